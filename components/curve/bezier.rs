//! Bezier curves, polynomial and rational, of any degree.

use glam::DVec3;

use super::net::{Jet, LastStep, MAX_DEGREE, Net};
use super::{CORNER_TURN, Curve, Extent, ShapeError, canonical, turn};

/// A Bezier curve of the degree one less than the number of its control points.
///
/// Evaluated by de Casteljau's algorithm: it meets the first and the last control point to the
/// bit, and the reversed control points at `1 - u` give the same bits. If the two ends are the
/// same point to the bit, the curve is closed, with a corner there if it turns by
/// [`CORNER_TURN`] or more.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{Bezier, Curve};
///
/// // y = x^2
/// let parabola = Bezier::new(vec![DVec3::ZERO, 0.5 * DVec3::X, DVec3::new(1.0, 1.0, 0.0)])?;
/// assert_eq!(parabola.position(0.5), DVec3::new(0.5, 0.25, 0.0));
/// assert_eq!(parabola.derivative(0.5), DVec3::new(1.0, 1.0, 0.0));
/// # Ok::<(), selvedge_components::curve::ShapeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Bezier {
    net: Net,
    extent: Extent,
    corners: Vec<f64>,
}

impl Bezier {
    /// The curve of two control points or more.
    ///
    /// # Errors
    /// [`ShapeError::TooFew`], [`ShapeError::Degree`] above [`MAX_DEGREE`], or
    /// [`ShapeError::PointNotFinite`].
    pub fn new(points: Vec<DVec3>) -> Result<Self, ShapeError> {
        if points.len() < 2 {
            return Err(ShapeError::TooFew { what: "control points", count: points.len(), needed: 2 });
        }
        if points.len() > MAX_DEGREE + 1 {
            return Err(ShapeError::Degree { degree: points.len() - 1, limit: MAX_DEGREE });
        }
        Ok(Self::of(Net::plain(points)?))
    }

    /// The rational curve of the same control points and these weights.
    ///
    /// ```
    /// # use glam::DVec3;
    /// # use selvedge_components::curve::{Bezier, Curve};
    /// // A quarter of a circle.
    /// let arc = Bezier::new(vec![DVec3::X, DVec3::X + DVec3::Y, DVec3::Y])?
    ///     .with_weights(&[1.0, 0.5_f64.sqrt(), 1.0])?;
    /// assert!((arc.position(0.3).length() - 1.0).abs() < 1e-15);
    /// # Ok::<(), selvedge_components::curve::ShapeError>(())
    /// ```
    ///
    /// # Errors
    /// [`ShapeError::WrongCount`] or [`ShapeError::Weight`].
    pub fn with_weights(self, weights: &[f64]) -> Result<Self, ShapeError> {
        Ok(Self::of(self.net.with_weights(weights)?))
    }

    fn of(net: Net) -> Self {
        let meets = net.point(0) == net.point(net.len() - 1);
        let extent = if meets { Extent::Closed } else { Extent::Open };
        let mut built = Self { net, extent, corners: Vec::new() };
        if meets && turn(&built, 0.0).is_some_and(|by| by >= CORNER_TURN) {
            built.corners.push(0.0);
        }
        built
    }

    /// The degree, at least 1.
    pub fn degree(&self) -> usize {
        self.net.len() - 1
    }

    fn jet(&self, u: f64) -> Jet {
        let last = LastStep { share: u, speed: self.degree() as f64 };
        self.net.evaluate(0, self.net.len(), |_, _| u, last)
    }
}

impl Curve for Bezier {
    fn position(&self, u: f64) -> DVec3 {
        self.jet(canonical(u, self.extent)).position
    }

    fn derivative(&self, u: f64) -> DVec3 {
        // Open: 1 stays 1, where a closed curve is asked for its end, not for its beginning.
        self.jet(canonical(u, Extent::Open)).derivative
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        self.extent == Extent::Closed
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::curve::testing::{assert_derivative_is_of_second_order, bits, config, point, weighted};

    /// The curve as the sum of Bernstein polynomials: the definition, by another way.
    fn bernstein(points: &[DVec3], weights: &[f64], u: f64) -> DVec3 {
        let n = points.len() - 1;
        let mut choose = 1.0;
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (i, (p, w)) in points.iter().zip(weights).enumerate() {
            let b = w * choose * u.powi(i as i32) * (1.0 - u).powi((n - i) as i32);
            sum += b * p;
            total += b;
            choose *= (n - i) as f64 / (i + 1) as f64;
        }
        sum / total
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn it_is_the_sum_of_bernstein_polynomials((points, weights) in weighted(2..12), u in 0.0..=1.0) {
            let plain = Bezier::new(points.clone()).expect("a curve");
            let ones = vec![1.0; points.len()];
            prop_assert!(plain.position(u).distance(bernstein(&points, &ones, u)) < 1e-13);
            let rational = plain.with_weights(&weights).expect("a curve");
            prop_assert!(rational.position(u).distance(bernstein(&points, &weights, u)) < 1e-13);
        }

        #[test]
        fn ends_are_exact_and_directions_agree_bitwise((points, weights) in weighted(2..70), u in 0.0..=1.0) {
            prop_assume!(points.len() <= MAX_DEGREE + 1);
            let there = Bezier::new(points.clone()).expect("a curve");
            let back = Bezier::new(points.iter().rev().copied().collect()).expect("a curve");
            prop_assert_eq!(bits(there.position(0.0)), bits(points[0]));
            prop_assert_eq!(bits(there.position(1.0)), bits(points[points.len() - 1]));
            let v = 1.0 - u;
            prop_assert_eq!(bits(there.position(1.0 - v)), bits(back.position(v)));
            let rational = there.with_weights(&weights).expect("a curve");
            prop_assert_eq!(bits(rational.position(0.0)), bits(points[0]));
            prop_assert_eq!(bits(rational.position(1.0)), bits(points[points.len() - 1]));
        }

        #[test]
        fn derivative_agrees_with_differences_to_second_order((points, weights) in weighted(2..7), u in 0.01..0.99) {
            let plain = Bezier::new(points).expect("a curve");
            assert_derivative_is_of_second_order(&plain, u);
            assert_derivative_is_of_second_order(&plain.with_weights(&weights).expect("a curve"), u);
        }

        #[test]
        fn equal_weights_change_nothing((points, _) in weighted(2..9), weight in 0.1..10.0, u in 0.0..=1.0) {
            let plain = Bezier::new(points.clone()).expect("a curve");
            let rational = plain.clone().with_weights(&vec![weight; points.len()]).expect("a curve");
            prop_assert!(plain.position(u).distance(rational.position(u)) < 1e-14);
            prop_assert!(plain.derivative(u).distance(rational.derivative(u)) < 1e-12);
        }

        #[test]
        fn a_raised_degree_changes_nothing(points in prop::collection::vec(point(), 2..12), u in 0.0..=1.0) {
            let n = points.len() as f64;
            let mut raised = vec![points[0]];
            raised.extend(points.windows(2).enumerate().map(|(i, p)| {
                let share = (i + 1) as f64 / n;
                p[0] * share + p[1] * (1.0 - share)
            }));
            raised.push(points[points.len() - 1]);
            let (low, high) = (Bezier::new(points).expect("a curve"), Bezier::new(raised).expect("a curve"));
            prop_assert!(low.position(u).distance(high.position(u)) < 1e-13);
        }
    }

    #[test]
    fn a_rational_quadratic_is_a_circle() {
        let arc = Bezier::new(vec![DVec3::X, DVec3::X + DVec3::Y, DVec3::Y]).expect("a curve");
        let arc = arc.with_weights(&[1.0, 0.5_f64.sqrt(), 1.0]).expect("a curve");
        for k in 0..=100 {
            let (p, d) = (arc.position(f64::from(k) / 100.0), arc.derivative(f64::from(k) / 100.0));
            assert!((p.length() - 1.0).abs() < 4.0 * f64::EPSILON && p.dot(d).abs() < 8.0 * f64::EPSILON);
        }
    }

    #[test]
    fn a_flat_curve_stays_in_its_plane_to_the_bit() {
        let points = [(0.1, 0.2), (3.3, 1.7), (-0.4, 5.1), (2.2, 2.9)].map(|(x, y)| DVec3::new(x, y, 0.3));
        let plain = Bezier::new(points.to_vec()).expect("a curve");
        let rational = plain.clone().with_weights(&[1.0, 0.3, 2.0, 0.7]).expect("a curve");
        for k in 0..=1000 {
            let u = f64::from(k) / 1000.0;
            assert!(plain.position(u).z == 0.3 && rational.position(u).z == 0.3);
        }
    }

    #[test]
    fn ends_that_meet_close_it() {
        let drop = Bezier::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ZERO]).expect("a curve");
        assert!(drop.closed() && drop.corners() == [0.0]);
        let smooth = Bezier::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::X, DVec3::ZERO]).expect("a curve");
        assert!(smooth.closed() && smooth.corners().is_empty());
    }

    #[test]
    fn what_makes_no_bezier_is_refused_and_placed() {
        use ShapeError::{Degree, PointNotFinite, TooFew, Weight, WrongCount};
        assert!(matches!(Bezier::new(vec![DVec3::X]), Err(TooFew { count: 1, .. })));
        assert!(matches!(Bezier::new(vec![DVec3::X; 65]), Err(Degree { degree: 64, .. })));
        assert!(matches!(Bezier::new(vec![DVec3::X, DVec3::NAN]), Err(PointNotFinite { index: 1, .. })));
        let line = || Bezier::new(vec![DVec3::X, DVec3::Y]).expect("a curve");
        assert!(matches!(line().with_weights(&[1.0]), Err(WrongCount { count: 1, needed: 2, .. })));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(line().with_weights(&[1.0, bad]), Err(Weight { index: 1, .. })));
        }
    }
}
