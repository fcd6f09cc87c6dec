use glam::DVec3;
use selvedge_components::mesh::{Connectivity, FaceId, Fault, VertexId, faults, position_faults};

use crate::shapes::{Ends, TETRAHEDRON, grid, is_sound, moebius, octahedron};

fn v(id: u32) -> VertexId {
    VertexId(id)
}

fn f(id: u32) -> FaceId {
    FaceId(id)
}

#[test]
fn an_oriented_manifold_has_no_faults() {
    assert_eq!(faults(4, &TETRAHEDRON), []);
    assert_eq!(faults(6, &octahedron()), []);
    for (across, along) in [(Ends::Free, Ends::Free), (Ends::Free, Ends::Joined), (Ends::Joined, Ends::Joined)] {
        let (count, faces) = grid(4, 5, across, along);
        assert_eq!(faults(count, &faces), []);
    }
}

#[test]
fn no_faces_at_all_is_a_fault() {
    assert_eq!(faults(0, &[]), [Fault::Empty]);
    assert_eq!(faults(3, &[]), [Fault::Empty]);
}

#[test]
fn more_vertices_than_ids_are_refused_before_anything_is_allocated() {
    let found = faults(usize::MAX, &TETRAHEDRON);
    assert_eq!(found, [Fault::TooMany { what: "vertices", count: usize::MAX, limit: u32::MAX as usize - 1 }]);
}

fn flat(face: u32, vertex: u32) -> Fault {
    Fault::DegenerateFace { face: f(face), vertex: v(vertex) }
}

/// In the order of the enum, each kind by face; edges and vertices are not judged.
#[test]
fn every_face_that_is_wrong_by_itself_is_named() {
    let faces = [[0, 1, 1], [0, 1, 9], [u32::MAX, 1, 2], [2, 0, 2], [1, 1, 1]];
    let out = |face, index| Fault::IndexOutOfRange { face: f(face), index, vertex_count: 4 };
    assert_eq!(faults(4, &faces), [out(1, 9), out(2, u32::MAX), flat(0, 1), flat(3, 2), flat(4, 1)]);
}

/// A face that names a vertex twice has no area and no place in a fan: the surface is what the
/// others make of it. It still counts as a use of its vertices.
#[test]
fn degenerate_faces_are_named_and_set_aside() {
    let mut faces = TETRAHEDRON.to_vec();
    faces.insert(0, [0, 0, 1]);
    faces.extend([[2, 4, 2], [2, 4, 2]]);
    assert_eq!(faults(5, &faces), [flat(0, 0), flat(5, 2), flat(6, 2)]);
    faces.push([0, 1, 5]);
    let three = Fault::NonManifoldEdge { ends: [v(0), v(1)], faces: [1, 3, 7].map(f).to_vec() };
    assert_eq!(faults(6, &faces), [three, flat(0, 0), flat(5, 2), flat(6, 2)]);
}

/// A repeat is a repeat in whatever order its corners come, and hides no other fault.
#[test]
fn repeated_faces_are_named_and_set_aside() {
    let mut faces = TETRAHEDRON.to_vec();
    faces.insert(1, [1, 2, 0]);
    faces.push([2, 1, 0]);
    let repeat = |second| Fault::DuplicateFace { first: f(0), second: f(second) };
    assert_eq!(faults(5, &faces), [repeat(1), repeat(5), Fault::UnusedVertex { vertex: v(4) }]);
}

/// The faces of the other faults keep their own numbers when repeats are set aside.
#[test]
fn setting_repeats_aside_renumbers_nothing() {
    let faces = [[0, 1, 2], [1, 2, 0], [1, 0, 3], [0, 1, 4]];
    let found = faults(5, &faces);
    let ends = [v(0), v(1)];
    assert_eq!(
        found,
        [
            Fault::NonManifoldEdge { ends, faces: vec![f(0), f(2), f(3)] },
            Fault::DuplicateFace { first: f(0), second: f(1) },
        ]
    );
}

#[test]
fn an_edge_of_three_faces_is_named_with_all_of_them() {
    let faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    assert_eq!(faults(5, &faces), [Fault::NonManifoldEdge { ends: [v(0), v(1)], faces: vec![f(0), f(1), f(2)] }]);
}

#[test]
fn faces_that_wind_against_each_other_are_named_with_their_edge() {
    let mut faces = TETRAHEDRON.to_vec();
    faces[2].swap(0, 1);
    let against = |a, b, face| Fault::InconsistentWinding { ends: [v(a), v(b)], faces: face };
    assert_eq!(
        faults(4, &faces),
        [against(0, 1, [f(0), f(2)]), against(0, 3, [f(1), f(2)]), against(1, 3, [f(2), f(3)])]
    );
}

/// A Moebius strip has one seam at which the windings disagree, wherever it is put.
#[test]
fn a_moebius_strip_never_winds_consistently() {
    for length in 3..12 {
        let (count, faces) = moebius(length);
        let found = faults(count, &faces);
        assert!(matches!(found[..], [Fault::InconsistentWinding { .. }]), "{found:?}");
    }
}

#[test]
fn two_solids_that_touch_at_a_vertex_have_two_fans_there() {
    let other = TETRAHEDRON.map(|face| face.map(|c| if c == 0 { 0 } else { c + 3 }));
    let faces = [TETRAHEDRON, other].concat();
    assert_eq!(faults(7, &faces), [Fault::NonManifoldVertex { vertex: v(0), fans: 2 }]);
}

#[test]
fn two_triangles_that_touch_at_a_corner_have_two_fans_there() {
    assert_eq!(faults(5, &[[0, 1, 2], [2, 3, 4]]), [Fault::NonManifoldVertex { vertex: v(2), fans: 2 }]);
}

#[test]
fn every_unused_vertex_is_named() {
    let shifted = TETRAHEDRON.map(|face| face.map(|c| c + 1));
    let unused = |vertex| Fault::UnusedVertex { vertex: v(vertex) };
    assert_eq!(faults(7, &shifted), [unused(0), unused(5), unused(6)]);
}

#[test]
fn every_control_point_that_is_not_finite_is_named() {
    let good = DVec3::new(f64::MAX, f64::MIN_POSITIVE, -0.0);
    let bad = [DVec3::new(0.0, f64::NAN, 0.0), DVec3::new(f64::INFINITY, 0.0, 0.0), DVec3::NEG_INFINITY];
    let found = position_faults(&[good, bad[0], good, bad[1], bad[2]]);
    let named: Vec<VertexId> = found
        .iter()
        .map(|fault| match fault {
            Fault::NotFinite { vertex, .. } => *vertex,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(named, [v(1), v(3), v(4)]);
    assert_eq!(position_faults(&[good]), []);
}

#[test]
fn a_fault_says_what_and_where() {
    let faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    assert_eq!(faults(5, &faces)[0].to_string(), "edge 0-1 is non-manifold: 3 faces share it");
    let said = faults(4, &[[0, 1, 9]])[0].to_string();
    assert_eq!(said, "face 0 names vertex 9, but there are 4 vertices");
}

#[test]
fn faces_of_a_fault_can_be_renamed() {
    let faces = [[0, 1, 2], [1, 0, 3], [0, 1, 4]];
    let [fault] = faults(5, &faces).try_into().unwrap();
    assert_eq!(
        fault.rename_faces(|face| f(10 * face.0)),
        Fault::NonManifoldEdge { ends: [v(0), v(1)], faces: vec![f(0), f(10), f(20)] }
    );
}

/// Every set of oriented triangles over five vertices, all 2^20 of them: a fault is found exactly
/// where the definition of an oriented manifold does not hold, and `Connectivity` agrees.
#[test]
fn faults_are_exactly_what_the_definition_forbids() {
    let triangles = oriented_triangles(5);
    assert_eq!(triangles.len(), 20);
    let mut sound = 0;
    let mut faces = Vec::new();
    for chosen in 0_u32..1 << 20 {
        faces.clear();
        faces.extend(triangles.iter().enumerate().filter(|&(i, _)| chosen >> i & 1 == 1).map(|(_, &t)| t));
        let found = faults(5, &faces);
        // The definition is slow to judge, and a doubled edge is seen from the count alone: of five
        // vertices there are ten edges, so ten faces at most.
        let expected = faces.len() <= 10 && is_sound(5, &faces);
        assert_eq!(found.is_empty(), expected, "{faces:?}: {found:?}");
        sound += u32::from(expected);
        if expected {
            assert!(Connectivity::new(5, &faces).is_ok());
        }
    }
    assert!(sound > 100, "only {sound} sound meshes were met");
}

/// Each oriented triangle once, begun at its smallest corner.
fn oriented_triangles(vertex_count: u32) -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    for a in 0..vertex_count {
        for b in a + 1..vertex_count {
            for c in b + 1..vertex_count {
                all.extend([[a, b, c], [a, c, b]]);
            }
        }
    }
    all
}
