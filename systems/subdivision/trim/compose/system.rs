//! The system that puts results together.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use selvedge_components::guard::caught;
use selvedge_components::identity::Serials;
use selvedge_components::subdivision::remesh::RemeshError;
use selvedge_components::subdivision::{Border, DetailOf, LoopSurface, Snapshot};
use selvedge_components::trim::{ResultOf, Stale, Trim, TrimFailed, TrimJob, TrimState, TrimmedTo};

use super::{ComposedOf, Misfit, Solved, compose};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::subdivision::job::discard;
use crate::subdivision::trim::Ground;
use crate::subdivision::trim::traces::{FailedTraces, WorkTraces};

/// Puts together what is left of each source, once none of its trims is at work any more.
pub fn compose_results(
    mut commands: Commands,
    mut trims: Query<(Entity, &Trim, &mut TrimJob, Option<&Solved>)>,
    sources: Query<(Entity, &Ground, Option<&TrimmedTo>)>,
    results: Query<(&ComposedOf, Has<Stale>), With<ResultOf>>,
    details: Query<(Entity, &DetailOf)>,
    mut serials: If<ResMut<Serials>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut misfits = Vec::new();
    for (source, ground, result) in &sources {
        let of_source = || trims.iter().filter(|(_, trim, ..)| trim.source == source);
        let mut pieces: Vec<&Solved> = of_source().filter_map(|(.., solved)| solved).collect();
        pieces.sort_unstable_by_key(|piece| piece.number);
        let made_of = ComposedOf(pieces.iter().map(|piece| piece.number).collect());
        let as_before = result.and_then(|result| results.get(result.0).ok()) == Some((&made_of, false));
        if as_before || of_source().any(|(_, _, job, _)| job.is_running()) {
            run.counted.skipped += 1;
            continue;
        }
        run.counted.items += 1;
        let surface = match compose(&ground.surface, &pieces) {
            Ok(Some(surface)) => surface,
            Ok(None) => continue,
            Err(Misfit { piece, why }) => {
                misfits.push((pieces[piece].together.clone(), why));
                continue;
            }
        };
        run.counted.written += 1;
        let revision = serials.0.next_number();
        let left = (snapshot(surface, revision), ResultOf(source), made_of);
        match result.filter(|result| results.contains(result.0)) {
            Some(&TrimmedTo(result)) => {
                commands.entity(result).try_insert(left).try_remove::<Stale>();
            }
            None => {
                let result = commands.spawn(left).id();
                commands.entity(source).try_insert(TrimmedTo(result));
            }
        }
    }
    let freed = misfits.iter().flat_map(|(together, _)| together).copied().collect();
    for (together, why) in misfits {
        run.counted.written += 1;
        misfit(&mut commands, &mut trims, &together, why);
    }
    discard(&mut commands, &freed, details.iter().map(|(detail, of)| (detail, of.0)));
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.compose += run.finish();
    }
}

/// What trims made together have left does not fit the rest: the newest fails, and the others are
/// made again.
fn misfit(
    commands: &mut Commands,
    trims: &mut Query<(Entity, &Trim, &mut TrimJob, Option<&Solved>)>,
    together: &[Entity],
    why: RemeshError,
) {
    for &trim in together {
        commands.entity(trim).try_remove::<WorkTraces>();
        let Ok((_, _, mut job, _)) = trims.get_mut(trim) else { continue };
        job.together.clear();
        job.state = if Some(&trim) == together.last() { TrimState::Failed } else { TrimState::Located };
    }
    if let Some(&newest) = together.last() {
        let failed = TrimFailed { why: why.into(), ladder: Vec::new() };
        commands.entity(newest).try_remove::<FailedTraces>().try_insert(failed);
    }
}

fn snapshot(surface: Arc<LoopSurface>, revision: u64) -> Snapshot {
    let curves = surface.sides.iter().map(|side| match &side.border {
        Border::Plain => None,
        Border::Given { curve, .. } => caught(|| curve.curve().revision()).ok(),
    });
    let curves = curves.collect();
    Snapshot { surface, revision, structure: revision, curves }
}
