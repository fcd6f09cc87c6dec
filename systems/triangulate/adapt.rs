//! The forest that keeps a chord.
//!
//! Where a face lies within one polynomial, the polynomial says how far it is from its triangle at most,
//! and whether it is quartered; elsewhere, beside given borders, irregular vertices and details, fifteen
//! points of it say so. Then the finished triangles, closures and all, are measured at other points where
//! no bound tells enough, and leaves that stand off too far after all are quartered too.

use core::sync::atomic::{AtomicUsize, Ordering};

use glam::DVec3;
use selvedge_components::subdivision::FaceCode;
use selvedge_components::subdivision::boxspline::Quartic;

use super::assemble::{Assembly, Leaf, assemble};
use super::forest::Forest;
use super::inner::Inner;
use super::measure::{Facet, Over};
use super::sample::{Farthest, Grid, Piece, Place, Sampled};
use super::{ChordReport, Subject, TriangulateError, TriangulateOptions, Triangulation, within_budget};
use crate::parallel::map_in_order;
use crate::subdivision::limit::Cover;

/// A leaf that is sampled passes where fifteen points find it closer than this part of the chord.
///
/// Over a sphere the distance peaks in the middle of the triangle, and the nearest of the fifteen
/// points sees 15/16 of it; where the curvature differs by direction they see more. The tenth that is
/// left is for what is not quadratic.
pub const MARGIN: f64 = 0.85;

/// Triangulates to a chord.
///
/// # Errors
/// [`TriangulateError::LimitNotFinite`], [`TriangulateError::TooManyTriangles`].
pub fn adapt(subject: &Subject, chord: f64, options: &TriangulateOptions) -> Result<Triangulation, TriangulateError> {
    let mut forest = Forest::new(subject.surface.mesh.face_count());
    let mut new = forest.leaves();
    loop {
        grow(subject, &mut forest, new, chord, options)?;
        let assembly = assemble(subject, &forest, options.normals)?;
        within_budget(assembly.triangle_count(), options)?;
        let found = check(subject, &assembly, chord, options.last_level);
        let mut too_far = failing(&assembly, &found, chord);
        let stuck = too_far.get(options.last_level as usize).map_or(0, Vec::len);
        too_far.truncate(options.last_level as usize);
        if too_far.iter().all(Vec::is_empty) {
            return Ok(finish(assembly, &found, chord, stuck));
        }
        new = forest.split(&subject.surface.mesh, &too_far);
    }
}

/// Quarters leaves until all but those of the last level pass; `new` are the ones not yet looked at.
fn grow(
    subject: &Subject,
    forest: &mut Forest,
    mut new: Vec<Vec<FaceCode>>,
    chord: f64,
    options: &TriangulateOptions,
) -> Result<(), TriangulateError> {
    loop {
        within_budget(forest.leaf_count(), options)?;
        new.truncate(options.last_level as usize);
        let places = |(level, codes): (usize, &Vec<FaceCode>)| {
            let level = level as u32;
            codes.iter().map(|&code| Place { level, code }).collect::<Vec<_>>()
        };
        let new_places: Vec<Place> = new.iter().enumerate().flat_map(places).collect();
        if new_places.is_empty() {
            return Ok(());
        }
        let growth = Growth { subject, chord, options, leaves: AtomicUsize::new(forest.leaf_count()) };
        let mut failing = vec![Vec::new(); options.last_level as usize];
        for found in map_in_order(new_places.len(), |i| growth.too_far(new_places[i])) {
            found?.into_iter().for_each(|place| failing[place.level as usize].push(place.code));
        }
        within_budget(growth.leaves.into_inner(), options)?;
        failing.iter_mut().for_each(|codes| codes.sort_unstable());
        new = forest.split(&subject.surface.mesh, &failing);
        // What lies within one polynomial was gone through to the end, from its parent or from above.
        for (level, codes) in new.iter_mut().enumerate().skip(1) {
            codes.retain(|code| subject.limit.quartic(level as u32 - 1, code.parent()).is_none());
        }
    }
}

/// One round of growing.
struct Growth<'a> {
    subject: &'a Subject<'a>,
    chord: f64,
    options: &'a TriangulateOptions,
    /// How many leaves there are by now.
    leaves: AtomicUsize,
}

impl Growth<'_> {
    /// Those of a new leaf and what lies below it that stand off too far: where it lies within one
    /// polynomial all of them, elsewhere the leaf alone.
    fn too_far(&self, place: Place) -> Result<Vec<Place>, TriangulateError> {
        let mut too_far = Vec::new();
        if let Cover::Quartic(base, quartic) = self.subject.limit.cover(place.level, place.code) {
            self.descend(&quartic, base, place, &mut too_far)?;
        } else if self.is_sampled_too_far(place)? {
            too_far.push(place);
        }
        Ok(too_far)
    }

    fn descend(
        &self,
        quartic: &Quartic,
        base: u32,
        place: Place,
        too_far: &mut Vec<Place>,
    ) -> Result<(), TriangulateError> {
        if place.level == self.options.last_level {
            return Ok(());
        }
        let far = match judge(quartic, Inner::new(place, base), self.chord) {
            Verdict::Keeps => false,
            Verdict::TooFar => true,
            Verdict::Unsure => self.is_sampled_too_far(place)?,
        };
        // Past the budget nothing comes of it: however many are counted by then, too many is too many.
        if far && within_budget(self.leaves.fetch_add(3, Ordering::Relaxed), self.options).is_ok() {
            too_far.push(place);
            for child in 0..4 {
                let child = Place { level: place.level + 1, code: place.code.child(child) };
                self.descend(quartic, base, child, too_far)?;
            }
        }
        Ok(())
    }

    fn is_sampled_too_far(&self, place: Place) -> Result<bool, TriangulateError> {
        let sampled = Sampled::new(self.subject, place);
        let (triangle, borders) = (Facet::new(sampled.corners()), sampled.borders());
        let found = sampled.farthest(&Grid::Quarters.weights(), |x| alone(x, &triangle, borders));
        if !found.at.is_finite() {
            let face = place.code.root_face(place.level);
            return Err(TriangulateError::LimitNotFinite { face, at: found.at });
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

/// How many leaves are measured at a time: few at first, since the farthest tells how many more must be,
/// and then enough for every core.
const AT_A_TIME: [usize; 2] = [64, 1024];

/// Measures the finished triangles both ways: from the surface to them, and from them to the surface.
///
/// The leaves are gone through from the greatest bound down, until what is left can neither be too far
/// nor be the farthest. Of those that no polynomial bounds the distance to their own triangles decides;
/// where it is the greatest so far, or too far, that to all triangles around.
///
/// Leaves that a polynomial leaves in doubt come first, since they are cheap: if one of them is to be
/// quartered the rest waits for the next forest.
fn check(subject: &Subject, assembly: &Assembly, chord: f64, last_level: u32) -> Vec<Farthest> {
    let leaves = &assembly.leaves;
    let bounds = map_in_order(leaves.len(), |i| bound(subject, assembly, &leaves[i]));
    let mut order: Vec<usize> = (0..leaves.len()).collect();
    let turn = |bound: f64| if bound <= chord { 2 } else { u8::from(bound == f64::INFINITY) };
    order.sort_by(|&a, &b| turn(bounds[a]).cmp(&turn(bounds[b])).then(bounds[b].total_cmp(&bounds[a])));
    let (around, weights) = (assembly.around(), Grid::Ninths.weights());
    let mut found = vec![Farthest::default(); leaves.len()];
    let (mut most, mut again) = (0.0_f64, false);
    let (first, rest) = order.split_at(order.len().min(AT_A_TIME[0]));
    for some in core::iter::once(first).chain(rest.chunks(AT_A_TIME[1])) {
        let enough = most.min(chord);
        if bounds[some[0]] <= enough || (again && bounds[some[0]] == f64::INFINITY) {
            break;
        }
        let measured = map_in_order(some.len(), |i| {
            let leaf = &leaves[some[i]];
            let sampled = Sampled::new(subject, leaf.place);
            let mut there = sampled.farthest(&weights, assembly.own(leaf));
            if is_beyond(&there, enough) {
                there = sampled.farthest(&weights, assembly.near(&around, leaf));
            }
            there.or(sampled.farthest_back(&assembly.pieces(leaf), enough))
        });
        for (&i, measured) in some.iter().zip(measured) {
            most = most.max(measured.squared.sqrt());
            again |= is_beyond(&measured, chord) && leaves[i].place.level < last_level;
            found[i] = measured;
        }
    }
    found
}

/// No point of a leaf is farther from its triangles than this, or the other way round; infinite where no
/// polynomial tells.
fn bound(subject: &Subject, assembly: &Assembly, leaf: &Leaf) -> f64 {
    let Cover::Quartic(base, quartic) = subject.limit.cover(leaf.place.level, leaf.place.code) else {
        return f64::INFINITY;
    };
    let (deviation, first) = Inner::new(leaf.place, base).deviation(&quartic);
    if !leaf.is_cut() {
        return deviation.greatest();
    }
    let turned = |w: [f64; 3]| core::array::from_fn(|c| w[(first + c) % 3]);
    let of_piece = |piece: &Piece| deviation.greatest_of_piece(piece.map(|(_, w)| turned(w)));
    assembly.pieces(leaf).iter().map(of_piece).fold(0.0, f64::max)
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

fn is_beyond(found: &Farthest, limit: f64) -> bool {
    found.squared.is_nan() || found.squared > limit * limit
}

/// By level, ascending: the codes of those leaves whose farthest point is farther off than `limit`.
fn failing(assembly: &Assembly, found: &[Farthest], limit: f64) -> Vec<Vec<FaceCode>> {
    let mut failing: Vec<Vec<FaceCode>> = Vec::new();
    for (Place { level, code }, _) in
        assembly.leaves.iter().map(|leaf| leaf.place).zip(found).filter(|(_, found)| is_beyond(found, limit))
    {
        failing.resize(failing.len().max(level as usize + 1), Vec::new());
        failing[level as usize].push(code);
    }
    failing
}

fn finish(assembly: Assembly, found: &[Farthest], chord: f64, failing: usize) -> Triangulation {
    let farthest = found.iter().fold(Farthest::default(), |all, &leaf| all.or(leaf));
    let mut done = assembly.finish();
    done.report.chord = Some(ChordReport {
        asked: chord,
        achieved: farthest.squared.sqrt(),
        at: farthest.at,
        samples: farthest.samples,
        failing,
    });
    done
}
