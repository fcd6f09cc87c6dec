//! Which faces are quartered before anything is measured.
//!
//! Where a face lies within one polynomial, the polynomial says how far it is from its triangle at most,
//! and whether it is quartered; elsewhere, beside given borders, irregular vertices and details, fifteen
//! points of it say so. A face that is quartered is gone through to the end at once. How the leaves stand off
//! is kept for the check.

use core::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::{Deviation, FaceCode, quartered};

use super::forest::Forest;
use super::inner::Inner;
use super::known::Known;
use super::measure::{Facet, Over};
use super::sample::{Farthest, Grid, Place, Sampled, borders, corners_of, farthest_of, is_beyond};
use super::{DEAR, Subject, TriangulateError, TriangulateOptions, within_budget};
use crate::parallel::map_dear_in_order;
use crate::subdivision::limit::{Nest, Spot};

/// A leaf that is sampled passes where fifteen points find it closer than this part of the chord.
///
/// Over a sphere the distance peaks in the middle of the triangle, and the nearest of the fifteen
/// points sees 15/16 of it; where the curvature differs by direction they see more. The tenth that is
/// left is for what is not quadratic.
pub const MARGIN: f64 = 0.85;

/// Leaves on their way to be quartered until all but those of the last level pass.
#[derive(Debug)]
pub struct GrowWork {
    /// The leaves not yet looked at, by root face.
    places: Vec<Place>,
    /// How many of them are gone through.
    seen: usize,
    /// How many leaves there are by now.
    leaves: usize,
    /// By level: the faces to be quartered.
    too_far: Vec<Vec<FaceCode>>,
}

impl GrowWork {
    /// Begins with the leaves of `forest` that are `new`, by level.
    pub fn new(forest: &Forest, mut new: Vec<Vec<FaceCode>>, options: &TriangulateOptions) -> Self {
        new.truncate(options.last_level as usize);
        let places = |(level, codes): (usize, Vec<FaceCode>)| {
            let level = level as u32;
            codes.into_iter().map(move |code| Place { level, code })
        };
        let mut places: Vec<Place> = new.into_iter().enumerate().flat_map(places).collect();
        places.sort_by_key(Place::root);
        let too_far = vec![Vec::new(); options.last_level as usize];
        Self { places, seen: 0, leaves: forest.leaf_count(), too_far }
    }

    /// Goes through some more leaves and what lies below them, and adds to `spent` what that costs. What
    /// leaves stand off by becomes `known`. `true` once all are gone through: then `forest` has grown.
    ///
    /// # Errors
    /// [`TriangulateError::LimitNotFinite`], [`TriangulateError::TooManyTriangles`].
    pub fn advance(
        &mut self,
        subject: &Subject,
        forest: &mut Forest,
        chord: f64,
        options: &TriangulateOptions,
        known: &mut Known,
        spent: &mut usize,
    ) -> Result<bool, TriangulateError> {
        within_budget(self.leaves, options)?;
        let leaves = self.leaves.into();
        let weights = Grid::Quarters.weights();
        let mut middles_first = weights.clone();
        middles_first.sort_by_key(|w| w.iter().filter(|&&x| x == 0.5).count() < 2);
        let growth = Growth { subject, chord, options, weights, middles_first, leaves };
        let left = &self.places[self.seen..];
        // What comes of a root face is not known before.
        let roots: Vec<&[Place]> = left.chunk_by(|a, b| a.root() == b.root()).take(ROOTS).collect();
        for (places, found) in roots.iter().zip(map_dear_in_order(roots.len(), |i| growth.too_far(roots[i]))) {
            let found = found?;
            self.seen += places.len();
            *spent += found.cost;
            found.too_far.iter().for_each(|place| self.too_far[place.level as usize].push(place.code));
            known.learn(places[0].root(), found.stand_off);
        }
        self.leaves = growth.leaves.into_inner();
        within_budget(self.leaves, options)?;
        if self.seen < self.places.len() {
            return Ok(false);
        }
        self.too_far.iter_mut().for_each(|codes| codes.sort_unstable());
        forest.split(&subject.surface.mesh, &self.too_far);
        within_budget(forest.leaf_count(), options)?;
        Ok(true)
    }
}

/// Root faces that are gone through between two looks at what has been spent.
const ROOTS: usize = 128;

/// What is found of one root face.
#[derive(Default)]
struct Found {
    /// What is to be quartered.
    too_far: Vec<Place>,
    /// How leaves stand off, where that is not plain to see.
    stand_off: Vec<(Place, Deviation)>,
    cost: usize,
}

/// What is found of one face.
struct Seen {
    /// Is it to be quartered?
    far: bool,
    /// If so, are its quarters likely to be, too?
    deeper: bool,
}

/// A face within one polynomial.
struct Within {
    place: Place,
    inner: Inner,
    corners: [DVec3; 3],
}

/// What does not change from face to face.
struct Growth<'a> {
    subject: &'a Subject,
    chord: f64,
    options: &'a TriangulateOptions,
    weights: Vec<[f64; 3]>,
    /// The same, the middles of edges first: most faces that stand off do so there.
    middles_first: Vec<[f64; 3]>,
    /// How many leaves there are by now.
    leaves: AtomicUsize,
}

impl Growth<'_> {
    /// Those of new leaves in one root face, and of what lies below them, that stand off too far.
    fn too_far(&self, places: &[Place]) -> Result<Found, TriangulateError> {
        let mut found = Found::default();
        let mut nest = Nest::new(&self.subject.limit, places.first().map_or(FaceId::new(0), Place::root));
        for &place in places {
            self.descend(&mut nest, place, true, &mut found)?;
        }
        Ok(found)
    }

    /// Goes into a face; `deep` if its quarters are likely to be gone into as well.
    fn descend(&self, nest: &mut Nest, place: Place, deep: bool, found: &mut Found) -> Result<(), TriangulateError> {
        if place.level == self.options.last_level {
            return Ok(());
        }
        let spot = nest.spot(place.level, place.code);
        if let Some(quartic) = nest.quartic(spot) {
            let (quartic, inner) = (*quartic, Inner::new(place, spot.level));
            let corners = inner.corners().map(|[s, t]| quartic.position(s, t));
            // In a root face that is one polynomial it is as soon found again as looked up.
            let is_kept = spot != nest.root();
            return self.descend_within(&quartic, nest, Within { place, inner, corners }, is_kept, found);
        }
        found.cost += 4 * DEAR;
        let Seen { far, deeper } = self.look_at(nest, spot, place, deep, &mut found.stand_off)?;
        if far && self.quarter(place, found) {
            for child in place.quarters() {
                self.descend(nest, child, deeper, found)?;
            }
        }
        Ok(())
    }

    /// Goes into a face within one polynomial; how leaves stand off is noted where it is to be kept.
    fn descend_within(
        &self,
        quartic: &Quartic,
        nest: &mut Nest,
        face: Within,
        is_kept: bool,
        found: &mut Found,
    ) -> Result<(), TriangulateError> {
        let Within { place, inner, corners } = face;
        if place.level == self.options.last_level {
            return Ok(());
        }
        found.cost += 1;
        let deviation = inner.deviation(quartic);
        let far = match judge(corners, &deviation, self.chord) {
            Verdict::Keeps => false,
            Verdict::TooFar => true,
            Verdict::Unsure => self.is_sampled_too_far(nest, place)?,
        };
        if far && self.quarter(place, found) {
            let quarters = inner.quarters();
            // The one in the middle has its corners in the middles of the edges.
            let middles = quarters[3].corners().map(|[s, t]| quartic.position(s, t));
            for ((place, inner), corners) in place.quarters().into_iter().zip(quarters).zip(quartered(corners, middles))
            {
                self.descend_within(quartic, nest, Within { place, inner, corners }, is_kept, found)?;
            }
        } else if !far && is_kept {
            found.stand_off.push((place, deviation));
        }
        Ok(())
    }

    /// Notes that a face is to be quartered, unless that passes the budget: nothing comes of it then, however
    /// many are counted.
    fn quarter(&self, place: Place, found: &mut Found) -> bool {
        let is_within = within_budget(self.leaves.fetch_add(3, Ordering::Relaxed), self.options).is_ok();
        found.too_far.extend(is_within.then_some(place));
        is_within
    }

    /// Looks at a face that is no polynomial. How it stands off goes to `stand_off`, if it is not to be
    /// quartered.
    fn look_at(
        &self,
        nest: &mut Nest,
        spot: Spot,
        place: Place,
        deep: bool,
        stand_off: &mut Vec<(Place, Deviation)>,
    ) -> Result<Seen, TriangulateError> {
        if self.subject.reach.moves_below(place.level, place.code) {
            // Fifteen points say nothing about details between them.
            return Ok(Seen { far: self.is_sampled_too_far(nest, place)?, deeper: true });
        }
        let points = nest.quarter_points(spot, deep);
        let (facet, borders) = (Facet::new(corners_of(&points)), borders(self.subject, place));
        let found = farthest_of(&points, borders, &self.weights, |x| alone(x, &facet, borders));
        let far = self.is_too_far(place, &found)?;
        // Distances fall to a quarter from level to level.
        let deeper = is_beyond(&found, 4.0 * MARGIN * self.chord);
        if !far {
            stand_off.push((place, Deviation::of_points(&points)));
        }
        Ok(Seen { far, deeper })
    }

    fn is_sampled_too_far(&self, nest: &mut Nest, place: Place) -> Result<bool, TriangulateError> {
        let mut sampled = Sampled::new(self.subject, nest, place);
        let (triangle, borders) = (Facet::new(sampled.corners()), sampled.borders());
        let limit = MARGIN * self.chord;
        let found = sampled.farthest(&self.middles_first, limit, |x| alone(x, &triangle, borders));
        self.is_too_far(place, &found)
    }

    fn is_too_far(&self, place: Place, found: &Farthest) -> Result<bool, TriangulateError> {
        if !found.at.is_finite() {
            return Err(TriangulateError::LimitNotFinite { face: place.root(), at: found.at });
        }
        Ok(is_beyond(found, MARGIN * self.chord))
    }
}

/// What the bounds of a face say about the chord.
enum Verdict {
    Keeps,
    TooFar,
    /// Nothing: samples must.
    Unsure,
}

/// A face keeps the chord where heights over its triangle do: what slides beyond is over a neighbour. Without
/// a plane to be high over, distances from the points of the triangle with the same weights decide.
fn judge([a, b, c]: [DVec3; 3], deviation: &Deviation, chord: f64) -> Verdict {
    let normal = (b - a).cross(c - a).normalize_or_zero();
    if normal == DVec3::ZERO {
        if deviation.greatest() <= chord { Verdict::Keeps } else { Verdict::Unsure }
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
