//! # Remesh: a cage that ends at the curves
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the source, details and all; directed curves | the new cage, or what stands against it | check | relax |
//!
//! Stages, each a kernel of its own: [`preimage`] finds where the curves run, [`adapt`] makes the cage
//! fine enough there, [`closure`] makes it conforming, [`remove`] takes away what lies on the right,
//! [`attach`] lays a strip of triangles between the rest and each curve, [`relax`]
//! spaces its vertices, [`cleanup`] mends valences, and [`assemble`] makes a surface of it.
//! [Litke et al. 2001, Section 3.1]
//!
//! Everything is measured in space, on the limit surface, but only over connected ground; so cages
//! of any shape will do. Where two boundaries come too near to each other for the cage, the curves
//! that need it are taken a level finer and the whole is done again.

pub mod adapt;
pub mod assemble;
pub mod attach;
mod borders;
pub mod cleanup;
pub mod closure;
pub mod contour;
mod crossing;
pub mod field;
pub mod junction;
pub mod leaves;
pub mod path;
pub mod preimage;
pub mod remove;
mod sides;
pub mod track;
pub mod winding;

#[cfg(test)]
pub(crate) mod tests;

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{Curve, Heading};
use selvedge_components::mesh::Connectivity;
pub use selvedge_components::subdivision::remesh as error;
use selvedge_components::subdivision::{CornerTable, LoopSurface, NONE};

pub use adapt::AdaptOptions;
pub use assemble::{FaceOrigin, Remeshed, SideOrigin, VertexOrigin};
pub use error::{PreImageError, RemeshError};
pub use junction::JunctionOptions;
pub use preimage::{Extent, PathPoint, PreImage, TraceOptions, trace, trace_parts};
pub use remove::Fate;

use super::relax::{self, RelaxOptions, Relaxed, Slider};
use closure::{Adapted, Part};
use contour::{Arrangement, Contour};
use leaves::Leaves;
use remove::{Cage, Place, Remains, Trouble};
use track::Track;

/// One directed curve that cuts: what lies on its left stays.
#[derive(Clone, Debug)]
pub struct Cut {
    /// The curve.
    pub curve: Arc<dyn Curve>,
    /// Which way it is walked.
    pub heading: Heading,
}

/// How a cage is remeshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshOptions {
    /// How fine the cage becomes.
    pub adapt: AdaptOptions,
    /// The part of its size that a triangle's corner must be away from a curve to stay: the room
    /// for the strip.
    pub margin: f64,
    /// How the strip settles.
    pub relax: RelaxOptions,
    /// The farthest from the curves that a vertex may change, in model units. The whole cage is
    /// refined first as often as that takes.
    pub reach: Option<f64>,
    /// What is asked of the places where curves cross.
    pub junctions: JunctionOptions,
    /// How often the cage is made finer where boundaries come too near to each other.
    pub tries: u32,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        Self {
            adapt: AdaptOptions::default(),
            margin: 0.3,
            relax: RelaxOptions::default(),
            reach: None,
            junctions: JunctionOptions::default(),
            tries: 12,
        }
    }
}

/// Cuts `surface` along curves, whose pre-images on it are given in the order of the curves. A curve
/// that leaves the surface and comes back is one cut for each part, with the same curve.
///
/// # Errors
/// When there is no curve, a curve is open, the curves do not separate what stays from what goes,
/// nothing stays, or boundaries come too near to each other; see [`RemeshError`].
pub fn remesh(
    surface: &LoopSurface,
    cuts: &[Cut],
    preimages: &[PreImage],
    options: &RemeshOptions,
) -> Result<Remeshed, RemeshError> {
    check(cuts, preimages)?;
    let corners = CornerTable::new(surface);
    let plan = contour::arrange(surface, cuts, preimages, &options.junctions)?;
    let mut options = *options;
    let deepest = options.adapt.finest;
    loop {
        let remeshed = refine_until_sound(surface, &corners, cuts, &plan, &options)?;
        let Some(reach) = options.reach else { return Ok(remeshed) };
        let (distance, at) = remeshed.reach(&plan.track);
        if distance <= reach {
            return Ok(remeshed);
        }
        if options.adapt.base == deepest {
            return Err(RemeshError::OutOfReach { distance, at, reach });
        }
        // Each level of the whole cage halves the reach. Details finer than its level would have no
        // place on the new cage, so it is at least as fine as they are.
        options.adapt.base = (options.adapt.base + 1).max(surface.details.depth().saturating_sub(1));
        if surface.mesh.face_count() << (2 * options.adapt.base) > options.adapt.most_faces {
            return Err(RemeshError::OutOfReach { distance, at, reach });
        }
    }
}

fn check(cuts: &[Cut], preimages: &[PreImage]) -> Result<(), RemeshError> {
    if cuts.is_empty() || preimages.len() != cuts.len() {
        return Err(RemeshError::NoCurves);
    }
    for (curve, (cut, image)) in cuts.iter().zip(preimages).enumerate() {
        if !cut.curve.closed() && image.extent == Extent::Round {
            let gap = cut.curve.position(0.0).distance(cut.curve.position(1.0));
            return Err(RemeshError::Open { curve, gap });
        }
    }
    Ok(())
}

fn refine_until_sound(
    surface: &LoopSurface,
    corners: &CornerTable,
    cuts: &[Cut],
    plan: &Arrangement,
    options: &RemeshOptions,
) -> Result<Remeshed, RemeshError> {
    let track = &plan.track;
    let mut least = vec![0; track.points.len()];
    for tried in 0.. {
        let leaves = adapt::adapt(surface, corners, track, &options.adapt, &least)?;
        let (what, places) = match cut_once(surface, corners, cuts, plan, &leaves, options) {
            Ok(remeshed) => return Ok(remeshed),
            Err(Trouble::Error(why)) => return Err(why),
            Err(Trouble::TooCoarse { what, places }) => (what, places),
        };
        let Some(first) = places.first().filter(|_| tried == options.tries) else {
            places.iter().for_each(|place| ask_for_finer(track, place, &mut least));
            continue;
        };
        let point = &track.points[first.near.segment as usize];
        let u = plan.contours[point.cut as usize].spot(cuts, track.parameter(first.near)).u;
        let curve = point.curve as usize;
        let (at, level) = (track.position(first.near), leaves.finest());
        return Err(RemeshError::Unresolved { what, curve, u, at, tries: tried, level });
    }
    // Reached only if tries overflow.
    Err(RemeshError::NoCurves)
}

/// How far along the curve to either side of a place that is too coarse the cage is refined, in sizes
/// of its triangles there: as far as the triangles around its neighbours reach.
const ASIDE: f64 = 3.0;

/// Asks for one level more along the curve near `place`.
fn ask_for_finer(track: &Track, place: &Place, least: &mut [u32]) {
    let cut = track.points[place.near.segment as usize].cut;
    let whole = track.tracks[cut as usize];
    let wanted = place.level + 1;
    let mut raise = |segment: u32| least[segment as usize] = least[segment as usize].max(wanted);
    let from = track.along(place.near);
    for (sign, reach) in [(1.0, ASIDE * place.size), (-1.0, ASIDE * place.size)] {
        let mut at = place.near.segment;
        for _ in 0..whole.count {
            raise(at);
            let far = (track.points[at as usize].along - from) * sign;
            let far = if whole.closed { far - (far / whole.length).floor() * whole.length } else { far };
            let next = if sign > 0.0 { track.points[at as usize].next } else { track.points[at as usize].previous };
            let is_segment = next != NONE && track.points[next as usize].next != NONE;
            if !is_segment || (far > reach && at != place.near.segment) {
                break;
            }
            at = next;
        }
    }
}

/// One try, with leaves that are given.
fn cut_once(
    surface: &LoopSurface,
    corners: &CornerTable,
    cuts: &[Cut],
    plan: &Arrangement,
    leaves: &Leaves,
    options: &RemeshOptions,
) -> Result<Remeshed, Trouble> {
    let track = &plan.track;
    let adapted = closure::close(surface, corners, leaves).map_err(Trouble::Error)?;
    let mesh = manifold(adapted.vertices.len(), &adapted.triangles)?;
    let levels: Vec<u32> = adapted.sources.iter().map(|s| s.level).collect();
    let limit: Vec<DVec3> = adapted.vertices.iter().map(|v| v.limit).collect();
    let cage = Cage {
        mesh: &mesh,
        triangles: &adapted.triangles,
        levels: &levels,
        limit: &limit,
        track,
        margin: options.margin,
    };
    let stays = |f: usize| plan.winding.stays(adapted.sources[f].middle());
    let remains = cage.cut(&crossed(&adapted, track, leaves), &stays)?;
    let mut strips = Vec::with_capacity(plan.contours.len());
    for (cut, rim) in remains.loops.iter().enumerate() {
        let strip = attach::attach(track, cut as u32, rim, |v| (limit[v as usize], cage.normal(v)));
        strips.push(strip.map_err(|near| {
            let away = |v: &&u32| limit[**v as usize].distance_squared(track.position(near));
            let nearest = rim.vertices.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            let place = cage.place(nearest.copied().unwrap_or(0), near);
            Trouble::TooCoarse { what: "too coarse between two corners", places: vec![place] }
        })?);
    }
    let contours = strips.iter_mut().zip(&plan.contours);
    let relaxed = contours.map(|(strip, contour)| settle(strip, contour, &limit, options)).collect();
    let base = options.adapt.base;
    let mut work = Work {
        base,
        surface,
        cuts,
        plan,
        leaves,
        adapted: &adapted,
        remains: &remains,
        strips: &strips,
        parameters: Vec::new(),
    };
    work.parameters = (0..strips.len() as u32).map(|s| sides::strip_parameters(&work, s)).collect::<Result<_, _>>()?;
    assemble::assemble(&work, relaxed)
}

/// All that the last stage reads.
struct Work<'a> {
    base: u32,
    surface: &'a LoopSurface,
    cuts: &'a [Cut],
    plan: &'a Arrangement,
    leaves: &'a Leaves,
    adapted: &'a Adapted,
    remains: &'a Remains,
    strips: &'a [attach::Strip],
    /// By strip.
    parameters: Vec<sides::StripParameters>,
}

impl Work<'_> {
    /// The curve that a knot of a strip lies on, of two the one that goes on from there.
    fn curve_of(&self, strip: u32, knot: u32) -> u32 {
        let contour = &self.plan.contours[self.strips[strip as usize].cut as usize];
        contour.spans[self.parameters[strip as usize].spots[knot as usize].span as usize].cut
    }
}

fn manifold(vertices: usize, triangles: &[[u32; 3]]) -> Result<Connectivity, Trouble> {
    Connectivity::new(vertices, triangles).map_err(|faults| Trouble::Error(RemeshError::NotManifold { faults }))
}

/// The triangles that segments cross, with the segments. Of a leaf in several triangles all count.
fn crossed(adapted: &Adapted, track: &Track, leaves: &Leaves) -> Vec<(u32, u32)> {
    let mut first = HashMap::new();
    for (f, piece) in adapted.sources.iter().enumerate() {
        first.entry((piece.level, piece.leaf)).or_insert(f as u32);
    }
    let mut crossed = Vec::new();
    for level in 0..=leaves.finest() {
        for visit in track.visits(level) {
            let Some(&begin) = first.get(&(level, visit.code)) else { continue };
            let own = adapted.sources[begin as usize..].iter();
            let count = own.take_while(|p| (p.level, p.leaf) == (level, visit.code)).count() as u32;
            crossed.extend((begin..begin + count).map(|f| (f, visit.segment)));
        }
    }
    crossed.dedup();
    crossed
}

/// Relaxes one strip.
fn settle(strip: &mut attach::Strip, contour: &Contour, limit: &[DVec3], options: &RemeshOptions) -> Relaxed {
    let widths = strip.widths(|v| limit[v as usize]);
    let slider = |(knot, width): (&attach::Knot, f64)| {
        let smooth = knot.kind == attach::KnotKind::Smooth;
        Slider { t: knot.t, base: smooth.then(|| strip.base(knot).map(|v| limit[v as usize])), width }
    };
    let mut sliders: Vec<Slider> = strip.knots.iter().zip(widths).map(slider).collect();
    let (curve, heading) = (&*contour.curve, contour.heading);
    let worst = |sliders: &[Slider], strip: &attach::Strip| {
        let knots: Vec<DVec3> =
            sliders.iter().map(|k| curve.position(relax::curve_parameter(curve, heading, k.t))).collect();
        let begin = limit.len() as u32;
        let at = |v: u32| if v < begin { limit[v as usize] } else { knots[(v - begin) as usize] };
        let triangles = strip.triangles(|i| begin + i as u32);
        triangles.iter().map(|t| relax::shape(t.map(at))).fold(f64::INFINITY, f64::min)
    };
    let before = (relax::residual(curve, heading, &sliders), worst(&sliders, strip));
    relax::relax(curve, heading, &mut sliders, options.relax);
    let after = (relax::residual(curve, heading, &sliders), worst(&sliders, strip));
    strip.knots.iter_mut().zip(&sliders).for_each(|(knot, slider)| knot.t = slider.t);
    Relaxed { sweeps: options.relax.sweeps, residual: [before.0, after.0], worst_shape: [before.1, after.1] }
}

impl Remeshed {
    /// How far from the curves a vertex has changed, and where.
    fn reach(&self, track: &Track) -> (f64, DVec3) {
        let mut farthest = (0.0, DVec3::ZERO);
        for &v in &self.changed {
            let x = self.limit[v.index()];
            let distances = track.points.iter().map(|p| p.position.distance(x));
            let distance = distances.fold(f64::INFINITY, f64::min);
            if distance > farthest.0 {
                farthest = (distance, x);
            }
        }
        farthest
    }
}

impl Part {
    /// Is it all of its leaf?
    pub fn is_whole(self) -> bool {
        self == Self::Whole
    }
}
