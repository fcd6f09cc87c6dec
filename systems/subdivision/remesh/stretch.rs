//! # Stretches: curves cut where they cross
//!
//! From its first crossing on each curve is cut into stretches, each of which has one number on its
//! left all along ([`winding`](super::winding)), so that all of it is a border or none.

use glam::DVec3;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::NONE;
use selvedge_components::subdivision::remesh::RemeshError;

use super::contour::Span;
use super::crossing::Crossing;
use super::junction::Meeting;
use super::track::{Near, Track};
use super::winding::{Way, Winding};

/// A stretch before it is known whether it stays.
pub(super) struct Stretch {
    pub span: Span,
    /// Where it begins and ends on its curve's track.
    pub from: Near,
    pub to: Near,
}

impl Stretch {
    /// The point that it begins at.
    pub fn begin(&self, track: &Track, meetings: &[Meeting]) -> DVec3 {
        let junction = self.span.junctions[0].map(|j| meetings[j as usize].junction.point);
        junction.unwrap_or_else(|| track.position(self.from))
    }
}

/// A place where a curve is cut, or ends.
#[derive(Clone, Copy)]
struct Stop {
    near: Near,
    t: f64,
    u: f64,
    junction: Option<u32>,
}

/// Cuts the curves where they cross. In the order of the curves, each from its first crossing on.
pub(super) fn stretches(
    track: &Track,
    crossings: &[Crossing],
    meetings: &[Meeting],
) -> Result<Vec<Stretch>, RemeshError> {
    let mut stops: Vec<Vec<Stop>> = vec![Vec::new(); track.tracks.len()];
    for (j, (crossing, meeting)) in crossings.iter().zip(meetings).enumerate() {
        for (i, near) in crossing.at.into_iter().enumerate() {
            let (t, u) = (meeting.t[i], meeting.junction.ends[i].1);
            let cut = track.points[near.segment as usize].cut;
            stops[cut as usize].push(Stop { near, t, u, junction: Some(j as u32) });
        }
    }
    let mut stretches = Vec::new();
    for (cut, mut stops) in stops.into_iter().enumerate() {
        stops.sort_by(|a, b| a.near.segment.cmp(&b.near.segment).then(a.near.part.total_cmp(&b.near.part)));
        let whole = track.tracks[cut];
        if whole.closed && !stops.is_empty() {
            stops.push(Stop { t: stops[0].t + 1.0, ..stops[0] });
        } else {
            let [begin, end] = ends(track, cut);
            stops.insert(0, begin);
            stops.push(end);
        }
        for pair in stops.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let curve = track.points[from.near.segment as usize].curve;
            let span =
                Span { cut: curve, t: [from.t, to.t], u: [from.u, to.u], junctions: [from.junction, to.junction] };
            let stretch = Stretch { span, from: from.near, to: to.near };
            // Places so near to each other that they come in another order in space.
            if from.t >= to.t || from.t.is_nan() || to.t.is_nan() {
                let at = stretch.begin(track, meetings);
                return Err(RemeshError::Tangled { curve: curve as usize, u: from.u, at });
            }
            stretches.push(stretch);
        }
    }
    Ok(stretches)
}

/// Where a track begins and ends.
fn ends(track: &Track, cut: usize) -> [Stop; 2] {
    let whole = track.tracks[cut];
    let (first, last) = (whole.begin, whole.begin + whole.count - 1);
    let begin = Near { segment: first, part: 0.0, distance: 0.0 };
    let end = Near { segment: if whole.closed { last } else { last - 1 }, part: 1.0, distance: 0.0 };
    let last = if whole.closed { first } else { last };
    [(begin, first), (end, last)].map(|(near, point)| {
        let (t, u) = (track.parameter(near), track.points[point as usize].u);
        Stop { near, t, u, junction: None }
    })
}

/// The number on the left of a stretch whose curve is one of `winding`'s.
pub(super) fn number(track: &Track, winding: &Winding, stretch: &Stretch) -> (FaceId, i32) {
    middle(track, stretch).map_or((FaceId::new(0), i32::MIN), |(way, f)| (way.leg.face, winding.left_of(&way, f)))
}

/// The middle of a stretch where its way is longest within a face: the way, and how far along it.
pub(super) fn middle(track: &Track, stretch: &Stretch) -> Option<(Way, f64)> {
    let mut best: Option<(f64, Way, f64)> = None;
    for (segment, part) in segments(track, stretch.from, stretch.to) {
        for leg in &track.points[segment as usize].legs {
            let shares = part.map(|f| share_in(leg.part, f));
            let length = (shares[1] - shares[0]) * leg.from.distance(leg.to);
            if best.as_ref().is_none_or(|b| length > b.0) {
                best = Some((length, Way { leg: *leg, segment }, 0.5 * (shares[0] + shares[1])));
            }
        }
    }
    best.map(|(_, way, f)| (way, f))
}

/// Where in a part of [0, 1] a number lies, in [0, 1].
pub(super) fn share_in(part: [f64; 2], f: f64) -> f64 {
    let width = part[1] - part[0];
    if width > 0.0 { ((f - part[0]) / width).clamp(0.0, 1.0) } else { f64::from(u8::from(f > part[0])) }
}

/// The segments between two places of one track, with the part of each.
pub(super) fn segments(track: &Track, from: Near, to: Near) -> Vec<(u32, [f64; 2])> {
    let mut out = Vec::new();
    let mut at = from.segment;
    let mut begin = from.part;
    let cut = track.points[from.segment as usize].cut;
    for _ in 0..=track.tracks[cut as usize].count {
        if at == to.segment && begin < to.part {
            out.push((at, [begin, to.part]));
            return out;
        }
        out.push((at, [begin, 1.0]));
        begin = 0.0;
        at = track.points[at as usize].next;
        if at == NONE || !track.is_segment(at) {
            return out;
        }
    }
    out
}
