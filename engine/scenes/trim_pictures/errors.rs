//! How far the trimmed surface is from the given one.

use glam::DVec3;
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::target::Target;
use selvedge_components::triangles::Triangles;
use selvedge_components::triangulation::Normals;
use selvedge_systems::closest::Search;
use selvedge_systems::parallel::map_in_order;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

use super::TrimPictureError;
use crate::diagram::camera::{Frame, View};
use crate::diagram::canvas::{Canvas, Stroke};
use crate::diagram::colour::palette;
use crate::diagram::colourbar::with_colour_bar;
use crate::diagram::colourmap::ColourScale;
use crate::diagram::grid::{Cell, Grid};
use crate::diagram::overlay::Overlay;
use crate::diagram::plot::{Ladder, Series};
use crate::diagram::scene::Scene;
use crate::diagram::shade::{Paint, Surface};
use crate::diagram::units::Quantity;
use crate::scenes::trims::{TrimSceneError, Trimmed};

/// How error maps are drawn.
#[derive(Clone, Copy, Debug)]
pub struct MapStyle {
    /// From where.
    pub view: View,
    /// Pixels.
    pub frame: Frame,
    /// How often each face is quartered.
    pub level: u32,
    /// Maps in a row.
    pub columns: usize,
}

impl MapStyle {
    /// From above, pictures of 520 pixels, three in a row.
    pub fn above(level: u32) -> Self {
        let view = View { from: DVec3::Z, up: DVec3::Y, ..View::from_angles(0.0, 90.0) }.orthographic();
        Self { view, frame: Frame::new(520, 520), level, columns: 3 }
    }
}

/// A triangulated limit surface with its distances to the given one.
struct Map {
    mesh: Triangles,
    errors: Vec<f64>,
}

/// One map per level, each with a logarithmic scale of its own: three decades down from its greatest
/// error. The border of the region of influence is drawn over it. [Fig. 13 and 15]
///
/// # Errors
/// As the drawing.
pub fn maps(trimmed: &Trimmed, style: &MapStyle) -> Result<Canvas, TrimPictureError> {
    let levels = core::iter::once(None).chain(trimmed.ladder.iter().map(|rung| Some(rung.level)));
    let cells = levels.map(|level| cell(trimmed, level, style)).collect::<Result<Vec<_>, _>>()?;
    Ok(Grid::new(style.columns, 20.0).compose(&cells)?)
}

fn cell(trimmed: &Trimmed, level: Option<u32>, style: &MapStyle) -> Result<Cell, TrimPictureError> {
    const DECADES: f64 = 1e-3;
    let map = measure(trimmed, &trimmed.after(level), style.level)?;
    let shown = map.errors.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let rung = match level {
        None => trimmed.initial,
        Some(level) => trimmed.ladder.iter().find(|rung| rung.level == level).copied(),
    };
    // Neither the map nor the ladder shows all points.
    let most = rung.map_or(shown, |rung| rung.max.max(shown));
    let scale = ColourScale::new(DECADES * most, most)?.logarithmic()?.titled("distance");
    let surface = Surface::new(&map.mesh).painted(Paint::Values(&map.errors, &scale));
    let rim = Overlay::lines(region_border(trimmed, &map.mesh), Stroke::new(palette::PAPER, 1.6));
    let border = Overlay::border(&map.mesh, Stroke::new(palette::INK, 1.2))?;
    let picture = Scene::of(surface).with([rim, border]).picture(&style.view, style.frame)?;
    let words = level.map_or("before any detail".to_owned(), |level| format!("level {level}"));
    let caption = format!("{words}: at most {}", Quantity::Length.label(most, 3));
    Ok(Cell::new(with_colour_bar(&picture, &scale, 17.0)?, caption))
}

fn measure(trimmed: &Trimmed, surface: &LoopSurface, level: u32) -> Result<Map, TrimPictureError> {
    let options =
        TriangulateOptions { density: Density::Level(level), normals: Normals::OfLimit, ..Default::default() };
    let mesh = triangulate(surface, &options).map_err(TrimSceneError::from)?.triangles;
    let target = trimmed.ground.target(Search::Everywhere);
    // Beyond the region of influence the surface has its bits: it need not be measured.
    let mut inside = vec![false; mesh.positions.len()];
    for (corners, &face) in mesh.triangles.iter().zip(&mesh.faces) {
        if trimmed.remeshed.omega.binary_search(&FaceCode::root(face)).is_ok() {
            corners.iter().for_each(|&v| inside[v as usize] = true);
        }
    }
    // Neighbours in number are mostly neighbours in space, so one's foot is a hint for the next.
    const RUN: usize = 32;
    let runs: Vec<usize> = (0..mesh.positions.len()).step_by(RUN).collect();
    let errors = map_in_order(runs.len(), |run| {
        let end = mesh.positions.len().min(runs[run] + RUN);
        let mut hint = None;
        let distance = |v: usize| {
            if !inside[v] {
                return 0.0;
            }
            let Ok(foot) = target.closest(mesh.positions[v], hint) else { return f64::NAN };
            hint = foot.at;
            foot.position.distance(mesh.positions[v])
        };
        (runs[run]..end).map(distance).collect::<Vec<f64>>()
    });
    Ok(Map { errors: errors.into_iter().flatten().collect(), mesh })
}

/// The edges between the region of influence and what is beyond.
fn region_border(trimmed: &Trimmed, mesh: &Triangles) -> Vec<Vec<DVec3>> {
    let mut edges: Vec<([u32; 2], bool)> = Vec::new();
    for (corners, &face) in mesh.triangles.iter().zip(&mesh.faces) {
        let inside = trimmed.remeshed.omega.binary_search(&FaceCode::root(face)).is_ok();
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            edges.push(([a.min(b), a.max(b)], inside));
        }
    }
    edges.sort_unstable();
    let pairs = edges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 2 && same[0].1 != same[1].1);
    pairs.map(|same| same[0].0.map(|v| mesh.positions[v as usize]).to_vec()).collect()
}

/// The ladders of several trims, each with its name.
///
/// # Errors
/// As the drawing.
pub fn ladder(title: &str, trims: &[(&str, &Trimmed)]) -> Result<Canvas, TrimPictureError> {
    let series = |(name, trimmed): &(&str, &Trimmed)| {
        Series::from_levels((*name).to_owned(), trimmed.ladder.iter().map(|rung| rung.max))
    };
    let plot = Ladder {
        title: title.into(),
        value_label: "distance to the given surface".into(),
        series: trims.iter().map(series).collect(),
        ..Ladder::default()
    };
    Ok(plot.draw()?)
}
