//! Angles without the platform's `sin`, `cos` and `atan2`, whose last bits differ from machine to
//! machine: `libm` is the same code everywhere.

use core::f64::consts::FRAC_PI_2;

use glam::DVec3;

/// Sine and cosine of a number of full turns.
///
/// Reduced by quarter turns, which is exact in turns and would not be in radians: quarter turns
/// come out as exact zeros and ones.
pub(super) fn sin_cos_turns(turns: f64) -> (f64, f64) {
    let quarters = (4.0 * turns).round();
    let (s, c) = libm::sincos((4.0 * turns - quarters) * FRAC_PI_2);
    match quarters.rem_euclid(4.0) as u8 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Sine and cosine of an angle in radians.
pub(super) fn sin_cos(angle: f64) -> (f64, f64) {
    libm::sincos(angle)
}

/// The angle between two vectors in [0, pi], in radians; 0 if one of them vanishes.
///
/// By the tangent, which is accurate for small and large angles alike; scaled first, so that
/// squares neither overflow nor vanish.
pub(super) fn between(a: DVec3, b: DVec3) -> f64 {
    let scaled = |v: DVec3| {
        let size = v.abs().max_element();
        if size > 0.0 { v / size } else { DVec3::ZERO }
    };
    let (a, b) = (scaled(a), scaled(b));
    libm::atan2(a.cross(b).length(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        let quarters = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
        for (k, wanted) in (0..8).map(|k| (k, quarters[k % 4])) {
            let (s, c) = sin_cos_turns(k as f64 / 4.0);
            assert!((s, c) == wanted, "{k}: {s} {c}");
        }
    }

    #[test]
    fn turns_agree_with_radians() {
        for k in -500..500 {
            let turns = f64::from(k) * 0.0173;
            let (s, c) = sin_cos_turns(turns);
            let angle = core::f64::consts::TAU * turns;
            assert!((s - angle.sin()).abs() < 1e-14 && (c - angle.cos()).abs() < 1e-14, "{turns}");
        }
    }

    #[test]
    fn angle_is_accurate_at_every_size() {
        for size in [1e-200, 1e-9, 1.0, 1e150] {
            for angle in [1e-9, 0.3, FRAC_PI_2, 3.0, core::f64::consts::PI - 1e-9] {
                let (s, c) = f64::sin_cos(angle);
                let found = between(DVec3::X * size, DVec3::new(c, s, 0.0) / size);
                assert!((found - angle).abs() < 1e-15, "{size} {angle} {found}");
            }
        }
        assert_eq!(between(DVec3::ZERO, DVec3::X), 0.0);
    }
}
