//! Which jobs begin, begin again, wait or are refused.

use bevy_ecs::entity::Entity;
use selvedge_components::budget::Budget;
use selvedge_components::error::FitFault;
use selvedge_components::job::{FitInputs, FitJob, JobState};

/// What a job's surface is like now.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceNow {
    /// It has a snapshot of this revision.
    Sound(u64),
    /// It is refused, for so many faults.
    Failed(usize),
    /// It was not gathered yet.
    Ungathered,
    /// The entity is no surface.
    Missing,
}

/// Has the host asked to take the job back?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// It may run.
    Run,
    /// It is to be taken back.
    Cancel,
}

/// What is to be done about a job before the stages run.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// Nothing: it goes on, or is over.
    Keep,
    /// It begins, or begins again.
    Start,
    /// It cannot begin yet.
    Wait,
    /// It cannot be done.
    Refuse(FitFault),
    /// What it did is taken back.
    TakeBack,
}

/// Decides about one job: `job` is where it stands, if it was ever begun, and `now` what it would
/// read if it began now.
pub fn verdict(wish: Wish, job: Option<&FitJob>, now: &FitInputs, surface: SurfaceNow) -> Verdict {
    if wish == Wish::Cancel {
        return match job.map(|job| job.state) {
            // The result of a finished fit is the surface's own: there is nothing to take back.
            None | Some(JobState::Finished) => Verdict::Keep,
            Some(_) => Verdict::TakeBack,
        };
    }
    let current = job.is_some_and(|job| {
        // Edits of the surface after a fit are meant, and do not undo it.
        let surface = job.state == JobState::Finished || job.inputs.revision == now.revision;
        surface && job.inputs.same_order(now)
    });
    if current {
        return Verdict::Keep;
    }
    match refusal(now, surface) {
        Some(why) => Verdict::Refuse(why),
        None if surface == SurfaceNow::Ungathered => Verdict::Wait,
        None => Verdict::Start,
    }
}

fn refusal(now: &FitInputs, surface: SurfaceNow) -> Option<FitFault> {
    if now.target.is_none() {
        return Some(FitFault::NoTarget);
    }
    if let Err(message) = &now.target_revision {
        return Some(FitFault::TargetRevision { message: message.clone() });
    }
    if let Err(over) = now.budgets.check(Budget::Levels, u64::from(now.options.last_level)) {
        return Some(FitFault::Budget(over));
    }
    match surface {
        SurfaceNow::Missing => Some(FitFault::NoSurface { surface: now.surface }),
        SurfaceNow::Failed(faults) => Some(FitFault::SurfaceFailed { surface: now.surface, faults }),
        SurfaceNow::Sound(_) | SurfaceNow::Ungathered => None,
    }
}

/// Of the jobs that would begin, those that may: one at a time on each surface, first come first
/// served. `wanting` are `(job, surface)` in the order of their serials, `busy` the surfaces that
/// have a running job.
pub fn first_on_each_surface(wanting: &[(Entity, Entity)], mut busy: Vec<Entity>) -> Vec<Entity> {
    let mut begin = Vec::new();
    for &(job, surface) in wanting {
        if !busy.contains(&surface) {
            busy.push(surface);
            begin.push(job);
        }
    }
    begin
}
