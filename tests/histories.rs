//! What a world has been through does not show in what it comes to.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DVec2, DVec3};
use selvedge::bevy_ecs::prelude::*;
use selvedge::curve::{Circle, Curve, CurveParameters, Heading};
use selvedge::error::SurfaceFailed;
use selvedge::job::Cancelled;
use selvedge::subdivision::{Border, LoopSurface};
use selvedge::tolerance::Tolerance;
use selvedge::trim::{OtherSide, OtherSideOf, ResultOf, Sides, Stale, Trim, TrimOptions};
use selvedge::{Engine, Pass, TrimProgress};
use support::plate::{circle, plate, tolerance, wide_plate};
use support::world::bits;

/// Passes until nothing is left to do; not forever.
fn settle(engine: &mut Engine) {
    assert!((0..20_000).any(|_| engine.update() == Pass::Idle), "it never comes to rest");
}

struct Bored {
    engine: Engine,
    source: Entity,
    surface: LoopSurface,
}

impl Bored {
    fn of(surface: LoopSurface) -> Self {
        let mut engine = Engine::new();
        let source = engine.spawn_surface(&surface);
        Self { engine, source, surface }
    }

    fn bore(&mut self, at: DVec2, radius: f64) -> (Entity, Entity) {
        self.bore_with(at, radius, TrimOptions::default())
    }

    fn bore_with(&mut self, at: DVec2, radius: f64, options: TrimOptions) -> (Entity, Entity) {
        let curve = self.engine.spawn_curve(circle(&self.surface, at, radius));
        let trim = self.engine.spawn_trim(self.source, &[(curve, Heading::Against)], tolerance(), options);
        (trim, curve)
    }

    fn result(&self) -> Vec<u64> {
        bits(self.engine.surface(self.engine.result(self.source).expect("a result")).unwrap().unwrap())
    }

    fn is_stale(&self) -> bool {
        let result = self.engine.result(self.source).expect("a result");
        self.engine.world().get::<Stale>(result).is_some()
    }
}

#[test]
fn a_refused_trim_leaves_a_stale_result() {
    let mut plate = Bored::of(plate());
    let (_, curve) = plate.bore(DVec2::ZERO, 0.05);
    settle(&mut plate.engine);
    plate.engine.world_mut().despawn(curve);
    settle(&mut plate.engine);
    assert!(plate.is_stale());
}

#[test]
fn when_the_last_good_trim_goes_its_result_is_not_the_present_one() {
    let mut plate = Bored::of(plate());
    let (good, _) = plate.bore(DVec2::ZERO, 0.05);
    let (_, curve) = plate.bore(DVec2::new(0.01, 0.0), 0.05);
    plate.engine.world_mut().despawn(curve);
    settle(&mut plate.engine);
    plate.engine.world_mut().despawn(good);
    settle(&mut plate.engine);
    assert!(plate.engine.result(plate.source).is_none_or(|_| plate.is_stale()));
}

#[test]
fn results_go_with_their_source() {
    let mut plate = Bored::of(plate());
    let options = TrimOptions { sides: Sides::Both, ..TrimOptions::default() };
    let (trim, _) = plate.bore_with(DVec2::ZERO, 0.05, options);
    settle(&mut plate.engine);
    let source = plate.source;
    plate.engine.despawn_surface(source);
    settle(&mut plate.engine);
    settle(&mut plate.engine);
    let world = plate.engine.world_mut();
    let left = world.query_filtered::<Entity, Or<(With<ResultOf>, With<OtherSideOf>)>>().iter(world).count();
    assert_eq!(left, 0);
    assert!(world.get::<OtherSide>(trim).is_none());
}

#[test]
fn a_number_that_is_none_does_not_keep_the_world_busy() {
    let mut plate = Bored::of(plate());
    let (bad, _) = plate.bore(DVec2::new(0.1, 0.0), 0.03);
    let away = plate.engine.spawn_curve(Arc::new(Circle::new(DVec3::Z * 0.3, DVec3::Z, 0.05).unwrap()));
    let source = plate.source;
    let near = plate.engine.spawn_curve(circle(&plate.surface, DVec2::ZERO, 0.03));
    let cuts = [(near, Heading::Against), (away, Heading::Against)];
    plate.engine.spawn_trim(source, &cuts, tolerance(), TrimOptions::default());
    plate.engine.world_mut().entity_mut(bad).insert(Tolerance { fit: f64::NAN, chord: 1.0, curve: 1.0 });
    settle(&mut plate.engine);
}

#[test]
fn what_is_no_trim_any_more_is_not_worked_on() {
    let mut plate = Bored::of(plate());
    let (trim, _) = plate.bore(DVec2::ZERO, 0.05);
    for _ in 0..8 {
        plate.engine.update();
    }
    plate.engine.world_mut().entity_mut(trim).remove::<Trim>();
    settle(&mut plate.engine);
}

#[test]
fn a_trim_taken_back_names_no_other_side() {
    let mut plate = Bored::of(plate());
    let options = TrimOptions { sides: Sides::Both, ..TrimOptions::default() };
    let (trim, _) = plate.bore_with(DVec2::ZERO, 0.05, options);
    settle(&mut plate.engine);
    plate.engine.world_mut().entity_mut(trim).insert(Cancelled);
    settle(&mut plate.engine);
    assert!(plate.engine.other_side(trim).is_none_or(|other| plate.engine.world().get_entity(other).is_ok()));
}

#[test]
fn other_sides_are_stale_while_what_they_are_made_of_is_made_again() {
    let mut plate = Bored::of(wide_plate(60));
    let options = TrimOptions { sides: Sides::Both, ..TrimOptions::default() };
    let (wide, _) = plate.bore_with(DVec2::ZERO, 1.1, options);
    let (within, _) = plate.bore(DVec2::ZERO, 0.06);
    settle(&mut plate.engine);
    let other = plate.engine.other_side(wide).expect("another side");
    let Some(TrimProgress::Finished(report)) = plate.engine.trim_progress(wide) else { panic!("it is made") };
    assert_eq!(report.together, [wide], "they do not touch");
    let before = plate.engine.surface(other).unwrap().unwrap().mesh.euler();
    assert_eq!(before, 0);
    plate.engine.world_mut().get_mut::<Tolerance>(within).unwrap().fit *= 0.9;
    plate.engine.update();
    plate.engine.update();
    assert!(plate.engine.world().get::<Stale>(other).is_some());
}

/// A curve that can change inside.
#[derive(Debug)]
struct Moody(Arc<AtomicU64>);

impl Curve for Moody {
    fn position(&self, u: f64) -> DVec3 {
        if self.0.load(Ordering::Relaxed) == 0 { DVec3::NAN } else { DVec3::new(u, 0.0, 0.0) }
    }

    fn revision(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

#[test]
fn a_border_that_is_mended_inside_mends_its_surface() {
    let revision = Arc::new(AtomicU64::new(0));
    let mesh = Arc::new(selvedge::mesh::Connectivity::new(4, &[[0, 1, 2], [0, 2, 3]]).unwrap());
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
    let corners = [0, 1].map(selvedge::mesh::VertexId);
    let mut surface = LoopSurface::plain(mesh, points, &corners);
    let curve = Arc::new(CurveParameters::even(Arc::new(Moody(revision.clone())), 1).unwrap());
    surface.sides[0].border = Border::Given { curve, first: 0, heading: Heading::Along };
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&surface);
    engine.update();
    assert!(engine.world().get::<SurfaceFailed>(surface).is_some());
    revision.store(1, Ordering::Relaxed);
    engine.update();
    engine.update();
    assert!(engine.world().get::<SurfaceFailed>(surface).is_none());
}

/// The lead of two trims goes, and another that fails is tried again and fails at once: the one that is left
/// is made by itself all the same.
#[test]
fn trims_part_from_one_that_is_taken_back_though_another_fails() {
    let run = |is_edited: bool| {
        let mut plate = Bored::of(plate());
        let (first, _) = plate.bore(DVec2::ZERO, 0.05);
        let (second, _) = plate.bore(DVec2::new(0.06, 0.0), 0.05);
        let away = plate.engine.spawn_curve(Arc::new(Circle::new(DVec3::Z * 0.3, DVec3::Z, 0.05).expect("a circle")));
        let source = plate.source;
        plate.engine.spawn_trim(source, &[(away, Heading::Against)], tolerance(), TrimOptions::default());
        if is_edited {
            settle(&mut plate.engine);
        }
        plate.engine.world_mut().entity_mut(first).insert(Cancelled);
        settle(&mut plate.engine);
        let Some(TrimProgress::Finished(report)) = plate.engine.trim_progress(second) else { panic!("it is made") };
        assert_eq!(report.together, [second]);
        assert!(!plate.is_stale());
        plate.result()
    };
    assert_eq!(run(true), run(false));
}
