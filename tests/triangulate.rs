//! Triangles out: no T-junctions, the chord that was asked for, the same bits every way.

mod support;

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::subdivision::LoopSurface;
use selvedge_systems::audit::{Audit, AuditReport, audit};
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::triangulate::{Density, TriangulateOptions, Triangulation, triangulate};
use support::octant;

fn icosahedron() -> LoopSurface {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let points = [
        (-1.0, g, 0.0),
        (1.0, g, 0.0),
        (-1.0, -g, 0.0),
        (1.0, -g, 0.0),
        (0.0, -1.0, g),
        (0.0, 1.0, g),
        (0.0, -1.0, -g),
        (0.0, 1.0, -g),
        (g, 0.0, -1.0),
        (g, 0.0, 1.0),
        (-g, 0.0, -1.0),
        (-g, 0.0, 1.0),
    ];
    let faces = [
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    support::plain(points.iter().map(|&(x, y, z)| DVec3::new(x, y, z)).collect(), &faces)
}

fn torus(nu: u32, nv: u32) -> LoopSurface {
    let at = |i: u32, j: u32| {
        let (u, v) = (
            f64::from(i) / f64::from(nu) * std::f64::consts::TAU,
            f64::from(j) / f64::from(nv) * std::f64::consts::TAU,
        );
        let r = 1.0 + 0.4 * v.cos();
        DVec3::new(r * u.cos(), r * u.sin(), 0.4 * v.sin())
    };
    let name = |i: u32, j: u32| (i % nu) * nv + j % nv;
    let points = (0..nu).flat_map(|i| (0..nv).map(move |j| at(i, j))).collect();
    let faces: Vec<[u32; 3]> = (0..nu)
        .flat_map(|i| {
            (0..nv).flat_map(move |j| {
                [[name(i, j), name(i + 1, j), name(i + 1, j + 1)], [name(i, j), name(i + 1, j + 1), name(i, j + 1)]]
            })
        })
        .collect();
    support::plain(points, &faces)
}

fn to_chord(surface: &LoopSurface, chord: f64) -> Triangulation {
    let options = TriangulateOptions { density: Density::Chord(chord), ..TriangulateOptions::default() };
    triangulate(surface, &options).expect("the chord can be kept")
}

fn sound(report: &AuditReport) {
    assert!(report.is_sound(), "{} faults, first {:?}", report.faults.len(), report.faults.first());
}

#[test]
fn smoke() {
    let spot = selvedge::scenes::limit::spot().unwrap();
    let spot = support::plain(spot.positions.clone(), &spot.triangles);
    for (name, surface, size) in [
        ("ico", icosahedron(), 0.1),
        ("torus", torus(12, 6), 0.1),
        ("oct", octant("cone(1,2)"), 0.05),
        ("spot", spot, 0.02),
    ] {
        let limit = LimitSurface::new(Arc::new(surface.clone())).unwrap();
        for level in 0..4 {
            let options = TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() };
            let done = triangulate(&surface, &options).unwrap();
            sound(&audit(&done.triangles, &Audit::of(&surface)));
        }
        for k in 1..5 {
            let chord = size * 0.3_f64.powi(k);
            let start = std::time::Instant::now();
            let done = to_chord(&surface, chord);
            let time = start.elapsed();
            let report = audit(&done.triangles, &Audit::of(&surface).within(&limit, chord));
            println!(
                "{name} {chord:e} {} {:?} {:?} {time:?}\n   {:?}",
                done.triangles.triangles.len(),
                done.report.leaves,
                done.report.chord,
                report.measured
            );
            println!("   {}", done.report.worst_shape);
            sound(&report);
        }
    }
}
