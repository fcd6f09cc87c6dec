//! # Other: the far side of a set of curves
//!
//! What a set of curves removes of that which all other sets leave, as a surface of its own. Its
//! curves are walked the other way, and where they are borders of what stays, too, both have the very
//! same parameters; so both have the same samples there on every level. The strip that joins the cage
//! to them then has as many knots as the other side needed, and shares out its edges among them.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{Curve, CurveParameters, Extent, Heading, wrap};
use selvedge_components::subdivision::Border;
use selvedge_components::trim::BorderLine;

use super::attach::{Knot, KnotKind, Strip};
use super::contour::{Contour, Span};
use super::junction::Meeting;
use super::{Cut, Remeshed};

/// Which other side is wanted.
#[derive(Clone, Debug)]
pub struct OtherSide {
    /// The set of curves whose far side it is.
    pub set: u32,
    /// What stays: it has the parameters.
    pub kept: Arc<Remeshed>,
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
        let same = self.kept.junctions.iter().filter(|j| j.ends.map(|end| end.0) == lines);
        let nearest = same.min_by(|a, b| far(&a.ends).total_cmp(&far(&b.ends)));
        match nearest.filter(|j| far(&j.ends) < SAME) {
            Some(&junction) => Meeting { junction, ..meeting },
            None => meeting,
        }
    }

    /// The parameters that the kept side has along a stretch of a turned curve.
    pub(super) fn parameters(&self, cuts: &[Cut], span: &Span) -> Option<Arc<CurveParameters>> {
        let cut = &cuts[span.cut as usize];
        if cut.set != self.set {
            return None;
        }
        let canonical = |u: f64| if cut.curve.closed() { wrap(u) } else { u };
        let mut ends = span.u.map(canonical);
        if cut.heading == Heading::Against {
            ends.reverse();
        }
        let round = span.junctions == [None; 2] && cut.curve.closed();
        let own = self.kept.surface.sides.iter().zip(&self.kept.side_origin);
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
/// stretches that have none stay. `None` where the corners are not among the parameters.
pub(super) fn seat(
    strip: &mut Strip,
    contour: &Contour,
    given: &[Option<Arc<CurveParameters>>],
    cuts: &[Cut],
    limit: impl Fn(u32) -> DVec3,
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
        let rim: Vec<DVec3> = (a..=b).map(q).collect();
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
fn all_round(list: &CurveParameters, heading: Heading, m: u32, q: impl Fn(u32) -> DVec3) -> Vec<Knot> {
    let mut u: Vec<f64> = list.base().to_vec();
    if heading == Heading::Against {
        u.reverse();
    }
    let points: Vec<DVec3> = u.iter().map(|&u| list.curve().position(u)).collect();
    let seam = points[0].midpoint(points[points.len() - 1]);
    let off = |i: &u32| q(*i).distance_squared(seam);
    let begin = (0..m).min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0);
    let rim: Vec<DVec3> = (begin..=begin + m).map(q).collect();
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

/// How many edges of `rim` each of `points` sees, so that triangles are short: all edges are seen in
/// order, and what joins neighbours is the vertex between their shares. Least sum of squares of the
/// distances of tips from the middles of their edges, by dynamic programming over shares.
fn share_out(points: &[DVec3], ends: [DVec3; 2], rim: &[DVec3]) -> Vec<u32> {
    let (g, e) = (points.len(), rim.len() - 1);
    if g == 0 {
        return Vec::new();
    }
    let at = |i: usize| if i < g { points[i] } else { ends[1] };
    // A fair share and some more for each.
    let most = e.div_ceil(g) + 3;
    let mut best = vec![vec![(f64::INFINITY, 0_u32); e + 1]; g + 1];
    best[0][0].0 = ends[0].midpoint(points[0]).distance_squared(rim[0]);
    for i in 0..g {
        for j in 0..=e {
            let mut cost = best[i][j].0;
            if cost == f64::INFINITY {
                continue;
            }
            for span in 0..=most.min(e - j) {
                if span > 0 {
                    cost += points[i].distance_squared(rim[j + span - 1].midpoint(rim[j + span]));
                }
                let total = cost + at(i).midpoint(at(i + 1)).distance_squared(rim[j + span]);
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
