//! What can go wrong with an entity, as a component on it: what, where, and by how much.

use bevy_ecs::prelude::{Component, Entity};
use glam::DVec3;
use thiserror::Error;

use crate::budget::BudgetExceeded;
use crate::curve::{CurveError, CurveFault};
use crate::mesh::{Fault, VertexId};
use crate::subdivision::Address;
use crate::subdivision::fit::{FitError, Outcome, Rung, Stage};

/// A defect of a surface, named by what it is and placed by index or entity.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SurfaceFault {
    /// The mesh or a control point is defective.
    #[error(transparent)]
    Mesh(#[from] Fault),
    /// The list of control points is longer or shorter than the mesh has vertices.
    #[error("{listed} control points are listed for {vertices} vertices")]
    PointCount {
        /// How many are listed.
        listed: usize,
        /// How many there must be.
        vertices: usize,
    },
    /// No entity is control point `index`: the one listed is gone, or says it is another.
    #[error("control point {index} is missing: {listed} does not stand for it")]
    PointMissing {
        /// The vertex.
        index: u32,
        /// The entity listed for it.
        listed: Entity,
    },
    /// An entity says that it is a control point of this surface, which does not list it.
    #[error("{entity} says it is control point {index}, but is not listed as such")]
    PointUnlisted {
        /// The entity.
        entity: Entity,
        /// Which control point it says it is.
        index: u32,
    },
    /// A border edge belongs to no side.
    #[error("border edge {}-{} belongs to no side", .ends[0], .ends[1])]
    SideMissing {
        /// The ends of the edge, the surface on the left.
        ends: [VertexId; 2],
    },
    /// A border edge belongs to more than one side.
    #[error("border edge {}-{} belongs to side {first} and to side {second}", .ends[0], .ends[1])]
    SideOverlap {
        /// The ends of the edge, the surface on the left.
        ends: [VertexId; 2],
        /// The side that came first.
        first: usize,
        /// The side that repeats it.
        second: usize,
    },
    /// A side goes where there is no border edge with the surface on its left.
    #[error("side {side} goes from vertex {} to {}, where no border edge runs that way", .ends[0], .ends[1])]
    SideOffBorder {
        /// The side.
        side: usize,
        /// The vertices that it names one after the other.
        ends: [VertexId; 2],
    },
    /// A side has too few vertices to have an edge.
    #[error("side {side} has {vertices} vertices, fewer than {least}")]
    SideTooShort {
        /// The side.
        side: usize,
        /// How many it has.
        vertices: usize,
        /// How many it must have.
        least: usize,
    },
    /// A side is longer than its curve's parameters from where it begins; or is closed, and the
    /// parameters do not go round with it.
    #[error("side {side} has {edges} edges along parameters that have {available} from where it begins")]
    SideParameters {
        /// The side.
        side: usize,
        /// How many edges it has.
        edges: usize,
        /// How many the parameters have.
        available: u64,
    },
    /// A side's curve gives no point at one of its vertices.
    #[error("side {side} has no point at vertex {vertex}: {why}")]
    SideCurve {
        /// The side.
        side: usize,
        /// The vertex.
        vertex: VertexId,
        /// What happened.
        why: CurveError,
    },
    /// Two detail coefficients sit at the same place.
    #[error("level {level} has more than one detail at {address:?}")]
    DetailTwice {
        /// The level.
        level: u32,
        /// The place.
        address: Address,
    },
    /// A detail coefficient sits at a level that is too fine to be addressed.
    #[error("detail at level {level}, finer than {finest}, the finest that this mesh can name")]
    DetailTooFine {
        /// The level.
        level: u32,
        /// The finest there may be.
        finest: u32,
    },
    /// A detail coefficient sits where its level has no vertex.
    #[error("level {level} has no vertex at {address:?}")]
    DetailNowhere {
        /// The level.
        level: u32,
        /// The place that there is not.
        address: Address,
    },
    /// A detail coefficient is NaN or infinite.
    #[error("the detail at {address:?} of level {level} is not finite: {value}")]
    DetailNotFinite {
        /// The level.
        level: u32,
        /// The place.
        address: Address,
        /// The vector.
        value: DVec3,
    },
    /// The surface is larger than allowed.
    #[error(transparent)]
    Budget(#[from] BudgetExceeded),
}

/// This surface is refused: nothing goes further with it until every fault is mended.
///
/// Written by the gather and check stages; removed by them once the surface is sound.
#[derive(Component, Clone, Debug, PartialEq, Error)]
#[error("{} faults, the first: {}", .0.len(), .0.first().map_or_else(String::new, ToString::to_string))]
pub struct SurfaceFailed(pub Vec<SurfaceFault>);

/// This curve is refused. Written by the check stage; removed by it once the curve is sound.
#[derive(Component, Clone, Debug, PartialEq, Error)]
#[error("{} faults, the first: {}", .0.len(), .0.first().map_or_else(String::new, ToString::to_string))]
pub struct CurveFailed(pub Vec<CurveFault>);

/// This curve is new or has changed, and waits to be checked: curves are checked some in a pass. Written and
/// removed by the check stage. Trims that read the curve wait for that, too.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CurveUnchecked;

/// Why a fitting job has no result.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FitFault {
    /// The entity to be fitted is no surface, or no longer.
    #[error("{surface} is not a surface")]
    NoSurface {
        /// The entity.
        surface: Entity,
    },
    /// The surface is refused.
    #[error("surface {surface} has {faults} faults")]
    SurfaceFailed {
        /// The surface.
        surface: Entity,
        /// How many faults it has.
        faults: usize,
    },
    /// The job has no [`FitTarget`](crate::job::FitTarget).
    #[error("the fit has no target")]
    NoTarget,
    /// The target panicked when it was asked whether it had changed.
    #[error("the target panicked when asked for its revision: {message}")]
    TargetRevision {
        /// What the panic said.
        message: String,
    },
    /// The options cannot be met, or a stage could not go on.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// A budget is spent.
    #[error(transparent)]
    Budget(#[from] BudgetExceeded),
    /// User code, or a stage, panicked where no place can be told.
    #[error("{stage} panicked: {message}")]
    Panicked {
        /// The stage.
        stage: Stage,
        /// What the panic said.
        message: String,
    },
    /// The fit went to its end, and the error that is left is above the tolerance.
    #[error("the fit ended above its tolerance: {outcome}")]
    NotReached {
        /// How it ended: what is left, and where.
        outcome: Outcome,
    },
}

/// This fit failed, and the surface is as it was. Written when the job ends; removed when it begins
/// again, which it does once something that it reads has changed.
#[derive(Component, Clone, Debug, PartialEq, Error)]
#[error("{why}")]
pub struct FitFailed {
    /// What happened.
    pub why: FitFault,
    /// The ladder as far as it went.
    pub ladder: Vec<Rung>,
}
