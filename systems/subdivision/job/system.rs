//! The systems that begin, move and end jobs.

use std::sync::Arc;

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use selvedge_components::budget::Budgets;
use selvedge_components::error::{FitFailed, FitFault, SurfaceFailed};
use selvedge_components::guard::caught;
use selvedge_components::identity::Serial;
use selvedge_components::job::{
    AtCorrespond, AtModify, AtRefine, Cancelled, Fit, FitInputs, FitJob, FitTarget, JobState,
};
use selvedge_components::report::FitReport;
use selvedge_components::subdivision::fit::{FitOptions, Outcome, Stage};
use selvedge_components::subdivision::{Address, Cage, Detail, DetailLevel, DetailOf, Snapshot};
use selvedge_components::target::Guarded;
use selvedge_components::tolerance::Tolerance;

use super::{Commit, Move, Order, Place, SurfaceNow, Verdict, Wish, commit, first_on_each_surface, next_move, verdict};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::parallel::for_each;
use crate::subdivision::fit::FitWork;

type Job = (
    Entity,
    Option<&'static Serial>,
    &'static Fit,
    Option<&'static FitTarget>,
    &'static FitOptions,
    Option<&'static Tolerance>,
    Option<&'static FitJob>,
    Has<FitWork>,
    Has<Cancelled>,
);
type Surface = (Option<&'static Snapshot>, Option<&'static SurfaceFailed>);

/// What the engine adds to a job while it runs, or when it has failed.
type Traces = (FitJob, FitWork, AtCorrespond, AtModify, AtRefine, FitFailed);

/// The jobs that began or went on in the pass before.
pub type Running = EntityHashSet;

/// Begins jobs, begins again those whose inputs have changed, and takes back what was cancelled.
pub fn admit_fits(
    mut commands: Commands,
    jobs: Query<Job>,
    surfaces: Query<Surface, With<Cage>>,
    details: Query<(Entity, &DetailOf)>,
    budgets: Option<Res<Budgets>>,
    mut running: Local<Running>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let budgets = budgets.map_or_else(Budgets::default, |b| *b);
    let mut found: Vec<_> = jobs.iter().collect();
    found.sort_unstable_by_key(|job| (job.1, job.0));
    let mut candidates: Vec<_> = found.into_iter().map(|job| Candidate::new(job, &surfaces, budgets)).collect();
    wait_for_turns(&mut candidates);

    let goes_on: EntityHashSet = candidates.iter().filter(|c| c.goes_on()).map(|c| c.entity).collect();
    let over: EntityHashSet = candidates.iter().filter(|c| c.is_over()).map(|c| c.entity).collect();
    let broken_off = running.iter().filter(|job| !goes_on.contains(*job) && !over.contains(*job));
    let broken_off: EntityHashSet = broken_off.copied().collect();
    discard(&mut commands, &broken_off, details.iter().map(|(detail, of)| (detail, of.0)));
    for &job in broken_off.iter().filter(|&&job| !jobs.contains(job)) {
        // It is a job no longer, and may not even be an entity.
        commands.entity(job).try_remove::<Traces>();
    }
    *running = goes_on;

    run.counted.items = candidates.len() as u64;
    let mut starts = Vec::new();
    for Candidate { entity, order, verdict, .. } in candidates {
        run.counted.skipped += u64::from(verdict == Verdict::Keep);
        run.counted.written += u64::from(verdict != Verdict::Keep);
        match verdict {
            Verdict::Keep => {}
            Verdict::Start => starts.push((entity, order.inputs(), None)),
            Verdict::Wait | Verdict::TakeBack => {
                commands.entity(entity).try_remove::<Traces>();
            }
            Verdict::Refuse(why) => fail(commands.entity(entity), order.inputs(), why),
        }
    }
    for_each(starts.iter_mut().collect(), |(_, inputs, work)| *work = Some(begin(inputs, &surfaces)));
    for (job, inputs, work) in starts {
        running.insert(job);
        match work {
            Some(Ok(work)) => start(commands.entity(job), inputs, work),
            Some(Err(why)) => fail(commands.entity(job), inputs, why),
            None => {}
        }
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.admit += run.finish();
    }
}

/// A job, and what is to be done about it.
struct Candidate<'w> {
    entity: Entity,
    state: Option<JobState>,
    has_work: bool,
    order: Order<'w>,
    verdict: Verdict,
}

impl<'w> Candidate<'w> {
    fn new(job: <Job as QueryData>::Item<'w, '_>, surfaces: &Query<Surface, With<Cage>>, budgets: Budgets) -> Self {
        let (entity, _, fit, target, options, tolerance, job, has_work, cancelled) = job;
        let now = match surfaces.get(fit.surface) {
            Err(_) => SurfaceNow::Missing,
            Ok((Some(snapshot), _)) => SurfaceNow::Sound(snapshot.revision),
            Ok((None, Some(failed))) => SurfaceNow::Failed(failed.0.len()),
            Ok((None, None)) => SurfaceNow::Ungathered,
        };
        let order = Order {
            surface: fit.surface,
            now,
            target: target.map(|target| &target.0),
            target_revision: target.map_or(Ok(0), |target| caught(|| target.0.revision())),
            options,
            tolerance: tolerance.copied(),
            budgets,
        };
        let wish = if cancelled { Wish::Cancel } else { Wish::Run };
        // A job that has lost its work, which is derived, begins again.
        let whole = job.filter(|job| has_work || !job.is_running());
        let verdict = match verdict(wish, whole, &order) {
            // One that was never begun has nothing to clear; one that a host has stripped of its state has.
            Verdict::Wait if job.is_none() && !has_work => Verdict::Keep,
            Verdict::Keep if job.is_none() && has_work => Verdict::TakeBack,
            verdict => verdict,
        };
        Self { entity, state: job.map(|job| job.state), has_work, order, verdict }
    }

    fn goes_on(&self) -> bool {
        matches!(self.state, Some(JobState::Running(_))) && self.verdict == Verdict::Keep
    }

    /// Has it ended by itself? Then nothing of it is left to clear.
    fn is_over(&self) -> bool {
        matches!(self.state, Some(JobState::Finished | JobState::Failed))
    }
}

/// Lets those that would start wait where another job is on the same surface, or comes first.
fn wait_for_turns(candidates: &mut [Candidate<'_>]) {
    let starting = candidates.iter().filter(|c| c.verdict == Verdict::Start).map(|c| (c.entity, c.order.surface));
    let busy = candidates.iter().filter(|c| c.goes_on()).map(|c| c.order.surface);
    let first = first_on_each_surface(&starting.collect::<Vec<_>>(), busy.collect());
    for candidate in candidates.iter_mut().filter(|c| c.verdict == Verdict::Start && !first.contains(&c.entity)) {
        let traced = candidate.state.is_some() || candidate.has_work;
        candidate.verdict = if traced { Verdict::Wait } else { Verdict::Keep };
    }
}

/// Begins the work of a job, on what its surface is now.
fn begin(now: &FitInputs, surfaces: &Query<Surface, With<Cage>>) -> Result<FitWork, FitFault> {
    let Ok((Some(snapshot), _)) = surfaces.get(now.surface) else {
        return Err(FitFault::NoSurface { surface: now.surface });
    };
    let target = now.target.as_ref().ok_or(FitFault::NoTarget)?;
    let guarded = Arc::new(Guarded::new(Arc::clone(target), now.budgets));
    let most_details = usize::try_from(now.budgets.details).unwrap_or(usize::MAX);
    let mut options = now.options.clone();
    options.tolerance = now.tolerance.map_or(options.tolerance, |tolerance| Some(tolerance.fit));
    options.most_details = options.most_details.min(most_details);
    let surface = Arc::clone(&snapshot.surface);
    caught(|| FitWork::new(surface, guarded, options))
        .map_err(|message| FitFault::Panicked { stage: Stage::Refine, message })?
        .map_err(FitFault::Fit)
}

/// Puts a begun job on its way.
fn start(mut job: EntityCommands, inputs: FitInputs, work: FitWork) {
    let stage = work.stage();
    job.try_remove::<Traces>().try_insert((FitJob::new(JobState::Running(stage), inputs), work));
    mark(&mut job, stage);
}

/// Tells why a job could not begin.
fn fail(mut job: EntityCommands, inputs: FitInputs, why: FitFault) {
    let failed = FitFailed { why, ladder: Vec::new() };
    job.try_remove::<Traces>().try_insert((FitJob::new(JobState::Failed, inputs), failed));
}

/// Moves the marker of a job to `stage`.
pub(in crate::subdivision) fn mark(job: &mut EntityCommands, stage: Stage) {
    job.try_remove::<(AtCorrespond, AtModify, AtRefine)>();
    match stage {
        Stage::Correspond => job.try_insert(AtCorrespond),
        Stage::Modify => job.try_insert(AtModify),
        Stage::Refine => job.try_insert(AtRefine),
    };
}

/// Despawns the details that belong to `jobs`.
pub(in crate::subdivision) fn discard(
    commands: &mut Commands,
    jobs: &EntityHashSet,
    details: impl Iterator<Item = (Entity, Entity)>,
) {
    if jobs.is_empty() {
        return;
    }
    for (detail, _) in details.filter(|(_, owner)| jobs.contains(owner)) {
        commands.entity(detail).try_despawn();
    }
}

/// A detail coefficient.
pub(in crate::subdivision) type Coefficient =
    (Entity, &'static mut Detail, &'static DetailLevel, &'static Address, &'static mut DetailOf);

/// Writes the transitions of all jobs that took a step, and the results of those that are done.
pub fn advance_fits(
    mut commands: Commands,
    mut jobs: Query<(Entity, &mut FitJob, &FitWork), With<Fit>>,
    mut details: Query<Coefficient>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut failed = EntityHashSet::default();
    for (entity, mut job, work) in &mut jobs {
        if job.step.is_none() {
            run.counted.skipped += 1;
            continue;
        }
        run.counted.items += 1;
        let next = next_move(&mut job, work.outcome());
        run.counted.written += u64::from(next != Move::Stay);
        match next {
            Move::Stay => {}
            Move::GoTo(stage) => {
                job.state = JobState::Running(stage);
                mark(&mut commands.entity(entity), stage);
            }
            Move::Finish(outcome) => {
                job.state = JobState::Finished;
                let stored = deliver(&mut commands, &mut details, entity, job.inputs.surface, work);
                let report = report(work, outcome, stored);
                commands.entity(entity).try_remove::<(FitWork, AtCorrespond, AtModify, AtRefine)>().try_insert(report);
            }
            Move::Fail(why) => {
                job.state = JobState::Failed;
                failed.insert(entity);
                let ladder = work.ladder().to_vec();
                let mut entity = commands.entity(entity);
                entity.try_remove::<(FitWork, AtCorrespond, AtModify, AtRefine)>();
                entity.try_insert(FitFailed { why, ladder });
            }
        }
    }
    discard(&mut commands, &failed, details.iter().map(|(detail, .., of)| (detail, of.0)));
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.advance += run.finish();
    }
}

fn report(work: &FitWork, outcome: Outcome, details: usize) -> FitReport {
    FitReport { initial: work.initial().copied(), ladder: work.ladder().to_vec(), outcome, details }
}

/// Makes what `work` has found the details of `surface`, which may be the job itself. Returns how
/// many they are.
pub(in crate::subdivision) fn deliver(
    commands: &mut Commands,
    details: &mut Query<Coefficient>,
    job: Entity,
    surface: Entity,
    work: &FitWork,
) -> usize {
    let (mut of_surface, mut of_job) = (Vec::<(Place, Entity)>::new(), Vec::new());
    for (entity, _, level, &address, of) in details.iter() {
        let place = ((level.0, address), entity);
        of_surface.extend((of.0 == surface).then_some(place));
        of_job.extend((of.0 == job && job != surface).then_some(place));
    }
    let Commit { write, give, spawn, despawn } = commit(work.details(), of_surface, of_job);
    let count = write.len() + give.len() + spawn.len();
    for (entity, value) in write.into_iter().chain(give) {
        if let Ok((_, mut detail, _, _, mut of)) = details.get_mut(entity) {
            detail.set_if_neq(Detail(value));
            of.set_if_neq(DetailOf(surface));
        }
    }
    commands.spawn_batch(
        spawn
            .into_iter()
            .map(move |((level, address), value)| (Detail(value), DetailLevel(level), address, DetailOf(surface))),
    );
    for entity in despawn {
        commands.entity(entity).try_despawn();
    }
    count
}
