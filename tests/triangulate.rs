//! Triangles out: no vertex inside an edge, the chord that was asked for, the same bits every way.

#[path = "support/draw.rs"]
mod draw;
mod support;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use draw::{add_details, ball, disc};
use glam::DVec3;
use selvedge::io::{Limits, read_cage};
use selvedge_components::curve::Heading;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::fit::FitOptions;
use selvedge_components::subdivision::{Address, Border, Lattice, LoopSurface, PlainLoop};
use selvedge_systems::audit::{Audit, AuditReport, audit};
use selvedge_systems::subdivision::fit::FitWork;
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::tessellate;
use selvedge_systems::target::Projection;
use selvedge_systems::triangulate::{Density, TriangulateError, TriangulateOptions, Triangulation, triangulate};
use support::{octant, plain, spherical_fan};

/// A torus of `nu` by `nv` quads, radii 1 and 0.4.
fn torus(nu: u32, nv: u32) -> LoopSurface {
    let turn = |i: u32, n: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let at = |i: u32, j: u32| {
        let (u, v) = (turn(i, nu), turn(j, nv));
        let r = 1.0 + 0.4 * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), 0.4 * v.sin())
    };
    let name = |i: u32, j: u32| (i % nu) * nv + j % nv;
    let quad = |i: u32, j: u32| {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let faces: Vec<[u32; 3]> = (0..nu).flat_map(|i| (0..nv).flat_map(move |j| quad(i, j))).collect();
    plain((0..nu).flat_map(|i| (0..nv).map(move |j| at(i, j))).collect(), &faces)
}

/// A cage that comes with the engine, with its tags.
fn cage(name: &str) -> LoopSurface {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name);
    let cage = read_cage(&path, &Limits::default()).expect("the file is sound");
    let mesh = Connectivity::new(cage.positions.len(), &cage.triangles).expect("the cage is sound");
    LoopSurface::plain(Arc::new(mesh), cage.positions, &cage.corners)
}

/// The octant fitted to its sphere, with details on three levels.
fn fitted_octant() -> LoopSurface {
    let mut surface = octant("cone(1,2)");
    let sphere = Arc::new(Projection(|p: DVec3| p.normalize() * 0.5));
    let options = FitOptions { last_level: 2, ..FitOptions::default() };
    let mut work = FitWork::new(Arc::new(surface.clone()), sphere, options).expect("the options can be met");
    work.run().expect("a sphere has a closest point everywhere");
    surface.details = work.details().clone();
    surface
}

/// Surfaces of every kind, by name, with a length that is small beside each.
fn surfaces() -> Vec<(&'static str, LoopSurface, f64)> {
    let (points, triangles) = ball(80, 3);
    let rough = |mut surface: LoopSurface, size: f64, seed: u64| {
        add_details(&mut surface, 4, size, seed);
        surface
    };
    vec![
        ("torus", torus(10, 6), 1.0),
        ("ball", plain(points.clone(), &triangles), 1.0),
        ("ball with details", rough(plain(points, &triangles), 0.1, 5), 1.0),
        ("icosahedron", cage("cages/loop_icosahedron.obj"), 1.0),
        ("toroidal tetrahedron", cage("cages/loop_toroidal_tet.obj"), 1.0),
        ("pole of valence 8", cage("cages/loop_pole8.obj"), 1.0),
        ("irregular border", cage("cages/loop_xord_boundary.obj"), 1.0),
        ("border with corners", cage("cages/loop_triangle_edgecorner.obj"), 1.0),
        ("octant", octant("cone(1,2)"), 0.5),
        ("fitted octant", fitted_octant(), 0.5),
        ("octant with details", rough(octant("cone(1,1)"), 0.03, 11), 0.5),
        ("disc", disc(5, 2, 3, Heading::Against), 1.0),
        ("concave corner", spherical_fan(4, 2, 240_f64.to_radians()), 0.5),
    ]
}

fn at_level(surface: &LoopSurface, level: u32) -> Triangulation {
    let options = TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() };
    triangulate(surface, &options).expect("the level can be had")
}

fn to_chord(surface: &LoopSurface, chord: f64) -> Triangulation {
    let options = TriangulateOptions { density: Density::Chord(chord), ..TriangulateOptions::default() };
    triangulate(surface, &options).expect("the chord can be kept")
}

#[track_caller]
fn assert_sound(name: &str, report: &AuditReport) {
    assert!(report.is_sound(), "{name}: {} faults, the first: {}", report.faults.len(), report.faults[0]);
}

/// Every interior edge has two triangles, every open one runs along a border, the triangles of each
/// root face cover it once, and border vertices are the curves' own samples: at every level and every
/// chord, whatever the surface.
#[test]
fn no_vertex_lies_inside_an_edge() {
    for (name, surface, size) in surfaces() {
        for level in 0..4 {
            let done = at_level(&surface, level);
            assert_sound(name, &audit(&done.triangles, &Audit::of(&surface)));
            assert_eq!(done.triangles.triangles.len(), surface.mesh.face_count() << (2 * level));
        }
        for k in 1..8 {
            let done = to_chord(&surface, 0.1 * size * 0.6_f64.powi(k));
            assert_sound(name, &audit(&done.triangles, &Audit::of(&surface)));
            assert_eq!(done.triangles.faces.len(), done.triangles.triangles.len());
        }
    }
}

/// The limit of a surface by other means than triangulation has: closed forms where it is plain.
fn limit(surface: &LoopSurface) -> Box<dyn Evaluate> {
    let bare = surface.details.count() == 0 && surface.sides.iter().all(|s| matches!(s.border, Border::Plain));
    if bare && surface.sides.iter().all(|s| s.vertices.len() == s.edge_count()) {
        let plain = PlainLoop::new(surface.mesh.clone(), surface.points.clone(), &[]);
        return Box::new(plain.expect("the surface is sound"));
    }
    Box::new(LimitSurface::new(Arc::new(surface.clone())).expect("the surface is sound"))
}

/// Measured at other places, both ways, and with what the triangulation itself reports.
#[test]
fn the_chord_asked_for_is_kept_at_independent_samples() {
    for (name, surface, size) in surfaces() {
        let limit = limit(&surface);
        for k in 1..5 {
            let chord = 0.1 * size * 0.35_f64.powi(k);
            let done = to_chord(&surface, chord);
            let found = done.report.chord.expect("a chord was asked for");
            assert!(found.kept() && found.achieved <= chord, "{name}: {found:?}");
            let against = Audit { points: 24, seed: 7, ..Audit::of(&surface).within(&*limit, chord) };
            let report = audit(&done.triangles, &against);
            assert_sound(name, &report);
            let (measured, _) = report.measured.expect("the limit was given").greatest();
            assert!(measured > 0.8 * found.achieved, "{name}: {measured:e} measured, {:e} reported", found.achieved);
        }
    }
}

/// Over a smooth surface the distance falls with the square of the edges, so the triangles grow in
/// inverse proportion to the chord.
#[test]
fn triangles_grow_in_inverse_proportion_to_the_chord() {
    for (name, surface) in [("torus", torus(10, 6)), ("octant", octant("cone(1,2)"))] {
        let counts: Vec<f64> =
            (1..5).map(|k| to_chord(&surface, 0.1 * 0.25_f64.powi(k)).triangles.triangles.len() as f64).collect();
        let order = (counts[3] / counts[0]).ln() / 64_f64.ln();
        assert!((0.9..1.1).contains(&order), "{name}: order {order}, {counts:?}");
    }
}

/// By place: the bits of position and normal.
fn vertices(done: &Triangulation) -> BTreeMap<[u64; 3], ([u64; 3], [u64; 3])> {
    let bits = |v: DVec3| v.to_array().map(f64::to_bits);
    let t = &done.triangles;
    let place = |at: &SurfacePoint| [u64::from(at.face.0), at.st.x.to_bits(), at.st.y.to_bits()];
    t.origins.iter().zip(&t.positions).zip(&t.normals).map(|((o, &p), &n)| (place(o), (bits(p), bits(n)))).collect()
}

/// A vertex has one position and one normal, whoever asks.
#[test]
fn a_vertex_has_the_same_bits_at_every_density() {
    for (name, surface, size) in surfaces() {
        let fine = vertices(&at_level(&surface, 4));
        let others = [0.03, 0.004, 0.001].map(|part| to_chord(&surface, part * size));
        for done in others.iter().chain(&[at_level(&surface, 1), at_level(&surface, 3)]) {
            let mut shared = 0;
            for (place, bits) in vertices(done) {
                if let Some(same) = fine.get(&place) {
                    assert_eq!(*same, bits, "{name}: {place:?}");
                    shared += 1;
                }
            }
            assert!(shared > 0, "{name}");
        }
    }
}

/// Nothing depends on who works, or on how many do.
#[test]
fn one_to_four_threads_give_the_same_bits() {
    for (name, surface, size) in surfaces() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| to_chord(&surface, 0.002 * size))
        };
        let alone = on(1);
        for threads in 2..=4 {
            assert_eq!(on(threads), alone, "{name} on {threads} threads");
        }
    }
}

/// Vertices are numbered as the lattice of a level numbers them, and stand where the tessellation of
/// plain surfaces puts them.
#[test]
fn uniform_vertices_are_those_of_the_lattice() {
    let surface = cage("cages/loop_pole8.obj");
    let plain = PlainLoop::new(surface.mesh.clone(), surface.points.clone(), &[]).expect("a plain surface");
    for level in 0..4 {
        let done = at_level(&surface, level).triangles;
        let lattice = Lattice::new(&surface.mesh, level).expect("few vertices");
        assert_eq!(done.origins, tessellate::origins(&surface.mesh, &lattice));
        let tessellator = tessellate::Tessellator::new(&surface.mesh, level).expect("few vertices");
        let (positions, normals) = (tessellator.positions(&plain), tessellator.normals(&plain));
        for (ours, theirs) in [(&done.positions, positions), (&done.normals, normals)] {
            for (a, b) in ours.iter().zip(theirs.expect("the same mesh")) {
                assert!(a.distance(b) < 1e-13, "{a} {b}");
            }
        }
    }
}

/// The normals are the limit surface's, and the triangles turn the same way.
#[test]
fn normals_are_unit_and_agree_with_the_triangles() {
    for (name, surface, size) in surfaces() {
        if ["ball", "ball with details", "octant with details", "toroidal tetrahedron"].contains(&name) {
            // Rough on purpose, or folded by its cage.
            continue;
        }
        let done = to_chord(&surface, 0.0005 * size).triangles;
        for corners in &done.triangles {
            let [a, b, c] = corners.map(|v| done.positions[v as usize]);
            let flat = (b - a).cross(c - a).normalize();
            for &v in corners {
                let normal = done.normals[v as usize];
                assert!((normal.length() - 1.0).abs() < 1e-14, "{name}: {normal}");
                assert!(normal.dot(flat) > 0.8, "{name}: {normal} on a triangle facing {flat}");
            }
        }
    }
}

/// What is flat stays as coarse as its cage, beside what is not: the work is where the surface bends.
#[test]
fn a_flat_surface_keeps_its_cage() {
    let n = 8_u32;
    let at = |i: u32, j: u32| DVec3::new(f64::from(i), f64::from(j), 0.0);
    let mut points: Vec<DVec3> = (0..=n).flat_map(|i| (0..=n).map(move |j| at(i, j))).collect();
    let name = |i: u32, j: u32| i * (n + 1) + j;
    let quad = |i: u32, j: u32| {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let faces: Vec<[u32; 3]> = (0..n).flat_map(|i| (0..n).flat_map(move |j| quad(i, j))).collect();
    let corners = [name(0, 0), name(n, 0), name(n, n), name(0, n)].map(VertexId);
    let mesh = Arc::new(Connectivity::new(points.len(), &faces).expect("a lattice is a manifold"));
    let flat = LoopSurface::plain(Arc::clone(&mesh), points.clone(), &corners);
    assert_eq!(to_chord(&flat, 1e-9).triangles.triangles.len(), faces.len());
    // One control point up: its two rings of faces bend, nothing else.
    points[name(4, 4) as usize].z = 0.5;
    let bent = to_chord(&LoopSurface::plain(mesh, points, &corners), 1e-4);
    let coarse = bent.triangles.origins.iter().filter(|o| o.st.x.fract() == 0.0 && o.st.y.fract() == 0.0).count();
    assert_eq!(coarse, 81);
    assert!(bent.report.leaves[0] >= faces.len() - 54, "{:?}", bent.report.leaves);
}

/// Cutting a leaf along its neighbours makes no slivers: no triangle is worse than a quarter of the
/// worst that quartering alone makes.
#[test]
fn closures_make_no_slivers() {
    for (name, surface, size) in surfaces() {
        let uniform = (0..5).map(|level| at_level(&surface, level).report.worst_shape).fold(1.0, f64::min);
        for k in 1..6 {
            let shape = to_chord(&surface, 0.1 * size * 0.4_f64.powi(k)).report.worst_shape;
            assert!(shape >= 0.24 * uniform, "{name}: {shape} beside {uniform}");
        }
    }
}

/// A chord that the last level does not keep is told, with what was achieved; the mesh is sound.
#[test]
fn a_chord_out_of_reach_is_told() {
    let surface = torus(10, 6);
    let options = TriangulateOptions { density: Density::Chord(1e-5), last_level: 2, ..TriangulateOptions::default() };
    let done = triangulate(&surface, &options).expect("a mesh there is");
    let chord = done.report.chord.expect("a chord was asked for");
    assert!(!chord.kept() && chord.achieved > chord.asked, "{chord:?}");
    assert_eq!(chord.failing, done.triangles.triangles.len());
    assert_eq!(done.report.leaves.len(), 3);
    assert_sound("torus", &audit(&done.triangles, &Audit::of(&surface)));
}

/// What cannot be done is refused, and the refusal says why.
#[test]
fn what_cannot_be_done_is_refused() {
    let surface = torus(10, 6);
    let asked = |density| triangulate(&surface, &TriangulateOptions { density, ..TriangulateOptions::default() });
    for chord in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(asked(Density::Chord(chord)), Err(TriangulateError::BadChord { .. })));
    }
    assert!(matches!(asked(Density::Chord(1e-15)), Err(TriangulateError::ChordBelowRounding { .. })));
    for level in [29, 31, u32::MAX] {
        assert!(matches!(asked(Density::Level(level)), Err(TriangulateError::TooFine { .. })), "level {level}");
    }
    for density in [Density::Level(14), Density::Chord(1e-12)] {
        let options = TriangulateOptions { density, most_triangles: 20_000, ..TriangulateOptions::default() };
        let refused = triangulate(&surface, &options);
        assert!(matches!(refused, Err(TriangulateError::TooManyTriangles { .. })), "{density:?}");
    }
    let mut broken = surface.clone();
    broken.points[3].y = f64::NAN;
    let refused = triangulate(&broken, &TriangulateOptions::default());
    assert!(matches!(refused, Err(TriangulateError::PointNotFinite { vertex: VertexId(3), .. })));
    broken.points.pop();
    let refused = triangulate(&broken, &TriangulateOptions::default());
    assert!(matches!(refused, Err(TriangulateError::PointCount { .. })));
    let mut broken = surface.clone();
    broken.details.levels = vec![vec![(Address::Corner(VertexId(0)), DVec3::INFINITY)]];
    let refused = triangulate(&broken, &TriangulateOptions::default());
    assert!(refused.is_err(), "an infinite detail");
    broken.details.levels = vec![Vec::new(), vec![(Address::Corner(VertexId(9999)), DVec3::ONE)]];
    assert!(triangulate(&broken, &TriangulateOptions::default()).is_ok(), "a detail that is nowhere moves nothing");
}
