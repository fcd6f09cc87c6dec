//! Why a surface could not be remeshed: what, where and by how much.

use glam::DVec3;
use thiserror::Error;

use crate::curve::ParameterError;
use crate::evaluate::SurfacePoint;
use crate::mesh::{Fault, VertexId};
use crate::target::TargetError;

/// A curve has no usable pre-image on the surface.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PreImageError {
    /// The curve gave no finite point.
    #[error("the curve is not finite at u = {u}: {at}")]
    NotFinite {
        /// The parameter.
        u: f64,
        /// What the curve gave.
        at: DVec3,
    },
    /// The surface gave no closest point.
    #[error("no closest point at u = {u}: {source}")]
    Target {
        /// The parameter.
        u: f64,
        /// Why.
        source: TargetError,
    },
    /// The closest point came without a place on the surface.
    #[error("the surface gave no place for the curve at u = {u}")]
    NoPlace {
        /// The parameter.
        u: f64,
    },
    /// The curve lies farther off the surface than is allowed.
    #[error("the curve lies {distance} off the surface at u = {u}, {at}: more than {limit}")]
    TooFarOff {
        /// The parameter where it is farthest, of those that were looked at.
        u: f64,
        /// The curve's point.
        at: DVec3,
        /// Its distance from the surface, in model units.
        distance: f64,
        /// The greatest that is allowed.
        limit: f64,
    },
    /// The curve runs off the surface across a border.
    #[error("the curve leaves the surface across a border at u = {u}, {at}: it is {distance} off there")]
    LeavesSurface {
        /// A parameter outside.
        u: f64,
        /// The curve's point.
        at: DVec3,
        /// Its distance from the surface, in model units.
        distance: f64,
    },
    /// An open curve begins or ends on the surface, where it must run round or from border to border.
    #[error("the curve is open and ends on the surface at u = {u}, {at}: its ends lie {gap} apart")]
    EndsInside {
        /// The parameter of the end.
        u: f64,
        /// The curve's point there.
        at: DVec3,
        /// The distance of its ends, in model units.
        gap: f64,
    },
    /// Neighbouring points of the curve are closest to places that do not meet.
    #[error("the place of the curve on the surface is ambiguous near u = {u}, {at}: it jumps from face {} to face {}", .places[0].face, .places[1].face)]
    Ambiguous {
        /// The parameter.
        u: f64,
        /// The curve's point.
        at: DVec3,
        /// The places on both sides of the jump.
        places: [SurfacePoint; 2],
    },
    /// The curve has no length.
    #[error("the curve has no length: all of it lies within {length} of {at}")]
    NoLength {
        /// A point of it.
        at: DVec3,
        /// The length found.
        length: f64,
    },
    /// The pre-image crosses itself or another one.
    #[error("the pre-images cross at {at}: u = {} of curve {} and u = {} of curve {}", .u[0], .curves[0], .u[1], .curves[1])]
    Crossing {
        /// The two curves, by index; the same one twice if it crosses itself.
        curves: [usize; 2],
        /// Their parameters.
        u: [f64; 2],
        /// The point of the first curve.
        at: DVec3,
    },
    /// A given point of a pre-image is not near the curve.
    #[error("the given pre-image lies {distance} off the curve at point {index}, u = {u}, {at}: more than {limit}")]
    GivenOff {
        /// The point of the given pre-image.
        index: usize,
        /// Its parameter.
        u: f64,
        /// The curve's point.
        at: DVec3,
        /// The distance of the place from it, in model units.
        distance: f64,
        /// The greatest that is allowed.
        limit: f64,
    },
    /// A given pre-image does not run along the curve, or skips over faces.
    #[error("the given pre-image is not usable at point {index}: {reason}")]
    BadGiven {
        /// The point of the pre-image.
        index: usize,
        /// What is wrong.
        reason: &'static str,
    },
}

/// A cut could not be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RemeshError {
    /// A curve has no usable pre-image.
    #[error("curve {curve}: {source}")]
    PreImage {
        /// The curve, by index.
        curve: usize,
        /// Why.
        source: PreImageError,
    },
    /// There is nothing to cut with.
    #[error("there is no curve to cut with")]
    NoCurves,
    /// The curve is open where it must be closed.
    #[error("curve {curve} is open: its ends lie {gap} apart")]
    Open {
        /// The curve, by index.
        curve: usize,
        /// The distance of its ends, in model units.
        gap: f64,
    },
    /// Both sides of the curves are the same part of the surface.
    #[error("curve {curve} does not separate the surface: the part at {at} lies on both of its sides")]
    DoesNotSeparate {
        /// A curve that has the part on both sides, by index.
        curve: usize,
        /// A point of the part.
        at: DVec3,
    },
    /// Nothing is left: what lies on the left of this curve lies on the right of others.
    #[error("nothing is left of the surface: what curve {curve} leaves, others take away")]
    NothingLeft {
        /// A curve of the newest set that is in the way, by index.
        curve: usize,
    },
    /// The cage would have to be finer than was allowed, or than faces can be addressed. What bends as
    /// sharply may be a corner of the curve instead; a source of smaller faces has smaller ones there.
    #[error(
        "the cage would have to be finer than level {limit} at {at} (curve {curve}, u = {u}), where its faces are {size:e} wide: {what}"
    )]
    TooFine {
        /// What they cannot follow.
        what: &'static str,
        /// How wide faces of the finest level are there, in model units.
        size: f64,
        /// The finest level.
        limit: u32,
        /// The curve that asks for it, by index.
        curve: usize,
        /// Where on it.
        u: f64,
        /// The point.
        at: DVec3,
    },
    /// The cage would have more faces than it may.
    #[error("the cage would have {faces} faces at level {level}, more than the {limit} allowed")]
    TooManyFaces {
        /// The level at which it passes the limit.
        level: u32,
        /// How many faces it would have.
        faces: usize,
        /// How many it may have.
        limit: usize,
    },
    /// Two curves cross, but do not meet: where they come nearest they are too far apart.
    #[error("curves {} and {} cross at {at}, u = {} and {}, but pass {gap} apart there: more than {limit}", .curves[0], .curves[1], .u[0], .u[1])]
    Gap {
        /// The curves, by index, the older first.
        curves: [usize; 2],
        /// Their parameters.
        u: [f64; 2],
        /// The point of the older.
        at: DVec3,
        /// Their distance, in model units.
        gap: f64,
        /// The greatest that is allowed.
        limit: f64,
    },
    /// A curve leaves the source across a border, but does not meet it: where they come nearest they
    /// are too far apart.
    #[error("curve {curve} crosses the border at {at}, u = {u}, but passes {gap} from it: more than {limit}")]
    BorderGap {
        /// The curve, by index.
        curve: usize,
        /// Its parameter.
        u: f64,
        /// The border's point.
        at: DVec3,
        /// Their distance, in model units.
        gap: f64,
        /// The greatest that is allowed.
        limit: f64,
    },
    /// A curve leaves the source across a border at so small an angle that no triangle fits between.
    #[error("curve {curve} crosses the border at {at}, u = {u}, at an angle of {angle} degrees: less than {limit}")]
    AlongBorder {
        /// The curve, by index.
        curve: usize,
        /// Its parameter.
        u: f64,
        /// The border's point.
        at: DVec3,
        /// The angle, in degrees.
        angle: f64,
        /// The smallest that is allowed.
        limit: f64,
    },
    /// A curve comes to a border of the source and goes back from there: what it leaves would hang together
    /// by one point.
    #[error("curve {curve} touches the border at {at}, u = {u}, and goes back from there")]
    TouchesBorder {
        /// The curve, by index.
        curve: usize,
        /// Its parameter.
        u: f64,
        /// The border's point.
        at: DVec3,
    },
    /// Two curves cross at so small an angle that no triangle fits between them, or run along each
    /// other.
    #[error("curves {} and {} cross at {at}, u = {} and {}, at an angle of {angle} degrees: less than {limit}", .curves[0], .curves[1], .u[0], .u[1])]
    Tangential {
        /// The curves, by index, the older first.
        curves: [usize; 2],
        /// Their parameters.
        u: [f64; 2],
        /// The point of the older.
        at: DVec3,
        /// The angle, in degrees.
        angle: f64,
        /// The smallest that is allowed.
        limit: f64,
    },
    /// Two curves run along each other for a while.
    #[error("curves {} and {} run along each other at {at}, u = {} and {}, {distance} apart", .curves[0], .curves[1], .u[0], .u[1])]
    Coincident {
        /// The curves, by index, the older first.
        curves: [usize; 2],
        /// The parameters of a place where they do.
        u: [f64; 2],
        /// The point of the older.
        at: DVec3,
        /// Their distance, in model units.
        distance: f64,
    },
    /// Places where curves cross lie too near to each other to be told apart.
    #[error("curve {curve} crosses others twice at {at}, u = {u}: the places cannot be told apart")]
    Tangled {
        /// The curve, by index.
        curve: usize,
        /// Where on it.
        u: f64,
        /// The point.
        at: DVec3,
    },
    /// A curve turns back on itself.
    #[error("curve {curve} has a cusp at {at}, u = {u}: its sides meet at {angle} degrees, less than {limit}")]
    Cusp {
        /// The curve, by index.
        curve: usize,
        /// Where on it.
        u: f64,
        /// The point.
        at: DVec3,
        /// The angle between its sides, in degrees.
        angle: f64,
        /// The smallest that is allowed.
        limit: f64,
    },
    /// Two boundaries come too near to each other, or to a border, to be told apart at the finest
    /// level tried.
    #[error("the cage at {at} (curve {curve}, u = {u}) is still {what} after {tries} tries, the last at level {level}")]
    Unresolved {
        /// What is wrong there.
        what: &'static str,
        /// The curve, by index.
        curve: usize,
        /// Where on it.
        u: f64,
        /// The point.
        at: DVec3,
        /// How often it was refined.
        tries: u32,
        /// The finest level tried.
        level: u32,
    },
    /// The change cannot be kept within the distance asked for.
    #[error("the cage changes up to {distance} from the curves, at {at}, where only {reach} is allowed")]
    OutOfReach {
        /// How far the change goes, in model units.
        distance: f64,
        /// Where.
        at: DVec3,
        /// How far it may go.
        reach: f64,
    },
    /// A vertex of the source is not finite.
    #[error("the source is not finite at {vertex}: {at}")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its limit point.
        at: DVec3,
    },
    /// The parameters found along a side of the source that was refined make no sound list.
    #[error("the parameters along side {side} of the source are not sound at u = {u}, {at}: {source}")]
    Parameters {
        /// The source's side, by index.
        side: usize,
        /// The parameter.
        u: f64,
        /// The border's point.
        at: DVec3,
        /// Why.
        source: ParameterError,
    },
    /// The new cage is no manifold: a defect of this engine, never passed on as a mesh.
    #[error("the new cage is not a manifold: {}", .faults.first().map_or_else(String::new, ToString::to_string))]
    NotManifold {
        /// Everything that is wrong with it.
        faults: Vec<Fault>,
    },
}
