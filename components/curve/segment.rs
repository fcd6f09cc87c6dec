//! A straight line between two points.

use glam::DVec3;

use super::{Curve, Extent, canonical, mix};

/// The straight segment from `start` to `end`, at constant speed.
///
/// Exact at both ends, and the same bits from either end: the segment from `end` to `start` has
/// at `1 - u` what this has at `u`.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{Curve, Segment};
///
/// let s = Segment { start: DVec3::ZERO, end: DVec3::new(2.0, 4.0, 6.0) };
/// assert_eq!(s.position(0.5), DVec3::new(1.0, 2.0, 3.0));
/// assert_eq!(s.derivative(0.5), DVec3::new(2.0, 4.0, 6.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// The point at 0.
    pub start: DVec3,
    /// The point at 1.
    pub end: DVec3,
}

impl Curve for Segment {
    fn position(&self, u: f64) -> DVec3 {
        mix(self.start, self.end, canonical(u, Extent::Open))
    }

    fn derivative(&self, _: f64) -> DVec3 {
        self.end - self.start
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::curve::testing::{bits, config, point};

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn ends_are_exact_and_directions_agree_bitwise(start in point(), end in point(), k in 0_u32..=1024) {
            let (there, back) = (Segment { start, end }, Segment { start: end, end: start });
            prop_assert_eq!(bits(there.position(0.0)), bits(start));
            prop_assert_eq!(bits(there.position(1.0)), bits(end));
            let u = f64::from(k) / 1024.0;
            prop_assert_eq!(bits(there.position(u)), bits(back.position(1.0 - u)));
            prop_assert_eq!(bits(there.position(0.5)), bits(back.position(0.5)));
        }

        #[test]
        fn shares_of_the_way_are_shares_of_the_length(start in point(), end in point(), u in 0.0..=1.0) {
            let s = Segment { start, end };
            let along = s.position(u).distance(start);
            prop_assert!((along - u * start.distance(end)).abs() < 1e-14);
        }
    }

    #[test]
    fn a_coordinate_that_both_ends_share_is_kept_to_the_bit() {
        let s = Segment { start: DVec3::new(0.0, 0.1, 0.3), end: DVec3::new(1.0, 0.7, 0.3) };
        assert!((0..1000).all(|k| s.position(f64::from(k) / 999.0).z == 0.3));
    }

    #[test]
    fn parameters_outside_are_read_as_the_nearer_end() {
        let s = Segment { start: DVec3::X, end: DVec3::Y };
        assert_eq!(s.position(-3.0), DVec3::X);
        assert_eq!(s.position(f64::INFINITY), DVec3::Y);
        assert!(s.position(f64::NAN).is_nan());
    }
}
