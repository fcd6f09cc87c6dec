use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use selvedge::io::tags::{Crease, Tags};
use selvedge::io::{Cage, CageError, Limits, Place, PlacedFault, Polygons, ReadError, obj, read_cage};
use selvedge_components::mesh::{Connectivity, FaceId, Fault, VertexId};

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn cage(name: &str) -> Cage {
    read_cage(&data(name), &Limits::default()).unwrap_or_else(|why| panic!("{why}"))
}

fn connectivity(cage: &Cage) -> Connectivity {
    Connectivity::new(cage.positions.len(), &cage.triangles).expect("a cage is sound")
}

/// How many vertices there are of each valence.
fn valences(mesh: &Connectivity) -> BTreeMap<u32, usize> {
    let mut histogram = BTreeMap::new();
    for v in 0..mesh.vertex_count() {
        *histogram.entry(mesh.valence(VertexId::new(v))).or_default() += 1;
    }
    histogram
}

#[test]
fn every_cage_that_is_shipped_is_sound() {
    // Vertices, triangles, Euler number: 2 for each closed surface less twice its handles, 1 for
    // each disc.
    let known = [
        ("cages/loop_cube.obj", 14, 24, 2),
        ("cages/loop_icosahedron.obj", 12, 20, 2),
        ("cages/loop_pole8.obj", 17, 24, 1),
        ("cages/loop_toroidal_tet.obj", 32, 72, 2 - 2 * 3),
        ("cages/loop_triangle_edgecorner.obj", 48, 49, 4),
        ("cages/loop_xord_boundary.obj", 31, 23, 4),
        ("cages/spot.obj", 2930, 5856, 2),
        ("cages/spot_control_mesh.obj", 188, 372, 2),
        ("plates/plate8.obj", 81, 128, 1),
        ("plates/plate32.obj", 1089, 2048, 1),
    ];
    for (name, vertices, triangles, euler) in known {
        let cage = cage(name);
        let mesh = connectivity(&cage);
        assert_eq!((mesh.vertex_count(), mesh.face_count(), mesh.euler()), (vertices, triangles, euler), "{name}");
        assert_eq!(cage.import.turned, [], "{name}");
        assert!(cage.positions.iter().all(|p| p.is_finite()));
    }
}

/// Annealing over all ways to cut this cage finds nothing below 302.
#[test]
fn spot_is_cut_to_low_valences() {
    let cage = cage("cages/spot_control_mesh.obj");
    assert_eq!(cage.import.polygons, 176);
    let mesh = connectivity(&cage);
    let histogram = valences(&mesh);
    let sum: i64 = histogram.iter().map(|(&k, &n)| (i64::from(k) - 6).pow(4) * n as i64).sum();
    assert!(sum <= 312, "sum {sum} of {histogram:?}");
    assert!(histogram.keys().max() <= Some(&8) && histogram[&8] == 1, "{histogram:?}");
}

#[test]
fn triangles_are_the_faces_of_a_file_of_triangles() {
    let cage = cage("cages/loop_cube.obj");
    assert_eq!(cage.import.polygons, 0);
    assert_eq!(cage.import.sources, (0..24).map(FaceId).collect::<Vec<_>>());
}

/// OpenSubdiv's `interpolateboundary` 1 is "edge and corner", 2 is "edge only".
#[test]
fn corners_come_from_tag_files() {
    let sharp = cage("cages/loop_triangle_edgecorner.obj");
    let mesh = connectivity(&sharp);
    let expected: Vec<VertexId> =
        (0..48).map(VertexId).filter(|&v| mesh.is_border(v) && mesh.valence(v) == 2).collect();
    assert_eq!((sharp.corners.len(), &sharp.corners), (12, &expected));
    assert_eq!(cage("cages/loop_xord_boundary.obj").corners, [1, 5, 7, 12, 14, 20, 22, 30].map(VertexId));
    assert_eq!(cage("cages/loop_icosahedron.obj").corners, []);
    assert_eq!(cage("plates/plate8.obj").corners, [0, 8, 72, 80].map(VertexId));
}

/// The corners that the tags of the plates name are the corners of the lattice.
#[test]
fn plate_corners_are_the_ends_of_the_diagonals() {
    for name in ["plates/plate8.obj", "plates/plate32.obj"] {
        let plate = cage(name);
        let extent = plate.positions.iter().fold(0.0_f64, |far, p| far.max(p.x.abs()));
        let outermost = |v: &VertexId| plate.positions[v.index()].truncate().abs() == glam::DVec2::splat(extent);
        assert!(plate.corners.len() == 4 && plate.corners.iter().all(outermost), "{name}: {:?}", plate.corners);
    }
}

fn tetrahedron() -> (Vec<DVec3>, [[u32; 3]; 4]) {
    (vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
}

#[test]
fn windings_are_healed_and_the_faces_named() {
    let (positions, mut triangles) = tetrahedron();
    triangles[2].swap(0, 1);
    let healed = Cage::from_triangles(positions.clone(), &triangles).unwrap();
    assert_eq!(healed.import.turned, [FaceId(2)]);
    let sound = Cage::from_triangles(positions, &tetrahedron().1).unwrap();
    let turned = |triangles: &[[u32; 3]]| triangles.iter().map(|t| winding(*t)).collect::<Vec<_>>();
    assert_eq!(turned(&healed.triangles), turned(&sound.triangles));
}

/// A triangle begun at its smallest corner.
fn winding(mut triangle: [u32; 3]) -> [u32; 3] {
    let smallest = (0..3).min_by_key(|&i| triangle[i]).unwrap();
    triangle.rotate_left(smallest);
    triangle
}

/// A turned polygon is named once, as the polygon that it is in the file.
#[test]
fn a_turned_polygon_is_one_face() {
    let text = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 8 7 3 4\nf 1 5 8 4\n";
    let limits = Limits::default();
    assert_eq!(Cage::from_polygons(obj::read(text, &limits).unwrap()).unwrap().import.turned, []);
    let spoiled = String::from_utf8_lossy(text).replace("f 2 3 7 6", "f 2 6 7 3");
    let cage = Cage::from_polygons(obj::read(spoiled.as_bytes(), &limits).unwrap()).unwrap();
    assert_eq!((cage.import.turned, cage.import.polygons), (vec![FaceId(3)], 6));
}

#[test]
fn every_fault_of_a_cage_is_found_at_once_with_its_place() {
    let text = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 5 5 5\n\nf 1 3 2\nf 1 2 4\nf 1 4 3\n# the lid\nf 2 3 4\nf 2 2 3\nf 4 3 2\n";
    let why = Cage::from_polygons(obj::read(text, &Limits::default()).unwrap()).unwrap_err();
    let at = |fault, line| PlacedFault { fault, place: Some(Place::Line(line)) };
    let expected = [
        at(Fault::DegenerateFace { face: FaceId(4), vertex: VertexId(1) }, 12),
        at(Fault::DuplicateFace { first: FaceId(3), second: FaceId(5) }, 13),
        at(Fault::UnusedVertex { vertex: VertexId(4) }, 5),
    ];
    assert_eq!(why, CageError::Faulty { faults: expected.to_vec() });
    assert_eq!(
        why.to_string(),
        "the mesh cannot be used: face 4 is degenerate: it names vertex 1 more than once (line 12); \
         faces 3 and 5 have the same corners (line 13); vertex 4 is used by no face (line 5)"
    );
}

#[test]
fn a_polygon_that_names_a_vertex_twice_is_named() {
    let mut polygons = Polygons::new((0..5).map(|i| DVec3::splat(f64::from(i))).collect());
    polygons.push(&[0, 1, 2]).unwrap();
    polygons.push(&[2, 3, 4, 3]).unwrap();
    polygons.push(&[4, 9, 8]).unwrap();
    let CageError::Faulty { faults } = Cage::from_polygons(polygons).unwrap_err() else { panic!("faults") };
    let found: Vec<Fault> = faults.into_iter().map(|placed| placed.fault).collect();
    let out = |index| Fault::IndexOutOfRange { face: FaceId(2), index, vertex_count: 5 };
    assert_eq!(found, [out(9), out(8), Fault::DegenerateFace { face: FaceId(1), vertex: VertexId(3) }]);
}

#[test]
fn a_position_that_is_not_finite_is_named_beside_what_else_is_wrong() {
    let (mut positions, triangles) = tetrahedron();
    positions[2].y = f64::NAN;
    let CageError::Faulty { faults } = Cage::from_triangles(positions, &triangles[..3]).unwrap_err() else {
        panic!("faults")
    };
    assert!(matches!(faults[..], [PlacedFault { fault: Fault::NotFinite { vertex: VertexId(2), .. }, place: None }]));
}

#[test]
fn creases_and_inner_corners_are_reported_and_not_kept() {
    let (positions, triangles) = tetrahedron();
    let mut polygons = Polygons::from_triangles(positions, &triangles);
    let mut tags = Tags::default();
    tags.push("crease 2/1/0 3 1 2.5").unwrap();
    tags.push("corner 1/1/0 2 10").unwrap();
    tags.push("hole 1/0/0 1").unwrap();
    polygons.tags = tags;
    let cage = Cage::from_polygons(polygons).unwrap();
    assert_eq!(cage.corners, []);
    let said: Vec<String> = cage.import.unkept.iter().map(ToString::to_string).collect();
    assert_eq!(
        said,
        [
            "the tag \"hole 1/0/0 1\"",
            "a corner of sharpness 10 at vertex 2",
            "a crease of sharpness 2.5 along edge 3-1"
        ]
    );
}

#[test]
fn tags_must_name_what_exists() {
    let with = |tag: &str| {
        let (positions, triangles) = tetrahedron();
        let mut polygons = Polygons::from_triangles(positions, &triangles[..3]);
        polygons.tags.push(tag).unwrap();
        Cage::from_polygons(polygons).map(|cage| cage.corners).map_err(|why| why.to_string())
    };
    assert_eq!(with("corner 2/1/0 3 1 10"), Ok(vec![VertexId(1), VertexId(3)]));
    assert_eq!(with("corner 1/1/0 4 10").unwrap_err(), "a tag names vertex 4, but there are 4 vertices");
    assert_eq!(with("crease 2/1/0 0 9 1").unwrap_err(), "a tag names vertex 9, but there are 4 vertices");
    assert!(with("crease 2/1/0 0 3 1").is_ok());
}

#[test]
fn a_crease_must_lie_along_an_edge() {
    let mut polygons =
        Polygons::from_triangles(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE], &[[0, 1, 2], [2, 1, 3]]);
    polygons.tags.creases.push(Crease { ends: [VertexId(0), VertexId(3)], sharpness: 1.0 });
    let why = Cage::from_polygons(polygons).unwrap_err();
    assert_eq!(why.to_string(), "a crease names vertices 0 and 3, but no edge joins them");
}

#[test]
fn statements_that_are_not_taken_over_are_counted() {
    let unkept: Vec<String> =
        cage("cages/loop_icosahedron.obj").import.unkept.iter().map(ToString::to_string).collect();
    assert_eq!(unkept, ["OBJ statement \"vt\" (22 times)", "OBJ statement \"vn\" (12 times)"]);
}

#[test]
fn a_path_that_is_no_mesh_file_is_refused_by_name() {
    let limits = Limits::default();
    assert!(matches!(read_cage(&data("README.md"), &limits), Err(ReadError::Format { .. })));
    assert!(matches!(read_cage(&data("nothing.obj"), &limits), Err(ReadError::Io { .. })));
    assert!(matches!(read_cage(&data(""), &limits), Err(ReadError::Format { .. })));
}
