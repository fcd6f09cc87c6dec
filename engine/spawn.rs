//! Surfaces and jobs into a world, and out of it again.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::DVec3;
use selvedge_components::curve::{Curve, Heading, SpaceCurve};
use selvedge_components::identity::{Serial, Serials};
use selvedge_components::job::{Fit, FitTarget};
use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::fit::FitOptions;
use selvedge_components::subdivision::{
    Cage, ControlPointIndex, ControlPointOf, ControlPoints, Detail, DetailLevel, DetailOf, LoopSurface, Position, Sides,
};
use selvedge_components::target::Target;
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{PreImagePoint, PreImages, Trim, TrimCurve, TrimOptions};

/// Spawns a surface with all its control points and details, each kind in one batch. Returns the
/// surface.
///
/// Faults are found in the next pass, and are then a
/// [`SurfaceFailed`](selvedge_components::error::SurfaceFailed) on it.
pub fn spawn_surface(world: &mut World, surface: &LoopSurface) -> Entity {
    let sides = Sides { sides: surface.sides.clone(), corner_rule: surface.corner_rule };
    let entity = spawn_parts(world, Arc::clone(&surface.mesh), &surface.points, sides);
    let levels = (0_u32..).zip(&surface.details.levels);
    let details =
        levels.flat_map(|(level, stored)| stored.iter().map(move |&(address, value)| (level, address, value)));
    world.spawn_batch(
        details.map(|(level, address, value)| (Detail(value), DetailLevel(level), address, DetailOf(entity))),
    );
    entity
}

/// Spawns a surface of `mesh` with control points `points` in the order of its vertices; its
/// borders are plain and have no corners. Returns the surface.
pub fn spawn_cage(world: &mut World, mesh: Arc<Connectivity>, points: &[DVec3]) -> Entity {
    let sides = Sides::plain(&mesh, &[]);
    spawn_parts(world, mesh, points, sides)
}

fn spawn_parts(world: &mut World, mesh: Arc<Connectivity>, points: &[DVec3], sides: Sides) -> Entity {
    let serial = next_serial(world);
    let surface = world.spawn((Cage { mesh }, sides, serial)).id();
    let rows = (0_u32..).zip(points).map(|(i, &at)| (Position(at), ControlPointOf(surface), ControlPointIndex(i)));
    let points: Vec<Entity> = world.spawn_batch(rows).collect();
    world.entity_mut(surface).insert(ControlPoints(points));
    surface
}

/// Despawns a surface with its control points and details. Jobs on it fail in the next pass.
pub fn despawn_surface(world: &mut World, surface: Entity) {
    let mut points = world.query::<(Entity, &ControlPointOf)>();
    let mut details = world.query::<(Entity, &DetailOf)>();
    let points = points.iter(world).filter(|(_, of)| of.0 == surface).map(|(entity, _)| entity);
    let mut parts: Vec<Entity> = points.collect();
    parts.extend(details.iter(world).filter(|(_, of)| of.0 == surface).map(|(entity, _)| entity));
    for part in parts {
        world.despawn(part);
    }
    world.despawn(surface);
}

/// Spawns a job that fits `surface` to `target`. Returns the job.
///
/// It begins in the next pass, and ends with a
/// [`FitReport`](selvedge_components::report::FitReport) or a
/// [`FitFailed`](selvedge_components::error::FitFailed) on it.
pub fn spawn_fit(world: &mut World, surface: Entity, target: Arc<dyn Target>, options: FitOptions) -> Entity {
    let serial = next_serial(world);
    world.spawn((Fit { surface }, FitTarget(target), options, serial)).id()
}

/// Takes a job back, and despawns it. If it was still running, the world is then as it was before
/// the job was spawned; the result of one that had finished stays.
pub fn cancel_fit(world: &mut World, job: Entity) {
    let mut details = world.query::<(Entity, &DetailOf)>();
    let own: Vec<Entity> = details.iter(world).filter(|(_, of)| of.0 == job).map(|(entity, _)| entity).collect();
    for detail in own {
        world.despawn(detail);
    }
    world.despawn(job);
}

/// Spawns a curve in space. Returns the curve.
pub fn spawn_curve(world: &mut World, curve: Arc<dyn Curve>) -> Entity {
    let serial = next_serial(world);
    world.spawn((SpaceCurve { curve }, serial)).id()
}

/// Spawns a trim of `source` by directed curves; what lies on their left stays. Returns the trim.
///
/// It begins in the next pass, and ends with a [`TrimReport`](selvedge_components::trim::TrimReport)
/// or a [`TrimFailed`](selvedge_components::trim::TrimFailed) on it. Without a tolerance every level
/// down to the last of `options` gets all its details.
pub fn spawn_trim(
    world: &mut World,
    source: Entity,
    cuts: &[(Entity, Heading)],
    tolerance: Option<Tolerance>,
    options: TrimOptions,
) -> Entity {
    let serial = next_serial(world);
    let cuts = cuts.iter().map(|&(curve, heading)| TrimCurve { curve, heading }).collect();
    let mut trim = world.spawn((Trim { source, cuts }, options, serial));
    if let Some(tolerance) = tolerance {
        trim.insert(tolerance);
    }
    trim.id()
}

/// Tells where curve `cut` of `trim` runs on the source, roughly: see [`PreImages`]. What is told of it
/// replaces what was told before; no points take that back. Nothing happens to what is no trim.
pub fn tell_pre_image(world: &mut World, trim: Entity, cut: usize, points: Vec<PreImagePoint>) {
    let Ok(mut trim) = world.get_entity_mut(trim) else { return };
    let Some(cuts) = trim.get::<Trim>().map(|trim| trim.cuts.len()).filter(|&cuts| cut < cuts) else { return };
    let mut given = trim.take::<PreImages>().unwrap_or_default();
    given.0.resize_with(cuts, || Arc::from([]));
    given.0[cut] = points.into();
    trim.insert(given);
}

fn next_serial(world: &mut World) -> Serial {
    Serial(world.get_resource_or_init::<Serials>().next_number())
}
