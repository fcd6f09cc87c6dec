//! How much may be spent before a job gives up.

use core::fmt;

use bevy_ecs::prelude::Resource;
use thiserror::Error;

/// Limits on what one job, or one surface, may use. Passing one is [`BudgetExceeded`], found before
/// the work is done wherever its size is known beforehand.
///
/// Insert another value to change them; what they had stopped is tried again.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budgets {
    /// Levels of subdivision that a fit may go through.
    pub levels: u64,
    /// Detail coefficients of one surface.
    pub details: u64,
    /// Nodes of level-of-detail trees.
    pub nodes: u64,
    /// Triangles of one surface.
    pub triangles: u64,
    /// Bytes of the dense data of one job.
    pub bytes: u64,
    /// Calls of user code, curves and targets, by one job.
    pub curve_evaluations: u64,
    /// Work quanta of one job: what ends a stage that never does.
    pub quanta: u64,
}

impl Default for Budgets {
    /// What a desktop takes without swapping. Levels: at a vertex of valence 12 sixteen levels
    /// still shrink the error by 2.9 each, and past twenty f64 has no digits left. Quanta: at a
    /// millisecond each, a quarter of an hour.
    fn default() -> Self {
        Self {
            levels: 20,
            details: 10_000_000,
            nodes: 10_000_000,
            triangles: 100_000_000,
            bytes: 8 << 30,
            curve_evaluations: 10_000_000_000,
            quanta: 1_000_000,
        }
    }
}

/// How much of the work at hand is done in one pass: what keeps a pass as short among a thousand jobs as among a few.
///
/// The jobs beyond it wait for later passes, in turns. What they come to does not depend on it, to the bit, nor
/// does this on clock or threads; insert another value at any time. Where passes are not frames of anything, and
/// only the end counts, `u64::MAX` saves some passes.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassAllowance {
    /// Work quanta of all jobs together, some of about a millisecond each. One at each stage at which there is
    /// a job is done in any case, so 0 is the least that still comes to an end.
    pub quanta: u64,
}

impl Default for PassAllowance {
    /// What a frame has room for, and enough to keep some threads busy.
    fn default() -> Self {
        Self { quanta: 16 }
    }
}

/// One of the [`Budgets`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Budget {
    /// [`Budgets::levels`].
    Levels,
    /// [`Budgets::details`].
    Details,
    /// [`Budgets::nodes`].
    Nodes,
    /// [`Budgets::triangles`].
    Triangles,
    /// [`Budgets::bytes`].
    Bytes,
    /// [`Budgets::curve_evaluations`].
    CurveEvaluations,
    /// [`Budgets::quanta`].
    Quanta,
}

impl fmt::Display for Budget {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Levels => "levels",
            Self::Details => "detail coefficients",
            Self::Nodes => "tree nodes",
            Self::Triangles => "triangles",
            Self::Bytes => "bytes",
            Self::CurveEvaluations => "calls of user code",
            Self::Quanta => "work quanta",
        })
    }
}

/// More was needed than a budget allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("over budget: {needed} {budget} needed, {limit} allowed")]
pub struct BudgetExceeded {
    /// Which budget.
    pub budget: Budget,
    /// How much was needed, as far as is known.
    pub needed: u64,
    /// How much was allowed.
    pub limit: u64,
}

impl Budgets {
    /// The limit of one budget.
    pub const fn limit(&self, budget: Budget) -> u64 {
        match budget {
            Budget::Levels => self.levels,
            Budget::Details => self.details,
            Budget::Nodes => self.nodes,
            Budget::Triangles => self.triangles,
            Budget::Bytes => self.bytes,
            Budget::CurveEvaluations => self.curve_evaluations,
            Budget::Quanta => self.quanta,
        }
    }

    /// Is `needed` within `budget`?
    ///
    /// # Errors
    /// [`BudgetExceeded`] when it is above the limit.
    pub const fn check(&self, budget: Budget, needed: u64) -> Result<(), BudgetExceeded> {
        let limit = self.limit(budget);
        if needed > limit { Err(BudgetExceeded { budget, needed, limit }) } else { Ok(()) }
    }
}
