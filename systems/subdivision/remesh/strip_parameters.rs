//! The parameters of a strip's knots, stretch by stretch of its contour.

use std::sync::Arc;

use selvedge_components::curve::{Curve, CurveParameters, Extent, Heading, ParameterError, wrap};

use super::Work;
use super::attach::KnotKind;
use super::contour::{Contour, Spot};
use super::remove::{Place, Trouble};

/// The parameters along a strip.
pub(super) struct StripParameters {
    /// Of each stretch of its contour.
    pub spans: Vec<Arc<CurveParameters>>,
    /// By knot, its place on the contour.
    pub spots: Vec<Spot>,
    /// By knot, its index in the parameters of its stretch.
    pub indices: Vec<u64>,
}

/// The parameters of a strip's knots, which its sides share.
pub(super) fn strip_parameters(work: &Work<'_>, s: u32) -> Result<StripParameters, Trouble> {
    let strip = &work.strips[s as usize];
    let contour = &work.plan.contours[strip.cut as usize];
    let spots = strip.knots.iter().enumerate().map(|(k, knot)| match knot.kind {
        KnotKind::Smooth => contour.spot(work.cuts, knot.t),
        KnotKind::End => contour.end(usize::from(k > 0)),
        KnotKind::Convex | KnotKind::Concave => contour.corner(work.cuts, knot.t),
    });
    let mut out = StripParameters { spans: Vec::new(), spots: spots.collect(), indices: vec![0; strip.knots.len()] };
    for (i, span) in contour.spans.iter().enumerate() {
        let cut = &work.cuts[span.cut as usize];
        let mut members = members(&out.spots, strip.closed, contour, i as u32);
        if let Some(list) = &work.plan.given[strip.cut as usize][i] {
            take_over(&mut out, &members, list, cut.heading);
            continue;
        }
        let mut u: Vec<f64> = members.iter().map(|&k| out.spots[k].u).collect();
        if let (Some(last), Some(_)) = (u.last_mut(), span.junctions[1]) {
            *last = span.u[1];
        }
        let closed = contour.is_single() && strip.closed;
        if closed {
            members.sort_by(|&a, &b| out.spots[a].u.total_cmp(&out.spots[b].u));
            u.sort_by(f64::total_cmp);
        } else if cut.heading == Heading::Against {
            members.reverse();
            u.reverse();
        }
        let is_corner = |&i: &usize| strip.knots[members[i]].kind != KnotKind::Smooth;
        let corners: Vec<usize> = (0..members.len()).filter(is_corner).collect();
        for (i, &k) in members.iter().enumerate() {
            if out.spots[k].span as usize == out.spans.len() {
                out.indices[k] = i as u64;
            }
        }
        let made = parameters(&cut.curve, u.clone(), closed, &corners);
        out.spans.push(made.map_err(|why| unsound(work, s, members[index_of(&why, &u)]))?);
    }
    Ok(out)
}

/// The parameters of a stretch are given: its knots, in their order, are those.
fn take_over(out: &mut StripParameters, members: &[usize], list: &Arc<CurveParameters>, heading: Heading) {
    let (base, span) = (list.base(), out.spans.len());
    let n = base.len();
    let apart = |i: &usize| {
        let way = base[*i] - out.spots[members[0]].u;
        (way - way.round()).abs()
    };
    let first = match (list.extent(), heading) {
        (Extent::Closed, _) => (0..n).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0),
        (Extent::Open, Heading::Along) => 0,
        (Extent::Open, Heading::Against) => n - 1,
    };
    for (k, &knot) in members.iter().enumerate().filter(|(k, _)| *k < n) {
        let index = if heading == Heading::Along { first + k } else { first + n - k } % n;
        // The knot that ends the stretch begins the next one.
        if out.spots[knot].span as usize == span {
            (out.spots[knot].u, out.indices[knot]) = (base[index], index as u64);
        }
    }
    out.spans.push(Arc::clone(list));
}

/// The knots of a stretch in their order, with the one that ends it.
fn members(spots: &[Spot], closed: bool, contour: &Contour, span: u32) -> Vec<usize> {
    let n = spots.len();
    if contour.is_single() {
        return (0..n).collect();
    }
    let begins = |k: &usize| spots[*k].span == span && spots[*k].junction.is_some();
    let first = (0..n).find(begins).unwrap_or(0);
    let is_inside = |&k: &usize| spots[k].junction.is_none();
    let order = (first + 1..if closed { first + n } else { n }).map(|k| k % n);
    let mut members = vec![first];
    members.extend(order.clone().take_while(is_inside));
    members.push((first + members.len()) % n);
    members
}

/// The parameters as the curve owns them: `u` rises in the curve's direction, and may be unwrapped.
pub(super) fn parameters(
    curve: &Arc<dyn Curve>,
    u: Vec<f64>,
    closed: bool,
    corners: &[usize],
) -> Result<Arc<CurveParameters>, ParameterError> {
    let u = if curve.closed() { u.into_iter().map(wrap).collect() } else { u };
    let extent = if closed { Extent::Closed } else { Extent::Open };
    let made = CurveParameters::new(Arc::clone(curve), extent, u, corners);
    made.map(Arc::new)
}

/// Which of a list of parameters is in the way.
pub(super) fn index_of(why: &ParameterError, u: &[f64]) -> usize {
    let index = match why {
        ParameterError::OutOfRange { index, .. } | ParameterError::NotAscending { index, .. } => *index,
        ParameterError::MissedCorner { u: corner } => {
            let apart = |i: &usize| (u[*i] - corner).abs();
            (0..u.len()).min_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(0)
        }
        _ => 0,
    };
    index.min(u.len().saturating_sub(1))
}

/// Knots of strip `s` around knot `k` make no sound list: a finer cage has others.
pub(super) fn unsound(work: &Work<'_>, s: u32, k: usize) -> Trouble {
    let strip = &work.strips[s as usize];
    let knot = &strip.knots[k];
    let near = work.plan.track.place_of_parameter(strip.cut, knot.t);
    let seen = (knot.first..=knot.first + knot.span).map(|j| strip.rim[j as usize % strip.rim.len()]);
    let seen: Vec<_> = seen.map(|v| &work.adapted.vertices[v as usize]).collect();
    let size = seen.iter().map(|v| v.limit.distance(seen[0].limit)).fold(0.0, f64::max);
    let level = seen.iter().map(|v| v.level).max().unwrap_or(0);
    Trouble::TooCoarse { what: "too coarse to tell places along it apart", places: vec![Place { near, level, size }] }
}
