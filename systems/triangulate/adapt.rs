//! The forest that keeps a chord.
//!
//! Leaves are quartered where fifteen points of their patch say so, until none does; then the
//! finished triangles, closures and all, are measured at other points, and leaves that stand off too
//! far after all are quartered too.

use glam::DVec3;
use selvedge_components::subdivision::FaceCode;

use super::assemble::{Assembly, assemble};
use super::forest::Forest;
use super::measure::{Over, squared_to_triangle};
use super::pyramid::{Floor, Pyramid};
use super::sample::{Farthest, Grid, farthest, farthest_back};
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
        let found = check(subject, &assembly, chord);
        let mut too_far = failing(&assembly.pyramid, &found, chord);
        let stuck = too_far.get(options.last_level as usize).map_or(0, Vec::len);
        too_far.truncate(options.last_level as usize);
        if too_far.iter().all(Vec::is_empty) {
            return Ok(finish(assembly, &found, chord, stuck));
        }
        new = forest.split(&subject.surface.mesh, &too_far);
    }
}

/// Measures the finished triangles both ways: from the surface to them, and from them to the surface.
fn check(subject: &Subject, assembly: &Assembly, chord: f64) -> Vec<Vec<Farthest>> {
    let around = assembly.around();
    let pyramid = &assembly.pyramid;
    let mut found = farthest(subject, pyramid, Grid::Ninths, |l, place| assembly.near(&around, l, place));
    // The way back matters where it is farther than the farthest so far, or too far.
    let most = found.iter().flatten().map(|f| f.squared).fold(0.0, f64::max).sqrt().min(chord);
    let back = farthest_back(subject, pyramid, most, |l, place| assembly.pieces(l, place));
    for (there, back) in found.iter_mut().flatten().zip(back.into_iter().flatten()) {
        *there = there.or(back);
    }
    found
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
        let found = farthest(subject, &pyramid, Grid::Quarters, |l, place| {
            let face = pyramid.floors[l].faces[place];
            let (corners, borders) = (pyramid.corners(l, face), pyramid.floors[l].borders(face));
            move |x| alone(x, corners, borders)
        });
        new = forest.split(&subject.surface.mesh, &failing(&pyramid, &found, MARGIN * chord));
    }
    Ok(())
}

/// How far a foot may slide beyond an edge, as a share of the triangle. At a vertex of valence `k`
/// the middle of an edge comes to stand at `lambda` of its length rather than at half: 1/4 at valence
/// 3, 5/8 at the highest, so the slide is a quarter at most, and a third leaves room for bending.
const SLIDE: f64 = 1.0 / 3.0;

/// The squared distance of a point of the limit surface to a triangle of which the neighbours are not
/// known yet. A point that has slid over an edge inside the surface is over a neighbour, and how far it
/// slid is not how far it is off: its height counts, over this triangle's plane for want of the
/// other's. Over a border there is no neighbour.
fn alone(x: DVec3, corners: [DVec3; 3], borders: [bool; 3]) -> f64 {
    let close =
        |over: &Over| (0..3).all(|edge| over.weights[(edge + 2) % 3] >= if borders[edge] { 0.0 } else { -SLIDE });
    match Over::new(x, corners).filter(close) {
        Some(over) => over.squared,
        None => squared_to_triangle(x, corners),
    }
}

/// By level: the faces whose farthest point is farther off than `limit`.
fn failing(pyramid: &Pyramid, found: &[Vec<Farthest>], limit: f64) -> Vec<Vec<FaceCode>> {
    let far = |f: &Farthest| f.squared.is_nan() || f.squared > limit * limit;
    let of_level = |(floor, found): (&Floor, &Vec<Farthest>)| {
        let codes = floor.faces.iter().map(|&f| floor.level.mesh.codes[f as usize]);
        codes.zip(found).filter(|(_, f)| far(f)).map(|(code, _)| code).collect()
    };
    pyramid.floors.iter().zip(found).map(of_level).collect()
}

fn finish(assembly: Assembly, found: &[Vec<Farthest>], chord: f64, failing: usize) -> Triangulation {
    let farthest = found.iter().flatten().fold(Farthest::default(), |all, &leaf| all.or(leaf));
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
