use proptest::prelude::*;

use super::*;
use crate::curve::Bezier;
use crate::curve::testing::{assert_derivative_is_of_second_order, bits, config, point, weighted};

/// The B-spline basis by its recursive definition: the curve by another way.
fn basis(knots: &[f64], i: usize, p: usize, u: f64) -> f64 {
    if p == 0 {
        return if knots[i] <= u && u < knots[i + 1] { 1.0 } else { 0.0 };
    }
    let ratio = |above: f64, below: f64| if below > 0.0 { above / below } else { 0.0 };
    ratio(u - knots[i], knots[i + p] - knots[i]) * basis(knots, i, p - 1, u)
        + ratio(knots[i + p + 1] - u, knots[i + p + 1] - knots[i + 1]) * basis(knots, i + 1, p - 1, u)
}

fn by_definition(p: usize, knots: &[f64], points: &[DVec3], weights: &[f64], u: f64) -> DVec3 {
    let weight = |i: usize| weights[i % weights.len()] * basis(knots, i, p, u);
    let count = knots.len() - p - 1;
    let sum: DVec3 = (0..count).map(|i| weight(i) * points[i % points.len()]).sum();
    sum / (0..count).map(weight).sum::<f64>()
}

/// A degree, weighted control points for it, and gaps between knots, some of them zero.
fn spline() -> impl Strategy<Value = (usize, Vec<DVec3>, Vec<f64>, Vec<f64>)> {
    (1_usize..6).prop_flat_map(|degree| {
        let gap = prop_oneof![3 => 0.1..2.0, 1 => Just(0.0)];
        weighted(degree + 1..degree + 9).prop_flat_map(move |(points, weights)| {
            let count = points.len() + degree + 1;
            (Just(degree), Just(points), Just(weights), prop::collection::vec(gap.clone(), count))
        })
    })
}

fn knots_of(gaps: &[f64], start: f64) -> Vec<f64> {
    gaps.iter()
        .scan(start, |at, gap| {
            *at += gap;
            Some(*at)
        })
        .collect()
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn it_is_the_sum_of_its_basis((degree, points, weights, gaps) in spline(), start in -9.0..9.0, u in 0.0..1.0) {
        let Ok(plain) = BSpline::new(degree, knots_of(&gaps, start), points.clone()) else { return Ok(()) };
        let knots = plain.knots().to_vec();
        let ones = vec![1.0; points.len()];
        let error = plain.position(u).distance(by_definition(degree, &knots, &points, &ones, u));
        prop_assert!(error < 1e-12, "{}", error);
        let rational = plain.with_weights(&weights).expect("a curve");
        let error = rational.position(u).distance(by_definition(degree, &knots, &points, &weights, u));
        prop_assert!(error < 1e-12, "{}", error);
    }

    #[test]
    fn a_periodic_one_is_the_sum_of_its_basis((degree, points, weights, gaps) in spline(), u in 0.0..1.0) {
        let period = knots_of(&gaps[..points.len().min(gaps.len() - 1) + 1], 0.5);
        let Ok(plain) = BSpline::periodic(degree, period, points.clone()) else { return Ok(()) };
        let rational = plain.with_weights(&weights).expect("a curve");
        let error = rational.position(u).distance(by_definition(degree, rational.knots(), &points, &weights, u));
        prop_assert!(error < 1e-12, "{}", error);
        prop_assert_eq!(bits(rational.position(0.0)), bits(rational.position(1.0)));
    }

    #[test]
    fn a_periodic_one_runs_on_smoothly_across_its_seam(points in prop::collection::vec(point(), 3..12), degree in 2_usize..6) {
        let ring = BSpline::uniform_periodic(degree, points).expect("a curve");
        prop_assert!(ring.corners().is_empty() && ring.closed());
        let jump = ring.derivative(0.0).distance(ring.derivative_before(0.0));
        prop_assert!(jump < 1e-12 * (1.0 + ring.derivative(0.0).length()), "{}", jump);
        let (near, speed) = (1e-13, ring.derivative(0.0).length());
        let step = ring.position(0.0).distance(ring.position(1.0 - near));
        prop_assert!((step - near * speed).abs() < 1e-14 * (1.0 + speed), "{}", step);
    }

    #[test]
    fn derivative_agrees_with_differences_to_second_order((degree, points, weights, _) in spline(), u in 0.01..0.99_f64) {
        let plain = BSpline::clamped(degree, points).expect("a curve");
        // Across a knot a difference has a lower order: stay within a span.
        let clear = plain.knots().iter().all(|k: &f64| (k - u).abs() > 2e-3);
        prop_assume!(clear);
        assert_derivative_is_of_second_order(&plain, u);
        assert_derivative_is_of_second_order(&plain.with_weights(&weights).expect("a curve"), u);
    }

    #[test]
    fn a_spline_of_one_span_is_a_bezier_curve((points, weights) in weighted(2..12), u in 0.0..=1.0) {
        let spline = BSpline::clamped(points.len() - 1, points.clone()).expect("a curve");
        let bezier = Bezier::new(points).expect("a curve");
        prop_assert_eq!(bits(spline.position(u)), bits(bezier.position(u)));
        prop_assert_eq!(bits(spline.derivative(u)), bits(bezier.derivative(u)));
        let (spline, bezier) = (spline.with_weights(&weights).expect("a"), bezier.with_weights(&weights).expect("a"));
        prop_assert_eq!(bits(spline.position(u)), bits(bezier.position(u)));
    }

    #[test]
    fn an_inserted_knot_changes_nothing(points in prop::collection::vec(point(), 4..12), at in 0.0..1.0, u in 0.0..=1.0) {
        // Boehm's algorithm for degree 3.
        let coarse = BSpline::clamped(3, points.clone()).expect("a curve");
        let old = coarse.knots().to_vec();
        let span = old.iter().rposition(|&k| k <= at).expect("0 is a knot");
        let mut knots = old.clone();
        knots.insert(span + 1, at);
        let fine = (0..=points.len()).map(|i| {
            let share = if i + 3 <= span { 1.0 } else if i > span { 0.0 } else { (at - old[i]) / (old[i + 3] - old[i]) };
            let before = points[i.saturating_sub(1)];
            before * (1.0 - share) + points[i.min(points.len() - 1)] * share
        });
        let fine = BSpline::new(3, knots, fine.collect()).expect("a curve");
        prop_assert!(fine.position(u).distance(coarse.position(u)) < 1e-13);
    }

    #[test]
    fn clamped_ends_are_met_to_the_bit((degree, points, weights, _) in spline()) {
        let last = points[points.len() - 1];
        let plain = BSpline::clamped(degree, points.clone()).expect("a curve");
        for curve in [plain.clone(), plain.with_weights(&weights).expect("a curve")] {
            prop_assert_eq!(bits(curve.position(0.0)), bits(points[0]));
            prop_assert_eq!(bits(curve.position(1.0)), bits(last));
        }
    }
}

/// The circle in four quarters has double knots, but no corner. [Piegl, Tiller 1997, Section 7.5]
#[test]
fn the_rational_circle_is_round_closed_and_without_corners() -> Result<(), ShapeError> {
    let square = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let points = square.map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 0.0)).to_vec();
    let knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
    let half = 0.5_f64.sqrt();
    let circle = BSpline::new(2, knots, points)?.with_weights(&[1.0, half, 1.0, half, 1.0, half, 1.0, half, 1.0])?;
    assert!(circle.closed() && circle.corners().is_empty());
    for k in 0..=1000 {
        let (p, d) = (circle.position(f64::from(k) / 1000.0), circle.derivative(f64::from(k) / 1000.0));
        assert!((p.length() - 1.0).abs() < 4.0 * f64::EPSILON && p.dot(d).abs() < 1e-14, "{k}");
    }
    Ok(())
}

#[test]
fn corners_are_where_knots_are_full_and_the_tangent_turns() -> Result<(), ShapeError> {
    let zigzag: Vec<_> = (0..7).map(|i| DVec3::new(f64::from(i), f64::from(i % 2), 0.0)).collect();
    // Degree 1: every inner control point.
    assert_eq!(BSpline::clamped(1, zigzag.clone())?.corners().len(), 5);
    // Degree 2 over simple knots: none; over one double knot: one.
    assert!(BSpline::clamped(2, zigzag.clone())?.corners().is_empty());
    let double = vec![0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0];
    let bent = BSpline::new(2, double, zigzag.clone())?;
    assert_eq!(bent.corners(), [0.25]);
    assert_eq!(bits(bent.position(0.25)), bits(zigzag[2]));
    let sides = [bent.derivative_before(0.25), bent.derivative(0.25)].map(DVec3::normalize);
    assert!(sides[0].distance(DVec3::new(1.0, -1.0, 0.0).normalize()) < 1e-15);
    assert!(sides[1].distance(DVec3::new(1.0, 1.0, 0.0).normalize()) < 1e-15);
    // A triangle as a periodic curve of degree 1 has a corner where it begins.
    let triangle = BSpline::uniform_periodic(1, vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
    assert_eq!(triangle.corners(), [0.0, 1.0 / 3.0, 2.0 / 3.0]);
    Ok(())
}

#[test]
fn unclamped_knots_leave_the_ends_of_the_control_polygon() -> Result<(), ShapeError> {
    // A uniform cubic: the ends are (1, 4, 1) / 6 of three control points.
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
    let curve = BSpline::new(3, (0..9).map(f64::from).collect(), points.to_vec())?;
    let ends = [(points[0] + 4.0 * points[1] + points[2]) / 6.0, (points[2] + 4.0 * points[3] + points[4]) / 6.0];
    assert!(curve.position(0.0).distance(ends[0]) < 1e-15 && curve.position(1.0).distance(ends[1]) < 1e-15);
    Ok(())
}

#[test]
fn what_makes_no_spline_is_refused_and_placed() {
    use ShapeError::{Degree, KnotMultiplicity, KnotOrder, PointNotFinite, TooFew, WrongCount};
    let points = || vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    let with = |knots: [f64; 7]| BSpline::new(2, knots.to_vec(), points());
    assert!(matches!(BSpline::clamped(0, points()), Err(Degree { degree: 0, .. })));
    assert!(matches!(BSpline::clamped(64, points()), Err(Degree { degree: 64, .. })));
    assert!(matches!(BSpline::clamped(4, points()), Err(TooFew { count: 4, needed: 5, .. })));
    assert!(matches!(BSpline::new(2, vec![0.0; 6], points()), Err(WrongCount { count: 6, needed: 7, .. })));
    assert!(matches!(with([0.0, 0.0, 0.0, 2.0, 1.0, 3.0, 3.0]), Err(KnotOrder { index: 4, .. })));
    assert!(matches!(with([0.0, 0.0, f64::NAN, 2.0, 3.0, 3.0, 3.0]), Err(KnotOrder { index: 2, .. })));
    assert!(matches!(with([1.0; 7]), Err(KnotOrder { .. })));
    assert!(matches!(with([-1e308, -1e308, -1e308, 0.0, 1e308, 1e308, 1e308]), Err(KnotOrder { .. })));
    let torn = BSpline::new(1, vec![0.0, 0.0, 1.0, 1.0, 2.0, 2.0], points());
    assert!(matches!(torn, Err(KnotMultiplicity { index: 2, u: 0.5, multiplicity: 2, degree: 1 })), "{torn:?}");
    let seam = BSpline::periodic(1, vec![0.0, 0.0, 1.0, 2.0, 3.0], points());
    assert!(matches!(seam, Err(KnotMultiplicity { u: 0.0, .. })), "{seam:?}");
    assert!(matches!(BSpline::clamped(1, vec![DVec3::ZERO, DVec3::NAN]), Err(PointNotFinite { index: 1, .. })));
    assert!(matches!(BSpline::clamped(1, points()).and_then(|c| c.with_weights(&[1.0])), Err(WrongCount { .. })));
}

#[test]
fn no_parameter_panics() -> Result<(), ShapeError> {
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
    for curve in [BSpline::clamped(2, points.clone())?, BSpline::uniform_periodic(3, points)?] {
        for u in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 2.0, f64::MIN_POSITIVE] {
            let _ = (curve.position(u), curve.derivative(u), curve.derivative_before(u));
        }
        assert!(curve.position(f64::NAN).is_nan());
    }
    Ok(())
}
