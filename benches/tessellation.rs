//! A cage of 10 000 triangles to the 1.28 million limit points and 2.56 million triangles of level 4.

mod support;

use std::sync::Arc;
use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use selvedge::mesh::Connectivity;
use selvedge_components::subdivision::PlainLoop;
use selvedge_systems::subdivision::tessellate::{Faces, Tessellator, triangles};
use support::{Cage, Cut, torus};

const LEVEL: u32 = 4;

fn tessellation(criterion: &mut Criterion) {
    for (name, cut) in [("regular torus", Cut::Regular), ("irregular torus", Cut::Irregular)] {
        let cage = torus(100, 50, cut);
        let mut surface = cage.surface();
        let tessellator = Tessellator::new(surface.topology().mesh(), LEVEL).expect("level 4 of 10 000 faces fits");
        let mut positions = tessellator.positions(&surface).expect("the tessellator is the mesh's");
        let mut normals = positions.clone();

        let mut group = criterion.benchmark_group(format!("{name}, 10 000 faces, level 4"));
        group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(3));
        group.throughput(Throughput::Elements(positions.len() as u64));
        group.bench_function("cold: points and triangles", |bench| bench.iter(|| cold(&cage, Normals::No)));
        group.bench_function("cold: points, normals and triangles", |bench| bench.iter(|| cold(&cage, Normals::Yes)));
        group.bench_function("points moved: points", |bench| {
            bench.iter(|| {
                surface.move_points(&cage.points).expect("as many points, finite");
                tessellator.write_positions(&surface, Faces::All, &mut positions)
            });
        });
        group.bench_function("points moved: points and normals", |bench| {
            bench.iter(|| {
                surface.move_points(&cage.points).expect("as many points, finite");
                tessellator.write_positions(&surface, Faces::All, &mut positions)?;
                tessellator.write_normals(&surface, Faces::All, &mut normals)
            });
        });
        group.finish();
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Normals {
    No,
    Yes,
}

/// Everything from a list of faces on: connectivity, numbering, limit points, triangles.
fn cold(cage: &Cage, wanted: Normals) -> impl Sized {
    let mesh = Connectivity::new(cage.points.len(), &cage.faces).expect("a torus has no fault");
    let surface = PlainLoop::new(Arc::new(mesh), cage.points.clone(), &[]).expect("finite points");
    let mesh = surface.topology().mesh();
    let tessellator = Tessellator::new(mesh, LEVEL).expect("level 4 of 10 000 faces fits");
    let positions = tessellator.positions(&surface);
    let normals = (wanted == Normals::Yes).then(|| tessellator.normals(&surface));
    (positions, normals, triangles(mesh, tessellator.lattice()))
}

criterion_group!(benches, tessellation);
criterion_main!(benches);
