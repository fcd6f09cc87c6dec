//! Where each level of a fit works.

use std::sync::Arc;

use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::FaceCode;
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::region;

use super::{TrimPictureError, limit_faces, root_faces};
use crate::diagram::canvas::Canvas;
use crate::diagram::colour::{Colour, palette};
use crate::diagram::domain::Domain;
use crate::diagram::grid::{Cell, Grid};
use crate::scenes::trims::{TrimSceneError, Trimmed};

/// Pixels across one diagram.
const SIZE: u32 = 620;
/// Beyond the region of influence.
const OUTSIDE: Colour = Colour::hex(0xff_ff_ff);
/// The region of influence.
const OMEGA: Colour = Colour::hex(0xe6_e6_e0);
/// The patches that are measured.
const NEAR: Colour = Colour::hex(0xb9_d3_e6);
/// The faces around vertices that may move.
const ACTIVE: Colour = Colour::hex(0x3f_7c_b4);

/// For each level the faces around the vertices that it may move, the patches that they influence, and
/// the region that none may leave. [Fig. 11 and 14]
///
/// # Errors
/// As the drawing.
pub fn figure(trimmed: &Trimmed) -> Result<Canvas, TrimPictureError> {
    let mesh = &trimmed.surface.mesh;
    let limit = LimitSurface::new(Arc::clone(&trimmed.surface)).map_err(TrimSceneError::from)?;
    let all = root_faces(&limit);
    // What lies beyond is white: the region fills the page.
    let shown = limit_faces(&limit, 0, trimmed.remeshed.omega.iter().copied());
    let mut cells = Vec::new();
    for rung in &trimmed.ladder {
        let level = rung.level;
        let stored = trimmed.surface.details.levels.get(level as usize).map_or(&[][..], Vec::as_slice);
        let mut active = Vec::new();
        for (face, corner) in stored.iter().filter_map(|&(address, _)| region::corner_at(mesh, level, address)) {
            active.push(face);
            region::fan(mesh, level, face, corner, &mut active);
        }
        let active = region::ascending(active);
        let near = region::neighbourhood(mesh, level, &active);
        let outside = (0..mesh.face_count()).map(|f| FaceCode::root(FaceId::new(f)));
        let outside = outside.filter(|f| trimmed.remeshed.omega.binary_search(f).is_err());
        let mut page = Domain::about(&all, &shown, SIZE)?;
        page.fill(&all, OMEGA);
        page.fill(&limit_faces(&limit, 0, outside), OUTSIDE);
        page.fill(&limit_faces(&limit, level, near.iter().copied()), NEAR);
        let dark = limit_faces(&limit, level, active.iter().copied());
        page.fill(&dark, ACTIVE);
        page.edges(&dark, palette::PAPER.with_alpha(120), 0.5);
        page.edges(&all, palette::SLATE, 1.0);
        let caption = format!("level {level}: {} vertices may move (blue), their patches (light)", rung.active);
        cells.push(Cell::new(page.into_canvas(), caption));
    }
    Ok(Grid::new(cells.len().clamp(1, 4), 20.0).compose(&cells)?)
}
