//! The systems that check.

use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use selvedge_components::budget::Budgets;
use selvedge_components::curve::SpaceCurve;
use selvedge_components::error::{CurveFailed, SurfaceFailed};
use selvedge_components::guard::caught;
use selvedge_components::subdivision::Snapshot;

use super::{curve_fault, surface_faults};
use crate::diagnostics::{Counters, GroundDiagnostics};
use crate::parallel::for_each;

/// Refuses every surface whose new snapshot has a fault, and clears those that have none.
pub fn check_surfaces(
    mut commands: Commands,
    snapshots: Query<(Entity, &Snapshot, Has<SurfaceFailed>), Changed<Snapshot>>,
    budgets: Option<Res<Budgets>>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let budgets = budgets.map_or_else(Budgets::default, |b| *b);
    let mut checks: Vec<_> =
        snapshots.iter().map(|(entity, snapshot, failed)| (entity, &*snapshot.surface, failed, Vec::new())).collect();
    for_each(checks.iter_mut().collect(), |(_, surface, _, faults)| *faults = surface_faults(surface, &budgets));
    run.counted.items = checks.len() as u64;
    for (entity, _, failed, faults) in checks {
        run.counted.written += u64::from(failed || !faults.is_empty());
        if !faults.is_empty() {
            commands.entity(entity).try_remove::<Snapshot>().try_insert(SurfaceFailed(faults));
        } else if failed {
            commands.entity(entity).try_remove::<SurfaceFailed>();
        }
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.check += run.finish();
    }
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
    for (entity, space, failed) in &curves {
        let revision = caught(|| space.curve.revision()).ok();
        checked.insert(entity, revision);
        if !space.is_changed() && before.get(&entity) == Some(&revision) {
            run.counted.skipped += 1;
            continue;
        }
        run.counted.items += 1;
        let fault = curve_fault(&*space.curve);
        run.counted.written += u64::from(failed || fault.is_some());
        match fault {
            Some(fault) => commands.entity(entity).try_insert(fault),
            None => commands.entity(entity).try_remove::<CurveFailed>(),
        };
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.check += run.finish();
    }
}
