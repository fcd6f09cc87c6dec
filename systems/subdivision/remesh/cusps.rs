//! Places at which a curve turns back on itself.
//!
//! At corners its one-sided derivatives tell. Elsewhere the curve is a black box, and a cusp lies
//! anywhere between two points of its track; but a track that follows its curve turns by little at
//! each point, so wherever it turns by much the curve is looked at more closely: in a window that
//! halves around the sharpest turn, a smooth bend comes to turn by nothing, a corner keeps its angle,
//! and at a cusp the ways to both sides come to be one.

use glam::DVec3;
use selvedge_components::curve::{Curve, wrap};
use selvedge_components::subdivision::NONE;
use selvedge_components::subdivision::remesh::RemeshError;

use super::Cut;
use super::junction::JunctionOptions;
use super::track::{Track, TrackPoint};

/// Refuses places at which a curve turns back on itself: its corners, and wherever its track turns
/// sharply and the curve between its points does too.
pub(super) fn check(track: &Track, cuts: &[Cut], options: &JunctionOptions) -> Result<(), RemeshError> {
    for p in track.points.iter().filter(|p| p.previous != NONE && p.next != NONE) {
        let curve = &*cuts[p.curve as usize].curve;
        let tip = if p.corner {
            let angle = (-curve.derivative_before(p.u)).angle_between(curve.derivative(p.u));
            Some(Tip { u: p.u, at: p.position, angle: angle.to_degrees() })
        } else {
            Window::around(track, p, curve).and_then(|window| window.narrow(curve))
        };
        if let Some(Tip { u, at, angle }) = tip.filter(|tip| tip.angle < options.angle) {
            return Err(RemeshError::Cusp { curve: p.curve as usize, u, at, angle, limit: options.angle });
        }
    }
    Ok(())
}

/// A place where a curve has an angle.
struct Tip {
    u: f64,
    at: DVec3,
    /// Between the ways to both sides, in degrees.
    angle: f64,
}

/// Five points of a curve at even steps of its parameter, which may run over its end.
struct Window {
    begin: f64,
    step: f64,
    points: [DVec3; 5],
}

/// The turn, in radians, from which on a track is looked at: a track that follows its curve turns by
/// twentieths, one past a cusp by half a turn at one point or at two.
const SHARP: f64 = 0.5;

/// Ways shorter than this part of their coordinates are left alone: what rounding there is of points,
/// some hundreds of units where they are projected onto a surface, turns them by less than a degree.
const SHORT: f64 = 1e5 * f64::EPSILON;

/// Halvings, at most: from a sixteenth of the parameter to its rounding.
const HALVINGS: u32 = 48;

impl Window {
    /// The window from the point before `p` to the one after it, where the track turns sharply.
    fn around(track: &Track, p: &TrackPoint, curve: &dyn Curve) -> Option<Self> {
        let before = aside(track, p, |p| p.previous)?;
        let after = aside(track, p, |p| p.next)?;
        if (p.position - before.position).angle_between(after.position - p.position) < SHARP {
            return None;
        }
        // Over the end of a closed curve the shorter way is meant.
        let way = |q: &TrackPoint| {
            let way = q.u - p.u;
            if curve.closed() { way - way.round() } else { way }
        };
        let (from, to) = (p.u + way(before), p.u + way(after));
        Some(Self::over(curve, from, to))
    }

    fn over(curve: &dyn Curve, from: f64, to: f64) -> Self {
        let step = 0.25 * (to - from);
        Self { begin: from, step, points: [0, 1, 2, 3, 4].map(|k| at(curve, from + f64::from(k) * step)) }
    }

    fn turn(&self, k: usize) -> f64 {
        let [a, b, c] = [k - 1, k, k + 1].map(|k| self.points[k]);
        (b - a).angle_between(c - b)
    }

    /// Halves the window around its sharpest turn for as long as it has a sharp one, and says what it
    /// narrows down to. Two points of the curve are asked for each time.
    fn narrow(mut self, curve: &dyn Curve) -> Option<Tip> {
        for _ in 0..HALVINGS {
            let [a, b, c, d, e] = self.points;
            let short = SHORT * c.abs().max_element();
            if (b - a).length().min((e - d).length()) <= short {
                break;
            }
            let first = [1, 2, 3].into_iter().max_by(|&i, &j| self.turn(i).total_cmp(&self.turn(j)))? - 1;
            // Half a turn shared by two points is a quarter at each.
            if self.turn(first + 1).is_nan() || self.turn(first + 1) < SHARP {
                return None;
            }
            let (begin, step) = (self.begin + first as f64 * self.step, 0.5 * self.step);
            let [p, q, r] = [first, first + 1, first + 2].map(|k| self.points[k]);
            let points = [p, at(curve, begin + step), q, at(curve, begin + 3.0 * step), r];
            let next = Self { begin, step, points };
            if !next.is_told_apart(short) {
                break;
            }
            self = next;
        }
        let [a, b, c, d, e] = self.points;
        let u = self.begin + 2.0 * self.step;
        let u = if curve.closed() { wrap(u) } else { u };
        Some(Tip { u, at: c, angle: (a - b).angle_between(e - d).to_degrees() })
    }

    /// Are the ways at both ends long enough to have a direction?
    fn is_told_apart(&self, short: f64) -> bool {
        let [a, b, _, d, e] = self.points;
        (b - a).length().min((e - d).length()) > short
    }
}

fn at(curve: &dyn Curve, u: f64) -> DVec3 {
    curve.position(if curve.closed() { wrap(u) } else { u.clamp(0.0, 1.0) })
}

/// Points nearer than this part of their coordinates have no direction from one to the other.
const NO_WAY: f64 = 1e3 * f64::EPSILON;

/// The first point of a track on one side of another that is not in the same place.
fn aside<'a>(track: &'a Track, from: &TrackPoint, next: impl Fn(&TrackPoint) -> u32) -> Option<&'a TrackPoint> {
    let least = NO_WAY * from.position.abs().max_element();
    let mut at = next(from);
    for _ in 0..track.tracks[from.cut as usize].count {
        let point = track.points.get(at as usize).filter(|_| at != NONE)?;
        if point.position.distance(from.position) > least {
            return Some(point);
        }
        at = next(point);
    }
    None
}
