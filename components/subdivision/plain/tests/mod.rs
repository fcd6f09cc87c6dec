pub(super) mod meshes;
mod oracle;

use std::sync::Arc;

use super::*;
use crate::mesh::FaceId;
use meshes::{Cage, Random, bipyramid, zoo};
use oracle::Naive;

fn surface(cage: &Cage) -> PlainLoop {
    let (points, faces, corners) = cage;
    let mesh = Connectivity::new(points.len(), faces).expect("a mesh of the tests is sound");
    let corners: Vec<VertexId> = corners.iter().map(|&c| VertexId(c)).collect();
    PlainLoop::new(Arc::new(mesh), points.clone(), &corners).expect("its corners are on its border")
}

fn naive((points, faces, corners): &Cage) -> Naive {
    Naive::new(points, faces, corners)
}

fn weights(s: f64, t: f64) -> [f64; 3] {
    [1.0 - s - t, s, t]
}

/// Every vertex of the mesh three steps finer has its limit where the surface says.
#[test]
fn dyadic_points_are_limits_of_subdivided_vertices() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let fine = naive(&cage).step().step().step();
        let limits = fine.limits();
        for (f, corners) in fine.faces.iter().enumerate() {
            let code = crate::subdivision::FaceCode(f as u64);
            for (v, (i, j)) in corners.iter().zip(code.corners(3)) {
                let at = SurfacePoint::new(code.root_face(3), f64::from(i) / 8.0, f64::from(j) / 8.0);
                let gap = surface.position(at).distance(limits[*v]);
                assert!(gap < 2e-15, "{name}: {gap:e} at {at:?}");
            }
        }
    }
}

/// Any point of any face of any mesh is where deep subdivision leads.
#[test]
fn random_points_agree_with_deep_subdivision() {
    for (name, cage) in zoo() {
        let (surface, naive) = (surface(&cage), naive(&cage));
        let mut random = Random(77);
        for _ in 0..30 {
            let (face, (s, t)) = (random.below(cage.1.len()), random.place());
            let gap = surface.position(SurfacePoint::new(FaceId::new(face), s, t)).distance(naive.deep(
                face,
                weights(s, t),
                26,
            ));
            assert!(gap < 1e-14, "{name}: {gap:e} at {s}, {t} of {face}");
        }
    }
}

/// Down to the last bit beside a vertex, at every valence.
#[test]
fn points_beside_irregular_vertices_are_exact() {
    for k in 3..=64 {
        let cage = bipyramid(k);
        let (surface, naive) = (surface(&cage), naive(&cage));
        for (exponent, a) in [(3, 0.3), (9, 0.8), (20, 0.55), (33, 0.1), (50, 0.6)] {
            let size = 2_f64.powi(-exponent);
            let (s, t) = (size * a, size * (1.0 - a));
            let gap = surface.position(SurfacePoint::new(FaceId(0), s, t)).distance(naive.deep(0, weights(s, t), 80));
            assert!(gap < 1e-14, "valence {k}, 2^-{exponent} away: {gap:e}");
        }
    }
}
