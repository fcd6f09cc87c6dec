use selvedge::io::tags::{BorderCorners, Corner, Crease, TagError, Tags};
use selvedge::io::{Cage, Limits, obj};
use selvedge::scenes::limit::{LimitRow, limit};
use selvedge_components::mesh::VertexId;
use selvedge_systems::triangulate::TriangulateOptions;

fn read(tags: &[&str]) -> Result<Tags, TagError> {
    Tags::from_json(serde_json::to_string(tags).unwrap().as_bytes())
}

#[test]
fn each_kind_of_tag_is_understood() {
    let tags = read(&[
        "interpolateboundary 1/0/0 1",
        "corner 2/1/0 0 7 10.0",
        " corner  2/2/0  1 2 0.5 3 ",
        "crease 4/1/0 1 5 5 6 4.7",
        "crease 4/2/0 0 1 2 3 1 2",
        "hole 1/0/0 3",
        "interpolateboundary 1/0/0 0",
        "",
    ])
    .unwrap();
    let corner = |v, sharpness| Corner { vertex: VertexId(v), sharpness };
    let crease = |a, b, sharpness| Crease { ends: [VertexId(a), VertexId(b)], sharpness };
    assert_eq!(
        tags,
        Tags {
            border: BorderCorners::ValenceTwo,
            corners: vec![corner(0, 10.0), corner(7, 10.0), corner(1, 0.5), corner(2, 3.0)],
            creases: vec![crease(1, 5, 4.7), crease(5, 6, 4.7), crease(0, 1, 1.0), crease(2, 3, 2.0)],
            other: vec!["hole 1/0/0 3".to_owned(), "interpolateboundary 1/0/0 0".to_owned()],
        }
    );
    assert_eq!(read(&["interpolateboundary 1/0/0 2"]).unwrap(), Tags::default());
}

#[test]
fn what_cannot_be_understood_is_named() {
    let said = |tag: &str| read(&[tag]).unwrap_err().to_string();
    assert_eq!(said("corner"), r#"tag "corner": "" is not of the form ints/floats/strings"#);
    assert_eq!(said("corner 1/1 0 1"), r#"tag "corner 1/1 0 1": "1/1" is not of the form ints/floats/strings"#);
    assert_eq!(
        said("corner 1/1/-1 0 1"),
        r#"tag "corner 1/1/-1 0 1": "1/1/-1" is not of the form ints/floats/strings"#
    );
    assert!(
        said("corner 2/1/0 0 10").contains("1 values of a kind where 2 are expected")
            || said("corner 2/1/0 0 10").contains("0 values")
    );
    assert!(said("corner 1/1/0 0 10 11").contains("1 values of a kind where no more are expected"));
    assert!(said("corner 3/2/0 0 1 2 1 1").contains("2 values of a kind where 1 or 3 are expected"));
    assert!(said("crease 3/1/0 0 1 2 1").contains("3 values of a kind where an even number are expected"));
    assert!(said("corner 1/1/0 -1 10").contains(r#""-1" is not a vertex index"#));
    assert!(said("corner 1/1/0 99999999999 10").contains(r#""99999999999" is not a vertex index"#));
    for sharpness in ["nan", "inf", "-1", "x"] {
        assert!(said(&format!("corner 1/1/0 0 {sharpness}")).contains("is not a finite sharpness"));
    }
}

/// A count costs nothing until as many values are there.
#[test]
fn a_tag_that_claims_much_is_refused() {
    let claim = format!("corner {0}/{0}/{0} 1 2 3", usize::MAX);
    assert!(matches!(read(&[&claim]), Err(TagError::Values { found: 3, .. })));
    let claim = format!("corner {}/1/0", "9".repeat(60));
    assert!(matches!(read(&[&claim]), Err(TagError::Counts { .. })));
}

#[test]
fn a_file_that_is_no_list_of_strings_is_refused_with_its_place() {
    for text in ["", "[", "[1]", "{}", "[\"corner 1/1/0 0 10\"", "\"corner\"", "null"] {
        assert!(matches!(Tags::from_json(text.as_bytes()), Err(TagError::Json { line: 1, .. })), "{text}");
    }
    assert!(matches!(Tags::from_json(b"[\n\"a 0/0/0\",\n7]"), Err(TagError::Json { line: 3, .. })));
}

/// Corners on the border are kept, and the limit surface stays at them; corners inside and creases are
/// named, one by one, in what is said of the surface.
#[test]
fn corners_are_kept_and_creases_reported() {
    let vertices: String = (0..9).map(|v| format!("v {} {} {}\n", v % 3, v / 3, v % 2)).collect();
    let text = vertices + "f 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n";
    let mut polygons = obj::read(text.as_bytes(), &Limits::default()).unwrap();
    let tags = ["corner 3/1/0 0 2 4 10", "crease 4/1/0 1 4 4 7 3", "hole 1/0/0 0"];
    polygons.tags = read(&tags).unwrap();
    let cage = Cage::from_polygons(polygons).unwrap();
    assert_eq!(cage.corners, [VertexId(0), VertexId(2)]);

    let made = limit(&cage, &TriangulateOptions::default()).unwrap();
    let row = LimitRow::new("four squares", &cage, &made);
    assert_eq!((row.corners_kept, row.creases_reported), (2, 2));
    let said = [
        "a corner of sharpness 10 at vertex 4",
        "a crease of sharpness 3 along edge 1-4",
        "a crease of sharpness 3 along edge 4-7",
        "the tag \"hole 1/0/0 0\"",
    ];
    let (mut found, mut expected) = (row.not_kept.clone(), said.to_vec());
    found.sort();
    expected.sort_unstable();
    assert_eq!(found, expected);
    // Where the border has no corner it passes the control point by.
    let stays = |v: usize| made.triangulation.triangles.positions.contains(&cage.positions[v]);
    assert_eq!([0, 2, 6, 8].map(stays), [true, true, false, false]);
}
