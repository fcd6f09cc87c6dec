//! A surface and what a trim leaves of it, as one would see them.

use selvedge_components::subdivision::LoopSurface;
use selvedge_components::triangles::Triangles;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

use super::{TrimPictureError, cage};
use crate::diagram::camera::{Frame, View};
use crate::diagram::canvas::{Canvas, Stroke};
use crate::diagram::colour::palette;
use crate::diagram::error::DiagramError;
use crate::diagram::grid::{Cell, Grid};
use crate::diagram::overlay::Overlay;
use crate::diagram::scene::Scene;
use crate::diagram::shade::Surface;
use crate::scenes::trims::{TrimSceneError, Trimmed};

/// Triangles of a picture, at least: some pixels each.
const TRIANGLES: usize = 60_000;

/// The given surface and the trimmed one, and below them their cages. [Fig. 12]
///
/// # Errors
/// As the drawing.
pub fn figure(trimmed: &Trimmed, view: &View, frame: Frame) -> Result<Canvas, TrimPictureError> {
    let surfaces = [(&*trimmed.ground.surface, "given"), (&*trimmed.surface, "trimmed")];
    let limits = [limit(surfaces[0].0)?, limit(surfaces[1].0)?];
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
    let mesh = limit(&trimmed.surface)?;
    Ok(Scene::of(Surface::new(&mesh)).picture(view, frame)?)
}

/// Several surfaces in one scene.
///
/// # Errors
/// As the drawing.
pub fn together(surfaces: &[&LoopSurface], view: &View, frame: Frame) -> Result<Canvas, TrimPictureError> {
    let meshes = surfaces.iter().map(|surface| limit(surface)).collect::<Result<Vec<_>, _>>()?;
    let Some((first, rest)) = meshes.split_first() else {
        return Err(DiagramError::Nothing { what: "no surfaces" }.into());
    };
    let scene = rest.iter().fold(Scene::of(Surface::new(first)), |scene, mesh| scene.and(Surface::new(mesh)));
    let borders = meshes.iter().map(|mesh| Overlay::border(mesh, Stroke::new(palette::INK, 1.4)));
    Ok(scene.with(borders.collect::<Result<Vec<_>, _>>()?).picture(view, frame)?)
}

/// The limit surface as so many triangles that it looks smooth.
fn limit(surface: &LoopSurface) -> Result<Triangles, TrimPictureError> {
    let faces = surface.mesh.face_count().max(1);
    let level = (0..8).find(|level| faces << (2 * level) >= TRIANGLES).unwrap_or(8);
    let options = TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() };
    Ok(triangulate(surface, &options).map_err(TrimSceneError::from)?.triangles)
}
