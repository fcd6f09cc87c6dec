use std::path::Path;

use selvedge::io::octant::{self, OctantError};
use selvedge_components::mesh::VertexId;

#[test]
fn both_octants_are_discs_of_one_irregular_vertex() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/plates/octant.json");
    let meshes = octant::read(&std::fs::read(path).unwrap()).unwrap();
    let names: Vec<&str> = meshes.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["cone(1,1)", "cone(1,2)"]);
    for octant in &meshes {
        assert_eq!(octant.mesh.euler(), 1);
        let irregular = |v: &VertexId| !octant.mesh.is_border(*v) && octant.mesh.valence(*v) != 6;
        let all: Vec<VertexId> = (0..octant.mesh.vertex_count()).map(VertexId::new).filter(irregular).collect();
        assert_eq!(all, [octant.irregular], "{}", octant.name);
        assert_eq!(octant.mesh.valence(octant.irregular), 5);
        // Corners of valence 3, 2 and 2: discrete Gauss-Bonnet with one vertex of valence 5.
        assert_eq!(octant.sides.each_ref().map(|side| octant.mesh.valence(side[0])), [3, 2, 2]);
    }
    assert_eq!(meshes.iter().map(|m| m.mesh.face_count()).collect::<Vec<_>>(), [7, 14]);
}

#[test]
fn sides_must_walk_the_border() {
    let file = |sides: &str, irregular: u32| {
        let triangles = "[[0,1,2],[0,2,3],[0,3,1]]";
        let mesh = format!(r#"{{"vertices":4,"triangles":{triangles},"sides":{sides},"irregular":{irregular}}}"#);
        octant::read(format!(r#"{{"meshes":{{"m":{mesh}}}}}"#).as_bytes())
    };
    assert!(file("[[1,2],[2,3],[3,1]]", 0).is_ok());
    let wrong = OctantError::Sides { mesh: "m".to_owned() };
    for sides in
        ["[[1,3],[3,2],[2,1]]", "[[1,2],[2,3],[3,2]]", "[[1,2],[3],[3,1]]", "[[],[],[]]", "[[0,0],[0,0],[0,0]]"]
    {
        assert_eq!(file(sides, 0), Err(wrong.clone()), "{sides}");
    }
    assert!(matches!(file("[[1,2],[2,3],[3,1]]", 4), Err(OctantError::NoSuchVertex { .. })));
}

#[test]
fn a_file_that_is_wrong_is_refused_with_its_place() {
    let huge =
        br#"{"meshes":{"m":{"vertices":18446744073709551615,"triangles":[[0,1,2]],"sides":[[],[],[]],"irregular":0}}}"#;
    assert!(matches!(octant::read(huge), Err(OctantError::Faulty { .. })));
    assert!(matches!(octant::read(b"{\"meshes\":\n{\"m\": 3}}"), Err(OctantError::Json { line: 2, .. })));
    assert!(matches!(octant::read(b""), Err(OctantError::Json { line: 1, .. })));
}
