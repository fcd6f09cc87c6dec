//! Pictures of trims.
//!
//! | module | what |
//! | --- | --- |
//! | [`stages`] | pre-image, refined, removed, attached and relaxed cage; re-sampled points [Fig. 9 and 10] |
//! | [`regions`] | active set, its neighbourhood and the region of influence, level by level [Fig. 11 and 14] |
//! | [`errors`] | the distance to the given surface in pseudo colours, and the ladder [Fig. 13 and 15] |
//! | [`views`] | a surface and what a trim leaves of it, with their cages [Fig. 12] |
//! | [`failed`] | what is known of a trim that failed, and where |
//!
//! Figures are those of [Litke et al. 2001].

pub mod errors;
pub mod failed;
pub mod regions;
pub mod stages;
pub mod views;

use glam::DVec3;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::triangles::Triangles;
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::remesh::{Extent, PreImage};
use thiserror::Error;

use super::trims::TrimSceneError;
use crate::diagram::canvas::{Ends, Stroke};
use crate::diagram::domain::{Domain, Face};
use crate::diagram::error::DiagramError;

/// Why there is no picture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrimPictureError {
    /// What is to be drawn.
    #[error(transparent)]
    Scene(#[from] TrimSceneError),
    /// The drawing.
    #[error(transparent)]
    Diagram(#[from] DiagramError),
}

/// The limit points at the corners of faces of one level.
fn limit_faces(limit: &LimitSurface, level: u32, codes: impl IntoIterator<Item = FaceCode>) -> Vec<Face> {
    let scale = 1.0 / f64::from(1_u32 << level);
    let corner = |face: FaceId, (i, j): (u32, u32)| {
        limit.position(SurfacePoint::new(face, f64::from(i) * scale, f64::from(j) * scale))
    };
    codes.into_iter().map(|code| code.corners(level).map(|at| corner(code.root_face(level), at))).collect()
}

/// The limit points at the corners of all faces of the control mesh.
fn root_faces(limit: &LimitSurface) -> Vec<Face> {
    let faces = (0..limit.face_count()).map(|f| FaceCode::root(FaceId::new(f)));
    limit_faces(limit, 0, faces)
}

/// The control mesh as triangles; border vertices stand where their curve has them.
fn cage(surface: &LoopSurface) -> Triangles {
    let corners = surface.mesh.faces().iter().map(|f| f.map(|v| v.0));
    Triangles { positions: surface.points.clone(), triangles: corners.collect(), ..Triangles::default() }
}

/// Draws where curves run.
fn draw_images(page: &mut Domain, images: &[PreImage], stroke: &Stroke) {
    for image in images {
        let points: Vec<DVec3> = image.points.iter().map(|p| p.position).collect();
        page.curve(&points, if image.extent == Extent::Round { Ends::Closed } else { Ends::Open }, stroke);
    }
}
