//! Where a trim stands, and what it reads.

use core::fmt;
use std::sync::Arc;

use bevy_ecs::prelude::{Component, Entity};

use super::{PreImages, TrimFault, TrimOptions};
use crate::budget::Budgets;
use crate::curve::{Curve, Heading};
use crate::tolerance::Tolerance;

/// Marks a trim whose curves are being found on its source.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtLocate;

/// Marks a trim whose curves are being worked into the cage.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtRemesh;

/// Marks a trim whose new vertices settle along its curves.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtRelax;

/// Marks a trim that is fitted and is being measured.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtAudit;

/// The stages that are a trim's own; before the last, it is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TrimStage {
    /// Curves are found on the source.
    Locate,
    /// Curves are worked into the cage.
    Remesh,
    /// New vertices settle along the curves, and the new cage is made; or a finer one is asked for.
    Relax,
    /// Details are fitted.
    Fit,
    /// The result is measured.
    Audit,
}

impl fmt::Display for TrimStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Locate => "locate",
            Self::Remesh => "remesh",
            Self::Relax => "relax",
            Self::Fit => "fit",
            Self::Audit => "audit",
        })
    }
}

/// What a work quantum of a trim's own stages led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrimQuantum {
    /// The stage has more to do.
    More,
    /// The stage is done; this one is next.
    Next(TrimStage),
    /// The trim changes more of its source than was thought, and may touch others.
    Widen,
    /// The trim is made.
    Finished,
}

/// Whether a trim runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrimState {
    /// It is at this stage; its marker says the same.
    Running(TrimStage),
    /// Its curves are located, and it waits for the other trims of its source to be, too.
    Located,
    /// It touches others, and is made together with them: this one carries the work.
    With(Entity),
    /// It is done, and its report is there.
    Finished,
    /// It failed, and its failure is there.
    Failed,
}

impl TrimState {
    /// Is the trim being worked on?
    pub const fn is_running(self) -> bool {
        !matches!(self, Self::Finished | Self::Failed)
    }
}

/// A directed curve as a trim reads it: the curve, the revision that it had, and its heading.
pub type CutInput = (Arc<dyn Curve>, u64, Heading);

/// All that a trim reads, as it was when it began.
#[derive(Clone, Debug)]
pub struct TrimInputs {
    /// The source.
    pub source: Entity,
    /// The revision of its snapshot; `None` while it has none.
    pub revision: Option<u64>,
    /// The curves; `None` where the entity named has no curve.
    pub cuts: Vec<Option<CutInput>>,
    /// Where they are said to run.
    pub given: PreImages,
    /// How the trim is made.
    pub options: TrimOptions,
    /// The trim's tolerance, if it has one.
    pub tolerance: Option<Tolerance>,
    /// What may be spent.
    pub budgets: Budgets,
}

impl PartialEq for TrimInputs {
    /// Curves are the same when they are one and the same object, of one revision; numbers as
    /// [`same_number`](crate::identity::same_number) says.
    fn eq(&self, other: &Self) -> bool {
        let same = |a: &Option<CutInput>, b: &Option<CutInput>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(&a.0, &b.0) && (a.1, a.2) == (b.1, b.2),
            (None, None) => true,
            _ => false,
        };
        let rest = |inputs: &Self| (inputs.source, inputs.revision, inputs.budgets);
        rest(self) == rest(other)
            && Tolerance::same_option(self.tolerance, other.tolerance)
            && self.options.same_as(&other.options)
            && self.given.same_as(&other.given)
            && self.cuts.len() == other.cuts.len()
            && self.cuts.iter().zip(&other.cuts).all(|(a, b)| same(a, b))
    }
}

/// Where a trim stands. Written by the engine; remove it to have the trim made again.
#[derive(Component, Clone, Debug)]
pub struct TrimJob {
    /// Whether it runs.
    pub state: TrimState,
    /// What it read when it began.
    pub inputs: TrimInputs,
    /// What the stage that ran in this pass has to say. The system of a stage sets it, once a pass,
    /// on each trim that bears the stage's marker and has its turn; the end of the pass takes it.
    pub step: Option<Result<TrimQuantum, TrimFault>>,
    /// Which of the trims made together a failed [`Self::step`] is about, if that can be told.
    pub blamed: Option<Entity>,
    /// Where it is about curves of two trims, the older of them.
    pub with: Option<Entity>,
    /// The trims that it is made together with, itself included, in their order; none before it is
    /// known which they are. The first carries the work.
    pub together: Vec<Entity>,
    /// How many work quanta it has taken, those of the fit included.
    pub quanta: u64,
}

impl TrimJob {
    /// A trim that begins with these inputs.
    pub const fn new(state: TrimState, inputs: TrimInputs) -> Self {
        Self { state, inputs, step: None, blamed: None, with: None, together: Vec::new(), quanta: 0 }
    }

    /// Does another trim, made together with this one, carry the work?
    pub fn is_led_by(&self, trim: Entity) -> bool {
        self.together.first().is_some_and(|&lead| lead != trim)
    }

    /// Is it being worked on?
    pub const fn is_running(&self) -> bool {
        self.state.is_running()
    }
}
