//! The octant of a sphere: three given arcs, and an interior that is fitted to the sphere.
//!
//! [Litke et al. 2001, Fig. 6 and 7], with a radius of half a metre. Its mesh is lost; the ones here
//! are the smallest with one irregular vertex, of valence 5.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{CircularArc, CurveParameters, Extent, Heading, ParameterError, ShapeError};
use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::{Border, CornerRule, Details, Ends, LoopSurface, Side};
use selvedge_systems::subdivision::fit::{FitError, FitOptions, FitWork, Quantum, Region, Rule, Rung, Storage};
use selvedge_systems::subdivision::quasi::{BoundaryStencil, CornerStencil};
use selvedge_systems::target::Projection;
use serde::Serialize;
use thiserror::Error;

use crate::io::octant::{Octant, OctantError, read};

/// Radius of the sphere, in metres.
pub const RADIUS: f64 = 0.5;

/// The meshes that come with the engine: `cone(1,1)` and `cone(1,2)`.
///
/// # Errors
/// [`OctantError`] if the file that was built in is not what it should be.
pub fn meshes() -> Result<Vec<Octant>, OctantError> {
    read(include_bytes!("../../data/plates/octant.json"))
}

/// Why the scene could not be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OctantSceneError {
    /// The meshes.
    #[error(transparent)]
    Mesh(#[from] OctantError),
    /// An arc.
    #[error(transparent)]
    Arc(#[from] ShapeError),
    /// The parameters along an arc.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    /// The fit.
    #[error(transparent)]
    Fit(#[from] FitError),
}

/// The combined Loop surface over `octant`: three quarter circles from axis to axis with even
/// parameters, the interior at rest between them, no details.
///
/// # Errors
/// [`OctantSceneError::Arc`] or [`OctantSceneError::Parameters`] for a side without vertices.
pub fn surface(octant: &Octant, corner_rule: CornerRule) -> Result<LoopSurface, OctantSceneError> {
    let mesh = Arc::new(octant.mesh.clone());
    let mut points = vec![DVec3::ZERO; mesh.vertex_count()];
    let mut sides = Vec::with_capacity(3);
    for (k, vertices) in octant.sides.iter().enumerate() {
        let arc = CircularArc::from_axes(
            DVec3::ZERO,
            DVec3::AXES[k],
            DVec3::AXES[(k + 1) % 3],
            RADIUS,
            0.0,
            core::f64::consts::FRAC_PI_2,
        )?;
        let edges = vertices.len().saturating_sub(1).max(1) as f64;
        let even = (0..vertices.len()).map(|i| i as f64 / edges).collect();
        let curve = Arc::new(CurveParameters::new(Arc::new(arc), Extent::Open, even, &[])?);
        for (&v, sample) in vertices.iter().zip(curve.samples(0)) {
            points[v.index()] = sample;
        }
        let border = Border::Given { curve, first: 0, heading: Heading::Along };
        sides.push(Side { vertices: vertices.clone(), ends: Ends::Corners, border });
    }
    let mut surface = LoopSurface { mesh, points, sides, corner_rule, details: Details::default() };
    relax_interior(&mut surface);
    Ok(surface)
}

/// Moves every interior control point to the mean of its neighbours until nothing moves: the start
/// when nothing is known of the inside.
fn relax_interior(surface: &mut LoopSurface) {
    /// Each sweep shrinks what is left by a third at least on these small meshes, so this many end
    /// below rounding.
    const SWEEPS: usize = 200;
    let mesh = surface.mesh.clone();
    let interior: Vec<VertexId> = (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| !mesh.is_border(v)).collect();
    for _ in 0..SWEEPS {
        for &v in &interior {
            let sum = mesh.neighbours(v).fold(DVec3::ZERO, |sum, n| sum + surface.points[n.index()]);
            surface.points[v.index()] = sum / f64::from(mesh.valence(v));
        }
    }
}

/// How the details are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Least squares on every level.
    Lsq,
    /// The seed's stencils, with the boundary stencil that is exact on cubics.
    Quasi,
}

impl Method {
    /// Both, the default first.
    pub const ALL: [Self; 2] = [Self::Lsq, Self::Quasi];

    fn rules(self) -> (Rule, CornerRule) {
        match self {
            Self::Lsq => (Rule::LeastSquares, CornerRule::Lattice),
            Self::Quasi => {
                (Rule::Quasi { boundary: BoundaryStencil::Cubic, corner: CornerStencil::Mean }, CornerRule::Seed)
            }
        }
    }
}

/// What a fit of the octant by `method` asks for: details on levels 0 to 5, everywhere.
pub fn options(method: Method) -> FitOptions {
    FitOptions { rule: method.rules().0, last_level: 5, ..FitOptions::default() }
}

/// One ladder: what a fit of one mesh by one method came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LadderRow {
    /// Name of the mesh.
    pub mesh: String,
    /// How the details were found.
    pub rule: Method,
    /// Radius of the sphere, in metres.
    pub radius_m: f64,
    /// Greatest distance to the sphere before any detail, in metres.
    pub initial_max_m: f64,
    /// Level by level.
    pub levels: Vec<LevelRow>,
}

/// One level of a ladder.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LevelRow {
    /// The level.
    pub level: u32,
    /// Greatest distance to the sphere, in metres, at the limit points two levels finer.
    pub max_m: f64,
    /// Mean distance over the points sampled at this level.
    pub mean_m: f64,
    /// Vectors stored, all levels together.
    pub details: usize,
    /// Where the distance is greatest.
    pub max_at: [f64; 3],
    /// Greatest distance over the patches that this level could influence: where a fit goes on
    /// around one vertex only, the error there.
    pub zone_max_m: f64,
    /// By how much that fell from the level before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
}

impl LevelRow {
    fn new(rung: &Rung, before: Option<&Rung>) -> Self {
        Self {
            level: rung.level,
            max_m: rung.max,
            mean_m: rung.mean,
            details: rung.details,
            max_at: rung.max_at.to_array(),
            zone_max_m: rung.max_here,
            ratio: before.map(|b| b.max_here / rung.max_here),
        }
    }
}

/// A fit to the sphere, kept with what pictures need.
#[derive(Clone, Debug)]
pub struct OctantFit {
    /// Its ladder.
    pub row: LadderRow,
    /// The surface, details and all.
    pub surface: LoopSurface,
}

/// Fits `octant` down to `last_level`; levels after `everywhere` go on around the irregular vertex
/// only, eight rings of faces of each level.
///
/// # Errors
/// [`OctantSceneError::Fit`] when the level is too fine.
pub fn fit(
    octant: &Octant,
    method: Method,
    storage: Storage,
    everywhere: u32,
    last_level: u32,
) -> Result<OctantFit, OctantSceneError> {
    let source = Arc::new(surface(octant, method.rules().1)?);
    let sphere = Arc::new(Projection(|p: DVec3| p * (RADIUS / p.length())));
    let region = if last_level > everywhere {
        Region::Around { vertex: octant.irregular, rings: 8, from_level: everywhere + 1 }
    } else {
        Region::Whole
    };
    let options = FitOptions { last_level, region, storage, ..options(method) };
    let mut work = FitWork::new(source.clone(), sphere, options)?;
    while work.advance()? != Quantum::Finished {}
    let ladder = work.ladder();
    let levels = (0..ladder.len()).map(|i| LevelRow::new(&ladder[i], i.checked_sub(1).map(|b| &ladder[b])));
    let row = LadderRow {
        mesh: octant.name.clone(),
        rule: method,
        radius_m: RADIUS,
        initial_max_m: work.initial().map_or(f64::NAN, |rung| rung.max),
        levels: levels.collect(),
    };
    let surface = LoopSurface { details: work.details().clone(), ..(*source).clone() };
    Ok(OctantFit { row, surface })
}
