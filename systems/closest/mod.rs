//! The point of a surface closest to a given one.
//!
//! A [`SurfaceIndex`] knows the surface as small, nearly flat cells in a tree, each with a bound on how
//! far the surface leaves it. The nearest cells give starts; from each, Newton's method follows the
//! surface itself, over edges and along borders, to rounding. Every cell that could hold a nearer
//! point by its bound is tried, so the answer is the closest point of all, whatever the start.

mod build;
mod cells;
mod line;
mod seek;
mod target;
mod walk;

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use thiserror::Error;

pub use build::IndexBuild;
pub use line::Hit;
pub use target::{Search, SurfaceTarget};
pub use walk::Walk;

use crate::spatial::Bvh;
use cells::{Cell, nearest_in_triangle};
use seek::{Reached, seek};
use walk::Spot;

/// A point of a surface and how far it is from where it was sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Where it lies.
    pub at: SurfacePoint,
    /// The point, in model units.
    pub position: DVec3,
    /// Its distance from the point asked for, in model units.
    pub distance: f64,
}

/// Why a surface cannot be searched.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IndexError {
    /// It has no faces.
    #[error("the surface has no faces")]
    Empty,
    /// It is NaN or infinite somewhere.
    #[error("the surface is not finite on face {}, at s = {}, t = {}", at.face, at.st.x, at.st.y)]
    NotFinite {
        /// Where.
        at: SurfacePoint,
    },
}

/// Why there is no closest point.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ClosestError {
    /// The point asked for is NaN or infinite.
    #[error("there is no point closest to {point}, which is not finite")]
    NotFinite {
        /// The point asked for.
        point: DVec3,
    },
    /// Two places are about as close.
    #[error(
        "two places are closest to {point}: {} at {} and {} at {}",
        places[0].position, places[0].distance, places[1].position, places[1].distance
    )]
    Ambiguous {
        /// The point asked for.
        point: DVec3,
        /// The closest place and the one farthest from it among those that are about as close.
        places: Box<[Closest; 2]>,
    },
}

/// A surface that can be searched for closest points.
#[derive(Clone, Debug)]
pub struct SurfaceIndex<S> {
    surface: Arc<S>,
    cells: Vec<Cell>,
    tree: Bvh,
    /// The step, in model units, that is no longer worth taking.
    fine: f64,
}

impl<S: Walk> SurfaceIndex<S> {
    /// Samples `surface` and sorts the samples.
    ///
    /// # Errors
    /// [`IndexError::Empty`], [`IndexError::NotFinite`].
    pub fn new(surface: Arc<S>) -> Result<Self, IndexError> {
        IndexBuild::new(surface).finish()
    }

    /// The surface that is searched.
    pub fn surface(&self) -> &Arc<S> {
        &self.surface
    }

    /// How many cells the surface is known by.
    pub fn cell_count(&self) -> usize {
        self.cells.len()
    }

    /// The point of the surface closest to `point`. Of several that are as close, which one follows
    /// from the surface and the point alone.
    ///
    /// # Errors
    /// [`ClosestError::NotFinite`].
    pub fn closest(&self, point: DVec3) -> Result<Closest, ClosestError> {
        self.check(point)?;
        let Some((nearest, _)) = self.tree.nearest(point, |c| nearest_in_triangle(point, &self.cell(c).points).1)
        else {
            return Err(ClosestError::NotFinite { point });
        };
        let start = self.seek_from_cell(point, nearest);
        Ok(self.closest_of_all(point, start).closest())
    }

    /// As [`Self::closest`], begun at `hint`: the same answer sooner, if the hint is near it.
    ///
    /// # Errors
    /// [`ClosestError::NotFinite`].
    pub fn closest_from(&self, point: DVec3, hint: SurfacePoint) -> Result<Closest, ClosestError> {
        self.check(point)?;
        if hint.face.index() >= self.surface.face_count() {
            return self.closest(point);
        }
        let start = seek(&*self.surface, point, Spot::new(hint), self.fine);
        Ok(self.closest_of_all(point, start).closest())
    }

    /// The point that is reached from `hint` by following the surface for as long as that leads nearer
    /// to `point`. It stays on the sheet that the hint lies on; another sheet may be nearer.
    ///
    /// # Errors
    /// [`ClosestError::NotFinite`].
    pub fn closest_around(&self, point: DVec3, hint: SurfacePoint) -> Result<Closest, ClosestError> {
        self.check(point)?;
        if hint.face.index() >= self.surface.face_count() {
            return self.closest(point);
        }
        Ok(seek(&*self.surface, point, Spot::new(hint), self.fine).closest())
    }

    /// The closest point, if no other place is within `(1 + ratio)` times its distance. Places count
    /// as others if the surface between them leads away from the point.
    ///
    /// # Errors
    /// [`ClosestError::NotFinite`], [`ClosestError::Ambiguous`].
    pub fn closest_alone(&self, point: DVec3, ratio: f64) -> Result<Closest, ClosestError> {
        let best = self.closest(point)?;
        let reach = best.distance * (1.0 + ratio.max(0.0)) + self.fine;
        let found = self.rest_within(point, reach * reach, best);
        let apart = |c: &Closest| c.position.distance_squared(best.position);
        match found.into_iter().reduce(|a, b| if apart(&b) > apart(&a) { b } else { a }) {
            Some(other) => Err(ClosestError::Ambiguous { point, places: Box::new([best, other]) }),
            None => Ok(best),
        }
    }

    /// All places within `reach` squared that the surface comes nearest at, but for `best`.
    fn rest_within(&self, point: DVec3, reach: f64, best: Closest) -> Vec<Closest> {
        let mut found: Vec<Closest> = Vec::new();
        self.tree.near(point, reach, |c, limit| {
            if self.lower_bound(point, c) <= limit {
                let reached = self.seek_from_cell(point, c);
                let place = reached.closest();
                // Two searches that end within a part of a cell have ended in the same place.
                let same = |other: &Closest| other.position.distance(place.position) <= 0.5 * self.cell(c).size();
                if reached.square <= limit && !same(&best) && !found.iter().any(same) {
                    found.push(place);
                }
            }
            limit
        });
        found
    }

    fn check(&self, point: DVec3) -> Result<(), ClosestError> {
        if point.is_finite() { Ok(()) } else { Err(ClosestError::NotFinite { point }) }
    }

    fn cell(&self, c: u32) -> &Cell {
        &self.cells[c as usize]
    }

    /// No point of the surface over cell `c` is nearer than this, squared.
    fn lower_bound(&self, point: DVec3, c: u32) -> f64 {
        let cell = self.cell(c);
        let lower = (nearest_in_triangle(point, &cell.points).1.sqrt() - cell.sag).max(0.0);
        lower * lower
    }

    fn seek_from_cell(&self, point: DVec3, c: u32) -> Reached {
        let cell = self.cell(c);
        let weights = nearest_in_triangle(point, &cell.points).0;
        seek(&*self.surface, point, Spot::new(cell.place(weights)), self.fine)
    }

    /// Tries every cell that may hold a nearer point than `start`.
    fn closest_of_all(&self, point: DVec3, start: Reached) -> Reached {
        let mut best = start;
        self.tree.near(point, start.square, |c, limit| {
            let cell = self.cell(c);
            let (weights, square) = nearest_in_triangle(point, &cell.points);
            let lower = (square.sqrt() - cell.sag).max(0.0);
            if lower * lower >= limit {
                return limit;
            }
            let spot = Spot::new(cell.place(weights));
            if self.leads_to(point, spot, cell, &best) {
                return limit;
            }
            let reached = seek(&*self.surface, point, spot, self.fine);
            if reached.square < best.square {
                best = reached;
            }
            best.square
        });
        best
    }

    /// Does one step from `spot` lead to where `best` is? A search from there would end there too.
    ///
    /// Only next to the best place's face, where the surface faces the same way: elsewhere another
    /// sheet may pass as near.
    fn leads_to(&self, point: DVec3, spot: Spot, cell: &Cell, best: &Reached) -> bool {
        let (here, there) = (spot.face, best.spot.face);
        let beside = |corner| self.surface.across(here, corner).is_some_and(|(face, _)| face == there);
        if here != there && !(0..3).any(beside) {
            return false;
        }
        let jet = self.surface.jet(spot.point());
        if jet.position.distance_squared(point) < best.square || jet.ds.cross(jet.dt).dot(best.facing) <= 0.0 {
            return false;
        }
        // The step is off by what the surface turns on the way: little within a cell.
        let aim = seek::aim(&jet, point);
        let step = aim.distance(jet.position);
        step <= 1.5 * cell.size() && aim.distance(best.position) <= 0.25 * step + self.fine
    }
}

impl Cell {
    fn is_finite(&self) -> bool {
        self.sag.is_finite() && self.points.iter().all(|p| p.is_finite())
    }
}

impl Reached {
    fn closest(&self) -> Closest {
        Closest { at: self.spot.point(), position: self.position, distance: self.square.sqrt() }
    }
}
