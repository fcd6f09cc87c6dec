//! Curves that nothing can be trimmed by: each is refused by what it is, with the place, and the
//! source is as it was.

mod support;

use core::f64::consts::TAU;
use std::sync::Arc;

use bevy_ecs::entity::Entity;
use glam::{DVec2, DVec3};
use selvedge::curve::{Curve, CurveError, CurveFault, FnCurve, Heading, Polyline, Segment};
use selvedge::evaluate::{Evaluate, SurfacePoint};
use selvedge::subdivision::remesh::{PreImageError, RemeshError};
use selvedge::subdivision::{DetailOf, LoopSurface};
use selvedge::tolerance::Tolerance;
use selvedge::trim::{TrimFailed, TrimFault, TrimOptions};
use selvedge::{Engine, TrimProgress};
use selvedge_systems::subdivision::limit::LimitSurface;
use support::plate::{TOLERANCE, circle, laid, plate, tolerance};
use support::world::bits;

/// A source of its own, and what came of trims of it.
struct Stage {
    engine: Engine,
    source: Entity,
    surface: LoopSurface,
}

impl Stage {
    fn new() -> Self {
        let (mut engine, surface) = (Engine::new(), plate());
        let source = engine.spawn_surface(&surface);
        Self { engine, source, surface }
    }

    fn trim(&mut self, curve: Arc<dyn Curve>, heading: Heading, tolerance: Option<Tolerance>) -> Entity {
        let cut = [(self.engine.spawn_curve(curve), heading)];
        self.engine.spawn_trim(self.source, &cut, tolerance, TrimOptions::default())
    }

    fn failure(&mut self, trim: Entity) -> TrimFailed {
        self.engine.settle().expect("trims end");
        match self.engine.trim_progress(trim) {
            Some(TrimProgress::Failed(failed)) => failed,
            other => panic!("{other:?}"),
        }
    }

    /// Nothing has come of it, and the source has its bits.
    fn is_untouched(&mut self) {
        let now = self.engine.surface(self.source).expect("gathered").expect("sound");
        assert_eq!(bits(now), bits(&self.surface));
        assert_eq!(self.engine.result(self.source), None);
        let world = self.engine.world_mut();
        assert_eq!(world.query::<&DetailOf>().iter(world).count(), 0);
    }
}

fn flat(p: DVec2) -> DVec3 {
    p.extend(0.0)
}

/// A closed curve over the plane, laid on the plate.
fn on_plate(of: &LoopSurface, plane: impl Fn(f64) -> DVec2 + Send + Sync + 'static) -> Arc<dyn Curve> {
    laid(of, FnCurve::new(move |u| flat(plane(u))).closed())
}

fn eight(u: f64) -> DVec2 {
    DVec2::new(0.013 + 0.12 * (TAU * u).sin(), 0.007 + 0.06 * (2.0 * TAU * u).sin())
}

/// The border of a plate, all of it.
fn along_border(of: &LoopSurface) -> Arc<dyn Curve> {
    let (limit, mesh) = (LimitSurface::new(Arc::new(of.clone())).expect("sound"), Arc::clone(&of.mesh));
    let border = mesh.border_loops()[0].clone();
    let n = border.len();
    let corners = (0..n).filter(|&i| mesh.valence(border[i]) < 4).map(|i| i as f64 / n as f64).collect();
    let at = move |u: f64| {
        let x = u * n as f64;
        let i = (x.floor() as usize).min(n - 1);
        let h = mesh.outgoing(border[i]);
        let mut weights = [0.0; 3];
        (weights[h.corner()], weights[h.next().corner()]) = (1.0 - (x - i as f64), x - i as f64);
        limit.position(SurfacePoint::new(h.face(), weights[1], weights[2]))
    };
    Arc::new(FnCurve::new(at).closed().with_corners(corners))
}

type Refused = fn(&TrimFault) -> bool;
type Case = (&'static str, fn(&LoopSurface) -> Arc<dyn Curve>, Option<Tolerance>, Refused);

fn within(fit: f64) -> Option<Tolerance> {
    Some(Tolerance { fit, chord: TOLERANCE, curve: TOLERANCE })
}

fn cases() -> Vec<Case> {
    let fine = tolerance();
    vec![
        (
            "crosses itself",
            |of| on_plate(of, eight),
            fine,
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::PreImage { curve: 0, source: PreImageError::Crossing { curves: [0, 0], at, .. } })
                if at.truncate().distance(DVec2::new(0.013, 0.007)) < 1e-3)
            },
        ),
        (
            "crosses itself in the pre-image alone",
            |of| {
                let on = on_plate(of, eight);
                Arc::new(FnCurve::new(move |u| on.position(u) + 0.5e-3 * (TAU * u).cos() * DVec3::Z).closed())
            },
            Some(Tolerance { fit: 2e-3, chord: 2e-3, curve: 2e-3 }),
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::PreImage { curve: 0, source: PreImageError::Crossing { curves: [0, 0], at, .. } })
                if at.truncate().distance(DVec2::new(0.013, 0.007)) < 1e-3)
            },
        ),
        (
            "is open where it must be closed",
            |of| laid(of, Segment { start: flat(DVec2::new(-0.05, 0.0)), end: flat(DVec2::new(0.05, 0.01)) }),
            fine,
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::PreImage { curve: 0, source: PreImageError::EndsInside { u: 0.0, at, gap } })
                if at.x == -0.05 && (gap - 0.1).abs() < 2e-3)
            },
        ),
        (
            "comes in across the border and ends",
            |of| laid(of, Segment { start: flat(DVec2::new(-0.5, 0.0)), end: flat(DVec2::new(0.05, 0.01)) }),
            fine,
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::PreImage { curve: 0, source: PreImageError::EndsInside { u: 1.0, at, .. } })
                if at.x == 0.05)
            },
        ),
        (
            "is not a number somewhere",
            |_| Arc::new(FnCurve::new(|u| if u > 0.4 { DVec3::NAN } else { DVec3::X * 0.1 * u })),
            fine,
            |why| {
                matches!(why, TrimFault::CurveFailed { first, .. }
                if matches!(&**first, CurveFault::Evaluation { error: CurveError::NotFinite { u, .. }, .. } if (u - 0.4).abs() < 1e-12))
            },
        ),
        (
            "panics somewhere",
            |_| Arc::new(FnCurve::new(|u: f64| if u > 0.4 { panic!("at {u}") } else { DVec3::X * 0.1 * u })),
            fine,
            |why| {
                matches!(why, TrimFault::CurveFailed { first, .. }
                if matches!(&**first, CurveFault::Evaluation { error: CurveError::Panicked { u, .. }, .. } if (u - 0.4).abs() < 1e-12))
            },
        ),
        (
            "has no length",
            |_| Arc::new(FnCurve::new(|_| DVec3::new(0.01, 0.02, 0.0)).closed()),
            fine,
            |why| {
                matches!(why, TrimFault::CurveFailed { first, .. }
                if matches!(&**first, CurveFault::ZeroLength { from: 0.0, to: 1.0, at } if *at == DVec3::new(0.01, 0.02, 0.0)))
            },
        ),
        (
            "misses the surface",
            |of| {
                let on = circle(of, DVec2::ZERO, 0.05);
                Arc::new(FnCurve::new(move |u| on.position(u) + DVec3::X).closed())
            },
            fine,
            |why| matches!(why, TrimFault::Misses { curve: 0, distance, at, limit, .. } if *distance > 0.5 && at.x > 0.9 && *limit == TOLERANCE),
        ),
        ("runs along the border", along_border, fine, |why| {
            matches!(why, TrimFault::Remesh(RemeshError::AlongBorder { curve: 0, at, angle, .. })
                if at.truncate().abs().max_element() > 0.19 && *angle < 1e-3)
        }),
        (
            "touches the border with a corner",
            |of| {
                let corners = [DVec3::new(0.2, 0.02, 0.0), DVec3::new(0.1, 0.09, 0.0), DVec3::new(0.1, -0.04, 0.0)];
                laid(of, Polyline::closed(corners.to_vec()).expect("a triangle"))
            },
            fine,
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::TouchesBorder { curve: 0, u, at })
                if (u - u.round()).abs() < 1e-12 && at.truncate().distance(DVec2::new(0.2, 0.02)) < 1e-9)
            },
        ),
        (
            "lies above the surface",
            |of| {
                let on = circle(of, DVec2::ZERO, 0.05);
                Arc::new(FnCurve::new(move |u| on.position(u) + 0.01 * DVec3::Z).closed())
            },
            fine,
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::PreImage { curve: 0, source: PreImageError::TooFarOff { distance, .. } })
                if (distance - 0.01).abs() < 2e-3)
            },
        ),
        (
            "has a cusp that is not declared",
            |of| {
                on_plate(of, |u| {
                    let angle = TAU * (u - 0.5);
                    0.04 * (1.0 - angle.cos()) * DVec2::from_angle(angle) + DVec2::new(0.01, 0.0)
                })
            },
            fine,
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::Cusp { curve: 0, u, at, angle, .. })
                if (u - 0.5).abs() < 1e-3 && at.truncate().distance(DVec2::new(0.01, 0.0)) < 1e-4 && *angle < 5.0)
            },
        ),
        (
            "has a corner like a needle",
            |of| {
                laid(
                    of,
                    Polyline::closed(vec![
                        flat(DVec2::new(-0.1, 0.0)),
                        flat(DVec2::new(0.1, 0.004)),
                        flat(DVec2::new(0.1, -0.004)),
                    ])
                    .expect("three points"),
                )
            },
            fine,
            |why| {
                matches!(why, TrimFault::Remesh(RemeshError::Cusp { curve: 0, at, angle, .. })
                if at.truncate().distance(DVec2::new(-0.1, 0.0)) < 1e-9 && (angle - 2.29).abs() < 0.1)
            },
        ),
        (
            "is smaller than the tolerance",
            |of| circle(of, DVec2::ZERO, 1e-6),
            fine,
            |why| matches!(why, TrimFault::TooSmall { curve: 0, size, tolerance, .. } if *size < 4e-6 && *tolerance == TOLERANCE),
        ),
        (
            "tolerance is negative",
            |of| circle(of, DVec2::ZERO, 0.05),
            within(-1.0),
            |why| matches!(why, TrimFault::BadNumber { value: -1.0, .. }),
        ),
        (
            "tolerance is zero",
            |of| circle(of, DVec2::ZERO, 0.05),
            within(0.0),
            |why| matches!(why, TrimFault::BadNumber { value: 0.0, .. }),
        ),
        (
            "tolerance is not a number",
            |of| circle(of, DVec2::ZERO, 0.05),
            within(f64::NAN),
            |why| matches!(why, TrimFault::BadNumber { value, .. } if value.is_nan()),
        ),
        (
            "tolerance is below rounding",
            |of| circle(of, DVec2::ZERO, 0.05),
            within(1e-17),
            |why| matches!(why, TrimFault::BelowRounding { value: 1e-17, limit, .. } if *limit < 1e-14),
        ),
    ]
}

#[test]
fn every_bad_curve_is_refused_by_what_it_is_and_leaves_the_source_alone() {
    for (name, curve, tolerance, refused) in cases() {
        let mut stage = Stage::new();
        let trim = stage.trim(curve(&stage.surface), Heading::Against, tolerance);
        let failed = stage.failure(trim);
        assert!(refused(&failed.why), "{name}: {:?}", failed.why);
        assert_eq!(failed.with, None, "{name}");
        stage.is_untouched();
    }
}

/// Two trims along one line: the newer fails, names the older and the place, and the older stands.
#[test]
fn of_two_trims_along_one_curve_the_newer_fails_and_names_the_other() {
    let square = |of: &LoopSurface, right: f64| {
        let corners = [(-0.07, -0.05), (-0.07, 0.05), (right, 0.05), (right, -0.05)];
        laid(of, Polyline::closed(corners.map(|(x, y)| flat(DVec2::new(x, y))).to_vec()).expect("a square"))
    };
    let turned = |of: &LoopSurface| {
        let of = circle(of, DVec2::new(0.01, 0.0), 0.06);
        Arc::new(FnCurve::new(move |u: f64| of.position((u + 0.377).fract())).closed()) as Arc<dyn Curve>
    };
    let round = |of: &LoopSurface| circle(of, DVec2::new(0.01, 0.0), 0.06);
    let stage = Stage::new();
    let of = &stage.surface;
    let one = round(of);
    let pairs = [
        ("the very curve", Arc::clone(&one), one, Heading::Against),
        ("a curve of the same shape", round(of), round(of), Heading::Against),
        ("the other side of the curve", round(of), round(of), Heading::Along),
        ("the same circle from elsewhere", round(of), turned(of), Heading::Against),
        ("a square with three sides in common", square(of, 0.03), square(of, 0.06), Heading::Along),
    ];
    for (name, first, second, heading) in pairs {
        let mut stage = Stage::new();
        let older =
            stage.trim(first, if name.contains("square") { Heading::Along } else { Heading::Against }, tolerance());
        let newer = stage.trim(second, heading, tolerance());
        let failed = stage.failure(newer);
        assert_eq!(failed.with, Some(older), "{name}");
        match failed.why {
            TrimFault::Remesh(RemeshError::Coincident { curves: [0, 0], u, at, distance }) => {
                assert!(distance < 1e-9 && u.iter().all(|u| (0.0..=1.0).contains(u)) && at.is_finite(), "{name}");
            }
            TrimFault::Remesh(RemeshError::Tangential { curves: [0, 0], at, angle, .. }) => {
                assert!(angle < 1e-3 && at.is_finite(), "{name}: {angle}");
            }
            other => panic!("{name}: {other:?}"),
        }
        assert!(matches!(stage.engine.trim_progress(older), Some(TrimProgress::Finished(_))), "{name}");
    }
}

type Plane = Arc<dyn Fn(f64) -> DVec2 + Send + Sync>;

/// Closed plane curves with a cusp at a parameter, and where their cusp is.
fn cusped(at: f64) -> [(&'static str, Plane, DVec2); 3] {
    let cardioid = move |u: f64| {
        let angle = TAU * (u - at);
        0.04 * (1.0 - angle.cos()) * DVec2::from_angle(angle) + DVec2::new(0.01, 0.0)
    };
    // The other two of its cusps come a third of the way before and after.
    let deltoid = move |u: f64| {
        let angle = TAU * (u - at);
        0.03 * DVec2::new(2.0 * angle.cos() + (2.0 * angle).cos(), 2.0 * angle.sin() - (2.0 * angle).sin())
    };
    // A periodic cubic B-spline whose derivative is zero in the middle of one of its spans.
    let control = [(0.05, 0.04), (-0.01, 0.0), (0.01, 0.0), (-0.05, 0.04), (0.0, 0.12)];
    let control = control.map(|(x, y)| DVec2::new(x, y));
    let spline = move |u: f64| {
        let t = 5.0 * (u - at + 0.3).rem_euclid(1.0);
        let (k, t) = (t.floor() as usize, t.fract());
        let weights =
            [(1.0 - t).powi(3), 3.0 * t.powi(3) - 6.0 * t * t + 4.0, 1.0 + 3.0 * (t + t * t - t.powi(3)), t.powi(3)];
        weights.iter().enumerate().map(|(i, w)| control[(k + i + 4) % 5] * (w / 6.0)).sum()
    };
    let middle = spline(at);
    [
        ("cardioid", Arc::new(cardioid), DVec2::new(0.01, 0.0)),
        ("deltoid", Arc::new(deltoid), DVec2::new(0.09, 0.0)),
        ("spline", Arc::new(spline), middle),
    ]
}

#[test]
fn a_cusp_is_found_wherever_it_lies() {
    let mut missed = Vec::new();
    for at in [0.0, 0.3, 0.123456, 1.0 / 3.0, 0.4721359549995796, 0.9442719099991592] {
        for (name, plane, tip) in cusped(at) {
            for heading in [Heading::Along, Heading::Against] {
                let mut stage = Stage::new();
                let plane = Arc::clone(&plane);
                let curve = on_plate(&stage.surface, move |u| plane(u));
                let trim = stage.trim(curve, heading, tolerance());
                let why = stage.failure(trim).why;
                let TrimFault::Remesh(RemeshError::Cusp { curve: 0, u, at: point, angle, .. }) = why else {
                    missed.push(format!("{name} {at} {heading:?}: {why}"));
                    continue;
                };
                // A deltoid has three; the first of them along the curve is told.
                let turns = if name == "deltoid" { 3.0 } else { 1.0 };
                let off = (u - at) * turns;
                let apart =
                    if turns == 1.0 { point.truncate().distance(tip) } else { point.truncate().length() - 0.09 };
                if (off - off.round()).abs() > 1e-5 || apart.abs() > 1e-9 || angle > 1.0 {
                    missed.push(format!("{name} {at} {heading:?}: {why}"));
                }
                stage.is_untouched();
            }
        }
    }
    assert!(missed.is_empty(), "{missed:#?}");
}

#[test]
fn what_bends_sharply_and_does_not_turn_back_is_no_cusp() {
    // A stadium whose ends are half circles of a hundredth of its width, from anywhere on.
    let slot = |radius: f64, from: f64| {
        let (arc, line) = (0.5 * TAU * radius, 0.12);
        move |u: f64| {
            let s = (u + from).rem_euclid(1.0) * 2.0 * (arc + line);
            let (half, s) = (if s < arc + line { 1.0 } else { -1.0 }, s % (arc + line));
            let p = if s < line {
                DVec2::new(s - 0.06, -radius)
            } else {
                DVec2::new(0.06, 0.0) + radius * DVec2::from_angle((s - line) / radius - 0.25 * TAU)
            };
            half * p
        }
    };
    for (radius, from) in [(0.02, 0.123), (0.006, 0.3), (0.004, 0.0)] {
        let mut stage = Stage::new();
        let curve = on_plate(&stage.surface, slot(radius, from));
        let trim = stage.trim(curve, Heading::Against, tolerance());
        stage.engine.settle().expect("trims end");
        let progress = stage.engine.trim_progress(trim);
        assert!(matches!(progress, Some(TrimProgress::Finished(_))), "{radius}: {progress:?}");
    }
}
