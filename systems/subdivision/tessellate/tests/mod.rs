use crate::subdivision::test_meshes as meshes;

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::evaluate::Evaluate;
use selvedge_components::mesh::{FaceId, VertexId};

use super::*;
use meshes::{Cage, zoo};

fn surface((points, faces, corners): &Cage) -> PlainLoop {
    let mesh = Connectivity::new(points.len(), faces).expect("a mesh of the tests is sound");
    let corners: Vec<VertexId> = corners.iter().map(|&c| VertexId(c)).collect();
    PlainLoop::new(Arc::new(mesh), points.clone(), &corners).expect("its corners are on its border")
}

fn bits(points: &[DVec3]) -> Vec<[u64; 3]> {
    points.iter().map(|p| p.to_array().map(f64::to_bits)).collect()
}

/// Points and normals stand where their origins say, on every kind of mesh, at every level.
#[test]
fn vertices_lie_on_the_surface_at_their_origins() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let mesh = surface.topology().mesh();
        for level in 0..6 {
            let tessellator = Tessellator::new(mesh, level).expect("small");
            let positions = tessellator.positions(&surface).expect("the same mesh");
            let normals = tessellator.normals(&surface).expect("the same mesh");
            let origins = origins(mesh, tessellator.lattice());
            assert_eq!((positions.len(), normals.len()), (origins.len(), origins.len()));
            for ((&p, &n), &at) in positions.iter().zip(&normals).zip(&origins) {
                let gap = p.distance(surface.position(at));
                assert!(gap < 2e-15, "{name}, level {level}: {gap:e} at {at:?}");
                let turn = n.distance(surface.normal(at));
                assert!(turn < 1e-9, "{name}, level {level}: normal off by {turn:e} at {at:?}");
            }
        }
    }
}

/// The triangles are the root mesh again, finer: sound, of its shape, and of its orientation.
#[test]
fn triangles_close_up() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let mesh = surface.topology().mesh();
        for level in 0..4 {
            let lattice = *Tessellator::new(mesh, level).expect("small").lattice();
            let fine = Connectivity::new(lattice.vertex_count(), &triangles(mesh, &lattice)).expect("a sound mesh");
            assert_eq!(fine.euler(), mesh.euler(), "{name}, level {level}");
            let lengths = |m: &Connectivity| m.border_loops().iter().map(Vec::len).sum::<usize>();
            assert_eq!(lengths(&fine), lengths(mesh) << level, "{name}, level {level}");
            assert_eq!(fine.face_count(), mesh.face_count() << (2 * level));
        }
    }
}

/// Triangles of one face keep their corners in it: both, by the lattice's own addresses.
#[test]
fn triangles_follow_the_order_that_is_documented() {
    use selvedge_components::subdivision::Address;
    let cage = meshes::scrambled(3, 20, 5);
    let surface = surface(&cage);
    let mesh = surface.topology().mesh();
    for level in 0..4 {
        let lattice = Lattice::new(mesh, level).expect("small");
        let n = 1 << level;
        let mut expected = Vec::new();
        for f in 0..mesh.face_count() {
            let at = |i, j| lattice.number(Address::of(mesh, level, FaceId::new(f), i, j));
            for i in 0..n {
                for j in 0..n - i {
                    expected.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                    if i + j + 1 < n {
                        expected.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                    }
                }
            }
        }
        assert_eq!(triangles(mesh, &lattice), expected, "level {level}");
    }
}

/// What is wanted in two halves is what is wanted at once, and nothing else is touched.
#[test]
fn parts_make_the_whole() {
    for (name, cage) in zoo() {
        let surface = surface(&cage);
        let mesh = surface.topology().mesh();
        let tessellator = Tessellator::new(mesh, 3).expect("small");
        let whole = tessellator.positions(&surface).expect("the same mesh");
        let wanted: Vec<bool> = (0..mesh.face_count()).map(|f| f % 3 == 1).collect();
        let others: Vec<bool> = wanted.iter().map(|w| !w).collect();
        let mut out = vec![DVec3::INFINITY; whole.len()];
        tessellator.write_positions(&surface, Faces::Only(&wanted), &mut out).expect("the same mesh");
        for (p, q) in out.iter().zip(&whole) {
            assert!(p.x == f64::INFINITY || p.distance(*q) < 2e-15, "{name}");
        }
        let untouched = out.iter().filter(|p| p.x == f64::INFINITY).count();
        tessellator.write_positions(&surface, Faces::Only(&others), &mut out).expect("the same mesh");
        assert!(out.iter().zip(&whole).all(|(p, q)| p.distance(*q) < 2e-15), "{name}");
        assert!(untouched > 0 || mesh.face_count() < 3, "{name}");
    }
}

/// Threads, and points that move and come back, leave no trace in the bits.
#[test]
#[cfg(feature = "parallel")]
fn bits_do_not_depend_on_threads() {
    let cage = meshes::scrambled(5, 80, 0);
    let surface = surface(&cage);
    let tessellator = Tessellator::new(surface.topology().mesh(), 4).expect("small");
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| {
            let positions = tessellator.positions(&surface).expect("the same mesh");
            (bits(&positions), bits(&tessellator.normals(&surface).expect("the same mesh")))
        })
    };
    let one = run(1);
    assert!((2..=4).all(|threads| run(threads) == one));
}

/// Wrong sizes are refused before anything is written.
#[test]
fn wrong_sizes_are_errors() {
    let surface = surface(&meshes::bipyramid(5));
    let tessellator = Tessellator::new(surface.topology().mesh(), 2).expect("small");
    let needed = tessellator.lattice().vertex_count();
    let mut short = vec![DVec3::ZERO; needed - 1];
    let error = tessellator.write_positions(&surface, Faces::All, &mut short);
    assert_eq!(error, Err(TessellateError::Length { level: 2, given: needed - 1, needed }));
    let mut out = vec![DVec3::ZERO; needed];
    let error = tessellator.write_positions(&surface, Faces::Only(&[true]), &mut out);
    assert_eq!(error, Err(TessellateError::Surface { given: 1, expected: 10 }));
}
