//! Bores: one in the plate of 64 squares to two tolerances, and 1, 8 and 64 in the wavy plate.

#[path = "support/wavy.rs"]
mod wavy;

use std::time::Duration;

use criterion::{BatchSize, BenchmarkGroup, Criterion, criterion_group, criterion_main, measurement::WallTime};
use selvedge::subdivision::LoopSurface;
use selvedge_systems::subdivision::trim::Ground;
use wavy::{Bore, SIZE};

/// Of the seed of the method: a bore of 60 mm, a little off the middle.
const BORE: Bore = [0.013, -0.007, 0.06];

fn plate8(criterion: &mut Criterion) {
    let ground: std::sync::Arc<Ground> = selvedge::scenes::trims::ground::plate8().expect("the plate is built in");
    let mut group = group(criterion, "plate of 64 squares, one bore");
    for (name, eps) in [("to 13 um", 13e-6), ("to 1 um", 1e-6)] {
        bench(&mut group, name, &ground.surface, &[BORE], eps);
    }
    group.finish();
}

fn wavy_plate(criterion: &mut Criterion) {
    let surface = wavy::endless(22, SIZE / 22.0).expect("a lattice is a mesh");
    let mut group = group(criterion, "wavy plate of 484 squares, to 10 um");
    for count in [1, 8, 64] {
        bench(&mut group, &format!("{count} bores"), &surface, &wavy::even_bores(count, SIZE), 1e-5);
    }
    group.finish();
}

fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    group
}

/// All passes from spawned trims to audited results.
fn bench(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, surface: &LoopSurface, bores: &[Bore], eps: f64) {
    group.bench_function(name, |bench| {
        let ready = || wavy::engine(surface, bores, eps).expect("circles over the plate");
        bench.iter_batched_ref(ready, wavy::finish, BatchSize::LargeInput);
    });
}

criterion_group!(benches, plate8, wavy_plate);
criterion_main!(benches);
