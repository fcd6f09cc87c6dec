//! Trims in a world: a quantum a pass, together where they touch, taken back without a trace.

mod support;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use selvedge::curve::{Circle, Curve, FnCurve, Heading, SpaceCurve};
use selvedge::diagnostics::SubdivisionDiagnostics;
use selvedge::io::{Cage, Limits, obj};
use selvedge::job::Cancelled;
use selvedge::mesh::Connectivity;
use selvedge::subdivision::{ControlPoints, DetailOf, LoopSurface, Position, Snapshot};
use selvedge::tolerance::Tolerance;
use selvedge::trim::{
    ResultOf, Stale, Trim, TrimFailed, TrimFault, TrimJob, TrimOptions, TrimReport, TrimState, TrimmedTo,
};
use selvedge::{despawn_surface, spawn_curve, spawn_surface, spawn_trim};
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::projected_curve::{Pick, ProjectedCurve};
use selvedge_systems::subdivision::limit::LimitSurface;
use support::world::{bits, host};

const TOLERANCE: f64 = 13e-6;

fn plate() -> LoopSurface {
    let polygons = obj::read(include_bytes!("../data/plates/plate8.obj"), &Limits::default()).expect("a plate");
    let cage = Cage::from_polygons(polygons).expect("a cage");
    let mesh = Arc::new(Connectivity::new(cage.positions.len(), &cage.triangles).expect("sound"));
    let corners: Vec<_> = mesh.border_loops()[0].iter().copied().filter(|&v| mesh.valence(v) < 4).collect();
    LoopSurface::plain(mesh, cage.positions, &corners)
}

/// The circle about `centre` on `surface`, seen from above.
fn circle(surface: &LoopSurface, centre: DVec2, radius: f64) -> Arc<dyn Curve> {
    let limit = LimitSurface::new(Arc::new(surface.clone())).expect("sound");
    let index = Arc::new(SurfaceIndex::new(Arc::new(limit)).expect("finite"));
    let above = Circle::new(centre.extend(0.1), DVec3::Z, radius).expect("a circle");
    Arc::new(ProjectedCurve::new(Arc::new(above), DVec3::NEG_Z, index, Pick::First).expect("a direction"))
}

fn tolerance() -> Option<Tolerance> {
    Some(Tolerance { fit: TOLERANCE, chord: TOLERANCE, curve: TOLERANCE })
}

/// A world with a plate and bores in it.
struct Plate {
    world: World,
    schedule: Schedule,
    source: Entity,
    surface: LoopSurface,
}

impl Plate {
    fn new() -> Self {
        let (mut world, schedule) = host();
        let surface = plate();
        let source = spawn_surface(&mut world, &surface);
        Self { world, schedule, source, surface }
    }

    fn bore(&mut self, centre: DVec2, radius: f64) -> Entity {
        let curve = spawn_curve(&mut self.world, circle(&self.surface, centre, radius));
        self.cut(curve, Heading::Against)
    }

    fn cut(&mut self, curve: Entity, heading: Heading) -> Entity {
        spawn_trim(&mut self.world, self.source, &[(curve, heading)], tolerance(), TrimOptions::default())
    }

    fn run(&mut self) {
        self.schedule.run(&mut self.world);
        self.world.clear_trackers();
    }

    /// Passes until no trim is at work. Returns how many.
    fn settle(&mut self) -> u64 {
        for passes in 1..10_000 {
            self.run();
            let mut jobs = self.world.query::<(Option<&TrimJob>, &Trim)>();
            if jobs.iter(&self.world).all(|(job, _)| job.is_some_and(|job| !job.is_running())) {
                self.run();
                return passes;
            }
        }
        panic!("trims do not end");
    }

    fn state(&self, trim: Entity) -> TrimState {
        self.world.get::<TrimJob>(trim).expect("the trim was begun").state
    }

    fn report(&self, trim: Entity) -> &TrimReport {
        if let Some(failed) = self.world.get::<TrimFailed>(trim) {
            panic!("{failed}");
        }
        self.world.get::<TrimReport>(trim).expect("the trim is done")
    }

    fn failure(&self, trim: Entity) -> &TrimFault {
        &self.world.get::<TrimFailed>(trim).expect("the trim has failed").why
    }

    fn result(&self) -> Option<&LoopSurface> {
        let result = self.world.get::<TrimmedTo>(self.source)?;
        Some(&self.world.get::<Snapshot>(result.0).expect("a result has a snapshot").surface)
    }

    fn details(&mut self) -> usize {
        self.world.query::<&DetailOf>().iter(&self.world).count()
    }

    fn source_bits(&self) -> Vec<u64> {
        bits(&self.world.get::<Snapshot>(self.source).expect("gathered").surface)
    }
}

#[test]
fn a_bore_leaves_a_result_beside_its_source() {
    let mut plate = Plate::new();
    plate.run();
    let before = plate.source_bits();
    let trim = plate.bore(DVec2::new(0.013, -0.007), 0.06);
    plate.settle();
    let report = plate.report(trim).clone();
    assert!(report.audit.greatest().0 <= TOLERANCE);
    assert_eq!(report.together, [trim]);
    assert_eq!(plate.source_bits(), before, "the source is as it was");
    assert_eq!(plate.details(), report.details, "counts are those of the world");
    let result = plate.result().expect("a result");
    assert_eq!(result.mesh.euler(), 0);
    assert_eq!(result.details.count(), report.details);
}

#[test]
fn nothing_happens_when_nothing_has_changed() {
    let mut plate = Plate::new();
    plate.bore(DVec2::ZERO, 0.05);
    plate.settle();
    let written = |plate: &Plate| {
        let d = plate.world.resource::<SubdivisionDiagnostics>();
        [d.admit, d.locate, d.remesh, d.refine, d.audit, d.compose, d.advance].map(|c| c.written)
    };
    let before = written(&plate);
    let points = plate.world.get::<ControlPoints>(plate.source).expect("a surface").0.clone();
    plate.world.get_mut::<Position>(points[3]).expect("a point").set_changed();
    for _ in 0..3 {
        plate.run();
    }
    assert_eq!(written(&plate), before);
}

#[test]
fn an_edit_of_the_source_is_trimmed_anew() {
    let mut plate = Plate::new();
    let trim = plate.bore(DVec2::ZERO, 0.05);
    plate.settle();
    let before = bits(plate.result().expect("a result"));
    let points = plate.world.get::<ControlPoints>(plate.source).expect("a surface").0.clone();
    let old = *plate.world.get::<Position>(points[40]).expect("a point");
    plate.world.get_mut::<Position>(points[40]).expect("a point").0.z += 1e-6;
    plate.run();
    let result = plate.world.get::<TrimmedTo>(plate.source).expect("a result").0;
    assert!(plate.world.get::<Stale>(result).is_some(), "the last good result says that it is old");
    plate.settle();
    assert!(plate.world.get::<Stale>(result).is_none());
    assert!(plate.report(trim).audit.greatest().0 <= TOLERANCE);
    assert_ne!(bits(plate.result().expect("a result")), before);
    *plate.world.get_mut::<Position>(points[40]).expect("a point") = old;
    plate.run();
    plate.settle();
    assert_eq!(bits(plate.result().expect("a result")), before, "the way back leads to the same bits");
}

#[test]
fn two_bores_leave_what_both_leave() {
    let mut plate = Plate::new();
    let first = plate.bore(DVec2::new(-0.09, 0.0), 0.04);
    let second = plate.bore(DVec2::new(0.09, 0.02), 0.05);
    plate.settle();
    for trim in [first, second] {
        assert!(plate.report(trim).audit.greatest().0 <= TOLERANCE);
    }
    assert_eq!(plate.result().expect("a result").mesh.euler(), -1);
    // One is moved: the other stays.
    let moved = circle(&plate.surface, DVec2::new(0.09, -0.03), 0.05);
    let curve = plate.world.get::<Trim>(second).expect("a trim").cuts[0].curve;
    *plate.world.get_mut::<SpaceCurve>(curve).expect("a curve") = SpaceCurve { curve: moved };
    plate.run();
    plate.settle();
    assert_eq!(plate.result().expect("a result").mesh.euler(), -1);
    plate.world.despawn(first);
    plate.run();
    plate.settle();
    assert_eq!(plate.result().expect("a result").mesh.euler(), 0);
    plate.world.despawn(second);
    plate.run();
    plate.run();
    assert!(plate.result().is_none(), "what is left of a source without trims is the source");
    assert_eq!(plate.details(), 0);
    let mut results = plate.world.query::<&ResultOf>();
    assert_eq!(results.iter(&plate.world).count(), 0);
}

#[test]
fn a_cancelled_trim_leaves_no_trace() {
    let mut plate = Plate::new();
    let trim = plate.bore(DVec2::ZERO, 0.05);
    for _ in 0..12 {
        plate.run();
    }
    assert!(plate.state(trim).is_running());
    plate.world.entity_mut(trim).insert(Cancelled);
    plate.run();
    assert!(plate.world.get::<TrimJob>(trim).is_none());
    assert_eq!(plate.details(), 0);
    assert!(plate.result().is_none());
    plate.world.entity_mut(trim).remove::<Cancelled>();
    plate.run();
    plate.settle();
    assert!(plate.report(trim).details > 0);
}

#[test]
fn a_trim_that_fails_is_skipped_and_the_others_are_made() {
    let mut plate = Plate::new();
    let good = plate.bore(DVec2::ZERO, 0.05);
    let away = plate.bore_in_the_air();
    plate.settle();
    assert!(matches!(plate.failure(away), TrimFault::Misses { .. } | TrimFault::Remesh(_)), "{}", plate.failure(away));
    assert!(plate.report(good).audit.greatest().0 <= TOLERANCE);
    assert_eq!(plate.result().expect("a result").mesh.euler(), 0);
}

impl Plate {
    fn bore_in_the_air(&mut self) -> Entity {
        let circle = Circle::new(DVec3::new(0.0, 0.0, 0.3), DVec3::Z, 0.05).expect("a circle");
        let curve = spawn_curve(&mut self.world, Arc::new(circle));
        self.cut(curve, Heading::Against)
    }
}

#[test]
fn what_cannot_be_trimmed_says_why() {
    let mut plate = Plate::new();
    let no_curve = plate.world.spawn_empty().id();
    let no_curve = plate.cut(no_curve, Heading::Along);
    let nan = spawn_curve(&mut plate.world, Arc::new(FnCurve::new(|_| DVec3::NAN)));
    let nan = plate.cut(nan, Heading::Along);
    let panics = spawn_curve(&mut plate.world, Arc::new(FnCurve::new(|u: f64| -> DVec3 { panic!("at {u}") })));
    let panics = plate.cut(panics, Heading::Along);
    let bad = plate.bore(DVec2::ZERO, 0.03);
    plate.world.entity_mut(bad).insert(Tolerance { fit: -1.0, chord: 1.0, curve: 1.0 });
    let small = plate.bore(DVec2::ZERO, 1e-6);
    let curve = spawn_curve(&mut plate.world, circle(&plate.surface, DVec2::ZERO, 0.05));
    let nowhere = plate.world.spawn_empty().id();
    let no_source =
        spawn_trim(&mut plate.world, nowhere, &[(curve, Heading::Against)], tolerance(), TrimOptions::default());
    let nothing = spawn_trim(&mut plate.world, plate.source, &[], tolerance(), TrimOptions::default());
    plate.settle();
    assert!(matches!(plate.failure(no_curve), TrimFault::NoCurve { .. }));
    assert!(matches!(plate.failure(nan), TrimFault::CurveFailed { .. }));
    assert!(matches!(plate.failure(panics), TrimFault::CurveFailed { .. }));
    assert!(matches!(plate.failure(bad), TrimFault::BadNumber { .. }));
    assert!(matches!(plate.failure(small), TrimFault::TooSmall { .. }), "{}", plate.failure(small));
    assert!(matches!(plate.failure(no_source), TrimFault::NoSource { .. }));
    assert!(matches!(plate.failure(nothing), TrimFault::Remesh(_)));
    assert!(plate.result().is_none());
    despawn_surface(&mut plate.world, plate.source);
    plate.run();
    assert!(matches!(plate.failure(bad), TrimFault::NoSource { .. }));
}
