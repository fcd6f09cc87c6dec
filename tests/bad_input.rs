//! Whatever a file holds, it gives a cage or a typed error that names the place, and takes no more work
//! than its bytes are worth.

use std::fs;
use std::path::{Path, PathBuf};

use selvedge::io::obj::{self, ObjError};
use selvedge::io::tags::Tags;
use selvedge::io::{Cage, CageError, Limits, Place, PlacedFault, Polygons, ReadError, read_cage};
use selvedge_components::mesh::{Connectivity, FaceId, Fault, VertexId};

use random::Draw;

#[cfg(feature = "gltf")]
#[path = "support/glb.rs"]
mod by_hand;
#[path = "support/random.rs"]
mod random;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn refused(name: &str) -> Vec<PlacedFault> {
    match read_cage(&data(name), &Limits::default()) {
        Err(ReadError::Cage { why: CageError::Faulty { faults }, .. }) => faults,
        other => panic!("{name}: {other:?}"),
    }
}

/// The strip is one component, named by its first face; at which edge the walk round it clashes
/// depends on how its squares are cut, so that edge is looked up in the file.
#[test]
fn a_moebius_strip_is_not_orientable() {
    let faults = refused("refuse/moebius.obj");
    let [PlacedFault { fault: Fault::NonOrientable { face: FaceId(0), ends }, place: Some(Place::Line(284)) }] =
        faults[..]
    else {
        panic!("{faults:?}")
    };
    let text = fs::read_to_string(data("refuse/moebius.obj")).unwrap();
    let faces = text.lines().filter_map(|line| line.strip_prefix("f "));
    let names = |face: &str, v: VertexId| face.split_whitespace().any(|word| word == (v.0 + 1).to_string());
    assert!(faces.into_iter().any(|face| ends.iter().all(|&v| names(face, v))), "{ends:?}");
}

#[test]
fn an_hourglass_is_not_manifold_at_its_waist() {
    let faults = refused("refuse/hourglass_ico.obj");
    let fault = Fault::NonManifoldVertex { vertex: VertexId(22), fans: 2 };
    assert_eq!(faults, [PlacedFault { fault, place: Some(Place::Line(26)) }]);
}

/// All nine shapes of the file are wrong, and each at the edges that its faces say, counted here from
/// the text.
#[test]
fn edges_of_many_faces_are_named_with_their_faces() {
    let text = fs::read_to_string(data("refuse/loop_nonman_edges.obj")).unwrap();
    let corner = |word: &str| word.split('/').next().unwrap().parse::<u32>().unwrap() - 1;
    let lines = text.lines().filter_map(|line| line.strip_prefix("f "));
    let faces: Vec<Vec<u32>> = lines.map(|line| line.split_whitespace().map(corner).collect()).collect();
    let mut expected = std::collections::BTreeMap::<_, Vec<FaceId>>::new();
    for (f, face) in
        faces.iter().enumerate().filter(|(_, face)| face[0] != face[1] && face[1] != face[2] && face[2] != face[0])
    {
        for i in 0..3 {
            let (a, b) = (face[i], face[(i + 1) % 3]);
            expected.entry([VertexId(a.min(b)), VertexId(a.max(b))]).or_default().push(FaceId::new(f));
        }
    }
    expected.retain(|_, faces| faces.len() > 2);
    assert!(expected.len() >= 3);
    let found = refused("refuse/loop_nonman_edges.obj");
    let edges: std::collections::BTreeMap<_, _> = found
        .iter()
        .filter_map(|placed| match &placed.fault {
            Fault::NonManifoldEdge { ends, faces } => Some((*ends, faces.clone())),
            _ => None,
        })
        .collect();
    assert_eq!(edges, expected);
    // What the file is about before what is wrong beside it.
    assert!(matches!(found[0].fault, Fault::NonManifoldEdge { .. }), "{:?}", found[0]);
    assert!(found.iter().all(|placed| matches!(placed.place, Some(Place::Line(_)))), "{found:?}");
    let degenerate = found.iter().filter(|placed| matches!(placed.fault, Fault::DegenerateFace { .. })).count();
    assert_eq!(degenerate, 4);
}

/// Nothing in the folder of what is to be refused gets through.
#[test]
fn every_file_to_be_refused_is_refused() {
    let mut count = 0;
    for entry in fs::read_dir(data("refuse")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|end| end == "obj") {
            let why = read_cage(&path, &Limits::default()).unwrap_err();
            assert!(why.to_string().contains("line "), "{why}");
            count += 1;
        }
    }
    assert_eq!(count, 3);
}

/// Reads, judges, and holds what comes out to its promises. Says what went wrong, if anything.
fn judge(name: &str, polygons: Result<Polygons, String>) -> Result<Cage, String> {
    let cage = polygons.and_then(|polygons| Cage::from_polygons(polygons).map_err(|why| why.to_string()));
    match &cage {
        Ok(cage) => {
            let mesh = Connectivity::new(cage.positions.len(), &cage.triangles).expect(name);
            assert!(cage.positions.iter().all(|p| p.is_finite()), "{name}");
            assert!(cage.corners.iter().all(|&v| mesh.is_border(v)), "{name}");
            assert_eq!(cage.import.sources.len(), cage.triangles.len(), "{name}");
        }
        Err(why) => assert!(!why.is_empty(), "{name}"),
    }
    cage
}

fn judge_obj(name: &str, bytes: &[u8]) -> Result<Cage, String> {
    let cage = judge(name, obj::read(bytes, &Limits::default()).map_err(|why| why.to_string()));
    // Each takes a letter and three numbers, and a space before each; a side more of a face, a triangle
    // more, takes two.
    if let Ok(cage) = &cage {
        assert!(8 * cage.positions.len() + 2 * cage.triangles.len() <= bytes.len() + 8, "{name}");
    }
    cage
}

#[test]
fn an_empty_file_has_no_faces() {
    for text in ["", "\n", "# nothing\n", "v 0 0 0\n", "\\", "\\\n\\\n"] {
        assert_eq!(judge_obj("empty", text.as_bytes()).unwrap_err(), "the mesh cannot be used: the mesh has no faces");
    }
}

#[test]
fn numbers_that_are_none_are_named_by_their_line() {
    for token in ["nan", "NaN", "inf", "-infinity", "1e400", "0x10", "1.0.0", "", "one", "\u{1F40D}"] {
        let text = format!("v 0 0 0\nv 0 1 {token}\nv 1 0 0\nf 1 2 3\n");
        let why = judge_obj(token, text.as_bytes()).unwrap_err();
        assert!(why.starts_with("line 2: "), "{token}: {why}");
    }
}

#[test]
fn indices_that_reach_nothing_are_named_by_their_line() {
    for index in
        ["4", "-4", "0", "2147483648", "4294967295", "4294967296", "18446744073709551616", "-9223372036854775808"]
    {
        let text = format!("v 0 0 0\nv 0 1 0\nv 1 0 0\n\nf 1 2 {index}\n");
        let why = judge_obj(index, text.as_bytes()).unwrap_err();
        assert!(why.starts_with("line 5: ") && why.contains(index), "{index}: {why}");
    }
}

/// A sparse file that says it has a gigabyte is refused by its length, and one whose lines never end
/// is read as far as its first word.
#[test]
fn a_gigabyte_is_refused_before_it_is_read() {
    let folder = std::env::temp_dir().join(format!("selvedge-bad-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    for name in ["huge.obj", "huge.glb"] {
        let path = folder.join(name);
        fs::File::create(&path).unwrap().set_len(1 << 30).unwrap();
        let why = read_cage(&path, &Limits::default()).unwrap_err();
        if cfg!(feature = "gltf") || name == "huge.obj" {
            assert!(matches!(why, ReadError::TooLarge { .. }), "{why}");
            assert!(why.to_string().contains("1073741824 bytes"), "{why}");
        }
    }
    let path = folder.join("huge.tags.json");
    fs::write(folder.join("small.obj"), "v 0 0 0\nv 0 1 0\nv 1 0 0\nf 1 2 3\n").unwrap();
    fs::rename(folder.join("huge.obj"), folder.join("small.tags.json")).unwrap();
    let why = read_cage(&folder.join("small.obj"), &Limits::default()).unwrap_err();
    assert!(
        why.to_string().contains("small.tags.json") && matches!(why, ReadError::TooLarge { .. }),
        "{path:?}: {why}"
    );
    fs::remove_dir_all(folder).unwrap();

    let zeros = vec![0; 64 << 20];
    assert!(judge_obj("zeros", &zeros).unwrap_err().starts_with("line 1: "));
    let words = b"f 1 ".repeat(16 << 20);
    assert!(judge_obj("words", &words).unwrap_err().starts_with("line 1: "));
    let numbers = [b"v".to_vec(), b" 1".repeat(8 << 20)].concat();
    assert_eq!(
        judge_obj("numbers", &numbers).unwrap_err(),
        format!("line 1: a vertex of {} numbers; it takes 3 (position), 4 (and weight) or 6 (and colour)", 8 << 20)
    );
}

/// A file that ends anywhere within its last face or before is refused or smaller, never worse.
#[test]
fn a_truncated_obj_is_refused_or_smaller() {
    let whole = fs::read(data("cages/loop_cube.obj")).unwrap();
    let (mut refused, mut smaller) = (0, 0);
    for length in 0..whole.len() {
        match judge_obj("truncated", &whole[..length]) {
            Ok(cage) => {
                assert!(cage.triangles.len() <= 24);
                smaller += 1;
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 900 && smaller > 10, "{refused} refused, {smaller} smaller");
}

/// Spoils bytes in a few places: other values, lost or doubled stretches, numbers made large.
fn mutate(bytes: &[u8], random: &mut Draw) -> Vec<u8> {
    let mut out = bytes.to_vec();
    for _ in 0..=random.remainder(4) {
        let at = random.remainder(out.len());
        let end = (at + random.remainder(16)).min(out.len());
        match random.remainder(6) {
            0 => out.get_mut(at..=at).into_iter().flatten().for_each(|b| *b = random.next() as u8),
            1 => out.get_mut(at..=at).into_iter().flatten().for_each(|b| *b ^= 1 << random.remainder(8)),
            2 => drop(out.drain(at..end)),
            3 => {
                let stretch = out[at..end].to_vec();
                out.splice(at..at, stretch);
            }
            4 => drop(out.splice(at..at, *b"999999")),
            _ => out.truncate(at),
        }
    }
    out
}

#[test]
fn spoiled_objs_never_break_anything() {
    let mut outcomes = [0, 0];
    for name in ["cages/spot_control_mesh.obj", "cages/loop_cube.obj", "cages/loop_xord_boundary.obj"] {
        let whole = fs::read(data(name)).unwrap();
        for seed in 0..300 {
            let bytes = mutate(&whole, &mut Draw(seed));
            let outcome = judge_obj(&format!("{name}, seed {seed}"), &bytes);
            outcomes[usize::from(outcome.is_err())] += 1;
        }
    }
    assert!(outcomes[1] > 300, "{outcomes:?}");
}

#[test]
fn garbage_is_no_obj() {
    for seed in 0..200 {
        let mut random = Draw(seed);
        let length = 16 + random.remainder(4096);
        let bytes: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
        let why = obj::read(&bytes, &Limits::default()).unwrap_err();
        let places = ["line ", "OBJ"];
        assert!(places.iter().any(|p| why.to_string().contains(p)), "seed {seed}: {why}");
        assert!(matches!(why, ObjError::Statement { .. }), "seed {seed}: {why}");
        let _ = Tags::from_json(&bytes).unwrap_err();
    }
}

#[cfg(feature = "gltf")]
mod glb {
    use selvedge::io::glb::{GlbError, Weld, extras, read};
    use selvedge::io::{PrimitivePlace, TooLarge};
    use serde_json::{Value, json};

    use super::by_hand::{container, floats, tetrahedron};
    use super::*;

    const FIRST: PrimitivePlace = PrimitivePlace { node: 0, mesh: 0, primitive: 0 };

    fn attempt(bytes: &[u8]) -> Result<Polygons, GlbError> {
        let _ = extras(bytes, &Limits::default());
        read(bytes, &Limits::default(), Weld::default())
    }

    /// What is said of the tetrahedron when something about its scene is changed.
    fn said(change: impl FnOnce(&mut Value)) -> String {
        let (mut scene, buffer) = tetrahedron();
        change(&mut scene);
        attempt(&container(&scene, &buffer)).unwrap_err().to_string()
    }

    #[test]
    fn a_truncated_glb_is_refused_wherever_it_ends() {
        let (scene, buffer) = tetrahedron();
        let whole = container(&scene, &buffer);
        assert!(attempt(&whole).is_ok());
        for length in 0..whole.len() {
            let why = attempt(&whole[..length]).unwrap_err();
            let expected = if length < 12 {
                GlbError::NoHeader { length }
            } else {
                GlbError::Length { claimed: whole.len() as u32, length }
            };
            assert_eq!(why, expected);
        }
    }

    /// The same, with a header that owns to the shorter length.
    #[test]
    fn a_truncated_glb_with_an_honest_header_is_refused_too() {
        let (scene, buffer) = tetrahedron();
        let whole = container(&scene, &buffer);
        for length in 12..whole.len() {
            let mut bytes = whole[..length].to_vec();
            bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            let why = attempt(&bytes).unwrap_err();
            // Where the chunk of the buffer is gone altogether the scene reaches into nothing.
            let without_buffer = length == whole.len() - buffer.len() - 8;
            let expected = match why {
                GlbError::Container { .. } => !without_buffer,
                GlbError::Overrun { .. } => without_buffer,
                _ => false,
            };
            assert!(expected, "{length}: {why}");
        }
    }

    #[test]
    fn headers_and_chunks_that_lie_are_refused() {
        let (scene, buffer) = tetrahedron();
        let whole = container(&scene, &buffer);
        let with = |at: usize, word: u32| {
            let mut bytes = whole.clone();
            bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
            attempt(&bytes).unwrap_err()
        };
        for claimed in [0, 11, u32::MAX, 1 << 30] {
            assert_eq!(with(8, claimed), GlbError::Length { claimed, length: whole.len() });
        }
        for (at, word) in [(0, 0), (4, 1), (4, 3), (12, 1 << 30), (12, u32::MAX), (16, 7), (16, 0x004E_4942)] {
            assert!(matches!(with(at, word), GlbError::Container { .. }), "{at} {word}");
        }
        assert!(matches!(with(12, 0), GlbError::Json { .. } | GlbError::Container { .. }));
        assert!(matches!(with(20, 0), GlbError::Json { line: 1, .. }));
    }

    #[test]
    fn a_scene_that_is_no_scene_is_refused_with_its_place() {
        assert!(said(|s| *s = json!(3)).starts_with("JSON chunk, line 1, column 1: "));
        assert!(said(|s| s["asset"] = Value::Null).starts_with("JSON chunk, line 1, column "));
        assert!(said(|s| s["accessors"][0]["count"] = json!(-1)).starts_with("JSON chunk"));
        assert!(said(|s| s["accessors"][0]["count"] = json!(1e40)).starts_with("JSON chunk"));
        let deep = "[".repeat(1 << 20);
        assert!(Tags::from_json(deep.as_bytes()).is_err());
        let mut bytes = container(&json!(0), &[]);
        bytes.truncate(12);
        bytes.extend((deep.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(deep.as_bytes());
        let length = bytes.len() as u32;
        bytes[8..12].copy_from_slice(&length.to_le_bytes());
        assert!(matches!(attempt(&bytes), Err(GlbError::Json { .. })));
    }

    #[test]
    fn names_of_nothing_are_refused_with_who_names_them() {
        let primitive = |key: &'static str, value: Value| said(move |s| s["meshes"][0]["primitives"][0][key] = value);
        let of = "node 0, mesh 0, primitive 0";
        assert_eq!(primitive("indices", json!(2)), format!("{of} names accessor 2, but there are 2"));
        assert_eq!(
            primitive("attributes", json!({ "POSITION": 9 })),
            format!("{of} names accessor 9, but there are 2")
        );
        assert_eq!(primitive("attributes", json!({})), format!("{of} has no positions"));
        assert_eq!(primitive("mode", json!(9)), format!("{of}: a primitive of an unknown mode is not supported"));
        assert_eq!(said(|s| s["nodes"][0]["mesh"] = json!(1)), "node 0 names mesh 1, but there are 1");
        assert_eq!(
            said(|s| s["nodes"][0]["children"] = json!([4294967295_u32])),
            "node 0 names node 4294967295, but there are 1"
        );
        assert_eq!(said(|s| s["scenes"][0]["nodes"] = json!([7])), "scene 0 names node 7, but there are 1");
        assert_eq!(said(|s| s["scene"] = json!(5)), "the file names scene 5, but there are 1");
        assert_eq!(
            said(|s| s["accessors"][0]["bufferView"] = json!(8)),
            "accessor 0 names buffer view 8, but there are 2"
        );
        assert_eq!(said(|s| s["bufferViews"][0]["buffer"] = json!(1)), "buffer view 0 names buffer 1, but there are 1");
    }

    #[test]
    fn claims_beyond_the_file_are_refused_with_what_is_there() {
        let count = |accessor: usize, count: u64| said(move |s| s["accessors"][accessor]["count"] = json!(count));
        assert_eq!(count(0, 5), "accessor 0 claims 60 bytes, but buffer view 0 holds 48");
        assert_eq!(count(0, 1 << 27), "accessor 0 claims 1610612736 bytes, but buffer view 0 holds 48");
        assert_eq!(count(0, u64::MAX), format!("accessor 0 claims {} bytes, but buffer view 0 holds 48", u64::MAX));
        assert_eq!(count(1, 15), "accessor 1 claims 60 bytes, but buffer view 1 holds 48");
        assert!(count(1, 1 << 40).contains("corners of triangles are more than the limit"));
        assert_eq!(count(1, 11), "node 0, mesh 0, primitive 0 has 11 corners, which is no whole number of triangles");
        assert_eq!(
            said(|s| s["accessors"][0]["byteOffset"] = json!(u64::MAX)),
            format!("accessor 0 claims {} bytes, but buffer view 0 holds 48", u64::MAX)
        );
        assert_eq!(
            said(|s| s["bufferViews"][0]["byteLength"] = json!(1 << 30)),
            "buffer view 0 claims 1073741824 bytes, but buffer 0 holds 96"
        );
        assert_eq!(
            said(|s| s["bufferViews"][1]["byteOffset"] = json!(u64::MAX)),
            format!("buffer view 1 claims {} bytes, but buffer 0 holds 96", u64::MAX)
        );
        assert_eq!(
            said(|s| s["buffers"][0]["byteLength"] = json!(1 << 30)),
            "buffer 0 claims 1073741824 bytes, but the file holds 96"
        );
        assert_eq!(
            said(|s| s["bufferViews"][0]["byteStride"] = json!(4)),
            "accessor 0 has elements of 12 bytes every 4"
        );
        assert_eq!(
            said(|s| s["bufferViews"][0]["byteStride"] = json!(252)),
            "accessor 0 claims 768 bytes, but buffer view 0 holds 48"
        );
    }

    #[test]
    fn types_that_do_not_fit_are_refused() {
        let change =
            |accessor: usize, key: &'static str, value: Value| said(move |s| s["accessors"][accessor][key] = value);
        assert_eq!(
            change(0, "type", json!("VEC2")),
            "accessor 0 holds Vec2 of F32 where positions (three floats) are expected"
        );
        assert_eq!(
            change(0, "componentType", json!(5123)),
            "accessor 0 holds Vec3 of U16 where positions (three floats) are expected"
        );
        assert_eq!(
            change(0, "componentType", json!(0)),
            "accessor 0 holds an unknown type where positions (three floats) are expected"
        );
        assert_eq!(
            change(1, "componentType", json!(5126)),
            "accessor 1 holds Scalar of F32 where indices (unsigned integers) are expected"
        );
        assert_eq!(
            change(1, "type", json!("VEC3")),
            "accessor 1 holds Vec3 of U32 where indices (unsigned integers) are expected"
        );
    }

    #[test]
    fn what_is_not_read_here_is_refused_by_name() {
        let sparse =
            json!({ "count": 1, "indices": { "bufferView": 1, "componentType": 5125 }, "values": { "bufferView": 0 } });
        assert_eq!(said(|s| s["accessors"][0]["sparse"] = sparse), "accessor 0: a sparse accessor is not supported");
        assert_eq!(
            said(|s| s["accessors"][0]["bufferView"] = Value::Null),
            "accessor 0: a sparse accessor is not supported"
        );
        assert_eq!(
            said(|s| s["buffers"][0]["uri"] = json!("elsewhere.bin")),
            "buffer view 0: buffer 0 outside the file is not supported"
        );
        assert_eq!(
            said(|s| s["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])),
            "the file: extension KHR_draco_mesh_compression is not supported"
        );
        assert_eq!(
            said(|s| s["nodes"][0]["matrix"] = json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
            "node 0: a matrix that is not affine is not supported"
        );
    }

    #[test]
    fn nodes_that_form_no_trees_are_refused() {
        let nodes = |nodes: Value| said(move |s| s["nodes"] = nodes);
        assert!(nodes(json!([{ "children": [0] }])).starts_with("node 0 is reached"));
        assert!(
            nodes(json!([{ "children": [1] }, { "children": [2] }, { "children": [0] }]))
                .starts_with("node 0 is reached")
        );
        assert!(nodes(json!([{ "children": [1, 1] }, {}])).starts_with("node 1 is reached"));
        assert!(said(|s| s["scenes"][0]["nodes"] = json!([0, 0])).starts_with("node 0 is reached"));
    }

    /// A chain of a hundred thousand nodes is walked without a stack of calls.
    #[test]
    fn a_deep_tree_is_walked() {
        let (mut scene, buffer) = tetrahedron();
        let depth = 100_000;
        let mut nodes: Vec<Value> = (1..depth).map(|child| json!({ "children": [child] })).collect();
        nodes.push(json!({ "mesh": 0 }));
        scene["nodes"] = json!(nodes);
        assert_eq!(attempt(&container(&scene, &buffer)).unwrap().face_count(), 4);
    }

    #[test]
    fn indices_and_positions_that_are_wrong_are_named() {
        let (scene, mut buffer) = tetrahedron();
        buffer[48 + 4 * 7..48 + 4 * 8].copy_from_slice(&u32::MAX.to_le_bytes());
        let why = attempt(&container(&scene, &buffer)).unwrap_err();
        assert_eq!(why, GlbError::IndexOutOfRange { place: FIRST, corner: 7, index: u32::MAX, vertex_count: 4 });
        for wrong in [f32::NAN, f32::INFINITY] {
            let (scene, mut buffer) = tetrahedron();
            buffer[24..28].copy_from_slice(&wrong.to_le_bytes());
            let why = attempt(&container(&scene, &buffer)).unwrap_err();
            assert_eq!(why, GlbError::NotFinite { place: FIRST, vertex: 2 });
        }
        let zero = said(|s| s["nodes"][0]["rotation"] = json!([0, 0, 0, 0]));
        assert_eq!(zero, "node 0, mesh 0, primitive 0: vertex 0 is not finite");
    }

    /// A small file that names one list of triangles over and over does not get it over and over.
    #[test]
    fn what_is_named_often_counts_as_often() {
        let (mut scene, _) = tetrahedron();
        let corners = 3 << 18;
        let buffer = [floats(&[0.0; 12]), vec![0; corners]].concat();
        scene["accessors"][1] = json!({ "bufferView": 1, "componentType": 5121, "count": corners, "type": "SCALAR" });
        scene["bufferViews"][1]["byteLength"] = json!(corners);
        scene["buffers"][0]["byteLength"] = json!(buffer.len());
        for mode in [4, 5, 6] {
            let primitive = json!({ "attributes": { "POSITION": 0 }, "indices": 1, "mode": mode });
            scene["meshes"][0]["primitives"] = json!(vec![primitive; 1000]);
            let limits = Limits { faces: 1 << 20, ..Limits::default() };
            let why = read(&container(&scene, &buffer), &limits, Weld::default()).unwrap_err();
            assert!(matches!(why, GlbError::TooLarge(TooLarge { .. })), "{why}");
        }
    }

    #[test]
    fn each_limit_is_kept() {
        let (scene, buffer) = tetrahedron();
        let bytes = container(&scene, &buffer);
        let within = |limits: Limits| read(&bytes, &limits, Weld::default()).map_err(|why| why.to_string());
        let all = Limits::default();
        assert!(within(Limits { vertices: 4, faces: 4, bytes: bytes.len(), ..all }).is_ok());
        assert_eq!(within(Limits { vertices: 3, ..all }).unwrap_err(), "4 vertices are more than the limit of 3");
        assert_eq!(
            within(Limits { faces: 3, ..all }).unwrap_err(),
            "12 corners of triangles are more than the limit of 9"
        );
        assert!(within(Limits { bytes: 100, ..all }).unwrap_err().contains("bytes are more than the limit of 100"));
    }

    #[test]
    fn spoiled_glbs_never_break_anything() {
        let (scene, buffer) = tetrahedron();
        let whole = container(&scene, &buffer);
        let json = scene.to_string().into_bytes();
        let mut outcomes = [0, 0];
        for seed in 0..600 {
            let mut random = Draw(seed);
            // The container spoiled, or its scene or its buffer in a container that is whole.
            let bytes = match seed % 3 {
                0 => mutate(&whole, &mut random),
                1 => reframed(&mutate(&json, &mut random), &buffer),
                _ => {
                    let mut spoiled = mutate(&buffer, &mut random);
                    spoiled.resize(buffer.len(), 0);
                    container(&scene, &spoiled)
                }
            };
            let name = format!("seed {seed}");
            let outcome = judge(&name, attempt(&bytes).map_err(|why| why.to_string()));
            outcomes[usize::from(outcome.is_err())] += 1;
        }
        assert!(outcomes[0] > 10 && outcomes[1] > 300, "{outcomes:?}");
    }

    /// A container that is whole around a scene that need not even be text.
    fn reframed(scene: &[u8], buffer: &[u8]) -> Vec<u8> {
        let empty = container(&json!({}), buffer);
        let mut scene = scene.to_vec();
        scene.resize(scene.len().next_multiple_of(4), b' ');
        // The empty scene takes four bytes.
        let mut out = [&empty[..20], &scene, &empty[24..]].concat();
        let length = out.len() as u32;
        out[8..12].copy_from_slice(&length.to_le_bytes());
        out[12..16].copy_from_slice(&(scene.len() as u32).to_le_bytes());
        out
    }

    #[test]
    fn garbage_is_no_glb() {
        for seed in 0..200 {
            let mut random = Draw(seed);
            let length = 12 + random.remainder(4096);
            let mut bytes: Vec<u8> = (0..length).map(|_| random.next() as u8).collect();
            assert!(matches!(attempt(&bytes), Err(GlbError::Container { .. })), "seed {seed}");
            bytes[..4].copy_from_slice(b"glTF");
            bytes[4..8].copy_from_slice(&2_u32.to_le_bytes());
            bytes[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            assert!(matches!(attempt(&bytes), Err(GlbError::Container { .. })), "seed {seed}");
        }
    }
}
