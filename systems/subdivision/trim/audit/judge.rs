//! What of that which was measured and counted is a fault.

use glam::DVec3;
use selvedge_components::curve::Traversal;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Border, Ends};
use selvedge_components::trim::{TrimAudit, TrimAuditFault};

use super::Measuring;
use crate::parallel::map_dear_in_order;
use crate::subdivision::remesh::FaceOrigin;

impl Measuring {
    pub(super) fn judge_distances(&self, faults: &mut Vec<TrimAuditFault>) {
        let Some(limit) = self.allowed else { return };
        let TrimAudit { to_source, to_source_at, to_result, to_result_at, .. } = self.found;
        let both = [
            ("the result from the source", to_source, to_source_at),
            ("the source from the result", to_result, to_result_at),
        ];
        for (what, distance, at) in both {
            if distance > limit || distance.is_nan() {
                faults.push(TrimAuditFault::Distance { what, distance, limit, at });
            }
        }
    }

    /// How a face beyond Omega is not what it was: compares limit points of both surfaces, bit for bit.
    /// Where the whole cage was refined first, for a small reach, they are the same up to rounding.
    pub(super) fn change_of(&self, face: FaceId) -> Option<TrimAuditFault> {
        const STEPS: u32 = 4;
        let origin = self.remeshed.face_origin[face.index()];
        let FaceOrigin::Leaf { level, code } = origin else {
            let at = self.limit.position(SurfacePoint::new(face, 1.0 / 3.0, 1.0 / 3.0));
            return Some(TrimAuditFault::Outside { face: face.0, distance: 0.0, at });
        };
        let rounding = if level == 0 { 0.0 } else { ROUNDING * self.ground.size };
        let places =
            (0..=STEPS).flat_map(|i| (0..=STEPS - i).map(move |j| [i, j].map(|k| f64::from(k) / f64::from(STEPS))));
        places.into_iter().find_map(|[s, t]| {
            let now = self.limit.position(SurfacePoint::new(face, s, t));
            let then = self.ground.limit().position(code.place(level, [1.0 - s - t, s, t]));
            let distance = now.distance(then);
            let same = bits(now) == bits(then) || distance <= rounding;
            (!same).then_some(TrimAuditFault::Outside { face: face.0, distance, at: now })
        })
    }

    /// Every border sample of a side of the result is its curve's own value. Returns how many there are.
    pub(super) fn compare(&self, s: usize) -> (usize, Vec<TrimAuditFault>) {
        let (mesh, side) = (&self.surface.mesh, &self.surface.sides[s]);
        let Border::Given { curve, first, heading } = &side.border else { return (0, Vec::new()) };
        let along = Traversal { first: *first, heading: *heading };
        // Where a side begins at a corner, the older of the two that meet gives the bits.
        let first_step = u64::from(side.ends == Ends::Corners);
        // Vertices of the side, and places two levels below, through the evaluator.
        let steps = |level: u32| (first_step..(side.edge_count() as u64) << level).map(move |step| (level, step));
        let places: Vec<(u32, u64)> = [0, 2].into_iter().flat_map(steps).collect();
        let faults = map_dear_in_order(places.len(), |i| {
            let (level, step) = places[i];
            let u = curve.parameter(level, along.vertex(curve, level, step));
            let (edge, part) = ((step >> level) as usize, step & ((1 << level) - 1));
            let ends = [edge, (edge + 1) % side.vertices.len()].map(|i| side.vertices[i]);
            let at = on_edge(mesh, ends, part as f64 / f64::from(1_u32 << level))?;
            let (found, sample) = (self.limit.position(at), curve.curve().position(u));
            let same = bits(found) == bits(sample);
            Some((!same).then_some(TrimAuditFault::OffCurve { side: s, u, at: found, sample }))
        });
        let compared = faults.iter().flatten().count();
        (compared, faults.into_iter().flatten().flatten().collect())
    }

    /// Borders are simple loops made of sides; loops, parts and Euler number make a surface that is no
    /// more knotted than the source.
    pub(super) fn judge_topology(&mut self, faults: &mut Vec<TrimAuditFault>) {
        let mesh = &self.surface.mesh;
        let loops = mesh.border_loops();
        let edges: usize = loops.iter().map(Vec::len).sum();
        let named: usize = self.surface.sides.iter().map(|side| side.edge_count()).sum();
        if edges != named {
            faults.push(TrimAuditFault::Border { edges, named });
        }
        let (euler, parts) = (mesh.euler(), parts(mesh));
        (self.found.loops, self.found.euler) = (loops.len(), euler);
        // Twice the genus of all parts together: even, and not above the source's.
        let twice_genus = 2 * parts as i64 - euler - loops.len() as i64;
        let source = &self.ground.surface.mesh;
        let most = 2 * self::parts(source) as i64 - source.euler() - source.border_loops().len() as i64;
        if twice_genus < 0 || twice_genus % 2 != 0 || twice_genus > most {
            faults.push(TrimAuditFault::Euler { euler, loops: loops.len(), parts });
        }
    }

    /// The pieces of the source that are kept, cut and removed make up each of its faces once.
    pub(super) fn judge_cover(&self, faults: &mut Vec<TrimAuditFault>) {
        let mut shares = vec![0.0; self.ground.surface.mesh.face_count()];
        for &(level, code, _) in &self.remeshed.fates {
            shares[code.root_face(level).index()] += 0.25_f64.powi(level as i32);
        }
        for (face, &share) in (0_u32..).zip(&shares) {
            // A sum of quarters of quarters is exact.
            if share != 1.0 {
                faults.push(TrimAuditFault::Cover { face, share });
            }
        }
    }
}

/// Limit points by other ways differ by no more than this part of a surface's size.
const ROUNDING: f64 = 1e-14;

/// The bits of a point.
fn bits(p: DVec3) -> [u64; 3] {
    p.to_array().map(f64::to_bits)
}

/// The place of the border edge between `ends`, walked with the surface on the left, at `share` of
/// the way.
fn on_edge(mesh: &Connectivity, ends: [VertexId; 2], share: f64) -> Option<SurfacePoint> {
    let h: HalfedgeId = mesh.ring(ends[0]).find(|&h| mesh.to(h) == ends[1])?;
    let mut weights = [0.0; 3];
    let corner = h.corner();
    (weights[corner], weights[(corner + 1) % 3]) = (1.0 - share, share);
    Some(SurfacePoint::new(h.face(), weights[1], weights[2]))
}

/// How many connected parts a mesh has.
fn parts(mesh: &Connectivity) -> usize {
    let mut seen = vec![false; mesh.face_count()];
    let mut parts = 0;
    for f in 0..mesh.face_count() {
        if core::mem::replace(&mut seen[f], true) {
            continue;
        }
        parts += 1;
        let mut stack = vec![FaceId::new(f)];
        while let Some(face) = stack.pop() {
            for corner in 0..3 {
                if let Some(twin) = mesh.twin(HalfedgeId::of(face, corner))
                    && !core::mem::replace(&mut seen[twin.face().index()], true)
                {
                    stack.push(twin.face());
                }
            }
        }
    }
    parts
}
