use glam::{DMat4, DQuat, DVec3};
use proptest::prelude::*;
use selvedge::io::glb::{Extras, Object, Weld, extras, read, write};
use selvedge::io::{Cage, Limits, Place, Polygons, PrimitivePlace, WriteError, read_cage};
use selvedge_components::mesh::{Connectivity, FaceId};
use selvedge_components::triangles::Triangles;
use serde_json::{Value, json};

use crate::by_hand::{CORNERS, TRIANGLES, container, floats, tetrahedron};

fn take(bytes: &[u8]) -> Polygons {
    read(bytes, &Limits::default(), Weld::default()).unwrap_or_else(|why| panic!("{why}"))
}

fn triangles(polygons: &Polygons) -> Vec<[u32; 3]> {
    polygons.faces().map(|face| face.try_into().unwrap()).collect()
}

fn places(polygons: &Polygons) -> Vec<[DVec3; 3]> {
    triangles(polygons).iter().map(|t| t.map(|v| polygons.positions[v as usize])).collect()
}

/// The triangles of the tetrahedron as places, each moved.
fn moved(by: impl Fn(DVec3) -> DVec3) -> Vec<[DVec3; 3]> {
    let corner = |v: u32| by(DVec3::from_array(CORNERS[v as usize].map(f64::from)));
    TRIANGLES.iter().map(|t| t.map(corner)).collect()
}

fn farthest(a: &[[DVec3; 3]], b: &[[DVec3; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

fn sphere(centre: DVec3, radius: f64) -> Triangles {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cages/spot.obj");
    let cage = read_cage(&path, &Limits::default()).unwrap();
    let normals: Vec<DVec3> = cage.positions.iter().map(|p| p.normalize()).collect();
    let colours = normals.iter().map(|n| n.as_vec3().abs().to_array()).collect();
    let positions = normals.iter().map(|n| centre + radius * n).collect();
    Triangles { positions, normals, colours, triangles: cage.triangles, ..Triangles::default() }
}

fn write_one(surface: &Triangles) -> selvedge::io::glb::Glb {
    write(&[Object { name: "it", surface, extras: None }]).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    /// What comes back is off by what the report says, no more, and by no less at some vertex. And the
    /// report is what single precision about the centre can do: half a unit in the last place along
    /// each axis of what is at most the radius and the rounding of the centre.
    #[test]
    fn the_report_tells_the_error_of_the_file(
        direction in prop::array::uniform3(-1.0_f64..1.0),
        far in -3.0_f64..5.0,
        size in -6.0_f64..6.0,
    ) {
        let radius = 10_f64.powf(size);
        let centre = DVec3::from_array(direction) * 10_f64.powf(far) * radius;
        let surface = sphere(centre, radius);
        let glb = write_one(&surface);
        let back = read(&glb.bytes, &Limits::default(), Weld::Never).unwrap();
        prop_assert_eq!(triangles(&back), surface.triangles.clone());
        let off = back.positions.iter().zip(&surface.positions).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        prop_assert_eq!(off, glb.objects[0].error);
        let reach = radius + centre.abs().max_element() * f64::from(f32::EPSILON);
        prop_assert!(off <= 0.5 * 3_f64.sqrt() * reach * f64::from(f32::EPSILON), "{off} of {reach}");
        prop_assert!(off > 0.0);
    }
}

/// An error of zero where single precision is enough.
#[test]
fn what_single_precision_can_hold_comes_back_exactly() {
    let corner = |c: [f32; 3]| DVec3::from_array(c.map(f64::from)) * 0.25 + DVec3::new(1000.0, -2000.5, 0.0);
    let surface =
        Triangles { positions: CORNERS.map(corner).to_vec(), triangles: TRIANGLES.to_vec(), ..Triangles::default() };
    let glb = write_one(&surface);
    assert_eq!(glb.objects[0].error, 0.0);
    let back = take(&glb.bytes);
    assert_eq!((back.positions.clone(), triangles(&back)), (surface.positions, surface.triangles));
}

/// The validation and the accessors of the crate `gltf`, as a second opinion on every array.
#[test]
fn another_reader_finds_what_was_written() {
    let surface = sphere(DVec3::new(3.0, 4.0, 5.0), 0.5);
    let kept = json!({ "level": 4, "exact": 0.1 + 0.2 });
    let objects = [
        Object { name: "near", surface: &surface, extras: Some(&kept) },
        Object {
            name: "bare",
            surface: &Triangles { normals: vec![], colours: vec![], ..surface.clone() },
            extras: None,
        },
    ];
    let glb = write(&objects).unwrap();
    let gltf = gltf::Gltf::from_slice(&glb.bytes).expect("valid glTF");
    let bin = gltf.blob.as_deref().unwrap();
    let nodes: Vec<_> = gltf.default_scene().unwrap().nodes().collect();
    assert_eq!(nodes.iter().map(|n| n.name().unwrap()).collect::<Vec<_>>(), ["near", "bare"]);
    assert_eq!(nodes[0].extras().as_ref().unwrap().get(), kept.to_string());
    for (node, report) in nodes.iter().zip(&glb.objects) {
        let (translation, ..) = node.transform().decomposed();
        assert_eq!(translation.map(f64::from), report.centre.to_array());
        let primitive = node.mesh().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(bin));
        let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
        let local = surface.positions.iter().map(|&p| (p - report.centre).as_vec3().to_array());
        assert_eq!(positions, local.collect::<Vec<_>>());
        let bounds = primitive.bounding_box();
        for k in 0..3 {
            assert_eq!(positions.iter().map(|p| p[k]).fold(f32::INFINITY, f32::min), bounds.min[k]);
            assert_eq!(positions.iter().map(|p| p[k]).fold(f32::NEG_INFINITY, f32::max), bounds.max[k]);
        }
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, surface.triangles.as_flattened());
        if node.name() == Some("near") {
            assert!(reader.read_normals().unwrap().zip(&surface.normals).all(|(a, b)| a == b.as_vec3().to_array()));
            assert!(reader.read_colors(0).unwrap().into_rgb_f32().eq(surface.colours.iter().copied()));
        } else {
            assert!(reader.read_normals().is_none() && reader.read_colors(0).is_none());
        }
    }
}

/// A reader that takes the decimals of the translation as doubles puts the object in the same place.
#[test]
fn the_centre_is_the_same_number_in_single_and_in_double() {
    for (centre, radius) in [
        (DVec3::splat(0.1), 0.05),
        (DVec3::new(1e6 + 0.3, -12345.678, 3.3e5), 0.4),
        (DVec3::new(1e-7, 3e-7, 0.0), 1e-8),
    ] {
        let surface = sphere(centre, radius);
        let glb = write_one(&surface);
        let json = &glb.bytes[20..20 + u32::from_le_bytes(glb.bytes[12..16].try_into().unwrap()) as usize];
        let scene: Value = serde_json::from_slice(json).unwrap();
        let decimals: [f64; 3] = serde_json::from_value(scene["nodes"][0]["translation"].clone()).unwrap();
        assert_eq!(decimals, glb.objects[0].centre.to_array());
        assert!(glb.objects[0].centre.distance(centre) <= radius, "{}", glb.objects[0].centre);
        assert!(glb.objects[0].error <= 2.0 * radius * f64::from(f32::EPSILON));
    }
}

#[test]
fn extras_keep_doubles() {
    let surface = sphere(DVec3::ZERO, 1.0);
    let exact: Vec<f64> = surface.positions.iter().map(|p| p.x * 0.1 + 1e-9).collect();
    let kept = json!({ "x": exact, "note": "doubles" });
    let glb = write(&[Object { name: "it", surface: &surface, extras: Some(&kept) }]).unwrap();
    let found = extras(&glb.bytes, &Limits::default()).unwrap();
    assert_eq!(found, [Extras { name: Some("it".to_owned()), value: kept }]);
}

#[test]
fn what_the_format_cannot_say_is_not_written() {
    let good = Triangles {
        positions: CORNERS.map(|c| DVec3::from_array(c.map(f64::from))).to_vec(),
        triangles: TRIANGLES.to_vec(),
        ..Triangles::default()
    };
    let fails = |spoil: fn(&mut Triangles)| {
        let mut surface = good.clone();
        spoil(&mut surface);
        write(&[Object { name: "it", surface: &surface, extras: None }]).unwrap_err()
    };
    assert!(matches!(write(&[]), Err(WriteError::NoObjects)));
    assert!(matches!(fails(|s| s.triangles.clear()), WriteError::Empty { .. }));
    assert!(matches!(fails(|s| s.positions[3].z = 1e39), WriteError::Beyond { .. }));
    assert!(matches!(fails(|s| s.positions[3].z = f64::MAX), WriteError::Beyond { .. }));
    assert!(matches!(fails(|s| s.positions[3].z = f64::INFINITY), WriteError::NotFinite { vertex: 3, .. }));
    assert!(matches!(fails(|s| s.normals = vec![DVec3::NAN; 4]), WriteError::NotFinite { what: "normal", .. }));
    assert!(matches!(fails(|s| s.triangles[2][2] = 4), WriteError::IndexOutOfRange { triangle: 2, .. }));
}

/// A point makes an object without size, and at a point a surface may have no normal.
#[test]
fn an_object_without_size_is_written_too() {
    let point = Triangles { positions: vec![DVec3::splat(0.1); 3], triangles: vec![[0, 1, 2]], ..Triangles::default() };
    let glb = write_one(&point);
    assert!(glb.objects[0].error < 1e-8);
    let normals = vec![DVec3::ZERO; 3];
    let glb = write_one(&Triangles { normals, ..point });
    gltf::Gltf::from_slice(&glb.bytes).unwrap();
}

#[test]
fn a_file_by_hand_is_read() {
    let (scene, buffer) = tetrahedron();
    let polygons = take(&container(&scene, &buffer));
    assert_eq!(places(&polygons), moved(|p| p));
    assert_eq!(polygons.positions.len(), 4);
    assert!(Cage::from_polygons(polygons).is_ok());
}

/// Indices of any width, or none; lists, strips and fans; interleaved positions: the same triangles.
#[test]
fn triangles_are_read_however_they_are_listed() {
    let (plain, _) = tetrahedron();
    let positions = floats(CORNERS.as_flattened());
    let list: Vec<u32> = TRIANGLES.as_flattened().to_vec();
    let narrow = |bytes: Vec<u8>, component: u32, count: usize, mode: u32| {
        let mut scene = plain.clone();
        scene["accessors"][1] =
            json!({ "bufferView": 1, "componentType": component, "count": count, "type": "SCALAR" });
        scene["bufferViews"][1]["byteLength"] = json!(bytes.len());
        scene["buffers"][0]["byteLength"] = json!(48 + bytes.len());
        scene["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let buffer = [&positions[..], &bytes].concat();
        places(&take(&container(&scene, &buffer)))
    };
    let bytes = |list: &[u32]| list.iter().map(|&i| i as u8).collect::<Vec<_>>();
    let halves = list.iter().flat_map(|&i| (i as u16).to_le_bytes()).collect();
    assert_eq!(narrow(bytes(&list), 5121, 12, 4), moved(|p| p));
    assert_eq!(narrow(halves, 5123, 12, 4), moved(|p| p));

    // A strip of a tetrahedron, with its last corner said twice as where strips are joined, and a fan
    // of three of its faces.
    let rounds = |mut all: Vec<[DVec3; 3]>| {
        for triangle in &mut all {
            let first = (0..3).min_by(|&i, &j| triangle[i].to_array().partial_cmp(&triangle[j].to_array()).unwrap());
            triangle.rotate_left(first.unwrap());
        }
        all.sort_by(|a, b| format!("{a:?}").cmp(&format!("{b:?}")));
        all
    };
    let strip = narrow(bytes(&[0, 2, 1, 3, 0, 2, 2]), 5121, 7, 5);
    assert_eq!(rounds(strip), rounds(moved(|p| p)));
    let fan = narrow(bytes(&[0, 2, 1, 3, 2]), 5121, 5, 6);
    assert_eq!(rounds(fan), rounds(moved(|p| p)[..3].to_vec()));

    let mut loose = plain.clone();
    loose["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
    loose["accessors"][0]["count"] = json!(12);
    loose["bufferViews"][0] = json!({ "buffer": 0, "byteLength": 12 * 20, "byteStride": 20 });
    loose["buffers"][0]["byteLength"] = json!(240);
    let spaced = |&v: &u32| [&CORNERS[v as usize][..], &[9.0, 9.0]].concat();
    let polygons = take(&container(&loose, &floats(&list.iter().flat_map(spaced).collect::<Vec<_>>())));
    assert_eq!(places(&polygons), moved(|p| p));
    assert_eq!((polygons.positions.len(), polygons.reading.welded), (4, 8));
}

#[test]
fn nodes_place_what_they_hold() {
    let (mut scene, buffer) = tetrahedron();
    let (half, turn) = (0.5_f32.sqrt(), DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2));
    scene["nodes"] = json!([
        { "children": [1, 2], "translation": [1, 2, 3] },
        { "mesh": 0, "rotation": [0, 0, half, half], "scale": [2, 3, 4] },
        { "mesh": 0, "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1] },
        { "mesh": 0 }
    ]);
    let polygons = take(&container(&scene, &buffer));
    let parent = DVec3::new(1.0, 2.0, 3.0);
    let first = moved(|p| parent + turn * (p * DVec3::new(2.0, 3.0, 4.0)));
    let matrix = DMat4::from_rotation_z(std::f64::consts::FRAC_PI_2);
    let second = moved(|p| parent + DVec3::new(5.0, 6.0, 7.0) + matrix.transform_point3(p));
    let off = farthest(&places(&polygons), &[first, second].concat());
    // The quaternion is rounded to single precision and made a unit again.
    assert!(off < 4.0 * f64::from(f32::EPSILON), "{off}");
    let place = |node| Some(Place::Primitive(PrimitivePlace { node, mesh: 0, primitive: 0 }));
    assert_eq!([0, 3, 4, 7].map(|f| polygons.place_of_face(FaceId(f))), [place(1), place(1), place(2), place(2)]);
}

/// Seen in a mirror a triangle winds the other way, and is turned back.
#[test]
fn a_mirrored_object_keeps_its_outside() {
    let (mut scene, buffer) = tetrahedron();
    scene["nodes"][0]["scale"] = json!([-1, 1, 1]);
    let volume = |polygons: &Polygons| places(polygons).iter().map(|[a, b, c]| a.dot(b.cross(*c)) / 6.0).sum::<f64>();
    let mirrored = volume(&take(&container(&scene, &buffer)));
    assert!((mirrored - 1.0 / 6.0).abs() < 1e-15, "{mirrored}");
}

#[test]
fn a_file_without_scenes_gives_all_its_trees() {
    let (mut scene, buffer) = tetrahedron();
    scene.as_object_mut().unwrap().retain(|key, _| !key.starts_with("scene"));
    scene["nodes"] = json!([{ "mesh": 0, "translation": [9, 0, 0] }, { "children": [0] }]);
    assert_eq!(take(&container(&scene, &buffer)).face_count(), 4);
}

/// Vertices split for their normals are one again; those of two objects only if that is asked for.
#[test]
fn splits_are_welded_and_objects_are_not() {
    let (mut scene, _) = tetrahedron();
    let split: Vec<f32> = TRIANGLES.as_flattened().iter().flat_map(|&v| CORNERS[v as usize]).collect();
    scene["accessors"] = json!([{ "bufferView": 0, "componentType": 5126, "count": 12, "type": "VEC3" }]);
    scene["bufferViews"] = json!([{ "buffer": 0, "byteLength": 144 }]);
    scene["buffers"] = json!([{ "byteLength": 144 }]);
    scene["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
    scene["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0 }]);
    scene["scenes"][0]["nodes"] = json!([0, 1]);
    let bytes = container(&scene, &floats(&split));
    let count = |weld| read(&bytes, &Limits::default(), weld).unwrap().positions.len();
    assert_eq!([Weld::Never, Weld::WithinObjects, Weld::Everywhere].map(count), [24, 8, 4]);
    let cage = Cage::from_polygons(take(&bytes)).unwrap();
    assert_eq!((cage.import.welded, Connectivity::new(8, &cage.triangles).unwrap().euler()), (16, 4));
}

/// Minus zero is where zero is.
#[test]
fn zeros_of_both_signs_are_one_place() {
    let (scene, mut buffer) = tetrahedron();
    buffer[3] = 0x80;
    let polygons = take(&container(&scene, &buffer));
    assert_eq!(polygons.positions.len(), 4);
    let (mut scene, _) = tetrahedron();
    scene["meshes"][0]["primitives"][0] = json!({ "attributes": { "POSITION": 0 } });
    scene["accessors"][0]["count"] = json!(6);
    scene["bufferViews"][0]["byteLength"] = json!(72);
    let corners =
        [[0.0, -0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0], [0.0, 1.0, -0.0], [0.0, 0.0, 1.0]];
    let mut buffer = floats(corners.as_flattened());
    buffer.resize(96, 0);
    assert_eq!(take(&container(&scene, &buffer)).positions.len(), 4);
}

/// Primitives may share one list of vertices, each naming some.
#[test]
fn vertices_that_a_primitive_does_not_name_are_left_out() {
    let (mut scene, buffer) = tetrahedron();
    scene["meshes"] = json!([{ "primitives": [
        { "attributes": { "POSITION": 0 }, "indices": 1 },
        { "attributes": { "POSITION": 0 }, "indices": 2 }
    ] }]);
    scene["accessors"][1]["count"] = json!(6);
    let other = json!({ "bufferView": 1, "byteOffset": 24, "componentType": 5125, "count": 6, "type": "SCALAR" });
    scene["accessors"].as_array_mut().unwrap().push(other);
    let polygons = take(&container(&scene, &buffer));
    assert_eq!((polygons.positions.len(), places(&polygons)), (4, moved(|p| p)));
    let (mut scene, buffer) = tetrahedron();
    scene["accessors"][1]["count"] = json!(3);
    let polygons = take(&container(&scene, &buffer));
    assert_eq!((polygons.positions.len(), polygons.reading.unreferenced), (3, 1));
}

#[test]
fn what_is_not_triangles_is_reported() {
    let (mut scene, buffer) = tetrahedron();
    let lines = json!({ "attributes": { "POSITION": 0 }, "mode": 1 });
    scene["meshes"][0]["primitives"].as_array_mut().unwrap().push(lines);
    scene["extensionsRequired"] = json!(["KHR_materials_unlit"]);
    let polygons = take(&container(&scene, &buffer));
    assert_eq!(polygons.face_count(), 4);
    assert_eq!(polygons.reading.skipped, [("GLB primitive of points or lines".to_owned(), 1)]);
}

#[test]
fn a_cage_is_read_from_a_path_with_its_tags() {
    let folder = std::env::temp_dir().join(format!("selvedge-glb-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (mut scene, buffer) = tetrahedron();
    scene["accessors"][1]["count"] = json!(9);
    std::fs::write(folder.join("open.GLB"), container(&scene, &buffer)).unwrap();
    std::fs::write(folder.join("open.tags.json"), r#"["corner 2/1/0 1 3 10"]"#).unwrap();
    let cage = read_cage(&folder.join("open.GLB"), &Limits::default()).unwrap();
    assert_eq!(cage.corners.len(), 2);
    std::fs::remove_dir_all(folder).unwrap();
}
