//! # Audit: triangles are measured by someone else
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | `Triangles`, `Snapshot`, [`AuditOptions`] | [`AuditReport`] | `Triangulate` | `Finish` |
//!
//! Nothing here knows how the triangles were made. The mesh is judged by its indices, its borders by
//! the curves themselves, its coverage by areas in the domain, and its distance to the limit surface
//! by evaluating that surface at random places, in both directions.

mod border;
mod domain;
mod measure;
mod system;

use std::sync::Arc;

use selvedge_components::evaluate::Evaluate;
use selvedge_components::mesh::{Connectivity, VertexId, position_faults};
use selvedge_components::subdivision::LoopSurface;
use selvedge_components::triangles::Triangles;

pub use selvedge_components::audit::{AuditFault, AuditOptions, AuditReport, Measured};

pub use system::audit_surfaces;

use crate::subdivision::limit::LimitSurface;
use crate::triangulate::{Density, TriangulateOptions, shape};

/// What triangles are audited against.
#[derive(Clone, Copy)]
pub struct Audit<'a> {
    /// The surface that the triangles stand for.
    pub surface: &'a LoopSurface,
    /// Its limit, evaluated by other means than the triangles were; without it no distance is
    /// measured.
    pub limit: Option<&'a dyn Evaluate>,
    /// The distance between both that is allowed, in model units.
    pub chord: Option<f64>,
    /// Random places inside each triangle; each of its edges gets a quarter as many.
    pub points: u32,
    /// Chooses the places.
    pub seed: u64,
}

impl core::fmt::Debug for Audit<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { chord, points, seed, limit, .. } = self;
        let limit = limit.map(|_| "a surface");
        f.debug_struct("Audit")
            .field("limit", &limit)
            .field("chord", chord)
            .field("points", points)
            .field("seed", seed)
            .finish_non_exhaustive()
    }
}

impl<'a> Audit<'a> {
    /// Everything but distances.
    pub fn of(surface: &'a LoopSurface) -> Self {
        Self { surface, limit: None, chord: None, points: 45, seed: 0 }
    }

    /// Distances to `limit` too, of which none may be greater than `chord`.
    #[must_use]
    pub fn within(self, limit: &'a dyn Evaluate, chord: f64) -> Self {
        Self { limit: Some(limit), chord: Some(chord), ..self }
    }
}

/// Audits the triangles that `made` asked for of `surface`, against its limit evaluated anew.
pub fn audit_result(
    triangles: &Triangles,
    surface: &Arc<LoopSurface>,
    made: &TriangulateOptions,
    options: &AuditOptions,
) -> AuditReport {
    let plain = Audit { points: options.points, seed: options.seed, ..Audit::of(surface) };
    if options.points == 0 {
        return audit(triangles, &plain);
    }
    let limit = match LimitSurface::new(Arc::clone(surface)) {
        Ok(limit) => limit,
        Err(why) => {
            let mut report = audit(triangles, &plain);
            report.faults.push(AuditFault::Unmeasured { why: why.to_string() });
            return report;
        }
    };
    let chord = match made.density {
        Density::Chord(chord) => Some(chord),
        Density::Level(_) => None,
    };
    audit(triangles, &Audit { limit: Some(&limit), chord, ..plain })
}

/// Audits `triangles`, which must have [`Triangles::origins`].
///
/// Faults of the indices end the audit: without a sound mesh there is nothing to measure.
pub fn audit(triangles: &Triangles, against: &Audit<'_>) -> AuditReport {
    let mut report = AuditReport {
        vertices: triangles.positions.len(),
        triangles: triangles.triangles.len(),
        ..AuditReport::default()
    };
    report.faults = array_faults(triangles);
    if !report.faults.is_empty() {
        return report;
    }
    let mesh = match Connectivity::new(triangles.positions.len(), &triangles.triangles) {
        Ok(mesh) => mesh,
        Err(found) => {
            report.faults.extend(found.into_iter().map(AuditFault::Mesh));
            return report;
        }
    };
    judge_mesh(triangles, &mesh, against.surface, &mut report);
    let places = domain::places(triangles, against.surface, &mut report.faults);
    let Some(places) = places else { return report };
    domain::judge_cover(triangles, &places, against.surface, &mut report.faults);
    border::judge(triangles, &mesh, &places, against.surface, &mut report.faults);
    if let Some(limit) = against.limit {
        report.measured = Some(measure::measure(triangles, &mesh, &places, limit, against, &mut report.faults));
    }
    report
}

fn array_faults(triangles: &Triangles) -> Vec<AuditFault> {
    let expected = triangles.positions.len();
    let lengths = [("origins", triangles.origins.len()), ("normals", triangles.normals.len())];
    let mut found: Vec<_> = lengths
        .into_iter()
        .filter(|&(what, given)| given != expected && (given != 0 || what == "origins"))
        .map(|(what, given)| AuditFault::Length { what, given, expected })
        .collect();
    found.extend(position_faults(&triangles.positions).into_iter().map(AuditFault::Mesh));
    found
}

/// What the indices and positions alone tell.
fn judge_mesh(triangles: &Triangles, mesh: &Connectivity, surface: &LoopSurface, report: &mut AuditReport) {
    report.euler = mesh.euler();
    let (found, expected) = (mesh.euler(), surface.mesh.euler());
    if found != expected {
        report.faults.push(AuditFault::Euler { found, expected });
    }
    report.border_loops = mesh.border_loops().iter().map(Vec::len).collect();
    let (found, expected) = (report.border_loops.len(), surface.mesh.border_loops().len());
    if found != expected {
        report.faults.push(AuditFault::Loops { found, expected });
    }
    report.worst_shape = f64::INFINITY;
    for (triangle, corners) in triangles.triangles.iter().enumerate() {
        let shape = shape(corners.map(|v| triangles.positions[v as usize]));
        report.worst_shape = report.worst_shape.min(shape);
        if shape <= THINNEST {
            report.faults.push(AuditFault::Degenerate { triangle, shape });
        }
    }
    judge_coincident(triangles, &mut report.faults);
}

/// A triangle whose height is this part of its longest edge has no area that survives rounding its
/// corners.
const THINNEST: f64 = 8.0 * f64::EPSILON;

/// Two vertices in one place are a crack that is closed to the eye alone.
fn judge_coincident(triangles: &Triangles, found: &mut Vec<AuditFault>) {
    let bits = |v: u32| triangles.positions[v as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..triangles.positions.len() as u32).collect();
    order.sort_unstable_by_key(|&v| (bits(v), v));
    for pair in order.windows(2).filter(|pair| bits(pair[0]) == bits(pair[1])) {
        let [first, second] = [pair[0], pair[1]].map(VertexId);
        found.push(AuditFault::Coincident { first, second, at: triangles.positions[first.index()] });
    }
}
