//! The systems that check.

use std::sync::Arc;

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use selvedge_components::budget::Budgets;
use selvedge_components::curve::SpaceCurve;
use selvedge_components::error::{CurveFailed, SurfaceFailed};
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

/// The revision at which each curve was checked last; `None` where it panicked when asked.
pub type Checked = EntityHashMap<Option<u64>>;

/// Refuses every curve that is new or has changed and has a fault, and clears those that have none.
pub fn check_curves(
    mut commands: Commands,
    curves: Query<(Entity, Ref<SpaceCurve>, Has<CurveFailed>)>,
    mut checked: Local<Checked>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let before = core::mem::take(&mut *checked);
    let mut checks = Vec::new();
    for (entity, space, failed) in &curves {
        let revision = caught(|| space.curve.revision()).ok();
        checked.insert(entity, revision);
        if space.is_changed() || before.get(&entity) != Some(&revision) {
            checks.push((entity, Arc::clone(&space.curve), failed, Vec::new()));
        } else {
            run.counted.skipped += 1;
        }
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
