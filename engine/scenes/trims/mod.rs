//! Surfaces to be trimmed, curves to trim them by, and what a trim comes to.
//!
//! | module | what |
//! | --- | --- |
//! | [`ground`] | the surfaces: contoured plates and a contoured disc, ready to lay curves on |
//! | [`disc`] | how the disc is made |
//! | [`shapes`] | curves in the plane: holes, slots, stars, rounded outlines |
//! | [`subjects`] | the scenes: what is cut from what |
//! | [`run()`] | does the trims of a scene, one after the other, and measures what comes out |
//! | [`shared`] | the wall of a bore, along the same curve |
//! | [`row`] | the figures that the examples print |
//!
//! Every curve on a surface is a plane one carried there, a black box to the engine; none is known to
//! it as a formula. [Litke et al. 2001, Section 4]

pub mod disc;
pub mod ground;
pub mod measure;
pub mod row;
mod run;
pub mod shapes;
pub mod shared;
pub mod subjects;

use std::sync::Arc;

use selvedge_components::curve::{ParameterError, ShapeError};
use selvedge_components::mesh::Fault;
use selvedge_components::triangulation::TriangulateError;
use selvedge_components::trim::TrimFault;
use selvedge_systems::projected_curve::ProjectError;
use selvedge_systems::subdivision::limit::LimitError;
use selvedge_systems::subdivision::remesh::Cut;
use selvedge_systems::subdivision::trim::Ground;
use thiserror::Error;

pub use run::{Settings, Trimmed, run};

use self::row::Broken;
use crate::io::CageError;
use crate::io::obj::ObjError;

/// A surface and what is cut from it.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What it is called.
    pub name: String,
    /// The surface.
    pub ground: Arc<Ground>,
    /// The trims, in order; the curves of each act together.
    pub trims: Vec<Vec<Cut>>,
}

/// Why a scene could not be made or trimmed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TrimSceneError {
    /// The file of a plate.
    #[error(transparent)]
    Obj(#[from] ObjError),
    /// The cage of a plate.
    #[error(transparent)]
    Cage(#[from] CageError),
    /// The connectivity of a cage made in code.
    #[error("the cage has {} faults, the first: {}", .0.len(), .0[0])]
    Mesh(Vec<Fault>),
    /// A curve.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// The parameters along a curve.
    #[error(transparent)]
    Parameters(#[from] ParameterError),
    /// The projection of a curve.
    #[error(transparent)]
    Project(#[from] ProjectError),
    /// No side of what is left runs round.
    #[error("the trim has left no border that runs round")]
    NoRim,
    /// The limit surface of what is left.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// The trim.
    #[error(transparent)]
    Trim(#[from] TrimFault),
    /// The figures of what came out.
    #[error("{name}: {what}")]
    Broken {
        /// What was trimmed.
        name: String,
        /// What is not as promised.
        what: Broken,
    },
    /// The triangles of the result.
    #[error(transparent)]
    Triangulate(#[from] TriangulateError),
}
