//! The forest that keeps a chord.
//!
//! Faces are quartered by what bounds and samples of them say ([`grow`](super::grow)). Then the finished
//! triangles, closures and all, are measured ([`check`](super::check)), and leaves that stand off too far
//! after all are quartered too.

use selvedge_components::subdivision::FaceCode;

use super::assemble::{Assembly, assemble};
use super::check::{Known, check, is_beyond};
use super::forest::Forest;
use super::grow::grow;
use super::sample::{Farthest, Place};
use super::{ChordReport, Subject, TriangulateError, TriangulateOptions, Triangulation, within_budget};

/// Triangulates to a chord.
///
/// # Errors
/// [`TriangulateError::LimitNotFinite`], [`TriangulateError::TooManyTriangles`].
pub fn adapt(subject: &Subject, chord: f64, options: &TriangulateOptions) -> Result<Triangulation, TriangulateError> {
    let mut forest = Forest::new(subject.surface.mesh.face_count());
    let mut new = forest.leaves();
    let mut known = Known::default();
    loop {
        grow(subject, &mut forest, new, chord, options, &mut known)?;
        let assembly = assemble(subject, &forest, options.normals)?;
        within_budget(assembly.triangle_count(), options)?;
        let found = check(subject, &assembly, chord, options.last_level, &mut known);
        let mut too_far = failing(&assembly, &found, chord);
        let stuck = too_far.get(options.last_level as usize).map_or(0, Vec::len);
        too_far.truncate(options.last_level as usize);
        if too_far.iter().all(Vec::is_empty) {
            return Ok(finish(assembly, &found, chord, stuck));
        }
        new = forest.split(&subject.surface.mesh, &too_far);
    }
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
