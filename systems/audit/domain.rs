//! Where triangles lie on the root mesh.

use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::LoopSurface;
use selvedge_components::triangles::Triangles;

use super::AuditFault;

/// A triangle on its root face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The root face.
    pub face: FaceId,
    /// For each corner of the triangle, the weights of the corners of the face.
    pub weights: [[f64; 3]; 3],
}

impl Place {
    /// The place where the triangle's corners weigh `b`.
    pub fn at(&self, b: [f64; 3]) -> SurfacePoint {
        let weigh = |c: usize| b[0] * self.weights[0][c] + b[1] * self.weights[1][c] + b[2] * self.weights[2][c];
        SurfacePoint::new(self.face, weigh(1), weigh(2))
    }

    /// Twice the signed area in (s, t).
    fn area(&self) -> f64 {
        let [a, b, c] = self.weights;
        (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1])
    }
}

/// The place of every triangle; `None`, with the reasons, if one has none.
pub fn places(triangles: &Triangles, surface: &LoopSurface, found: &mut Vec<AuditFault>) -> Option<Vec<Place>> {
    let before = found.len();
    let mut seen = Vec::with_capacity(triangles.origins.len());
    for (v, &origin) in triangles.origins.iter().enumerate() {
        let on = on_faces(surface, origin);
        if on.is_empty() {
            let weights = weights_of(origin);
            found.push(AuditFault::NoPlace { vertex: VertexId::new(v), face: origin.face, weights });
        }
        seen.push(on);
    }
    let mut places = Vec::with_capacity(triangles.triangles.len());
    for (triangle, corners) in triangles.triangles.iter().enumerate() {
        let [a, b, c] = corners.map(|v| &seen[v as usize]);
        let on = |list: &[(FaceId, [f64; 3])], face| list.iter().find(|on| on.0 == face).map(|on| on.1);
        let common = a.iter().find_map(|&(face, w)| Some(Place { face, weights: [w, on(b, face)?, on(c, face)?] }));
        match common {
            Some(place) => places.push(place),
            None => found.push(AuditFault::Torn { triangle }),
        }
    }
    (found.len() == before).then_some(places)
}

/// Every face that a point lies on, with the weights of its corners: one inside a face, two on an edge,
/// a fan at a vertex.
fn on_faces(surface: &LoopSurface, origin: SurfacePoint) -> Vec<(FaceId, [f64; 3])> {
    let (mesh, weights) = (&surface.mesh, weights_of(origin));
    if origin.face.index() >= mesh.face_count() || !weights.iter().all(|w| (0.0..=1.0).contains(w)) {
        return Vec::new();
    }
    if let Some(corner) = weights.iter().position(|&w| w == 1.0) {
        let v = mesh.face(origin.face)[corner];
        return mesh.ring(v).map(|h| (h.face(), one_at(h.corner()))).collect();
    }
    let mut on = vec![(origin.face, weights)];
    if let Some(corner) = weights.iter().position(|&w| w == 0.0) {
        let h = HalfedgeId::of(origin.face, (corner + 1) % 3);
        if let Some(twin) = mesh.twin(h) {
            let mut across = [0.0; 3];
            across[(twin.corner() + 1) % 3] = weights[h.corner()];
            across[twin.corner()] = weights[(h.corner() + 1) % 3];
            on.push((twin.face(), across));
        }
    }
    on
}

fn weights_of(origin: SurfacePoint) -> [f64; 3] {
    [1.0 - origin.st.x - origin.st.y, origin.st.x, origin.st.y]
}

fn one_at(corner: usize) -> [f64; 3] {
    core::array::from_fn(|c| if c == corner { 1.0 } else { 0.0 })
}

/// Every triangle must lie the right way up on its face, and those of a face must fill it. Places are
/// multiples of a power of two, so the sums are exact.
pub fn judge_cover(triangles: &Triangles, places: &[Place], surface: &LoopSurface, found: &mut Vec<AuditFault>) {
    let mut covered = vec![0.0; surface.mesh.face_count()];
    for (triangle, place) in places.iter().enumerate() {
        let area = place.area();
        if area.is_nan() || area <= 0.0 {
            found.push(AuditFault::Reversed { triangle, area });
        }
        covered[place.face.index()] += area;
    }
    debug_assert_eq!(places.len(), triangles.triangles.len());
    for (face, share) in covered.into_iter().enumerate().filter(|(_, share)| *share != 1.0) {
        found.push(AuditFault::Cover { face: FaceId::new(face), share });
    }
}
