//! What can be told about a curve before anybody uses it.

use selvedge_components::curve::{Check, Curve, CurveFault, evaluate, faults};

/// A closed curve may miss its beginning by this part of its greatest coordinate. Far above the
/// rounding at the end of a turn (1e-16), far below any gap that somebody means.
const CLOSING: f64 = 1e-12;

/// How many points tell the size of a curve: any few do.
const SAMPLES: u32 = 16;

/// Every fault that `curve` has whatever it is used for. A cusp is none: what cannot have one says
/// so itself. Never panics, whatever the curve does.
pub fn curve_faults(curve: &dyn Curve) -> Vec<CurveFault> {
    let samples = (0..=SAMPLES).filter_map(|k| evaluate(curve, f64::from(k) / f64::from(SAMPLES)).ok());
    let size = samples.map(|p| p.abs().max_element()).fold(0.0, f64::max);
    faults(curve, &Check { extent: None, gap: CLOSING * size, cusp: 0.0 })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use selvedge_components::curve::{Circle, FnCurve};

    use super::*;

    #[test]
    fn rounding_closes_a_curve_of_any_size_and_a_gap_does_not() {
        for size in [1e-6, 1.0, 1e6] {
            let circle = Circle::new(DVec3::splat(size), DVec3::Z, size).expect("a circle");
            assert_eq!(curve_faults(&circle), []);
            let gap = FnCurve::new(move |u| size * DVec3::new(u * (1.0 - u), (1.0 + 1e-9) * u * u - u, 0.0)).closed();
            let found = curve_faults(&gap);
            assert!(matches!(found[..], [CurveFault::NotClosed { .. }]), "{found:?}");
        }
    }

    #[test]
    fn a_turn_back_is_no_fault_of_the_curve_itself() {
        let back = FnCurve::new(|u| DVec3::X * (u - 0.5).abs());
        assert_eq!(curve_faults(&back), []);
    }
}
