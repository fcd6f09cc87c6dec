//! Why a trim has no result.

use bevy_ecs::prelude::{Component, Entity};
use glam::DVec3;
use thiserror::Error;

use super::TrimStage;
use crate::budget::BudgetExceeded;
use crate::curve::CurveFault;
use crate::subdivision::fit::{FitError, Outcome, Rung};
use crate::subdivision::remesh::RemeshError;

/// Why a trim has no result.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TrimFault {
    /// The entity to be trimmed is no surface, or no longer.
    #[error("{source_entity} is not a surface")]
    NoSource {
        /// The entity.
        source_entity: Entity,
    },
    /// The source is refused.
    #[error("source {source_entity} has {faults} faults")]
    SourceFailed {
        /// The source.
        source_entity: Entity,
        /// How many faults it has.
        faults: usize,
    },
    /// The source cannot be evaluated.
    #[error("the source cannot be evaluated: {why}")]
    Unevaluated {
        /// What its evaluation said.
        why: String,
    },
    /// An entity named as a curve has none.
    #[error("{curve} is not a curve")]
    NoCurve {
        /// The entity.
        curve: Entity,
    },
    /// A curve is refused.
    #[error("curve {curve} has {faults} faults, the first: {first}")]
    CurveFailed {
        /// The curve.
        curve: Entity,
        /// How many faults it has.
        faults: usize,
        /// The first of them.
        first: Box<CurveFault>,
    },
    /// A number of the options or the tolerance is not a positive distance.
    #[error("{what} is {value}, not a positive distance")]
    BadNumber {
        /// Which.
        what: &'static str,
        /// What it is.
        value: f64,
    },
    /// The tolerance is so small that rounding of the source's coordinates alone is above it.
    #[error("{what} is {value:e}, but coordinates of the source are rounded by up to {limit:e}")]
    BelowRounding {
        /// Which.
        what: &'static str,
        /// What it is, in model units.
        value: f64,
        /// The least that it may be.
        limit: f64,
    },
    /// A curve misses the source.
    #[error("curve {curve} does not meet the source within {limit}: at u = {u}, {at}, it is {distance} off")]
    Misses {
        /// The curve, by index.
        curve: usize,
        /// The parameter where it is nearest, of those looked at.
        u: f64,
        /// The curve's point.
        at: DVec3,
        /// How far off that is.
        distance: f64,
        /// How far off it may be.
        limit: f64,
    },
    /// A curve is smaller than the tolerance: nothing could be told apart along it.
    #[error("curve {curve} lies within {size} of {at}, the tolerance is {tolerance}")]
    TooSmall {
        /// The curve, by index.
        curve: usize,
        /// The diagonal of its box.
        size: f64,
        /// A point of it.
        at: DVec3,
        /// The tolerance.
        tolerance: f64,
    },
    /// The curves could not be worked into the cage.
    #[error(transparent)]
    Remesh(#[from] RemeshError),
    /// The details could not be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The fit went to its end, and the error that is left is above the tolerance.
    #[error("the fit ended above its tolerance: {outcome}")]
    NotReached {
        /// How it ended: what is left, and where.
        outcome: Outcome,
    },
    /// The audit found something wrong.
    #[error("the audit found {} faults, the first: {}", .faults.len(), .faults.first().map_or_else(String::new, ToString::to_string))]
    Audit {
        /// Everything that is wrong.
        faults: Vec<TrimAuditFault>,
    },
    /// What stays could be made, but not the other side, which was asked for, too.
    #[error("the other side: {why}")]
    OtherSide {
        /// What happened there.
        why: Box<TrimFault>,
    },
    /// A budget is spent.
    #[error(transparent)]
    Budget(#[from] BudgetExceeded),
    /// User code, or a stage, panicked where no place can be told.
    #[error("{stage} panicked: {message}")]
    Panicked {
        /// The stage.
        stage: TrimStage,
        /// What the panic said.
        message: String,
    },
}

/// One thing that an audit finds wrong with a trim, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TrimAuditFault {
    /// The result leaves the source, or the source what is left of it.
    #[error("{what} at {at} is {distance:e} off, more than {limit:e}")]
    Distance {
        /// From what to what.
        what: &'static str,
        /// The distance, in model units.
        distance: f64,
        /// What is allowed.
        limit: f64,
        /// Where.
        at: DVec3,
    },
    /// A face next to those that may change is not as it was.
    #[error("face {face} of the result has changed by {distance:e} at {at}, where nothing may change")]
    Outside {
        /// The face of the result.
        face: u32,
        /// How far its limit point has moved, in model units; 0 where only its origin is not what it
        /// should be.
        distance: f64,
        /// Where.
        at: DVec3,
    },
    /// Put together with what other trims have left, a face is not what its own trim made of it.
    #[error("face {face} of what all trims have left is {distance:e} off at {at} from what its own trim left")]
    Composed {
        /// The face of the result.
        face: u32,
        /// How far its limit point is off, in model units; NaN where it has none.
        distance: f64,
        /// Where.
        at: DVec3,
    },
    /// A border sample is not the curve's own.
    #[error("the border is at {at}, its curve at {sample} (u = {u}, side {side})")]
    OffCurve {
        /// The side, by index.
        side: usize,
        /// The curve's parameter.
        u: f64,
        /// The border's point.
        at: DVec3,
        /// The curve's value.
        sample: DVec3,
    },
    /// A border loop has other vertices than the sides that make it up.
    #[error("{edges} border edges, of which sides name {named}")]
    Border {
        /// Border edges of the result.
        edges: usize,
        /// Edges that sides name.
        named: usize,
    },
    /// Vertices, edges and faces do not add up to a surface of the source's kind.
    #[error("the Euler number is {euler} with {loops} border loops in {parts} parts")]
    Euler {
        /// Vertices - edges + faces.
        euler: i64,
        /// Border loops.
        loops: usize,
        /// Connected parts.
        parts: usize,
    },
    /// What is kept and what is removed do not make up the source.
    #[error("kept, cut and removed pieces cover face {face} of the source {share} times, not once")]
    Cover {
        /// The root face of the source.
        face: u32,
        /// The sum of their shares.
        share: f64,
    },
}

/// This trim failed; the source and the last good result are as they were. Removed when the trim
/// begins again, which it does once something that it reads has changed.
#[derive(Component, Clone, Debug, PartialEq, Error)]
#[error("{why}")]
pub struct TrimFailed {
    /// What happened.
    pub why: TrimFault,
    /// The other trim, where it is about curves of two: of [`Self::why`]'s two curves the first is
    /// that one's, the second this one's.
    pub with: Option<Entity>,
    /// The ladder as far as it went.
    pub ladder: Vec<Rung>,
}
