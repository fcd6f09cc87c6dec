//! What becomes of a job at the end of a pass.

use selvedge_components::budget::{Budget, BudgetExceeded};
use selvedge_components::error::FitFault;
use selvedge_components::job::FitJob;
use selvedge_components::subdivision::fit::{Outcome, Quantum, Stage};

/// What becomes of a job at the end of a pass.
#[derive(Clone, Debug, PartialEq)]
pub enum Move {
    /// It stays at its stage, or took no step in this pass.
    Stay,
    /// It goes to this stage.
    GoTo(Stage),
    /// It is done; its result becomes the surface's.
    Finish(Outcome),
    /// It failed.
    Fail(FitFault),
}

/// Takes the step that `job` made in this pass. `outcome` is what its work says about the end.
pub fn next_move(job: &mut FitJob, outcome: Option<Outcome>) -> Move {
    let Some(step) = job.step.take() else { return Move::Stay };
    let over = |over: BudgetExceeded| Move::Fail(over.into());
    match step {
        Err(why) => Move::Fail(why),
        // A finished fit always says how.
        Ok(Quantum::Finished) => match outcome.unwrap_or(Outcome::Within) {
            Outcome::Within => Move::Finish(Outcome::Within),
            outcome => Move::Fail(FitFault::NotReached { outcome }),
        },
        Ok(going) => match job.inputs.budgets.check(Budget::Quanta, job.quanta + 1) {
            Err(exceeded) => over(exceeded),
            Ok(()) => match going {
                Quantum::Next(stage) => Move::GoTo(stage),
                _ => Move::Stay,
            },
        },
    }
}
