//! # Arrange: the borders that the curves together make
//!
//! Where curves cross they are cut into stretches. A stretch stays if what is on its left stays
//! (`sets`); those that stay follow each other from crossing to crossing, and make up contours.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{CurveParameters, Heading};
use selvedge_components::subdivision::remesh::{PreImageError, RemeshError};
use selvedge_components::subdivision::{LoopSurface, NONE};
use selvedge_components::trim::{BorderLine, Junction};

use super::borders::Borders;
use super::contour::{Contour, Joined, Piece, Span};
use super::junction::{self, JunctionOptions, Meeting};
use super::other::OtherSide;
use super::path::Leg;
use super::sets::{Sets, Stays};
use super::stretch::{Stretch, segments, share_in, stretches};
use super::track::{Track, TrackPoint};
use super::winding::{Beyond, Ways};
use super::{Cut, PreImage, crossing, cusps};

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

/// Finds the borders of what stays, or of the other side of a set whose curves are turned, on a surface
/// that hangs together `beyond` what there is of it.
///
/// # Errors
/// When a pre-image is not usable or crosses itself, curves do not separate the surface, or cross in
/// a way that leaves no border: see [`RemeshError`].
pub fn arrange(
    surface: &LoopSurface,
    cuts: &[Cut],
    preimages: &[PreImage],
    options: &JunctionOptions,
    beyond: &Beyond,
    other: Option<&OtherSide>,
) -> Result<Arrangement, RemeshError> {
    let mesh = &*surface.mesh;
    let pre_image = |curve, source| RemeshError::PreImage { curve, source };
    let curves = Track::new(mesh, cuts, preimages).map_err(|(curve, source)| pre_image(curve, source))?;
    cusps::check(&curves, cuts, options)?;
    let ways = Ways::new(&curves, mesh.face_count());
    let crossings = crossing::find(&curves, cuts, &ways).map_err(|source| {
        pre_image(if let PreImageError::Crossing { curves, .. } = &source { curves[0] } else { 0 }, source)
    })?;
    let meetings =
        crossings.iter().map(|c| junction::meet(&curves, cuts, c, options)).collect::<Result<Vec<_>, _>>()?;
    let with_bits = |meeting| other.map_or(meeting, |other| other.with_bits(meeting));
    let meetings: Vec<Meeting> = meetings.into_iter().map(with_bits).collect();
    let stretches = stretches(&curves, &crossings, &meetings)?;
    let sets = Sets::new(mesh, &curves, cuts, beyond);
    let (stays, borders) = sets.stays(ways, &stretches, other.map(|other| other.set))?;
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
    let chains = chains(&curves, &kept, &meetings)?;
    let contours: Vec<Contour> = chains.iter().map(|chain| built.contour(chain)).collect::<Result<_, _>>()?;
    built.check_ends()?;
    let of_span = |span: &Span| other.and_then(|other| other.parameters(cuts, span));
    let given = contours.iter().map(|contour| contour.spans.iter().map(of_span).collect()).collect();
    let (track, junctions) = (built.track, built.junctions);
    let unused = (0..cuts.len()).filter(|&c| !used[c]).collect();
    Ok(Arrangement { contours, track, junctions, unused, given, stays })
}

/// Puts the stretches that stay one after the other, from junction to junction.
fn chains<'a>(track: &Track, kept: &[&'a Stretch], meetings: &[Meeting]) -> Result<Vec<Vec<&'a Stretch>>, RemeshError> {
    let tangled = |k: usize| {
        let Span { cut, u: [u, _], .. } = kept[k].span;
        RemeshError::Tangled { curve: cut as usize, u, at: kept[k].begin(track, meetings) }
    };
    // By junction, the one stretch that begins there.
    let mut begins = vec![None; meetings.len()];
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

/// Ends of curves on a border that are nearer to each other than this part of the longest track are one place:
/// below what a face of the finest level tells apart along it.
const SAME_END: f64 = 1e-6;

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
            pin(&mut points, ends, span.t, span.u);
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
            pin(&mut points, ends, [0.0, 1.0], [spans[0].u[0], spans[chain.len() - 1].u[1]]);
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

    /// No two curves, nor two ends of one, leave the source at one place of its border.
    fn check_ends(&self) -> Result<(), RemeshError> {
        let least = SAME_END * self.track.tracks.iter().map(|whole| whole.length).fold(0.0, f64::max);
        let ends = self.junctions.iter().filter_map(|junction| match junction.ends {
            [(BorderLine::Side(_), _), (BorderLine::Cut(curve), u)] => Some((curve, u, junction.point)),
            _ => None,
        });
        let ends: Vec<(usize, f64, DVec3)> = ends.collect();
        for (k, &(curve, u, at)) in ends.iter().enumerate() {
            if let Some(other) = ends[..k].iter().find(|other| other.2.distance(at) <= least) {
                return Err(if other.0 == curve {
                    RemeshError::TouchesBorder { curve, u, at }
                } else {
                    RemeshError::Tangled { curve, u, at }
                });
            }
        }
        Ok(())
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
            u: stretch.span.u[0],
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
fn pin(points: &mut [TrackPoint], ends: [Option<DVec3>; 2], t: [f64; 2], u: [f64; 2]) {
    let last = points.len() - 1;
    for (which, k) in [(0, 0), (1, last)] {
        if let Some(point) = ends[which] {
            points[k].position = point;
            points[k].t = t[which];
            points[k].u = u[which];
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
