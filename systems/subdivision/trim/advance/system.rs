//! The system that moves and ends trims.

use std::sync::Arc;

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use selvedge_components::identity::Serials;
use selvedge_components::job::{AtCorrespond, AtModify, AtRefine, FitInputs, FitJob, JobState};
use selvedge_components::subdivision::fit::FitOptions;
use selvedge_components::trim::{
    AtAudit, AtLocate, AtRelax, AtRemesh, OtherReport, Trim, TrimFailed, TrimInputs, TrimJob, TrimReport, TrimStage,
    TrimState,
};

use super::{Step, next_step};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::subdivision::fit::FitWork;
use crate::subdivision::job::{Coefficient, deliver, discard, mark};
use crate::subdivision::trim::compose::Solved;
use crate::subdivision::trim::traces::{FailedTraces, WorkTraces};
use crate::subdivision::trim::{Blamed, LocateWork, TrimWork};

type Made = (
    Entity,
    &'static mut TrimJob,
    Option<&'static mut TrimWork>,
    Option<&'static mut FitJob>,
    Option<&'static FitWork>,
    Option<&'static mut LocateWork>,
);

/// How the work of trims made together has ended.
enum End {
    /// They are done, and so is the other side of each of which that is wanted.
    Finished(Option<Box<TrimReport>>, Vec<Option<OtherReport>>),
    /// They change more than was thought.
    Widen,
    /// Their fit needs more faces.
    FitMore,
    /// This one has failed.
    Failed(Entity, TrimFailed),
}

/// Writes the transitions of all trims that took a step, and keeps what those that are done have
/// left.
pub fn advance_trims(
    mut commands: Commands,
    mut trims: Query<Made, With<Trim>>,
    mut details: Query<Coefficient>,
    mut serials: If<ResMut<Serials>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut ends = Vec::new();
    for (entity, mut job, work, fit_job, fit, _) in &mut trims {
        let step = next_step(&mut job, fit_job.map(Mut::into_inner), fit.and_then(FitWork::outcome));
        let Some(step) = step else {
            run.counted.skipped += 1;
            continue;
        };
        run.counted.items += 1;
        run.counted.written += u64::from(step != Step::Stay);
        let step = match step {
            Step::Fail(why) if work.as_ref().is_some_and(|work| work.may_fit_more(&why)) => Step::FitMore,
            step => step,
        };
        match step {
            Step::Stay => {}
            Step::Located => {
                job.state = TrimState::Located;
                commands.entity(entity).try_remove::<AtLocate>();
            }
            Step::GoTo(stage) => {
                job.state = TrimState::Running(stage);
                let mut trim = commands.entity(entity);
                trim.try_remove::<(AtRemesh, AtRelax)>();
                match stage {
                    TrimStage::Relax => trim.try_insert(AtRelax),
                    _ => trim.try_insert(AtRemesh),
                };
            }
            Step::Fit(stage) => mark(&mut commands.entity(entity), stage),
            Step::BeginFit => {
                let fit = work.and_then(|mut work| work.take_fit());
                begin_fit(&mut commands.entity(entity), &mut job, fit);
            }
            Step::Audit => {
                job.state = TrimState::Running(TrimStage::Audit);
                commands.entity(entity).try_remove::<(AtCorrespond, AtModify, AtRefine)>().try_insert(AtAudit);
            }
            Step::Widen => ends.push((job.together.clone(), End::Widen)),
            Step::FitMore => ends.push((job.together.clone(), End::FitMore)),
            Step::Finish => {
                let Some((work, fit)) = work.zip(fit) else { continue };
                deliver(&mut commands, &mut details, entity, entity, fit);
                let solved = solved(&job, &work, serials.0.next_number());
                let others = (0..job.together.len()).map(|trim| work.other_report(trim)).collect();
                ends.push((job.together.clone(), End::Finished(work.report(fit).map(Box::new), others)));
                commands.entity(entity).try_remove::<WorkTraces>();
                if let Some(solved) = solved {
                    commands.entity(entity).try_insert(solved);
                }
            }
            Step::Fail(why) => {
                let ladder = fit.map_or_else(Vec::new, |fit| fit.ladder().to_vec());
                let together = if job.together.is_empty() { vec![entity] } else { job.together.clone() };
                let (nearest, why) = match work {
                    Some(work) => {
                        let Blamed { trim, why, .. } = work.nearest(why);
                        (together.get(trim).copied(), why)
                    }
                    None => (None, why),
                };
                let blamed = job.blamed.take().or(nearest).filter(|trim| together.contains(trim));
                let blamed = blamed.or(together.last().copied()).unwrap_or(entity);
                let with = job.with.take().filter(|with| together.contains(with));
                ends.push((together, End::Failed(blamed, TrimFailed { why, with, ladder })));
            }
        }
    }
    let mut undone = EntityHashSet::default();
    for (together, end) in ends {
        match end {
            End::Finished(report, others) => {
                finish(&mut commands, &mut trims, &together, report.as_deref(), others);
            }
            End::Widen | End::FitMore => {
                for &trim in &together {
                    match trims.get_mut(trim) {
                        Ok((.., Some(mut located))) if matches!(end, End::FitMore) => located.fit_more(&together),
                        Ok((.., Some(mut located))) => located.widen(&together),
                        _ => {}
                    }
                }
                undone.extend(together.iter().copied());
                break_off(&mut commands, &mut trims, &together, None);
            }
            End::Failed(blamed, why) => {
                undone.extend(together.iter().copied());
                break_off(&mut commands, &mut trims, &together, Some(blamed));
                commands.entity(blamed).try_remove::<FailedTraces>().try_insert(why);
            }
        }
    }
    discard(&mut commands, &undone, details.iter().map(|(detail, .., of)| (detail, of.0)));
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.advance += run.finish();
    }
}

/// A trim's new cage becomes a fit like any other.
fn begin_fit(trim: &mut EntityCommands, job: &mut TrimJob, fit: Option<FitWork>) {
    let Some(work) = fit else { return };
    job.state = TrimState::Running(TrimStage::Fit);
    let TrimInputs { source, revision, tolerance, budgets, .. } = job.inputs.clone();
    let inputs = FitInputs {
        surface: source,
        revision,
        target: None,
        target_revision: Ok(0),
        options: FitOptions::default(),
        tolerance,
        budgets,
    };
    let stage = work.stage();
    let fit = FitJob::new(JobState::Running(stage), inputs);
    trim.try_remove::<AtRelax>().try_insert((fit, work));
    mark(trim, stage);
}

fn solved(job: &TrimJob, work: &TrimWork, number: u64) -> Option<Solved> {
    let (remeshed, surface) = (Arc::clone(work.remeshed()?), Arc::clone(work.result()?));
    let solved = |remeshed, surface| Solved {
        together: job.together.clone(),
        number,
        zone: work.zone().map(Arc::clone),
        remeshed,
        surface,
        others: Vec::new(),
    };
    let others = work.others().iter().filter_map(|other| {
        let (remeshed, surface) = (Arc::clone(other.remeshed()?), Arc::clone(other.surface()?));
        Some((*job.together.get(other.trim)?, solved(remeshed, surface)))
    });
    Some(Solved { others: others.collect(), ..solved(remeshed, surface) })
}

/// All trims made together are done.
fn finish(
    commands: &mut Commands,
    trims: &mut Query<Made, With<Trim>>,
    together: &[Entity],
    report: Option<&TrimReport>,
    others: Vec<Option<OtherReport>>,
) {
    for (&trim, other) in together.iter().zip(others) {
        if let Ok((_, mut job, ..)) = trims.get_mut(trim) {
            job.state = TrimState::Finished;
        }
        if let Some(report) = report {
            let report = TrimReport { together: together.to_vec(), other: other.map(Box::new), ..report.clone() };
            commands.entity(trim).try_insert(report);
        }
    }
}

/// Trims made together are to be made again, but for the one that has failed.
fn break_off(
    commands: &mut Commands,
    trims: &mut Query<Made, With<Trim>>,
    together: &[Entity],
    failed: Option<Entity>,
) {
    for &trim in together {
        commands.entity(trim).try_remove::<WorkTraces>();
        let Ok((_, mut job, ..)) = trims.get_mut(trim) else { continue };
        job.together.clear();
        job.state = if Some(trim) == failed { TrimState::Failed } else { TrimState::Located };
    }
}
