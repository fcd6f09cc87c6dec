//! Surfaces that ask for triangles get them, once for each time that something has become different.

mod support;

use selvedge::audit::{AuditOptions, AuditReport};
use selvedge::bevy_ecs::prelude::*;
use selvedge::budget::Budgets;
use selvedge::diagnostics::GroundDiagnostics;
use selvedge::subdivision::Position;
use selvedge::tolerance::Tolerance;
use selvedge::triangles::Triangles;
use selvedge::triangulation::{
    Density, TriangulateError, TriangulateOptions, Triangulated, TriangulationFailed, TriangulationReport,
};
use selvedge::{Engine, Pass, Triangulating};
use selvedge_systems::triangulate::triangulate;
use support::octant;
use support::world::host;

fn level(level: u32) -> TriangulateOptions {
    TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() }
}

fn made(world: &World) -> u64 {
    world.resource::<GroundDiagnostics>().triangulate.written
}

#[test]
fn a_surface_that_asks_gets_the_kernels_triangles_and_nobody_else() {
    let (mut world, mut schedule) = host();
    let source = octant("cone(1,2)");
    let asks = selvedge::spawn_surface(&mut world, &source);
    let does_not = selvedge::spawn_surface(&mut world, &source);
    world.entity_mut(asks).insert((level(2), AuditOptions::default()));
    schedule.run(&mut world);
    let by_kernel = triangulate(&source, &level(2)).expect("a sound surface");
    assert_eq!(world.get::<Triangles>(asks), Some(&by_kernel.triangles));
    assert_eq!(world.get::<TriangulationReport>(asks), Some(&by_kernel.report));
    assert!(world.get::<AuditReport>(asks).expect("it was asked for").is_sound());
    assert!(world.get::<Triangles>(does_not).is_none() && world.get::<AuditReport>(does_not).is_none());
}

#[test]
fn nothing_is_done_again_until_something_is_different() {
    let (mut world, mut schedule) = host();
    let surface = selvedge::spawn_surface(&mut world, &octant("cone(1,2)"));
    world.entity_mut(surface).insert((level(1), AuditOptions::default()));
    let audits = |world: &World| world.resource::<GroundDiagnostics>().audit.written;
    let mut run = |world: &mut World| {
        schedule.run(world);
        (made(world), audits(world))
    };
    assert_eq!(run(&mut world), (1, 1));
    assert_eq!(run(&mut world), (1, 1));
    // Touched, but the same.
    world.get_mut::<TriangulateOptions>(surface).expect("they are there").set_changed();
    let point = inner_point(&mut world);
    world.get_mut::<Position>(point).expect("it is there").set_changed();
    assert_eq!(run(&mut world), (1, 1));
    // Different.
    world.get_mut::<Position>(point).expect("it is there").0 *= 1.01;
    assert_eq!(run(&mut world), (2, 2));
    world.entity_mut(surface).insert(level(2));
    assert_eq!(run(&mut world), (3, 3));
    world.entity_mut(surface).insert(Tolerance::total(1e-2));
    assert_eq!(run(&mut world), (4, 4));
    let chord = world.get::<TriangulationReport>(surface).and_then(|r| r.chord).expect("the tolerance has one");
    assert_eq!(chord.asked, Tolerance::total(1e-2).chord);
    // Asked again.
    world.entity_mut(surface).remove::<Triangulated>();
    assert_eq!(run(&mut world), (5, 5));
    assert_eq!(run(&mut world), (5, 5));
}

#[test]
fn a_failure_is_a_component_and_the_last_triangles_stay() {
    let (mut world, mut schedule) = host();
    let surface = selvedge::spawn_surface(&mut world, &octant("cone(1,1)"));
    world.entity_mut(surface).insert((level(1), AuditOptions::default()));
    schedule.run(&mut world);
    let before = world.get::<Triangles>(surface).cloned().expect("they were made");
    world.resource_mut::<Budgets>().triangles = 10;
    schedule.run(&mut world);
    let why = world.get::<TriangulationFailed>(surface).expect("28 triangles are more than 10");
    assert!(matches!(why.0, TriangulateError::TooManyTriangles { limit: 10, .. }), "{why}");
    assert_eq!(world.get::<Triangles>(surface), Some(&before));
    // Not tried again and again; and as soon as it succeeds, the failure is gone.
    assert_eq!(made(&world), 2);
    schedule.run(&mut world);
    assert_eq!(made(&world), 2);
    world.resource_mut::<Budgets>().triangles = 100;
    schedule.run(&mut world);
    assert!(world.get::<TriangulationFailed>(surface).is_none());
    assert_eq!(world.get::<AuditReport>(surface).map(AuditReport::is_sound), Some(true));
}

/// A point inside the surface that a host may move.
fn inner_point(world: &mut World) -> Entity {
    let mut points = world.query::<(Entity, &Position)>();
    points.iter(world).find(|(_, p)| p.0.min_element() > 0.1).map(|(e, _)| e).expect("an interior point")
}

/// Many triangles take many passes, of which each does little: till then there are none, or those from before.
#[test]
fn a_large_surface_is_triangulated_over_several_passes_to_the_kernels_bits() {
    let mut engine = Engine::new();
    let source = octant("cone(1,2)");
    let surface = engine.spawn_surface(&source);
    engine.world_mut().entity_mut(surface).insert(level(1));
    engine.settle().expect("nothing stalls");
    let few = engine.world().get::<Triangles>(surface).cloned().expect("they were made");
    for asked in [level(6), TriangulateOptions { density: Density::Chord(2e-7), ..level(0) }] {
        let by_kernel = triangulate(&source, &asked).expect("a sound surface");
        assert!(by_kernel.triangles.triangles.len() > 40_000);
        engine.world_mut().entity_mut(surface).insert(asked);
        let before = engine.world().get::<Triangles>(surface).cloned();
        let (mut passes, mut worked) = (0, 0);
        while engine.update() == Pass::Busy {
            if let Some(work) = engine.world().get::<Triangulating>(surface) {
                worked = work.passes();
                assert_eq!(engine.world().get::<Triangles>(surface), before.as_ref());
            }
            passes += 1;
        }
        assert!(worked >= 3 && passes >= 3, "{passes} passes, {worked} of them worked");
        assert_eq!(engine.world().get::<Triangles>(surface), Some(&by_kernel.triangles));
        assert_eq!(engine.world().get::<TriangulationReport>(surface), Some(&by_kernel.report));
        assert!(engine.world().get::<Triangulating>(surface).is_none());
    }
    assert!(few.triangles.len() < 100, "a small one takes one pass");
}

/// Who edits a surface faster than its triangles are made sees some of every while, and in the end the last.
#[test]
fn what_was_begun_before_an_edit_is_finished_and_then_made_again() {
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&octant("cone(1,2)"));
    engine.world_mut().entity_mut(surface).insert(level(6));
    engine.update();
    let point = inner_point(engine.world_mut());
    let mut seen = Vec::new();
    for _ in 0..60 {
        engine.world_mut().get_mut::<Position>(point).expect("it is there").0 *= 1.0 + 1e-3;
        engine.update();
        seen.extend(engine.world().get::<Triangulated>(surface).map(|made| made.revision));
    }
    seen.dedup();
    assert!(seen.len() >= 3, "only {seen:?} were seen of 60 edits");
    engine.settle().expect("nothing stalls");
    let last = engine.surface(surface).expect("it was gathered").expect("it is sound").clone();
    let expected = triangulate(&last, &level(6)).expect("a sound surface");
    assert_eq!(engine.world().get::<Triangles>(surface), Some(&expected.triangles));
}

#[test]
fn what_is_no_longer_asked_for_is_not_made() {
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&octant("cone(1,2)"));
    engine.world_mut().entity_mut(surface).insert(level(1));
    engine.settle().expect("nothing stalls");
    let first = engine.world().get::<Triangles>(surface).cloned();
    let begin = |engine: &mut Engine| {
        engine.world_mut().entity_mut(surface).insert(level(6));
        engine.update();
        assert!(engine.world().get::<Triangulating>(surface).is_some());
    };
    // Other options begin again; the same as before are met already.
    begin(&mut engine);
    engine.world_mut().entity_mut(surface).insert(level(2));
    engine.settle().expect("nothing stalls");
    assert!(engine.world().get::<Triangulating>(surface).is_none());
    assert_ne!(engine.world().get::<Triangles>(surface).cloned(), first);
    engine.world_mut().entity_mut(surface).insert(level(1));
    engine.settle().expect("nothing stalls");
    begin(&mut engine);
    engine.world_mut().entity_mut(surface).insert(level(1));
    engine.settle().expect("nothing stalls");
    assert!(engine.world().get::<Triangulating>(surface).is_none());
    assert_eq!(engine.world().get::<Triangles>(surface).cloned(), first);
    // Nothing at all.
    begin(&mut engine);
    engine.world_mut().entity_mut(surface).remove::<TriangulateOptions>();
    engine.settle().expect("nothing stalls");
    assert!(engine.world().get::<Triangulating>(surface).is_none());
    assert_eq!(engine.world().get::<Triangles>(surface).cloned(), first);
}
