//! # Attach: a strip of triangles joins what is left to the curve
//!
//! ```text
//!    q0 --- q1 --- q2 --- q3        the rim of what is left
//!      \   /  \   /  \   /  \
//!       p0 --- p1 --- p2 --- ..     on the curve
//! ```
//!
//! Knot `p_i` is joined to the rim vertices `q_a ..= q_(a + span)`, and shares the last of them with
//! the next knot. A span of one gives the valence of four that a smooth boundary vertex must have; a
//! convex corner has span zero and valence three, a concave one span two and valence five, so all
//! corners are regular in the lattice. There are as many knots as rim edges, and one more for each
//! convex corner, one fewer for each concave one.

use glam::DVec3;

use super::remove::Rim;
use super::track::{Near, Track};

/// A new vertex on a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// The travel parameter, unwrapped.
    pub t: f64,
    /// What it is.
    pub kind: KnotKind,
    /// The first rim vertex that it is joined to, by its place in the rim.
    pub first: u32,
}

/// What a new vertex on a curve is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KnotKind {
    /// The curve is smooth there; the parameter may move.
    Smooth,
    /// The curve turns to the left, the kept side: an interior angle below pi.
    Convex,
    /// The curve turns to the right: an interior angle above pi.
    Concave,
    /// The curve ends there on a border, in a corner of an interior angle below pi. It sees one edge
    /// of the rim, whose end is its neighbour along the border.
    End,
}

impl KnotKind {
    /// How many rim edges it sees.
    pub const fn span(self) -> u32 {
        match self {
            Self::Convex => 0,
            Self::Smooth | Self::End => 1,
            Self::Concave => 2,
        }
    }

    /// How many edges meet there.
    pub const fn valence(self) -> u32 {
        match self {
            Self::End => 3,
            other => other.span() + 3,
        }
    }
}

/// The knots along one curve, in its direction of travel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strip {
    /// The curve, by index.
    pub cut: u32,
    /// The rim's vertices.
    pub rim: Vec<u32>,
    /// The knots.
    pub knots: Vec<Knot>,
    /// Does it run round?
    pub closed: bool,
}

impl Strip {
    /// The triangles, with knot `i` named `name(i)`.
    pub fn triangles(&self, name: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
        let m = self.rim.len();
        let q = |i: u32| self.rim[i as usize % m];
        let mut triangles = Vec::with_capacity(2 * m);
        for (i, knot) in self.knots.iter().enumerate() {
            let last = knot.first + knot.kind.span();
            triangles.extend((knot.first..last).map(|j| [q(j + 1), q(j), name(i)]));
            if self.closed || i + 1 < self.knots.len() {
                triangles.push([q(last), name(i), name((i + 1) % self.knots.len())]);
            }
        }
        triangles
    }

    /// The two rim vertices that a smooth knot sees.
    pub fn base(&self, knot: &Knot) -> [u32; 2] {
        let m = self.rim.len();
        [self.rim[knot.first as usize % m], self.rim[(knot.first as usize + 1) % m]]
    }
}

/// A corner of a curve as it meets the rim.
struct Corner {
    along: f64,
    /// The rim vertex nearest to it.
    nearest: usize,
    kind: KnotKind,
}

/// Lays the strip between `rim` and curve `cut`. `limit` gives the rim's limit points and normals.
///
/// # Errors
/// The place of a corner that finds no room on the rim.
pub fn attach(track: &Track, cut: u32, rim: &Rim, limit: impl Fn(u32) -> (DVec3, DVec3)) -> Result<Strip, Near> {
    let m = rim.vertices.len();
    let whole = track.tracks[cut as usize];
    let mut corners: Vec<Corner> = (whole.begin..whole.begin + whole.count)
        .filter(|&p| track.points[p as usize].corner)
        .map(|p| corner(track, p, rim, &limit))
        .collect();
    corners.sort_by_key(|c| c.nearest);
    if !rim.closed {
        let end = |along, nearest| Corner { along, nearest, kind: KnotKind::End };
        if m < 3 {
            return Err(track.place(cut, 0.0));
        }
        corners.insert(0, end(0.0, 0));
        corners.push(end(whole.length, m - 2));
    }
    let mut knots =
        if corners.is_empty() { plain_knots(m) } else { knots_between(track, cut, &corners, m, rim.closed)? };
    first_guess(track, cut, rim, &limit, &mut knots, &corners);
    let mut strip = Strip { cut, rim: rim.vertices.clone(), knots, closed: rim.closed };
    space_out(track, &mut strip);
    Ok(strip)
}

fn plain_knots(m: usize) -> Vec<Knot> {
    (0..m as u32).map(|first| Knot { t: 0.0, kind: KnotKind::Smooth, first }).collect()
}

fn corner(track: &Track, p: u32, rim: &Rim, limit: &impl Fn(u32) -> (DVec3, DVec3)) -> Corner {
    let point = &track.points[p as usize];
    let length = track.tracks[point.cut as usize].length;
    // The rim may pass the corner's place in space again elsewhere: only the stretch along the curve
    // is asked, a quarter of it to either side at most.
    let apart = |i: usize| {
        let d = rim.along[i] - point.along;
        if rim.closed { (d - (d / length).round() * length).abs() } else { d.abs() }
    };
    let unit = |s: u32| {
        let (a, b) = track.ends(s);
        (b - a).normalize_or_zero()
    };
    let far = |i: usize| limit(rim.vertices[i]).0.distance(point.position);
    let usable = |i: &usize| apart(*i) <= 0.25 * length;
    let near = (0..rim.vertices.len()).filter(usable).min_by(|&a, &b| far(a).total_cmp(&far(b))).unwrap_or(0);
    let normal = limit(rim.vertices[near]).1;
    let (before, after) = (unit(point.previous), unit(p));
    // Half-way between the two sides, into what stays.
    let bisector = normal.cross(before + after).normalize_or_zero();
    let off = |i: usize| 1.0 - (limit(rim.vertices[i]).0 - point.position).normalize_or_zero().dot(bisector);
    let close = |i: &usize| far(*i) <= CORNER_REACH * far(near);
    let nearest = (0..rim.vertices.len())
        .filter(|i| usable(i) && close(i))
        .min_by(|&a, &b| off(a).total_cmp(&off(b)))
        .unwrap_or(near);
    let turn = before.cross(after).dot(normal);
    let kind = if turn < 0.0 { KnotKind::Concave } else { KnotKind::Convex };
    // How far round the rim has come there.
    let rounds = if rim.closed { ((rim.along[nearest] - point.along) / length).round() } else { 0.0 };
    let along = point.along + rounds * length;
    Corner { along, nearest, kind }
}

/// Of the rim vertices no farther than this many times the nearest, a corner takes the one that lies
/// best in its middle: so both sides have their fair share of the rim. The rim's triangles are alike
/// in size, so that is within one edge or two.
const CORNER_REACH: f64 = 2.5;

/// Corners where they are, and smooth knots on the rim edges between.
fn knots_between(track: &Track, cut: u32, corners: &[Corner], m: usize, closed: bool) -> Result<Vec<Knot>, Near> {
    // The rim vertices at which a corner's share begins and ends.
    let begin = |c: &Corner| if c.kind == KnotKind::Concave { c.nearest as i64 - 1 } else { c.nearest as i64 };
    let mut knots = Vec::new();
    for (k, c) in corners.iter().enumerate() {
        let next = &corners[(k + 1) % corners.len()];
        let round = if k + 1 == corners.len() { m as i64 } else { 0 };
        let first = begin(c);
        knots.push(Knot { t: 0.0, kind: c.kind, first: (first + m as i64) as u32 });
        if !closed && k + 1 == corners.len() {
            break;
        }
        let from = first + i64::from(c.kind.span());
        let to = begin(next) + round;
        if to - from < FEWEST {
            return Err(track.place(cut, c.along));
        }
        knots.extend((from..to).map(|i| Knot { t: 0.0, kind: KnotKind::Smooth, first: (i + m as i64) as u32 }));
    }
    Ok(knots)
}

/// Smooth knots between two corners, at least: with one there is a vertex that is free to move.
const FEWEST: i64 = 1;

/// Distances along the curve to begin with, kept in `t` until they are spaced out: of a smooth knot
/// the one nearest to the middle of its rim edge.
fn first_guess(
    track: &Track,
    cut: u32,
    rim: &Rim,
    limit: &impl Fn(u32) -> (DVec3, DVec3),
    knots: &mut [Knot],
    corners: &[Corner],
) {
    let m = rim.vertices.len();
    let length = track.tracks[cut as usize].length;
    let mut corner = corners.iter();
    let mut last = f64::NEG_INFINITY;
    for knot in knots {
        let i = knot.first as usize % m;
        let near = if knot.kind == KnotKind::Smooth {
            let middle = 0.5 * (limit(rim.vertices[i]).0 + limit(rim.vertices[(i + 1) % m]).0);
            let start = track.place(cut, rim.along[i]);
            track.along(track.nearest(start.segment, middle))
        } else {
            corner.next().map_or(0.0, |c| c.along)
        };
        // The nearest place may have been counted from another round of the curve.
        let reference = if last.is_finite() { last } else { near };
        let rounds = if rim.closed { ((near - reference) / length).round() } else { 0.0 };
        knot.t = near - rounds * length;
        last = knot.t;
    }
}

/// The smallest gap between neighbours, as a part of the mean gap of their stretch: below it the
/// relaxation, which keeps the middle 40 % between neighbours, has no room to begin.
const SMALLEST_GAP: f64 = 0.3;

/// Rounds of smoothing, each a quarter-half-quarter average: enough for disorder over some ten knots;
/// what is left after that is spaced evenly.
const ROUNDS: u32 = 200;

/// Makes the distances rise, by smoothing them until all gaps are wide enough, and turns them into
/// parameters. Corners stay where they are.
fn space_out(track: &Track, strip: &mut Strip) {
    let length = track.tracks[strip.cut as usize].length;
    let n = strip.knots.len();
    let fixed: Vec<usize> = (0..n).filter(|&i| strip.knots[i].kind != KnotKind::Smooth).collect();
    let mut along: Vec<f64> = strip.knots.iter().map(|k| k.t).collect();
    if fixed.is_empty() {
        smooth_round(&mut along, length);
    } else {
        for (k, &from) in fixed.iter().enumerate() {
            let round = if k + 1 == fixed.len() { length } else { 0.0 };
            let to = fixed[(k + 1) % fixed.len()];
            let count = if to > from { to - from } else { to + n - from };
            let end = along[to] + round;
            // A corner seen a round early or late.
            let end = along[from] + (end - along[from]).rem_euclid(length);
            let end = if end <= along[from] { end + length } else { end };
            let mut piece: Vec<f64> = (0..count).map(|j| along[(from + j) % n]).collect();
            piece.iter_mut().skip(1).for_each(|x| *x -= ((*x - 0.5 * (along[from] + end)) / length).round() * length);
            piece.push(end);
            smooth_piece(&mut piece);
            for j in 1..count {
                along[(from + j) % n] = piece[j];
            }
            if k + 1 < fixed.len() {
                along[to] = end;
            }
        }
    }
    for (knot, along) in strip.knots.iter_mut().zip(along) {
        knot.t = track.parameter_at(strip.cut, along);
    }
}

/// A whole closed curve without corners.
fn smooth_round(along: &mut [f64], length: f64) {
    let n = along.len();
    let least = SMALLEST_GAP * length / n as f64;
    let extended = |x: &[f64], i: usize| {
        [
            x[(i + n - 1) % n] - if i == 0 { length } else { 0.0 },
            x[i],
            x[(i + 1) % n] + if i + 1 == n { length } else { 0.0 },
        ]
    };
    for _ in 0..ROUNDS {
        if (0..n).all(|i| extended(along, i)[2] - along[i] >= least) {
            return;
        }
        let next: Vec<f64> = (0..n).map(|i| extended(along, i)).map(|[a, b, c]| 0.25 * (a + c) + 0.5 * b).collect();
        along.copy_from_slice(&next);
    }
    let first = along[0];
    along.iter_mut().enumerate().for_each(|(i, x)| *x = first + length * i as f64 / n as f64);
}

/// A stretch between two fixed ends.
fn smooth_piece(x: &mut [f64]) {
    let n = x.len() - 1;
    let (from, to) = (x[0], x[n]);
    let least = SMALLEST_GAP * (to - from) / n as f64;
    for _ in 0..ROUNDS {
        if x.windows(2).all(|w| w[1] - w[0] >= least) {
            return;
        }
        let next: Vec<f64> = x.windows(3).map(|w| 0.25 * (w[0] + w[2]) + 0.5 * w[1]).collect();
        x[1..n].copy_from_slice(&next);
    }
    x.iter_mut().enumerate().for_each(|(i, x)| *x = from + (to - from) * i as f64 / n as f64);
}
