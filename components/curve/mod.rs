//! Curves in space: what a surface is trimmed by, and what its border can be.
//!
//! | curve | what |
//! | --- | --- |
//! | [`Segment`], [`Polyline`] | straight |
//! | [`Circle`], [`CircularArc`] | round |
//! | [`Bezier`], [`BSpline`] | polynomial and rational, of any degree up to [`MAX_DEGREE`] |
//! | [`Concatenation`], [`Reversed`] | made of other curves |
//! | [`FnCurve`] | any closure: a black box |
//!
//! | and | what |
//! | --- | --- |
//! | [`CurveParameters`] | the hierarchy of parameters that every surface along a curve shares |
//! | [`RememberedCurve`] | a curve that is dear to evaluate, each parameter once |
//! | [`GuardedCurve`] | a curve that may panic, call forever or be not finite, called safely |
//! | [`faults()`], [`find_corners()`] | everything wrong with a curve; the corners of a black box |
//! | [`tangent()`], [`turn()`], [`length()`] | what is asked of curves everywhere |
//!
//! Evaluation allocates nothing. It uses no platform `sin` or `cos` and no fused operations, so
//! that samples, which surfaces share, have the same bits on every machine of IEEE arithmetic.

mod angle;
mod arc;
mod bezier;
mod bspline;
mod check;
mod circle;
mod closure;
mod concatenation;
mod corners;
mod difference;
mod error;
mod guard;
mod length;
mod net;
mod parameters;
mod polyline;
mod remembered;
mod reversed;
mod segment;
mod space_curve;
mod tangent;

use core::fmt::Debug;
use core::ops::{Add, Mul, Sub};
use std::sync::Arc;

use glam::DVec3;

pub use arc::CircularArc;
pub use bezier::Bezier;
pub use bspline::BSpline;
pub use check::{Check, CurveFault, faults};
pub use circle::Circle;
pub use closure::FnCurve;
pub use concatenation::Concatenation;
pub use corners::{Corner, find_corners};
pub use error::{CurveError, ParameterError, ShapeError};
pub use guard::{EvaluationBudget, GuardedCurve, evaluate};
pub use length::length;
pub use net::MAX_DEGREE;
pub use parameters::{CurveParameters, Heading, Traversal};
pub use polyline::Polyline;
pub use remembered::RememberedCurve;
pub use reversed::Reversed;
pub use segment::Segment;
pub use space_curve::SpaceCurve;
pub use tangent::{Branch, CORNER_TURN, tangent, turn};

/// A piecewise smooth curve in space, evaluated at a parameter `u` in [0, 1].
///
/// [`Curve::position`] is all that it takes: a curve is a black box to every stage. An
/// implementation must be a pure function of `u` (the same bits for the same `u`, always), or
/// raise [`Curve::revision`] when it changes. The curves of this module read a parameter outside
/// [0, 1] as the nearer end.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::Curve;
///
/// #[derive(Debug)]
/// struct Helix;
///
/// impl Curve for Helix {
///     fn position(&self, u: f64) -> DVec3 {
///         DVec3::new((9.0 * u).cos(), (9.0 * u).sin(), u)
///     }
/// }
///
/// assert!((Helix.derivative(0.5).z - 1.0).abs() < 1e-11);
/// ```
pub trait Curve: Debug + Send + Sync {
    /// The point at `u` in [0, 1], in model units.
    fn position(&self, u: f64) -> DVec3;

    /// The derivative with respect to `u`, in model units per unit of `u`; one-sided where the
    /// curve has a corner: from the right, and at 1 from the left.
    ///
    /// By default a difference of fourth order over five points, which crosses no declared
    /// corner and no open end.
    fn derivative(&self, u: f64) -> DVec3 {
        let branch = if u < 1.0 { Branch::After } else { Branch::Before };
        difference::difference(self, u, branch)
    }

    /// The derivative from the left; at 0 of an open curve from the right. It differs from
    /// [`Curve::derivative`] at corners only.
    ///
    /// By default a difference at declared corners, and [`Curve::derivative`] elsewhere.
    fn derivative_before(&self, u: f64) -> DVec3 {
        if u <= 0.0 && self.closed() {
            self.derivative(1.0)
        } else if self.corners().contains(&u) {
            difference::difference(self, u, Branch::Before)
        } else {
            self.derivative(u)
        }
    }

    /// The parameters inside (0, 1), ascending, where the tangent turns at once; a closed curve
    /// that has a corner where it begins lists 0.
    fn corners(&self) -> &[f64] {
        &[]
    }

    /// Does the curve end where it begins, and run on from there?
    fn closed(&self) -> bool {
        false
    }

    /// Rises whenever the curve has become another one.
    fn revision(&self) -> u64 {
        0
    }
}

macro_rules! forward {
    ($($owner:ty),*) => {$(
        impl<C: Curve + ?Sized> Curve for $owner {
            fn position(&self, u: f64) -> DVec3 {
                (**self).position(u)
            }

            fn derivative(&self, u: f64) -> DVec3 {
                (**self).derivative(u)
            }

            fn derivative_before(&self, u: f64) -> DVec3 {
                (**self).derivative_before(u)
            }

            fn corners(&self) -> &[f64] {
                (**self).corners()
            }

            fn closed(&self) -> bool {
                (**self).closed()
            }

            fn revision(&self) -> u64 {
                (**self).revision()
            }
        }
    )*};
}

forward!(&C, Box<C>, Arc<C>);

/// Does a curve, or a part of one, come back to where it begins?
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Extent {
    /// It has two ends.
    Open,
    /// It ends where it begins and runs on from there.
    Closed,
}

impl Extent {
    /// The extent of a curve as a whole, as the curve declares it.
    pub fn of(curve: &dyn Curve) -> Self {
        if curve.closed() { Self::Closed } else { Self::Open }
    }
}

/// The parameter in [0, 1) that means the same place of a closed curve as `u`.
///
/// ```
/// # use selvedge_components::curve::wrap;
/// assert_eq!(wrap(1.25), 0.25);
/// assert_eq!(wrap(-0.25), 0.75);
/// assert_eq!(wrap(-1e-300), 0.0); // 1 - 1e-300 rounds to 1, which is 0
/// ```
pub fn wrap(u: f64) -> f64 {
    let inside = u - u.floor();
    if inside >= 1.0 { 0.0 } else { inside }
}

/// `u` moved into [0, 1] and, on a closed curve, 1 onto 0. What is not a number stays so.
fn canonical(u: f64, extent: Extent) -> f64 {
    let inside = u.clamp(0.0, 1.0);
    if extent == Extent::Closed && inside == 1.0 { 0.0 } else { inside }
}

/// The point at share `t` of the way from `a` to `b`: exact at both ends, constant where `a` and
/// `b` agree, and the same bits for `b`, `a` and `1 - t`.
fn mix<T>(a: T, b: T, t: f64) -> T
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    if t < 0.5 {
        a + (b - a) * t
    } else if t == 0.5 {
        (a + b) * 0.5
    } else {
        b + (a - b) * (1.0 - t)
    }
}

#[cfg(test)]
mod testing;
