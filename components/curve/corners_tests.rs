use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use proptest::prelude::*;

use super::*;
use crate::curve::testing::{config, point};
use crate::curve::{BSpline, CORNER_TURN, Circle, FnCurve, Polyline};

/// The positions of a curve and nothing else.
fn blind<'a>(curve: &'a (dyn Curve + 'a)) -> FnCurve<impl Fn(f64) -> DVec3 + 'a> {
    let bare = FnCurve::new(move |u| curve.position(u));
    if curve.closed() { bare.closed() } else { bare }
}

fn ellipse(a: f64, b: f64) -> FnCurve<impl Fn(f64) -> DVec3> {
    FnCurve::new(move |u| DVec3::new(a * (TAU * u).cos(), b * (TAU * u).sin(), 0.0)).closed()
}

#[test]
fn smooth_curves_have_none_however_curved() {
    let circle = Circle::new(DVec3::new(3.0, 1.0, -2.0), DVec3::ONE, 1e-3).expect("a circle");
    let helix = FnCurve::new(|u| DVec3::new((300.0 * u).cos(), (300.0 * u).sin(), u));
    let stretched = FnCurve::new(|u| DVec3::new(u.powi(3), u.powi(6), 0.0));
    let hyperbola = FnCurve::new(|u| DVec3::new(u, (1e-6 + (u - 0.4).powi(2)).sqrt(), 0.0));
    let curves: [&dyn Curve; 7] =
        [&circle, &helix, &ellipse(10.0, 1.0), &ellipse(1.0, 300.0), &ellipse(1e6, 1e6), &stretched, &hyperbola];
    for curve in curves {
        assert_eq!(find_corners(&blind(curve), CORNER_TURN), Ok(vec![]), "{curve:?}");
    }
}

#[test]
fn a_curve_of_single_precision_has_its_corners_and_no_others() {
    let single = |p: DVec3| p.as_vec3().as_dvec3();
    for far in [0.0, 1.0, 1000.0] {
        let ring = FnCurve::new(move |u| single(DVec3::new(far + (TAU * u).cos(), 0.1 * (TAU * u).sin(), 0.3)));
        assert_eq!(find_corners(&ring.closed(), CORNER_TURN), Ok(vec![]), "{far}");
    }
    let star = (0..30).map(|k| (f64::from(k) / 30.0, if k % 2 == 0 { 1.0 } else { 0.4 }));
    let star = star.map(|(turn, r)| r * DVec3::new((TAU * turn).cos(), (TAU * turn).sin(), 0.0));
    let star = Polyline::closed(star.collect()).expect("a star");
    let vertices = star.parameters().to_vec();
    let rough = FnCurve::new(move |u| single(star.position(u))).closed();
    let found = find_corners(&rough, CORNER_TURN).expect("finite");
    assert_eq!(found.len(), 30);
    // The rounding of single precision over the speed, which is about 19.
    assert!(found.iter().zip(&vertices).all(|(c, u)| (c.u - u).abs() < 2.0 * f64::from(f32::EPSILON)));
}

/// A corner rounded off over a stretch `r` of the parameter is smooth as long as windows resolve it.
#[test]
fn a_tight_bend_is_smooth_down_to_the_finest_windows() {
    let bend = |r: f64| FnCurve::new(move |u| DVec3::new(u, (r * r + (u - 0.437) * (u - 0.437)).sqrt(), 0.0));
    for r in [0.1, 1e-2, 1e-3, 1e-4, 1e-5] {
        assert_eq!(find_corners(&bend(r), CORNER_TURN), Ok(vec![]), "{r}");
    }
    for r in [1e-8, 1e-10, 0.0] {
        let found = find_corners(&bend(r), CORNER_TURN).expect("finite");
        assert!(found.len() == 1 && (found[0].u - 0.437).abs() < r + 1e-14, "{r}: {found:?}");
        assert!((found[0].turn - FRAC_PI_2).abs() < 0.1, "{r}: {found:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..config() })]

    #[test]
    fn blobs_have_none(points in prop::collection::vec(point(), 4..24), degree in 3_usize..6) {
        let blob = BSpline::uniform_periodic(degree, points).expect("a curve");
        prop_assert_eq!(find_corners(&blind(&blob), CORNER_TURN), Ok(vec![]));
    }

    #[test]
    fn polygons_have_theirs_to_rounding(points in prop::collection::vec(point(), 3..24)) {
        for polygon in [Polyline::closed(points.clone()), Polyline::open(points)] {
            let polygon = polygon.expect("distinct points").smooth_below(CORNER_TURN);
            let found = find_corners(&blind(&polygon), CORNER_TURN).expect("finite");
            prop_assert_eq!(found.len(), polygon.corners().len());
            for (found, &u) in found.iter().zip(polygon.corners()) {
                prop_assert!((found.u - u).abs() < 2e-14, "{} {}", found.u, u);
                let turn = crate::curve::turn(&polygon, u).expect("straight");
                prop_assert!((found.turn - turn).abs() < 0.1 * turn, "{} {}", found.turn, turn);
            }
        }
    }

    #[test]
    fn splines_with_full_knots_have_theirs(points in prop::collection::vec(point(), 9..10), at in 0.1..0.9) {
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.05, 0.95, at, at, at, 1.0, 1.0, 1.0, 1.0];
        let mut knots = knots;
        knots.sort_by(f64::total_cmp);
        let spline = BSpline::new(3, knots, points).expect("a curve");
        let found = find_corners(&blind(&spline), CORNER_TURN).expect("finite");
        prop_assert_eq!(found.len(), spline.corners().len());
        for (found, &u) in found.iter().zip(spline.corners()) {
            prop_assert!((found.u - u).abs() < 1e-12, "{} {}", found.u, u);
        }
    }
}

#[test]
fn a_corner_is_placed_to_rounding_wherever_it_lies() {
    for corner in [1e-3, 0.1, 1.0 / 3.0, 0.5, 0.637, 0.75, 1.0 - 1e-3] {
        for turn in [0.02, 0.3, FRAC_PI_2, 3.0] {
            let (s, c) = f64::sin_cos(turn);
            let bent = FnCurve::new(move |u| {
                let past = (u - corner).max(0.0);
                DVec3::X * (u - corner).min(0.0) + DVec3::new(c, s, 0.0) * 7.0 * past + DVec3::Z * (u * u)
            });
            let found = find_corners(&bent, 0.9 * CORNER_TURN).expect("finite");
            assert_eq!(found.len(), 1, "{corner} {turn}");
            let off = (found[0].u - corner).abs();
            assert!(off < 1e-15 * (1.0 + turn.recip()), "corner {corner} turn {turn}: off by {off}");
        }
    }
}

#[test]
fn a_corner_where_a_closed_curve_begins_is_found_there() {
    let drop = FnCurve::new(|u| DVec3::new((PI * u).sin(), (PI * u).sin() * (PI * u).cos(), 0.0)).closed();
    let found = find_corners(&drop, CORNER_TURN).expect("finite");
    assert_eq!(found.len(), 1);
    assert!(found[0].u == 0.0 && (found[0].turn - FRAC_PI_2).abs() < 1e-6, "{found:?}");
    // The same corner is none where the curve is open.
    let open = FnCurve::new(move |u| drop.position(u));
    assert_eq!(find_corners(&open, CORNER_TURN), Ok(vec![]));
}

#[test]
fn cusps_and_stops_are_corners() {
    let cusp = FnCurve::new(|u| DVec3::new((u - 0.3).powi(2), (u - 0.3).powi(3), 0.0));
    let found = find_corners(&cusp, CORNER_TURN).expect("finite");
    assert!(found.len() == 1 && (found[0].u - 0.3).abs() < 1e-6 && found[0].turn > 3.0, "{found:?}");
    // Slows down to a stop, turns, and starts again: the parameter is smooth, the curve is not.
    let stop = FnCurve::new(|u| {
        let (before, after) = ((0.6 - u).max(0.0), (u - 0.6).max(0.0));
        DVec3::X * -before.powi(3) + DVec3::new(1.0, 1.0, 0.0) * after.powi(3)
    });
    let found = find_corners(&stop, CORNER_TURN).expect("finite");
    assert!(found.len() == 1 && (found[0].u - 0.6).abs() < 1e-4, "{found:?}");
    assert!((found[0].turn - FRAC_PI_4).abs() < 0.05, "{found:?}");
}

#[test]
fn a_notch_of_opposite_corners_shows_both() {
    let notch = FnCurve::new(|u| DVec3::new(u, if u < 0.5 { 0.0 } else { (u - 0.5).min(0.01) }, 0.0));
    let found = find_corners(&notch, CORNER_TURN).expect("finite");
    assert_eq!(found.len(), 2);
    assert!((found[0].u - 0.5).abs() < 1e-14 && (found[1].u - 0.51).abs() < 1e-14, "{found:?}");
}

#[test]
fn what_is_no_curve_ends_in_an_error_not_in_a_hang() {
    let noise = FnCurve::new(|u: f64| {
        let hash = |salt: u64| (u.to_bits() ^ salt).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 11;
        DVec3::new(hash(1) as f64, hash(2) as f64, hash(3) as f64)
    });
    assert!(matches!(find_corners(&noise, CORNER_TURN), Err(CurveError::Rough { .. })));
    let pole = FnCurve::new(|u| DVec3::X / (u - 0.5));
    assert!(matches!(find_corners(&pole, CORNER_TURN), Err(CurveError::NotFinite { u: 0.5, .. })));
    let panics = FnCurve::new(|u| if u > 0.9 { panic!("no") } else { DVec3::X * u });
    assert!(matches!(find_corners(&panics, CORNER_TURN), Err(CurveError::Panicked { .. })));
    assert_eq!(find_corners(&FnCurve::new(|_| DVec3::ONE), CORNER_TURN), Ok(vec![]));
    for turn in [0.0, f64::NAN, -1.0] {
        let _ = find_corners(&ellipse(2.0, 1.0), turn);
    }
}
