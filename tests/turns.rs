//! Many jobs at once: a pass does no more than it may, everybody has a turn, and what comes out knows nothing
//! of it.

mod support;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleCleanupPolicy;
use glam::DVec2;
use selvedge::budget::PassAllowance;
use selvedge::diagnostics::SubdivisionDiagnostics;
use selvedge::job::{FitJob, JobState};
use selvedge::report::FitReport;
use selvedge::schedule::SubdivisionStage;
use selvedge::subdivision::fit::Stage;
use selvedge::trim::{TrimJob, TrimReport};
use selvedge::{Engine, cancel_fit, spawn_fit, spawn_surface};
use selvedge_systems::subdivision::turns::STAGES;
use support::octant;
use support::plate::{Plate, wide_plate};
use support::world::{bits, down_to, host, sphere};

/// The quanta that all jobs have taken.
fn taken(world: &mut World) -> u64 {
    let d = world.resource::<SubdivisionDiagnostics>();
    let stages = [d.locate, d.remesh, d.relax, d.correspond, d.modify, d.refine, d.audit];
    stages.iter().map(|counters| counters.items).sum()
}

/// Bores of a plate: some that touch, some beside, one that fails, all at once.
fn bored(allowance: u64) -> (Plate, Vec<Entity>) {
    let mut plate = Plate::of(wide_plate(40));
    plate.world.insert_resource(PassAllowance { quanta: allowance });
    let places = (0..12).map(|k| DVec2::new(-0.75 + 0.5 * f64::from(k % 4), -0.6 + 0.5 * f64::from(k / 4)));
    let mut bores: Vec<_> = places.map(|at| plate.bore(at, 0.06)).collect();
    bores.push(plate.bore(DVec2::new(-0.67, -0.55), 0.06));
    bores.push(plate.bore_in_the_air());
    (plate, bores)
}

/// As many quanta as are allowed, and one more for each stage at most; what is left over waits.
#[test]
fn a_pass_over_many_trims_does_no_more_quanta_than_it_may() {
    let longest = |allowance: u64| {
        let (mut plate, _) = bored(allowance);
        let (mut before, mut most) = (0, 0);
        for _ in 0..2000 {
            plate.run();
            let after = taken(&mut plate.world);
            most = most.max(after - before);
            before = after;
            if plate.world.query::<&TrimJob>().iter(&plate.world).all(|job| !job.is_running()) {
                return most;
            }
        }
        panic!("trims do not end");
    };
    assert!(longest(u64::MAX) >= 12, "without an allowance all are moved at once");
    for allowance in [0, 1, 4] {
        let most = longest(allowance);
        assert!(most >= allowance.max(1) && most <= allowance + STAGES as u64, "{most} of {allowance}");
    }
}

#[test]
fn what_is_left_does_not_depend_on_how_much_a_pass_may_do() {
    let run = |allowance: u64| {
        let (mut plate, bores) = bored(allowance);
        let passes = plate.settle();
        let reports: Vec<_> = bores.iter().map(|&bore| plate.world.get::<TrimReport>(bore).cloned()).collect();
        assert_eq!(reports.iter().flatten().count(), 13);
        (passes, bits(plate.result().expect("a result")), reports)
    };
    let (few, expected, reports) = run(u64::MAX);
    for allowance in [0, 3, 5] {
        let (passes, found, again) = run(allowance);
        assert!(passes > few, "some waited");
        assert_eq!(found, expected, "{allowance}");
        assert_eq!(again, reports, "{allowance}");
    }
}

/// Of five jobs, two of which may be moved in a pass, none waits for more than two passes in a row.
#[test]
fn every_job_has_its_turn_after_those_before_it() {
    let (mut world, mut schedule) = host();
    world.insert_resource(PassAllowance { quanta: 2 });
    let fits: Vec<_> = (0..5)
        .map(|_| {
            let surface = spawn_surface(&mut world, &octant("cone(1,2)"));
            spawn_fit(&mut world, surface, sphere(), down_to(2))
        })
        .collect();
    let quanta = |world: &World| -> Vec<_> {
        fits.iter().map(|&fit| world.get::<FitJob>(fit).map_or(0, |job| job.quanta)).collect()
    };
    let mut seen = vec![quanta(&world)];
    while world.query::<&FitReport>().iter(&world).count() == 0 {
        let before = taken(&mut world);
        schedule.run(&mut world);
        seen.push(quanta(&world));
        assert!(taken(&mut world) - before <= 2 + 2, "two, and the first at two other stages");
    }
    assert!(seen.len() > 50);
    for four in seen.windows(4) {
        assert!(four[0].iter().zip(&four[3]).all(|(before, after)| after > before), "{four:?}");
    }
}

/// A job that is taken back while it waits leaves its place to the others.
#[test]
fn a_job_that_is_taken_back_gives_its_turns_away() {
    let (mut world, mut schedule) = host();
    world.insert_resource(PassAllowance { quanta: 1 });
    let surfaces = [(); 3].map(|()| spawn_surface(&mut world, &octant("cone(1,2)")));
    let fits = surfaces.map(|surface| spawn_fit(&mut world, surface, sphere(), down_to(1)));
    for _ in 0..7 {
        schedule.run(&mut world);
    }
    cancel_fit(&mut world, fits[1]);
    for _ in 0..1000 {
        schedule.run(&mut world);
    }
    assert_eq!(world.query::<&FitReport>().iter(&world).count(), 2);
    assert!(world.get::<FitReport>(fits[0]).is_some() && world.get::<FitReport>(fits[2]).is_some());
}

/// Jobs that nothing moves, as many as a pass may move, do not keep another from its turns.
#[test]
fn jobs_that_stand_still_are_in_nobodys_way() {
    let mut engine = Engine::new();
    engine.world_mut().insert_resource(PassAllowance { quanta: 2 });
    let policy = ScheduleCleanupPolicy::RemoveSystemsOnly;
    engine
        .with_schedule(|world, schedule| schedule.remove_systems_in_set(SubdivisionStage::Modify, world, policy))
        .expect("it was there");
    let mut fits = Vec::new();
    for _ in 0..4 {
        let surface = engine.spawn_surface(&octant("cone(1,1)"));
        fits.push(engine.spawn_fit(surface, sphere(), down_to(1)));
    }
    let stalled = engine.settle().expect_err("nothing modifies");
    assert_eq!(stalled.jobs.len(), 4);
    let surface = engine.spawn_surface(&octant("cone(1,1)"));
    let last = engine.spawn_fit(surface, sphere(), down_to(1));
    assert_eq!(engine.settle().expect_err("nothing modifies").jobs.len(), 5);
    let job = engine.world().get::<FitJob>(last).expect("it was begun");
    assert_eq!(job.state, JobState::Running(Stage::Modify), "it has come as far as the others");
}
