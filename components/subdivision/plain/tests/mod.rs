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

/// A band is what its three quarters are, each made from its own control points: beside corners of every
/// valence, inside and on borders.
#[test]
fn bands_are_made_of_their_quarters() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let reader = PatchReader::new(&surface, AsStored);
        let (mut pieces, mut bands, mut random) = (reader.scratch(), reader.no_bands(), Random(31));
        let faces = (0..cage.1.len()).map(FaceId::new).filter(|f| !surface.topology().is_regular(*f));
        for (face, corner) in faces.flat_map(|f| [0, 1, 2].map(|corner| (f, corner))) {
            reader.corner(face, corner, &mut pieces);
            reader.begin(face, corner, &mut bands);
            for depth in 0..7 {
                if depth > 0 {
                    pieces.descend();
                    bands.descend();
                }
                for quarter in 0..3 {
                    let (u, v) = random.place();
                    let [position, du, dv] = pieces.quarter(depth, quarter).with_derivatives(u, v);
                    let (a, b, scale) = in_band(quarter, u, v);
                    let [weight, by_c, by_a, by_b] = place::weigh_excess(a, b, (1.0 - a - b).max(0.0));
                    // Along the corner's own directions.
                    let jet = bands.band(depth, 0).with_derivatives(a, b, [weight, by_a - by_c, by_b - by_c]);
                    let size = 1e-14 * (1.0 + du.length() + dv.length());
                    let gap = jet.iter().zip([position, du * scale, dv * scale]).map(|(x, y)| x.distance(y));
                    let gap = gap.fold(0.0, f64::max);
                    assert!(gap < size, "{name}: {gap:e} in quarter {quarter} at depth {depth} of {face}, {corner}");
                }
            }
        }
    }
}

/// The place in a band of one in a quarter, and how fast coordinates run in the quarter.
fn in_band(quarter: u8, u: f64, v: f64) -> (f64, f64, f64) {
    match quarter {
        0 => (0.5 + 0.5 * u, 0.5 * v, 2.0),
        1 => (0.5 * u, 0.5 + 0.5 * v, 2.0),
        _ => (0.5 - 0.5 * u, 0.5 - 0.5 * v, -2.0),
    }
}

/// The first three bands alone are those of the whole row of them; there are none alone on borders.
#[test]
fn early_bands_are_the_first_of_all() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let reader = PatchReader::new(&surface, AsStored);
        let mut bands = reader.no_bands();
        let faces = (0..cage.1.len()).map(FaceId::new).filter(|f| !surface.topology().is_regular(*f));
        for (face, corner) in faces.flat_map(|f| [0, 1, 2].map(|corner| (f, corner))) {
            reader.begin(face, corner, &mut bands);
            bands.descend();
            bands.descend();
            let i = usize::from(corner);
            let v = surface.topology().mesh().face(face)[i];
            let early = [reader.first_band(face, i), reader.second_band(face, i), reader.third_band(face, i)];
            assert_eq!(early[0].is_some(), surface.topology().rule(v) == VertexRule::Interior, "{name}");
            let bits = |band: Band<DVec3>| format!("{band:?}");
            for (depth, band) in early.into_iter().enumerate().filter_map(|(i, band)| Some((i as u8, band?))) {
                assert_eq!(bits(band), bits(bands.band(depth, corner)), "{name}: {face}, {corner}");
            }
        }
    }
}
