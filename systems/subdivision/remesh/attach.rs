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
use super::seats::{Corner, FEWEST, corner, seat};
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
    /// How many rim edges it sees: as many as its kind asks for, unless its parameter is given.
    pub span: u32,
    /// Is its parameter given, so that it stays where it is?
    pub given: bool,
}

impl Knot {
    /// A knot that may move, and sees what its kind asks for.
    const fn new(kind: KnotKind, first: u32) -> Self {
        Self { t: 0.0, kind, first, span: kind.span(), given: false }
    }
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
            let last = knot.first + knot.span;
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

impl Strip {
    /// By knot, the length of the rim that it sees.
    pub fn widths(&self, limit: impl Fn(u32) -> DVec3) -> Vec<f64> {
        let m = self.rim.len();
        let q = |i: u32| limit(self.rim[i as usize % m]);
        let width = |k: &Knot| (k.first..k.first + k.span).map(|j| q(j).distance(q(j + 1))).sum();
        self.knots.iter().map(width).collect()
    }
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
    corners.sort_by(|a, b| a.along.total_cmp(&b.along));
    if !rim.closed {
        let end = |along, nearest: usize| Corner { along, nearest: nearest as i64, kind: KnotKind::End };
        if m < 3 {
            return Err(track.place(cut, 0.0));
        }
        corners.insert(0, end(0.0, 0));
        corners.push(end(whole.length, m - 2));
    }
    seat(track, cut, &mut corners, m, rim.closed)?;
    let mut knots =
        if corners.is_empty() { plain_knots(m) } else { knots_between(track, cut, &corners, m, rim.closed)? };
    first_guess(track, cut, rim, &limit, &mut knots, &corners);
    let mut strip = Strip { cut, rim: rim.vertices.clone(), knots, closed: rim.closed };
    let widths = strip.widths(|v| limit(v).0);
    space_out(track, &mut strip, &widths);
    Ok(strip)
}

fn plain_knots(m: usize) -> Vec<Knot> {
    (0..m as u32).map(|first| Knot::new(KnotKind::Smooth, first)).collect()
}

/// Corners where they are, and smooth knots on the rim edges between.
fn knots_between(track: &Track, cut: u32, corners: &[Corner], m: usize, closed: bool) -> Result<Vec<Knot>, Near> {
    let name = |i: i64| (i + m as i64) as u32;
    let mut knots = Vec::new();
    for (k, c) in corners.iter().enumerate() {
        let next = &corners[(k + 1) % corners.len()];
        let round = if k + 1 == corners.len() { m as i64 } else { 0 };
        let [first, from] = c.share();
        knots.push(Knot::new(c.kind, name(first)));
        if !closed && k + 1 == corners.len() {
            break;
        }
        let to = next.share()[0] + round;
        if to - from < FEWEST {
            return Err(track.place(cut, c.along));
        }
        knots.extend((from..to).map(|i| Knot::new(KnotKind::Smooth, name(i))));
    }
    Ok(knots)
}

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

/// The smallest gap between neighbours, as a part of the gap that suits the rim beside it: below it
/// the relaxation, which keeps the middle 40 % between neighbours, has no room to begin.
const SMALLEST_GAP: f64 = 0.3;

/// Rounds of smoothing: enough for disorder over some ten knots; what is left after that is spaced
/// as the rim is.
const ROUNDS: u32 = 200;

/// Makes the distances rise, by smoothing them until all gaps are wide enough, and turns them into
/// parameters. Corners stay where they are.
fn space_out(track: &Track, strip: &mut Strip, widths: &[f64]) {
    let length = track.tracks[strip.cut as usize].length;
    let n = strip.knots.len();
    let fixed: Vec<usize> = (0..n).filter(|&i| strip.knots[i].kind != KnotKind::Smooth).collect();
    let mut along: Vec<f64> = strip.knots.iter().map(|k| k.t).collect();
    let gap = |i: usize| 0.5 * (widths[i % n] + widths[(i + 1) % n]);
    if fixed.is_empty() {
        let mut gaps: Vec<f64> = (0..n).map(gap).collect();
        scale(&mut gaps, length);
        smooth_round(&mut along, &gaps, length);
    } else {
        for (k, &from) in fixed.iter().enumerate() {
            let round = if k + 1 == fixed.len() { length } else { 0.0 };
            let to = fixed[(k + 1) % fixed.len()];
            let count = if to > from { to - from } else { to + n - from };
            let end = along[to] + round;
            // A corner seen a round early or late; one alone is a whole round from itself.
            let way = if fixed.len() == 1 { length } else { (end - along[from]).rem_euclid(length) };
            let end = along[from] + if way > 0.0 { way } else { length };
            let mut piece: Vec<f64> = (0..count).map(|j| along[(from + j) % n]).collect();
            piece.iter_mut().skip(1).for_each(|x| *x -= ((*x - 0.5 * (along[from] + end)) / length).round() * length);
            piece.push(end);
            let mut gaps: Vec<f64> = (from..from + count).map(gap).collect();
            scale(&mut gaps, end - along[from]);
            smooth_piece(&mut piece, &gaps);
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

/// Makes the gaps fill `length`.
fn scale(gaps: &mut [f64], length: f64) {
    let total: f64 = gaps.iter().sum();
    let even = length / gaps.len() as f64;
    gaps.iter_mut().for_each(|g| *g = if total > 0.0 { *g * length / total } else { even });
}

/// Half-way to where the gaps to both neighbours are as wide as they should be, relative to each
/// other.
fn smoothed([a, b, c]: [f64; 3], [before, after]: [f64; 2]) -> f64 {
    0.5 * b + 0.5 * (after * a + before * c) / (before + after)
}

/// A whole closed curve without corners.
fn smooth_round(along: &mut [f64], gaps: &[f64], length: f64) {
    let n = along.len();
    let extended = |x: &[f64], i: usize| {
        [
            x[(i + n - 1) % n] - if i == 0 { length } else { 0.0 },
            x[i],
            x[(i + 1) % n] + if i + 1 == n { length } else { 0.0 },
        ]
    };
    for _ in 0..ROUNDS {
        if (0..n).all(|i| extended(along, i)[2] - along[i] >= SMALLEST_GAP * gaps[i]) {
            return;
        }
        let next = |i: usize| smoothed(extended(along, i), [gaps[(i + n - 1) % n], gaps[i]]);
        let next: Vec<f64> = (0..n).map(next).collect();
        along.copy_from_slice(&next);
    }
    for i in 1..n {
        along[i] = along[i - 1] + gaps[i - 1];
    }
}

/// A stretch between two fixed ends.
fn smooth_piece(x: &mut [f64], gaps: &[f64]) {
    let n = x.len() - 1;
    for _ in 0..ROUNDS {
        if x.windows(2).zip(gaps).all(|(w, gap)| w[1] - w[0] >= SMALLEST_GAP * gap) {
            return;
        }
        let next: Vec<f64> =
            x.windows(3).zip(gaps.windows(2)).map(|(w, g)| smoothed([w[0], w[1], w[2]], [g[0], g[1]])).collect();
        x[1..n].copy_from_slice(&next);
    }
    for i in 1..n {
        x[i] = x[i - 1] + gaps[i - 1];
    }
}
