//! What a host does to a world.

use std::sync::Arc;

use glam::DVec3;
use selvedge::bevy_ecs::prelude::*;
use selvedge::curve::{Heading, SpaceCurve};
use selvedge::job::Cancelled;
use selvedge::subdivision::Position;
use selvedge::tolerance::Tolerance;
use selvedge::triangulation::{Density, TriangulateOptions};
use selvedge::trim::{Omega, Sides, Trim, TrimCurve, TrimJob, TrimOptions};

use super::Draw;
use super::grounds::Start;
use super::world::{Live, Model};

/// Does one thing to a world, and to what it should be. Returns what.
pub fn edit(start: &Start, model: &mut Model, live: &mut Live, draw: &mut Draw) -> String {
    if model.trims.is_empty() {
        return add(start, model, live, draw);
    }
    let trim = draw.below(model.trims.len());
    let entity = live.trims[trim];
    match draw.below(20) {
        0..=2 => {
            let line = draw.below(model.lines.len());
            let mut with = model.clone();
            with.lines.truncate(line);
            model.lines[line] = with.new_line(start, draw);
            let curve = model.lines[line].curve.clone().expect("a curve");
            live.engine.world_mut().entity_mut(live.lines[line]).insert(SpaceCurve { curve });
            format!("curve {line} replaced")
        }
        3 | 4 => {
            let index = draw.below(model.surface.points.len());
            let far = model.tolerance.curve * if draw.chance(0.3) { 3.0 } else { 0.3 };
            let by = far * (DVec3::new(draw.unit(), draw.unit(), draw.unit()) - 0.5);
            move_point(model, live, index, model.surface.points[index] + by);
            format!("point {index} moved by {by}")
        }
        5 => {
            let times = if draw.chance(0.5) { 0.3 } else { 2.0 };
            let Tolerance { fit, chord, curve } = model.trims[trim].tolerance;
            tolerate(model, live, trim, Tolerance { fit: fit * times, chord, curve });
            format!("tolerance of trim {trim} times {times}")
        }
        6 | 7 => add(start, model, live, draw),
        8 | 9 => {
            model.trims.remove(trim);
            live.trims.remove(trim);
            live.engine.world_mut().despawn(entity);
            format!("trim {trim} removed")
        }
        10 => {
            let cut = draw.below(model.trims[trim].cuts.len());
            let heading = &mut model.trims[trim].cuts[cut].1;
            *heading = if *heading == Heading::Along { Heading::Against } else { Heading::Along };
            live.engine.world_mut().get_mut::<Trim>(entity).expect("a trim").cuts[cut].heading = *heading;
            format!("cut {cut} of trim {trim} turned")
        }
        11 => {
            let sides = &mut model.trims[trim].options.sides;
            *sides = if *sides == Sides::Both { Sides::Left } else { Sides::Both };
            live.engine.world_mut().get_mut::<TrimOptions>(entity).expect("a trim").sides = *sides;
            format!("trim {trim} wants {sides:?}")
        }
        12 => {
            let density = Density::Level(1 + draw.below(2) as u32);
            model.triangles = Some(TriangulateOptions { density, ..TriangulateOptions::default() });
            if let Some(result) = live.engine.result(live.source) {
                live.engine.world_mut().entity_mut(result).insert(model.triangles.expect("options"));
            }
            format!("triangles at {density:?}")
        }
        13 => touch(model, live, draw),
        14 => {
            let cancelled = &mut model.trims[trim].cancelled;
            *cancelled = !*cancelled;
            let mut entity = live.engine.world_mut().entity_mut(entity);
            if *cancelled {
                entity.insert(Cancelled)
            } else {
                entity.remove::<Cancelled>()
            };
            format!("trim {trim} cancelled: {cancelled}")
        }
        15 => {
            let asked = model.trims.remove(trim);
            live.trims.remove(trim);
            live.engine.world_mut().despawn(entity);
            (0..draw.below(3)).for_each(|_| live.update());
            live.spawn_trim(&asked);
            model.trims.push(asked);
            format!("trim {trim} spawned again")
        }
        16 => {
            let line = draw.below(model.lines.len());
            if model.lines[line].curve.take().is_some() {
                live.engine.world_mut().entity_mut(live.lines[line]).remove::<SpaceCurve>();
            }
            format!("curve {line} removed")
        }
        17 => {
            let index = draw.below(model.surface.points.len());
            let before = model.surface.points[index];
            let wrong = if draw.chance(0.5) { DVec3::NAN } else { before + 1e-3 * model.edge };
            live.move_point(index, wrong);
            let passes = draw.below(30);
            (0..passes).for_each(|_| live.update());
            live.move_point(index, before);
            format!("point {index} at {wrong} for {passes} passes")
        }
        18 => {
            let omega = &mut model.trims[trim].options.omega;
            *omega = if *omega == Omega::Changed { Omega::Neighbourhood } else { Omega::Changed };
            live.engine.world_mut().get_mut::<TrimOptions>(entity).expect("a trim").omega = *omega;
            format!("trim {trim} may fit {omega:?}")
        }
        _ => {
            if draw.chance(0.5) {
                live.engine.world_mut().entity_mut(entity).remove::<TrimJob>();
                format!("the job of trim {trim} dropped")
            } else {
                let bad = if draw.chance(0.5) { f64::NAN } else { -1.0 };
                let tolerance = model.trims[trim].tolerance;
                tolerate(model, live, trim, Tolerance { fit: bad, ..tolerance });
                if draw.chance(0.6) {
                    (0..draw.below(12)).for_each(|_| live.update());
                    tolerate(model, live, trim, tolerance);
                }
                format!("tolerance of trim {trim} was {bad}")
            }
        }
    }
}

fn add(start: &Start, model: &mut Model, live: &mut Live, draw: &mut Draw) -> String {
    model.add_trim(start, draw);
    for line in live.lines.len()..model.lines.len() {
        live.spawn_line(&model.lines[line]);
    }
    live.spawn_trim(&model.trims[model.trims.len() - 1]);
    format!("trim {} added", model.trims.len() - 1)
}

fn move_point(model: &mut Model, live: &mut Live, index: usize, to: DVec3) {
    model.surface.points[index] = to;
    live.move_point(index, to);
}

fn tolerate(model: &mut Model, live: &mut Live, trim: usize, tolerance: Tolerance) {
    model.trims[trim].tolerance = tolerance;
    live.engine.world_mut().entity_mut(live.trims[trim]).insert(tolerance);
}

/// Writes what is there already.
fn touch(model: &Model, live: &mut Live, draw: &mut Draw) -> String {
    let (point, index) = (draw.below(model.surface.points.len()), draw.below(model.trims.len()));
    let (at, trim) = (live.point(point), live.trims[index]);
    let cuts = model.trims[index].cuts.iter();
    let cuts = cuts.map(|&(line, heading)| TrimCurve { curve: live.lines[line], heading }).collect();
    let asked = Trim { source: live.source, cuts };
    let world = live.engine.world_mut();
    world.get_mut::<Position>(at).expect("a point").set_changed();
    world.entity_mut(trim).insert((asked, model.trims[index].tolerance, model.trims[index].options.clone()));
    for (entity, line) in live.lines.iter().zip(&model.lines) {
        if let Some(curve) = &line.curve {
            world.entity_mut(*entity).insert(SpaceCurve { curve: Arc::clone(curve) });
        }
    }
    format!("trim {index} touched")
}
