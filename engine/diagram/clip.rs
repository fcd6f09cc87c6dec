//! Clipping to a box, so that no coordinate reaches the rasteriser that it could not hold.

use glam::DVec2;

/// A box in pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Area {
    pub low: DVec2,
    pub high: DVec2,
}

impl Area {
    /// A picture of this size with `grown` pixels around it.
    pub fn of_picture(width: u32, height: u32, grown: f64) -> Self {
        Self { low: DVec2::splat(-grown), high: DVec2::new(f64::from(width), f64::from(height)) + grown }
    }
}

/// The part of the segment from `a` to `b` inside `area` [Liang and Barsky 1984]; `None` if there
/// is none, or an end is not finite.
pub(super) fn segment(a: DVec2, b: DVec2, area: &Area) -> Option<(DVec2, DVec2)> {
    if !(a.is_finite() && b.is_finite()) {
        return None;
    }
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        // Halves, so that the difference of two finite numbers stays finite.
        let half = 0.5 * b[axis] - 0.5 * a[axis];
        let (low, high) = (0.5 * area.low[axis] - 0.5 * a[axis], 0.5 * area.high[axis] - 0.5 * a[axis]);
        if half == 0.0 {
            if low > 0.0 || high < 0.0 {
                return None;
            }
            continue;
        }
        let (first, last) = if half > 0.0 { (low / half, high / half) } else { (high / half, low / half) };
        enter = enter.max(first);
        leave = leave.min(last);
    }
    if enter > leave {
        return None;
    }
    let at = |t: f64| (a * (1.0 - t) + b * t).clamp(area.low, area.high);
    let start = if enter > 0.0 { at(enter) } else { a };
    let end = if leave < 1.0 { at(leave) } else { b };
    Some((start, end))
}

/// The part of a polygon inside `area` [Sutherland and Hodgman 1974]; empty if there is none, or a
/// corner is not finite. Where a concave polygon falls apart, edges along the box join the parts.
pub(super) fn polygon(corners: &[DVec2], area: &Area) -> Vec<DVec2> {
    if corners.iter().any(|corner| !corner.is_finite()) {
        return Vec::new();
    }
    let mut kept = corners.to_vec();
    for axis in 0..2 {
        kept = half_plane(&kept, axis, |x| x - area.low[axis]);
        kept = half_plane(&kept, axis, |x| area.high[axis] - x);
    }
    kept
}

/// The part of a polygon where `inside` of the coordinate is not negative.
fn half_plane(corners: &[DVec2], axis: usize, inside: impl Fn(f64) -> f64) -> Vec<DVec2> {
    let mut kept = Vec::with_capacity(corners.len() + 2);
    for (i, &to) in corners.iter().enumerate() {
        let from = corners[if i == 0 { corners.len() - 1 } else { i - 1 }];
        let (before, after) = (inside(from[axis]), inside(to[axis]));
        if (before < 0.0) != (after < 0.0) {
            // Scaled first: the difference of two huge numbers of opposite signs may overflow.
            let t = (0.5 * before) / (0.5 * before - 0.5 * after);
            kept.push(from * (1.0 - t) + to * t);
        }
        if after >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    const AREA: Area = Area { low: DVec2::ZERO, high: DVec2::new(10.0, 20.0) };

    #[test]
    fn a_segment_inside_keeps_its_bits() {
        let (a, b) = (DVec2::new(0.1, 0.3), DVec2::new(9.7, 19.9));
        assert_eq!(segment(a, b, &AREA), Some((a, b)));
    }

    #[test]
    fn a_diagonal_is_cut_where_it_meets_the_box() {
        let (a, b) = segment(DVec2::new(-5.0, -5.0), DVec2::new(15.0, 15.0), &AREA).expect("it crosses the box");
        assert!(a.distance(DVec2::ZERO) < 1e-12 && b.distance(DVec2::splat(10.0)) < 1e-12);
    }

    #[test]
    fn nothing_remains_outside_or_of_what_is_not_finite() {
        assert_eq!(segment(DVec2::new(-1.0, 0.0), DVec2::new(-1.0, 9.0), &AREA), None);
        assert_eq!(segment(DVec2::new(f64::NAN, 0.0), DVec2::ONE, &AREA), None);
        assert!(polygon(&[DVec2::ONE, DVec2::new(f64::INFINITY, 0.0), DVec2::ZERO], &AREA).is_empty());
    }

    #[test]
    fn coordinates_at_the_end_of_the_range_are_brought_inside() {
        let far = 1e308;
        let (a, b) = segment(DVec2::new(-far, 5.0), DVec2::new(far, 5.0), &AREA).expect("it crosses the box");
        assert!(a.x >= 0.0 && b.x <= 10.0);
        for corner in polygon(&[DVec2::new(-far, -far), DVec2::new(far, -far), DVec2::new(0.0, far)], &AREA) {
            assert!(corner.is_finite() && corner.cmpge(AREA.low - 1e-9).all() && corner.cmple(AREA.high + 1e-9).all());
        }
    }

    /// Area by the shoelace formula: the box cut out of a big square is the box.
    #[test]
    fn a_square_around_the_box_is_cut_to_the_box() {
        let big = [DVec2::new(-50.0, -50.0), DVec2::new(50.0, -50.0), DVec2::new(50.0, 50.0), DVec2::new(-50.0, 50.0)];
        let cut = polygon(&big, &AREA);
        let twice: f64 = (0..cut.len()).map(|i| cut[i].perp_dot(cut[(i + 1) % cut.len()])).sum();
        assert!((0.5 * twice - 200.0).abs() < 1e-9);
    }
}
