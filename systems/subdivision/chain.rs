//! The levels of a surface down to a set of faces of one of them.

use glam::DVec3;
use selvedge_components::subdivision::{
    CornerTable, Details, FaceCode, Kind, LevelMesh, LevelState, LoopSurface, Step,
};

use super::{region, rules};
use crate::parallel::map_in_order;

/// One level: its mesh and its state, details of that level included.
#[derive(Clone, Debug, Default)]
pub struct Level {
    /// The faces and vertices.
    pub mesh: LevelMesh,
    /// Effective control points and boundary details.
    pub state: LevelState,
}

/// Level 0 of `surface`, with its details.
pub fn root(surface: &LoopSurface, corners: &CornerTable, details: &Details) -> Level {
    let mesh = LevelMesh::root(surface, corners);
    let mut state = LevelState { effective: surface.points.clone(), details: vec![DVec3::ZERO; mesh.given.len()] };
    for (g, given) in mesh.given.iter().enumerate() {
        state.effective[given.vertex as usize] = given.sample - state.details[g];
    }
    add_details(surface, details, &mesh, &mut state);
    Level { mesh, state }
}

/// Refines `coarse` over `faces` (local, ascending, refinable) and adds the details of the new level.
pub fn refine(
    surface: &LoopSurface,
    corners: &CornerTable,
    details: &Details,
    coarse: &Level,
    faces: &[u32],
) -> (Level, Step) {
    let mesh = rules::refine(surface, &coarse.mesh, faces);
    let step = rules::step(surface, corners, &coarse.mesh, &mesh);
    let state = advance(surface, corners, details, &step, coarse, &mesh);
    (Level { mesh, state }, step)
}

/// The state of the finer level `mesh`, to which `step` leads from `coarse`.
pub fn advance(
    surface: &LoopSurface,
    corners: &CornerTable,
    details: &Details,
    step: &Step,
    coarse: &Level,
    mesh: &LevelMesh,
) -> LevelState {
    let effective = map_in_order(step.rows.len(), |r| step.rows.dot(r, &coarse.state.effective));
    let mut state = step.apply(0, corners, [&coarse.mesh, mesh], &coarse.state, effective);
    add_details(surface, details, mesh, &mut state);
    state
}

/// As [`advance`], where the rules are wanted once only.
pub fn descend(
    surface: &LoopSurface,
    corners: &CornerTable,
    details: &Details,
    coarse: &Level,
    mesh: &LevelMesh,
) -> LevelState {
    let mut state = rules::state(surface, corners, coarse, mesh);
    add_details(surface, details, mesh, &mut state);
    state
}

/// The level of `faces`, which are codes of `level` in whole families (all root faces at level 0).
pub fn build(surface: &LoopSurface, corners: &CornerTable, details: &Details, level: u32, faces: &[FaceCode]) -> Level {
    let mut way = Way::to(surface, level, faces);
    let mut at = root(surface, corners, details);
    while let Some(finer) = way.step(surface, corners, details, &at) {
        at = finer;
    }
    at
}

/// The way from the root mesh to some faces of a level.
///
/// The levels between hold just what is needed: a level must hold the neighbourhood of every face
/// that it subdivides.
#[derive(Debug, Default)]
pub struct Way {
    /// The faces to be subdivided, by level, the finest first.
    families: Vec<Vec<FaceCode>>,
}

impl Way {
    /// The way to `faces`, which are codes of `level` in whole families.
    pub fn to(surface: &LoopSurface, level: u32, faces: &[FaceCode]) -> Self {
        let mut families: Vec<Vec<FaceCode>> = Vec::new();
        let mut needed = faces.to_vec();
        for l in (0..level).rev() {
            let split = region::parents(&needed);
            needed = region::neighbourhood(&surface.mesh, l, &split);
            if l > 0 {
                // Whole families only.
                needed = region::children(&region::parents(&needed));
            }
            families.push(split);
        }
        Self { families }
    }

    /// The next level after `at`; `None` at the end of the way.
    pub fn step(
        &mut self,
        surface: &LoopSurface,
        corners: &CornerTable,
        details: &Details,
        at: &Level,
    ) -> Option<Level> {
        let split = self.families.pop()?;
        let local = at.mesh.find_all(&split);
        let mesh = rules::refine(surface, &at.mesh, &local);
        let state = descend(surface, corners, details, at, &mesh);
        Some(Level { mesh, state })
    }
}

/// Adds the stored details of the mesh's level to its state.
fn add_details(surface: &LoopSurface, details: &Details, mesh: &LevelMesh, state: &mut LevelState) {
    let stored = details.levels.get(mesh.level as usize).map_or(&[][..], Vec::as_slice);
    if stored.is_empty() {
        return;
    }
    let addresses = mesh.addresses(&surface.mesh);
    let found = map_in_order(addresses.len(), |v| stored.binary_search_by_key(&addresses[v], |d| d.0).ok());
    for (v, at) in found.into_iter().enumerate() {
        if let Some(at) = at {
            shift(mesh, state, v as u32, interior_sign(mesh, v as u32) * stored[at].1);
        }
    }
}

/// A detail is added to an interior vertex and subtracted on a given border.
pub fn interior_sign(mesh: &LevelMesh, v: u32) -> f64 {
    if matches!(mesh.vertices[v as usize].kind, Kind::Given(_)) { -1.0 } else { 1.0 }
}

/// Moves the effective point of `v` by `x`; on a given border the detail takes the move.
pub fn shift(mesh: &LevelMesh, state: &mut LevelState, v: u32, x: DVec3) {
    match mesh.vertices[v as usize].kind {
        Kind::Given(g) => {
            let d = &mut state.details[g as usize];
            *d -= x;
            state.effective[v as usize] = mesh.given[g as usize].sample - *d;
        }
        _ => state.effective[v as usize] += x,
    }
}
