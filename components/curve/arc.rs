//! A part of a circle.

use core::f64::consts::TAU;

use glam::DVec3;

use super::circle::Frame;
use super::{Curve, Extent, ShapeError, angle, canonical};

/// A part of a circle, less than a full turn, at constant speed.
///
/// ```
/// use core::f64::consts::FRAC_PI_2;
/// use glam::DVec3;
/// use selvedge_components::curve::{CircularArc, Curve};
///
/// let quarter = CircularArc::from_axes(DVec3::ZERO, DVec3::X, DVec3::Y, 2.0, 0.0, FRAC_PI_2)?;
/// assert_eq!(quarter.position(0.0), 2.0 * DVec3::X);
/// assert!(quarter.position(1.0).distance(2.0 * DVec3::Y) < 1e-15);
/// # Ok::<(), selvedge_components::curve::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CircularArc {
    /// Turned so that the arc begins at angle 0.
    frame: Frame,
    sweep: f64,
}

impl CircularArc {
    /// The arc about `centre` that begins at the angle `from`, counted from the direction `x`
    /// towards `y`, and turns by `sweep`, both in radians; a negative sweep turns the other way.
    /// The axes need not be of unit length, nor perpendicular.
    ///
    /// # Errors
    /// [`ShapeError::OutOfRange`] unless `from` is finite and `0 < |sweep| < 2 pi` (a full turn
    /// is a [`Circle`](super::Circle)), and as [`Circle::from_axes`](super::Circle::from_axes).
    pub fn from_axes(
        centre: DVec3,
        x: DVec3,
        y: DVec3,
        radius: f64,
        from: f64,
        sweep: f64,
    ) -> Result<Self, ShapeError> {
        Self::build(Frame::from_axes(centre, x, y, radius)?, from, sweep)
    }

    /// The arc about `centre` that begins at `start` and turns by `sweep` radians about `normal`,
    /// counter-clockwise as seen from its tip. `start` is met exactly if `normal` is perpendicular
    /// to its arm up to rounding; else it is moved into the plane across `normal`.
    ///
    /// # Errors
    /// As [`CircularArc::from_axes`]; [`ShapeError::OutOfRange`] for the radius if `start` lies on the axis.
    pub fn about(centre: DVec3, normal: DVec3, start: DVec3, sweep: f64) -> Result<Self, ShapeError> {
        let unit = normal.try_normalize().ok_or(ShapeError::NoDirection { what: "the normal", vector: normal })?;
        let arm = start - centre;
        let x = arm - unit * arm.dot(unit);
        let frame = Frame::from_axes(centre, x, unit.cross(x), x.length())?;
        Self::build(Frame { x, y: unit.cross(x), ..frame }, 0.0, sweep)
    }

    fn build(frame: Frame, from: f64, sweep: f64) -> Result<Self, ShapeError> {
        if !from.is_finite() {
            let (what, limit) = ("the angle that the arc begins at", f64::MAX);
            return Err(ShapeError::OutOfRange { what, value: from, from: -limit, to: limit });
        }
        if !(sweep != 0.0 && sweep.abs() < TAU) {
            return Err(ShapeError::OutOfRange { what: "the sweep of an arc", value: sweep, from: -TAU, to: TAU });
        }
        let (sin, cos) = angle::sin_cos(from);
        let x = frame.x * cos + frame.y * sin;
        let y = frame.y * cos - frame.x * sin;
        Ok(Self { frame: Frame { x, y, ..frame }, sweep })
    }
}

impl Curve for CircularArc {
    fn position(&self, u: f64) -> DVec3 {
        self.frame.at(angle::sin_cos(self.sweep * canonical(u, Extent::Open)))
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.sweep * self.frame.velocity(angle::sin_cos(self.sweep * canonical(u, Extent::Open)))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::curve::testing::{assert_derivative_is_of_second_order, bits, config, point};

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn every_point_lies_on_the_circle_at_its_angle(
            centre in point(), x in point(), y in point(), radius in 1e-3..1e3,
            from in -9.0..9.0, sweep in -6.2..6.2, u in 0.0..=1.0,
        ) {
            prop_assume!(x.normalize().cross(y.normalize()).length() > 1e-2 && sweep != 0.0);
            let arc = CircularArc::from_axes(centre, x, y, radius, from, sweep).expect("an arc");
            let arm = arc.position(u) - centre;
            prop_assert!((arm.length() - radius).abs() < 4.0 * f64::EPSILON * (radius + centre.length()));
            let x = x.normalize();
            let y = (y - x * y.dot(x)).normalize();
            let (s, c) = f64::sin_cos(from + sweep * u);
            prop_assert!(arm.distance(radius * (c * x + s * y)) < 1e-12 * (radius + centre.length()));
            prop_assert!((arc.derivative(u).length() - radius * sweep.abs()).abs() < 1e-13 * radius);
        }

        #[test]
        fn an_arc_about_an_axis_begins_at_its_start(centre in point(), x in point(), other in point(), sweep in 0.1..6.2) {
            let normal = x.cross(other);
            prop_assume!(normal.length() > 1e-2);
            let arc = CircularArc::about(centre, normal, centre + x, sweep).expect("an arc");
            prop_assert!(arc.position(0.0).distance(centre + x) < 1e-14);
            prop_assert!(arc.position(0.01).distance(centre + x) > 0.0);
            prop_assert!(x.cross(arc.position(0.01) - centre).dot(normal) > 0.0);
        }
    }

    #[test]
    fn it_begins_to_the_bit_where_its_axis_points() {
        let arc = CircularArc::from_axes(DVec3::ONE, DVec3::X, DVec3::Y, 0.3, 0.0, 1.0).expect("an arc");
        assert_eq!(bits(arc.position(0.0)), bits(DVec3::ONE + DVec3::X * 0.3));
    }

    #[test]
    fn derivative_agrees_with_differences_to_second_order() {
        let arc = CircularArc::from_axes(DVec3::ONE, DVec3::X, DVec3::ONE, 2.0, 0.4, -5.0).expect("an arc");
        for k in 1..20 {
            assert_derivative_is_of_second_order(&arc, f64::from(k) / 20.0);
        }
    }

    #[test]
    fn what_makes_no_arc_is_refused() {
        for sweep in [0.0, TAU, -TAU, 7.0, f64::NAN, f64::INFINITY] {
            let arc = CircularArc::from_axes(DVec3::ZERO, DVec3::X, DVec3::Y, 1.0, 0.0, sweep);
            assert!(matches!(arc, Err(ShapeError::OutOfRange { .. })), "{sweep}");
        }
        let arc = CircularArc::from_axes(DVec3::ZERO, DVec3::X, DVec3::Y, 1.0, f64::NAN, 1.0);
        assert!(matches!(arc, Err(ShapeError::OutOfRange { .. })));
        let arc = CircularArc::about(DVec3::ZERO, DVec3::Z, 3.0 * DVec3::Z, 1.0);
        assert!(arc.is_err(), "{arc:?}");
    }
}
