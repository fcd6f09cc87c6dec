//! A level and its rules, made on all cores: some hundred vertices at a time.

use core::ops::Range;

use selvedge_components::subdivision::{
    BorderStep, CornerTable, LevelMesh, LevelState, LimitRows, LoopSurface, Quartered, Step, border_sample,
};

use super::chain::Level;
use crate::parallel::{join, map_dear_in_order, map_in_order};

/// Vertices whose rules are made by one thread at a time.
const VERTICES: usize = 512;

/// What `of` makes of a range of vertices, part by part.
fn parts<R: Send>(range: Range<u32>, of: impl Fn(Range<u32>) -> R + Sync + Send) -> Vec<R> {
    map_dear_in_order(range.len().div_ceil(VERTICES), |i| {
        let begin = range.start + (i * VERTICES) as u32;
        of(begin..range.end.min(begin + VERTICES as u32))
    })
}

/// As [`LevelMesh::refine`].
pub fn refine(surface: &LoopSurface, coarse: &LevelMesh, faces: &[u32]) -> LevelMesh {
    settle(surface, coarse, quarter(coarse, faces))
}

/// As [`LevelMesh::quarter`].
pub fn quarter(coarse: &LevelMesh, faces: &[u32]) -> Quartered {
    coarse.quarter_with(faces, |a, b| {
        join(a, b);
    })
}

/// The level that has been quartered from `coarse`.
pub fn settle(surface: &LoopSurface, coarse: &LevelMesh, quartered: Quartered) -> LevelMesh {
    let at = |(side, step): BorderStep| border_sample(&surface.sides[side as usize], coarse.level + 1, step);
    quartered.settle(coarse, |steps| map_in_order(steps.len(), |i| at(steps[i])))
}

/// The rules that lead from `coarse` to `fine`, which is a refinement of it.
pub fn step(surface: &LoopSurface, corners: &CornerTable, coarse: &LevelMesh, fine: &LevelMesh) -> Step {
    let mut step = Step::default();
    extend_step(&mut step, surface, corners, [coarse, fine], 0..fine.vertices.len() as u32);
    step
}

/// The state of `fine`, a refinement of `coarse`, without the details that are stored for its level: what its
/// rules make, none of which are kept.
pub fn state(surface: &LoopSurface, corners: &CornerTable, coarse: &Level, fine: &LevelMesh) -> LevelState {
    let parts = parts(0..fine.vertices.len() as u32, |range| {
        let step = Step::of(surface, corners, &coarse.mesh, fine, range.clone());
        let effective = (0..step.rows.len()).map(|r| step.rows.dot(r, &coarse.state.effective)).collect();
        step.apply(range.start, corners, [&coarse.mesh, fine], &coarse.state, effective)
    });
    let mut all = LevelState {
        effective: Vec::with_capacity(fine.vertices.len()),
        details: Vec::with_capacity(fine.given.len()),
    };
    for part in parts {
        all.effective.extend(part.effective);
        all.details.extend(part.details);
    }
    all
}

/// Adds the rules of the vertices of `range`, which come after all that `step` has, from a coarse level to a
/// fine one.
pub fn extend_step(
    step: &mut Step,
    surface: &LoopSurface,
    corners: &CornerTable,
    [coarse, fine]: [&LevelMesh; 2],
    range: Range<u32>,
) {
    let parts = parts(range, |range| Step::of(surface, corners, coarse, fine, range));
    step.append(parts);
}

/// As [`LimitRows::new`].
pub fn limit_rows(
    surface: &LoopSurface,
    corners: &CornerTable,
    mesh: &LevelMesh,
    wanted: impl Fn(u32) -> bool + Sync + Send,
) -> LimitRows {
    let mut rows = LimitRows::default();
    let all = 0..mesh.vertices.len() as u32;
    let parts = parts(all, |range| LimitRows::of(surface, corners, mesh, range.filter(|&v| wanted(v))));
    rows.append(parts);
    rows
}
