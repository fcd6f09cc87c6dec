//! The engine in a box: a private world and schedule, and no window.

use core::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use glam::DVec3;
use selvedge_components::curve::{Curve, Heading};
use selvedge_components::error::{CurveUnchecked, FitFailed, SurfaceFailed};
use selvedge_components::job::{FitJob, JobState};
use selvedge_components::mesh::Connectivity;
use selvedge_components::report::FitReport;
use selvedge_components::subdivision::fit::FitOptions;
use selvedge_components::subdivision::{LoopSurface, Snapshot};
use selvedge_components::target::Target;
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{
    OtherSide, PreImagePoint, Trim, TrimFailed, TrimJob, TrimOptions, TrimReport, TrimStage, TrimState, TrimmedTo,
};
use selvedge_systems::triangulate::Triangulating;
use thiserror::Error;

use crate::{
    BakeError, bake, cancel_fit, despawn_surface, install, spawn_cage, spawn_curve, spawn_fit, spawn_surface,
    spawn_trim, strict, tell_pre_image,
};

/// The schedule that an [`Engine`] runs once a pass.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SelvedgePass;

type JobOrTrim = Or<(With<FitJob>, With<TrimJob>)>;

/// A world and a schedule of their own, filled by [`install`] like any host's. Headless.
///
/// Systems run one after the other on the calling thread, and each uses all cores by itself: two
/// pools of threads would only be in each other's way. The engine needs no task pool of Bevy's;
/// systems that a host adds and that need one must bring it.
pub struct Engine {
    world: World,
    schedule: Schedule,
    jobs: QueryState<(Entity, Option<&'static FitJob>, Option<&'static TrimJob>), JobOrTrim>,
    unchecked: QueryState<(), With<CurveUnchecked>>,
    triangulating: QueryState<(Entity, &'static Triangulating)>,
}

impl fmt::Debug for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Engine").field("world", &self.world).finish_non_exhaustive()
    }
}

/// How far a job is.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// It has not begun: its turn has not come.
    Waiting,
    /// It is being worked on.
    Running {
        /// The level in work.
        level: u32,
        /// Work quanta that it has taken.
        quanta: u64,
        /// The largest distance from the target measured last, in model units.
        error: Option<f64>,
    },
    /// It is done.
    Finished(FitReport),
    /// It failed; the surface is as it was.
    Failed(FitFailed),
}

/// How far a trim is.
#[derive(Clone, Debug, PartialEq)]
pub enum TrimProgress {
    /// It has not begun, or waits for other trims of its source.
    Waiting,
    /// It is being worked on.
    Running {
        /// Its stage.
        stage: TrimStage,
        /// Work quanta that it has taken.
        quanta: u64,
    },
    /// It is made together with another trim, which carries the work.
    With(Entity),
    /// It is done.
    Finished(Box<TrimReport>),
    /// It failed; the source is as it was.
    Failed(TrimFailed),
}

/// What a pass left behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Nothing is left to do.
    Idle,
    /// Jobs are running.
    Busy,
}

/// Jobs are running, but none of them has moved in a whole pass: the system of their stage was
/// taken out, or does not do what its set asks.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{} jobs do not move: no system takes a step for them", .jobs.len())]
pub struct Stalled {
    /// The jobs, and surfaces whose triangles are being made.
    pub jobs: Vec<Entity>,
}

impl Default for Engine {
    fn default() -> Self {
        Self::new()
    }
}

impl Engine {
    /// An engine with nothing in it.
    pub fn new() -> Self {
        let (mut world, mut schedule) = (World::new(), Schedule::new(SelvedgePass));
        schedule.set_executor(SingleThreadedExecutor::new());
        schedule.set_build_settings(strict());
        install(&mut world, &mut schedule);
        let (jobs, unchecked, triangulating) = (world.query_filtered(), world.query_filtered(), world.query());
        Self { world, schedule, jobs, unchecked, triangulating }
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world: to edit sources, to insert [`Budgets`](selvedge_components::budget::Budgets), to
    /// query.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// World and schedule together: to add systems, or to replace a stage.
    pub fn with_schedule<R>(&mut self, change: impl FnOnce(&mut World, &mut Schedule) -> R) -> R {
        change(&mut self.world, &mut self.schedule)
    }

    /// See [`spawn_surface`].
    pub fn spawn_surface(&mut self, surface: &LoopSurface) -> Entity {
        spawn_surface(&mut self.world, surface)
    }

    /// See [`spawn_cage`].
    pub fn spawn_cage(&mut self, mesh: Arc<Connectivity>, points: &[DVec3]) -> Entity {
        spawn_cage(&mut self.world, mesh, points)
    }

    /// See [`spawn_fit`].
    pub fn spawn_fit(&mut self, surface: Entity, target: Arc<dyn Target>, options: FitOptions) -> Entity {
        spawn_fit(&mut self.world, surface, target, options)
    }

    /// See [`spawn_curve`].
    pub fn spawn_curve(&mut self, curve: Arc<dyn Curve>) -> Entity {
        spawn_curve(&mut self.world, curve)
    }

    /// See [`spawn_trim`].
    pub fn spawn_trim(
        &mut self,
        source: Entity,
        cuts: &[(Entity, Heading)],
        tolerance: Option<Tolerance>,
        options: TrimOptions,
    ) -> Entity {
        spawn_trim(&mut self.world, source, cuts, tolerance, options)
    }

    /// See [`tell_pre_image`].
    pub fn tell_pre_image(&mut self, trim: Entity, cut: usize, points: Vec<PreImagePoint>) {
        tell_pre_image(&mut self.world, trim, cut, points);
    }

    /// The entity that stands for what is left of `source` by all of its trims, once there is one.
    pub fn result(&self, source: Entity) -> Option<Entity> {
        self.world.get::<TrimmedTo>(source).map(|result| result.0)
    }

    /// The entity that stands for what `trim` removes, once there is one: its options must ask for
    /// [`Sides::Both`](selvedge_components::trim::Sides::Both).
    pub fn other_side(&self, trim: Entity) -> Option<Entity> {
        self.world.get::<OtherSide>(trim).map(|result| result.0)
    }

    /// See [`bake`].
    ///
    /// # Errors
    /// As [`bake`].
    pub fn bake(&mut self, result: Entity) -> Result<Entity, BakeError> {
        bake(&mut self.world, result)
    }

    /// How far `trim` is; `None` for what is no trim.
    pub fn trim_progress(&self, trim: Entity) -> Option<TrimProgress> {
        let entity = self.world.get_entity(trim).ok()?;
        entity.get::<Trim>()?;
        let Some(job) = entity.get::<TrimJob>() else { return Some(TrimProgress::Waiting) };
        Some(match job.state {
            TrimState::Running(stage) => TrimProgress::Running { stage, quanta: job.quanta },
            TrimState::Located => TrimProgress::Waiting,
            TrimState::With(other) => TrimProgress::With(other),
            TrimState::Finished => TrimProgress::Finished(Box::new(entity.get::<TrimReport>()?.clone())),
            TrimState::Failed => TrimProgress::Failed(entity.get::<TrimFailed>()?.clone()),
        })
    }

    /// See [`despawn_surface`].
    pub fn despawn_surface(&mut self, surface: Entity) {
        despawn_surface(&mut self.world, surface);
    }

    /// See [`cancel_fit`].
    pub fn cancel(&mut self, job: Entity) {
        cancel_fit(&mut self.world, job);
    }

    /// The dense form of `surface`, as the last pass has gathered it.
    ///
    /// # Errors
    /// Its faults, if it has any.
    ///
    /// Neither while no pass has run since it was spawned, nor for what is no surface: then `None`.
    pub fn surface(&self, surface: Entity) -> Option<Result<&Arc<LoopSurface>, &SurfaceFailed>> {
        let entity = self.world.get_entity(surface).ok()?;
        let failed = entity.get::<SurfaceFailed>().map(Err);
        failed.or_else(|| entity.get::<Snapshot>().map(|snapshot| Ok(&snapshot.surface)))
    }

    /// How far `job` is; `None` for what is no job.
    pub fn progress(&self, job: Entity) -> Option<Progress> {
        let entity = self.world.get_entity(job).ok()?;
        entity.get::<selvedge_components::job::Fit>()?;
        let Some(fit) = entity.get::<FitJob>() else { return Some(Progress::Waiting) };
        Some(match fit.state {
            JobState::Running(_) => Progress::Running { level: fit.level, quanta: fit.quanta, error: fit.error },
            JobState::Finished => Progress::Finished(entity.get::<FitReport>()?.clone()),
            JobState::Failed => Progress::Failed(entity.get::<FitFailed>()?.clone()),
        })
    }

    /// One pass: what has changed is gathered and checked, every running job takes one step, and
    /// triangles are made or gone on with.
    pub fn update(&mut self) -> Pass {
        let before = self.work();
        self.pass();
        let after = self.work();
        // A job that has just ended has changed its surface: one more pass gathers that.
        let is_idle = before.jobs == after.jobs && after.running().is_empty() && after.unchecked == 0;
        if is_idle { Pass::Idle } else { Pass::Busy }
    }

    /// Passes until nothing is left to do. Returns how many.
    ///
    /// # Errors
    /// [`Stalled`] when jobs are left that no system moves.
    pub fn settle(&mut self) -> Result<u64, Stalled> {
        let mut before = self.work();
        let mut passes = 0;
        loop {
            self.pass();
            passes += 1;
            let after = self.work();
            if before == after {
                let jobs = after.running();
                return if jobs.is_empty() { Ok(passes) } else { Err(Stalled { jobs }) };
            }
            before = after;
        }
    }

    /// Passes until nothing is left to do or `time` is over, but one pass at least. A pass that has
    /// begun is finished, so it may take longer by as much as the work quanta of one pass do: see
    /// [`PassAllowance`](selvedge_components::budget::PassAllowance).
    pub fn update_for(&mut self, time: Duration) -> Pass {
        let start = Instant::now();
        loop {
            let pass = self.update();
            if pass == Pass::Idle || start.elapsed() >= time {
                return pass;
            }
        }
    }

    fn pass(&mut self) {
        self.schedule.run(&mut self.world);
        // Nobody else forgets what was removed, and a world that runs for long must not grow by it.
        self.world.clear_trackers();
    }

    /// How far everything is that takes more than a pass.
    fn work(&mut self) -> Work {
        let jobs = self.jobs.iter(&self.world);
        let mut jobs: Vec<_> = jobs
            .map(|(entity, fit, trim)| {
                let quanta = fit.map_or(0, |job| job.quanta) + trim.map_or(0, |job| job.quanta);
                (entity, fit.map(|job| job.state), trim.map(|job| job.state), quanta)
            })
            .collect();
        jobs.sort_unstable_by_key(|job| job.0);
        let triangulating = self.triangulating.iter(&self.world);
        let mut triangulating: Vec<_> =
            triangulating.map(|(entity, work)| (entity, work.from().revision, work.passes())).collect();
        triangulating.sort_unstable();
        Work { jobs, unchecked: self.unchecked.iter(&self.world).count(), triangulating }
    }
}

/// What takes more than a pass.
#[derive(PartialEq)]
struct Work {
    /// Where every job and trim stands, by entity.
    jobs: Vec<Standing>,
    /// How many curves wait to be checked.
    unchecked: usize,
    /// The surfaces whose triangles are being made: of which revision, and for how many passes.
    triangulating: Vec<(Entity, u64, u64)>,
}

/// Where a job or a trim stands: what it is, and how many quanta it has taken.
type Standing = (Entity, Option<JobState>, Option<TrimState>, u64);

impl Work {
    /// The jobs and surfaces that a pass should move.
    fn running(&self) -> Vec<Entity> {
        let is_running = |&&(_, fit, trim, _): &&Standing| {
            matches!(fit, Some(JobState::Running(_))) || trim.is_some_and(TrimState::is_running)
        };
        let jobs = self.jobs.iter().filter(is_running).map(|job| job.0);
        jobs.chain(self.triangulating.iter().map(|surface| surface.0)).collect()
    }
}
