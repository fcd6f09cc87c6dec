//! Which trims are made together, and what is old from then on.

use std::sync::Arc;

use bevy_ecs::entity::EntityHashSet;
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use selvedge_components::trim::{AtRemesh, OtherSide, Stale, TrimJob, TrimStage, TrimState, TrimmedTo};

use super::super::system::{Admitted, Job};
use crate::diagnostics::Counters;
use crate::subdivision::region;
use crate::subdivision::trim::group::replay;
use crate::subdivision::trim::traces::WorkTraces;
use crate::subdivision::trim::{LocateWork, TrimWork};

/// Trims that were made together with one that has gone, begins again or is refused are to be made again,
/// whatever becomes of that. Returns them.
pub(in super::super) fn part(
    commands: &mut Commands,
    (source, trims): (Entity, &[<Job as QueryData>::Item<'_, '_>]),
    admitted: &Admitted,
) -> Vec<Entity> {
    let mut goes_on: EntityHashSet = trims.iter().map(|trim| trim.0).collect();
    for trim in admitted.refused.iter().chain(admitted.starts.iter().map(|start| &start.trim)) {
        goes_on.remove(trim);
    }
    let mut parted = Vec::new();
    for (trim, job) in trims.iter().filter_map(|trim| Some((trim.0, trim.5?))) {
        if goes_on.contains(&trim) && job.together.iter().any(|other| !goes_on.contains(other)) {
            let job = TrimJob { quanta: job.quanta, ..TrimJob::new(TrimState::Located, job.inputs.clone()) };
            commands.entity(trim).try_remove::<WorkTraces>().try_insert(job);
            parted.push(trim);
        }
    }
    if !parted.is_empty() {
        commands.entity(source).queue_silenced(mark_stale);
        mark_others(commands, trims);
    }
    parted
}

/// Sends located trims on their way, in groups; those whose group is what it was go on as they are.
/// Returns those that have begun.
pub(in super::super) fn begin_groups(
    commands: &mut Commands,
    trims: &[<Job as QueryData>::Item<'_, '_>],
    counted: &mut Counters,
) -> Vec<Entity> {
    let mut begun = Vec::new();
    let standing: Vec<_> = trims
        .iter()
        .filter_map(|trim| Some((trim.0, trim.5?, trim.6?)).filter(|t| t.1.state != TrimState::Failed))
        .collect();
    let reaches: Vec<_> = standing.iter().map(|(trim, _, located)| (*trim, located.reaches())).collect();
    let (groups, steps) = replay(&reaches);
    for group in groups {
        let members: Vec<_> = standing.iter().zip(&steps).filter(|((trim, ..), _)| group.contains(trim)).collect();
        let as_before = members.iter().all(|((_, job, located), step)| {
            job.together == group && job.state != TrimState::Located && located.reaches().len() == **step + 1
        });
        if as_before {
            continue;
        }
        counted.written += 1;
        begun.extend(group.iter().copied());
        commands.entity(trims[0].2.source).queue_silenced(mark_stale);
        mark_others(commands, trims);
        let located: Vec<LocateWork> = members
            .iter()
            .map(|((.., located), step)| {
                let mut located = LocateWork::clone(located);
                located.go_back(**step);
                located
            })
            .collect();
        let lead = members[0].0.0;
        let ground = Arc::clone(located[0].ground());
        let reserved = located.iter().flat_map(|located| located.reserved()).copied().collect();
        let found = located.iter().map(|located| Arc::clone(located.found())).collect();
        let work = TrimWork::new(ground, found, region::ascending(reserved));
        for (&(&(trim, job, _), _), located) in members.iter().zip(located) {
            let led = trim != lead;
            let state = if led { TrimState::With(lead) } else { TrimState::Running(TrimStage::Remesh) };
            let job = TrimJob { together: group.clone(), ..TrimJob::new(state, job.inputs.clone()) };
            commands.entity(trim).try_remove::<WorkTraces>().try_insert((job, located));
        }
        commands.entity(lead).try_insert((work, AtRemesh));
    }
    begun
}

/// The last good result stays, and says that it is not the present one.
pub(in super::super) fn mark_stale(mut source: EntityWorldMut) {
    if let Some(&TrimmedTo(result)) = source.get() {
        source.world_scope(|world| mark_result(world, result));
    }
}

pub(in super::super) fn mark_others(commands: &mut Commands, trims: &[<Job as QueryData>::Item<'_, '_>]) {
    for trim in trims {
        commands.entity(trim.0).queue_silenced(mark_other_stale);
    }
}

fn mark_other_stale(mut trim: EntityWorldMut) {
    if let Some(&OtherSide(result)) = trim.get() {
        trim.world_scope(|world| mark_result(world, result));
    }
}

fn mark_result(world: &mut World, result: Entity) {
    if let Ok(mut result) = world.get_entity_mut(result) {
        result.insert(Stale);
    }
}
