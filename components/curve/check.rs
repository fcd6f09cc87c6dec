//! Everything that can be wrong with a curve, named and placed.

use glam::DVec3;
use thiserror::Error;

use super::corners::{SAMPLES, find_corners_among, parameter};
use super::guard::{catch, evaluate};
use super::{CORNER_TURN, Curve, CurveError, Extent, turn};

/// What a curve must keep to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Check {
    /// What the curve is wanted for takes a closed or an open one; `None` if either will do.
    pub extent: Option<Extent>,
    /// How far apart the ends of a closed curve may be, in model units.
    pub gap: f64,
    /// The smallest angle between the two branches of the curve at a corner, in radians: pi where it
    /// runs straight on, 0 where it turns back on itself.
    pub cusp: f64,
}

/// A defect of a curve, placed by parameter.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveFault {
    /// A corner is listed outside [0, 1), or at 0 of an open curve.
    #[error("corner {index} is listed at u = {u}, where an {} curve can have none", if *.closed { "closed" } else { "open" })]
    CornerOutOfRange {
        /// Its place in the list.
        index: usize,
        /// Its parameter.
        u: f64,
        /// Whether the curve is closed.
        closed: bool,
    },
    /// A corner is listed at or before the one before it.
    #[error("corner {index} is listed at u = {u}, not after {before}")]
    CornersUnsorted {
        /// Its place in the list.
        index: usize,
        /// Its parameter.
        u: f64,
        /// The parameter listed before it.
        before: f64,
    },
    /// The curve is not finite, panics, or is too rough to be looked at; from the parameter of the
    /// error on, up to the next parameter at which it is sound again.
    #[error("up to u = {to}: {error}")]
    Evaluation {
        /// The error at the first parameter that fails.
        #[source]
        error: CurveError,
        /// The last parameter in a row that fails.
        to: f64,
    },
    /// The curve stands still: parameters differ and points do not.
    #[error("the curve has no length from u = {from} to {to}: it stays at {at}")]
    ZeroLength {
        /// Where it comes to rest.
        from: f64,
        /// Where it moves on.
        to: f64,
        /// Where it stays.
        at: DVec3,
    },
    /// The curve is declared closed, but does not close.
    #[error("the curve is declared closed, but ends {gap} from where it begins: more than {limit}")]
    NotClosed {
        /// The distance of its ends, in model units.
        gap: f64,
        /// The greatest distance, in model units.
        limit: f64,
    },
    /// The curve is open or closed where the other is wanted.
    #[error("the curve is {declared:?} where the other is wanted; its ends are {gap} apart")]
    WrongExtent {
        /// What the curve declares.
        declared: Extent,
        /// The distance of its ends, in model units.
        gap: f64,
    },
    /// The curve turns back on itself.
    #[error("the curve has a cusp at u = {u}: its branches meet at {angle} rad, less than {limit}")]
    Cusp {
        /// The parameter.
        u: f64,
        /// The angle between the branches, in radians.
        angle: f64,
        /// The smallest angle, in radians.
        limit: f64,
    },
}

/// Every fault of `curve`: first of its list of corners, then of its evaluation, then of its shape.
/// Empty for a sound curve. A corner that is not declared is no fault, but is looked at for a cusp.
///
/// The curve is called under guard. What cannot be evaluated hides the faults of shape. Faults are
/// found at 257 samples and, between them, where the curve turns; a pole between two samples is not.
///
/// ```
/// use core::f64::consts::TAU;
/// use glam::DVec3;
/// use selvedge_components::curve::{Check, CurveFault, Extent, FnCurve, faults};
///
/// let check = Check { extent: Some(Extent::Closed), gap: 1e-9, cusp: 0.1 };
/// let spiral = FnCurve::new(|u| (1.0 + u) * DVec3::new((TAU * u).cos(), (TAU * u).sin(), 0.0)).closed();
/// let found = faults(&spiral, &check);
/// assert!(matches!(found[..], [CurveFault::NotClosed { gap, .. }] if (gap - 1.0).abs() < 1e-12));
/// ```
pub fn faults(curve: &dyn Curve, check: &Check) -> Vec<CurveFault> {
    let about = catch(|| (curve.corners().to_vec(), curve.closed()));
    let (corners, closed) = match about {
        Ok(about) => about,
        Err(message) => {
            let error = CurveError::PanickedAbout { what: "corners and closedness", message };
            return vec![CurveFault::Evaluation { error, to: 1.0 }];
        }
    };
    let mut found = corner_faults(&corners, closed);
    let samples: Vec<_> = (0..=SAMPLES).map(|k| evaluate(curve, parameter(k))).collect();
    let failures = evaluation_faults(curve, &samples);
    if failures.is_empty() {
        let points: Vec<DVec3> = samples.into_iter().flatten().collect();
        found.extend(still_faults(curve, &points));
        found.extend(end_faults(&points, closed, check));
        found.extend(cusps(curve, &points, &corners, check.cusp));
    } else {
        found.extend(failures);
    }
    found
}

fn corner_faults(corners: &[f64], closed: bool) -> Vec<CurveFault> {
    let is_inside = |u: f64| (u > 0.0 && u < 1.0) || (u == 0.0 && closed);
    let outside = corners.iter().enumerate().filter(|&(_, &u)| !is_inside(u));
    let mut found: Vec<_> = outside.map(|(index, &u)| CurveFault::CornerOutOfRange { index, u, closed }).collect();
    let pairs = corners.windows(2).enumerate().filter(|(_, pair)| pair[1] <= pair[0]);
    found.extend(pairs.map(|(i, pair)| CurveFault::CornersUnsorted { index: i + 1, u: pair[1], before: pair[0] }));
    found
}

/// One fault for each run of samples that fail, its ends placed by bisection.
fn evaluation_faults(curve: &dyn Curve, samples: &[Result<DVec3, CurveError>]) -> Vec<CurveFault> {
    let mut found = Vec::new();
    let mut k = 0;
    while k < samples.len() {
        let run = samples[k..].iter().take_while(|s| s.is_err()).count();
        if let Err(error) = &samples[k] {
            let (first, last) = (k as u32, (k + run - 1) as u32);
            let start = (first > 0).then(|| border(curve, parameter(first - 1), parameter(first)));
            let end = (last < SAMPLES).then(|| border(curve, parameter(last + 1), parameter(last)));
            let error = start.and_then(|u| evaluate(curve, u).err()).unwrap_or_else(|| error.clone());
            found.push(CurveFault::Evaluation { error, to: end.unwrap_or(1.0) });
        }
        k += run.max(1);
    }
    found
}

/// The parameter that fails nearest to `sound`, where the curve is sound, on the way to `failing`.
fn border(curve: &dyn Curve, mut sound: f64, mut failing: f64) -> f64 {
    // Each halving gains a bit; a parameter has 53.
    for _ in 0..53 {
        let middle = 0.5 * (sound + failing);
        if evaluate(curve, middle).is_ok() {
            sound = middle;
        } else {
            failing = middle;
        }
    }
    failing
}

/// Runs of intervals over which the curve moves by no more than rounding.
fn still_faults(curve: &dyn Curve, points: &[DVec3]) -> Vec<CurveFault> {
    // Two evaluations of one point differ by a few roundings of its coordinates.
    let size = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let rounding = 4.0 * f64::EPSILON * size;
    let is_near = |p: DVec3, q: DVec3| p.distance(q) <= rounding;
    // The inner samples lie at no simple share, so that a curve that comes round in every interval
    // is not taken for one that stands still.
    let is_still = |k: usize| {
        let inner = [0.381_966, 0.763_932].map(|share| (k as f64 + share) / f64::from(SAMPLES));
        is_near(points[k], points[k + 1])
            && inner.iter().all(|&u| evaluate(curve, u).is_ok_and(|p| is_near(p, points[k])))
    };
    let mut found = Vec::new();
    let mut from = None;
    for k in 0..points.len() {
        let still = k + 1 < points.len() && is_still(k);
        match (from, still) {
            (None, true) => from = Some(k),
            (Some(start), false) => {
                let (from, to) = (parameter(start as u32), parameter(k as u32));
                found.push(CurveFault::ZeroLength { from, to, at: points[start] });
            }
            _ => {}
        }
        from = from.filter(|_| still);
    }
    found
}

fn end_faults(points: &[DVec3], closed: bool, check: &Check) -> Vec<CurveFault> {
    let (first, last) = (points[0], points[points.len() - 1]);
    let gap = first.distance(last);
    let declared = if closed { Extent::Closed } else { Extent::Open };
    let mut found = Vec::new();
    if closed && gap > check.gap {
        found.push(CurveFault::NotClosed { gap, limit: check.gap });
    }
    if check.extent.is_some_and(|wanted| wanted != declared) {
        found.push(CurveFault::WrongExtent { declared, gap });
    }
    found
}

/// Cusps at corners, declared or found.
fn cusps(curve: &dyn Curve, samples: &[DVec3], declared: &[f64], limit: f64) -> Vec<CurveFault> {
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for &u in declared.iter().filter(|u| (0.0..1.0).contains(*u)) {
        if let Ok(Some(by)) = catch(|| turn(curve, u)) {
            corners.push((u, by));
        }
    }
    match find_corners_among(curve, samples, CORNER_TURN) {
        // A corner found within the width at which it was found is the declared one.
        Ok(found) => corners.extend(
            found
                .iter()
                .filter(|c| declared.iter().all(|&u| (u - c.u).abs() > f64::from(1 << 18).recip()))
                .map(|c| (c.u, c.turn)),
        ),
        Err(error) => return vec![CurveFault::Evaluation { error, to: 1.0 }],
    }
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let angles = corners.into_iter().map(|(u, by)| (u, core::f64::consts::PI - by));
    angles
        .filter(|&(_, angle)| angle < limit)
        .map(|(u, angle)| CurveFault::Cusp { u, angle: angle.max(0.0), limit })
        .collect()
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, TAU};

    use super::*;
    use crate::curve::{Circle, FnCurve, Polyline, Segment};

    const ANY: Check = Check { extent: None, gap: 1e-9, cusp: 0.1 };

    #[test]
    fn sound_curves_have_no_faults() {
        let closed = Check { extent: Some(Extent::Closed), ..ANY };
        let circle = Circle::new(DVec3::ONE, DVec3::Z, 2.0).expect("a circle");
        assert_eq!(faults(&circle, &closed), []);
        let square = Polyline::closed(vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y]).expect("a square");
        assert_eq!(faults(&square, &closed), []);
        assert_eq!(faults(&FnCurve::new(move |u| square.position(u)).closed(), &closed), []);
        let segment = Segment { start: DVec3::ZERO, end: DVec3::ONE };
        assert_eq!(faults(&segment, &Check { extent: Some(Extent::Open), ..ANY }), []);
        // Once round in every sampled interval, so that all samples coincide.
        let aliased = FnCurve::new(|u| DVec3::new((256.0 * TAU * u).cos(), (256.0 * TAU * u).sin(), 0.0));
        assert!(!faults(&aliased, &ANY).iter().any(|f| matches!(f, CurveFault::ZeroLength { .. })));
    }

    #[test]
    fn lists_of_corners_are_judged_each_entry_for_itself() {
        let listed = vec![0.0, 0.5, 0.5, 0.2, 1.0, f64::NAN, -0.1];
        let found = faults(&FnCurve::new(|u| DVec3::X * u).with_corners(listed), &ANY);
        let outside: Vec<_> = found
            .iter()
            .filter_map(|f| if let CurveFault::CornerOutOfRange { index, .. } = f { Some(*index) } else { None })
            .collect();
        let unsorted: Vec<_> = found
            .iter()
            .filter_map(|f| if let CurveFault::CornersUnsorted { index, .. } = f { Some(*index) } else { None })
            .collect();
        assert_eq!((outside, unsorted), (vec![0, 4, 5, 6], vec![2, 3]));
    }

    #[test]
    fn what_fails_is_placed_at_its_borders() {
        let curve = FnCurve::new(|u| match u {
            u if u > 0.3 && u < 0.4 => DVec3::NAN,
            u if u > 0.81 => panic!("gone"),
            u => DVec3::X * u,
        });
        let found = faults(&curve, &ANY);
        let [CurveFault::Evaluation { error: nan, to }, CurveFault::Evaluation { error: gone, to: end }] = &found[..]
        else {
            panic!("{found:?}")
        };
        assert!(matches!(nan, CurveError::NotFinite { u, .. } if (u - 0.3).abs() < 1e-15));
        assert!((to - 0.4).abs() < 1e-15 && *end == 1.0);
        assert!(matches!(gone, CurveError::Panicked { u, .. } if (u - 0.81).abs() < 1e-15));
    }

    #[test]
    fn a_curve_without_length_says_where() {
        let point = FnCurve::new(|_| DVec3::ONE);
        let found = faults(&point, &ANY);
        assert_eq!(found, [CurveFault::ZeroLength { from: 0.0, to: 1.0, at: DVec3::ONE }]);
        let pause = FnCurve::new(|u: f64| DVec3::X * (u.min(0.25) + (u - 0.5).max(0.0)));
        assert_eq!(faults(&pause, &ANY), [CurveFault::ZeroLength { from: 0.25, to: 0.5, at: 0.25 * DVec3::X }]);
    }

    #[test]
    fn ends_that_do_not_meet_say_by_how_much() {
        let open = Segment { start: DVec3::ZERO, end: 3.0 * DVec3::X };
        let wanted = Check { extent: Some(Extent::Closed), ..ANY };
        assert_eq!(faults(&open, &wanted), [CurveFault::WrongExtent { declared: Extent::Open, gap: 3.0 }]);
        let false_promise =
            FnCurve::new(|u| (TAU * 0.75 * u).cos() * DVec3::X + (TAU * 0.75 * u).sin() * DVec3::Y).closed();
        let found = faults(&false_promise, &wanted);
        assert!(matches!(found[..], [CurveFault::NotClosed { gap, limit: 1e-9 }] if (gap - 2f64.sqrt()).abs() < 1e-15));
    }

    #[test]
    fn cusps_are_found_declared_or_not() {
        let spike = |half: f64| {
            let (s, c) = f64::sin_cos(half);
            let points = vec![DVec3::new(c, s, 0.0), DVec3::ZERO, DVec3::new(c, -s, 0.0)];
            Polyline::open(points).expect("a spike")
        };
        assert_eq!(faults(&spike(0.06), &ANY), []);
        for half in [0.04, 0.0] {
            let declared = spike(half);
            let bare = declared.clone();
            let curves: [&dyn Curve; 2] = [&declared, &FnCurve::new(move |u| bare.position(u))];
            for curve in curves {
                let found = faults(curve, &ANY);
                let [CurveFault::Cusp { u, angle, limit: 0.1 }] = found[..] else { panic!("{found:?}") };
                assert!((u - 0.5).abs() < 1e-14 && (angle - 2.0 * half).abs() < 1e-7, "{u} {angle}");
            }
        }
        let wide = Check { cusp: FRAC_PI_2 + 0.1, ..ANY };
        let square = Polyline::closed(vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y]).expect("a square");
        assert_eq!(faults(&square, &wide).len(), 4);
    }

    #[test]
    fn whatever_a_curve_does_it_is_a_fault_and_no_panic() {
        #[derive(Debug)]
        struct Hostile;
        impl Curve for Hostile {
            fn position(&self, _: f64) -> DVec3 {
                panic!("never")
            }
            fn corners(&self) -> &[f64] {
                panic!("corners")
            }
        }
        assert!(matches!(faults(&Hostile, &ANY)[..], [CurveFault::Evaluation { to: 1.0, .. }]));
        let noise = FnCurve::new(|u: f64| {
            DVec3::splat((u.to_bits().wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64).with_y(u)
        });
        assert!(matches!(faults(&noise, &ANY)[..], [CurveFault::Evaluation { error: CurveError::Rough { .. }, .. }]));
    }
}
