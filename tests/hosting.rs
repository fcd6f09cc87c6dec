//! The engine in schedules that are not its own: any legal order, any executor, any number of
//! threads make the same bits; what is not the engine's is never touched.

mod support;

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{
    IntoScheduleConfigs, MultiThreadedExecutor, ScheduleBuildSettings, ScheduleCleanupPolicy, ScheduleLabel,
    SingleThreadedExecutor,
};
use glam::DVec3;
use selvedge::budget::Budgets;
use selvedge::diagnostics::{GroundDiagnostics, SubdivisionDiagnostics};
use selvedge::identity::Serials;
use selvedge::job::{AtModify, FitJob};
use selvedge::report::FitReport;
use selvedge::schedule::{STAGES, SelvedgeSystems, SubdivisionStage};
use selvedge::subdivision::Position;
use selvedge::subdivision::fit::{FitOptions, Quantum};
use selvedge::{Engine, Pass, Progress, install, spawn_fit, spawn_surface, strict};
use selvedge_systems::subdivision::fit::FitWork;
use selvedge_systems::subdivision::job::admit_fits;
use support::octant;
use support::world::{dump, host, octahedron, sphere, world_bits};

fn options() -> FitOptions {
    FitOptions { last_level: 4, tolerance: Some(1e-4), ..FitOptions::default() }
}

/// Three surfaces, three fits: two side by side and one after the first.
fn scene(world: &mut World) {
    let first = spawn_surface(world, &octant("cone(1,2)"));
    let second = spawn_surface(world, &octant("cone(1,1)"));
    spawn_surface(world, &octahedron());
    for surface in [first, second, first] {
        spawn_fit(world, surface, sphere(), options());
    }
}

/// What the scene comes to in this world and schedule.
fn result(world: &mut World, schedule: &mut Schedule) -> Vec<u64> {
    scene(world);
    for _ in 0..2000 {
        schedule.run(world);
        if world.query::<&FitReport>().iter(world).count() == 3 {
            // One more pass gathers the last result.
            schedule.run(world);
            return world_bits(world);
        }
    }
    panic!("the fits do not end");
}

fn expected() -> Vec<u64> {
    let (mut world, mut schedule) = host();
    result(&mut world, &mut schedule)
}

#[test]
fn no_two_systems_are_ambiguous() {
    let (mut world, mut schedule) = host();
    schedule.initialize(&mut world).expect("every pair of systems that share data has an order");
    // The check can fail: a system of a host's own that writes what ours read, and has no order.
    schedule.add_systems(|mut points: Query<&mut Position>| points.iter_mut().for_each(|mut p| p.0 *= 1.0));
    assert!(schedule.initialize(&mut world).is_err());
}

#[test]
fn every_legal_order_makes_the_same_bits() {
    let expected = expected();
    for seed in 0..8 {
        let (mut world, mut schedule) = host();
        schedule.set_build_settings(ScheduleBuildSettings { shuffle_seed: Some(seed), ..strict() });
        assert_eq!(result(&mut world, &mut schedule), expected, "seed {seed}");
    }
}

#[test]
fn any_number_of_threads_makes_the_same_bits() {
    let expected = expected();
    for threads in 1..=4 {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads to be had");
        let found = pool.install(|| {
            let (mut world, mut schedule) = host();
            result(&mut world, &mut schedule)
        });
        assert_eq!(found, expected, "{threads} threads");
    }
}

/// A host's own label, executor and systems around the engine's; commands applied early or late.
#[test]
fn a_foreign_schedule_makes_the_same_bits() {
    #[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
    struct EveryThirdFrame;
    #[derive(Resource, Default)]
    struct Frames(u64);
    let expected = expected();
    for settings in [strict(), ScheduleBuildSettings { auto_insert_apply_deferred: false, ..strict() }] {
        let (mut world, mut schedule) = (World::new(), Schedule::new(EveryThirdFrame));
        world.init_resource::<Frames>();
        schedule.set_executor(MultiThreadedExecutor::new());
        schedule.set_build_settings(settings);
        schedule.add_systems(
            (|mut frames: ResMut<Frames>| frames.0 += 1).after(SelvedgeSystems::Gather).before(SelvedgeSystems::Check),
        );
        install(&mut world, &mut schedule);
        schedule.add_systems((|frames: Res<Frames>| assert!(frames.0 > 0)).after(SelvedgeSystems::Finish));
        assert_eq!(result(&mut world, &mut schedule), expected);
    }
}

#[derive(Component, Clone, PartialEq, Debug)]
struct Name(String);

#[derive(Resource, Clone, PartialEq, Debug)]
struct Score(u32);

#[test]
fn what_is_not_the_engines_is_never_touched() {
    let (mut world, mut schedule) = host();
    world.insert_resource(Score(7));
    let strangers: Vec<_> = (0..5).map(|i| world.spawn(Name(format!("{i}"))).id()).collect();
    // A stranger that shares a table with nothing, and one that is a control point as well.
    scene(&mut world);
    let point = world.query_filtered::<Entity, With<Position>>().iter(&world).next().unwrap();
    world.entity_mut(point).insert(Name("mine".into()));
    world.clear_trackers();
    let before = strangers.iter().map(|s| world.get::<Name>(*s).cloned()).collect::<Vec<_>>();
    for _ in 0..40 {
        schedule.run(&mut world);
    }
    assert_eq!(strangers.iter().map(|s| world.get::<Name>(*s).cloned()).collect::<Vec<_>>(), before);
    assert_eq!(world.query_filtered::<(), Changed<Name>>().iter(&world).count(), 0);
    assert_eq!(world.query_filtered::<(), Changed<Position>>().iter(&world).count(), 0, "nor what the host edits");
    assert!(!world.is_resource_changed::<Score>() && *world.resource::<Score>() == Score(7));
    assert_eq!(world.get::<Name>(point), Some(&Name("mine".into())));
    for stranger in strangers {
        assert_eq!(world.inspect_entity(stranger).unwrap().count(), 1);
    }
    // The engine adds its own resources, and nothing else, to an empty world.
    let (mut empty, mut schedule) = host();
    schedule.run(&mut empty);
    let added = dump(&mut empty);
    schedule.run(&mut empty);
    assert_eq!(dump(&mut empty), added);
}

#[test]
fn a_stage_is_replaced_by_its_set() {
    #[derive(Resource, Default)]
    struct Mine(u64);
    let expected = expected();
    let (mut world, mut schedule) = host();
    world.init_resource::<Mine>();
    let policy = ScheduleCleanupPolicy::RemoveSystemsOnly;
    let removed = schedule.remove_systems_in_set(SubdivisionStage::Correspond, &mut world, policy);
    assert_eq!(removed.unwrap(), 1);
    let mine = |mut jobs: Query<(&mut FitJob, &mut FitWork), With<selvedge::job::AtCorrespond>>,
                mut count: ResMut<Mine>| {
        for (mut job, mut work) in &mut jobs {
            job.step = Some(work.correspond().map_err(Into::into));
            job.quanta += 1;
            count.0 += 1;
        }
    };
    schedule.add_systems(mine.in_set(SubdivisionStage::Correspond));
    assert_eq!(result(&mut world, &mut schedule), expected);
    assert!(world.resource::<Mine>().0 >= 6, "two fits of three rounds at level 0; the third finds its surface fitted");
    assert_eq!(world.resource::<SubdivisionDiagnostics>().correspond.runs, 0);
}

#[test]
fn a_stage_that_was_taken_out_stalls_jobs_and_does_not_hang() {
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&octahedron());
    let fit = engine.spawn_fit(surface, sphere(), options());
    let (mut world, mut schedule) = host();
    spawn_surface(&mut world, &octahedron());
    schedule.run(&mut world);
    engine.update();
    let policy = ScheduleCleanupPolicy::RemoveSystemsOnly;
    engine
        .with_schedule(|world, schedule| schedule.remove_systems_in_set(SubdivisionStage::Modify, world, policy))
        .unwrap();
    let stalled = engine.settle().unwrap_err();
    assert_eq!(stalled.jobs, [fit]);
    assert!(engine.world().entity(fit).contains::<AtModify>());
    // One that always wants more is ended by the budget of quanta.
    engine.with_schedule(|_, schedule| {
        let more = |mut jobs: Query<&mut FitJob, With<AtModify>>| {
            for mut job in &mut jobs {
                job.step = Some(Ok(Quantum::More));
                job.quanta += 1;
            }
        };
        schedule.add_systems(more.in_set(SubdivisionStage::Modify));
    });
    engine.world_mut().insert_resource(Budgets { quanta: 100, ..Budgets::default() });
    assert!(engine.settle().unwrap() < 200);
    assert!(matches!(engine.progress(fit), Some(Progress::Failed(_))));
}

#[test]
fn resources_that_a_host_takes_away_are_missed_by_nobody() {
    let (mut world, mut schedule) = host();
    world.remove_resource::<Budgets>();
    world.remove_resource::<GroundDiagnostics>();
    world.remove_resource::<SubdivisionDiagnostics>();
    assert_eq!(result(&mut world, &mut schedule), expected());
    world.remove_resource::<Serials>();
    schedule.run(&mut world);
}

#[test]
fn the_engine_in_a_box_finds_what_a_host_finds() {
    let mut engine = Engine::new();
    scene(engine.world_mut());
    let passes = engine.settle().expect("every stage has its system");
    assert_eq!(world_bits(engine.world_mut()), expected());
    assert_eq!(engine.update(), Pass::Idle);
    assert!(passes > 30);
}

#[test]
fn frames_of_any_length_come_to_the_same_end_and_tell_how_far_they_are() {
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&octant("cone(1,2)"));
    let fit = engine.spawn_fit(surface, sphere(), options());
    assert_eq!(engine.progress(fit), Some(Progress::Waiting));
    assert_eq!(engine.progress(surface), None);
    let mut last = 0;
    let mut frames = 0;
    while engine.update_for(Duration::ZERO) == Pass::Busy {
        frames += 1;
        match engine.progress(fit) {
            Some(Progress::Running { quanta, .. }) => {
                assert_eq!(quanta, last + 1, "a frame without time is one quantum");
                last = quanta;
            }
            Some(Progress::Finished(report)) => assert!(report.details > 0),
            other => panic!("{other:?}"),
        }
    }
    assert!(frames > 10);
    let found = world_bits(engine.world_mut());
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&octant("cone(1,2)"));
    engine.spawn_fit(surface, sphere(), options());
    while engine.update_for(Duration::from_secs(60)) == Pass::Busy {}
    assert_eq!(world_bits(engine.world_mut()), found);
}

#[test]
fn a_cancelled_job_of_the_engine_is_gone() {
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&octahedron());
    engine.update();
    let before = support::world::dump_without_resources(engine.world_mut());
    let fit = engine.spawn_fit(surface, sphere(), options());
    for _ in 0..9 {
        assert_eq!(engine.update(), Pass::Busy);
    }
    engine.cancel(fit);
    assert_eq!(support::world::dump_without_resources(engine.world_mut()), before);
    assert_eq!(engine.progress(fit), None);
    assert_eq!(engine.settle(), Ok(1));
}

/// The contracts say what the systems really ask for; each system is listed, in its set.
#[test]
fn the_listed_contracts_are_those_of_the_systems() {
    let (mut world, mut schedule) = host();
    schedule.initialize(&mut world).unwrap();
    let mut found = BTreeMap::new();
    for (_, system) in schedule.systems_with_access().unwrap() {
        let name = system.system().name().to_string();
        // What applies commands between the systems is Bevy's, and exclusive; none of ours is.
        let Some(name) = name.rsplit("::").next().filter(|_| !system.access().is_exclusive()) else { continue };
        let access = system.access().to_filtered_access_set();
        let short = |id| {
            let name = world.components().get_name(id).expect("it is registered").to_string();
            name.rsplit("::").next().unwrap().to_string()
        };
        let all = access.combined_access();
        let writes: BTreeSet<_> = all.writes().as_finite_set().unwrap().iter().map(short).collect();
        let mut reads: BTreeSet<_> = all.reads().as_finite_set().unwrap().iter().map(short).collect();
        reads.extend(all.archetypal().iter().map(short));
        for filtered in access.filtered_accesses() {
            reads.extend(filtered.with_filters().chain(filtered.without_filters()).map(short));
        }
        let reads: BTreeSet<_> = reads
            .difference(&writes)
            .filter(|name| !["IsResource", "Internal"].contains(&name.as_str()))
            .cloned()
            .collect();
        found.insert(name.to_string(), (reads, writes));
    }
    let set = |names: &[&str]| names.iter().map(ToString::to_string).collect::<BTreeSet<_>>();
    let listed: BTreeMap<_, _> =
        STAGES.iter().map(|stage| (stage.system.to_string(), (set(stage.reads), set(stage.writes)))).collect();
    assert_eq!(listed.keys().collect::<Vec<_>>(), found.keys().collect::<Vec<_>>());
    for (name, (reads, writes)) in &listed {
        let (found_reads, found_writes) = &found[name];
        // The default filter for disabled entities is in every query; it is listed where it is lifted.
        let mut found_reads = found_reads.clone();
        if !reads.contains("Disabled") {
            found_reads.remove("Disabled");
        }
        assert_eq!(reads, &found_reads, "{name} reads");
        assert_eq!(writes, found_writes, "{name} writes");
    }
    for set in SelvedgeSystems::ALL.map(|s| format!("SelvedgeSystems::{s:?}")) {
        let inner = matches!(set.as_str(), "SelvedgeSystems::Solve" | "SelvedgeSystems::Finish");
        assert!(inner || STAGES.iter().any(|stage| stage.set == set), "{set}");
    }
    for set in SubdivisionStage::ALL.map(|s| format!("SubdivisionStage::{s:?}")) {
        assert!(STAGES.iter().any(|stage| stage.set == set), "{set}");
    }
}

/// What replaces admission decides which jobs begin: here none, and nothing else breaks.
#[test]
fn admission_can_be_held_back_and_let_go() {
    let (mut world, mut schedule) = host();
    schedule.set_executor(SingleThreadedExecutor::new());
    let policy = ScheduleCleanupPolicy::RemoveSystemsOnly;
    schedule.remove_systems_in_set(SubdivisionStage::Admit, &mut world, policy).unwrap();
    scene(&mut world);
    for _ in 0..3 {
        schedule.run(&mut world);
    }
    assert_eq!(world.query::<&FitJob>().iter(&world).count(), 0);
    schedule.add_systems(admit_fits.in_set(SubdivisionStage::Admit));
    schedule.run(&mut world);
    assert_eq!(world.query::<&FitJob>().iter(&world).count(), 2);
    assert!(world.query::<&Position>().iter(&world).all(|p| p.0 != DVec3::NAN));
}

#[cfg(feature = "bevy_app")]
#[test]
fn an_app_makes_the_same_bits_in_any_of_its_schedules() {
    use bevy_app::{App, PostUpdate};
    use selvedge::SelvedgePlugin;
    let expected = expected();
    for plugin in [SelvedgePlugin::default(), SelvedgePlugin::new(PostUpdate)] {
        let mut app = App::new();
        app.add_plugins(plugin);
        scene(app.world_mut());
        while app.world_mut().query::<&FitReport>().iter(app.world()).count() < 3 {
            app.update();
        }
        app.update();
        assert_eq!(world_bits(app.world_mut()), expected);
    }
}
