//! A cage with strips along the curves, on its way to a surface: laid, relaxed, settled.

use glam::DVec3;
use selvedge_components::subdivision::{CornerTable, LoopSurface};

use super::super::relax::{self, Relaxed, Slider, Strung};
use super::arrange::Arrangement;
use super::assemble::{Remeshed, assemble};
use super::attach::{self, KnotKind, Strip};
use super::closure::{self, Adapted};
use super::contour::Contour;
use super::leaves::Leaves;
use super::other;
use super::remove::{Cage, Place, Remains, Trouble};
use super::settle::Settling;
use super::strip_parameters::strip_parameters;
use super::track::Near;
use super::{Cut, RemeshOptions, Work, crossed, manifold};
use crate::parallel::{for_each, map_dear_in_order};

/// The shape below which a triangle of a strip is a sliver: half of what the smallest angle allowed
/// between curves leaves at the tip of a wedge. A finer cage may do better.
const SLIVER: f64 = 0.02;

/// How many edges a knot whose parameter is given sees where they are short.
const SHORT_EDGES: u32 = 2;

/// Knots moved in a quantum, about: each costs a handful of evaluations of its curve.
const KNOTS: usize = 512;

/// A cage with strips along the curves.
#[derive(Debug)]
pub(super) struct Laid {
    pub leaves: Leaves,
    adapted: Adapted,
    /// The source's limit points at its vertices.
    limit: Vec<DVec3>,
    remains: Remains,
    strips: Vec<Strip>,
    strung: Vec<Strung>,
    /// The unit normals at the rims' vertices, by strip.
    normals: Vec<Vec<DVec3>>,
    /// What relaxation does, by strip.
    pub relaxed: Vec<Relaxed>,
}

/// Where strips have slivers.
pub(super) struct Slivers {
    /// The worst shape of a triangle of a strip, below zero if it is folded.
    pub worst: f64,
    /// Where that is.
    pub worst_at: Option<Near>,
    /// The same whichever way triangles face.
    pub flattest: f64,
    /// Where that is.
    pub flattest_at: Option<Near>,
    /// Where there are slivers that a finer cage may mend.
    pub places: Vec<Place>,
    /// Where there are slivers that a wider strip may mend.
    pub narrow: Vec<Place>,
}

/// Cuts an adapted cage, and lays a strip along each contour. By segment of the track, triangles of the strips
/// are so long at least.
pub(super) fn lay(
    surface: &LoopSurface,
    corners: &CornerTable,
    cuts: &[Cut],
    plan: &Arrangement,
    leaves: Leaves,
    lengths: &[f64],
    options: &RemeshOptions,
) -> Result<Laid, Trouble> {
    let track = &plan.track;
    let adapted = closure::close(surface, corners, &leaves).map_err(Trouble::Error)?;
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
        lengths,
    };
    let stays = |f: usize| plan.stays.stays(adapted.sources[f].middle());
    let remains = cage.cut(&crossed(&adapted, track, &leaves), &stays)?;
    let strips = map_dear_in_order(remains.loops.len(), |c| {
        let rim = &remains.loops[c];
        let mut strip = attach::attach(track, c as u32, rim, |v| (limit[v as usize], cage.normal(v)))?;
        let seated =
            other::seat(&mut strip, &plan.contours[c], &plan.given[c], cuts, |v| (limit[v as usize], cage.normal(v)));
        seated.map(|()| strip).ok_or_else(|| track.place(c as u32, 0.0))
    });
    let strips = strips.into_iter().zip(&remains.loops).map(|(strip, rim)| {
        strip.map_err(|near| {
            let away = |v: &&u32| limit[**v as usize].distance_squared(track.position(near));
            let nearest = rim.vertices.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
            let place = cage.place(nearest.copied().unwrap_or(0), near);
            Trouble::TooCoarse { what: "too coarse between two corners", places: vec![place] }
        })
    });
    let strips = strips.collect::<Result<Vec<_>, _>>()?;
    let strung = strips.iter().map(|strip| string(strip, &limit, options)).collect();
    let relaxed = vec![Relaxed::default(); strips.len()];
    let normals = strips.iter().map(|strip| strip.rim.iter().map(|&v| cage.normal(v)).collect()).collect();
    let mut laid = Laid { leaves, adapted, limit, remains, strips, strung, normals, relaxed };
    laid.judge(plan, 0);
    Ok(laid)
}

/// A strip's knots, ready to be relaxed.
fn string(strip: &Strip, limit: &[DVec3], options: &RemeshOptions) -> Strung {
    let at = |v: u32| limit[v as usize];
    let slider = |(knot, width): (&attach::Knot, f64)| {
        let smooth = knot.kind == KnotKind::Smooth && !knot.given;
        Slider { t: knot.t, base: smooth.then(|| strip.base(knot).map(at)), width }
    };
    Strung::new(strip.knots.iter().zip(strip.widths(at)).map(slider).collect(), options.relax)
}

impl Laid {
    /// Some sweeps over all strips: one at least.
    pub fn sweep(&mut self, plan: &Arrangement, options: &RemeshOptions) {
        let knots: usize = self.strips.iter().map(|strip| strip.knots.len()).sum();
        let done = self.relaxed.first().map_or(0, |relaxed| relaxed.sweeps);
        let sweeps = (KNOTS / knots.max(1)).clamp(1, (options.relax.sweeps - done) as usize) as u32;
        for_each(self.strung.iter_mut().zip(&plan.contours).collect(), |(strung, contour)| {
            (0..sweeps).for_each(|_| strung.sweep(&*contour.curve, contour.heading));
        });
        self.relaxed.iter_mut().for_each(|relaxed| relaxed.sweeps = done + sweeps);
    }

    /// Notes how well the knots stand, before (0) or after (1) they are relaxed.
    pub fn judge(&mut self, plan: &Arrangement, when: usize) {
        let judged = map_dear_in_order(plan.contours.len(), |s| {
            let contour = &plan.contours[s];
            (self.strung[s].residual(&*contour.curve, contour.heading), self.worst(s, contour))
        });
        for (relaxed, (residual, worst)) in self.relaxed.iter_mut().zip(judged) {
            (relaxed.residual[when], relaxed.worst_shape[when]) = (residual, worst);
        }
    }

    /// The worst shape of a triangle of a strip.
    fn worst(&self, s: usize, Contour { curve, heading, .. }: &Contour) -> f64 {
        let position = |k: &Slider| curve.position(relax::curve_parameter(&**curve, *heading, k.t));
        let knots: Vec<DVec3> = self.strung[s].knots().iter().map(position).collect();
        let begin = self.limit.len() as u32;
        let at = |v: u32| if v < begin { self.limit[v as usize] } else { knots[(v - begin) as usize] };
        let triangles = self.strips[s].triangles(|i| begin + i as u32);
        triangles.iter().map(|t| relax::shape(t.map(at))).fold(f64::INFINITY, f64::min)
    }

    /// Makes a surface of what is left and the strips, as they have settled.
    pub fn finish(
        &mut self,
        surface: &LoopSurface,
        cuts: &[Cut],
        plan: &Arrangement,
        options: &RemeshOptions,
    ) -> Result<(Remeshed, Slivers), Trouble> {
        let thin = self.settle(plan);
        self.judge(plan, 1);
        for (strip, strung) in self.strips.iter_mut().zip(&self.strung) {
            strip.knots.iter_mut().zip(strung.knots()).for_each(|(knot, slider)| knot.t = slider.t);
        }
        let mut work = Work {
            options,
            surface,
            cuts,
            plan,
            leaves: &self.leaves,
            adapted: &self.adapted,
            remains: &self.remains,
            strips: &self.strips,
            parameters: Vec::new(),
        };
        work.parameters =
            (0..self.strips.len() as u32).map(|s| strip_parameters(&work, s)).collect::<Result<_, _>>()?;
        Ok((assemble(&work, self.relaxed.clone())?, thin))
    }

    /// Moves the knots of thin triangles. Returns the places at which there are slivers all the same.
    fn settle(&mut self, plan: &Arrangement) -> Slivers {
        let mut slivers = Slivers {
            worst: f64::INFINITY,
            worst_at: None,
            flattest: f64::INFINITY,
            flattest_at: None,
            places: Vec::new(),
            narrow: Vec::new(),
        };
        for (s, Contour { curve, heading, .. }) in plan.contours.iter().enumerate() {
            let strip = &self.strips[s];
            let rim = strip.rim.iter().zip(&self.normals[s]).map(|(&v, &n)| (self.limit[v as usize], n)).collect();
            let settling = Settling { strip, rim, curve: &**curve, heading: *heading };
            settling.settle(self.strung[s].knots_mut());
            let knots = self.strung[s].knots();
            let flattest = settling.flattest(knots);
            for (i, shape) in settling.shapes(knots).into_iter().enumerate() {
                let near = || plan.track.place_of_parameter(strip.cut, knots[i].t);
                if shape < slivers.worst {
                    (slivers.worst, slivers.worst_at) = (shape, Some(near()));
                }
                if flattest[i] < slivers.flattest {
                    (slivers.flattest, slivers.flattest_at) = (flattest[i], Some(near()));
                }
                if shape < SLIVER {
                    let place = self.place(s, i, near());
                    let (own, next) = (strip.knots[i], strip.knots[(i + 1) % strip.knots.len()]);
                    // Of edges that are short already a finer cage has more, in thinner triangles.
                    let is_narrow = (own.given && own.span >= SHORT_EDGES) || (next.given && next.span >= SHORT_EDGES);
                    if is_narrow { slivers.narrow.push(place) } else { slivers.places.push(place) }
                }
            }
        }
        slivers
    }

    /// A place of the curve at knot `k` of strip `s`, with the cage there.
    fn place(&self, s: usize, k: usize, near: Near) -> Place {
        let strip = &self.strips[s];
        let own = &strip.knots[k];
        let seen = (own.first..=own.first + own.span).map(|j| strip.rim[j as usize % strip.rim.len()]);
        let seen: Vec<u32> = seen.collect();
        let level = seen.iter().map(|&v| self.adapted.vertices[v as usize].level).max().unwrap_or(0);
        let far = seen.iter().map(|&v| self.limit[v as usize].distance(self.limit[seen[0] as usize]));
        Place { near, level, size: far.fold(0.0, f64::max) }
    }
}
