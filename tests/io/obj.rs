use glam::DVec3;
use proptest::prelude::*;
use selvedge::io::obj::{ObjError, read, write, write_cage};
use selvedge::io::{Cage, Limits, Place, Polygons, TooLarge, WriteError};
use selvedge_components::mesh::{FaceId, VertexId};
use selvedge_components::triangles::Triangles;

fn parse(text: &str) -> Result<Polygons, ObjError> {
    read(text.as_bytes(), &Limits::default())
}

fn faces(polygons: &Polygons) -> Vec<Vec<u32>> {
    polygons.faces().map(<[u32]>::to_vec).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn corners_of_every_form_name_the_same_vertices() {
    for face in [
        "f 1 2 3 4",
        "f 1/5 2/6 3/7 4/8",
        "f 1//5 2//6 3//7 4//8",
        "f 1/5/5 2/6/6 3/7/7 4/8/8",
        "f 1/ 2/ 3/ 4/",
        "f -4 -3 -2 -1",
        "f -4/-1/-1 2/1 3//-1 -1",
        "  f\t1  2 3\t4  ",
        "f 1 2 3 4 # and no more 5",
        "fo 1 2 3 4",
        "f 1 2 \\\n3 4",
        "f \\\r\n1 2 \\\r\n3 4\r\n",
        "f 1 2 3 4\\",
    ] {
        let polygons = parse(&format!("{SQUARE}{face}")).unwrap_or_else(|why| panic!("{face}: {why}"));
        assert_eq!(faces(&polygons), [[0, 1, 2, 3]], "{face}");
    }
}

/// A relative index counts back from the last vertex before it, wherever the file goes on.
#[test]
fn relative_indices_count_back_from_where_they_stand() {
    let polygons = parse("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 0 0 1\nf -1 -2 -4\nf 1 4 2\n").unwrap();
    assert_eq!(faces(&polygons), [[0, 1, 2], [3, 2, 0], [0, 3, 1]]);
}

#[test]
fn a_face_may_come_before_its_vertices() {
    let polygons = parse(&format!("f 1 2 3\n{SQUARE}")).unwrap();
    assert_eq!(faces(&polygons), [[0, 1, 2]]);
}

#[test]
fn objects_are_read_as_one() {
    let text = "o first\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng a b\nusemtl red\ns 1\nf 1 2 3\no second\nv 0 0 1\nv 1 0 1\nv 0 1 1\ns off\nf 4 5 6\n";
    let polygons = parse(text).unwrap();
    assert_eq!(faces(&polygons), [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(polygons.reading.skipped, []);
}

#[test]
fn line_ends_of_every_kind_are_read() {
    let plain = parse(&format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    for text in [
        format!("{SQUARE}f 1 2 3 4"),
        format!("{SQUARE}f 1 2 3 4\n").replace('\n', "\r\n"),
        format!("\u{feff}{SQUARE}f 1 2 3 4\n"),
    ] {
        assert_eq!(parse(&text).unwrap(), plain);
    }
}

/// What ends in a backslash in a comment is a path, and the next line counts.
#[test]
fn a_comment_does_not_go_on_in_the_next_line() {
    let polygons = parse("# C:\\meshes\\\nv 0 0 0\nv 1 0 0\n  # \\\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(polygons.positions.len(), 3);
}

#[test]
fn colours_and_a_weight_of_one_are_allowed() {
    let polygons = parse("v 1 2 3 1.0\nv 1 2 3 0.5 0.5 0.5\nv 1 2 3\nf 1 2 3").unwrap();
    assert!(polygons.positions.iter().all(|&p| p == DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(parse("v 1 2 3 0.5"), Err(ObjError::Weight { line: 1, weight: 0.5 }));
}

#[test]
fn vertices_and_faces_know_their_lines() {
    let polygons = parse("# one\nv 0 0 0\n\nv 1 \\\n0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1\n").unwrap();
    let line = |n| Some(Place::Line(n));
    assert_eq!([0, 1, 2].map(|v| polygons.place_of_vertex(VertexId(v))), [2, 4, 6].map(line));
    assert_eq!([0, 1].map(|f| polygons.place_of_face(FaceId(f))), [7, 8].map(line));
    assert_eq!(polygons.place_of_face(FaceId(2)), None);
}

#[test]
fn tags_stand_after_a_t() {
    let polygons =
        parse(&format!("{SQUARE}f 1 2 3 4\nt interpolateboundary 1/0/0 1\nt corner 2/1/0 0 1 10 # sharp\n")).unwrap();
    assert_eq!(Cage::from_polygons(polygons).unwrap().corners.len(), 3);
    assert_eq!(
        parse("t corner 1/1/0").unwrap_err().to_string(),
        "line 1: tag \" corner 1/1/0\" has 0 values of a kind where 1 are expected"
    );
}

#[test]
fn every_error_names_its_line() {
    let bad = |text: &str| parse(&format!("{SQUARE}{text}\n")).unwrap_err();
    let token = |t: &str| t.to_owned();
    assert_eq!(bad("vertex 0 0 0"), ObjError::Statement { line: 5, keyword: token("vertex") });
    assert_eq!(bad("v 0 0"), ObjError::Coordinates { line: 5, found: 2 });
    assert_eq!(bad("v 0 0 0 1 1"), ObjError::Coordinates { line: 5, found: 5 });
    assert_eq!(bad("v 0 0 0 1 1 1 1"), ObjError::Coordinates { line: 5, found: 7 });
    assert_eq!(bad("v 0 0,5 0"), ObjError::Number { line: 5, token: token("0,5") });
    assert_eq!(bad("v 0 nan 0"), ObjError::NotFinite { line: 5, token: token("nan") });
    assert_eq!(bad("v 0 -inf 0"), ObjError::NotFinite { line: 5, token: token("-inf") });
    assert_eq!(bad("v 0 1e999 0"), ObjError::NotFinite { line: 5, token: token("1e999") });
    assert_eq!(bad("\n\nf 1 2"), ObjError::TooFewSides { line: 7, sides: 2 });
    assert_eq!(bad("f"), ObjError::TooFewSides { line: 5, sides: 0 });
    for corner in ["0", "1.5", "x", "/1/1", "1/x", "1//x", "1/2/3/4", "--1", "99999999999999999999", "1,2"] {
        assert_eq!(bad(&format!("f 1 2 {corner}")), ObjError::Corner { line: 5, token: token(corner) });
    }
    let out = |index| ObjError::IndexOutOfRange { line: 5, index, vertex_count: 4 };
    for index in [5, 4_000_000_000, 1 << 33, i64::MAX, -5, i64::MIN] {
        assert_eq!(bad(&format!("f 1 2 {index}")), out(index));
    }
}

#[test]
fn each_limit_is_kept() {
    let limits = Limits { bytes: 1000, vertices: 4, faces: 2, sides: 4 };
    let refused = |text: String| match read(text.as_bytes(), &limits).unwrap_err() {
        ObjError::TooLarge { line, why: TooLarge { what, count, limit } } => (line, what, count, limit),
        other => panic!("{other}"),
    };
    assert!(read(format!("{SQUARE}f 1 2 3 4\nf 4 3 2 1").as_bytes(), &limits).is_ok());
    assert_eq!(refused(format!("{SQUARE}v 0 0 0")), (Some(5), "vertices", 5, 4));
    assert_eq!(refused(format!("{SQUARE}f 1 2 3\nf 1 2 3\nf 1 2 3")), (Some(7), "faces", 3, 2));
    assert_eq!(refused(format!("{SQUARE}f 1 2 3 4 1")), (Some(5), "sides of a face", 5, 4));
    assert_eq!(refused(" ".repeat(1001)), (None, "bytes", 1001, 1000));
}

#[test]
fn triangles_that_are_not_what_they_promise_are_not_written() {
    let good = Triangles {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Triangles::default()
    };
    let fails = |spoil: fn(&mut Triangles)| {
        let mut surface = good.clone();
        spoil(&mut surface);
        write(&mut Vec::new(), &surface).unwrap_err()
    };
    assert!(matches!(
        fails(|s| s.triangles[0][1] = 3),
        WriteError::IndexOutOfRange { triangle: 0, index: 3, vertex_count: 3 }
    ));
    assert!(matches!(fails(|s| s.normals.push(DVec3::Z)), WriteError::Mismatch { what: "normals", count: 1, .. }));
    assert!(matches!(fails(|s| s.colours.push([0.0; 3])), WriteError::Mismatch { what: "colours", .. }));
    assert!(matches!(fails(|s| s.positions[2].x = f64::NAN), WriteError::NotFinite { vertex: 2, .. }));
}

#[test]
fn normals_and_colours_are_written_with_their_vertices() {
    let surface = Triangles {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        normals: vec![DVec3::Z; 3],
        colours: vec![[0.25, 0.5, 1.0]; 3],
        triangles: vec![[0, 1, 2]],
        ..Triangles::default()
    };
    let mut out = Vec::new();
    write(&mut out, &surface).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert!(text.starts_with("v 0.0 0.0 0.0 0.25 0.5 1.0\n"), "{text}");
    assert!(text.ends_with("vn 0.0 0.0 1.0\nf 1//1 2//2 3//3\n"), "{text}");
    let back = parse(&text).unwrap();
    assert_eq!((&back.positions, faces(&back)), (&surface.positions, vec![vec![0, 1, 2]]));
}

/// Any double, of any size.
fn coordinate() -> impl Strategy<Value = f64> {
    any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |x| x.is_finite())
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_double_comes_back_with_its_bits(
        positions in prop::collection::vec(prop::array::uniform3(coordinate()), 3..20),
        seed in any::<u32>(),
    ) {
        let count = positions.len() as u32;
        let triangles = vec![[seed % count, (seed / 7) % count, (seed / 49) % count]; 2];
        let positions: Vec<DVec3> = positions.into_iter().map(DVec3::from_array).collect();
        let surface = Triangles { positions, triangles, ..Triangles::default() };
        let mut out = Vec::new();
        write(&mut out, &surface).unwrap();
        let back = read(&out, &Limits::default()).unwrap();
        let bits = |all: &[DVec3]| all.iter().map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>();
        prop_assert_eq!(bits(&back.positions), bits(&surface.positions));
        prop_assert_eq!(faces(&back), surface.triangles.iter().map(|t| t.to_vec()).collect::<Vec<_>>());
    }
}

#[test]
fn a_cage_comes_back_with_its_corners() {
    let text = format!("{SQUARE}f 1 2 3 4\nt interpolateboundary 1/0/0 1\n");
    let cage = Cage::from_polygons(parse(&text).unwrap()).unwrap();
    assert_eq!(cage.corners.len(), 2);
    let mut out = Vec::new();
    write_cage(&mut out, &cage).unwrap();
    let back = Cage::from_polygons(read(&out, &Limits::default()).unwrap()).unwrap();
    assert_eq!((back.positions, back.triangles, back.corners), (cage.positions, cage.triangles, cage.corners));
}
