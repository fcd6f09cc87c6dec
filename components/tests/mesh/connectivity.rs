use std::collections::BTreeSet;

use proptest::prelude::*;
use selvedge_components::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId, VertexId};

use crate::shapes::{
    Ends, Faces, TETRAHEDRON, directed_edges, grid, is_sound, neighbours, octahedron, undirected_edges,
};

fn build(vertex_count: usize, faces: &[[u32; 3]]) -> Connectivity {
    Connectivity::new(vertex_count, faces).expect("sound")
}

#[test]
fn euler_counts_handles_and_borders() {
    let euler = |(count, faces): (usize, Faces)| build(count, &faces).euler();
    assert_eq!(euler((4, TETRAHEDRON.to_vec())), 2);
    assert_eq!(euler((6, octahedron())), 2);
    assert_eq!(euler(grid(5, 7, Ends::Free, Ends::Free)), 1);
    assert_eq!(euler(grid(5, 7, Ends::Joined, Ends::Free)), 0);
    assert_eq!(euler(grid(5, 7, Ends::Joined, Ends::Joined)), 0);
}

#[test]
fn borders_are_walked_with_the_surface_on_the_left() {
    let (count, faces) = grid(2, 1, Ends::Free, Ends::Free);
    let loops = build(count, &faces).border_loops();
    assert_eq!(loops, [[0, 1, 2, 5, 4, 3].map(VertexId)]);

    let (count, faces) = grid(3, 1, Ends::Joined, Ends::Free);
    let loops = build(count, &faces).border_loops();
    assert_eq!(loops, [[0, 1, 2].map(VertexId), [3, 5, 4].map(VertexId)]);

    let (count, faces) = grid(3, 3, Ends::Joined, Ends::Joined);
    assert_eq!(build(count, &faces).border_loops(), Vec::<Vec<VertexId>>::new());
}

#[test]
fn one_triangle_is_all_border() {
    let mesh = build(3, &[[2, 0, 1]]);
    assert_eq!(mesh.border_loops(), [[0, 1, 2].map(VertexId)]);
    assert_eq!((mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), (3, 3, 1));
    let around: Vec<VertexId> = mesh.neighbours(VertexId(0)).collect();
    assert_eq!(around, [VertexId(1), VertexId(2)]);
    check(3, &[[2, 0, 1]]);
}

#[test]
fn the_inside_of_a_regular_grid_has_valence_six() {
    let (count, faces) = grid(6, 6, Ends::Joined, Ends::Joined);
    let mesh = build(count, &faces);
    assert!((0..count).all(|v| mesh.valence(VertexId::new(v)) == 6));
    let (count, faces) = grid(6, 6, Ends::Free, Ends::Free);
    let mesh = build(count, &faces);
    let corners = [(0, 3), (6, 2), (42, 2), (48, 3)];
    assert!(corners.iter().all(|&(v, k)| mesh.valence(VertexId(v)) == k));
    assert_eq!((mesh.valence(VertexId(3)), mesh.valence(VertexId(24))), (4, 6));
}

#[test]
fn a_fan_of_high_valence_is_walked_whole() {
    let valence = 10_000;
    let faces: Faces = (0..valence).map(|i| [0, 1 + i, 1 + (i + 1) % valence]).collect();
    let mesh = build(1 + valence as usize, &faces);
    assert_eq!(mesh.valence(VertexId(0)), valence);
    let ring: Vec<VertexId> = mesh.neighbours(VertexId(0)).collect();
    assert_eq!(ring, (1..=valence).map(VertexId).collect::<Vec<_>>());
}

#[test]
fn edges_are_numbered_as_the_faces_meet_them() {
    let mesh = build(4, &[[0, 1, 2], [2, 1, 3]]);
    let edges: Vec<EdgeId> = (0..6).map(|h| mesh.edge(HalfedgeId(h))).collect();
    assert_eq!(edges, [0, 1, 2, 1, 3, 4].map(EdgeId));
    assert_eq!(mesh.halfedge(EdgeId(1)), HalfedgeId(1));
    assert_eq!(mesh.halfedge(EdgeId(3)), HalfedgeId(4));
}

/// A sound mesh made from a plain one by random operations that keep it one, renamed at random.
fn sound_mesh() -> impl Strategy<Value = (usize, Faces)> {
    let operation = (0..3_u8, any::<u32>(), any::<u32>());
    (0..4_usize, prop::collection::vec(operation, 0..60), any::<u64>()).prop_map(|(base, operations, seed)| {
        let (mut count, mut faces) = match base {
            0 => (6, octahedron()),
            1 => grid(3, 3, Ends::Joined, Ends::Joined),
            2 => grid(4, 3, Ends::Free, Ends::Free),
            _ => grid(4, 2, Ends::Joined, Ends::Free),
        };
        for (kind, at, side) in operations {
            match kind {
                0 => split_face(&mut count, &mut faces, at),
                1 => turn_edge(count, &mut faces, at, side),
                _ => remove_face(count, &mut faces, at),
            }
        }
        rename(count, &mut faces, seed);
        (count, faces)
    })
}

fn split_face(count: &mut usize, faces: &mut Faces, at: u32) {
    let f = at as usize % faces.len();
    let ([a, b, c], new) = (faces[f], *count as u32);
    faces[f] = [a, b, new];
    faces.extend([[b, c, new], [c, a, new]]);
    *count += 1;
}

/// Turns an edge inside the two triangles along it, where that leaves the mesh sound.
fn turn_edge(count: usize, faces: &mut Faces, at: u32, side: u32) {
    let (f, i) = (at as usize % faces.len(), side as usize % 3);
    let [a, b, c] = [faces[f][i], faces[f][(i + 1) % 3], faces[f][(i + 2) % 3]];
    let Some(g) = faces.iter().position(|face| directed_edges(&[*face]).any(|edge| edge == (b, a))) else { return };
    let d = faces[g].into_iter().find(|&corner| corner != a && corner != b).unwrap();
    let before = faces.clone();
    (faces[f], faces[g]) = ([c, a, d], [c, d, b]);
    if !is_sound(count, faces) {
        *faces = before;
    }
}

fn remove_face(count: usize, faces: &mut Faces, at: u32) {
    let f = at as usize % faces.len();
    let face = faces.swap_remove(f);
    if !is_sound(count, faces) {
        faces.push(face);
    }
}

/// Other names for the vertices, another order of the faces, another first corner for each.
fn rename(count: usize, faces: &mut Faces, seed: u64) {
    let mut state = seed | 1;
    let mut below = |n: usize| {
        // Knuth's multiplier for a 64-bit linear congruential generator; its high bits are good.
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % n
    };
    let mut names: Vec<u32> = (0..count as u32).collect();
    for v in (1..count).rev() {
        names.swap(v, below(v + 1));
    }
    for f in (1..faces.len()).rev() {
        faces.swap(f, below(f + 1));
    }
    for face in faces {
        *face = face.map(|v| names[v as usize]);
        face.rotate_left(below(3));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 400, ..ProptestConfig::default() })]

    #[test]
    fn every_promise_holds_on_any_sound_mesh((count, faces) in sound_mesh()) {
        prop_assert!(is_sound(count, &faces));
        check(count, &faces);
    }

    /// Soups of few vertices: never a panic, and only sound ones get through.
    #[test]
    fn nothing_unsound_gets_through(faces in prop::collection::vec(prop::array::uniform3(0..7_u32), 0..14)) {
        prop_assert_eq!(Connectivity::new(7, &faces).is_ok(), is_sound(7, &faces));
        if let Ok(mesh) = Connectivity::new(6, &faces) {
            prop_assert_eq!(mesh.vertex_count(), 6);
        }
    }
}

/// Everything that `Connectivity` promises, against plain looks at the faces.
fn check(count: usize, faces: &[[u32; 3]]) {
    let mesh = build(count, faces);
    assert_eq!((mesh.vertex_count(), mesh.face_count()), (count, faces.len()));
    check_halfedges(&mesh, faces);
    check_edges(&mesh, faces);
    check_rings(&mesh, faces);
    check_borders(&mesh, faces);
}

fn check_halfedges(mesh: &Connectivity, faces: &[[u32; 3]]) {
    let directed: BTreeSet<(u32, u32)> = directed_edges(faces).collect();
    for (h, (a, b)) in directed_edges(faces).enumerate() {
        let h = HalfedgeId::new(h);
        assert_eq!((mesh.from(h), mesh.to(h)), (VertexId(a), VertexId(b)));
        assert_eq!(h, HalfedgeId::of(h.face(), h.corner()));
        assert_eq!((h.next().previous(), h.next().next().next()), (h, h));
        assert_eq!(mesh.opposite(h), mesh.to(h.next()));
        assert_eq!(mesh.twin(h).is_some(), directed.contains(&(b, a)));
        if let Some(twin) = mesh.twin(h) {
            assert_eq!((mesh.from(twin), mesh.to(twin)), (VertexId(b), VertexId(a)));
            assert_eq!((mesh.twin(twin), mesh.edge(twin)), (Some(h), mesh.edge(h)));
        }
    }
}

fn check_edges(mesh: &Connectivity, faces: &[[u32; 3]]) {
    let edges = undirected_edges(faces);
    assert_eq!(mesh.edge_count(), edges.len());
    assert_eq!(mesh.euler(), mesh.vertex_count() as i64 - edges.len() as i64 + faces.len() as i64);
    let mut last = None;
    for e in (0..edges.len()).map(EdgeId::new) {
        let h = mesh.halfedge(e);
        assert_eq!(mesh.edge(h), e);
        assert!(mesh.twin(h).is_none_or(|twin| twin > h), "the first of the two stands for the edge");
        assert!(last < Some(h), "edges are numbered in the order of their first half-edges");
        last = Some(h);
    }
}

fn check_rings(mesh: &Connectivity, faces: &[[u32; 3]]) {
    let around = neighbours(mesh.vertex_count(), faces);
    let mut total = 0;
    for v in (0..mesh.vertex_count()).map(VertexId::new) {
        let ring: Vec<HalfedgeId> = mesh.ring(v).collect();
        assert!(ring.iter().all(|&h| mesh.from(h) == v));
        let met: BTreeSet<FaceId> = ring.iter().map(|h| h.face()).collect();
        let there = (0..faces.len()).filter(|&f| faces[f].contains(&v.0)).map(FaceId::new);
        assert_eq!(met, there.collect(), "each face at the vertex");
        assert_eq!(met.len(), ring.len(), "and each once");
        // Counter-clockwise: the edge by which a face is left is the one by which the next is entered.
        for pair in ring.windows(2) {
            assert_eq!(mesh.from(pair[0].previous()), mesh.to(pair[1]));
        }
        let listed: Vec<u32> = mesh.neighbours(v).map(|n| n.0).collect();
        assert_eq!(listed.iter().copied().collect::<BTreeSet<u32>>(), around[v.index()]);
        assert_eq!(listed.len(), mesh.valence(v) as usize, "no neighbour twice");
        assert_eq!(mesh.valence(v) as usize, ring.len() + usize::from(mesh.is_border(v)));
        if mesh.is_border(v) {
            assert_eq!(mesh.twin(mesh.outgoing(v)), None);
            assert_eq!(mesh.last_border_neighbour(v).map(|n| n.0), listed.last().copied());
        } else {
            assert_eq!(mesh.last_border_neighbour(v), None);
            assert_eq!(Some(mesh.outgoing(v)), ring.iter().copied().min(), "the smallest id comes first");
        }
        total += listed.len();
    }
    assert_eq!(total, 2 * mesh.edge_count());
}

fn check_borders(mesh: &Connectivity, faces: &[[u32; 3]]) {
    let directed: BTreeSet<(u32, u32)> = directed_edges(faces).collect();
    let open: BTreeSet<(u32, u32)> = directed.iter().copied().filter(|&(a, b)| !directed.contains(&(b, a))).collect();
    let loops = mesh.border_loops();
    let walked: Vec<(u32, u32)> =
        loops.iter().flat_map(|l| (0..l.len()).map(|i| (l[i].0, l[(i + 1) % l.len()].0))).collect();
    assert_eq!(walked.iter().copied().collect::<BTreeSet<_>>(), open);
    assert_eq!(walked.len(), open.len(), "each border edge once");
    assert!(loops.iter().all(|l| l[0] == *l.iter().min().unwrap()));
    assert!(loops.is_sorted_by_key(|l| l[0]));
    let on_border: BTreeSet<u32> = open.iter().flat_map(|&(a, b)| [a, b]).collect();
    for v in 0..mesh.vertex_count() as u32 {
        assert_eq!(mesh.is_border(VertexId(v)), on_border.contains(&v));
    }
}
