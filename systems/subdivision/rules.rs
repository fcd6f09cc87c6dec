//! The rules of a level, made on all cores: some hundred vertices at a time.

use core::ops::Range;

use selvedge_components::subdivision::{CornerTable, LevelMesh, LimitRows, LoopSurface, Step};

use crate::parallel::map_dear_in_order;

/// Vertices whose rules are made by one thread at a time.
const VERTICES: usize = 512;

/// What `of` makes of the vertices of `mesh`, part by part.
fn parts<R: Send>(mesh: &LevelMesh, of: impl Fn(Range<u32>) -> R + Sync + Send) -> Vec<R> {
    let count = mesh.vertices.len();
    map_dear_in_order(count.div_ceil(VERTICES), |i| {
        let begin = i * VERTICES;
        of(begin as u32..count.min(begin + VERTICES) as u32)
    })
}

/// As [`Step::new`].
pub fn step(surface: &LoopSurface, corners: &CornerTable, coarse: &LevelMesh, fine: &LevelMesh) -> Step {
    let mut step = Step::default();
    let parts = parts(fine, |range| Step::of(surface, corners, coarse, fine, range));
    parts.into_iter().for_each(|part| step.append(part));
    step
}

/// As [`LimitRows::new`].
pub fn limit_rows(
    surface: &LoopSurface,
    corners: &CornerTable,
    mesh: &LevelMesh,
    wanted: impl Fn(u32) -> bool + Sync + Send,
) -> LimitRows {
    let mut rows = LimitRows::default();
    let parts = parts(mesh, |range| LimitRows::of(surface, corners, mesh, range.filter(|&v| wanted(v))));
    parts.into_iter().for_each(|part| rows.append(part));
    rows
}
