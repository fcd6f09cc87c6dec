//! The forest that keeps a chord.
//!
//! Leaves are quartered where fifteen points of their patch say so, until none does; then the
//! finished triangles, closures and all, are measured at other points, and leaves that stand off too
//! far after all are quartered too.

use selvedge_components::subdivision::FaceCode;

use super::assemble::{Assembly, assemble};
use super::forest::Forest;
use super::pyramid::Pyramid;
use super::sample::{Cover, Farthest, Lattice, farthest};
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
        let found = farthest(subject, &assembly.pyramid, Lattice::Ninths, |l, place| assembly.cover(l, place))?;
        let too_far = failing(&assembly.pyramid, &found, chord);
        let stuck = too_far.get(options.last_level as usize).map_or(0, Vec::len);
        let open: Vec<_> = too_far.into_iter().take(options.last_level as usize).collect();
        if open.iter().all(Vec::is_empty) {
            return finish(assembly, &found, chord, stuck, options);
        }
        new = forest.split(&subject.surface.mesh, &open);
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
        let leaf = |l: usize, place: usize| Cover::new().with(pyramid.corners(l, pyramid.floors[l].faces[place]));
        let found = farthest(subject, &pyramid, Lattice::Quarters, leaf)?;
        new = forest.split(&subject.surface.mesh, &failing(&pyramid, &found, MARGIN * chord));
    }
    Ok(())
}

/// By level: the faces whose farthest point is farther off than `limit`.
fn failing(pyramid: &Pyramid, found: &[Vec<Farthest>], limit: f64) -> Vec<Vec<FaceCode>> {
    let far = |f: &Farthest| f.squared.is_nan() || f.squared > limit * limit;
    let of_level = |(floor, found): (&super::pyramid::Floor, &Vec<Farthest>)| {
        let codes = floor.faces.iter().map(|&f| floor.level.mesh.codes[f as usize]);
        codes.zip(found).filter(|(_, f)| far(f)).map(|(code, _)| code).collect()
    };
    pyramid.floors.iter().zip(found).map(of_level).collect()
}

fn finish(
    assembly: Assembly,
    found: &[Vec<Farthest>],
    chord: f64,
    failing: usize,
    options: &TriangulateOptions,
) -> Result<Triangulation, TriangulateError> {
    within_budget(assembly.triangle_count(), options)?;
    let farthest = found.iter().flatten().fold(Farthest::default(), |all, &leaf| all.or(leaf));
    let mut done = assembly.finish();
    done.report.chord = Some(ChordReport {
        asked: chord,
        achieved: farthest.squared.sqrt(),
        at: farthest.at,
        samples: farthest.samples,
        failing,
    });
    Ok(done)
}
