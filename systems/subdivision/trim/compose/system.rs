//! The system that puts results together.

use std::sync::Arc;

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use selvedge_components::guard::caught;
use selvedge_components::identity::{Serial, Serials};
use selvedge_components::subdivision::{Border, DetailOf, LoopSurface, Snapshot};
use selvedge_components::trim::{
    OtherSide, OtherSideOf, ResultOf, Stale, Trim, TrimFailed, TrimFault, TrimJob, TrimState, TrimmedTo,
};

use super::{ComposedOf, Misfit, Solved, compose};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::subdivision::job::discard;
use crate::subdivision::trim::Ground;
use crate::subdivision::trim::traces::{FailedTraces, WorkTraces};

type Made = (
    Entity,
    &'static Trim,
    &'static mut TrimJob,
    Option<&'static Solved>,
    Option<&'static Serial>,
    Option<&'static OtherSide>,
);
type Source = (Entity, &'static Ground, Option<&'static TrimmedTo>);
type Read<'a> = <<Made as QueryData>::ReadOnly as QueryData>::Item<'a, 'a>;
type Results<'w, 's> =
    Query<'w, 's, (Entity, &'static ComposedOf, Has<Stale>, Option<&'static ResultOf>, Option<&'static OtherSideOf>)>;

/// Trims made together whose result does not fit the rest: which of them fails, and why.
struct Failure {
    together: Vec<Entity>,
    failed: Entity,
    why: TrimFault,
}

/// Puts together what is left of each source, and what trims remove that are asked for it, once none
/// of its trims is at work any more.
pub fn compose_results(
    mut commands: Commands,
    mut trims: Query<Made>,
    (sources, trimmed): (Query<Source>, Query<&TrimmedTo>),
    results: Results,
    details: Query<(Entity, &DetailOf)>,
    mut serials: If<ResMut<Serials>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut failures = Vec::new();
    drop_results(&mut commands, &trims, &trimmed, &results);
    for (source, ground, result) in &sources {
        let of_source: Vec<Read<'_>> = trims.iter().filter(|(_, trim, ..)| trim.source == source).collect();
        if of_source.iter().any(|(_, _, job, ..)| job.is_running()) {
            run.counted.skipped += 1;
            continue;
        }
        let pieces = in_order(&of_source);
        let result = result.map(|result| result.0);
        match composed(&mut commands, &ground.surface, &pieces, result, &results) {
            Ok(None) => run.counted.skipped += 1,
            Ok(Some((surface, made_of))) => {
                (run.counted.items, run.counted.written) = (run.counted.items + 1, run.counted.written + 1);
                let left = (snapshot(surface, serials.0.next_number()), ResultOf(source), made_of);
                if let Some(result) = put(&mut commands, &results, result, left) {
                    commands.entity(source).try_insert(TrimmedTo(result));
                }
            }
            Err(Misfit { piece, why }) => {
                run.counted.items += 1;
                let together = pieces[piece].together.clone();
                failures.extend(together.last().map(|&failed| Failure { failed, why, together: together.clone() }));
                continue;
            }
        }
        for (trim, others) in others(&pieces) {
            let result = of_source.iter().find(|read| read.0 == trim).and_then(|read| read.5).map(|other| other.0);
            match composed(&mut commands, &ground.surface, &others, result, &results) {
                Ok(None) => {}
                Ok(Some((surface, made_of))) => {
                    run.counted.written += 1;
                    let left = (snapshot(surface, serials.0.next_number()), OtherSideOf(trim), made_of);
                    if let Some(result) = put(&mut commands, &results, result, left) {
                        commands.entity(trim).try_insert(OtherSide(result));
                    }
                }
                Err(Misfit { why, .. }) => {
                    let why = TrimFault::OtherSide { why: Box::new(why) };
                    let together = pieces.iter().find(|piece| piece.together.contains(&trim));
                    let together = together.map_or_else(Vec::new, |piece| piece.together.clone());
                    failures.push(Failure { together, failed: trim, why });
                }
            }
        }
    }
    let freed = failures.iter().flat_map(|failure| &failure.together).copied().collect();
    for failure in failures {
        run.counted.written += 1;
        fail(&mut commands, &mut trims, failure);
    }
    discard(&mut commands, &freed, details.iter().map(|(detail, of)| (detail, of.0)));
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.compose += run.finish();
    }
}

/// What is left by all of `pieces`, and what it was put together of; `None` where `result` is that, or
/// where nothing is left that could take its place: then it stays, and says that it is old.
fn composed(
    commands: &mut Commands,
    source: &LoopSurface,
    pieces: &[&Solved],
    result: Option<Entity>,
    results: &Results,
) -> Result<Option<(Arc<LoopSurface>, ComposedOf)>, Misfit> {
    let made_of = ComposedOf::of(pieces);
    let before = result.and_then(|result| results.get(result).ok());
    if let Some((result, of, is_stale, ..)) = before {
        if *of == made_of {
            // It was old as long as it might have become another one.
            if is_stale {
                commands.entity(result).try_remove::<Stale>();
            }
            return Ok(None);
        }
        if pieces.is_empty() && !is_stale {
            commands.entity(result).try_insert(Stale);
        }
    }
    Ok(compose(source, pieces)?.map(|surface| (surface, made_of)))
}

/// Gives a result what is left now, or makes one, which is returned.
fn put(commands: &mut Commands, results: &Results, result: Option<Entity>, left: impl Bundle) -> Option<Entity> {
    match result.filter(|&result| results.contains(result)) {
        Some(result) => {
            commands.entity(result).try_insert(left).try_remove::<Stale>();
            None
        }
        None => Some(commands.spawn(left).id()),
    }
}

/// What is left by each group of trims, in the order of the oldest trim of each: so of two that do not
/// go together, the younger is in the way.
fn in_order<'a>(trims: &[Read<'a>]) -> Vec<&'a Solved> {
    let order: EntityHashMap<_> = trims.iter().map(|read| (read.0, (read.4, read.0))).collect();
    let mut pieces: Vec<&Solved> = trims.iter().filter_map(|read| read.3).collect();
    pieces.sort_by_key(|piece| piece.together.first().and_then(|oldest| order.get(oldest).copied()));
    pieces
}

/// For each trim whose other side is wanted, that and what all other groups leave.
fn others<'a>(pieces: &[&'a Solved]) -> Vec<(Entity, Vec<&'a Solved>)> {
    let with = |k: usize, other: &'a Solved| {
        let mut pieces = pieces.to_vec();
        pieces[k] = other;
        pieces
    };
    let of_piece = |(k, piece): (usize, &&'a Solved)| {
        let piece: &'a Solved = piece;
        piece.others.iter().map(move |(trim, other)| (k, *trim, other))
    };
    pieces.iter().enumerate().flat_map(of_piece).map(|(k, trim, other)| (trim, with(k, other))).collect()
}

/// Results whose source has gone go with it; and so do other sides that nobody asks for any more, or that
/// could not be made.
fn drop_results(commands: &mut Commands, trims: &Query<Made>, trimmed: &Query<&TrimmedTo>, results: &Results) {
    let solved = trims.iter().filter_map(|(_, _, _, solved, ..)| solved);
    let made: EntityHashSet = solved.flat_map(|solved| &solved.others).map(|(trim, _)| *trim).collect();
    for (result, .., of, other_of) in results {
        if of.is_some_and(|of| trimmed.get(of.0).map_or(true, |trimmed| trimmed.0 != result)) {
            commands.entity(result).despawn();
        }
        let Some(&OtherSideOf(trim)) = other_of else { continue };
        // While its trim is at work, the last good one stays.
        let stays = made.contains(&trim) || trims.get(trim).is_ok_and(|(_, _, job, ..)| job.is_running());
        if !stays {
            commands.entity(result).despawn();
            // It may have been taken back, or be gone.
            commands.entity(trim).try_remove::<OtherSide>();
        }
    }
}

/// What trims made together have left does not fit the rest: one fails, and the others are made again.
fn fail(commands: &mut Commands, trims: &mut Query<Made>, Failure { together, failed, why }: Failure) {
    for &trim in &together {
        commands.entity(trim).try_remove::<WorkTraces>();
        let Ok((_, _, mut job, ..)) = trims.get_mut(trim) else { continue };
        job.together.clear();
        job.state = if trim == failed { TrimState::Failed } else { TrimState::Located };
    }
    let failure = TrimFailed { why, with: None, ladder: Vec::new() };
    commands.entity(failed).try_remove::<FailedTraces>().try_insert(failure);
}

fn snapshot(surface: Arc<LoopSurface>, revision: u64) -> Snapshot {
    let curves = surface.sides.iter().map(|side| match &side.border {
        Border::Plain => None,
        Border::Given { curve, .. } => caught(|| curve.curve().revision()).ok(),
    });
    let curves = curves.collect();
    Snapshot { surface, revision, structure: revision, curves }
}
