//! Triangles out: what a host draws or hands on.

use bevy_ecs::prelude::Component;
use glam::DVec3;

use crate::evaluate::SurfacePoint;
use crate::mesh::FaceId;

/// A triangle mesh whose vertices lie on a limit surface. Written by the triangulate stage;
/// replaced whole.
///
/// Always true: `triangles` name vertices in range, counter-clockwise seen from outside; each of
/// the other arrays is empty (not asked for) or has one entry per position, `faces` one per triangle.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct Triangles {
    /// Vertex positions, in model units.
    pub positions: Vec<DVec3>,
    /// Unit normals of the limit surface.
    pub normals: Vec<DVec3>,
    /// Where on the root mesh each vertex lies.
    pub origins: Vec<SurfacePoint>,
    /// Linear RGB in [0, 1].
    pub colours: Vec<[f32; 3]>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
    /// The root face that each triangle lies on.
    pub faces: Vec<FaceId>,
}
