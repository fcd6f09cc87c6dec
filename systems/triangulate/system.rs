//! The system that triangulates.

use bevy_ecs::prelude::*;
use selvedge_components::budget::Budgets;
use selvedge_components::guard::caught;
use selvedge_components::subdivision::Snapshot;
use selvedge_components::tolerance::Tolerance;
use selvedge_components::triangulation::Triangulated;

use super::{TriangulateError, TriangulateOptions, TriangulationFailed, effective, triangulate};
use crate::diagnostics::{Counters, GroundDiagnostics};
use crate::parallel::for_each;

type Asked =
    (Entity, &'static Snapshot, &'static TriangulateOptions, Option<&'static Tolerance>, Option<&'static Triangulated>);

/// Triangulates every surface that asks for it and is not what its triangles were made of.
pub fn triangulate_surfaces(
    mut commands: Commands,
    surfaces: Query<Asked>,
    budgets: Option<Res<Budgets>>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let budgets = budgets.map_or_else(Budgets::default, |b| *b);
    let mut due = Vec::new();
    for (entity, snapshot, options, tolerance, before) in &surfaces {
        let from = Triangulated { revision: snapshot.revision, options: effective(options, tolerance, &budgets) };
        let is_made = |before: &Triangulated| before.revision == from.revision && before.options.same_as(&from.options);
        if before.is_some_and(is_made) {
            run.counted.skipped += 1;
        } else {
            due.push((entity, &*snapshot.surface, from, None));
        }
    }
    for_each(due.iter_mut().collect(), |(_, surface, from, made)| {
        let done = caught(|| triangulate(surface, &from.options));
        *made = Some(done.unwrap_or_else(|message| Err(TriangulateError::Panicked { message })));
    });
    run.counted.items = due.len() as u64;
    for (entity, _, from, made) in due {
        let Some(made) = made else { continue };
        run.counted.written += 1;
        match made {
            Ok(made) => {
                let results = (made.triangles, made.report, from);
                commands.entity(entity).try_remove::<TriangulationFailed>().try_insert(results);
            }
            Err(why) => {
                commands.entity(entity).try_insert((TriangulationFailed(why), from));
            }
        }
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.triangulate += run.finish();
    }
}
