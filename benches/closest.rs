//! Closest points of limit surfaces: one query, with and without a hint, near and far.

#[path = "../tests/support/draw.rs"]
mod draw;
#[path = "support/mod.rs"]
mod meshes;
#[path = "../tests/support/mod.rs"]
mod support;

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use draw::{Draw, add_details, ball};
use glam::DVec3;
use selvedge::io::{Cage, Limits, read_cage};
use selvedge::scenes::limit::spot;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::subdivision::LoopSurface;
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::subdivision::limit::LimitSurface;

fn index(surface: LoopSurface) -> SurfaceIndex<LimitSurface> {
    let limit = LimitSurface::new(Arc::new(surface)).expect("a sound surface");
    SurfaceIndex::new(Arc::new(limit)).expect("a finite surface")
}

fn surfaces() -> Vec<(&'static str, LoopSurface)> {
    let (points, triangles) = ball(60, 7);
    let mut detailed = support::octant("cone(1,2)");
    add_details(&mut detailed, 4, 1e-3, 5);
    let plate = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/plates/plate32.obj");
    let plate = read_cage(&plate, &Limits::default()).expect("it is one of the engine's own");
    let torus = meshes::torus(100, 50, meshes::Cut::Regular);
    vec![
        ("ball", support::plain(points, &triangles)),
        ("octant", support::octant("cone(1,2)")),
        ("detailed octant", detailed),
        ("plate32", of_cage(&plate)),
        ("torus of 10 000 faces", support::plain(torus.points, &torus.faces)),
        ("spot", of_cage(&spot().expect("it is built in"))),
    ]
}

fn of_cage(cage: &Cage) -> LoopSurface {
    support::plain(cage.positions.clone(), &cage.triangles)
}

fn closest(c: &mut Criterion) {
    for (name, surface) in surfaces() {
        let index = index(surface);
        let limit = Arc::clone(index.surface());
        let mut group = c.benchmark_group(name);
        group.sample_size(10).warm_up_time(Duration::from_millis(200)).measurement_time(Duration::from_millis(500));
        group.bench_function("index", |b| b.iter(|| SurfaceIndex::new(Arc::clone(&limit))));
        let mut draw = Draw(1);
        let places: Vec<SurfacePoint> = (0..1024).map(|_| draw.place(limit.face_count())).collect();
        group.bench_function("jet", |b| each(b, &places, |at| limit.jet(*at)));
        for (distance, height) in [("on it", 1e-6), ("near", 1e-3), ("far", 0.1)] {
            let queries: Vec<(DVec3, SurfacePoint)> = places
                .iter()
                .map(|&at| {
                    let jet = limit.jet(at);
                    // The place of a question a twentieth of a face away.
                    let hint = SurfacePoint::new(at.face, (at.st.x - 0.05).max(0.0), at.st.y);
                    (jet.position + jet.normal() * height, hint)
                })
                .collect();
            group.bench_function(format!("closest, {distance}"), |b| each(b, &queries, |q| index.closest(q.0)));
            group.bench_function(format!("from a hint, {distance}"), |b| {
                each(b, &queries, |q| index.closest_from(q.0, q.1));
            });
            group.bench_function(format!("around a hint, {distance}"), |b| {
                each(b, &queries, |q| index.closest_around(q.0, q.1));
            });
        }
    }
}

/// One item per iteration, in turn.
fn each<T, R>(b: &mut criterion::Bencher, items: &[T], mut f: impl FnMut(&T) -> R) {
    let mut i = 0;
    b.iter(|| {
        i = (i + 1) % items.len();
        black_box(f(&items[i]))
    });
}

criterion_group!(benches, closest);
criterion_main!(benches);
