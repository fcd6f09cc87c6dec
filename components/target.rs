//! What a surface is fitted to: anything that knows its closest point.

use core::fmt;
use core::sync::atomic::{AtomicU64, Ordering};
use std::sync::Arc;

use glam::DVec3;
use thiserror::Error;

use crate::budget::{Budget, BudgetExceeded, Budgets};
use crate::evaluate::SurfacePoint;
use crate::guard::{CallError, caught, guarded};

/// A point of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The point, in model units.
    pub position: DVec3,
    /// Where it lies on the target, if the target has addresses.
    pub at: Option<SurfacePoint>,
}

/// Why a target gave no point.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TargetError {
    /// The target's answer was NaN or infinite.
    #[error("the target has no finite point closest to {to}: it answered {answer}")]
    NotFinite {
        /// What was asked for.
        to: DVec3,
        /// What came back.
        answer: DVec3,
    },
    /// User code panicked.
    #[error("the target panicked at {to}: {message}")]
    Panicked {
        /// What was asked for.
        to: DVec3,
        /// What the panic said.
        message: String,
    },
    /// The target was asked more often than allowed.
    #[error(transparent)]
    Budget(#[from] BudgetExceeded),
}

/// A surface that is fitted to, and measured against.
///
/// An implementation must be a pure function of what it is asked (the same bits for the same
/// question, always), or raise [`Target::revision`] when it changes.
pub trait Target: fmt::Debug + Send + Sync {
    /// The closest point to `to`; `hint` is where an earlier, nearby question was answered, and
    /// may limit the search.
    ///
    /// # Errors
    /// When there is no finite answer.
    fn closest(&self, to: DVec3, hint: Option<SurfacePoint>) -> Result<Foot, TargetError>;

    /// Rises whenever the target has become another one.
    fn revision(&self) -> u64 {
        0
    }
}

/// A projection given by a closure: an implicit surface, say, or one that is not the engine's own.
pub struct Projection<F>(pub F);

impl<F> fmt::Debug for Projection<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Projection")
    }
}

impl<F: Fn(DVec3) -> DVec3 + Send + Sync> Target for Projection<F> {
    fn closest(&self, to: DVec3, _: Option<SurfacePoint>) -> Result<Foot, TargetError> {
        match guarded(|| (self.0)(to)) {
            Ok(position) => Ok(Foot { position, at: None }),
            Err(CallError::NotFinite { value }) => Err(TargetError::NotFinite { to, answer: value }),
            Err(CallError::Panicked { message }) => Err(TargetError::Panicked { to, message }),
        }
    }
}

/// Another target, kept from doing harm: its panics are errors, its points are finite, and it is
/// asked no more often than a budget allows.
#[derive(Debug)]
pub struct Guarded {
    target: Arc<dyn Target>,
    budgets: Budgets,
    calls: AtomicU64,
}

impl Guarded {
    /// Guards `target` for one job, which may ask it [`Budgets::curve_evaluations`] times.
    pub const fn new(target: Arc<dyn Target>, budgets: Budgets) -> Self {
        Self { target, budgets, calls: AtomicU64::new(0) }
    }
}

impl Target for Guarded {
    fn closest(&self, to: DVec3, hint: Option<SurfacePoint>) -> Result<Foot, TargetError> {
        // Which of the questions of one quantum goes over the limit depends on the threads; that one
        // does, and so what the quantum ends with, does not. Nothing else is ordered by the count.
        let calls = self.calls.fetch_add(1, Ordering::Relaxed).saturating_add(1);
        if self.budgets.check(Budget::CurveEvaluations, calls).is_err() {
            let limit = self.budgets.curve_evaluations;
            let needed = limit.saturating_add(1);
            return Err(BudgetExceeded { budget: Budget::CurveEvaluations, needed, limit }.into());
        }
        let foot =
            caught(|| self.target.closest(to, hint)).map_err(|message| TargetError::Panicked { to, message })??;
        let answer = foot.position;
        if answer.is_finite() { Ok(foot) } else { Err(TargetError::NotFinite { to, answer }) }
    }

    fn revision(&self) -> u64 {
        self.target.revision()
    }
}
