//! How long a curve is.

use super::guard::call;
use super::{Curve, CurveError};

/// Abscissae and weights of the Gauss-Legendre rule of five points on [-1, 1], exact up to degree
/// 9: `sqrt(5 -+ 2 sqrt(10 / 7)) / 3` and `(322 +- 13 sqrt(70)) / 900`.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// How many panels each smooth piece is cut into. The error of a panel of width `h` is of order
/// `h^10`, below 1e-12 of the length for a piece that waves a few times.
const PANELS: u32 = 16;

/// The length of `curve` in model units: composite Gauss-Legendre quadrature of its speed, cut at
/// its corners. Exact to rounding where the speed is constant.
///
/// ```
/// use core::f64::consts::TAU;
/// use glam::DVec3;
/// use selvedge_components::curve::{Circle, length};
///
/// let circle = Circle::new(DVec3::ONE, DVec3::Z, 3.0)?;
/// assert!((length(&circle)? - 3.0 * TAU).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`CurveError::NotFinite`] or [`CurveError::Panicked`] for a derivative.
pub fn length(curve: &dyn Curve) -> Result<f64, CurveError> {
    let inside = curve.corners().iter().copied().filter(|&c| c > 0.0 && c < 1.0);
    let mut total = 0.0;
    let mut from = 0.0;
    for to in inside.chain([1.0]) {
        let width = (to - from) / f64::from(PANELS);
        for panel in 0..PANELS {
            let middle = from + (f64::from(panel) + 0.5) * width;
            for (x, weight) in GAUSS {
                let u = middle + 0.5 * width * x;
                total += 0.5 * width * weight * call(u, || curve.derivative(u))?.length();
            }
        }
        from = to;
    }
    Ok(total)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::curve::{Bezier, FnCurve, Polyline};

    #[test]
    fn a_parabola_has_its_closed_length() {
        // y = x^2 on [0, 1]: sqrt(5) / 2 + asinh(2) / 4.
        let parabola = Bezier::new(vec![DVec3::ZERO, 0.5 * DVec3::X, DVec3::new(1.0, 1.0, 0.0)]).expect("a curve");
        let closed = 5.0_f64.sqrt() / 2.0 + 2.0_f64.asinh() / 4.0;
        assert!((length(&parabola).expect("finite") - closed).abs() < 1e-14);
    }

    #[test]
    fn a_polyline_is_as_long_as_its_segments() {
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 2.0, 0.0), DVec3::new(1.0, 2.0, 4.0)];
        let line = Polyline::open(points).expect("a polyline");
        assert!((length(&line).expect("finite") - 7.0).abs() < 1e-13);
    }

    #[test]
    fn a_black_box_is_as_long_as_the_curve_it_is() {
        let helix = FnCurve::new(|u| DVec3::new((5.0 * u).cos(), (5.0 * u).sin(), 2.0 * u));
        assert!((length(&helix).expect("finite") - 29.0_f64.sqrt()).abs() < 1e-10);
        assert!(matches!(length(&FnCurve::new(|_| DVec3::NAN)), Err(CurveError::NotFinite { .. })));
        assert!(matches!(length(&FnCurve::new(|_| panic!("no"))), Err(CurveError::Panicked { .. })));
    }
}
