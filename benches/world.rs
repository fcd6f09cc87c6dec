//! A million control points as entities: spawned, gathered, left alone, edited.
//!
//! One thread and one processor matter here: everything but the check of the numbers is memory.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Duration;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use selvedge::mesh::Connectivity;
use selvedge::subdivision::{ControlPoints, Position, Snapshot};
use selvedge::{DVec3, install, spawn_cage, strict};

/// Along each way round the torus: a million control points, two million faces.
const SIDE: u32 = 1000;

fn torus() -> (Arc<Connectivity>, Vec<DVec3>) {
    let at = |i: u32, j: u32| (i % SIDE) * SIDE + j % SIDE;
    let quad =
        |i: u32, j: u32| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    let faces: Vec<_> = (0..SIDE).flat_map(|i| (0..SIDE).flat_map(move |j| quad(i, j))).collect();
    let turn = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(SIDE);
    let point = |i: u32, j: u32| {
        let (a, b) = (turn(i), turn(j));
        let r = 1.0 + 0.3 * b.cos();
        DVec3::new(r * a.cos(), r * a.sin(), 0.3 * b.sin())
    };
    let points = (0..SIDE).flat_map(|i| (0..SIDE).map(move |j| point(i, j))).collect::<Vec<_>>();
    let mesh = Connectivity::new(points.len(), &faces).expect("a torus has no fault");
    (Arc::new(mesh), points)
}

fn host() -> (World, Schedule) {
    let (mut world, mut schedule) = (World::new(), Schedule::default());
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(strict());
    install(&mut world, &mut schedule);
    (world, schedule)
}

fn million_control_points(criterion: &mut Criterion) {
    let (mesh, points) = torus();
    let mut group = criterion.benchmark_group("1e6 control points");
    group.sample_size(10).warm_up_time(Duration::from_secs(1)).measurement_time(Duration::from_secs(5));

    group.bench_function("spawn", |bench| {
        bench.iter_batched(
            || (World::new(), Arc::clone(&mesh)),
            |(mut world, mesh)| {
                spawn_cage(&mut world, mesh, &points);
                world
            },
            BatchSize::PerIteration,
        );
    });
    group.bench_function("first pass: gather and check", |bench| {
        bench.iter_batched(
            || {
                let (mut world, mut schedule) = host();
                schedule.run(&mut world);
                spawn_cage(&mut world, Arc::clone(&mesh), &points);
                (world, schedule)
            },
            |(mut world, mut schedule)| {
                schedule.run(&mut world);
                (world, schedule)
            },
            BatchSize::PerIteration,
        );
    });

    let (mut world, mut schedule) = host();
    let surface = spawn_cage(&mut world, mesh, &points);
    schedule.run(&mut world);
    group.bench_function("pass in which nothing changed", |bench| bench.iter(|| schedule.run(&mut world)));
    let one = world.get::<ControlPoints>(surface).expect("it was spawned").0[123_456];
    group.bench_function("edit of one, and a pass", |bench| {
        bench.iter(|| {
            world.get_mut::<Position>(one).expect("it was spawned").0.x += 1e-6;
            schedule.run(&mut world);
        });
    });
    let mut all = world.query::<&mut Position>();
    group.bench_function("edit of all, and a pass", |bench| {
        bench.iter(|| {
            for mut slice in all.contiguous_iter_mut(&mut world).expect("positions are stored in tables") {
                slice.iter_mut().for_each(|at| at.0.z += 1e-6);
            }
            schedule.run(&mut world);
        });
    });
    group.bench_function("touch of all with the same value, and a pass", |bench| {
        bench.iter(|| {
            for mut slice in all.contiguous_iter_mut(&mut world).expect("positions are stored in tables") {
                slice.mark_all_as_changed();
            }
            schedule.run(&mut world);
        });
    });
    // Somebody holds the surface as it was: it is copied before it is changed.
    group.bench_function("edit of one while the snapshot is held, and a pass", |bench| {
        bench.iter(|| {
            let held = world.get::<Snapshot>(surface).map(|snapshot| Arc::clone(&snapshot.surface));
            world.get_mut::<Position>(one).expect("it was spawned").0.x += 1e-6;
            schedule.run(&mut world);
            black_box(held);
        });
    });
    group.finish();
}

criterion_group!(benches, million_control_points);
criterion_main!(benches);
