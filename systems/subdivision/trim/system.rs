//! The systems of the stages that are a trim's own.

use bevy_ecs::prelude::*;
use selvedge_components::guard::caught;
use selvedge_components::trim::{AtAudit, AtLocate, AtRelax, AtRemesh, TrimFault, TrimJob, TrimQuantum, TrimStage};

use super::{Blamed, LocateWork, TrimWork};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::parallel::for_each;
use crate::subdivision::fit::FitWork;
use crate::subdivision::turns::Turns;

/// Finds where the curves of trims run on their sources.
pub fn locate_trims(
    mut trims: Query<(Entity, &mut TrimJob, &mut LocateWork), With<AtLocate>>,
    turns: Option<Res<Turns>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let trims = trims.iter_mut().filter(|trim| Turns::is_of(turns.as_deref(), trim.0));
    let mut trims: Vec<_> = trims.map(|(_, job, work)| (job.into_inner(), work.into_inner())).collect();
    run.counted.items = trims.len() as u64;
    for_each(trims.iter_mut().collect(), |(job, work)| {
        let step = caught(|| work.advance());
        job.quanta += 1;
        job.step = Some(step.unwrap_or_else(|message| Err(TrimFault::Panicked { stage: TrimStage::Locate, message })));
    });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.locate += run.finish();
    }
}

/// Works the curves of trims into the cages of their sources.
pub fn remesh_trims(
    mut trims: Query<(Entity, &mut TrimJob, &mut TrimWork), With<AtRemesh>>,
    turns: Option<Res<Turns>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let trims = trims.iter_mut().filter(|trim| Turns::is_of(turns.as_deref(), trim.0));
    let mut trims: Vec<_> = trims.map(|(_, job, work)| (job.into_inner(), work.into_inner())).collect();
    run.counted.items = trims.len() as u64;
    for_each(trims.iter_mut().collect(), |(job, work)| {
        let step = caught(|| work.remesh());
        set_step(job, work, TrimStage::Remesh, step);
    });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.remesh += run.finish();
    }
}

/// Lets new vertices settle along the curves of trims, and begins to fit the new cages.
pub fn relax_trims(
    mut trims: Query<(Entity, &mut TrimJob, &mut TrimWork), With<AtRelax>>,
    turns: Option<Res<Turns>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let trims = trims.iter_mut().filter(|trim| Turns::is_of(turns.as_deref(), trim.0));
    let mut trims: Vec<_> = trims.map(|(_, job, work)| (job.into_inner(), work.into_inner())).collect();
    run.counted.items = trims.len() as u64;
    for_each(trims.iter_mut().collect(), |(job, work)| {
        let budgets = job.inputs.budgets;
        let step = caught(|| work.relax(&budgets));
        set_step(job, work, TrimStage::Relax, step);
    });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.relax += run.finish();
    }
}

/// Measures trims whose fit is done.
pub fn audit_trims(
    mut trims: Query<(Entity, &mut TrimJob, &mut TrimWork, &FitWork), With<AtAudit>>,
    turns: Option<Res<Turns>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let trims = trims.iter_mut().filter(|trim| Turns::is_of(turns.as_deref(), trim.0));
    let mut trims: Vec<_> = trims.map(|(_, job, work, fit)| (job.into_inner(), work.into_inner(), fit)).collect();
    run.counted.items = trims.len() as u64;
    for_each(trims.iter_mut().collect(), |(job, work, fit)| {
        let step = caught(|| work.audit(fit));
        set_step(job, work, TrimStage::Audit, step);
    });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.audit += run.finish();
    }
}

/// Notes what a quantum of trims made together has led to, and which of them is to blame.
fn set_step(job: &mut TrimJob, work: &TrimWork, stage: TrimStage, step: Result<Result<TrimQuantum, Blamed>, String>) {
    job.quanta += 1;
    let step = step.unwrap_or_else(|message| Err(work.newest(TrimFault::Panicked { stage, message })));
    job.step = Some(step.map_err(|Blamed { trim, with, why }| {
        job.blamed = job.together.get(trim).copied();
        job.with = with.and_then(|with| job.together.get(with).copied());
        why
    }));
}
