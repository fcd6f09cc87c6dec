//! The system that audits.

use bevy_ecs::prelude::*;
use selvedge_components::guard::caught;
use selvedge_components::subdivision::Snapshot;
use selvedge_components::triangles::Triangles;
use selvedge_components::triangulation::{Triangulated, TriangulationFailed};

use super::{AuditFault, AuditOptions, AuditReport, audit_result};
use crate::diagnostics::{Counters, GroundDiagnostics};
use crate::parallel::for_each;

/// The triangles, or what is asked of their audit, have become other ones.
type Stale = Or<(Changed<Triangles>, Changed<AuditOptions>)>;
type Asked = (Entity, &'static Snapshot, &'static Triangles, &'static Triangulated, &'static AuditOptions);

/// Audits the triangles of every surface that asks for it, once for each time they are made.
pub fn audit_surfaces(
    mut commands: Commands,
    surfaces: Query<Asked, (Stale, Without<TriangulationFailed>)>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut due: Vec<_> = surfaces
        .iter()
        // Triangles left from before a failure, or from another surface, say nothing about this one.
        .filter(|(_, snapshot, _, from, _)| snapshot.revision == from.revision)
        .map(|(entity, snapshot, triangles, from, options)| {
            (entity, snapshot, triangles, from, options, AuditReport::default())
        })
        .collect();
    for_each(due.iter_mut().collect(), |(_, snapshot, triangles, from, options, report)| {
        *report =
            caught(|| audit_result(triangles, &snapshot.surface, &from.options, options)).unwrap_or_else(|message| {
                AuditReport { faults: vec![AuditFault::Unmeasured { why: message }], ..AuditReport::default() }
            });
    });
    run.counted.items = due.len() as u64;
    run.counted.written = due.len() as u64;
    for (entity, .., report) in due {
        commands.entity(entity).try_insert(report);
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.audit += run.finish();
    }
}
