//! Jobs: work that takes many passes, and where each of them stands.
//!
//! A job is an entity. Its stage is a marker, so that each stage's system finds its jobs in tables
//! of their own; everything else about it is in one component, [`FitJob`].
//!
//! ```text
//!                  +----------------- next level, next round ------------------+
//!                  v                                                           |
//! Fit -> AtRefine -+-> AtCorrespond -> AtModify -> AtRefine -------------------+
//!           |              |              |           |
//!           +--------------+--------------+-----------+--> FitReport, or FitFailed and no change
//! ```

use std::sync::Arc;

use bevy_ecs::prelude::{Component, Entity};

use crate::budget::Budgets;
use crate::error::FitFault;
use crate::subdivision::fit::{FitOptions, Quantum, Stage};
use crate::target::Target;
use crate::tolerance::Tolerance;

/// A job: fit a subdivision surface to a [`FitTarget`], by detail coefficients.
///
/// Spawn an entity with both, and with [`FitOptions`] and a
/// [`Tolerance`] if you like (its `fit` is then the distance asked
/// for), and the job starts in the next pass; of several on one surface, the one of the smallest
/// serial goes first. It starts again when the surface is edited while it runs, and when target,
/// tolerance, options or budgets change, whether it runs or not. A finished fit is not done again
/// for later edits of its surface, which are meant; to have it done again, remove [`FitJob`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[require(FitOptions)]
pub struct Fit {
    /// The surface to be fitted. Its control points stay; its details are replaced at the end.
    pub surface: Entity,
}

/// What a [`Fit`] fits to.
#[derive(Component, Clone, Debug)]
pub struct FitTarget(pub Arc<dyn Target>);

/// Stop this job and take back all that it did: the world is as it was before the job began, and
/// the job does not start again while this is here. Inserted by the host.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cancelled;

/// Marks a job that pairs points of its surface with points of its target.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtCorrespond;

/// Marks a job that works out the details of its level.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtModify;

/// Marks a job that measures what is left and opens the next level.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtRefine;

/// All that a fit reads, as it was when it started.
#[derive(Clone, Debug)]
pub struct FitInputs {
    /// The surface.
    pub surface: Entity,
    /// The revision of its snapshot; `None` while it has none.
    pub revision: Option<u64>,
    /// The target; `None` where the job has none.
    pub target: Option<Arc<dyn Target>>,
    /// The revision of the target; what it said where it panicked when asked.
    pub target_revision: Result<u64, String>,
    /// How the fit is made.
    pub options: FitOptions,
    /// The job's tolerance, if it has one; it goes before that of the options.
    pub tolerance: Option<Tolerance>,
    /// What may be spent.
    pub budgets: Budgets,
}

/// Whether a job runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobState {
    /// It is at this stage; its marker says the same.
    Running(Stage),
    /// It is done, and its report is there.
    Finished,
    /// It failed, and its failure is there.
    Failed,
}

/// Where a fit stands. Written by the engine; remove it to have the fit done again.
#[derive(Component, Clone, Debug)]
pub struct FitJob {
    /// Whether it runs.
    pub state: JobState,
    /// What it read when it started.
    pub inputs: FitInputs,
    /// What the stage that ran in this pass has to say. The system of a stage sets it, once a pass,
    /// on each job that bears the stage's marker and has its turn; the end of the pass takes it.
    pub step: Option<Result<Quantum, FitFault>>,
    /// How many work quanta it has taken.
    pub quanta: u64,
    /// The level that it works on.
    pub level: u32,
    /// The largest distance from the target that was measured last, in model units.
    pub error: Option<f64>,
}

impl FitJob {
    /// A job that begins with these inputs.
    pub const fn new(state: JobState, inputs: FitInputs) -> Self {
        Self { state, inputs, step: None, quanta: 0, level: 0, error: None }
    }

    /// Is it running?
    pub const fn is_running(&self) -> bool {
        matches!(self.state, JobState::Running(_))
    }
}
