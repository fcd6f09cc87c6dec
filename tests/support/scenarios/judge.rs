//! Looks at what trims have left as a stranger would.

use std::sync::Arc;

use glam::DVec3;
use selvedge::TrimProgress;
use selvedge::bevy_ecs::prelude::*;
use selvedge::budget::Budgets;
use selvedge::curve::{Curve, Heading, Traversal};
use selvedge::evaluate::{Evaluate, SurfacePoint};
use selvedge::mesh::FaceId;
use selvedge::subdivision::{Border, LoopSurface, Snapshot};
use selvedge::trim::{Sides, Stale, TrimOptions};
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::subdivision::limit::LimitSurface;

use super::grounds::Start;
use super::seam::{Seam, bits, seam};
use super::world::{Live, Model};
use super::{Draw, view};

type Index = SurfaceIndex<LimitSurface>;

/// What is wrong with what a world has come to.
pub fn judge(start: &Start, live: &mut Live, model: &Model, draw: &mut Draw) -> Option<String> {
    let made = |trim: &Entity| matches!(live.engine.trim_progress(*trim), Some(TrimProgress::Finished(_)));
    let done: Vec<usize> = (0..live.trims.len()).filter(|&t| made(&live.trims[t])).collect();
    if done.is_empty() {
        return None;
    }
    let Some(result) = live.engine.result(live.source).and_then(|result| present(live, result)) else {
        return Some("trims are made, and there is no present result".into());
    };
    let fit = done.iter().map(|&t| model.trims[t].tolerance.fit).fold(0.0, f64::max);
    let source = indexed(&Arc::new(model.surface.clone())).expect("it was trimmed");
    let kept = match within(&result, &source, fit, draw) {
        Ok(index) => index,
        Err(why) => return Some(format!("the result: {why}")),
    };
    for &t in done.iter().filter(|&&t| model.trims[t].options.sides == Sides::Both) {
        let other = live.engine.other_side(live.trims[t]).and_then(|other| present(live, other));
        let Some(other) = other else { return Some(format!("trim {t} has no other side")) };
        let index = match within(&other, &source, fit, draw) {
            Ok(index) => index,
            Err(why) => return Some(format!("the other side of trim {t}: {why}")),
        };
        let lines = model.trims[t].cuts.iter().filter_map(|&(line, _)| model.lines[line].curve.clone());
        let lines: Vec<_> = lines.collect();
        for level in [0, 2] {
            if let Err(why) = meets(&result, &other, &lines, level) {
                return Some(format!("the seam of trim {t} at level {level}: {why}"));
            }
        }
        if done.len() == 1
            && let Err(why) = cover(&source, &[&kept, &index], fit, draw)
        {
            return Some(why);
        }
    }
    baked(start, live, model, &result, &kept, draw)
}

/// Is a baked result the same surface, and can it be trimmed in turn?
fn baked(
    start: &Start,
    live: &mut Live,
    model: &Model,
    result: &Arc<LoopSurface>,
    kept: &Index,
    draw: &mut Draw,
) -> Option<String> {
    let entity = live.engine.result(live.source)?;
    let own = match live.engine.bake(entity) {
        Ok(own) => own,
        Err(why) => return Some(why.to_string()),
    };
    let line = live.engine.spawn_curve(model.new_line(start, draw).curve?);
    let cut = [(line, Heading::Against)];
    let again = live.engine.spawn_trim(own, &cut, Some(model.tolerance), TrimOptions::default());
    if let Err(busy) = live.settle() {
        return Some(format!("trimming what was baked: {busy}"));
    }
    let Some(surface) = present(live, own) else { return Some("what was baked is refused".into()) };
    if view::bits(&surface, model) != view::bits(result, model) {
        return Some("what was baked is not the same surface".into());
    }
    if !matches!(live.engine.trim_progress(again), Some(TrimProgress::Finished(_))) {
        return None;
    }
    let Some(left) = live.engine.result(own).and_then(|left| present(live, left)) else {
        return Some("what was baked is trimmed, and there is no result".into());
    };
    within(&left, kept, model.tolerance.fit, draw).err().map(|why| format!("what was baked, trimmed: {why}"))
}

fn present(live: &Live, result: Entity) -> Option<Arc<LoopSurface>> {
    let entity = live.engine.world().get_entity(result).ok()?;
    entity.get::<Snapshot>().filter(|_| !entity.contains::<Stale>()).map(|snapshot| Arc::clone(&snapshot.surface))
}

fn indexed(surface: &Arc<LoopSurface>) -> Result<Index, String> {
    let limit = LimitSurface::new(Arc::clone(surface)).map_err(|e| e.to_string())?;
    SurfaceIndex::new(Arc::new(limit)).map_err(|e| e.to_string())
}

/// Is a surface sound, are its borders their curves', and is it near the source?
fn within(surface: &Arc<LoopSurface>, source: &Index, fit: f64, draw: &mut Draw) -> Result<Index, String> {
    if let Some(fault) = selvedge_systems::check::surface_faults(surface, &Budgets::default()).first() {
        return Err(fault.to_string());
    }
    on_curves(surface)?;
    let index = indexed(surface)?;
    let mut worst = (0.0, DVec3::ZERO);
    for f in 0..surface.mesh.face_count() {
        for _ in 0..5 {
            let [s, t] = draw.in_triangle();
            let x = index.surface().position(SurfacePoint::new(FaceId::new(f), s, t));
            let off = source.closest(x).map_err(|e| format!("face {f}: {e}"))?.distance;
            worst = if off > worst.0 { (off, x) } else { worst };
        }
    }
    let (off, x) = worst;
    if off > fit { Err(format!("{x} is {off:e} off the source, {fit:e} allowed")) } else { Ok(index) }
}

fn on_curves(surface: &LoopSurface) -> Result<(), String> {
    for side in &surface.sides {
        let Border::Given { curve, first, heading } = &side.border else { continue };
        let along = Traversal { first: *first, heading: *heading };
        for step in 0..(side.edge_count() as u64) << 2 {
            let place = along.vertex(curve, 2, step);
            let sample = curve.sample(2, place);
            let on = side.point_on(2, step, 0.0).ok_or("a given side has no point")?;
            if bits(sample) != bits(on) || bits(sample) != bits(curve.curve().position(curve.parameter(2, place))) {
                return Err(format!("border sample {on} is not the curve's {sample}"));
            }
        }
    }
    Ok(())
}

/// Is every place of the source on one of its parts?
fn cover(source: &Index, parts: &[&Index], fit: f64, draw: &mut Draw) -> Result<(), String> {
    for f in 0..source.surface().face_count() {
        for _ in 0..4 {
            let [s, t] = draw.in_triangle();
            let y = source.surface().position(SurfacePoint::new(FaceId::new(f), s, t));
            let off = parts.iter().filter_map(|part| part.closest(y).ok()).map(|found| found.distance);
            let off = off.fold(f64::INFINITY, f64::min);
            if off > fit {
                return Err(format!("{y} is on neither side: {off:e} off"));
            }
        }
    }
    Ok(())
}

/// Is every border edge of `other` along `lines` one of `kept`, the other way?
fn meets(kept: &LoopSurface, other: &LoopSurface, lines: &[Arc<dyn Curve>], level: u32) -> Result<(), String> {
    let Seam { expected, found, open } = seam(kept, other, lines, level)?;
    if expected == 0 || open > 0 {
        return Err(format!("{open} of {found} edges are open, {expected} run along its curves"));
    }
    Ok(())
}
