//! The system that says whose turn it is.

use bevy_ecs::prelude::*;
use selvedge_components::budget::PassAllowance;
use selvedge_components::identity::Serial;
use selvedge_components::job::{AtCorrespond, AtModify, AtRefine};
use selvedge_components::trim::{AtAudit, AtLocate, AtRelax, AtRemesh};

use super::{Line, STAGES, Turns};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};

type Job = (
    Entity,
    Option<&'static Serial>,
    (Has<AtLocate>, Has<AtRemesh>, Has<AtRelax>, Has<AtCorrespond>, Has<AtModify>, Has<AtRefine>, Has<AtAudit>),
);
type AtWork = Or<(
    With<AtLocate>,
    With<AtRemesh>,
    With<AtRelax>,
    With<AtCorrespond>,
    With<AtModify>,
    With<AtRefine>,
    With<AtAudit>,
)>;

/// Says which jobs take a work quantum in this pass, where there are more than one may do.
pub fn give_turns(
    jobs: Query<Job, AtWork>,
    allowance: Option<Res<PassAllowance>>,
    mut turns: If<ResMut<Turns>>,
    mut line: Local<Line>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let allowed = allowance.map_or_else(PassAllowance::default, |allowance| *allowance);
    let mut jobs: Vec<_> = jobs.iter().collect();
    jobs.sort_unstable_by_key(|job| (job.1, job.0));
    let stage = |(locate, remesh, relax, correspond, modify, refine, audit)| {
        let at = [locate, remesh, relax, correspond, modify, refine, audit];
        at.iter().position(|&here| here).unwrap_or(STAGES - 1)
    };
    let jobs: Vec<_> = jobs.into_iter().map(|(job, _, at)| (job, stage(at))).collect();
    let waiting = line.pass(&jobs, usize::try_from(allowed.quanta).unwrap_or(usize::MAX));
    run.counted.items = jobs.len() as u64;
    run.counted.skipped = waiting.len() as u64;
    turns.0.set_if_neq(Turns { waiting });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.turns += run.finish();
    }
}
