//! Pictures of the octant: the fit, its error maps and its ladders.

use selvedge_components::subdivision::{Details, LoopSurface};
use selvedge_components::triangles::Triangles;
use selvedge_systems::triangulate::{Density, TriangulateError, TriangulateOptions, triangulate};
use thiserror::Error;

use super::octant::{LadderRow, Method, OctantFit, RADIUS};
use crate::diagram::camera::{Frame, View};
use crate::diagram::canvas::{Canvas, Stroke};
use crate::diagram::colour::palette;
use crate::diagram::colourbar::with_colour_bar;
use crate::diagram::colourmap::ColourScale;
use crate::diagram::error::DiagramError;
use crate::diagram::grid::{Cell, Grid};
use crate::diagram::overlay::Overlay;
use crate::diagram::plot::{Guide, Ladder, Series};
use crate::diagram::scene::Scene;
use crate::diagram::shade::{Paint, Surface};
use crate::diagram::units::Quantity;

/// Why there is no picture of the fit.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OctantPictureError {
    /// The surface cannot be drawn.
    #[error(transparent)]
    Triangulate(#[from] TriangulateError),
    /// The drawing.
    #[error(transparent)]
    Diagram(#[from] DiagramError),
}

/// The level at which surfaces are drawn: their borders turn by less than a degree from edge to edge.
const FINE: u32 = 6;

/// Along the diagonal of the octant, a little from above.
fn view() -> View {
    View::from_angles(45.0, 28.0)
}

/// Control mesh, the limit surface before any detail, and after the last level. [Fig. 6]
///
/// # Errors
/// [`OctantPictureError`].
pub fn figure(fit: &OctantFit) -> Result<Canvas, OctantPictureError> {
    let frame = Frame::new(620, 620);
    let cage = cage(&fit.surface);
    let initial = limit(&LoopSurface { details: Details::default(), ..fit.surface.clone() }, FINE)?;
    let fitted = limit(&fit.surface, FINE)?;
    let over = || Overlay::cage(&cage, palette::BLUE, 620);
    let camera = Scene::of(Surface::new(&fitted)).with(over()?).camera(&view(), frame)?;
    let draw = |scene: Scene<'_>, caption: String| Ok::<_, DiagramError>(Cell::new(scene.draw(&camera)?, caption));
    let last = fit.row.levels.last().map_or(0.0, |l| l.max_m);
    let length = |x: f64| Quantity::Length.label(x, 2);
    let cells = [
        draw(Scene::of(Surface::new(&cage).faceted()).with(over()?), "control mesh".into())?,
        draw(
            Scene::of(Surface::new(&initial)).with([border(&initial)?]),
            format!("its limit surface: the arcs are met, the sphere is missed by {}", length(fit.row.initial_max_m)),
        )?,
        draw(
            Scene::of(Surface::new(&fitted)).with([border(&fitted)?]),
            format!("with {} details: within {}", fit.surface.details.count(), length(last)),
        )?,
    ];
    Ok(Grid::new(3, 20.0).lettered().compose(&cells)?)
}

/// Decades of error that a map shows: at the finer levels the mean is a thousandth of the greatest,
/// and half of the surface lies below the mean.
const DECADES: i32 = 4;

/// The distance to the sphere after each of levels 0 to 5, each on a logarithmic scale that ends with
/// its own greatest. [Fig. 7]
///
/// # Errors
/// As the drawing.
pub fn error_maps(fit: &OctantFit) -> Result<Canvas, OctantPictureError> {
    let frame = Frame::new(520, 520);
    let mut cells = Vec::new();
    for level in &fit.row.levels {
        let mut details = fit.surface.details.clone();
        details.levels.truncate(level.level as usize + 1);
        let mesh = limit(&LoopSurface { details, ..fit.surface.clone() }, FINE.max(level.level + 2))?;
        let errors: Vec<f64> = mesh.positions.iter().map(|p| (p.length() - RADIUS).abs()).collect();
        // Neither the map nor the ladder shows all points; and a map without any error still has a scale.
        let most = errors.iter().copied().fold(level.max_m.max(f64::EPSILON), f64::max);
        let scale = ColourScale::new(most * 0.1_f64.powi(DECADES), most)?.logarithmic()?.titled("distance");
        let surface = Surface::new(&mesh).painted(Paint::Values(&errors, &scale));
        let picture = Scene::of(surface).picture(&view(), frame)?;
        let caption = format!("level {}: at most {}", level.level, Quantity::Length.label(most, 3));
        cells.push(Cell::new(with_colour_bar(&picture, &scale, 17.0)?, caption));
    }
    Ok(Grid::new(3, 20.0).compose(&cells)?)
}

/// Ladders of several fits in one plot, with the fall that the irregular vertex allows.
///
/// # Errors
/// As the drawing.
pub fn ladder_plot(rows: &[&LadderRow]) -> Result<Canvas, DiagramError> {
    let name = |row: &LadderRow| {
        let rule = match row.rule {
            Method::Lsq => "least squares",
            Method::Quasi => "quasi-interpolation",
        };
        format!("{}, {rule}", row.mesh)
    };
    let series = rows.iter().map(|row| Series::from_levels(name(row), row.levels.iter().map(|l| l.zone_max_m)));
    let deepest = rows.iter().max_by_key(|row| row.levels.len());
    let guide = deepest.and_then(|row| {
        let last = row.levels.last()?;
        let start = row.levels.get(3)?;
        Some(Guide {
            label: "1/\u{3bb}\u{b2} = 4.89".into(),
            ..Guide::new(4.89, (3.0, start.zone_max_m * 4.0), f64::from(last.level))
        })
    });
    Ladder {
        title: "octant of a sphere, radius 0.5 m".into(),
        value_label: "distance to the sphere".into(),
        series: series.collect(),
        guides: guide.into_iter().collect(),
        ..Ladder::default()
    }
    .draw()
}

/// A limit surface as triangles of `level`.
fn limit(surface: &LoopSurface, level: u32) -> Result<Triangles, TriangulateError> {
    let options = TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() };
    Ok(triangulate(surface, &options)?.triangles)
}

/// The control mesh as triangles.
fn cage(surface: &LoopSurface) -> Triangles {
    let corners = surface.mesh.faces().iter().map(|f| f.map(|v| v.0));
    Triangles { positions: surface.points.clone(), triangles: corners.collect(), ..Triangles::default() }
}

fn border(mesh: &Triangles) -> Result<Overlay, DiagramError> {
    Overlay::border(mesh, Stroke::new(palette::BLUE, 3.0))
}
