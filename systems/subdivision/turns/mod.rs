//! # Turns: which jobs take a quantum in this pass
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the markers of jobs at work, `Serial`, `PassAllowance` | [`Turns`] | admit | the stages |
//!
//! Why: a work quantum takes about a millisecond, so a pass that lets every job take one is as long as
//! there are jobs. Jobs stand in a line; as many as are allowed take their turn and go to its end. That is fair:
//! new jobs join behind all others, so none waits for more passes than those before it take. What a job comes
//! to does not depend on when its turns are.
//!
//! The first in line at each stage has a turn whatever is allowed: a host may have taken a stage out, and jobs
//! that nothing moves must not keep the others from theirs. So a pass lasts for the allowance and one quantum
//! for each of the [`STAGES`] at most.

mod system;

use bevy_ecs::entity::{Entity, EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::Resource;

pub use system::give_turns;

/// The stages at which a job may stand: locate, remesh, relax, correspond, modify, refine, audit.
pub const STAGES: usize = 7;

/// Which jobs wait in this pass; all others take a work quantum. Written anew in each pass, before the stages.
/// Where a host takes it away every job takes one.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Turns {
    waiting: EntityHashSet,
}

impl Turns {
    /// Does `job` take a quantum in this pass, as these `turns` say, or none?
    pub fn is_of(turns: Option<&Self>, job: Entity) -> bool {
        turns.is_none_or(|turns| !turns.waiting.contains(&job))
    }
}

/// Jobs in the order in which they have their turns, from one pass to the next.
#[derive(Clone, Debug, Default)]
pub struct Line {
    standing: Vec<Entity>,
}

impl Line {
    /// Lets `allowed` jobs take their turns, and at each stage one at least. `jobs` are those at work, each with
    /// its stage, below [`STAGES`]; those that are new join the line in this order. Returns those that wait.
    pub fn pass(&mut self, jobs: &[(Entity, usize)], allowed: usize) -> EntityHashSet {
        if jobs.len() <= allowed {
            // Nobody waits, so nobody is ahead of another.
            self.standing.clear();
            return EntityHashSet::default();
        }
        let stages: EntityHashMap<usize> = jobs.iter().copied().collect();
        self.standing.retain(|job| stages.contains_key(job));
        let known: EntityHashSet = self.standing.iter().copied().collect();
        self.standing.extend(jobs.iter().map(|job| job.0).filter(|job| !known.contains(job)));
        let mut served = [false; STAGES];
        let mut have_turn = Vec::with_capacity(allowed + STAGES);
        let mut place = 0;
        self.standing.retain(|job| {
            let is_first = !core::mem::replace(&mut served[stages[job]], true);
            let has_turn = place < allowed || is_first;
            place += 1;
            if has_turn {
                have_turn.push(*job);
            }
            !has_turn
        });
        let waiting = self.standing.iter().copied().collect();
        self.standing.extend(have_turn);
        waiting
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jobs(range: core::ops::Range<u32>, stage: usize) -> Vec<(Entity, usize)> {
        range.map(|n| (Entity::from_raw_u32(n).expect("not the last number"), stage)).collect()
    }

    fn turns(line: &mut Line, jobs: &[(Entity, usize)], allowed: usize) -> Vec<Entity> {
        let waiting = line.pass(jobs, allowed);
        jobs.iter().map(|job| job.0).filter(|job| !waiting.contains(job)).collect()
    }

    #[test]
    fn where_all_are_allowed_nobody_waits() {
        let all = jobs(0..5, 2);
        for allowed in [5, 6, usize::MAX] {
            assert!(Line::default().pass(&all, allowed).is_empty());
        }
    }

    #[test]
    fn nobody_waits_longer_for_jobs_that_come_after() {
        let mut line = Line::default();
        let old = jobs(0..10, 0);
        let mut all = old.clone();
        let mut seen = Vec::new();
        for pass in 0..4 {
            seen.extend(turns(&mut line, &all, 3));
            // As many more as there are turns.
            all = [jobs(100 + 3 * pass..103 + 3 * pass, 0), all].concat();
        }
        assert!(old.iter().all(|(job, _)| seen.contains(job)), "{seen:?}");
    }

    #[test]
    fn turns_are_as_many_as_allowed_and_one_for_each_stage() {
        for allowed in [0, 1, 3, 8] {
            let mut line = Line::default();
            let all = [jobs(0..20, 0), jobs(20..21, 3), jobs(21..30, 6)].concat();
            for _ in 0..50 {
                let have = turns(&mut line, &all, allowed);
                assert!((allowed.max(3)..=allowed + 3).contains(&have.len()), "{} of {allowed}", have.len());
                for stage in [0, 3, 6] {
                    assert!(have.iter().any(|job| all.contains(&(*job, stage))), "stage {stage} stands still");
                }
            }
        }
    }

    #[test]
    fn jobs_that_are_over_leave_the_line() {
        let mut line = Line::default();
        line.pass(&jobs(0..9, 1), 2);
        assert_eq!(line.pass(&jobs(5..8, 1), 2).len(), 1);
        assert_eq!(line.standing.len(), 3);
        line.pass(&[], 2);
        assert!(line.standing.is_empty());
    }
}
