//! The forest that keeps a chord.
//!
//! Leaves are quartered where fifteen points of their patch say so, until none does; then the
//! finished triangles, closures and all, are measured at other points, and leaves that stand off too
//! far after all are quartered too.

use glam::DVec3;
use selvedge_components::subdivision::FaceCode;

use super::assemble::{Assembly, assemble};
use super::forest::Forest;
use super::measure::{Facet, Over};
use super::pyramid::Pyramid;
use super::sample::{Farthest, Grid, LeafPlace, farthest, farthest_back, leaves};
use super::{ChordReport, Subject, TriangulateError, TriangulateOptions, Triangulation, within_budget};

/// A leaf passes where fifteen points find it closer than this part of the chord.
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
        let leaves = leaves(&assembly.pyramid);
        let found = check(subject, &assembly, &leaves, chord);
        let mut too_far = failing(&assembly.pyramid, &leaves, &found, chord);
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
    while new.iter().any(|level| !level.is_empty()) {
        within_budget(forest.leaf_count(), options)?;
        new.truncate(options.last_level as usize);
        let pyramid = Pyramid::new(subject, &new)?;
        let leaves = leaves(&pyramid);
        let found = farthest(subject, &pyramid, &leaves, Grid::Quarters, |(l, place)| {
            let face = pyramid.floors[l].faces[place];
            let (triangle, borders) = (Facet::new(pyramid.corners(l, face)), pyramid.floors[l].borders(face));
            move |x| alone(x, &triangle, borders)
        });
        new = forest.split(&subject.surface.mesh, &failing(&pyramid, &leaves, &found, MARGIN * chord));
    }
    Ok(())
}

/// How many leaves are measured to all triangles around at a time: enough for every core.
const AT_A_TIME: usize = 1024;

/// Measures the finished triangles both ways: from the surface to them, and from them to the surface.
///
/// The distance to a leaf's own triangles is one from above. The leaves are gone through from the
/// greatest down, and measured to all triangles around, until what is left can neither be too far nor
/// be the farthest.
fn check(subject: &Subject, assembly: &Assembly, leaves: &[LeafPlace], chord: f64) -> Vec<Farthest> {
    let pyramid = &assembly.pyramid;
    let mut found = farthest(subject, pyramid, leaves, Grid::Ninths, |leaf| assembly.own(leaf));
    let mut order: Vec<usize> = (0..leaves.len()).collect();
    order.sort_by(|&a, &b| found[b].squared.total_cmp(&found[a].squared));
    let around = assembly.around();
    let mut most = 0.0_f64;
    for some in order.chunks(AT_A_TIME) {
        if found[some[0]].squared <= most.min(chord * chord) {
            break;
        }
        let some_leaves: Vec<LeafPlace> = some.iter().map(|&i| leaves[i]).collect();
        let exact = farthest(subject, pyramid, &some_leaves, Grid::Ninths, |leaf| assembly.near(&around, leaf));
        for (&i, exact) in some.iter().zip(exact) {
            most = most.max(exact.squared);
            found[i] = exact;
        }
    }
    let back = farthest_back(subject, pyramid, leaves, most.sqrt().min(chord), |leaf| assembly.pieces(leaf));
    found.into_iter().zip(back).map(|(there, back)| there.or(back)).collect()
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

/// By level, ascending: the codes of those of `leaves` whose farthest point is farther off than `limit`.
fn failing(pyramid: &Pyramid, leaves: &[LeafPlace], found: &[Farthest], limit: f64) -> Vec<Vec<FaceCode>> {
    let mut failing = vec![Vec::new(); pyramid.floors.len()];
    for (&(l, place), found) in leaves.iter().zip(found) {
        if found.squared.is_nan() || found.squared > limit * limit {
            let floor = &pyramid.floors[l];
            failing[l].push(floor.level.mesh.codes[floor.faces[place] as usize]);
        }
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
