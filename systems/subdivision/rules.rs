//! A level and its rules, made on all cores: some hundred vertices at a time.

use core::ops::Range;

use selvedge_components::subdivision::{
    BorderStep, CornerTable, LevelMesh, LimitRows, LoopSurface, Quartered, Step, border_sample,
};

use crate::parallel::{map_dear_in_order, map_in_order};

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
    settle(surface, coarse, coarse.quarter(faces))
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
    parts.into_iter().for_each(|part| step.append(part));
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
    parts.into_iter().for_each(|part| rows.append(part));
    rows
}
