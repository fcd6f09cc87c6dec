//! The system that enrolls.

use bevy_ecs::prelude::*;
use selvedge_components::curve::SpaceCurve;
use selvedge_components::identity::{Serial, Serials};
use selvedge_components::job::Fit;
use selvedge_components::subdivision::Cage;
use selvedge_components::trim::Trim;

use crate::diagnostics::{Counters, GroundDiagnostics};

type Newcomer = (Without<Serial>, Or<(With<Cage>, With<SpaceCurve>, With<Fit>, With<Trim>)>);

/// Gives a number to every surface, curve and job that has none.
pub fn enroll(
    mut commands: Commands,
    newcomers: Query<Entity, Newcomer>,
    mut serials: If<ResMut<Serials>>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut newcomers: Vec<_> = newcomers.iter().collect();
    newcomers.sort_unstable();
    run.counted.items = newcomers.len() as u64;
    run.counted.written = newcomers.len() as u64;
    for newcomer in newcomers {
        commands.entity(newcomer).try_insert(Serial(serials.0.next_number()));
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.enroll += run.finish();
    }
}
