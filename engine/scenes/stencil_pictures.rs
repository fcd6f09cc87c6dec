//! Pictures of the stencils, and of what boundary details do.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{CurveParameters, Extent, Heading, ParameterError, Segment};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::{Address, Border, CornerRule, Details, Ends, LoopSurface, Side};
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

use super::stencils::StencilRow;
use crate::diagram::camera::{Frame, View};
use crate::diagram::canvas::{Canvas, Stroke};
use crate::diagram::colour::palette;
use crate::diagram::error::DiagramError;
use crate::diagram::grid::{Cell, Grid};
use crate::diagram::overlay::{Hidden, Overlay};
use crate::diagram::scene::Scene;
use crate::diagram::shade::Surface;
use crate::diagram::stencil::{Stencil, draw_all};
use crate::diagram::units::fraction;

/// The stencils called `name` that have a valence, one picture each, in rows of five.
///
/// # Errors
/// As the drawing.
pub fn rings(rows: &[StencilRow], name: &str) -> Result<Canvas, DiagramError> {
    let stencils: Vec<Stencil> = rows
        .iter()
        .filter(|row| row.name == name)
        .filter_map(|row| {
            let k = row.valence?;
            let label =
                |place: &str| row.weights.iter().find(|w| w.0 == place).map_or(String::new(), |w| fraction(w.1));
            Some(Stencil::even_ring(k as usize, &label("centre"), &label("ring"), format!("valence {k}")))
        })
        .collect();
    draw_all(&stencils, 5, 300)
}

/// A plate with straight borders, without a boundary detail and with two opposite ones at the middle
/// of its front border: the border stays, the surface beside it bends. [Fig. 4]
///
/// # Errors
/// As the drawing, and what the plate is made of, as text.
pub fn details() -> Result<Canvas, Box<dyn std::error::Error>> {
    let view = View::from_angles(-75.0, 24.0);
    let frame = Frame::new(620, 420);
    let mut cells = Vec::new();
    for height in [0.0, 0.35, -0.35] {
        let (surface, at) = plate(height)?;
        let options = TriangulateOptions { density: Density::Level(4), ..TriangulateOptions::default() };
        let fine = triangulate(&surface, &options)?.triangles;
        let coarse = TriangulateOptions { density: Density::Level(2), ..TriangulateOptions::default() };
        let wires = triangulate(&surface, &coarse)?.triangles;
        let mut over = vec![
            Overlay::wireframe(&wires, Stroke::new(palette::SLATE, 0.7))?.with_slack(0.01),
            Overlay::border(&fine, Stroke::new(palette::BLUE, 3.0))?,
        ];
        if height != 0.0 {
            over.push(arrow(at, height));
        }
        // One camera for all three: the reach of the arrows.
        let span = [at + DVec3::new(0.0, 0.0, 0.4), at - DVec3::new(0.0, 0.0, 0.4)];
        let reach = Overlay::dots(span.to_vec(), 0.0, palette::PAPER);
        let camera = Scene::of(Surface::new(&fine)).with([reach]).camera(&view, frame)?;
        let caption = match height {
            h if h > 0.0 => "d points up",
            h if h < 0.0 => "d points down",
            _ => "d = 0",
        };
        cells.push(Cell::new(Scene::of(Surface::new(&fine)).with(over).draw(&camera)?, caption));
    }
    Ok(Grid::new(3, 20.0).compose(&cells)?)
}

/// An arrow upwards by `height`, or downwards if that is negative.
fn arrow(from: DVec3, height: f64) -> Overlay {
    let tip = from + DVec3::Z * height;
    let barb = |side: f64| vec![tip, tip - DVec3::new(side * 0.05, 0.0, 0.1 * height.signum())];
    Overlay::lines(vec![vec![from, tip], barb(1.0), barb(-1.0)], Stroke::new(palette::RED, 4.0))
        .with_hidden(Hidden::Show)
}

/// A parallelogram of four by four lattice cells with four given sides, and a detail of `height` at
/// the middle of its first side; and where that is.
fn plate(height: f64) -> Result<(LoopSurface, DVec3), Box<dyn std::error::Error>> {
    const CELLS: u32 = 4;
    let (a, b) = (DVec2::X * 0.5, DVec2::from_angle(std::f64::consts::FRAC_PI_3) * 0.5);
    let name = |i: u32, j: u32| j * (CELLS + 1) + i;
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for j in 0..=CELLS {
        for i in 0..=CELLS {
            points.push((f64::from(i) * a + f64::from(j) * b).extend(0.0));
            if i < CELLS && j < CELLS {
                faces.push([name(i, j), name(i + 1, j), name(i, j + 1)]);
                faces.push([name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)]);
            }
        }
    }
    let mesh = Connectivity::new(points.len(), &faces).map_err(|faults| faults[0].clone())?;
    let walks: [Vec<u32>; 4] = [
        (0..=CELLS).map(|i| name(i, 0)).collect(),
        (0..=CELLS).map(|j| name(CELLS, j)).collect(),
        (0..=CELLS).map(|i| name(CELLS - i, CELLS)).collect(),
        (0..=CELLS).map(|j| name(0, CELLS - j)).collect(),
    ];
    let side = |walk: &Vec<u32>| {
        let ends = [walk[0], walk[CELLS as usize]].map(|v| points[v as usize]);
        let even = (0..=CELLS).map(|i| f64::from(i) / f64::from(CELLS)).collect();
        let curve = CurveParameters::new(Arc::new(Segment { start: ends[0], end: ends[1] }), Extent::Open, even, &[])?;
        let border = Border::Given { curve: Arc::new(curve), first: 0, heading: Heading::Along };
        Ok(Side { vertices: walk.iter().map(|&v| VertexId(v)).collect(), ends: Ends::Corners, border })
    };
    let sides = walks.iter().map(side).collect::<Result<Vec<Side>, ParameterError>>()?;
    let middle = name(CELLS / 2, 0);
    let detail = (Address::Corner(VertexId(middle)), DVec3::Z * height);
    let at = points[middle as usize];
    let details = Details { levels: vec![vec![detail]] };
    let surface = LoopSurface { mesh: Arc::new(mesh), points, sides, corner_rule: CornerRule::Lattice, details };
    Ok((surface, at))
}
