//! # Other: the far side of a set of curves
//!
//! What a set of curves removes of that which all other sets leave, as a surface of its own. Its
//! curves are walked the other way, and where they are borders of what stays, too, both have the very
//! same parameters; so both have the same samples there on every level. The strip that joins the cage
//! to them then has as many knots as the other side needed, and shares out its edges among them.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{Curve, CurveParameters, Extent, Heading, wrap};
use selvedge_components::subdivision::{Border, LoopSurface};
use selvedge_components::trim::BorderLine;

use super::arrange::Arrangement;
use super::attach::{Knot, KnotKind, Strip};
use super::contour::{Contour, Span};
use super::junction::Meeting;
use super::settle::{THIN, shape};
use super::track::{Near, TrackPoint, size};
use super::{Cut, Remeshed};

/// Which other side is wanted.
#[derive(Clone, Debug)]
pub struct OtherSide {
    /// The set of curves whose far side it is.
    pub set: u32,
    /// What stays, if it is made: it has the parameters.
    pub kept: Option<Arc<Remeshed>>,
}

/// Of the junctions of two curves, the one with parameters as near as this is the same one: places
/// found from both sides differ by rounding, and two crossings are never told apart so near.
const SAME: f64 = 1e-6;

fn apart(a: f64, b: f64) -> f64 {
    (a - b - (a - b).round()).abs()
}

impl OtherSide {
    /// The curves, those of the set walked the other way.
    pub fn turned(&self, cuts: &[Cut]) -> Vec<Cut> {
        let turned = |cut: &Cut| match (cut.set == self.set, cut.heading) {
            (false, heading) => heading,
            (true, Heading::Along) => Heading::Against,
            (true, Heading::Against) => Heading::Along,
        };
        cuts.iter().map(|cut| Cut { heading: turned(cut), ..cut.clone() }).collect()
    }

    /// The crossing with the bits that the kept side has for it, if it is a corner there.
    pub(super) fn with_bits(&self, meeting: Meeting) -> Meeting {
        let lines = meeting.junction.ends.map(|end| end.0);
        let far = |ends: &[(BorderLine, f64); 2]| {
            (0..2).map(|i| apart(ends[i].1, meeting.junction.ends[i].1)).fold(0.0, f64::max)
        };
        let Some(kept) = &self.kept else { return meeting };
        let same = kept.junctions.iter().filter(|j| j.ends.map(|end| end.0) == lines);
        let nearest = same.min_by(|a, b| far(&a.ends).total_cmp(&far(&b.ends)));
        match nearest.filter(|j| far(&j.ends) < SAME) {
            Some(&junction) => Meeting { junction, ..meeting },
            None => meeting,
        }
    }

    /// The parameters that the kept side has along a stretch of a turned curve.
    pub(super) fn parameters(&self, cuts: &[Cut], span: &Span) -> Option<Arc<CurveParameters>> {
        let cut = &cuts[span.cut as usize];
        let kept = self.kept.as_ref().filter(|_| cut.set == self.set)?;
        let canonical = |u: f64| if cut.curve.closed() { wrap(u) } else { u };
        let mut ends = span.u.map(canonical);
        if cut.heading == Heading::Against {
            ends.reverse();
        }
        let round = span.junctions == [None; 2] && cut.curve.closed();
        let own = kept.surface.sides.iter().zip(&kept.side_origin);
        let own = own.filter(|(_, origin)| origin.line == BorderLine::Cut(span.cut as usize));
        own.filter_map(|(side, _)| match &side.border {
            Border::Given { curve, .. } => Some(curve),
            Border::Plain => None,
        })
        .find(|list| match (list.extent(), list.base()) {
            (Extent::Closed, _) => round,
            (Extent::Open, [first, .., last]) => !round && [*first, *last] == ends,
            _ => false,
        })
        .map(Arc::clone)
    }
}

/// Puts the knots of a strip where given parameters are, stretch by stretch between corners; those of
/// stretches that have none stay. `limit` gives the rim's limit points and normals. `None` where the corners are not among the parameters.
pub(super) fn seat(
    strip: &mut Strip,
    contour: &Contour,
    given: &[Option<Arc<CurveParameters>>],
    cuts: &[Cut],
    limit: impl Fn(u32) -> (DVec3, DVec3),
) -> Option<()> {
    if given.iter().all(Option::is_none) {
        return Some(());
    }
    let n = strip.knots.len();
    let m = strip.rim.len() as u32;
    let fixed: Vec<usize> = (0..n).filter(|&k| strip.knots[k].kind != KnotKind::Smooth).collect();
    let q = |i: u32| limit(strip.rim[(i % m) as usize]);
    if fixed.is_empty() {
        let list = given[0].as_ref()?;
        strip.knots = all_round(list, cuts[contour.spans[0].cut as usize].heading, m, q);
        return Some(());
    }
    // A strip that has corners begins with one.
    let mut knots = Vec::new();
    for (i, &from) in fixed.iter().enumerate() {
        let corner = strip.knots[from];
        knots.push(corner);
        let (to, round) = match fixed.get(i + 1) {
            Some(&to) => (to, 0),
            None if strip.closed => (n, m),
            None => break,
        };
        let place = |knot: &Knot, is_last: bool| match knot.kind {
            KnotKind::End => contour.end(usize::from(is_last)),
            _ => contour.corner(cuts, knot.t),
        };
        let begin = place(&corner, false);
        let Some(list) = &given[begin.span as usize] else {
            knots.extend(&strip.knots[from + 1..to]);
            continue;
        };
        let next = &strip.knots[to % n];
        let (a, b) = (corner.first + corner.span, next.first + round);
        // The rim is counted on from the corner.
        let b = b + if b < a { m } else { 0 };
        let span = &contour.spans[begin.span as usize];
        let cut = &cuts[span.cut as usize];
        let end = place(next, to == n - 1 && !strip.closed);
        let same_span = end.span == begin.span && end.junction.is_none();
        let last = if same_span || contour.is_single() { end.u } else { span.u[1] };
        let between = between(list, cut.heading, [begin.u, last])?;
        let travel = |u: f64| {
            let way = if cut.heading == Heading::Along { u - begin.u } else { begin.u - u };
            corner.t + contour.travel(span, if cut.curve.closed() { wrap(way) } else { way })
        };
        let points: Vec<DVec3> = between.iter().map(|&u| cut.curve.position(u)).collect();
        let ends = [cut.curve.position(begin.u), cut.curve.position(last)];
        let rim: Vec<(DVec3, DVec3)> = (a..=b).map(q).collect();
        let mut first = a;
        for (&u, span) in between.iter().zip(share_out(&points, ends, &rim)) {
            knots.push(Knot { t: travel(u), kind: KnotKind::Smooth, first, span, given: true });
            first += span;
        }
    }
    strip.knots = knots;
    Some(())
}

/// The parameters strictly between two of a list, in the direction of travel.
fn between(list: &CurveParameters, heading: Heading, ends: [f64; 2]) -> Option<Vec<f64>> {
    let base = list.base();
    let wrapped = |u: f64| if list.curve().closed() { wrap(u) } else { u };
    let n = base.len();
    let at = |u: f64, from_end: bool| {
        let is = |b: &f64| *b == wrapped(u);
        if from_end { base.iter().rposition(is) } else { base.iter().position(is) }
    };
    // Where a stretch ends where it begins, both ends have one parameter.
    let from = at(ends[0], heading == Heading::Against)?;
    let to = at(ends[1], heading == Heading::Along)?;
    let step = if heading == Heading::Along { 1 } else { n - 1 };
    let mut found = Vec::new();
    let mut k = (from + step) % n;
    while k != to && found.len() < n {
        found.push(base[k]);
        k = (k + step) % n;
    }
    Some(found)
}

/// The knots of a strip without corners.
fn all_round(list: &CurveParameters, heading: Heading, m: u32, q: impl Fn(u32) -> (DVec3, DVec3)) -> Vec<Knot> {
    let mut u: Vec<f64> = list.base().to_vec();
    if heading == Heading::Against {
        u.reverse();
    }
    let points: Vec<DVec3> = u.iter().map(|&u| list.curve().position(u)).collect();
    let seam = points[0].midpoint(points[points.len() - 1]);
    let off = |i: &u32| q(*i).0.distance_squared(seam);
    let begin = (0..m).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
    let rim: Vec<(DVec3, DVec3)> = (begin..=begin + m).map(q).collect();
    let ends = [points[points.len() - 1], points[0]];
    let mut first = begin;
    let mut last = f64::NEG_INFINITY;
    let mut knots = Vec::with_capacity(u.len());
    for (&u, span) in u.iter().zip(share_out(&points, ends, &rim)) {
        let t = if heading == Heading::Along { u } else { -u };
        let t = if t < last { t + 1.0 } else { t };
        knots.push(Knot { t, kind: KnotKind::Smooth, first, span, given: true });
        (first, last) = (first + span, t);
    }
    knots
}

/// By segment of the track, how far apart the knots are that are given there; 0 where none are.
pub(super) fn gaps(plan: &Arrangement, cuts: &[Cut]) -> Vec<f64> {
    let mut gaps = vec![0.0; plan.track.points.len()];
    for (c, (contour, given)) in plan.contours.iter().zip(&plan.given).enumerate() {
        let lists: Vec<Option<(&[f64], Vec<DVec3>)>> =
            given.iter().map(|list| list.as_ref().map(|l| with_points(l))).collect();
        let whole = plan.track.tracks[c];
        for segment in (whole.begin..whole.begin + whole.count).filter(|&s| plan.track.is_segment(s)) {
            let middle = plan.track.parameter(Near { segment, part: 0.5, distance: 0.0 });
            let spot = contour.spot(cuts, middle);
            let Some((base, points)) = &lists[spot.span as usize] else { continue };
            let n = base.len();
            let after = base.partition_point(|&u| u <= spot.u);
            gaps[segment as usize] = points[(after + n - 1) % n].distance(points[after % n]);
        }
    }
    gaps
}

/// By segment of the track, the level whose faces are no wider than knots that are given there need: on a rim of
/// much longer edges the triangles between them would be thin.
pub(super) fn levels(plan: &Arrangement, surface: &LoopSurface, gaps: &[f64]) -> Vec<u32> {
    let level = |(p, &gap): (&TrackPoint, &f64)| {
        let Some(leg) = p.legs.first().filter(|_| gap > 0.0) else { return 0 };
        let whole = size(surface.mesh.face(leg.face).map(|v| surface.points[v.index()]));
        (whole / (WIDER * gap)).log2().ceil().max(0.0) as u32
    };
    plan.track.points.iter().zip(gaps).map(level).collect()
}

/// How many times as wide as the gap between knots the faces beside it may be: as many as two levels that are
/// neighbours leave.
const WIDER: f64 = 2.0;

fn with_points(list: &CurveParameters) -> (&[f64], Vec<DVec3>) {
    (list.base(), list.base().iter().map(|&u| list.curve().position(u)).collect())
}

/// What a triangle of no shape costs in the sharing, in squares of the gap between knots; a folded one costs more,
/// one that is not [`THIN`] nothing. Distances cost some tenths.
const NO_SHAPE: f64 = 10.0;

/// How many edges of `rim` each of `points` sees, so that no triangle is thin or folded if that can be
/// helped, and triangles are short: all edges are seen in order, and what joins neighbours is the vertex
/// between their shares. Least sum of squares of the distances of tips from the middles of their edges, and of
/// what shapes lack, by dynamic programming over shares. The rim comes with its normals.
fn share_out(points: &[DVec3], ends: [DVec3; 2], rim: &[(DVec3, DVec3)]) -> Vec<u32> {
    let (g, e) = (points.len(), rim.len() - 1);
    if g == 0 {
        return Vec::new();
    }
    let at = |i: usize| if i < g { points[i] } else { ends[1] };
    let way = ends[0].distance(points[0]) + (0..g).map(|i| at(i).distance(at(i + 1))).sum::<f64>();
    let square = (way / (g + 1) as f64).powi(2);
    let lack = |shape: f64| NO_SHAPE * square * ((THIN - shape) / THIN).max(0.0).powi(2);
    // A fair share for each, some times that where they are far apart, and some more.
    let most = 4 * e.div_ceil(g) + 3;
    let mut best = vec![vec![(f64::INFINITY, 0_u32); e + 1]; g + 1];
    best[0][0].0 = ends[0].midpoint(points[0]).distance_squared(rim[0].0);
    for i in 0..g {
        let fan = rim.windows(2).map(|edge| {
            let [q, r] = [edge[0], edge[1]];
            points[i].distance_squared(q.0.midpoint(r.0)) + lack(shape([r.0, q.0, points[i]], q.1 + r.1))
        });
        let fan: Vec<f64> = fan.collect();
        let link = rim
            .iter()
            .map(|q| at(i).midpoint(at(i + 1)).distance_squared(q.0) + lack(shape([q.0, at(i), at(i + 1)], q.1)));
        let link: Vec<f64> = link.collect();
        for j in 0..=e {
            let mut cost = best[i][j].0;
            if cost == f64::INFINITY {
                continue;
            }
            for span in 0..=most.min(e - j) {
                if span > 0 {
                    cost += fan[j + span - 1];
                }
                let total = cost + link[j + span];
                let there = &mut best[i + 1][j + span];
                if total < there.0 {
                    *there = (total, span as u32);
                }
            }
        }
    }
    let mut spans = vec![0; g];
    let mut j = e;
    for i in (0..g).rev() {
        spans[i] = best[i + 1][j].1;
        j -= spans[i] as usize;
    }
    spans
}
