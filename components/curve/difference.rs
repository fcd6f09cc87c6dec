//! The derivative of a black box.

use glam::DVec3;

use super::{Branch, Curve, wrap};

/// The distance between the five points. The error of rounding, `eps |c| / h`, and of truncation,
/// `h^4 |c^(5)| / 30`, balance where `h = (30 eps)^(1/5) / w` for a curve that waves like
/// `cos(w u)`: 2e-4 for one turn (`w = 2 pi`), where both are near 1e-12. A power of two, so that
/// the points lie where they are meant to.
const STEP: f64 = 1.0 / 4096.0;

/// The derivative at `u` by the five-point difference, of fourth order everywhere: the points stay
/// within the smooth piece on the given side of `u`, off centre where they must.
pub(super) fn difference<C: Curve + ?Sized>(curve: &C, u: f64, branch: Branch) -> DVec3 {
    let (from, to) = piece(curve, u, branch);
    let h = STEP.min((to - from) / 4.0);
    if h <= 0.0 || h.is_nan() {
        return DVec3::ZERO;
    }
    let centre = u.clamp(from + 2.0 * h, (to - 2.0 * h).max(from + 2.0 * h));
    let at = |k: f64| {
        let v = (centre + k * h).clamp(from, to);
        curve.position(if curve.closed() && !(0.0..=1.0).contains(&v) { wrap(v) } else { v })
    };
    let weights = weights((u - centre) / h);
    let nodes = [-2.0, -1.0, 0.0, 1.0, 2.0];
    // The weights sum to zero; taken from the middle point, a far origin costs no digits.
    let middle = at(0.0);
    let sum = nodes.iter().zip(weights).fold(DVec3::ZERO, |sum, (&k, w)| sum + w * (at(k) - middle));
    sum / h
}

/// Weights of the values at -2..=2 in the derivative at `s` of the quartic through them: the
/// derivatives of Lagrange's polynomials. At 0 they are the well-known (1, -8, 0, 8, -1) / 12.
fn weights(s: f64) -> [f64; 5] {
    let cubic = |a: f64, b: f64, c: f64, d: f64| ((a * s + b) * s + c) * s + d;
    [
        cubic(4.0, -6.0, -2.0, 2.0) / 24.0,
        -cubic(4.0, -3.0, -8.0, 4.0) / 6.0,
        cubic(4.0, 0.0, -10.0, 0.0) / 4.0,
        -cubic(4.0, 3.0, -8.0, -4.0) / 6.0,
        cubic(4.0, 6.0, -2.0, -2.0) / 24.0,
    ]
}

/// The ends of the smooth piece on the given side of `u`, between declared corners and open ends.
/// On a closed curve it may reach beyond [0, 1], and has no ends if there is no corner.
pub(super) fn piece<C: Curve + ?Sized>(curve: &C, u: f64, branch: Branch) -> (f64, f64) {
    let (mut from, mut to) = if curve.closed() { (f64::NEG_INFINITY, f64::INFINITY) } else { (0.0, 1.0) };
    // A list that is out of order or out of range is a fault found elsewhere; here it does no harm.
    for &corner in curve.corners().iter().filter(|c| (0.0..1.0).contains(*c)) {
        let lifts = if curve.closed() { [corner - 1.0, corner, corner + 1.0] } else { [corner; 3] };
        for lift in lifts {
            let is_before = lift < u || (lift == u && branch == Branch::After);
            if is_before {
                from = from.max(lift);
            } else {
                to = to.min(lift);
            }
        }
    }
    (from, to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::FnCurve;
    use crate::curve::testing::bits;

    /// Five points carry a quartic, wherever in the interval it is asked for.
    #[test]
    fn quartics_are_exact_up_to_the_ends() {
        let curve = FnCurve::new(|u| DVec3::new(u.powi(4), 1.0 - u * u, 3.0 * u));
        for k in 0..=1000 {
            let u = f64::from(k) / 1000.0;
            let wanted = DVec3::new(4.0 * u.powi(3), -2.0 * u, 3.0);
            assert!((curve.derivative(u) - wanted).length() < 2e-11, "{u}: {}", curve.derivative(u) - wanted);
        }
    }

    #[test]
    fn weights_are_of_fourth_order() {
        for s in [-2.0_f64, -0.7, 0.0, 1.3, 2.0] {
            let w = weights(s);
            for degree in 0..=4 {
                let sum: f64 = (-2..=2).zip(w).map(|(k, w)| w * f64::from(k).powi(degree)).sum();
                let wanted = if degree == 0 { 0.0 } else { f64::from(degree) * s.powi(degree - 1) };
                assert!((sum - wanted).abs() < 1e-13, "s {s} degree {degree}");
            }
        }
    }

    #[test]
    fn a_difference_crosses_no_declared_corner() {
        let hat = |u: f64| DVec3::new(u, 0.3 - (u - 0.3).abs(), 0.0);
        let curve = FnCurve::new(hat).with_corners(vec![0.3]);
        for k in 0..=100 {
            let u = f64::from(k) / 100.0;
            let wanted = if u < 0.3 { 1.0 } else { -1.0 };
            assert!((curve.derivative(u).y - wanted).abs() < 1e-11, "{u}");
        }
        assert!((curve.derivative_before(0.3).y - 1.0).abs() < 1e-11);
    }

    #[test]
    fn a_closed_curve_is_differenced_across_its_seam() {
        let turn = core::f64::consts::TAU;
        let circle = FnCurve::new(move |u| DVec3::new((turn * u).cos(), (turn * u).sin(), 0.0)).closed();
        for u in [0.0, 1e-5, 1.0 - 1e-5, 1.0] {
            let wanted = turn * DVec3::new(-(turn * u).sin(), (turn * u).cos(), 0.0);
            assert!((circle.derivative(u) - wanted).length() < 1e-10, "{u}");
        }
        let (start, end) = (circle.derivative(0.0), circle.derivative_before(0.0));
        assert!((start - end).length() < 1e-10);
        assert_eq!(bits(end), bits(circle.derivative(1.0)));
    }

    #[test]
    fn a_corner_where_a_closed_curve_begins_is_respected() {
        // A drop: one corner, at 0.
        let drop = |u: f64| DVec3::new(u * (1.0 - u), u * (1.0 - u) * (1.0 - 2.0 * u), 0.0);
        let curve = FnCurve::new(drop).closed().with_corners(vec![0.0]);
        assert!((curve.derivative(0.0) - DVec3::new(1.0, 1.0, 0.0)).length() < 1e-11);
        assert!((curve.derivative_before(0.0) - DVec3::new(-1.0, 1.0, 0.0)).length() < 1e-11);
    }

    #[test]
    fn corners_that_lie_together_give_no_panic() {
        let curve = FnCurve::new(DVec3::splat).with_corners(vec![0.5, 0.5, f64::NAN, -3.0, 7.0]);
        for u in [0.0, 0.5, 0.7, 1.0, f64::NAN] {
            let _ = (curve.derivative(u), curve.derivative_before(u));
        }
    }
}
