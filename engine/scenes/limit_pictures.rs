//! Pictures of a control cage and its limit surface.

use glam::DVec3;
use selvedge_components::triangles::Triangles;

use crate::diagram::camera::{Frame, View};
use crate::diagram::canvas::{Canvas, Stroke};
use crate::diagram::colour::palette;
use crate::diagram::error::DiagramError;
use crate::diagram::grid::{Cell, Grid};
use crate::diagram::overlay::Overlay;
use crate::diagram::scene::Scene;
use crate::diagram::shade::Surface;
use crate::io::Cage;

/// The cage over the limit surface, the triangles of the limit surface, and the surface alone, side
/// by side, seen from the front left with y up.
///
/// # Errors
/// As the drawing.
pub fn figure(cage: &Cage, limit: &Triangles, size: u32) -> Result<Canvas, DiagramError> {
    let view = View::from_angles(0.0, 0.0).with_up(DVec3::Y);
    let view = View { from: DVec3::new(-0.75, 0.35, -1.0), ..view };
    let over = Overlay::cage(&cage.to_triangles(), palette::BLUE, size)?;
    let scene = || Scene::of(Surface::new(limit));
    let camera = scene().with(over.clone()).camera(&view, Frame::new(size, size))?;
    let wires = Overlay::wireframe(limit, Stroke::new(palette::SLATE, 0.6))?;
    let cells = [
        Cell::new(
            scene().with(over).draw(&camera)?,
            format!("control cage: {} vertices, {} triangles", cage.positions.len(), cage.triangles.len()),
        ),
        Cell::new(
            scene().with([wires]).draw(&camera)?,
            format!("{} triangles, every vertex on the limit surface", limit.triangles.len()),
        ),
        Cell::new(scene().draw(&camera)?, "the limit surface"),
    ];
    Grid::new(3, f64::from(size) / 32.0).lettered().compose(&cells)
}
