//! The systems of the stages: each lets the jobs at its stage whose turn it is do one work quantum.

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use glam::DVec3;
use selvedge_components::error::FitFault;
use selvedge_components::guard::caught;
use selvedge_components::job::{AtCorrespond, AtModify, AtRefine, FitJob};
use selvedge_components::subdivision::{Address, Detail, DetailLevel, DetailOf};

use super::fit::{FitError, FitWork, Quantum, Stage};
use super::turns::Turns;
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::gather::{OwnerRows, runs};
use crate::parallel::for_each;

type Job = (Entity, &'static mut FitJob, &'static mut FitWork);

/// Pairs points of surfaces with points of their targets.
pub fn correspond_fits(
    mut jobs: Query<Job, With<AtCorrespond>>,
    turns: Option<Res<Turns>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let jobs: Vec<_> = jobs.iter_mut().filter(|job| Turns::is_of(turns.as_deref(), job.0)).collect();
    run.counted.items = jobs.len() as u64;
    quantum(jobs, Stage::Correspond, FitWork::correspond);
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.correspond += run.finish();
    }
}

/// Works out details, and writes those of every job that leaves the stage over its entities.
pub fn modify_fits(
    mut jobs: Query<Job, With<AtModify>>,
    mut details: Query<(&mut Detail, &DetailLevel, &Address, &DetailOf)>,
    turns: Option<Res<Turns>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let jobs: Vec<_> = jobs.iter_mut().filter(|job| Turns::is_of(turns.as_deref(), job.0)).collect();
    run.counted.items = jobs.len() as u64;
    let left: Vec<_> = quantum(jobs, Stage::Modify, FitWork::modify);
    if !left.is_empty() {
        let (tables, written) = write_details(&left, &mut details);
        run.counted.tables += tables;
        run.counted.written += written;
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.modify += run.finish();
    }
}

/// Measures what is left; where a job opens a level, spawns the details that it may move, and takes
/// away those of the level before that have stayed zero.
pub fn refine_fits(
    mut commands: Commands,
    mut jobs: Query<Job, With<AtRefine>>,
    details: Query<(Entity, &Detail, &DetailOf)>,
    turns: Option<Res<Turns>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let jobs: Vec<_> = jobs.iter_mut().filter(|job| Turns::is_of(turns.as_deref(), job.0)).collect();
    run.counted.items = jobs.len() as u64;
    let left = quantum(jobs, Stage::Refine, FitWork::refine);
    let owners: EntityHashSet = left.iter().map(|&(job, _)| job).collect();
    if !owners.is_empty() {
        let zero = details.iter().filter(|(_, detail, of)| detail.0 == DVec3::ZERO && owners.contains(&of.0));
        for (detail, ..) in zero {
            commands.entity(detail).try_despawn();
            run.counted.written += 1;
        }
    }
    for (job, work) in left {
        let active = work.active().to_vec();
        run.counted.written += active.len() as u64;
        commands.spawn_batch(
            active
                .into_iter()
                .map(move |(level, address)| (Detail::default(), DetailLevel(level), address, DetailOf(job))),
        );
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.refine += run.finish();
    }
}

/// Lets each job do one quantum, all at once. Returns those that go on to another stage.
fn quantum<'w>(
    jobs: Vec<(Entity, Mut<'w, FitJob>, Mut<'w, FitWork>)>,
    stage: Stage,
    work: impl Fn(&mut FitWork) -> Result<Quantum, FitError> + Sync,
) -> Vec<(Entity, &'w FitWork)> {
    let mut jobs: Vec<_> =
        jobs.into_iter().map(|(entity, job, fit)| (entity, job.into_inner(), fit.into_inner())).collect();
    for_each(jobs.iter_mut().collect(), |(_, job, fit)| {
        let step = caught(|| work(fit));
        job.quanta += 1;
        job.level = fit.level();
        job.error = fit.ladder().last().or(fit.initial()).map(|rung| rung.max);
        job.step = Some(match step {
            Ok(step) => step.map_err(FitFault::Fit),
            Err(message) => Err(FitFault::Panicked { stage, message }),
        });
    });
    let left = jobs.into_iter().filter(|(_, job, _)| matches!(job.step, Some(Ok(Quantum::Next(_)))));
    left.map(|(entity, _, fit)| (entity, &*fit)).collect()
}

/// Writes the details of the level in work of each of `jobs` over its entities, slice by slice.
/// Returns how many tables were gone through and how many details were written.
fn write_details(
    jobs: &[(Entity, &FitWork)],
    details: &mut Query<(&mut Detail, &DetailLevel, &Address, &DetailOf)>,
) -> (u64, u64) {
    let (mut tables, mut written) = (0, 0);
    let jobs: EntityHashMap<&FitWork> = jobs.iter().copied().collect();
    let slices = details.contiguous_iter_mut().expect("every component asked for is stored in tables");
    for (mut values, levels, addresses, owners) in slices {
        tables += 1;
        for (owner, run) in runs(OwnerRows(owners), 0..owners.len()) {
            let Some(work) = jobs.get(&owner) else { continue };
            // Only this stretch is marked as changed: the rest of the table is not ours to touch.
            let mut stretch = values.reborrow().slice(run.start as u32..run.end as u32);
            for (value, row) in stretch.iter_mut().zip(run).filter(|(_, row)| levels[*row].0 == work.level()) {
                *value = Detail(work.details().at(levels[row].0, addresses[row]));
                written += 1;
            }
        }
    }
    (tables, written)
}
