//! Curves are checked some in a pass, and trims wait for those that they read.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::entity::Entity;
use glam::{DVec2, DVec3};
use selvedge::curve::{Curve, FnCurve, Heading};
use selvedge::error::{CurveFailed, CurveUnchecked};
use selvedge::trim::{TrimFault, TrimOptions};
use selvedge::{Engine, Pass, TrimProgress};
use support::plate::{circle, tolerance, wide_plate};

/// A curve that notes that it was asked.
fn counted(curve: Arc<dyn Curve>, asked: &Arc<AtomicU64>, bit: u32) -> Arc<dyn Curve> {
    let asked = Arc::clone(asked);
    Arc::new(
        FnCurve::new(move |u| {
            asked.fetch_or(1 << bit, Ordering::Relaxed);
            curve.position(u)
        })
        .closed(),
    )
}

#[test]
fn a_pass_checks_some_of_many_curves_and_is_not_idle_before_the_last() {
    let (mut engine, asked) = (Engine::new(), Arc::new(AtomicU64::new(0)));
    let circle = |k: u32| -> Arc<dyn Curve> {
        let far = f64::from(k);
        Arc::new(FnCurve::new(move |u: f64| DVec3::new(far + (6.0 * u).cos(), (6.0 * u).sin(), 0.0)))
    };
    let curves: Vec<Entity> = (0..40).map(|k| engine.spawn_curve(counted(circle(k), &asked, k))).collect();
    for done in [8, 16, 24, 32, 40] {
        let pass = engine.update();
        assert_eq!(asked.load(Ordering::Relaxed).count_ones(), done);
        let waiting = curves.iter().filter(|&&curve| engine.world().get::<CurveUnchecked>(curve).is_some()).count();
        assert_eq!(waiting, 40 - done as usize);
        assert_eq!(pass == Pass::Idle, done == 40);
    }
    // They do not close.
    assert!(curves.iter().all(|&curve| engine.world().get::<CurveFailed>(curve).is_some()));
}

#[test]
fn trims_wait_for_their_curves_to_be_checked_and_one_that_is_not_sound_is_refused() {
    let (mut engine, surface) = (Engine::new(), wide_plate(16));
    let source = engine.spawn_surface(&surface);
    let mut trims = Vec::new();
    for k in 0..24_u32 {
        let centre = DVec2::new(f64::from(k % 6) - 2.5, f64::from(k / 6) - 1.5) * 0.12;
        let mut curve = circle(&surface, centre, 0.01);
        if k == 20 {
            let of = curve;
            curve = Arc::new(FnCurve::new(move |u| if u > 0.5 { DVec3::NAN } else { of.position(u) }).closed());
        }
        let cut = [(engine.spawn_curve(curve), Heading::Against)];
        trims.push(engine.spawn_trim(source, &cut, tolerance(), TrimOptions::default()));
    }
    engine.settle().expect("nothing stalls");
    for (k, &trim) in trims.iter().enumerate() {
        match engine.trim_progress(trim) {
            Some(TrimProgress::Finished(_)) => assert_ne!(k, 20),
            Some(TrimProgress::Failed(why)) => {
                assert!(k == 20 && matches!(why.why, TrimFault::CurveFailed { .. }), "{k}: {}", why.why);
            }
            other => panic!("{k}: {other:?}"),
        }
    }
    assert!(engine.result(source).is_some());
}
