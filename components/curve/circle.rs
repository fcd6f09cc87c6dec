//! The full circle.

use core::f64::consts::TAU;

use glam::DVec3;

use super::{Curve, Extent, ShapeError, angle, canonical};

/// A centre and two perpendicular radii: the plane that circles and arcs turn in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub(super) centre: DVec3,
    /// From the centre to the point at angle 0.
    pub(super) x: DVec3,
    /// From the centre to the point a quarter of a turn on.
    pub(super) y: DVec3,
}

impl Frame {
    /// The frame with its first radius towards `x`, turning towards `y`; neither needs to be of
    /// unit length, nor `y` perpendicular.
    pub(super) fn from_axes(centre: DVec3, x: DVec3, y: DVec3, radius: f64) -> Result<Self, ShapeError> {
        checked(centre, radius)?;
        let unit = |what, vector: DVec3, of: DVec3| of.try_normalize().ok_or(ShapeError::NoDirection { what, vector });
        let first = unit("the first axis", x, x)?;
        let towards = unit("the second axis", y, y)?;
        let normal = first.cross(towards);
        // Two axes that are parallel up to rounding span no plane: what is left is noise.
        let parallel = normal.length() <= 4.0 * f64::EPSILON;
        let normal = unit("the second axis", y, if parallel { DVec3::ZERO } else { normal })?;
        Ok(Self { centre, x: first * radius, y: normal.cross(first) * radius })
    }

    /// The frame in the plane across `normal`, turning counter-clockwise as seen from its tip.
    pub(super) fn from_normal(centre: DVec3, normal: DVec3, radius: f64) -> Result<Self, ShapeError> {
        checked(centre, radius)?;
        let unit = normal.try_normalize().ok_or(ShapeError::NoDirection { what: "the normal", vector: normal })?;
        let x = unit.any_orthonormal_vector();
        Ok(Self { centre, x: x * radius, y: unit.cross(x) * radius })
    }

    pub(super) fn at(&self, (sin, cos): (f64, f64)) -> DVec3 {
        self.centre + (self.x * cos + self.y * sin)
    }

    /// The derivative by the angle.
    pub(super) fn velocity(&self, (sin, cos): (f64, f64)) -> DVec3 {
        self.y * cos - self.x * sin
    }
}

fn checked(centre: DVec3, radius: f64) -> Result<(), ShapeError> {
    if !centre.is_finite() {
        return Err(ShapeError::PointNotFinite { index: 0, at: centre });
    }
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(ShapeError::OutOfRange { what: "the radius", value: radius, from: 0.0, to: f64::MAX });
    }
    Ok(())
}

/// A full circle, once round at constant speed: closed and without corners.
///
/// Every point lies on the circle to rounding. Quarter turns are exact: `position(0.25)` is the
/// centre plus the second radius, to the bit.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{Circle, Curve};
///
/// let c = Circle::from_axes(DVec3::Z, DVec3::X, DVec3::Y, 2.0)?;
/// assert_eq!(c.position(0.25), DVec3::new(0.0, 2.0, 1.0));
/// assert!(c.closed());
/// # Ok::<(), selvedge_components::curve::ShapeError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Circle {
    frame: Frame,
}

impl Circle {
    /// The circle about `centre` in the plane across `normal`, counter-clockwise as seen from the
    /// tip of `normal`. Where it begins is chosen from the normal alone.
    ///
    /// # Errors
    /// [`ShapeError::OutOfRange`] for the radius, [`ShapeError::NoDirection`] for the normal,
    /// [`ShapeError::PointNotFinite`] for the centre.
    pub fn new(centre: DVec3, normal: DVec3, radius: f64) -> Result<Self, ShapeError> {
        Frame::from_normal(centre, normal, radius).map(|frame| Self { frame })
    }

    /// The circle that begins in direction `x` from the centre and turns towards `y`. The axes
    /// need not be of unit length, nor perpendicular.
    ///
    /// # Errors
    /// As [`Circle::new`]; [`ShapeError::NoDirection`] also for parallel axes.
    pub fn from_axes(centre: DVec3, x: DVec3, y: DVec3, radius: f64) -> Result<Self, ShapeError> {
        Frame::from_axes(centre, x, y, radius).map(|frame| Self { frame })
    }

    /// The centre, in model units.
    pub fn centre(&self) -> DVec3 {
        self.frame.centre
    }
}

impl Curve for Circle {
    fn position(&self, u: f64) -> DVec3 {
        self.frame.at(angle::sin_cos_turns(canonical(u, Extent::Closed)))
    }

    fn derivative(&self, u: f64) -> DVec3 {
        TAU * self.frame.velocity(angle::sin_cos_turns(canonical(u, Extent::Closed)))
    }

    fn closed(&self) -> bool {
        true
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
        fn every_point_lies_on_the_circle(centre in point(), normal in point(), radius in 1e-3..1e3, u in 0.0..1.0) {
            prop_assume!(normal.length() > 1e-3);
            let circle = Circle::new(centre, normal, radius).expect("a circle");
            let arm = circle.position(u) - centre;
            prop_assert!((arm.length() - radius).abs() < 4.0 * f64::EPSILON * (radius + centre.length()));
            prop_assert!(arm.dot(normal.normalize()).abs() < 4.0 * f64::EPSILON * (radius + centre.length()));
        }

        #[test]
        fn speed_is_the_circumference_and_across_the_radius(normal in point(), radius in 1e-3..1e3, u in 0.0..1.0) {
            prop_assume!(normal.length() > 1e-3);
            let circle = Circle::new(DVec3::ZERO, normal, radius).expect("a circle");
            let (arm, velocity) = (circle.position(u), circle.derivative(u));
            prop_assert!((velocity.length() / (TAU * radius) - 1.0).abs() < 1e-14);
            prop_assert!((arm.cross(velocity).normalize() - normal.normalize()).length() < 1e-14);
        }

        #[test]
        fn axes_are_made_perpendicular(x in point(), y in point(), radius in 0.1..10.0) {
            prop_assume!(x.normalize().cross(y.normalize()).length() > 1e-2);
            let circle = Circle::from_axes(DVec3::ZERO, x, y, radius).expect("a circle");
            prop_assert!(circle.position(0.0).distance(x.normalize() * radius) < 1e-14 * radius);
            prop_assert!(circle.position(0.25).dot(x).abs() < 1e-13 * radius);
            prop_assert!(circle.position(0.25).dot(y) > 0.0);
        }
    }

    #[test]
    fn it_closes_to_the_bit() {
        let circle = Circle::new(DVec3::new(0.1, 0.2, 0.3), DVec3::ONE, 0.7).expect("a circle");
        assert_eq!(bits(circle.position(0.0)), bits(circle.position(1.0)));
        assert_eq!(bits(circle.derivative(0.0)), bits(circle.derivative_before(0.0)));
    }

    #[test]
    fn derivative_agrees_with_differences_to_second_order() {
        let circle = Circle::new(DVec3::ONE, DVec3::new(1.0, -2.0, 0.5), 3.0).expect("a circle");
        for k in 1..20 {
            assert_derivative_is_of_second_order(&circle, f64::from(k) / 20.0);
        }
    }

    #[test]
    fn what_makes_no_circle_is_refused() {
        use ShapeError::{NoDirection, OutOfRange, PointNotFinite};
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Circle::new(DVec3::ZERO, DVec3::Z, radius), Err(OutOfRange { .. })));
        }
        for normal in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(matches!(Circle::new(DVec3::ZERO, normal, 1.0), Err(NoDirection { .. })));
        }
        let x = DVec3::new(0.1, 0.2, 0.3);
        assert!(matches!(Circle::from_axes(DVec3::ZERO, x, -3.0 * x, 1.0), Err(NoDirection { .. })));
        assert!(matches!(Circle::new(DVec3::NAN, DVec3::Z, 1.0), Err(PointNotFinite { .. })));
    }
}
