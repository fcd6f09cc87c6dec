//! A surface and what a trim leaves of it, as one would see them.

use selvedge_components::subdivision::LoopSurface;
use selvedge_components::triangles::Triangles;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

use super::{TrimPictureError, cage};
use crate::diagram::camera::{Frame, View};
use crate::diagram::canvas::{Canvas, Stroke};
use crate::diagram::colour::palette;
use crate::diagram::grid::{Cell, Grid};
use crate::diagram::overlay::Overlay;
use crate::diagram::scene::Scene;
use crate::diagram::shade::Surface;
use crate::scenes::trims::{TrimSceneError, Trimmed};

/// How far the triangles of a picture may stand off, as a part of the size: less than its pixels.
const CHORD: f64 = 2e-5;

/// The given surface and the trimmed one, and below them their cages. [Fig. 12]
///
/// # Errors
/// As the drawing.
pub fn figure(trimmed: &Trimmed, view: &View, frame: Frame) -> Result<Canvas, TrimPictureError> {
    let surfaces = [(&*trimmed.ground.surface, "given"), (&*trimmed.surface, "trimmed")];
    let limits = [limit(trimmed, surfaces[0].0)?, limit(trimmed, surfaces[1].0)?];
    let camera = Scene::of(Surface::new(&limits[0])).camera(view, frame)?;
    let mut cells = Vec::new();
    for (mesh, (surface, words)) in limits.iter().zip(surfaces) {
        let border = Overlay::border(mesh, Stroke::new(palette::INK, 1.2))?;
        let picture = Scene::of(Surface::new(mesh)).with([border]).draw(&camera)?;
        cells.push(Cell::new(picture, format!("{words}: {} details", surface.details.count())));
    }
    for (mesh, (surface, _)) in limits.iter().zip(surfaces) {
        let cage = cage(surface);
        let wires = Overlay::wireframe(&cage, Stroke::new(palette::BLUE, 1.1))?;
        let border = Overlay::border(mesh, Stroke::new(palette::BLUE, 2.4))?;
        let picture = Scene::of(Surface::new(&cage).faceted()).with([wires, border]).draw(&camera)?;
        cells.push(Cell::new(picture, format!("its control mesh: {} faces", surface.mesh.face_count())));
    }
    Ok(Grid::new(2, 20.0).compose(&cells)?)
}

/// What a trim leaves, alone and large.
///
/// # Errors
/// As the drawing.
pub fn portrait(trimmed: &Trimmed, view: &View, frame: Frame) -> Result<Canvas, TrimPictureError> {
    let mesh = limit(trimmed, &trimmed.surface)?;
    Ok(Scene::of(Surface::new(&mesh)).picture(view, frame)?)
}

fn limit(trimmed: &Trimmed, surface: &LoopSurface) -> Result<Triangles, TrimPictureError> {
    let density = Density::Chord(CHORD * trimmed.ground.size);
    let options = TriangulateOptions { density, ..TriangulateOptions::default() };
    Ok(triangulate(surface, &options).map_err(TrimSceneError::from)?.triangles)
}
