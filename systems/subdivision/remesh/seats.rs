//! Corners of a curve on the rim: the vertex that each takes, and room between them.

use glam::DVec3;

use super::attach::KnotKind;
use super::remove::Rim;
use super::track::{Near, Track};

/// A corner of a curve as it meets the rim.
pub(super) struct Corner {
    /// How far along the curve it is, in model units.
    pub along: f64,
    /// The rim vertex nearest to it; it may be counted on beyond the rim's end.
    pub nearest: i64,
    /// What it is.
    pub kind: KnotKind,
}

/// How corner `p` of a track meets the rim. `limit` gives the rim's limit points and normals.
pub(super) fn corner(track: &Track, p: u32, rim: &Rim, limit: &impl Fn(u32) -> (DVec3, DVec3)) -> Corner {
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
    let turn = before.cross(after).dot(normal);
    let m = rim.vertices.len();
    let edge = |i: usize| limit(rim.vertices[i % m]).0.distance(limit(rim.vertices[(i + 1) % m]).0);
    let wide = edge(near).max(edge(near + m - 1));
    let is_far = turn >= 0.0 && far(near) > FAR * wide;
    let reach = if is_far { far(near) + ACROSS * wide } else { CORNER_REACH * far(near) };
    let close = (0..m).filter(|i| usable(i) && far(*i) <= reach);
    // In a wedge the rim may end far from the tip, and runs across in a few edges: those that lead back to the
    // tip are the side's before it, the others the side's after it. So the two part at the vertex that is
    // nearest to the tip along the wedge.
    let depth = |i: usize| (limit(rim.vertices[i]).0 - point.position).dot(after - before);
    let score = |i: usize| if is_far { depth(i) } else { off(i) };
    let nearest = close.min_by(|&a, &b| score(a).total_cmp(&score(b))).unwrap_or(near);
    let kind = if turn < 0.0 { KnotKind::Concave } else { KnotKind::Convex };
    // How far round the rim has come there.
    let rounds = if rim.closed { ((rim.along[nearest] - point.along) / length).round() } else { 0.0 };
    let along = point.along + rounds * length;
    Corner { along, nearest: nearest as i64, kind }
}

/// Of the rim vertices no farther than this many times the nearest, a corner takes the one that lies
/// best in its middle: so both sides have their fair share of the rim. The rim's triangles are alike
/// in size, so that is within one edge or two.
const CORNER_REACH: f64 = 2.5;

/// A rim farther than this many of its edges from a corner ends there in a wedge: with the usual margin one of
/// twelve degrees, or one whose tip has coarser triangles.
const FAR: f64 = 3.0;

/// How many edges the end of a wedge is across, at most: with three the next ones lie along its sides.
const ACROSS: f64 = 3.0;

impl Corner {
    /// The rim vertices at which its share begins and ends.
    pub fn share(&self) -> [i64; 2] {
        let begin = if self.kind == KnotKind::Concave { self.nearest - 1 } else { self.nearest };
        [begin, begin + i64::from(self.kind.span())]
    }
}

/// Moves corners along the rim, as far as one edge each, so that knots find room between them.
///
/// # Errors
/// The place of a corner that would have to move farther.
pub(super) fn seat(track: &Track, cut: u32, corners: &mut [Corner], m: usize, closed: bool) -> Result<(), Near> {
    let n = corners.len();
    let wanted: Vec<i64> = corners.iter().map(|c| c.nearest).collect();
    // Rounds of pushing neighbours apart; each corner moves by one edge at most.
    for _ in 0..2 * n {
        let mut moved = false;
        for k in 0..if closed { n } else { n.saturating_sub(1) } {
            let (j, round) = if k + 1 < n { (k + 1, 0) } else { (0, m as i64) };
            let room = corners[j].share()[0] + round - corners[k].share()[1];
            if room >= FEWEST || n == 1 {
                continue;
            }
            let can = |c: usize, by: i64| {
                corners[c].kind != KnotKind::End && (corners[c].nearest + by - wanted[c]).abs() <= FARTHEST
            };
            if can(j, 1) {
                corners[j].nearest += 1;
            } else if can(k, -1) {
                corners[k].nearest -= 1;
            } else {
                return Err(track.place(cut, corners[k].along));
            }
            moved = true;
        }
        if !moved {
            break;
        }
    }
    Ok(())
}

/// How many edges along the rim a corner may be moved from the vertex that suits it best.
const FARTHEST: i64 = 1;

/// Smooth knots between two corners, at least: with one there is a vertex that is free to move.
pub(super) const FEWEST: i64 = 1;
