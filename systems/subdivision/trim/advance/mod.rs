//! What the step of a trim leads to.

mod system;

use selvedge_components::budget::Budget;
use selvedge_components::error::FitFault;
use selvedge_components::job::{FitJob, JobState};
use selvedge_components::subdivision::fit::{Outcome, Stage};
use selvedge_components::trim::{TrimFault, TrimJob, TrimQuantum, TrimStage, TrimState};

pub use system::advance_trims;

use crate::subdivision::job::{Move, next_move};

/// What a trim's step leads to.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Stay,
    Located,
    GoTo(TrimStage),
    BeginFit,
    Fit(Stage),
    Audit,
    Widen,
    FitMore,
    Finish,
    Fail(TrimFault),
}

/// Takes the step that a trim made in this pass, in a stage of its own or in its fit, which says how it
/// has ended once it has.
fn next_step(job: &mut TrimJob, fit: Option<&mut FitJob>, outcome: Option<Outcome>) -> Option<Step> {
    if let Some(step) = job.step.take() {
        return Some(match step {
            Err(why) => Step::Fail(why),
            Ok(TrimQuantum::More) => match job.inputs.budgets.check(Budget::Quanta, job.quanta + 1) {
                Ok(()) => Step::Stay,
                Err(over) => Step::Fail(over.into()),
            },
            Ok(TrimQuantum::Finished) => Step::Finish,
            Ok(TrimQuantum::Widen) => Step::Widen,
            Ok(TrimQuantum::Next(TrimStage::Fit)) => Step::BeginFit,
            Ok(TrimQuantum::Next(TrimStage::Audit)) => Step::Audit,
            // Once its curves are located, a trim waits for the others of its source.
            Ok(TrimQuantum::Next(TrimStage::Remesh)) if job.state == TrimState::Running(TrimStage::Locate) => {
                Step::Located
            }
            Ok(TrimQuantum::Next(stage)) => Step::GoTo(stage),
        });
    }
    let fit = fit?;
    fit.step.as_ref()?;
    job.quanta += 1;
    Some(match next_move(fit, outcome) {
        Move::Stay => Step::Stay,
        Move::GoTo(stage) => {
            fit.state = JobState::Running(stage);
            Step::Fit(stage)
        }
        Move::Finish(_) => Step::Audit,
        Move::Fail(why) => Step::Fail(of_fit(why)),
    })
}

fn of_fit(why: FitFault) -> TrimFault {
    match why {
        FitFault::Fit(why) => why.into(),
        FitFault::Budget(over) => over.into(),
        FitFault::NotReached { outcome } => TrimFault::NotReached { outcome },
        FitFault::Panicked { message, .. } => TrimFault::Panicked { stage: TrimStage::Fit, message },
        other => TrimFault::Panicked { stage: TrimStage::Fit, message: other.to_string() },
    }
}
