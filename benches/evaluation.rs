//! Half a million limit points with first derivatives, at places in any order and by face.

mod support;

use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use selvedge_components::evaluate::Jet;
use selvedge_systems::subdivision::evaluate::{jets, jets_by_face};
use support::{Cut, torus};

const PLACES: usize = 500_000;

fn evaluation(criterion: &mut Criterion) {
    let cages = [
        ("regular, 1 000 faces", torus(25, 20, Cut::Regular)),
        ("irregular, 1 000 faces", torus(25, 20, Cut::Irregular)),
        ("irregular, 10 000 faces", torus(100, 50, Cut::Irregular)),
        ("irregular, 100 000 faces", torus(250, 200, Cut::Irregular)),
    ];
    for (name, cage) in cages {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(2));
        group.bench_function("preparation", |bench| bench.iter(|| cage.surface()));
        let (surface, mut places) = (cage.surface(), cage.places(PLACES));
        let mut out = vec![Jet::default(); PLACES];
        group.throughput(Throughput::Elements(PLACES as u64));
        group.bench_function("in no order", |bench| bench.iter(|| jets(&surface, &places, &mut out)));
        places.sort_by_key(|place| place.face);
        group.bench_function("by face", |bench| bench.iter(|| jets_by_face(&surface, &places, &mut out)));
        group.finish();
    }
}

criterion_group!(benches, evaluation);
criterion_main!(benches);
