//! A baked result is a surface like any other, and nobody's result any more.

mod support;

use std::f64::consts::FRAC_PI_6;

use glam::DVec2;
use selvedge::curve::Heading;
use selvedge::subdivision::{ControlPoints, LoopSurface, Position, Snapshot};
use selvedge::trim::{OtherSide, Sides, TrimOptions, TrimmedTo};
use selvedge::{BakeError, Engine, TrimProgress, bake, spawn_curve, spawn_trim};
use support::plate::{Plate, TOLERANCE, circle, plate, tolerance};
use support::world::bits;

fn surface(engine: &Engine, entity: bevy_ecs::entity::Entity) -> &LoopSurface {
    engine.surface(entity).expect("gathered").expect("sound")
}

fn ring(engine: &mut Engine, centre: DVec2, radius: f64, of: &LoopSurface) -> [(bevy_ecs::entity::Entity, Heading); 1] {
    [(engine.spawn_curve(circle(of, centre, radius)), Heading::Against)]
}

/// A plate with a bore in it, baked.
fn bored_and_baked(given: &LoopSurface) -> (Engine, bevy_ecs::entity::Entity) {
    let mut engine = Engine::new();
    let source = engine.spawn_surface(given);
    let bore = ring(&mut engine, DVec2::new(-0.02, 0.0), 0.05, given);
    engine.spawn_trim(source, &bore, tolerance(), TrimOptions::default());
    engine.settle().expect("trims end");
    let baked = engine.bake(engine.result(source).expect("a result")).expect("it is the present one");
    (engine, baked)
}

#[test]
fn a_baked_result_stays_when_its_source_is_edited() {
    let mut plate = Plate::new();
    plate.bore(DVec2::ZERO, 0.05);
    plate.settle();
    let result = plate.world.get::<TrimmedTo>(plate.source).expect("a result").0;
    let before = bits(plate.result().expect("a result"));
    let baked = bake(&mut plate.world, result).expect("the result is the present one");
    plate.run();
    let of = |plate: &Plate| bits(&plate.world.get::<Snapshot>(baked).expect("it is sound").surface);
    assert_eq!(of(&plate), before, "the same surface, to the bit");
    let source = plate.world.get::<ControlPoints>(plate.source).expect("a surface").0.clone();
    plate.world.get_mut::<Position>(source[40]).expect("a point").0.z += 1e-6;
    plate.run();
    assert_eq!(bake(&mut plate.world, result), Err(BakeError::Stale { entity: result }));
    plate.settle();
    assert_ne!(bits(plate.result().expect("a result")), before);
    assert_eq!(of(&plate), before);
    // Nor does an edit of the baked surface reach the source or its result.
    let (source_bits, result_bits) = (plate.source_bits(), bits(plate.result().expect("a result")));
    let own = plate.world.get::<ControlPoints>(baked).expect("a surface").0.clone();
    plate.world.get_mut::<Position>(own[3]).expect("a point").0.z += 1e-3;
    plate.run();
    assert_ne!(of(&plate), before);
    assert_eq!((plate.source_bits(), bits(plate.result().expect("a result"))), (source_bits, result_bits));
}

#[test]
fn a_baked_result_can_itself_be_trimmed_through_its_hole_too() {
    let given = plate();
    let (mut engine, baked) = bored_and_baked(&given);
    engine.settle().expect("it is gathered");
    let first = surface(&engine, baked).clone();
    let through = ring(&mut engine, DVec2::new(0.04, 0.01), 0.04, &given);
    let away = ring(&mut engine, DVec2::new(-0.09, 0.09), 0.03, &first);
    let trims = [through, away].map(|cut| engine.spawn_trim(baked, &cut, tolerance(), TrimOptions::default()));
    engine.settle().expect("trims end");
    for trim in trims {
        match engine.trim_progress(trim) {
            Some(TrimProgress::Finished(report)) => assert!(report.audit.greatest().0 <= TOLERANCE),
            other => panic!("{other:?}"),
        }
    }
    let again = engine.result(baked).expect("a result of its own");
    assert_eq!(surface(&engine, again).mesh.euler(), -1, "two holes, of which one is of two bores");
    assert_eq!(bits(surface(&engine, baked)), bits(&first));
}

#[test]
fn what_a_trim_removes_can_be_baked_as_well() {
    let mut plate = Plate::new();
    let curve = spawn_curve(&mut plate.world, circle(&plate.surface, DVec2::ZERO, 0.06));
    let options = TrimOptions { sides: Sides::Both, ..TrimOptions::default() };
    let trim = spawn_trim(&mut plate.world, plate.source, &[(curve, Heading::Against)], tolerance(), options);
    plate.settle();
    let other = plate.world.get::<OtherSide>(trim).expect("another side").0;
    let baked = bake(&mut plate.world, other).expect("it is the present one");
    plate.world.despawn(trim);
    plate.run();
    plate.run();
    let plug = &plate.world.get::<Snapshot>(baked).expect("it is sound").surface;
    assert_eq!(plug.mesh.euler(), 1);
}

#[test]
fn what_is_no_result_is_not_baked() {
    let mut engine = Engine::new();
    let source = engine.spawn_surface(&plate());
    assert_eq!(engine.bake(source), Err(BakeError::NotAResult { entity: source }));
    let gone = engine.world_mut().spawn_empty().id();
    engine.world_mut().despawn(gone);
    assert_eq!(engine.bake(gone), Err(BakeError::NotAResult { entity: gone }));
}

/// The details of a surface that was trimmed before show between the places at which a coarse level is
/// measured: trims of it keep their tolerance all the same, wherever they lie.
#[test]
fn trims_of_a_baked_result_keep_their_tolerance() {
    let given = plate();
    let (mut engine, baked) = bored_and_baked(&given);
    for k in 0..12 {
        let turn = DVec2::from_angle(FRAC_PI_6 * f64::from(k));
        let through = ring(&mut engine, DVec2::new(-0.02, 0.0) + 0.061 * turn, 0.03 + 0.001 * f64::from(k), &given);
        let trim = engine.spawn_trim(baked, &through, tolerance(), TrimOptions::default());
        engine.settle().expect("trims end");
        match engine.trim_progress(trim) {
            Some(TrimProgress::Finished(report)) => assert!(report.audit.greatest().0 <= TOLERANCE),
            other => panic!("{k}: {other:?}"),
        }
        engine.world_mut().despawn(trim);
    }
}
