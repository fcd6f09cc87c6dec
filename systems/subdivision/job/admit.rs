//! Which jobs begin, begin again, wait or are refused.

use std::sync::Arc;

use bevy_ecs::entity::{Entity, EntityHashSet};
use selvedge_components::budget::{Budget, Budgets};
use selvedge_components::error::FitFault;
use selvedge_components::job::{FitInputs, FitJob, JobState};
use selvedge_components::subdivision::fit::FitOptions;
use selvedge_components::target::Target;
use selvedge_components::tolerance::Tolerance;

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

/// What a job asks for, and what it would read if it began now.
#[derive(Clone, Debug)]
pub struct Order<'a> {
    /// The surface to be fitted.
    pub surface: Entity,
    /// What that is like.
    pub now: SurfaceNow,
    /// The target, if there is one.
    pub target: Option<&'a Arc<dyn Target>>,
    /// Its revision; what it said where it panicked when asked.
    pub target_revision: Result<u64, String>,
    /// How the fit is made.
    pub options: &'a FitOptions,
    /// The job's tolerance, if it has one.
    pub tolerance: Option<Tolerance>,
    /// What may be spent.
    pub budgets: Budgets,
}

impl Order<'_> {
    /// Is this what `inputs` were made of, whatever has become of the surface?
    fn is_that_of(&self, inputs: &FitInputs) -> bool {
        let same_target = match (self.target, &inputs.target) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b) && self.target_revision == inputs.target_revision,
            (None, None) => true,
            _ => false,
        };
        same_target
            && (inputs.surface, inputs.budgets) == (self.surface, self.budgets)
            && inputs.options.same_as(self.options)
            && Tolerance::same_option(inputs.tolerance, self.tolerance)
    }

    fn revision(&self) -> Option<u64> {
        if let SurfaceNow::Sound(revision) = self.now { Some(revision) } else { None }
    }

    /// The order as a job keeps it.
    pub fn inputs(&self) -> FitInputs {
        FitInputs {
            surface: self.surface,
            revision: self.revision(),
            target: self.target.map(Arc::clone),
            target_revision: self.target_revision.clone(),
            options: self.options.clone(),
            tolerance: self.tolerance,
            budgets: self.budgets,
        }
    }
}

/// Decides about one job: `job` is where it stands, if it was ever begun, and `order` what it asks
/// for now.
pub fn verdict(wish: Wish, job: Option<&FitJob>, order: &Order<'_>) -> Verdict {
    if wish == Wish::Cancel {
        return match job.map(|job| job.state) {
            // The result of a finished fit is the surface's own: there is nothing to take back.
            None | Some(JobState::Finished) => Verdict::Keep,
            Some(_) => Verdict::TakeBack,
        };
    }
    let current = job.is_some_and(|job| {
        // Edits of the surface after a fit are meant, and do not undo it.
        let surface = job.state == JobState::Finished || job.inputs.revision == order.revision();
        surface && order.is_that_of(&job.inputs)
    });
    if current {
        return Verdict::Keep;
    }
    match refusal(order) {
        Some(why) => Verdict::Refuse(why),
        None if order.now == SurfaceNow::Ungathered => Verdict::Wait,
        None => Verdict::Start,
    }
}

fn refusal(order: &Order<'_>) -> Option<FitFault> {
    if order.target.is_none() {
        return Some(FitFault::NoTarget);
    }
    if let Err(message) = &order.target_revision {
        return Some(FitFault::TargetRevision { message: message.clone() });
    }
    if let Err(over) = order.budgets.check(Budget::Levels, u64::from(order.options.last_level)) {
        return Some(FitFault::Budget(over));
    }
    match order.now {
        SurfaceNow::Missing => Some(FitFault::NoSurface { surface: order.surface }),
        SurfaceNow::Failed(faults) => Some(FitFault::SurfaceFailed { surface: order.surface, faults }),
        SurfaceNow::Sound(_) | SurfaceNow::Ungathered => None,
    }
}

/// Of the jobs that would begin, those that may: one at a time on each surface, first come first
/// served. `wanting` are `(job, surface)` in the order of their serials, `busy` the surfaces that
/// have a running job.
pub fn first_on_each_surface(wanting: &[(Entity, Entity)], mut busy: EntityHashSet) -> EntityHashSet {
    wanting.iter().filter(|&&(_, surface)| busy.insert(surface)).map(|&(job, _)| job).collect()
}

#[cfg(test)]
mod tests {
    use selvedge_components::subdivision::fit::Stage;
    use selvedge_components::target::Projection;

    use super::*;

    fn entity(n: u32) -> Entity {
        Entity::from_raw_u32(n).expect("a small number is an entity")
    }

    /// Of everything that a job reads, each alone makes it begin again, in every state.
    #[test]
    fn each_input_counts() {
        let (target, other): (Arc<dyn Target>, Arc<dyn Target>) =
            (Arc::new(Projection(|p| p)), Arc::new(Projection(|p| p)));
        let (options, deeper) = (FitOptions::default(), FitOptions { last_level: 7, ..FitOptions::default() });
        let order = Order {
            surface: entity(1),
            now: SurfaceNow::Sound(5),
            target: Some(&target),
            target_revision: Ok(3),
            options: &options,
            tolerance: None,
            budgets: Budgets::default(),
        };
        let edited = Order { now: SurfaceNow::Sound(6), ..order.clone() };
        let changed = [
            Order { surface: entity(2), ..order.clone() },
            Order { target: Some(&other), ..order.clone() },
            Order { target_revision: Ok(4), ..order.clone() },
            Order { options: &deeper, ..order.clone() },
            Order { tolerance: Some(Tolerance::total(1.0)), ..order.clone() },
            Order { budgets: Budgets { details: 1, ..Budgets::default() }, ..order.clone() },
        ];
        for state in [JobState::Running(Stage::Modify), JobState::Finished, JobState::Failed] {
            let job = FitJob::new(state, order.inputs());
            assert_eq!(verdict(Wish::Run, Some(&job), &order), Verdict::Keep);
            for other in &changed {
                assert_eq!(verdict(Wish::Run, Some(&job), other), Verdict::Start, "{other:?}");
            }
            let meant = state == JobState::Finished;
            let expected = if meant { Verdict::Keep } else { Verdict::Start };
            assert_eq!(verdict(Wish::Run, Some(&job), &edited), expected);
            let expected = if meant { Verdict::Keep } else { Verdict::TakeBack };
            assert_eq!(verdict(Wish::Cancel, Some(&job), &order), expected);
        }
        let waits = Order { now: SurfaceNow::Ungathered, ..order };
        assert_eq!(verdict(Wish::Run, None, &waits), Verdict::Wait);
    }

    #[test]
    fn surfaces_are_served_one_job_at_a_time_in_order() {
        let wanting = [(10, 1), (11, 2), (12, 1), (13, 3)].map(|(job, surface)| (entity(job), entity(surface)));
        let first = first_on_each_surface(&wanting, [entity(3)].into_iter().collect());
        assert_eq!(first, [entity(10), entity(11)].into_iter().collect());
    }
}
