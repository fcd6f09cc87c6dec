//! Two worlds side by side.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use glam::DVec3;
use selvedge::TrimProgress;
use selvedge::bevy_ecs::prelude::*;
use selvedge::subdivision::{Border, DetailOf, LoopSurface, Snapshot};
use selvedge::triangles::Triangles;
use selvedge::trim::{OtherSideOf, ResultOf, Stale};

use super::world::{Live, Model};

/// What is not the same in a world that was edited and one that was not.
pub fn differ(live: &mut Live, fresh: &mut Live, model: &Model) -> Option<String> {
    if let Some(options) = model.triangles {
        for world in [&mut *live, &mut *fresh] {
            if let Some(result) = world.engine.result(world.source) {
                world.engine.world_mut().entity_mut(result).insert(options);
                if let Err(busy) = world.settle() {
                    return Some(busy);
                }
            }
        }
    }
    let (lines, expected) = (lines(live, model), lines(fresh, model));
    let differs = lines.iter().zip(&expected).find(|(a, b)| a != b);
    let differs = differs.map(|(a, b)| format!("{a}\n      fresh: {b}"));
    differs
        .or_else(|| (lines.len() != expected.len()).then(|| format!("{} lines, not {}", lines.len(), expected.len())))
}

/// All that a world has come to, entities by what they are in the model.
fn lines(live: &mut Live, model: &Model) -> Vec<String> {
    let mut lines = Vec::new();
    let mut made = 0;
    for (t, &trim) in live.trims.iter().enumerate() {
        let progress = live.engine.trim_progress(trim);
        made += u64::from(matches!(progress, Some(TrimProgress::Finished(_))));
        let other = live.engine.other_side(trim).map(|other| surface(live, other, model));
        lines.push(format!("trim {t}: {}", named(live, &format!("{progress:?}"))));
        lines.push(format!("other side of trim {t}: {other:?}"));
    }
    // What was left last stays where nothing could be made, and says so.
    let result = live.engine.result(live.source);
    let present = result.filter(|&result| made > 0 || live.engine.world().get::<Stale>(result).is_none());
    lines.push(format!("result: {:?}", present.map(|result| surface(live, result, model))));
    let source = live.engine.surface(live.source).map(|s| s.map(|s| bits(s, model)).map_err(|why| why.to_string()));
    lines.push(format!("source: {source:?}"));
    let trims = live.trims.clone();
    let result = live.engine.result(live.source);
    let world = live.engine.world_mut();
    let results = world.query_filtered::<Entity, With<ResultOf>>().iter(world).filter(|&e| Some(e) != result).count();
    let others = world.query::<&OtherSideOf>().iter(world).count();
    let source = live.source;
    let owner = |of: &DetailOf| (of.0 != source).then(|| trims.iter().position(|&trim| trim == of.0));
    let mut owners: Vec<_> = world.query::<&DetailOf>().iter(world).filter_map(owner).collect();
    owners.sort_unstable();
    let mut counts: Vec<(Option<usize>, usize)> = Vec::new();
    for owner in owners {
        match counts.last_mut().filter(|last| last.0 == owner) {
            Some(last) => last.1 += 1,
            None => counts.push((owner, 1)),
        }
    }
    lines.push(format!("lost results: {results}, other sides: {others}, details by trim: {counts:?}"));
    lines
}

fn named(live: &Live, text: &str) -> String {
    let mut names: Vec<(String, String)> = Vec::new();
    let all = live.trims.iter().enumerate().map(|(k, e)| (e, format!("<trim {k}>")));
    let all = all.chain(live.lines.iter().enumerate().map(|(k, e)| (e, format!("<curve {k}>"))));
    names.extend(all.map(|(entity, name)| (format!("{entity:?}"), name)));
    names.push((format!("{:?}", live.source), "<source>".into()));
    names.sort_by_key(|(entity, _)| core::cmp::Reverse(entity.len()));
    names.into_iter().fold(text.to_owned(), |text, (entity, name)| text.replace(&entity, &name))
}

/// A result: its bits, and whether it is the present one.
fn surface(live: &Live, entity: Entity, model: &Model) -> String {
    let Ok(entity) = live.engine.world().get_entity(entity) else { return "gone".into() };
    let Some(Snapshot { surface, .. }) = entity.get::<Snapshot>() else { return "without a snapshot".into() };
    let triangles = entity.get::<Triangles>().map(|made| {
        let mut hash = DefaultHasher::new();
        made.positions.iter().chain(&made.normals).for_each(|&x| hash_point(x, &mut hash));
        (&made.triangles, &made.faces.len()).hash(&mut hash);
        (made.triangles.len(), hash.finish())
    });
    format!("{}, stale: {}, triangles {triangles:?}", bits(surface, model), entity.contains::<Stale>())
}

fn hash_point(x: DVec3, hash: &mut DefaultHasher) {
    x.to_array().map(f64::to_bits).hash(hash);
}

/// All that a surface is.
pub fn bits(surface: &LoopSurface, model: &Model) -> String {
    let part = |write: &dyn Fn(&mut DefaultHasher)| {
        let mut hash = DefaultHasher::new();
        write(&mut hash);
        hash.finish() as u32
    };
    let mesh = part(&|hash| surface.mesh.faces().iter().for_each(|f| f.map(|v| v.0).hash(hash)));
    let points = part(&|hash| surface.points.iter().for_each(|&x| hash_point(x, hash)));
    let details = part(&|hash| {
        for (address, value) in surface.details.levels.iter().flatten() {
            format!("{address:?}").hash(hash);
            hash_point(*value, hash);
        }
    });
    let sides: Vec<String> = surface
        .sides
        .iter()
        .map(|side| {
            let along = match &side.border {
                Border::Plain => "plain".to_owned(),
                Border::Given { curve, first, heading } => {
                    let line = model
                        .lines
                        .iter()
                        .position(|l| l.curve.as_ref().is_some_and(|c| Arc::ptr_eq(c, curve.curve())));
                    let parameters = part(&|hash| curve.base().iter().for_each(|u| u.to_bits().hash(hash)));
                    format!("{line:?} {parameters:08x} {first} {heading:?}")
                }
            };
            let vertices = part(&|hash| side.vertices.iter().for_each(|v| v.0.hash(hash)));
            format!("{:?} {vertices:08x} {along}", side.ends)
        })
        .collect();
    let counts = (surface.mesh.face_count(), surface.details.count());
    format!("{counts:?} mesh {mesh:08x} points {points:08x} details {details:08x} sides {sides:?}")
}
