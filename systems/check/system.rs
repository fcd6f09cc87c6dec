//! The systems that check.

use std::sync::Arc;

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use selvedge_components::budget::Budgets;
use selvedge_components::curve::SpaceCurve;
use selvedge_components::error::{CurveFailed, CurveUnchecked, SurfaceFailed};
use selvedge_components::guard::caught;
use selvedge_components::subdivision::Snapshot;

use super::{curve_faults, surface_faults, value_faults};
use crate::diagnostics::{Counters, GroundDiagnostics};
use crate::parallel::for_each;

/// The structure of each surface that was found sound.
pub type Sound = EntityHashMap<u64>;

/// Refuses every surface whose new snapshot has a fault, and clears those that have none.
pub fn check_surfaces(
    mut commands: Commands,
    snapshots: Query<(Entity, Ref<Snapshot>, Has<SurfaceFailed>)>,
    budgets: Option<Res<Budgets>>,
    mut sound: Local<Sound>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let budgets = budgets.map_or_else(Budgets::default, |b| *b);
    let before = core::mem::take(&mut *sound);
    let mut checks = Vec::new();
    for (entity, snapshot, failed) in &snapshots {
        let known = before.get(&entity).is_some_and(|&structure| structure == snapshot.structure);
        sound.insert(entity, snapshot.structure);
        if snapshot.is_changed() {
            let surface = Arc::clone(&snapshot.surface);
            checks.push((entity, surface, if known { Extent::Values } else { Extent::All }, failed, Vec::new()));
        } else {
            run.counted.skipped += 1;
        }
    }
    for_each(checks.iter_mut().collect(), |(_, surface, extent, _, faults)| {
        *faults = match extent {
            Extent::Values => value_faults(surface),
            Extent::All => surface_faults(surface, &budgets),
        }
    });
    run.counted.items = checks.len() as u64;
    for (entity, _, _, failed, faults) in checks {
        run.counted.written += u64::from(failed || !faults.is_empty());
        if !faults.is_empty() {
            sound.remove(&entity);
            commands.entity(entity).try_remove::<Snapshot>().try_insert(SurfaceFailed(faults));
        } else if failed {
            commands.entity(entity).try_remove::<SurfaceFailed>();
        }
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.check += run.finish();
    }
}

/// How much of a surface has to be checked.
enum Extent {
    /// Its values: the rest is as it was when it was found sound.
    Values,
    /// All of it.
    All,
}

/// A curve, and what was said of it.
type Curves = (Entity, Ref<'static, SpaceCurve>, Has<CurveFailed>, Has<CurveUnchecked>);

/// How many curves are checked in a pass: each takes about a millisecond.
const CURVES: usize = 8;

/// What is known of curves from the passes before.
#[derive(Debug, Default)]
pub struct Checked {
    /// The revision at which each was checked last, or will be; `None` where it panicked when asked.
    revisions: EntityHashMap<Option<u64>>,
    /// Those that are to be checked, in the order in which they became so.
    waiting: Vec<Entity>,
}

/// Refuses every curve that is new or has changed and has a fault, and clears those that have none: some in
/// a pass, while the others are marked.
pub fn check_curves(
    mut commands: Commands,
    curves: Query<Curves>,
    mut checked: Local<Checked>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let before = core::mem::take(&mut checked.revisions);
    let mut changed = Vec::new();
    for (entity, space, ..) in &curves {
        let revision = caught(|| space.curve.revision()).ok();
        checked.revisions.insert(entity, revision);
        if space.is_changed() || before.get(&entity) != Some(&revision) {
            changed.push(entity);
        } else {
            run.counted.skipped += 1;
        }
    }
    changed.sort_unstable();
    let known: EntityHashSet = checked.waiting.iter().copied().collect();
    checked.waiting.extend(changed.into_iter().filter(|curve| !known.contains(curve)));
    checked.waiting.retain(|&curve| curves.contains(curve));
    let most = checked.waiting.len().min(CURVES);
    let later = checked.waiting.split_off(most);
    let now = core::mem::replace(&mut checked.waiting, later);
    for (entity, .., is_marked) in checked.waiting.iter().filter_map(|&curve| curves.get(curve).ok()) {
        if !is_marked {
            commands.entity(entity).try_insert(CurveUnchecked);
        }
    }
    let mut checks = Vec::new();
    for (entity, space, failed, is_marked) in now.into_iter().filter_map(|curve| curves.get(curve).ok()) {
        if is_marked {
            commands.entity(entity).try_remove::<CurveUnchecked>();
        }
        checks.push((entity, Arc::clone(&space.curve), failed, Vec::new()));
    }
    for_each(checks.iter_mut().collect(), |(_, curve, _, faults)| *faults = curve_faults(&**curve));
    run.counted.items = checks.len() as u64;
    for (entity, _, failed, faults) in checks {
        run.counted.written += u64::from(failed || !faults.is_empty());
        if faults.is_empty() {
            commands.entity(entity).try_remove::<CurveFailed>();
        } else {
            commands.entity(entity).try_insert(CurveFailed(faults));
        }
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.check += run.finish();
    }
}
