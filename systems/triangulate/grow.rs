//! Which faces are quartered before anything is measured.
//!
//! Where a face lies within one polynomial, the polynomial says how far it is from its triangle at most,
//! and whether it is quartered; elsewhere, beside given borders, irregular vertices and details, fifteen
//! points of it say so. A face that is quartered is gone through to the end at once.

use core::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::FaceCode;
use selvedge_components::subdivision::boxspline::Quartic;

use super::check::is_beyond;
use super::forest::Forest;
use super::inner::Inner;
use super::measure::{Facet, Over};
use super::sample::{Grid, Place, Sampled};
use super::{Subject, TriangulateError, TriangulateOptions, within_budget};
use crate::parallel::map_dear_in_order;
use crate::subdivision::limit::Nest;

/// A leaf that is sampled passes where fifteen points find it closer than this part of the chord.
///
/// Over a sphere the distance peaks in the middle of the triangle, and the nearest of the fifteen
/// points sees 15/16 of it; where the curvature differs by direction they see more. The tenth that is
/// left is for what is not quadratic.
pub const MARGIN: f64 = 0.85;

/// Quarters leaves until all but those of the last level pass; `new` are the ones not yet looked at, by
/// level.
///
/// # Errors
/// [`TriangulateError::LimitNotFinite`], [`TriangulateError::TooManyTriangles`].
pub fn grow(
    subject: &Subject,
    forest: &mut Forest,
    mut new: Vec<Vec<FaceCode>>,
    chord: f64,
    options: &TriangulateOptions,
) -> Result<(), TriangulateError> {
    within_budget(forest.leaf_count(), options)?;
    new.truncate(options.last_level as usize);
    let places = |(level, codes): (usize, Vec<FaceCode>)| {
        let level = level as u32;
        codes.into_iter().map(move |code| Place { level, code })
    };
    let mut places: Vec<Place> = new.into_iter().enumerate().flat_map(places).collect();
    places.sort_by_key(Place::root);
    let roots: Vec<&[Place]> = places.chunk_by(|a, b| a.root() == b.root()).collect();
    let growth =
        Growth { subject, chord, options, weights: Grid::Quarters.weights(), leaves: forest.leaf_count().into() };
    let mut failing = vec![Vec::new(); options.last_level as usize];
    for found in map_dear_in_order(roots.len(), |i| growth.too_far(roots[i])) {
        found?.into_iter().for_each(|place| failing[place.level as usize].push(place.code));
    }
    within_budget(growth.leaves.into_inner(), options)?;
    failing.iter_mut().for_each(|codes| codes.sort_unstable());
    forest.split(&subject.surface.mesh, &failing);
    within_budget(forest.leaf_count(), options)
}

/// What does not change from face to face.
struct Growth<'a> {
    subject: &'a Subject,
    chord: f64,
    options: &'a TriangulateOptions,
    weights: Vec<[f64; 3]>,
    /// How many leaves there are by now.
    leaves: AtomicUsize,
}

impl Growth<'_> {
    /// Those of new leaves in one root face, and of what lies below them, that stand off too far.
    fn too_far(&self, places: &[Place]) -> Result<Vec<Place>, TriangulateError> {
        let mut too_far = Vec::new();
        let mut nest = Nest::new(&self.subject.limit, places.first().map_or(FaceId::new(0), Place::root));
        for &place in places {
            self.descend(&mut nest, place, &mut too_far)?;
        }
        Ok(too_far)
    }

    fn descend(&self, nest: &mut Nest, place: Place, too_far: &mut Vec<Place>) -> Result<(), TriangulateError> {
        if place.level == self.options.last_level {
            return Ok(());
        }
        let spot = nest.spot(place.level, place.code);
        let verdict = nest.quartic(spot).map(|quartic| judge(quartic, Inner::new(place, spot.level), self.chord));
        let far = match verdict {
            Some(Verdict::Keeps) => false,
            Some(Verdict::TooFar) => true,
            Some(Verdict::Unsure) | None => self.is_sampled_too_far(nest, place)?,
        };
        // Past the budget nothing comes of it: however many are counted by then, too many is too many.
        if far && within_budget(self.leaves.fetch_add(3, Ordering::Relaxed), self.options).is_ok() {
            too_far.push(place);
            for child in 0..4 {
                let child = Place { level: place.level + 1, code: place.code.child(child) };
                self.descend(nest, child, too_far)?;
            }
        }
        Ok(())
    }

    fn is_sampled_too_far(&self, nest: &mut Nest, place: Place) -> Result<bool, TriangulateError> {
        let mut sampled = Sampled::new(self.subject, nest, place);
        let (triangle, borders) = (Facet::new(sampled.corners()), sampled.borders());
        let found = sampled.farthest(&self.weights, |x| alone(x, &triangle, borders));
        if !found.at.is_finite() {
            return Err(TriangulateError::LimitNotFinite { face: place.root(), at: found.at });
        }
        Ok(is_beyond(&found, MARGIN * self.chord))
    }
}

/// What the bounds of a face say about the chord.
enum Verdict {
    Keeps,
    TooFar,
    /// Nothing: samples must.
    Unsure,
}

/// A face keeps the chord where no point is farther from the point of its triangle with the same
/// weights. Nor is it too far if heights over the triangle keep it: what slides beyond is over a
/// neighbour.
fn judge(quartic: &Quartic, inner: Inner, chord: f64) -> Verdict {
    let (deviation, _) = inner.deviation(quartic);
    if deviation.greatest() <= chord {
        return Verdict::Keeps;
    }
    let [a, b, c] = inner.corners().map(|[s, t]| quartic.position(s, t));
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal == DVec3::ZERO {
        Verdict::Unsure
    } else if deviation.along(normal) <= chord {
        Verdict::Keeps
    } else if deviation.in_the_middle(normal) > MARGIN * chord {
        // The middles of the edges are among the samples.
        Verdict::TooFar
    } else {
        Verdict::Unsure
    }
}

/// How far a foot may slide beyond an edge, as a share of the triangle. At a vertex of valence `k`
/// the middle of an edge comes to stand at `lambda` of its length rather than at half: 1/4 at valence
/// 3, 5/8 at the highest, so the slide is a quarter at most, and a third leaves room for bending.
const SLIDE: f64 = 1.0 / 3.0;

/// The squared distance of a point of the limit surface to a triangle of which the neighbours are not
/// known yet. A point that has slid over an edge inside the surface is over a neighbour, and how far it
/// slid is not how far it is off: its height counts, over this triangle's plane for want of the
/// other's. Over a border there is no neighbour.
fn alone(x: DVec3, triangle: &Facet, borders: [bool; 3]) -> f64 {
    let close =
        |over: &Over| (0..3).all(|edge| over.weights[(edge + 2) % 3] >= if borders[edge] { 0.0 } else { -SLIDE });
    triangle.under(x).filter(close).map_or_else(|| triangle.squared(x), |over| over.squared)
}
