//! Borders: where they may be, and the curves that own them.

use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Border, FINEST_LEVEL, LoopSurface, border_sample};
use selvedge_components::triangles::Triangles;

use super::AuditFault;
use super::domain::Place;

/// Every open edge must run along a border of the root mesh, surface on its left, and on a given
/// border its ends must be the curve's samples, bit for bit.
pub fn judge(
    triangles: &Triangles,
    mesh: &Connectivity,
    places: &[Place],
    surface: &LoopSurface,
    found: &mut Vec<AuditFault>,
) {
    let sides = RootBorder::new(surface);
    for h in (0..3 * mesh.face_count()).map(HalfedgeId::new).filter(|&h| mesh.twin(h).is_none()) {
        let ends = [mesh.from(h), mesh.to(h)];
        let (place, corner) = (&places[h.face().index()], h.corner());
        let [from, to] = [place.weights[corner], place.weights[(corner + 1) % 3]];
        match along_border(surface, place.face, from, to) {
            Some((root, start)) => {
                // The edge's end is the start of the next one.
                judge_sample(triangles, ends[0], &sides, root, start, found);
            }
            None => {
                let at = triangles.positions[ends[0].index()];
                found.push(AuditFault::OpenEdge { ends, triangle: h.face().index(), at });
            }
        }
    }
}

/// The border half-edge of the root mesh along which an edge runs forward, and how far along it the
/// edge starts.
fn along_border(surface: &LoopSurface, face: FaceId, from: [f64; 3], to: [f64; 3]) -> Option<(HalfedgeId, f64)> {
    (0..3).find_map(|corner| {
        let (apex, end) = ((corner + 2) % 3, (corner + 1) % 3);
        let root = HalfedgeId::of(face, corner);
        let forward = from[apex] == 0.0 && to[apex] == 0.0 && from[end] < to[end];
        (forward && surface.mesh.twin(root).is_none()).then_some((root, from[end]))
    })
}

/// Which side each border half-edge of the root mesh belongs to.
struct RootBorder<'a> {
    surface: &'a LoopSurface,
    /// By half-edge: its side, and its step along it.
    steps: Vec<Option<(usize, u64)>>,
}

impl<'a> RootBorder<'a> {
    fn new(surface: &'a LoopSurface) -> Self {
        let mut steps = vec![None; 3 * surface.mesh.face_count()];
        for (s, side) in surface.sides.iter().enumerate() {
            for (step, &v) in side.vertices[..side.edge_count()].iter().enumerate() {
                steps[surface.mesh.outgoing(v).index()] = Some((s, step as u64));
            }
        }
        Self { surface, steps }
    }

    /// The sides that pass the place `start` of the way along `root`, with its step at the level at
    /// which the place appears; `None` where it appears on no level.
    fn passing(&self, root: HalfedgeId, start: f64) -> Option<Vec<(usize, u32, u64)>> {
        let steps = start * f64::from(1_u32 << FINEST_LEVEL);
        if steps.fract() != 0.0 {
            return None;
        }
        let steps = steps as u64;
        let coarser = if steps == 0 { FINEST_LEVEL } else { steps.trailing_zeros().min(FINEST_LEVEL) };
        let level = FINEST_LEVEL - coarser;
        let own = self.steps[root.index()].map(|(s, step)| (s, level, (step << level) + (steps >> coarser)));
        let mut sides: Vec<_> = own.into_iter().collect();
        if steps == 0 {
            // The side that ends here passes too.
            let mesh = &self.surface.mesh;
            let before = mesh.ring(mesh.from(root)).last().map(HalfedgeId::previous);
            sides.extend(before.and_then(|h| self.steps[h.index()]).map(|(s, step)| (s, 0, step + 1)));
        }
        sides.sort_unstable();
        Some(sides)
    }
}

fn judge_sample(
    triangles: &Triangles,
    vertex: VertexId,
    border: &RootBorder<'_>,
    root: HalfedgeId,
    start: f64,
    found: &mut Vec<AuditFault>,
) {
    let at = triangles.positions[vertex.index()];
    let origin = triangles.origins[vertex.index()];
    let Some(sides) = border.passing(root, start) else {
        let weights = [1.0 - origin.st.x - origin.st.y, origin.st.x, origin.st.y];
        found.push(AuditFault::NoPlace { vertex, face: origin.face, weights });
        return;
    };
    // Where two given curves meet, the older one gives the bits.
    let given = |(s, ..): &(usize, u32, u64)| matches!(border.surface.sides[*s].border, Border::Given { .. });
    let sample = sides
        .into_iter()
        .filter(given)
        .find_map(|(s, level, step)| border_sample(&border.surface.sides[s], level, step));
    if let Some(sample) = sample
        && sample.to_array().map(f64::to_bits) != at.to_array().map(f64::to_bits)
    {
        found.push(AuditFault::OffCurve { vertex, at, sample });
    }
}
