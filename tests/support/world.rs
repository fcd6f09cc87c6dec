//! Worlds that a host would have, and what can be read from them.

use std::fmt::Debug;
use std::sync::Arc;

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use glam::DVec3;
use selvedge::error::{CurveFailed, FitFailed, SurfaceFailed};
use selvedge::identity::{Serial, Serials};
use selvedge::job::{AtCorrespond, AtModify, AtRefine, Cancelled, Fit, FitJob, FitTarget};
use selvedge::report::FitReport;
use selvedge::subdivision::fit::FitOptions;
use selvedge::subdivision::{
    Address, Cage, ControlPointIndex, ControlPointOf, ControlPoints, Detail, DetailLevel, DetailOf, LoopSurface,
    Position, Sides, Snapshot,
};
use selvedge::tolerance::Tolerance;
use selvedge::{Projection, Target, install, strict};

/// A bare world and schedule with the engine in it, ambiguities being errors.
pub fn host() -> (World, Schedule) {
    let (mut world, mut schedule) = (World::new(), Schedule::default());
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(strict());
    install(&mut world, &mut schedule);
    (world, schedule)
}

/// The sphere of radius 0.5.
pub fn sphere() -> Arc<dyn Target> {
    Arc::new(Projection(|p: DVec3| p.normalize() * 0.5))
}

/// A fit down to level `last`, without a tolerance.
pub fn down_to(last_level: u32) -> FitOptions {
    FitOptions { last_level, ..FitOptions::default() }
}

/// An octahedron of radius 0.5.
pub fn octahedron() -> LoopSurface {
    let faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let axes = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    super::plain(axes.map(|a| 0.5 * a).to_vec(), &faces)
}

/// A torus of `n` by `m` quads, each cut in two.
pub fn torus(n: u32, m: u32) -> LoopSurface {
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let mut faces = Vec::new();
    let mut points = Vec::new();
    for i in 0..n {
        for j in 0..m {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            let turn = |k: u32, of: u32| std::f64::consts::TAU * f64::from(k) / f64::from(of);
            let (a, b) = (turn(i, n), turn(j, m));
            let r = 1.0 + 0.3 * b.cos();
            points.push(DVec3::new(r * a.cos(), r * a.sin(), 0.3 * b.sin()));
        }
    }
    super::plain(points, &faces)
}

/// All numbers of a surface, digit for digit.
pub fn bits(surface: &LoopSurface) -> Vec<u64> {
    let details = surface.details.levels.iter().flatten().map(|d| d.1);
    let vectors = surface.points.iter().copied().chain(details);
    vectors.flat_map(|v| v.to_array()).map(f64::to_bits).collect()
}

/// The bits of the snapshots of all surfaces in the order of their serials, and of all ladders.
pub fn world_bits(world: &mut World) -> Vec<u64> {
    let mut surfaces: Vec<_> = world.query::<(&Serial, &Snapshot)>().iter(world).collect();
    surfaces.sort_unstable_by_key(|s| s.0);
    let mut all: Vec<u64> =
        surfaces.iter().flat_map(|(serial, s)| [vec![serial.0], bits(&s.surface)].concat()).collect();
    let mut reports: Vec<_> = world.query::<(&Serial, &FitReport)>().iter(world).collect();
    reports.sort_unstable_by_key(|r| r.0);
    for (serial, report) in reports {
        all.push(serial.0);
        all.extend(
            report.ladder.iter().flat_map(|rung| [rung.max.to_bits(), rung.mean.to_bits(), rung.details as u64]),
        );
    }
    all
}

/// The surface as the world's entities say it is, gathered the slow way.
pub fn by_hand(world: &mut World, surface: Entity) -> Vec<u64> {
    let mut points: Vec<_> = world
        .query_filtered::<(&ControlPointOf, &ControlPointIndex, &Position), Or<(With<Disabled>, Without<Disabled>)>>()
        .iter(world)
        .filter(|(of, ..)| of.0 == surface)
        .map(|(_, index, at)| (index.0, at.0))
        .collect();
    points.sort_by_key(|p| p.0);
    let mut details: Vec<_> = world
        .query::<(&DetailOf, &DetailLevel, &Address, &Detail)>()
        .iter(world)
        .filter(|(of, ..)| of.0 == surface)
        .map(|(_, level, address, value)| (*level, *address, value.0))
        .collect();
    details.sort_by_key(|d| (d.0, d.1));
    let vectors = points.into_iter().map(|p| p.1).chain(details.into_iter().map(|d| d.2));
    vectors.flat_map(|v| v.to_array()).map(f64::to_bits).collect()
}

/// The snapshot of a surface that has one.
pub fn snapshot(world: &World, surface: Entity) -> &Snapshot {
    world.get::<Snapshot>(surface).expect("the surface is sound")
}

/// How many details belong to `owner`.
pub fn details_of(world: &mut World, owner: Entity) -> usize {
    world.query::<&DetailOf>().iter(world).filter(|of| of.0 == owner).count()
}

/// Every entity with the names of all its components and the values of those of the engine.
pub fn dump(world: &mut World) -> Vec<String> {
    let mut entities: Vec<Entity> =
        world.query_filtered::<Entity, Or<(With<Disabled>, Without<Disabled>)>>().iter(world).collect();
    entities.sort_unstable();
    entities.into_iter().map(|entity| format!("{entity}: {:?}", values(world, entity))).collect()
}

fn values(world: &World, entity: Entity) -> Vec<String> {
    let found = world.entity(entity);
    let names = world.inspect_entity(entity).expect("the entity is there").map(|(_, info)| info.name().to_string());
    let mut all: Vec<String> = names.collect();
    all.sort_unstable();
    fn value<T: Component + Debug>(entity: EntityRef<'_>) -> Option<String> {
        entity.get::<T>().map(|value| format!("{value:?}"))
    }
    all.extend(
        [
            value::<Serial>(found),
            value::<Cage>(found),
            value::<Sides>(found),
            value::<ControlPoints>(found),
            value::<Position>(found),
            value::<ControlPointOf>(found),
            value::<ControlPointIndex>(found),
            value::<Detail>(found),
            value::<DetailLevel>(found),
            value::<Address>(found),
            value::<DetailOf>(found),
            value::<Snapshot>(found),
            value::<SurfaceFailed>(found),
            value::<CurveFailed>(found),
            value::<Fit>(found),
            value::<FitTarget>(found),
            value::<FitOptions>(found),
            value::<Tolerance>(found),
            value::<FitJob>(found),
            value::<FitReport>(found),
            value::<FitFailed>(found),
            value::<AtCorrespond>(found),
            value::<AtModify>(found),
            value::<AtRefine>(found),
            value::<Cancelled>(found),
        ]
        .into_iter()
        .flatten(),
    );
    all
}

/// A world's dump without what counts or numbers: the resources, which are entities too.
pub fn dump_without_resources(world: &mut World) -> Vec<String> {
    let _ = world.get_resource::<Serials>();
    dump(world).into_iter().filter(|line| !line.contains("IsResource")).collect()
}
