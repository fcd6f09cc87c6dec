//! Fits as jobs: a quantum a pass, side by side, taken back without a trace.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::prelude::*;
use glam::DVec3;
use selvedge::budget::{Budget, Budgets};
use selvedge::diagnostics::SubdivisionDiagnostics;
use selvedge::error::{FitFailed, FitFault, SurfaceFailed};
use selvedge::evaluate::{Evaluate, SurfacePoint};
use selvedge::job::{AtCorrespond, AtModify, AtRefine, Cancelled, Fit, FitJob, FitTarget, JobState};
use selvedge::mesh::FaceId;
use selvedge::report::FitReport;
use selvedge::subdivision::fit::{FitError, FitOptions, Outcome, Quantum, Stage};
use selvedge::subdivision::{Address, ControlPoints, Detail, DetailLevel, DetailOf, Position};
use selvedge::target::{Foot, TargetError};
use selvedge::tolerance::Tolerance;
use selvedge::{Projection, Target, cancel_fit, despawn_surface, spawn_fit, spawn_surface};
use selvedge_systems::closest::{SurfaceIndex, SurfaceTarget};
use selvedge_systems::subdivision::fit::FitWork;
use selvedge_systems::subdivision::limit::LimitSurface;
use support::octant;
use support::world::{bits, by_hand, details_of, down_to, dump_without_resources, host, octahedron, snapshot, sphere};

fn job(world: &World, job: Entity) -> &FitJob {
    world.get::<FitJob>(job).expect("the job was begun")
}

fn state(world: &World, entity: Entity) -> Option<JobState> {
    world.get::<FitJob>(entity).map(|job| job.state)
}

fn is_running(world: &World, entity: Entity) -> bool {
    matches!(state(world, entity), Some(JobState::Running(_)))
}

/// Passes until the job has ended and its result is gathered. Returns how many.
fn finish(world: &mut World, schedule: &mut Schedule, job: Entity) -> u64 {
    for passes in 1..100_000 {
        schedule.run(world);
        if matches!(state(world, job), Some(JobState::Finished | JobState::Failed)) {
            schedule.run(world);
            return passes;
        }
    }
    panic!("the job does not end");
}

fn failure(world: &World, job: Entity) -> &FitFault {
    &world.get::<FitFailed>(job).expect("the job has failed").why
}

#[test]
fn a_job_finds_what_its_kernel_finds_alone() {
    let source = octant("cone(1,2)");
    let mut alone = FitWork::new(Arc::new(source.clone()), sphere(), down_to(3)).unwrap();
    let mut quanta = 0;
    while alone.advance().unwrap() != Quantum::Finished {
        quanta += 1;
    }
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &source);
    let fit = spawn_fit(&mut world, surface, sphere(), down_to(3));
    let passes = finish(&mut world, &mut schedule, fit);
    assert_eq!(passes, quanta + 1, "a pass for every quantum");
    assert_eq!(job(&world, fit).quanta, passes);
    let report = world.get::<FitReport>(fit).unwrap();
    assert_eq!(report.ladder, alone.ladder());
    assert_eq!(report.outcome, Outcome::Within);
    assert_eq!(&snapshot(&world, surface).surface.details, alone.details());
}

/// What a job fits to can be a surface of the world: of another mesh here, and of a distance to the
/// sphere that is known.
#[test]
fn a_job_fits_one_surface_to_another() {
    const TOLERANCE: f64 = 1e-5;
    let (mut world, mut schedule) = host();
    let model = spawn_surface(&mut world, &octant("cone(1,1)"));
    let first = spawn_fit(&mut world, model, sphere(), down_to(5));
    finish(&mut world, &mut schedule, first);
    let known = world.get::<FitReport>(first).unwrap().ladder[5].max;

    let limit = LimitSurface::new(Arc::clone(&snapshot(&world, model).surface)).unwrap();
    let target = SurfaceTarget::new(Arc::new(SurfaceIndex::new(Arc::new(limit)).unwrap()));
    let copy = spawn_surface(&mut world, &octant("cone(1,2)"));
    let options = FitOptions { tolerance: Some(TOLERANCE), last_level: 5, ..FitOptions::default() };
    let second = spawn_fit(&mut world, copy, Arc::new(target), options);
    finish(&mut world, &mut schedule, second);
    assert_eq!(world.get::<FitReport>(second).unwrap().outcome, Outcome::Within);

    let limit = LimitSurface::new(Arc::clone(&snapshot(&world, copy).surface)).unwrap();
    let mut worst = 0.0_f64;
    for face in (0..limit.face_count()).map(FaceId::new) {
        for (i, j) in (0..=20).flat_map(|i| (0..=20 - i).map(move |j| (i, j))) {
            let at = SurfacePoint::new(face, f64::from(i) / 20.0, f64::from(j) / 20.0);
            worst = worst.max((limit.position(at).length() - 0.5).abs());
        }
    }
    assert!(known < 1e-6 && worst <= TOLERANCE + known, "{worst:e} where the model is off by {known:e}");
}

#[test]
fn counts_in_reports_are_those_of_the_world() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,2)"));
    let fit = spawn_fit(&mut world, surface, sphere(), FitOptions { tolerance: Some(1e-4), ..down_to(4) });
    finish(&mut world, &mut schedule, fit);
    let report = world.get::<FitReport>(fit).unwrap().clone();
    assert_eq!(report.details, details_of(&mut world, surface));
    assert_eq!(report.details, snapshot(&world, surface).surface.details.count());
    assert_eq!(report.details, report.ladder.last().unwrap().details);
    let mut by_level = vec![0; report.ladder.len()];
    for level in world.query::<&DetailLevel>().iter(&world) {
        by_level[level.0 as usize] += 1;
    }
    let mut total = 0;
    for (rung, count) in report.ladder.iter().zip(by_level) {
        total += count;
        assert_eq!(rung.details, total, "level {}", rung.level);
    }
    assert_eq!(world.query::<&Detail>().iter(&world).filter(|d| d.0 == DVec3::ZERO).count(), 0);
    assert_eq!(details_of(&mut world, fit), 0, "nothing is left with the job");
}

#[test]
fn while_a_job_runs_its_details_are_its_own_and_the_surface_is_as_it_was() {
    let (mut world, mut schedule) = host();
    let source = octant("cone(1,1)");
    let surface = spawn_surface(&mut world, &source);
    let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
    schedule.run(&mut world);
    let before = snapshot(&world, surface).clone();
    let mut most = 0;
    while is_running(&world, fit) {
        assert_eq!(details_of(&mut world, surface), 0);
        assert_eq!(snapshot(&world, surface).revision, before.revision);
        // What the level may move is there as entities; what it has moved has its value.
        let active = world.get::<FitWork>(fit).unwrap().active().to_vec();
        let owned = details_of(&mut world, fit);
        most = most.max(owned);
        if matches!(state(&world, fit), Some(JobState::Running(Stage::Correspond | Stage::Modify))) {
            let stored = world.get::<FitWork>(fit).unwrap().details().clone();
            let mut rows = world.query::<(&DetailOf, &DetailLevel, &Address, &Detail)>();
            let mut here: Vec<_> = rows.iter(&world).filter(|r| r.0.0 == fit && r.1.0 == active[0].0).collect();
            here.sort_by_key(|r| *r.2);
            assert_eq!(here.iter().map(|r| (r.1.0, *r.2)).collect::<Vec<_>>(), active);
            assert!(here.iter().all(|r| r.3.0 == stored.at(r.1.0, *r.2)));
        }
        schedule.run(&mut world);
    }
    assert!(most > 100);
}

#[test]
fn jobs_at_different_stages_move_in_one_pass() {
    let (mut world, mut schedule) = host();
    let mut fits = Vec::new();
    // One job a pass: each is a stage ahead of the next.
    for _ in 0..3 {
        let surface = spawn_surface(&mut world, &octant("cone(1,2)"));
        fits.push(spawn_fit(&mut world, surface, sphere(), down_to(2)));
        schedule.run(&mut world);
    }
    let mut seen = Vec::new();
    while fits.iter().all(|&fit| is_running(&world, fit)) {
        let stages: Vec<_> = fits.iter().map(|&fit| state(&world, fit)).collect();
        let quanta: Vec<_> = fits.iter().map(|&fit| job(&world, fit).quanta).collect();
        assert_eq!(quanta[0], quanta[1] + 1);
        assert_eq!(quanta[1], quanta[2] + 1);
        // Every job has the one marker that its state says.
        for (&fit, state) in fits.iter().zip(&stages) {
            let entity = world.entity(fit);
            let markers =
                [entity.contains::<AtCorrespond>(), entity.contains::<AtModify>(), entity.contains::<AtRefine>()];
            let expected =
                [Stage::Correspond, Stage::Modify, Stage::Refine].map(|s| *state == Some(JobState::Running(s)));
            assert_eq!(markers, expected);
        }
        seen.push(stages);
        let before = *world.resource::<SubdivisionDiagnostics>().advance_items();
        schedule.run(&mut world);
        assert_eq!(*world.resource::<SubdivisionDiagnostics>().advance_items(), before + 3, "each took one step");
    }
    let all_different = |s: &Vec<Option<JobState>>| s[0] != s[1] && s[1] != s[2] && s[0] != s[2];
    assert!(seen.iter().any(all_different), "{seen:?}");
}

trait AdvanceItems {
    fn advance_items(&self) -> &u64;
}

impl AdvanceItems for SubdivisionDiagnostics {
    fn advance_items(&self) -> &u64 {
        &self.advance.items
    }
}

/// Cancelled after any number of passes, the world is as it was before the job was spawned.
#[test]
fn a_cancelled_job_leaves_the_world_as_it_was() {
    let (mut world, mut schedule) = host();
    let mut source = octant("cone(1,1)");
    source.details.levels = vec![vec![(Address::Corner(selvedge::mesh::VertexId(0)), DVec3::splat(1e-3))]];
    let surface = spawn_surface(&mut world, &source);
    schedule.run(&mut world);
    let before = dump_without_resources(&mut world);
    let count = world.entities().count_spawned();
    for passes in 0.. {
        let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
        for _ in 0..passes {
            schedule.run(&mut world);
        }
        if passes > 0 && !is_running(&world, fit) {
            assert!(passes > 10, "it ran for {passes} passes only");
            return;
        }
        // At once and from outside, or in the next pass and by a marker.
        if passes % 2 == 0 {
            cancel_fit(&mut world, fit);
            schedule.run(&mut world);
        } else {
            world.entity_mut(fit).insert(Cancelled);
            schedule.run(&mut world);
            assert_eq!(state(&world, fit), None);
            assert!(!world.entity(fit).contains::<FitWork>() && !world.entity(fit).contains::<AtRefine>());
            world.despawn(fit);
        }
        assert_eq!(dump_without_resources(&mut world), before, "after {passes} passes");
        assert_eq!(world.entities().count_spawned(), count);
    }
}

#[test]
fn a_cancelled_job_begins_anew_once_it_may() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
    let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
    world.entity_mut(fit).insert(Cancelled);
    schedule.run(&mut world);
    assert_eq!(state(&world, fit), None);
    world.entity_mut(fit).remove::<Cancelled>();
    finish(&mut world, &mut schedule, fit);
    assert!(world.get::<FitReport>(fit).is_some());
    let done = dump_without_resources(&mut world);
    world.entity_mut(fit).insert(Cancelled);
    schedule.run(&mut world);
    world.entity_mut(fit).remove::<Cancelled>();
    assert_eq!(dump_without_resources(&mut world), done, "what is finished is not taken back");
}

#[test]
fn an_edit_in_mid_job_starts_it_again_and_the_result_is_that_of_the_edited_surface() {
    let run = |edit_at: Option<u64>| {
        let (mut world, mut schedule) = host();
        let surface = spawn_surface(&mut world, &octant("cone(1,2)"));
        let edit = |world: &mut World| {
            let point = world.get::<ControlPoints>(surface).unwrap().0[0];
            world.get_mut::<Position>(point).unwrap().0 += DVec3::splat(0.01);
        };
        if edit_at.is_none() {
            edit(&mut world);
        }
        let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
        for pass in 0..edit_at.map_or(0, |at| at + 1) {
            if Some(pass) == edit_at {
                assert!(is_running(&world, fit));
                edit(&mut world);
            }
            schedule.run(&mut world);
        }
        let quanta = state(&world, fit).map_or(0, |_| job(&world, fit).quanta);
        finish(&mut world, &mut schedule, fit);
        assert_eq!(bits(&snapshot(&world, surface).surface.clone()), by_hand(&mut world, surface));
        (quanta, bits(&snapshot(&world, surface).surface), world.get::<FitReport>(fit).unwrap().clone())
    };
    let (_, expected, report) = run(None);
    for at in [1, 2, 5, 20] {
        let (quanta, found, again) = run(Some(at));
        assert_eq!(quanta, 1, "it has begun again");
        assert_eq!(found, expected);
        assert_eq!(again, report);
    }
}

#[test]
fn touching_inputs_with_the_same_value_does_not_start_a_job_again() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
    let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
    for pass in 1..=6 {
        schedule.run(&mut world);
        assert_eq!(job(&world, fit).quanta, pass);
        world.query::<&mut Position>().iter_mut(&mut world).for_each(|mut p| p.set_changed());
        for mut options in world.query::<&mut FitOptions>().iter_mut(&mut world) {
            options.set_changed();
        }
        let same = world.get::<FitTarget>(fit).unwrap().clone();
        world.entity_mut(fit).insert(same);
        let same = *world.resource::<Budgets>();
        world.insert_resource(same);
    }
}

/// Whatever a job reads starts it again when it changes, and only that.
#[test]
fn target_tolerance_options_and_budgets_start_a_finished_job_again() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
    let fit = spawn_fit(&mut world, surface, sphere(), down_to(1));
    finish(&mut world, &mut schedule, fit);
    let mut begun = world.resource::<SubdivisionDiagnostics>().admit.written;
    let mut again = |world: &mut World, schedule: &mut Schedule, what: &str| {
        finish(world, schedule, fit);
        let now = world.resource::<SubdivisionDiagnostics>().admit.written;
        assert_eq!(now, begun + 1, "{what}");
        begun = now;
    };
    world.entity_mut(fit).insert(FitTarget(sphere()));
    again(&mut world, &mut schedule, "another target");
    world.entity_mut(fit).insert(Tolerance::total(0.1));
    again(&mut world, &mut schedule, "a tolerance");
    assert_eq!(job(&world, fit).inputs.tolerance, Some(Tolerance::total(0.1)));
    world.get_mut::<FitOptions>(fit).unwrap().last_level = 2;
    again(&mut world, &mut schedule, "a level more");
    world.insert_resource(Budgets { levels: 9, ..Budgets::default() });
    again(&mut world, &mut schedule, "other budgets");
    world.entity_mut(fit).remove::<FitJob>();
    again(&mut world, &mut schedule, "on demand");
    let point = world.get::<ControlPoints>(surface).unwrap().0[0];
    world.get_mut::<Position>(point).unwrap().0 *= 1.1;
    schedule.run(&mut world);
    assert_eq!(state(&world, fit), Some(JobState::Finished), "an edit after the fit is meant");
}

#[test]
fn a_refit_keeps_the_entities_of_details_that_stay() {
    #[derive(Component)]
    struct Note;
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
    let fit = spawn_fit(&mut world, surface, sphere(), down_to(1));
    finish(&mut world, &mut schedule, fit);
    let mut rows = world.query::<(Entity, &DetailLevel, &Address)>();
    let before: Vec<_> = rows.iter(&world).map(|(e, level, address)| (*level, *address, e)).collect();
    for &(.., detail) in &before {
        world.entity_mut(detail).insert(Note);
    }
    let bigger: Arc<dyn Target> = Arc::new(Projection(|p: DVec3| p.normalize() * 0.501));
    world.entity_mut(fit).insert(FitTarget(bigger));
    finish(&mut world, &mut schedule, fit);
    let mut rows = world.query::<(Entity, &DetailLevel, &Address)>();
    let mut after: Vec<_> = rows.iter(&world).map(|(e, level, address)| (*level, *address, e)).collect();
    let mut before = before;
    before.sort_unstable();
    after.sort_unstable();
    assert_eq!(before, after);
    assert_eq!(world.query::<(&Note, &DetailOf)>().iter(&world).count(), before.len());
    assert_eq!(details_of(&mut world, surface), before.len());
}

#[test]
fn jobs_on_one_surface_take_turns_in_the_order_of_their_serials() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
    let fits: Vec<_> = (0..3).map(|_| spawn_fit(&mut world, surface, sphere(), down_to(1))).collect();
    let mut ended = Vec::new();
    for _ in 0..1000 {
        schedule.run(&mut world);
        let running = fits.iter().filter(|&&fit| is_running(&world, fit)).count();
        assert!(running <= 1);
        for &fit in &fits {
            if state(&world, fit) == Some(JobState::Finished) && !ended.contains(&fit) {
                ended.push(fit);
            }
        }
        if ended.len() == 3 {
            break;
        }
    }
    assert_eq!(ended, fits);
}

#[test]
fn a_job_waits_for_its_surface_to_be_mended() {
    let (mut world, mut schedule) = host();
    let mut source = octahedron();
    source.points[3].z = f64::NAN;
    let surface = spawn_surface(&mut world, &source);
    let fit = spawn_fit(&mut world, surface, sphere(), down_to(1));
    schedule.run(&mut world);
    assert!(world.get::<SurfaceFailed>(surface).is_some());
    assert_eq!(*failure(&world, fit), FitFault::SurfaceFailed { surface, faults: 1 });
    let idle = world.resource::<SubdivisionDiagnostics>().admit.written;
    schedule.run(&mut world);
    assert_eq!(world.resource::<SubdivisionDiagnostics>().admit.written, idle, "told once");
    let point = world.get::<ControlPoints>(surface).unwrap().0[3];
    world.get_mut::<Position>(point).unwrap().0.z = 0.0;
    finish(&mut world, &mut schedule, fit);
    assert!(world.get::<FitReport>(fit).is_some() && world.get::<FitFailed>(fit).is_none());
}

#[test]
fn a_job_without_a_surface_or_a_target_says_so() {
    let (mut world, mut schedule) = host();
    let nothing = world.spawn_empty().id();
    let lost = spawn_fit(&mut world, nothing, sphere(), down_to(1));
    let surface = spawn_surface(&mut world, &octahedron());
    let aimless = world.spawn(Fit { surface }).id();
    let vague = spawn_fit(&mut world, surface, sphere(), FitOptions { tolerance: Some(f64::NAN), ..down_to(1) });
    schedule.run(&mut world);
    assert_eq!(*failure(&world, lost), FitFault::NoSurface { surface: nothing });
    assert_eq!(*failure(&world, aimless), FitFault::NoTarget);
    assert!(matches!(failure(&world, vague), FitFault::Fit(FitError::BadTolerance { .. })));
}

/// A target of a host's own, with nothing to keep it from panicking.
#[derive(Debug)]
struct Wild {
    answers: fn(DVec3) -> DVec3,
    revision: fn() -> u64,
}

impl Target for Wild {
    fn closest(&self, to: DVec3, _: Option<SurfacePoint>) -> Result<Foot, TargetError> {
        Ok(Foot { position: (self.answers)(to), at: None })
    }

    fn revision(&self) -> u64 {
        (self.revision)()
    }
}

#[test]
fn user_code_that_panics_or_gives_nan_is_a_failure_with_a_place_and_no_change() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
    schedule.run(&mut world);
    let before = dump_without_resources(&mut world);
    let fails = |world: &mut World, schedule: &mut Schedule, target: Arc<dyn Target>| {
        let fit = spawn_fit(world, surface, target, down_to(1));
        finish(world, schedule, fit);
        let why = failure(world, fit).clone();
        assert!(!world.entity(fit).contains::<FitWork>());
        world.despawn(fit);
        why
    };
    let closures: [fn(DVec3) -> DVec3; 2] = [|_| panic!("no sphere here"), |p| p / 0.0];
    for answers in closures {
        for target in [Arc::new(Wild { answers, revision: || 0 }) as Arc<dyn Target>, Arc::new(Projection(answers))] {
            let why = fails(&mut world, &mut schedule, target);
            match why {
                FitFault::Fit(FitError::Target(TargetError::Panicked { to, message })) => {
                    assert!(to.is_finite() && message == "no sphere here");
                }
                FitFault::Fit(FitError::Target(TargetError::NotFinite { to, .. })) => assert!(to.is_finite()),
                other => panic!("{other:?}"),
            }
            assert_eq!(dump_without_resources(&mut world), before);
        }
    }
    // Late in the fit, when there are details already.
    static CALLS: AtomicU64 = AtomicU64::new(0);
    let late = |p: DVec3| {
        assert!(CALLS.fetch_add(1, Ordering::Relaxed) < 100, "enough");
        p.normalize() * 0.5
    };
    let why = fails(&mut world, &mut schedule, Arc::new(Projection(late)));
    assert!(matches!(why, FitFault::Fit(FitError::Target(TargetError::Panicked { .. }))), "{why:?}");
    assert_eq!(dump_without_resources(&mut world), before);
    let moody = Wild { answers: |p| p, revision: || panic!("do not ask") };
    let why = fails(&mut world, &mut schedule, Arc::new(moody));
    assert_eq!(why, FitFault::TargetRevision { message: "do not ask".into() });
    assert_eq!(dump_without_resources(&mut world), before);
}

#[test]
fn a_spent_budget_ends_a_job_without_a_change_and_a_raised_one_begins_it_again() {
    let plenty = Budgets::default();
    let tight = [
        (Budget::Levels, Budgets { levels: 1, ..plenty }),
        (Budget::Quanta, Budgets { quanta: 5, ..plenty }),
        (Budget::CurveEvaluations, Budgets { curve_evaluations: 200, ..plenty }),
        (Budget::Details, Budgets { details: 20, ..plenty }),
    ];
    for (which, budgets) in tight {
        let (mut world, mut schedule) = host();
        let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
        world.insert_resource(budgets);
        schedule.run(&mut world);
        let before = dump_without_resources(&mut world);
        let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
        finish(&mut world, &mut schedule, fit);
        let (needed, limit) = match failure(&world, fit) {
            FitFault::Budget(over) | FitFault::Fit(FitError::Target(TargetError::Budget(over))) => {
                assert_eq!(over.budget, which);
                (over.needed, over.limit)
            }
            FitFault::Fit(FitError::TooManyDetails { details, limit, .. }) => (*details as u64, *limit as u64),
            other => panic!("{other:?}"),
        };
        assert_eq!(limit, budgets.limit(which));
        assert!(needed > limit);
        let own = format!("{fit}:");
        let others: Vec<_> = dump_without_resources(&mut world).into_iter().filter(|l| !l.starts_with(&own)).collect();
        assert_eq!(others, before, "{which}");
        world.insert_resource(plenty);
        finish(&mut world, &mut schedule, fit);
        assert!(world.get::<FitReport>(fit).is_some() && world.get::<FitFailed>(fit).is_none());
    }
}

#[test]
fn a_tolerance_that_is_not_reached_is_a_failure_that_says_by_how_much() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &octant("cone(1,2)"));
    let options = FitOptions { tolerance: Some(1e-6), ..down_to(1) };
    let fit = spawn_fit(&mut world, surface, sphere(), options);
    finish(&mut world, &mut schedule, fit);
    let failed = world.get::<FitFailed>(fit).unwrap();
    let FitFault::NotReached { outcome: Outcome::LevelsSpent { achieved, .. } } = failed.why else {
        panic!("{failed:?}");
    };
    assert_eq!(failed.ladder.len(), 2);
    assert_eq!(achieved, failed.ladder[1].max);
    assert!(achieved > 1e-6);
    assert_eq!(details_of(&mut world, surface) + details_of(&mut world, fit), 0);
}

#[test]
fn what_a_host_takes_away_in_mid_job_leaves_nothing_behind() {
    type Take = fn(&mut World, Entity, Entity);
    let takes: [(&str, Take); 5] = [
        ("the job", |world, _, fit| assert!(world.despawn(fit))),
        ("what makes it a job", |world, _, fit| {
            world.entity_mut(fit).remove::<Fit>();
        }),
        ("its state, and it may not begin again", |world, _, fit| {
            world.entity_mut(fit).remove::<FitJob>().insert(Cancelled);
        }),
        ("the surface", |world, surface, _| despawn_surface(world, surface)),
        ("the surface and the job", |world, surface, fit| {
            despawn_surface(world, surface);
            world.despawn(fit);
        }),
    ];
    for (what, take) in takes {
        let (mut world, mut schedule) = host();
        let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
        let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
        while details_of(&mut world, fit) == 0 {
            schedule.run(&mut world);
        }
        assert!(is_running(&world, fit));
        take(&mut world, surface, fit);
        for _ in 0..3 {
            schedule.run(&mut world);
        }
        assert_eq!(world.query::<&Detail>().iter(&world).count(), 0, "{what}");
        let works = world.query::<&FitWork>().iter(&world).count() + world.query::<&AtModify>().iter(&world).count();
        assert_eq!(works, 0, "{what}");
        if what == "the surface" {
            assert_eq!(*failure(&world, fit), FitFault::NoSurface { surface });
        }
    }
}

#[test]
fn work_that_was_dropped_is_done_again_with_the_same_result() {
    let run = |drop_at: Option<u32>| {
        let (mut world, mut schedule) = host();
        let surface = spawn_surface(&mut world, &octant("cone(1,1)"));
        let fit = spawn_fit(&mut world, surface, sphere(), down_to(2));
        for _ in 0..drop_at.unwrap_or(0) {
            schedule.run(&mut world);
        }
        world.entity_mut(fit).remove::<FitWork>();
        finish(&mut world, &mut schedule, fit);
        let details = details_of(&mut world, fit) + details_of(&mut world, surface);
        (bits(&snapshot(&world, surface).surface), details, world.get::<FitReport>(fit).unwrap().clone())
    };
    assert_eq!(run(Some(7)), run(None));
}
