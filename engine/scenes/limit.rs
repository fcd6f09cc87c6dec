//! A control cage and its limit surface.

use std::sync::Arc;

use selvedge_components::mesh::{Connectivity, Fault};
use selvedge_components::subdivision::LoopSurface;
use selvedge_systems::triangulate::{TriangulateError, TriangulateOptions, Triangulation, triangulate};
use thiserror::Error;

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
