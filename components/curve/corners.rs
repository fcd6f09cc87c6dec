//! The corners of a black box, found from positions alone.

use std::cell::RefCell;

use glam::DVec3;

use super::guard::evaluate;
use super::{Curve, CurveError, angle, wrap};

/// The first windows are `2^-8` of the parameter wide: two corners that turn opposite ways, as a
/// notch has, are told apart if they are farther apart than that.
const COARSEST: u32 = 8;

/// How many intervals a curve is sampled over: the first windows.
pub(super) const SAMPLES: u32 = 1 << COARSEST;

/// From windows `2^-20` of the parameter wide on, what keeps turning is a corner: a rounding of a
/// corner that tight is far below any sampling of the curve.
const FINE: u32 = 20;

/// What has neither kept turning nor stopped by then, never will: windows of `2^-40` are a thousand
/// roundings wide.
const FINEST: u32 = 40;

/// A smooth curve turns half as much in half a window, a corner as much as before. Between them, a
/// corner that turns by `J` on a curve that turns by `b` in a window tells at `b < J / 2`.
const KEPT: f64 = 0.75;

/// How many windows are looked at before the curve is called rough. A smooth curve takes
/// `256 + 4 * (its whole turning / the angle of a corner)`, a corner about 50 more: a curve of 50
/// full turns and 200 corners stays below, at an angle of one degree.
const MOST_WINDOWS: u32 = 1 << 17;

/// How many times a corner's window is halved at most once it is found; 2^-64 is beyond any
/// distance between parameters.
const MOST_HALVINGS: u32 = 44;

/// A place where the tangent of a curve turns at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// The parameter, in [0, 1); on an open curve inside (0, 1).
    pub u: f64,
    /// By how much the tangent turns, in radians in (0, pi].
    pub turn: f64,
}

/// All corners of `curve` that turn by at least `turn` radians, ascending, from its positions
/// alone: what it declares is not looked at.
///
/// The parameter range is cut into windows, and a window is halved as long as the chords before,
/// in and after it turn by `turn` together. On a smooth curve the turning of a window falls with
/// its width, so that no curvature, however high, is taken for a corner; across a corner it stays.
/// A window that turns as much as one of twice its width, at 2^-20 or where rounding lets no
/// narrower one be judged, holds a corner. It is placed by halving on until the chords drown in
/// rounding: to about 1e-15 of the curve's coordinates over its speed. Curves evaluated in single
/// precision are recognised, and judged by its rounding.
///
/// Two corners are told apart if they are at least 2^-18 apart.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{CORNER_TURN, FnCurve, find_corners};
///
/// let roof = FnCurve::new(|u| DVec3::new(u, 0.3 - (u - 0.3).abs(), u * u));
/// let corners = find_corners(&roof, CORNER_TURN)?;
/// assert_eq!(corners.len(), 1);
/// assert!((corners[0].u - 0.3).abs() < 1e-14);
/// # Ok::<(), selvedge_components::curve::CurveError>(())
/// ```
///
/// # Errors
/// [`CurveError::NotFinite`] or [`CurveError::Panicked`]; [`CurveError::Rough`] for a curve that
/// turns by `turn` nearly everywhere, whatever the width.
pub fn find_corners(curve: &dyn Curve, turn: f64) -> Result<Vec<Corner>, CurveError> {
    let samples: Vec<DVec3> = (0..=SAMPLES).map(|k| evaluate(curve, parameter(k))).collect::<Result<_, _>>()?;
    find_corners_among(curve, &samples, turn)
}

/// As [`find_corners`], where the curve's points at all [`parameter`]s are known.
pub(super) fn find_corners_among(curve: &dyn Curve, samples: &[DVec3], turn: f64) -> Result<Vec<Corner>, CurveError> {
    let seen = RefCell::new([[Seen::NOTHING; 4]; LEVELS]);
    let mut search = Search { curve, samples, seen: &seen, closed: curve.closed(), turn, rounding: f64::EPSILON };
    search.rounding = search.precision()?;
    let groups = search.groups()?;
    let mut corners = Vec::with_capacity(groups.len());
    for group in groups {
        corners.push(search.placed(group)?);
    }
    corners.retain(|corner| corner.turn >= turn);
    corners.sort_by(|a, b| a.u.total_cmp(&b.u));
    Ok(corners)
}

/// The parameter of sample `k` of [`SAMPLES`].
pub(super) fn parameter(k: u32) -> f64 {
    f64::from(k) / f64::from(SAMPLES)
}

#[derive(Clone, Copy)]
struct Search<'a> {
    curve: &'a dyn Curve,
    /// Its points at all [`parameter`]s: the ends of the first windows.
    samples: &'a [DVec3],
    /// By level of windows, from the second on, the points looked at last.
    seen: &'a RefCell<[[Seen; 4]; LEVELS]>,
    closed: bool,
    turn: f64,
    /// The relative rounding of the curve's coordinates.
    rounding: f64,
}

/// A point of the curve at an odd multiple of the width of the windows of a level: neighbouring windows,
/// and those that halve them, ask for the same ones.
#[derive(Clone, Copy)]
struct Seen {
    i: i64,
    point: DVec3,
}

impl Seen {
    const NOTHING: Self = Self { i: i64::MIN, point: DVec3::NAN };
}

/// The levels of windows that are halves of others.
const LEVELS: usize = (FINEST - COARSEST) as usize;

/// A stretch of the parameter and how much the curve turns there. On a closed curve it may lie
/// beyond [0, 1].
#[derive(Clone, Copy, Debug)]
struct Window {
    from: f64,
    width: f64,
    angle: f64,
}

/// How much the chords of a window turn, and by how much rounding may have turned them.
#[derive(Clone, Copy, Debug)]
struct Turning {
    angle: f64,
    noise: f64,
}

impl Turning {
    /// Does it turn by `angle`, whatever rounding did?
    fn is_at_least(&self, angle: f64) -> bool {
        self.angle - self.noise >= angle
    }
}

/// A window yet to be looked at: `i` of `2^level`.
#[derive(Clone, Copy, Debug)]
struct Open {
    level: u32,
    i: u64,
    /// How much the window that it is half of turns, if it could be judged.
    parent: Option<f64>,
    /// Did that one turn as much as its own parent?
    is_kept: bool,
}

impl Search<'_> {
    /// Single precision if every coordinate of some points at long binary fractions has it.
    fn precision(&self) -> Result<f64, CurveError> {
        let is_single = |x: f64| f64::from(x as f32) == x;
        for k in 0..8 {
            let p = self.at((f64::from(k) + 0.381_966_011_250_105) / 8.0)?;
            if !p.to_array().into_iter().all(is_single) {
                return Ok(f64::EPSILON);
            }
        }
        Ok(f64::from(f32::EPSILON))
    }

    /// Windows that hold a corner, those that touch merged into the one that turns most.
    fn groups(&self) -> Result<Vec<Window>, CurveError> {
        let mut groups: Vec<(Window, f64)> = Vec::new();
        self.survivors(&mut |window| match groups.last_mut() {
            // A corner reaches into the chords of the windows on either side of its own, and rounding
            // may hide one between them.
            Some((best, end)) if window.from <= *end + 2.0 * window.width.max(best.width) => {
                *end = window.from + window.width;
                if window.angle > best.angle {
                    *best = window;
                }
            }
            _ => groups.push((window, window.from + window.width)),
        })?;
        // The last window of a closed curve is next to the first.
        if let (true, [(first, _), .., (last, end)]) = (self.closed, &mut groups[..])
            && 1.0 + first.from <= *end + 2.0 * first.width.max(last.width)
        {
            if last.angle > first.angle {
                *first = *last;
            }
            groups.pop();
        }
        Ok(groups.into_iter().map(|(window, _)| window).collect())
    }

    /// Calls `found` for every window that keeps turning, from left to right.
    fn survivors(&self, found: &mut impl FnMut(Window)) -> Result<(), CurveError> {
        let mut looked_at = 0;
        let first = (0..1 << COARSEST).rev();
        let mut open: Vec<_> = first.map(|i| Open { level: COARSEST, i, parent: None, is_kept: false }).collect();
        while let Some(Open { level, i, parent, is_kept }) = open.pop() {
            let width = ((1_u64 << level) as f64).recip();
            let from = i as f64 * width;
            looked_at += 1;
            if looked_at > MOST_WINDOWS {
                return Err(CurveError::Rough { u: from, windows: MOST_WINDOWS, turn: self.turn });
            }
            let (angle, keeps) = match self.window_turning(level, i as i64)? {
                None => (None, false),
                Some(t) if t.is_at_least(self.turn) => {
                    (Some(t.angle), parent.is_some_and(|angle| t.angle >= KEPT * angle))
                }
                Some(t) => {
                    // Where rounding could hide it, what kept turning so far does so here.
                    if let (true, Some(angle)) = (is_kept, parent)
                        && t.angle + t.noise >= KEPT * angle
                    {
                        found(Window { from, width, angle });
                    }
                    continue;
                }
            };
            match angle {
                Some(angle) if level >= FINE && keeps => found(Window { from, width, angle }),
                _ if level < FINEST => {
                    let half = |i| Open { level: level + 1, i, parent: angle, is_kept: keeps };
                    open.extend([half(2 * i + 1), half(2 * i)]);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// The corner in `window`, placed as well as rounding lets it be.
    fn placed(&self, window: Window) -> Result<Corner, CurveError> {
        let mut best = window;
        // Chords that turn by half of the corner still tell where it is.
        let resolution = best.angle / 2.0;
        for _ in 0..MOST_HALVINGS {
            let mut narrower: Option<Window> = None;
            // Five windows of half the width, which overlap and reach beyond on both sides, so that
            // a wrong choice (curvature, rounding) is mended by the next; the middle one first.
            for quarter in [1.0, 0.0, 2.0, -1.0, 3.0] {
                let (from, width) = (best.from + 0.25 * quarter * best.width, 0.5 * best.width);
                if let Some(turning) = self.turning(from, width, resolution)?
                    && turning.is_at_least(narrower.map_or(resolution, |w| w.angle + turning.noise))
                {
                    narrower = Some(Window { from, width, angle: turning.angle });
                }
            }
            match narrower {
                Some(window) if window.from + window.width > window.from => best = window,
                _ => break,
            }
        }
        let u = self.sharpest(best)?;
        // Measured as widely as it was found, where the chords are long against rounding.
        let turn = self.chords_at(u, window.width)?;
        Ok(Corner { u: if self.closed { wrap(u) } else { u }, turn })
    }

    /// The best of the ends and the middle of a narrow window: where the chords on either side turn
    /// most. A corner at a short binary fraction is met exactly.
    fn sharpest(&self, window: Window) -> Result<f64, CurveError> {
        let (mut best, mut most) = (window.from + 0.5 * window.width, 0.0);
        for u in [best, window.from, window.from + window.width] {
            let turn = self.chords_at(u, window.width)?;
            if turn > most {
                (best, most) = (u, turn);
            }
        }
        Ok(best)
    }

    /// By how much the chords of a width before and after `u` turn.
    fn chords_at(&self, u: f64, width: f64) -> Result<f64, CurveError> {
        let [before, at, after] = [self.at(u - width)?, self.at(u)?, self.at(u + width)?];
        Ok(angle::between(at - before, after - at))
    }

    /// How much the three chords before, in and after the window turn; `None` where one of them
    /// would reach over the end of an open curve. The chord inside is left out if rounding might
    /// turn it by an eighth of `wanted`: a curve may come back to where it was.
    fn turning(&self, from: f64, width: f64, wanted: f64) -> Result<Option<Turning>, CurveError> {
        let (start, end) = (from - width, from + 2.0 * width);
        if !self.closed && (start < 0.0 || end > 1.0) {
            return Ok(None);
        }
        let points = [self.at(start)?, self.at(from)?, self.at(from + width)?, self.at(end)?];
        Ok(Some(self.turning_of(points, wanted)))
    }

    /// As [`Self::turning`], of window `i` of `2^level`.
    fn window_turning(&self, level: u32, i: i64) -> Result<Option<Turning>, CurveError> {
        if !self.closed && (i < 1 || i + 2 > 1 << level) {
            return Ok(None);
        }
        let at = |i: i64| self.at_multiple(level, i);
        Ok(Some(self.turning_of([at(i - 1)?, at(i)?, at(i + 1)?, at(i + 2)?], self.turn)))
    }

    /// The point at `i / 2^level`.
    fn at_multiple(&self, mut level: u32, mut i: i64) -> Result<DVec3, CurveError> {
        while level > COARSEST && i % 2 == 0 {
            (level, i) = (level - 1, i / 2);
        }
        let u = i as f64 / (1_u64 << level) as f64;
        if level == COARSEST {
            return self.at(u);
        }
        // Four in a row fall on different places.
        let (row, place) = ((level - COARSEST - 1) as usize, (i >> 1).rem_euclid(4) as usize);
        let seen = self.seen.borrow()[row][place];
        if seen.i == i {
            return Ok(seen.point);
        }
        let point = self.at(u)?;
        self.seen.borrow_mut()[row][place] = Seen { i, point };
        Ok(point)
    }

    fn turning_of(&self, [a, b, c, d]: [DVec3; 4], wanted: f64) -> Turning {
        let [before, inside, after] = [b - a, c - b, d - c];
        // A chord between points that are each off by a rounding turns by twice that over its length.
        let rounding = 2.0 * self.rounding * a.length().max(d.length());
        let noise = rounding / before.length() + rounding / after.length();
        let inner = 2.0 * rounding / inside.length();
        let turning = if inner <= wanted / 8.0 {
            let angle = angle::between(before, inside) + angle::between(inside, after);
            Turning { angle, noise: noise + inner }
        } else {
            Turning { angle: angle::between(before, after), noise }
        };
        // At the origin of coordinates rounding and chords vanish together.
        let noise = if turning.noise.is_nan() { f64::INFINITY } else { turning.noise };
        Turning { noise, ..turning }
    }

    fn at(&self, u: f64) -> Result<DVec3, CurveError> {
        let inside = if self.closed { wrap(u) } else { u.clamp(0.0, 1.0) };
        let sample = inside * f64::from(SAMPLES);
        if sample.fract() == 0.0
            && let Some(&known) = self.samples.get(sample as usize)
        {
            return Ok(known);
        }
        evaluate(self.curve, inside)
    }
}

#[cfg(test)]
#[path = "corners_tests.rs"]
mod tests;
