//! Directions: the tangent on either side of a place, and how far the curve turns there.

use glam::DVec3;

use super::difference::piece;
use super::{Curve, angle, wrap};

/// By how much the tangent must turn, in radians, for a join to be a corner: one degree.
///
/// Below it lie the kinks that data acquire by rounding (a control arm of 50 units on an integer
/// grid, as in fonts, is off by up to `atan(0.5 / 50)`, 0.6 degrees), above it those that are drawn.
pub const CORNER_TURN: f64 = core::f64::consts::PI / 180.0;

/// One of the two branches of a curve that meet at a place, in the direction of rising parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Branch {
    /// Where the curve comes from.
    Before,
    /// Where it goes.
    After,
}

/// How far from a place with a vanishing derivative the curve is looked at, in parameter. The
/// direction is extrapolated with an error of order `REACH^2`, 6e-8; at a tenth of it a curve that
/// starts like `u^3` would be lost in rounding.
const REACH: f64 = 1.0 / 4096.0;

/// The unit tangent of `curve` at `u`, from one side; at the ends of an open curve from the side
/// there is. `None` if the curve stands still there or is not finite.
///
/// Where the derivative vanishes but the curve moves on, as at a doubled control point, the
/// direction is the limit of chords. The curve is called as it is; put a black box under
/// [`GuardedCurve`](super::GuardedCurve) first.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{Bezier, Branch, tangent};
///
/// let stop = Bezier::new(vec![DVec3::ZERO, DVec3::ZERO, DVec3::X, DVec3::ONE])?;
/// let start = tangent(&stop, 0.0, Branch::After).unwrap();
/// assert!((start - DVec3::X).length() < 1e-6);
/// # Ok::<(), selvedge_components::curve::ShapeError>(())
/// ```
pub fn tangent(curve: &dyn Curve, u: f64, branch: Branch) -> Option<DVec3> {
    let derivative = match branch {
        Branch::After => curve.derivative(u),
        Branch::Before => curve.derivative_before(u),
    };
    let step = step(curve, u, branch);
    let far = chord(curve, u, step);
    // A regular point moves on as its derivative says; where it moves four times as far, the
    // derivative is not what carries it.
    if 4.0 * derivative.length() * step.abs() >= far.length() {
        return derivative.try_normalize();
    }
    let near = chord(curve, u, step / 2.0);
    let limit = 2.0 * near.try_normalize()? - far.try_normalize()?;
    Some(limit.try_normalize()? * step.signum())
}

/// The angle by which `curve` turns at `u`, in radians in [0, pi]: 0 where it is smooth, pi at a
/// cusp. `None` where a tangent is missing. At the ends of an open curve it is 0.
pub fn turn(curve: &dyn Curve, u: f64) -> Option<f64> {
    Some(angle::between(tangent(curve, u, Branch::Before)?, tangent(curve, u, Branch::After)?))
}

/// A short way along the curve on the given side of `u`, within the smooth piece there, and turned
/// round where an open curve ends.
fn step(curve: &dyn Curve, u: f64, branch: Branch) -> f64 {
    let (from, to) = piece(curve, u, branch);
    let (back, on) = (REACH.min(u - from), REACH.min(to - u));
    match branch {
        Branch::After if on > 0.0 => on,
        Branch::Before if back <= 0.0 => on,
        _ => -back,
    }
}

fn chord(curve: &dyn Curve, u: f64, step: f64) -> DVec3 {
    let end = if curve.closed() { wrap(u + step) } else { u + step };
    curve.position(end) - curve.position(u)
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{PI, TAU};

    use super::*;
    use crate::curve::{FnCurve, Polyline, ShapeError};

    #[test]
    fn a_cusp_turns_by_half_a_turn_and_a_smooth_point_not_at_all() {
        let cusp = FnCurve::new(|u| DVec3::new((u - 0.5).powi(2), (u - 0.5).powi(3), 0.0));
        let turned = turn(&cusp, 0.5).expect("the cusp has tangents");
        assert!((turned - PI).abs() < 1e-5, "{turned}");
        assert!(turn(&cusp, 0.25).expect("smooth") < 1e-9);
        assert_eq!(turn(&cusp, 0.0), Some(0.0));
        assert_eq!(turn(&cusp, 1.0), Some(0.0));
    }

    #[test]
    fn a_polygon_turns_by_its_exterior_angles() -> Result<(), ShapeError> {
        for n in 3..40 {
            let exterior = TAU / f64::from(n);
            let vertex = |k: i32| DVec3::new((exterior * f64::from(k)).cos(), (exterior * f64::from(k)).sin(), 1.0);
            let polygon = Polyline::closed((0..n).map(vertex).collect())?;
            assert_eq!(polygon.corners().len(), n as usize);
            for &u in polygon.corners() {
                let turned = turn(&polygon, u).expect("segments have tangents");
                assert!((turned - exterior).abs() < 1e-12, "{n} {u} {turned}");
            }
        }
        Ok(())
    }

    #[test]
    fn a_curve_that_stands_still_has_no_tangent() {
        assert_eq!(tangent(&FnCurve::new(|_| DVec3::ONE), 0.4, Branch::After), None);
        assert_eq!(tangent(&FnCurve::new(|_| DVec3::NAN), 0.4, Branch::Before), None);
    }
}
