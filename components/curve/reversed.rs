//! A curve, walked the other way.

use std::sync::Arc;

use glam::DVec3;

use super::{Curve, Extent, canonical};

/// The same curve from its end to its beginning: `position(u)` is the inner `position(1 - u)`, to
/// the bit; at a corner it is the inner curve's corner, to the bit.
///
/// `1 - u` is exact from 1/2 on, and below for multiples of 2^-53; elsewhere it is rounded, and the
/// inner curve is asked at the rounded parameter. What must share samples bit for bit from both
/// sides walks one [`CurveParameters`](super::CurveParameters) backwards instead.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use selvedge_components::curve::{Curve, Reversed, Segment};
///
/// let back = Reversed::new(Arc::new(Segment { start: DVec3::X, end: DVec3::Y }));
/// assert_eq!(back.position(0.0), DVec3::Y);
/// assert_eq!(back.derivative(0.0), DVec3::X - DVec3::Y);
/// ```
#[derive(Clone, Debug)]
pub struct Reversed {
    inner: Arc<dyn Curve>,
    /// Ascending, as [`Curve::corners`] are.
    corners: Vec<f64>,
    /// For each corner, the inner curve's own parameter, of which `1 - u` may be a rounding off.
    inner_corners: Vec<f64>,
}

impl Reversed {
    /// The reverse of `inner`. Corners are read once, here.
    pub fn new(inner: Arc<dyn Curve>) -> Self {
        let extent = Extent::of(&*inner);
        let mut pairs: Vec<_> = inner.corners().iter().map(|&c| (canonical(1.0 - c, extent), c)).collect();
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (corners, inner_corners) = pairs.into_iter().unzip();
        Self { inner, corners, inner_corners }
    }

    /// The curve that is walked backwards.
    pub fn inner(&self) -> &Arc<dyn Curve> {
        &self.inner
    }

    /// The parameter on the inner curve.
    fn mirrored(&self, u: f64) -> f64 {
        match self.corners.iter().position(|&c| c == u) {
            Some(corner) => self.inner_corners[corner],
            None => 1.0 - u,
        }
    }
}

impl Curve for Reversed {
    fn position(&self, u: f64) -> DVec3 {
        self.inner.position(self.mirrored(u))
    }

    fn derivative(&self, u: f64) -> DVec3 {
        // At 1 the answer is from the left, which is the inner curve's right.
        if u >= 1.0 { -self.inner.derivative(0.0) } else { -self.inner.derivative_before(self.mirrored(u)) }
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        match (u <= 0.0, self.closed()) {
            (true, true) => self.derivative(1.0),
            (true, false) => self.derivative(0.0),
            (false, _) => -self.inner.derivative(self.mirrored(u)),
        }
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        self.inner.closed()
    }

    fn revision(&self) -> u64 {
        self.inner.revision()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::curve::testing::{assert_derivative_is_of_second_order, bits, config, point};
    use crate::curve::{Bezier, Branch, Circle, Polyline, tangent};

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn mirrored_parameters_have_the_same_bits(points in prop::collection::vec(point(), 2..8), u in 0.0..=1.0) {
            let inner = Arc::new(Bezier::new(points).expect("a curve"));
            let back = Reversed::new(inner.clone());
            prop_assert_eq!(bits(back.position(u)), bits(inner.position(1.0 - u)));
            prop_assert_eq!(bits(back.derivative(u)), bits(-inner.derivative(1.0 - u)));
            // On the grid of 2^-53 the mirror is exact, so that walking back and forth is as well.
            let grid = (u * 2f64.powi(53)).round() * 2f64.powi(-53);
            let twice = Reversed::new(Arc::new(back.clone()));
            prop_assert_eq!(bits(back.position(1.0 - grid)), bits(inner.position(grid)));
            prop_assert_eq!(bits(twice.position(grid)), bits(inner.position(grid)));
        }

        #[test]
        fn corners_are_the_inner_corners_to_the_bit(points in prop::collection::vec(point(), 3..20)) {
            let inner = Arc::new(Polyline::closed(points).expect("random points are distinct"));
            let back = Reversed::new(inner.clone());
            prop_assert!(back.corners().is_sorted() && back.corners().iter().all(|c| (0.0..1.0).contains(c)));
            let mirror = inner.corners()[1..].iter().rev();
            prop_assert_eq!(back.corners().len(), inner.corners().len());
            for (&c, &inner_c) in back.corners()[1..].iter().zip(mirror) {
                prop_assert_eq!(bits(back.position(c)), bits(inner.position(inner_c)));
                let before = tangent(&back, c, Branch::Before).expect("straight");
                let after = tangent(&back, c, Branch::After).expect("straight");
                prop_assert_eq!(bits(before), bits(-tangent(&*inner, inner_c, Branch::After).expect("straight")));
                prop_assert_eq!(bits(after), bits(-tangent(&*inner, inner_c, Branch::Before).expect("straight")));
            }
        }
    }

    #[test]
    fn a_closed_curve_stays_closed_and_turns_the_other_way() {
        let circle = Arc::new(Circle::new(DVec3::ZERO, DVec3::Z, 1.0).expect("a circle"));
        let back = Reversed::new(circle.clone());
        assert!(back.closed());
        assert_eq!(bits(back.position(0.0)), bits(back.position(1.0)));
        assert_eq!(bits(back.derivative(0.25)), bits(-circle.derivative(0.75)));
        assert_derivative_is_of_second_order(&back, 0.3);
    }

    #[test]
    fn the_first_corner_of_a_closed_curve_has_both_its_sides() {
        let inner = Arc::new(Polyline::closed(vec![DVec3::ZERO, DVec3::X, DVec3::Y]).expect("a triangle"));
        let back = Reversed::new(inner.clone());
        assert_eq!(bits(back.derivative(0.0)), bits(-inner.derivative(1.0)));
        assert_eq!(bits(back.derivative(1.0)), bits(-inner.derivative(0.0)));
        assert_eq!(bits(back.derivative_before(0.0)), bits(-inner.derivative(0.0)));
    }
}
