//! # Contours: the borders that the curves together make
//!
//! Where curves cross they are cut into pieces. A piece stays if what is on its left stays
//! (`sets`); the pieces that stay follow each other from crossing to crossing, and
//! make up contours that run round or from border to border. Everything after works contour by
//! contour: each is one curve of one parameter, with a corner at each junction.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{Curve, CurveParameters, Heading, wrap};
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::remesh::{PreImageError, RemeshError};
use selvedge_components::subdivision::{LoopSurface, NONE};
use selvedge_components::trim::Junction;

use super::super::relax::curve_parameter;
use super::borders::Borders;
use super::crossing::{self, Crossing};
use super::cusps;
use super::junction::{self, JunctionOptions, Meeting};
use super::other::OtherSide;
use super::path::Leg;
use super::sets::{Sets, Stays};
use super::track::{Near, Track, TrackPoint};
use super::winding::{Way, Ways, Winding};
use super::{Cut, PreImage};

/// A stretch of one curve between two junctions, or all of it.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// The curve, by index.
    pub cut: u32,
    /// The travel parameters of its ends, ascending; unwrapped.
    pub t: [f64; 2],
    /// The curve's own parameters there, to the bit.
    pub u: [f64; 2],
    /// The junctions it runs between; where it is all of a closed curve, none.
    pub junctions: [Option<u32>; 2],
}

/// A border made of stretches of curves.
#[derive(Clone, Debug)]
pub struct Contour {
    /// The stretches, in order; the end of each is the beginning of the next.
    pub spans: Vec<Span>,
    /// All of it as one curve: a single stretch is its curve itself.
    pub curve: Arc<dyn Curve>,
    /// Which way that is walked.
    pub heading: Heading,
}

/// A place of a contour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The stretch, by index.
    pub span: u32,
    /// The parameter of its curve.
    pub u: f64,
    /// The junction there, where the stretch begins.
    pub junction: Option<u32>,
}

impl Contour {
    /// A contour that is one curve, or a part of one between two borders.
    fn single(cut: &Cut, span: Span) -> Self {
        Self { spans: vec![span], curve: Arc::clone(&cut.curve), heading: cut.heading }
    }

    /// Is it made of one curve alone?
    pub fn is_single(&self) -> bool {
        self.spans.len() == 1
    }

    /// The place at travel parameter `t`.
    pub fn spot(&self, cuts: &[Cut], t: f64) -> Spot {
        if self.is_single() {
            return Spot { span: 0, u: curve_parameter(&*self.curve, self.heading, t), junction: None };
        }
        let t = if self.curve.closed() { wrap(t) } else { t.clamp(0.0, 1.0) };
        let (span, share) = part_of(self.spans.len(), t);
        self.spot_on(cuts, span, share)
    }

    /// The place at travel parameter `t`, where the contour has a corner, to the bit.
    pub fn corner(&self, cuts: &[Cut], t: f64) -> Spot {
        let near = self.spot(cuts, t);
        let apart = |v: f64| (near.u - v - (near.u - v).round()).abs();
        if !self.is_single() {
            // A few sums and products of numbers of the size of one lie between.
            let x = t * self.spans.len() as f64;
            if (x - x.round()).abs() < 1e-9 {
                let span = (x.round() as i64).rem_euclid(self.spans.len() as i64);
                return self.spot_on(cuts, span as usize, 0.0);
            }
        }
        let corners = cuts[self.spans[near.span as usize].cut as usize].curve.corners().iter().copied();
        let nearest = corners.min_by(|a, b| apart(*a).total_cmp(&apart(*b)));
        Spot { u: nearest.unwrap_or(near.u), ..near }
    }

    /// Where it begins (0) or ends (1) on a border.
    pub fn end(&self, which: usize) -> Spot {
        let span = if which == 0 { 0 } else { self.spans.len() - 1 };
        let own = &self.spans[span];
        Spot { span: span as u32, u: own.u[which], junction: own.junctions[which] }
    }

    /// How far on its travel parameter comes in `way` of the travel along a stretch's curve.
    pub(super) fn travel(&self, span: &Span, way: f64) -> f64 {
        if self.is_single() { way } else { way / ((span.t[1] - span.t[0]) * self.spans.len() as f64) }
    }

    fn spot_on(&self, cuts: &[Cut], span: usize, share: f64) -> Spot {
        let own = &self.spans[span];
        let cut = &cuts[own.cut as usize];
        let u = own.parameter(cut, share);
        let junction = own.junctions[0].filter(|_| share == 0.0);
        Spot { span: span as u32, u, junction }
    }
}

impl Span {
    /// The curve's parameter at a share of the way: both ends to the bit.
    fn parameter(&self, cut: &Cut, share: f64) -> f64 {
        match share {
            0.0 => self.u[0],
            1.0 => self.u[1],
            _ => curve_parameter(&*cut.curve, cut.heading, self.t[0] + (self.t[1] - self.t[0]) * share),
        }
    }

    fn share(&self, t: f64) -> f64 {
        (t - self.t[0]) / (self.t[1] - self.t[0])
    }
}

/// Of `n` parts of [0, 1], the one that holds `t`, and the share of it.
fn part_of(n: usize, t: f64) -> (usize, f64) {
    let x = t * n as f64;
    let part = (x.floor().max(0.0) as usize).min(n - 1);
    (part, (x - part as f64).clamp(0.0, 1.0))
}

/// Several stretches as one curve, each with the same share of the parameter.
#[derive(Debug)]
struct Joined {
    pieces: Vec<Piece>,
    closed: bool,
}

#[derive(Debug)]
struct Piece {
    cut: Cut,
    span: Span,
    /// The junction that it begins with.
    start: Option<DVec3>,
}

impl Curve for Joined {
    fn position(&self, u: f64) -> DVec3 {
        let (part, share) = part_of(self.pieces.len(), if self.closed { wrap(u) } else { u });
        let piece = &self.pieces[part];
        let on_curve = || piece.cut.curve.position(piece.span.parameter(&piece.cut, share));
        piece.start.filter(|_| share == 0.0).unwrap_or_else(on_curve)
    }

    fn derivative(&self, u: f64) -> DVec3 {
        let n = self.pieces.len();
        let (part, share) = part_of(n, if self.closed { wrap(u) } else { u });
        let piece = &self.pieces[part];
        let sign = if piece.cut.heading == Heading::Along { 1.0 } else { -1.0 };
        let rate = sign * n as f64 * (piece.span.t[1] - piece.span.t[0]);
        piece.cut.curve.derivative(piece.span.parameter(&piece.cut, share)) * rate
    }

    fn closed(&self) -> bool {
        self.closed
    }
}

/// What the curves together make.
#[derive(Debug)]
pub struct Arrangement {
    /// The borders.
    pub contours: Vec<Contour>,
    /// The track of each contour.
    pub track: Track,
    /// The junctions of the contours.
    pub junctions: Vec<Junction>,
    /// The curves no part of which is a border, ascending.
    pub unused: Vec<usize>,
    /// By contour and stretch, the parameters that it has to have, if any.
    pub given: Vec<Vec<Option<Arc<CurveParameters>>>>,
    /// What tells left from right.
    pub stays: Stays,
}

/// A stretch before it is known whether it stays.
pub(super) struct Stretch {
    pub span: Span,
    /// Where it begins and ends on its curve's track.
    from: Near,
    to: Near,
}

/// Finds the borders of what stays, or of the other side of a set whose curves are turned.
///
/// # Errors
/// When a pre-image is not usable or crosses itself, curves do not separate the surface, or cross in
/// a way that leaves no border: see [`RemeshError`].
pub fn arrange(
    surface: &LoopSurface,
    cuts: &[Cut],
    preimages: &[PreImage],
    options: &JunctionOptions,
    other: Option<&OtherSide>,
) -> Result<Arrangement, RemeshError> {
    let mesh = &*surface.mesh;
    let pre_image = |curve, source| RemeshError::PreImage { curve, source };
    let curves = Track::new(mesh, cuts, preimages).map_err(|(curve, source)| pre_image(curve, source))?;
    cusps::check(&curves, cuts, options)?;
    let ways = Ways::new(&curves, mesh.face_count());
    let crossings = crossing::find(&curves, &ways).map_err(|source| {
        pre_image(if let PreImageError::Crossing { curves, .. } = &source { curves[0] } else { 0 }, source)
    })?;
    let meetings =
        crossings.iter().map(|c| junction::meet(&curves, cuts, c, options)).collect::<Result<Vec<_>, _>>()?;
    let with_bits = |meeting| other.map_or(meeting, |other| other.with_bits(meeting));
    let meetings: Vec<Meeting> = meetings.into_iter().map(with_bits).collect();
    let stretches = stretches(&curves, &crossings, &meetings)?;
    let (stays, borders) = Sets::new(mesh, &curves, cuts).stays(ways, &stretches, other.map(|other| other.set))?;
    let kept: Vec<&Stretch> = stretches.iter().zip(&borders).filter(|(_, border)| **border).map(|s| s.0).collect();
    let mut used = vec![false; cuts.len()];
    kept.iter().for_each(|s| used[s.span.cut as usize] = true);
    let mut built = Builder {
        curves: &curves,
        cuts,
        meetings: &meetings,
        borders: &Borders::new(surface),
        options,
        names: vec![NONE; meetings.len()],
        junctions: Vec::new(),
        track: Track::default(),
    };
    let chains = chains(&curves, &kept, meetings.len())?;
    let contours: Vec<Contour> = chains.iter().map(|chain| built.contour(chain)).collect::<Result<_, _>>()?;
    let of_span = |span: &Span| other.and_then(|other| other.parameters(cuts, span));
    let given = contours.iter().map(|contour| contour.spans.iter().map(of_span).collect()).collect();
    let (track, junctions) = (built.track, built.junctions);
    let unused = (0..cuts.len()).filter(|&c| !used[c]).collect();
    Ok(Arrangement { contours, track, junctions, unused, given, stays })
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
fn stretches(track: &Track, crossings: &[Crossing], meetings: &[Meeting]) -> Result<Vec<Stretch>, RemeshError> {
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
            let p = &track.points[from.near.segment as usize];
            // Places so near to each other that they come in another order in space.
            if from.t >= to.t || from.t.is_nan() || to.t.is_nan() {
                return Err(RemeshError::Tangled { curve: p.curve as usize, u: from.u, at: p.position });
            }
            let span =
                Span { cut: p.curve, t: [from.t, to.t], u: [from.u, to.u], junctions: [from.junction, to.junction] };
            stretches.push(Stretch { span, from: from.near, to: to.near });
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
fn share_in(part: [f64; 2], f: f64) -> f64 {
    let width = part[1] - part[0];
    if width > 0.0 { ((f - part[0]) / width).clamp(0.0, 1.0) } else { f64::from(u8::from(f > part[0])) }
}

/// The segments between two places of one track, with the part of each.
fn segments(track: &Track, from: Near, to: Near) -> Vec<(u32, [f64; 2])> {
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

/// Puts the stretches that stay one after the other, from junction to junction.
fn chains<'a>(track: &Track, kept: &[&'a Stretch], junctions: usize) -> Result<Vec<Vec<&'a Stretch>>, RemeshError> {
    let tangled = |k: usize| {
        let p = &track.points[kept[k].from.segment as usize];
        RemeshError::Tangled { curve: p.curve as usize, u: p.u, at: p.position }
    };
    // By junction, the one stretch that begins there.
    let mut begins = vec![None; junctions];
    for (k, stretch) in kept.iter().enumerate() {
        if let Some(j) = stretch.span.junctions[0]
            && begins[j as usize].replace(k).is_some()
        {
            return Err(tangled(k));
        }
    }
    let mut used = vec![false; kept.len()];
    let mut chains = Vec::new();
    // Those that begin on a border first: the others run round.
    let from_border = (0..kept.len()).filter(|&k| kept[k].span.junctions[0].is_none());
    for start in from_border.chain(0..kept.len()).collect::<Vec<_>>() {
        if used[start] {
            continue;
        }
        let mut chain = Vec::new();
        let mut at = start;
        loop {
            used[at] = true;
            chain.push(kept[at]);
            let Some(j) = kept[at].span.junctions[1] else { break };
            match begins[j as usize] {
                Some(next) if next == start => break,
                Some(next) if !used[next] => at = next,
                _ => return Err(tangled(at)),
            }
        }
        chains.push(chain);
    }
    Ok(chains)
}

/// Makes contours of chains, and their tracks.
struct Builder<'a> {
    curves: &'a Track,
    cuts: &'a [Cut],
    meetings: &'a [Meeting],
    borders: &'a Borders<'a>,
    options: &'a JunctionOptions,
    /// By crossing, its junction among those that count.
    names: Vec<u32>,
    junctions: Vec<Junction>,
    track: Track,
}

/// Points of a track nearer to a junction than this part of their segment are passed over: so short
/// a piece has no direction of its own, since a junction lies a little beside the track.
const NEAR_JUNCTION: f64 = 0.1;

impl Builder<'_> {
    fn contour(&mut self, chain: &[&Stretch]) -> Result<Contour, RemeshError> {
        let closed = match chain {
            [only] if only.span.junctions == [None; 2] => self.curves.tracks[only.span.cut as usize].closed,
            _ => chain[0].span.junctions[0].is_some(),
        };
        let mut spans: Vec<Span> = chain.iter().map(|s| self.named(&s.span)).collect();
        let ends = if closed { [None; 2] } else { self.ends(chain, &mut spans)? };
        if let [span] = spans.as_slice() {
            let whole = self.curves.tracks[span.cut as usize];
            let mut points = self.curves.points[whole.begin as usize..(whole.begin + whole.count) as usize].to_vec();
            pin(&mut points, ends, span.t);
            self.track.append(points, closed);
            return Ok(Contour::single(&self.cuts[span.cut as usize], *span));
        }
        let n = chain.len() as f64;
        let mut points = Vec::new();
        for (k, stretch) in chain.iter().enumerate() {
            self.points(stretch, &|share| (k as f64 + share) / n, &mut points);
        }
        if let (false, Some(last)) = (closed, chain.last()) {
            let end = &self.curves.points[self.curves.points[last.to.segment as usize].next as usize];
            points.push(TrackPoint { t: 1.0, legs: Vec::new(), ..end.clone() });
            pin(&mut points, ends, [0.0, 1.0]);
        }
        self.track.append(points, closed);
        let piece = |span: &Span| {
            let start = span.junctions[0].map(|j| self.junctions[j as usize].point);
            Piece { cut: self.cuts[span.cut as usize].clone(), span: *span, start }
        };
        let pieces = spans.iter().map(piece).collect();
        Ok(Contour { spans, curve: Arc::new(Joined { pieces, closed }), heading: Heading::Along })
    }

    /// A span with the junctions named that count.
    fn named(&mut self, span: &Span) -> Span {
        Span { junctions: span.junctions.map(|j| j.map(|j| self.name(j))), ..*span }
    }

    /// Joins both ends of a chain to the borders that they lie on; returns the points there.
    fn ends(&mut self, chain: &[&Stretch], spans: &mut [Span]) -> Result<[Option<DVec3>; 2], RemeshError> {
        let mut points = [None; 2];
        let last = chain.len() - 1;
        for (which, k) in [(0, 0), (1, last)] {
            let near = if which == 0 { chain[k].from } else { chain[k].to };
            let Some(meeting) = junction::leave(self.borders, self.curves, self.cuts, near, self.options)? else {
                continue;
            };
            let span = &mut spans[k];
            span.t[which] = meeting.t[1];
            span.u[which] = meeting.junction.ends[1].1;
            span.junctions[which] = Some(self.junctions.len() as u32);
            self.junctions.push(meeting.junction);
            points[which] = Some(meeting.junction.point);
        }
        Ok(points)
    }

    /// The number of a junction, given when it is first met.
    fn name(&mut self, j: u32) -> u32 {
        let name = &mut self.names[j as usize];
        if *name == NONE {
            *name = self.junctions.len() as u32;
            self.junctions.push(self.meetings[j as usize].junction);
        }
        *name
    }

    /// The points of a stretch but for its end.
    fn points(&self, stretch: &Stretch, t: &dyn Fn(f64) -> f64, points: &mut Vec<TrackPoint>) {
        let begin = points.len();
        let first = &self.curves.points[stretch.from.segment as usize];
        let [start, end] = stretch.span.junctions.map(|j| j.map(|j| &self.meetings[j as usize].junction));
        points.push(TrackPoint {
            position: start.map_or(first.position, |j| j.point),
            t: t(0.0),
            corner: start.is_some(),
            legs: Vec::new(),
            ..first.clone()
        });
        // Travel parameters on the track may be a turn early.
        let own = |q: f64| if q < stretch.span.t[0] { q + 1.0 } else { q };
        for (k, (segment, part)) in segments(self.curves, stretch.from, stretch.to).into_iter().enumerate() {
            let p = &self.curves.points[segment as usize];
            let (a, b) = self.curves.ends(segment);
            let (share, length) = (stretch.span.share(own(p.t)), a.distance(b));
            let far = |j: Option<&Junction>| j.is_none_or(|j| j.point.distance(p.position) > NEAR_JUNCTION * length);
            if k > 0 && 0.0 < share && share < 1.0 && (p.corner || (far(start) && far(end))) {
                points.push(TrackPoint { t: t(share), legs: Vec::new(), ..p.clone() });
            }
            let last = points.len() - 1;
            points[last].legs.extend(p.legs.iter().filter_map(|leg| clipped(leg, part)));
        }
        points[begin..].iter_mut().for_each(|p| share_out(&mut p.legs));
    }
}

/// Puts both ends of a track where its junctions are.
fn pin(points: &mut [TrackPoint], ends: [Option<DVec3>; 2], t: [f64; 2]) {
    let last = points.len() - 1;
    for (which, k) in [(0, 0), (1, last)] {
        if let Some(point) = ends[which] {
            points[k].position = point;
            points[k].t = t[which];
        }
    }
}

/// The piece of a leg within a part of its segment.
fn clipped(leg: &Leg, part: [f64; 2]) -> Option<Leg> {
    let [from, to] = part.map(|f| share_in(leg.part, f));
    let is_outside = leg.part[1] < part[0] || leg.part[0] > part[1];
    (!is_outside && (from < to || leg.from == leg.to)).then(|| Leg {
        from: leg.from.lerp(leg.to, from),
        to: leg.from.lerp(leg.to, to),
        ..*leg
    })
}

/// Gives each leg of a way its part of it, by length.
fn share_out(legs: &mut [Leg]) {
    let total: f64 = legs.iter().map(|l| l.from.distance(l.to)).sum();
    let mut along = 0.0;
    for leg in legs {
        let from = if total > 0.0 { along / total } else { 0.0 };
        along += leg.from.distance(leg.to);
        leg.part = [from, if total > 0.0 { along / total } else { 1.0 }];
    }
}
