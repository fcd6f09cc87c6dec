//! An octant of a sphere with one irregular vertex, fitted level by level.

use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use selvedge::scenes::octant::{self, Method, RADIUS};
use selvedge::subdivision::LoopSurface;
use selvedge::subdivision::fit::FitOptions;
use selvedge::{DVec3, Projection};
use selvedge_components::subdivision::CornerRule;
use selvedge_systems::subdivision::fit::{FitWork, Quantum};

fn octant_fit(criterion: &mut Criterion) {
    let meshes = octant::meshes().expect("the meshes are built in");
    let cone = meshes.iter().find(|mesh| mesh.name == "cone(1,2)").expect("it is one of them");
    let surface = Arc::new(octant::surface(cone, CornerRule::Lattice).expect("its sides have vertices"));
    let whole = octant::options(Method::Lsq);
    let cases = [
        ("to level 3", FitOptions { last_level: 3, ..whole.clone() }),
        ("to level 5", FitOptions { last_level: 5, ..whole.clone() }),
        ("adaptively to 1e-6", FitOptions { last_level: 8, tolerance: Some(1e-6), ..whole }),
    ];
    let mut group = criterion.benchmark_group("octant, cone(1,2)");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(5));
    for (name, options) in cases {
        group.bench_function(name, |bench| bench.iter(|| fit(&surface, options.clone())));
    }
    group.finish();
}

/// The whole of a fit: every level refined, asked, solved and measured two levels finer.
fn fit(surface: &Arc<LoopSurface>, options: FitOptions) -> FitWork {
    let sphere = Arc::new(Projection(|p: DVec3| p * (RADIUS / p.length())));
    let mut work = FitWork::new(Arc::clone(surface), sphere, options).expect("a sound surface");
    while work.advance().expect("a sphere can be asked anywhere") != Quantum::Finished {}
    work
}

criterion_group!(benches, octant_fit);
criterion_main!(benches);
