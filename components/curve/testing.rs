//! What the tests of curves share.

use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::Curve;

/// The bits of a point, for comparisons without any tolerance.
pub fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

/// Property tests are repeatable: a fixed seed, and nothing written beside the source.
pub fn config() -> ProptestConfig {
    ProptestConfig {
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(0x5e1f_ed6e),
        ..ProptestConfig::with_cases(200)
    }
}

/// A point of a cube about the origin.
pub fn point() -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-5.0..5.0).prop_map(DVec3::from_array)
}

/// `count` points, and weights between 1/3 and 3.
pub fn weighted(count: core::ops::Range<usize>) -> impl Strategy<Value = (Vec<DVec3>, Vec<f64>)> {
    let pair = (point(), 0.33..3.0);
    prop::collection::vec(pair, count).prop_map(|pairs| pairs.into_iter().unzip())
}

/// The derivative of a curve is what central differences say, with an error that falls as `h^2`;
/// `u` and `u +- 2 h` lie in one smooth piece.
pub fn assert_derivative_is_of_second_order(curve: &dyn Curve, u: f64) {
    let size = curve.derivative(u).length().max(1.0);
    let error = |h: f64| {
        let central = (curve.position(u + h) - curve.position(u - h)) / (2.0 * h);
        (central - curve.derivative(u)).length() / size
    };
    let (coarse, fine) = (error(2e-3), error(1e-3));
    let rounding = 1e-11;
    assert!(fine < 0.26 * coarse + rounding, "u {u}: error {coarse} at 2h, {fine} at h");
}
