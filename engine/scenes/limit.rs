//! A control cage and its limit surface.

use std::sync::Arc;

use selvedge_components::mesh::{Connectivity, Fault};
use selvedge_components::subdivision::LoopSurface;
use selvedge_components::triangulation::ChordReport;
use selvedge_systems::triangulate::{TriangulateError, TriangulateOptions, Triangulation, triangulate};
use serde::Serialize;
use thiserror::Error;

use crate::io::tags::Unkept;
use crate::io::{Cage, Limits, ReadError, obj};

/// An artist's control cage that comes with the engine: 188 vertices, faces of three to five sides.
/// Keenan Crane's Spot, in the public domain.
///
/// # Errors
/// None, as long as the file that was built in is what it should be.
pub fn spot() -> Result<Cage, LimitError> {
    let polygons = obj::read(include_bytes!("../../data/cages/spot_control_mesh.obj"), &Limits::default())?;
    Ok(Cage::from_polygons(polygons)?)
}

/// Why there is no limit surface.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LimitError {
    /// The file.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The file that was built in.
    #[error(transparent)]
    Obj(#[from] obj::ObjError),
    /// The cage.
    #[error(transparent)]
    Cage(#[from] crate::io::CageError),
    /// The cage's triangles.
    #[error("the cage has {} faults, the first: {}", .0.len(), .0[0])]
    Faulty(Vec<Fault>),
    /// The triangulation.
    #[error(transparent)]
    Triangulate(#[from] TriangulateError),
}

/// A limit surface with its triangles.
#[derive(Clone, Debug)]
pub struct Limit {
    /// The surface: plain borders, corners where the cage declares them.
    pub surface: LoopSurface,
    /// Its triangles.
    pub triangulation: Triangulation,
}

/// The limit surface of `cage`, triangulated.
///
/// # Errors
/// [`LimitError::Faulty`] for a cage that was not made by this engine's readers, and
/// [`LimitError::Triangulate`].
pub fn limit(cage: &Cage, options: &TriangulateOptions) -> Result<Limit, LimitError> {
    let mesh = Connectivity::new(cage.positions.len(), &cage.triangles).map_err(LimitError::Faulty)?;
    let surface = LoopSurface::plain(Arc::new(mesh), cage.positions.clone(), &cage.corners);
    let triangulation = triangulate(&surface, options)?;
    Ok(Limit { surface, triangulation })
}

/// What became of a cage and of its tags, in figures.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LimitRow {
    /// Of the cage.
    pub name: String,
    /// At how many border vertices the border has a corner.
    pub corners_kept: usize,
    /// How many edges were to be creases; all are smooth.
    pub creases_reported: usize,
    /// All that the file asked for and that the surface does not have, each in words.
    pub not_kept: Vec<String>,
    /// How many control points there are.
    pub control_points: usize,
    /// How many triangles the cage was cut into.
    pub cage_triangles: usize,
    /// How many vertices the triangulation of the limit surface has.
    pub vertices: usize,
    /// How many triangles it has.
    pub triangles: usize,
    /// The distance to the limit surface that was asked for, in model units; none where levels were.
    pub chord_asked: Option<f64>,
    /// The distance that was measured.
    pub chord_achieved: Option<f64>,
    /// At how many points.
    pub chord_samples: Option<usize>,
    /// The worst shape of a triangle, as in
    /// [`TriangulationReport`](selvedge_components::triangulation::TriangulationReport).
    pub worst_shape: f64,
}

impl LimitRow {
    /// The figures of `limit`, which was made of `cage`.
    pub fn new(name: impl Into<String>, cage: &Cage, limit: &Limit) -> Self {
        let (unkept, report) = (&cage.import.unkept, &limit.triangulation.report);
        let chord = |number: fn(&ChordReport) -> f64| report.chord.as_ref().map(number);
        Self {
            name: name.into(),
            corners_kept: cage.corners.len(),
            creases_reported: unkept.iter().filter(|what| matches!(what, Unkept::Crease(_))).count(),
            not_kept: unkept.iter().map(ToString::to_string).collect(),
            control_points: cage.positions.len(),
            cage_triangles: cage.triangles.len(),
            vertices: limit.triangulation.triangles.positions.len(),
            triangles: limit.triangulation.triangles.triangles.len(),
            chord_asked: chord(|chord| chord.asked),
            chord_achieved: chord(|chord| chord.achieved),
            chord_samples: report.chord.as_ref().map(|chord| chord.samples),
            worst_shape: report.worst_shape,
        }
    }
}
