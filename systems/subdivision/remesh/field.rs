//! The source at one level: limit points and control points over a set of faces.

use glam::DVec3;
use selvedge_components::subdivision::{CornerTable, FaceCode, Kind, LimitRows, LoopSurface, RingState};

use super::super::chain::{self, Level};
use super::super::region;

/// The faces of one level with what is known at their vertices.
#[derive(Debug)]
pub struct Field {
    /// The level's mesh and state.
    pub level: Level,
    /// Limit points, one per vertex; NaN where the ring is not whole.
    pub limit: Vec<DVec3>,
}

impl Field {
    /// The field over `faces` (ascending codes of `level`) and a ring around them.
    ///
    /// The limit points are those of the surface without details finer than `level`: they serve to
    /// measure, not to build.
    pub fn new(surface: &LoopSurface, corners: &CornerTable, level: u32, faces: &[FaceCode]) -> Self {
        let held = if level == 0 {
            region::whole(&surface.mesh, 0)
        } else {
            region::children(&region::parents(&region::neighbourhood(&surface.mesh, level, faces)))
        };
        let level = chain::build(surface, corners, &surface.details, level, &held);
        let rows = LimitRows::new(surface, corners, &level.mesh, |_| true);
        let mut limit = vec![DVec3::NAN; level.mesh.vertices.len()];
        for (&v, x) in rows.vertices.iter().zip(rows.apply(&level.state)) {
            limit[v as usize] = x;
        }
        for (v, vertex) in level.mesh.vertices.iter().enumerate() {
            if matches!(vertex.kind, Kind::Given(_)) && vertex.ring == RingState::Whole {
                limit[v] = level.mesh.sample(v as u32);
            }
        }
        Self { level, limit }
    }

    /// The corners of `face`'s limit triangle.
    pub fn triangle(&self, face: u32) -> [DVec3; 3] {
        self.level.mesh.corners[face as usize].map(|v| self.limit[v as usize])
    }
}
