use selvedge_components::mesh::{FaceId, Fault, VertexId, faults, orient};

use crate::shapes::{Ends, TETRAHEDRON, directed_edges, grid, moebius, undirected_edges};

fn reversed(mut face: [u32; 3]) -> [u32; 3] {
    face.swap(1, 2);
    face
}

#[test]
fn windings_that_agree_are_left_alone() {
    let (count, faces) = grid(3, 4, Ends::Joined, Ends::Free);
    let out = orient(count, &faces).unwrap();
    assert_eq!(out.faces, faces);
    assert_eq!(out.flipped, []);
}

/// Any few faces of a torus turned round are found again, each of them and no other.
#[test]
fn the_minority_is_turned_and_named() {
    let (count, faces) = grid(4, 4, Ends::Joined, Ends::Joined);
    for step in [3, 5, 7, 31] {
        let mut spoiled = faces.clone();
        let wrong: Vec<FaceId> = (0..faces.len()).step_by(step).map(FaceId::new).collect();
        for &f in &wrong {
            spoiled[f.index()] = reversed(spoiled[f.index()]);
        }
        let out = orient(count, &spoiled).unwrap();
        assert_eq!(out.flipped, wrong);
        assert_eq!(out.faces, faces);
    }
}

#[test]
fn on_a_tie_the_first_face_stays() {
    let out = orient(4, &[[0, 1, 2], [0, 1, 3]]).unwrap();
    assert_eq!(out.flipped, [FaceId(1)]);
    assert_eq!(out.faces, [[0, 1, 2], [0, 3, 1]]);
}

#[test]
fn components_are_judged_one_by_one() {
    let far = TETRAHEDRON.map(|face| face.map(|c| c + 4));
    let mut faces = [TETRAHEDRON, far].concat();
    for f in [1, 4, 5, 6] {
        faces[f] = reversed(faces[f]);
    }
    let out = orient(8, &faces).unwrap();
    assert_eq!(out.flipped, [1, 7].map(FaceId));
    assert_eq!(faults(8, &out.faces), []);
}

#[test]
fn each_component_that_cannot_be_oriented_is_named_at_an_edge_of_it() {
    let (count, strip) = moebius(5);
    let far: Vec<[u32; 3]> = strip.iter().map(|face| face.map(|c| c + count as u32 + 4)).collect();
    let between = TETRAHEDRON.map(|face| face.map(|c| c + count as u32));
    let faces = [&strip[..], &between, &far].concat();
    let found = orient(2 * count + 4, &faces).unwrap_err();
    let places: Vec<(FaceId, [VertexId; 2])> = found
        .iter()
        .map(|fault| match fault {
            Fault::NonOrientable { face, ends } => (*face, *ends),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(places.iter().map(|p| p.0).collect::<Vec<_>>(), [FaceId(0), FaceId::new(strip.len() + 4)]);
    let edges = undirected_edges(&faces);
    for (_, [a, b]) in places {
        assert_eq!(edges[&(a.0, b.0)], 2, "edge {a}-{b}");
    }
}

#[test]
fn faces_that_are_wrong_by_themselves_come_first() {
    assert_eq!(orient(3, &[[0, 1, 7]]).unwrap_err(), faults(3, &[[0, 1, 7]]));
    let twice = [[0, 1, 2], [2, 1, 0]];
    assert_eq!(orient(3, &twice).unwrap_err(), faults(3, &twice));
    assert_eq!(orient(0, &[]).unwrap_err(), [Fault::Empty]);
}

/// Every set of triangles over five vertices in every choice of windings, all 3^10 of them:
/// `orient` succeeds exactly where some choice of windings agrees across every edge of two faces,
/// and turns as few faces of each component as any such choice would.
#[test]
fn orienting_is_possible_and_least_exactly_when_exhaustion_says_so() {
    let triangles = triangles(5);
    let mut answers = [0, 0];
    for code in 1..3_u32.pow(10) {
        let mut faces = Vec::new();
        let mut rest = code;
        for &t in &triangles {
            match rest % 3 {
                0 => {}
                1 => faces.push(t),
                _ => faces.push(reversed(t)),
            }
            rest /= 3;
        }
        let best = least_turns(&faces);
        match orient(5, &faces) {
            Ok(out) => {
                assert_eq!(Some(out.flipped.len() as u32), best, "{faces:?}");
                assert!(agrees(&out.faces, 0), "{faces:?}");
                answers[0] += 1;
            }
            Err(_) => {
                assert_eq!(best, None, "{faces:?}");
                answers[1] += 1;
            }
        }
    }
    // There are 12 Moebius strips of five labelled vertices, each in 2^5 windings; no other set of
    // these triangles keeps two faces to an edge around a reversing loop.
    assert_eq!(answers[1], 12 * 32);
}

fn triangles(vertex_count: u32) -> Vec<[u32; 3]> {
    let mut all = Vec::new();
    for a in 0..vertex_count {
        for b in a + 1..vertex_count {
            all.extend((b + 1..vertex_count).map(|c| [a, b, c]));
        }
    }
    all
}

/// The fewest faces to turn so that windings agree across every edge of two faces, by trying all.
fn least_turns(faces: &[[u32; 3]]) -> Option<u32> {
    (0..1_u32 << faces.len()).filter(|&turned| agrees(faces, turned)).map(u32::count_ones).min()
}

/// Do the windings agree across every edge of two faces once the faces in the set are turned?
fn agrees(faces: &[[u32; 3]], turned: u32) -> bool {
    // Per undirected edge of five vertices: how many faces, and how many run towards the larger end.
    let mut counts = [[0_u8; 2]; 25];
    for (f, &face) in faces.iter().enumerate() {
        let face = if turned >> f & 1 == 1 { reversed(face) } else { face };
        for (a, b) in directed_edges(&[face]) {
            let count = &mut counts[(5 * a.min(b) + a.max(b)) as usize];
            count[0] += 1;
            count[1] += u8::from(a < b);
        }
    }
    counts.iter().all(|&[faces, up]| faces != 2 || up == 1)
}
