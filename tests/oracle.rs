//! Limit points and normals agree with OpenSubdiv's, at vertices of every kind and inside patches.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;
use selvedge::io::{Limits, read_cage};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::{CornerTable, Kind, LoopSurface, Origin};
use selvedge_components::triangles::Triangles;
use selvedge_systems::subdivision::chain;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

/// `(cage, numbers, whether its tags make corners)`.
const CASES: [(&str, &str, bool); 8] = [
    ("loop_cube", "loop_cube", false),
    ("loop_icosahedron", "loop_icosahedron", false),
    ("loop_pole8", "loop_pole8", false),
    ("loop_toroidal_tet", "loop_toroidal_tet", false),
    ("loop_triangle_edgecorner", "loop_triangle_edgecorner.corners", true),
    ("loop_triangle_edgecorner", "loop_triangle_edgecorner.smooth", false),
    ("loop_xord_boundary", "loop_xord_boundary.corners", true),
    ("loop_xord_boundary", "loop_xord_boundary.smooth", false),
];

/// Sizes of the cages are about one; both sides round.
const CLOSE: f64 = 1e-12;

struct Numbers {
    /// Level 0, in the order of the cage.
    vertices: Vec<(DVec3, DVec3)>,
    /// Level 2, in whatever order.
    fine: Vec<(DVec3, DVec3)>,
}

fn numbers(name: &str) -> Numbers {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/oracle").join(format!("{name}.txt"));
    let text = std::fs::read_to_string(path).expect("the numbers come with the project");
    let mut read = Numbers { vertices: Vec::new(), fine: Vec::new() };
    for line in text.lines() {
        let x: Vec<f64> = line.split(' ').map(|word| word.parse().expect("a number")).collect();
        let row = (DVec3::new(x[1], x[2], x[3]), DVec3::new(x[4], x[5], x[6]));
        if x[0] == 0.0 { read.vertices.push(row) } else { read.fine.push(row) }
    }
    read
}

fn surface(cage: &str, corners: bool) -> LoopSurface {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/cages").join(format!("{cage}.obj"));
    let cage = read_cage(&path, &Limits::default()).expect("the cage comes with the project");
    let mesh = Connectivity::new(cage.positions.len(), &cage.triangles).expect("a cage is a manifold");
    LoopSurface::plain(Arc::new(mesh), cage.positions, if corners { &cage.corners } else { &[] })
}

fn at_level(surface: &LoopSurface, level: u32) -> Triangles {
    let options = TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() };
    triangulate(surface, &options).expect("a cage has a limit surface").triangles
}

#[test]
fn limit_points_of_cage_vertices_agree() {
    for (cage, name, corners) in CASES {
        let ours = at_level(&surface(cage, corners), 0);
        let theirs = numbers(name).vertices;
        assert_eq!(ours.positions.len(), theirs.len(), "{name}");
        for (v, (x, (y, _))) in ours.positions.iter().zip(&theirs).enumerate() {
            assert!(x.distance(*y) < CLOSE, "{name}, vertex {v}: {x} and {y}");
        }
    }
}

/// OpenSubdiv's transversal tangent at a smooth border vertex of more than four edges is no left
/// eigenvector of Loop's rules: it turns when the cage is subdivided, so it is not compared.
/// [`normals_survive_subdivision`] holds there too.
#[test]
fn normals_of_cage_vertices_agree() {
    for (cage, name, corners) in CASES {
        let surface = surface(cage, corners);
        let ours = at_level(&surface, 0);
        for (v, (n, (_, m))) in ours.normals.iter().zip(numbers(name).vertices).enumerate() {
            let id = VertexId::new(v);
            let compared = m != DVec3::ZERO && !(surface.mesh.is_border(id) && surface.mesh.valence(id) > 4);
            assert!(!compared || n.distance(m) < CLOSE, "{name}, vertex {v}: {n} and {m}");
        }
    }
}

/// A cage and the same cage subdivided once have one limit surface, so one normal at each vertex of
/// the cage, whatever its valence and wherever it lies.
#[test]
fn normals_survive_subdivision() {
    for (cage, name, with_corners) in CASES {
        let coarse = surface(cage, with_corners);
        let table = CornerTable::new(&coarse);
        let root = chain::root(&coarse, &table, &coarse.details);
        let (fine, _) = chain::refine(&coarse, &table, &coarse.details, &root, &root.mesh.all_refinable());
        let mesh = Connectivity::new(fine.mesh.vertices.len(), &fine.mesh.corners).expect("a subdivided manifold");
        let is_corner = |v: &u32| fine.mesh.vertices[*v as usize].kind == Kind::PlainCorner;
        let corners: Vec<_> = (0..fine.mesh.vertices.len() as u32).filter(is_corner).map(VertexId).collect();
        let fine_surface = LoopSurface::plain(Arc::new(mesh), fine.state.effective.clone(), &corners);
        let (before, after) = (at_level(&coarse, 0), at_level(&fine_surface, 0));
        for (w, vertex) in fine.mesh.vertices.iter().enumerate() {
            let Origin::Vertex(v) = vertex.origin else { continue };
            let (n, m) = (before.normals[v as usize], after.normals[w]);
            assert!(n.distance(m) < CLOSE, "{name}, vertex {v}: {n} and then {m}");
        }
    }
}

/// Sixteenths of faces: their inner vertices lie inside the root patches.
#[test]
fn limit_points_inside_the_faces_agree() {
    for (cage, name, corners) in CASES {
        let ours = at_level(&surface(cage, corners), 2);
        let theirs = numbers(name).fine;
        assert_eq!(ours.positions.len(), theirs.len(), "{name}");
        for (y, _) in theirs {
            let off = ours.positions.iter().map(|x| x.distance(y)).fold(f64::MAX, f64::min);
            assert!(off < CLOSE, "{name}: {y} is {off:e} from every point");
        }
    }
}
