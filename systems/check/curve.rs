//! What can be told about a black-box curve beforehand.

use selvedge_components::curve::Curve;
use selvedge_components::error::CurveFailed;
use selvedge_components::guard::{caught, guarded};

/// A curve is tried at this many intervals and at its corners. Enough to find a curve that does not
/// work at all; one that fails only here and there is caught by the guard of whatever calls it.
const TRIALS: u32 = 32;

/// A closed curve may miss its beginning by this part of its size. Far above the rounding of
/// `sin` and `cos` at the end of a turn (1e-16), far below any gap that somebody means.
const CLOSING: f64 = 1e-12;

/// What is wrong with `curve`, if anything: the first fault found, for one makes all others
/// doubtful. Never panics, whatever the curve does.
pub fn curve_fault(curve: &dyn Curve) -> Option<CurveFailed> {
    let asked = caught(|| (curve.corners().to_vec(), curve.closed()));
    let (corners, closed) = match asked {
        Ok(answers) => answers,
        Err(message) => return Some(CurveFailed::Panicked { message }),
    };
    let mut last = f64::NEG_INFINITY;
    for (index, &u) in corners.iter().enumerate() {
        // Written so that a NaN is out of order too.
        if !(u > last && (0.0..1.0).contains(&u)) {
            return Some(CurveFailed::BadCorner { index, u });
        }
        last = u;
    }
    let trials = (0..=TRIALS).map(|i| f64::from(i) / f64::from(TRIALS)).chain(corners);
    let mut points = Vec::new();
    for u in trials {
        match guarded(|| curve.position(u)) {
            Ok(point) => points.push(point),
            Err(why) => return Some(CurveFailed::NoPoint { u, why }),
        }
    }
    let (start, end) = (points[0], points[TRIALS as usize]);
    let size = points.iter().fold(0.0_f64, |size, p| size.max(p.distance(start)));
    let gap = start.distance(end);
    (closed && gap > CLOSING * size).then_some(CurveFailed::Open { gap })
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use glam::DVec3;

    use super::*;

    #[derive(Debug)]
    struct Of(fn(f64) -> DVec3, bool, Vec<f64>);

    impl Curve for Of {
        fn position(&self, u: f64) -> DVec3 {
            (self.0)(u)
        }
        fn closed(&self) -> bool {
            self.1
        }
        fn corners(&self) -> &[f64] {
            &self.2
        }
    }

    fn circle(u: f64) -> DVec3 {
        DVec3::new((TAU * u).cos(), (TAU * u).sin(), 0.0)
    }

    #[test]
    fn a_circle_is_sound_closed_or_not() {
        assert_eq!(curve_fault(&Of(circle, true, vec![])), None);
        assert_eq!(curve_fault(&Of(circle, false, vec![0.25])), None);
    }

    #[test]
    fn a_gap_is_told_by_how_much() {
        let line = Of(|u| 3.0 * u * DVec3::X, true, vec![]);
        assert_eq!(curve_fault(&line), Some(CurveFailed::Open { gap: 3.0 }));
    }

    #[test]
    fn corners_out_of_order_out_of_range_or_nan_are_told_by_index() {
        for (corners, index) in [(vec![0.5, 0.5], 1), (vec![1.0], 0), (vec![-0.1], 0), (vec![0.1, f64::NAN], 1)] {
            let fault = curve_fault(&Of(circle, false, corners));
            assert!(matches!(fault, Some(CurveFailed::BadCorner { index: i, .. }) if i == index), "{fault:?}");
        }
    }

    #[test]
    fn a_curve_that_panics_or_gives_nan_is_told_with_its_parameter() {
        let panics = Of(|u| if u > 0.5 { panic!("no more") } else { DVec3::ZERO }, false, vec![]);
        let fault = curve_fault(&panics);
        assert!(matches!(fault, Some(CurveFailed::NoPoint { u, .. }) if u == 0.53125), "{fault:?}");
        let nan = Of(|u| DVec3::splat((u - 0.5).sqrt()), false, vec![]);
        let fault = curve_fault(&nan);
        assert!(matches!(fault, Some(CurveFailed::NoPoint { u: 0.0, .. })), "{fault:?}");
    }
}
