//! Where two curves meet in space: the pair of parameters at which they are nearest.

use glam::DVec3;
use selvedge_components::curve::{Branch, Curve, Heading, tangent, wrap};
use selvedge_components::subdivision::Border;
use selvedge_components::subdivision::remesh::RemeshError;
use selvedge_components::trim::{BorderLine, Junction};

use super::Cut;
use super::borders::{Borders, PlainBorder, given_parameter, is_straight};
use super::crossing::Crossing;
use super::track::{Near, Track};

/// What is asked of a place where curves cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JunctionOptions {
    /// How far apart the curves may pass there, in model units.
    pub gap: f64,
    /// The smallest angle, in degrees, at which curves may cross, and at which the sides of a corner
    /// may meet.
    ///
    /// A wedge of angle `a` holds no vertex nearer to its tip than `m h / sin(a / 2)`, with `m` the
    /// margin and `h` the size of triangles: at 5 degrees 7 of them. So long are the triangles at the
    /// tip, and their shape (twice the area over the longest edge squared) is `sin(a / 2)`, 0.04.
    /// Both fall with the angle, and so does what is known of the place, by its sine.
    pub angle: f64,
}

impl Default for JunctionOptions {
    fn default() -> Self {
        Self { gap: f64::INFINITY, angle: 5.0 }
    }
}

impl JunctionOptions {
    /// What a tolerance of `tolerance` model units allows: gaps up to an eighth of it.
    pub fn within(tolerance: f64) -> Self {
        Self { gap: tolerance / 8.0, ..Self::default() }
    }
}

/// A junction, and where it lies on the travels of its two curves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Meeting {
    pub junction: Junction,
    /// The travel parameters, near those of the track.
    pub t: [f64; 2],
}

/// The junction at a crossing.
///
/// # Errors
/// [`RemeshError::Gap`], [`RemeshError::Tangential`], [`RemeshError::Coincident`].
pub(super) fn meet(
    track: &Track,
    cuts: &[Cut],
    crossing: &Crossing,
    options: &JunctionOptions,
) -> Result<Meeting, RemeshError> {
    let indices = crossing.at.map(|near| track.points[near.segment as usize].curve as usize);
    let lines = [0, 1].map(|i| Line::new(&cuts[indices[i]], track, crossing.at[i]));
    let t = nearest(&lines);
    let ends = [0, 1].map(|i| (BorderLine::Cut(indices[i]), lines[i].parameter(t[i])));
    let point = lines[0].position(t[0]);
    let gap = point.distance(lines[1].position(t[1]));
    let u = ends.map(|end| end.1);
    let angle = angle(&lines, t).to_degrees();
    if angle < options.angle || angle.is_nan() {
        let along = along_each_other(&lines, t, track, crossing);
        return Err(match along {
            Some(distance) => RemeshError::Coincident { curves: indices, u, at: point, distance },
            None => RemeshError::Tangential { curves: indices, u, at: point, angle, limit: options.angle },
        });
    }
    if gap > options.gap || gap.is_nan() {
        return Err(RemeshError::Gap { curves: indices, u, at: point, gap, limit: options.gap });
    }
    Ok(Meeting { junction: Junction { point, ends, gap }, t })
}

/// The junction where a cut ends on a border of the source, at `near`; the cut's travel is the second.
///
/// # Errors
/// [`RemeshError::BorderGap`], [`RemeshError::AlongBorder`].
pub(super) fn leave(
    borders: &Borders<'_>,
    track: &Track,
    cuts: &[Cut],
    near: Near,
    options: &JunctionOptions,
) -> Result<Option<Meeting>, RemeshError> {
    let curve = track.points[near.segment as usize].curve as usize;
    let Some((s, x)) = borders.place(track.source(near)) else { return Ok(None) };
    let side = &borders.surface.sides[s as usize];
    let plain;
    let (border, start): (&dyn Curve, f64) = match &side.border {
        Border::Given { curve: given, .. } => (&**given.curve(), given_parameter(side, given, x, None)),
        Border::Plain => {
            plain = PlainBorder::new(borders.surface, side);
            (&plain, x / side.edge_count() as f64)
        }
    };
    let lines = [Line { curve: border, sign: 1.0, start }, Line::new(&cuts[curve], track, near)];
    let t = nearest(&lines);
    let ends =
        [(BorderLine::Side(s as usize), lines[0].parameter(t[0])), (BorderLine::Cut(curve), lines[1].parameter(t[1]))];
    let (on_border, on_cut) = (lines[0].position(t[0]), lines[1].position(t[1]));
    let (gap, u, at) = (on_border.distance(on_cut), ends[1].1, on_border);
    let angle = angle(&lines, t).to_degrees();
    if angle < options.angle || angle.is_nan() {
        return Err(RemeshError::AlongBorder { curve, u, at, angle, limit: options.angle });
    }
    if gap > options.gap || gap.is_nan() {
        return Err(RemeshError::BorderGap { curve, u, at, gap, limit: options.gap });
    }
    // A straight side stays plain: it has no samples, so the cut gives the bits.
    let stays_plain = matches!(side.border, Border::Plain) && is_straight(borders.surface, side);
    let point = if stays_plain { on_cut } else { on_border };
    Ok(Some(Meeting { junction: Junction { point, ends, gap }, t }))
}

/// A curve in the direction of its travel.
struct Line<'a> {
    curve: &'a dyn Curve,
    sign: f64,
    /// The track's guess.
    start: f64,
}

impl<'a> Line<'a> {
    fn new(cut: &'a Cut, track: &Track, near: Near) -> Self {
        let sign = if cut.heading == Heading::Along { 1.0 } else { -1.0 };
        Self { curve: &*cut.curve, sign, start: track.parameter(near) }
    }

    /// The curve's own parameter.
    fn parameter(&self, t: f64) -> f64 {
        let u = self.sign * t;
        if self.curve.closed() { wrap(u) } else { u.clamp(0.0, 1.0) }
    }

    fn position(&self, t: f64) -> DVec3 {
        self.curve.position(self.parameter(t))
    }

    fn slope(&self, t: f64) -> DVec3 {
        self.curve.derivative(self.parameter(t)) * self.sign
    }
}

/// Steps of Gauss and Newton: they converge quadratically where the curves meet, and by the gap over
/// the radius of their bend where they pass.
const STEPS: u32 = 40;

/// Halvings of a step that leads away: to rounding of the parameter.
const HALVINGS: u32 = 50;

/// The pair of travel parameters near the lines' guesses at which they are nearest.
fn nearest(lines: &[Line<'_>; 2]) -> [f64; 2] {
    let mut t = [lines[0].start, lines[1].start];
    let off = |t: [f64; 2]| lines[0].position(t[0]) - lines[1].position(t[1]);
    let mut apart = off(t);
    for _ in 0..STEPS {
        let (a, b) = (lines[0].slope(t[0]), lines[1].slope(t[1]));
        let (aa, ab, bb) = (a.dot(a), a.dot(b), b.dot(b));
        let (fa, fb) = (apart.dot(a), apart.dot(b));
        let det = aa * bb - ab * ab;
        let step = [(ab * fb - bb * fa) / det, (aa * fb - ab * fa) / det];
        if !(step[0].is_finite() && step[1].is_finite()) {
            break;
        }
        let mut share = 1.0;
        let better = (0..HALVINGS).find_map(|_| {
            let next = [t[0] + share * step[0], t[1] + share * step[1]];
            share *= 0.5;
            let there = off(next);
            (there.length_squared() < apart.length_squared()).then_some((next, there))
        });
        let Some((next, there)) = better else { break };
        (t, apart) = (next, there);
    }
    t
}

/// The smallest angle between the curves there, in radians, whichever way they are walked and to
/// both sides of a corner; NaN where one has no direction.
fn angle(lines: &[Line<'_>; 2], t: [f64; 2]) -> f64 {
    let tangents = |i: usize| {
        let u = lines[i].parameter(t[i]);
        [Branch::Before, Branch::After].map(|branch| tangent(lines[i].curve, u, branch).unwrap_or(DVec3::NAN))
    };
    let (a, b) = (tangents(0), tangents(1));
    let pairs = a.iter().flat_map(|a| b.iter().map(|b| a.cross(*b).length().atan2(a.dot(*b).abs())));
    pairs.fold(f64::INFINITY, |least, angle| if angle.is_nan() { f64::NAN } else { least.min(angle) })
}

/// Curves that meet like `x^2` part by this share of the way from their contact; those that are as
/// near as rounding there run along each other.
const ROUNDING: f64 = 1e-10;

/// How far apart the lines are on both sides of a place where their directions agree, if that is
/// no more than rounding.
fn along_each_other(lines: &[Line<'_>; 2], t: [f64; 2], track: &Track, crossing: &Crossing) -> Option<f64> {
    let cut = track.points[crossing.at[0].segment as usize].cut;
    let length = track.tracks[cut as usize].length;
    // A hundredth of the curve to either side.
    let aside = [-0.01, 0.01].map(|share| {
        let x = lines[0].position(t[0] + share);
        let mut u = t[1] + share * same_way(lines, t);
        for _ in 0..STEPS {
            let (off, slope) = (x - lines[1].position(u), lines[1].slope(u));
            let step = off.dot(slope) / slope.length_squared();
            u += if step.is_finite() { step } else { 0.0 };
        }
        x.distance(lines[1].position(u))
    });
    let distance = aside[0].max(aside[1]);
    (distance <= ROUNDING * length).then_some(distance)
}

/// The second line's parameter by the first's where they run side by side.
fn same_way(lines: &[Line<'_>; 2], t: [f64; 2]) -> f64 {
    let (a, b) = (lines[0].slope(t[0]), lines[1].slope(t[1]));
    let rate = a.dot(b) / b.length_squared();
    if rate.is_finite() { rate } else { 1.0 }
}
