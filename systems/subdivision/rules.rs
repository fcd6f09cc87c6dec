//! The rules of a level, made on all cores: a few thousand vertices at a time.

use core::ops::Range;

use selvedge_components::subdivision::{CornerTable, LevelMesh, LimitRows, LoopSurface, Step};

use crate::parallel::map_dear_in_order;

/// Vertices whose rules are made by one thread at a time.
const VERTICES: usize = 512;

/// The parts of `range`.
fn parts<R: Send>(range: Range<u32>, of: impl Fn(Range<u32>) -> R + Sync + Send) -> Vec<R> {
    let part = |i: usize| {
        let begin = range.start + (i * VERTICES) as u32;
        of(begin..range.end.min(begin + VERTICES as u32))
    };
    map_dear_in_order(range.len().div_ceil(VERTICES), part)
}

/// As [`Step::new`].
pub fn step(surface: &LoopSurface, corners: &CornerTable, coarse: &LevelMesh, fine: &LevelMesh) -> Step {
    let all = 0..fine.vertices.len() as u32;
    let mut step = Step::default();
    parts(all, |range| Step::of(surface, corners, coarse, fine, range)).into_iter().for_each(|part| step.append(part));
    step
}

/// As [`LimitRows::of`].
pub fn limit_rows(
    surface: &LoopSurface,
    corners: &CornerTable,
    mesh: &LevelMesh,
    range: Range<u32>,
    wanted: impl Fn(u32) -> bool + Sync + Send,
) -> LimitRows {
    let mut rows = LimitRows::default();
    parts(range, |range| LimitRows::of(surface, corners, mesh, range, &wanted))
        .into_iter()
        .for_each(|part| rows.append(part));
    rows
}
