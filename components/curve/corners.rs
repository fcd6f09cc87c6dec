//! The corners of a black box, found from positions alone.

use glam::DVec3;

use super::guard::evaluate;
use super::{Curve, CurveError, angle, wrap};

/// The first windows are `2^-8` of the parameter wide: two corners that turn opposite ways, as a
/// notch has, are told apart if they are farther apart than that.
const COARSEST: u32 = 8;

/// The last windows of the search are `2^-20` of the parameter wide. What still turns there is a
/// corner: a rounding of a corner that tight is far below any sampling of the curve.
const FINEST: u32 = 20;

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
/// A window that still turns at a width of 2^-20 holds a corner, which is then placed by halving
/// on until the chords drown in rounding: to about 1e-15 of the curve's coordinates over its speed.
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
    let search = Search { curve, closed: curve.closed(), turn };
    let groups = search.groups()?;
    let mut corners = Vec::with_capacity(groups.len());
    for group in groups {
        corners.push(search.placed(group)?);
    }
    corners.sort_by(|a, b| a.u.total_cmp(&b.u));
    Ok(corners)
}

#[derive(Clone, Copy)]
struct Search<'a> {
    curve: &'a dyn Curve,
    closed: bool,
    turn: f64,
}

/// A stretch of the parameter and how much the curve turns there. On a closed curve it may lie
/// beyond [0, 1].
#[derive(Clone, Copy, Debug)]
struct Window {
    from: f64,
    width: f64,
    turning: f64,
}

impl Window {
    fn end(&self) -> f64 {
        self.from + self.width
    }
}

/// What the chords around a window say.
enum Turning {
    /// They turn by this angle.
    By(f64),
    /// A chord reaches over the end of an open curve: narrower windows must tell.
    OverTheEnd,
    /// The curve moves by no more than rounding: nothing can be told, here or in narrower windows.
    Still,
}

impl Search<'_> {
    /// Windows that turn at the finest width, those that touch merged into the one that turns most.
    fn groups(&self) -> Result<Vec<Window>, CurveError> {
        let mut groups: Vec<(Window, f64)> = Vec::new();
        self.survivors(&mut |window| match groups.last_mut() {
            // A corner reaches into the chords of the windows on either side of its own.
            Some((best, end)) if window.from <= *end + window.width => {
                *end = window.end();
                if window.turning > best.turning {
                    *best = window;
                }
            }
            _ => groups.push((window, window.end())),
        })?;
        // The last window of a closed curve is next to the first.
        if let (true, [(first, _), .., (last, end)]) = (self.closed, &mut groups[..])
            && *end + first.width >= 1.0 + first.from
        {
            if last.turning > first.turning {
                *first = *last;
            }
            groups.pop();
        }
        Ok(groups.into_iter().map(|(window, _)| window).collect())
    }

    /// Calls `found` for every window that turns at the finest width, from left to right.
    fn survivors(&self, found: &mut impl FnMut(Window)) -> Result<(), CurveError> {
        let mut looked_at = 0;
        let mut open: Vec<(u32, u32, f64)> = (0..1 << COARSEST).rev().map(|i| (COARSEST, i, 0.0)).collect();
        while let Some((level, i, parent)) = open.pop() {
            let width = f64::from(1_u32 << level).recip();
            let from = f64::from(i) * width;
            looked_at += 1;
            if looked_at > MOST_WINDOWS {
                return Err(CurveError::Rough { u: from, windows: MOST_WINDOWS, turn: self.turn });
            }
            let split = match self.turning(from, width, self.turn)? {
                Turning::By(by) if by < self.turn => continue,
                Turning::By(by) => by,
                Turning::OverTheEnd => parent,
                // As far as rounding lets us see, what turned in the wider window turns here.
                Turning::Still if parent > 0.0 => {
                    found(Window { from, width, turning: parent });
                    continue;
                }
                Turning::Still => continue,
            };
            if level < FINEST {
                open.push((level + 1, 2 * i + 1, split));
                open.push((level + 1, 2 * i, split));
            } else if split > 0.0 {
                found(Window { from, width, turning: split });
            }
        }
        Ok(())
    }

    /// The corner in `window`, placed as well as rounding lets it be.
    fn placed(&self, window: Window) -> Result<Corner, CurveError> {
        let mut best = window;
        // Chords that turn by half of the corner still tell where it is.
        let resolution = best.turning / 2.0;
        for _ in 0..MOST_HALVINGS {
            let mut narrower: Option<Window> = None;
            // Five windows of half the width, which overlap and reach beyond on both sides, so that
            // a wrong choice (curvature, rounding) is mended by the next; the middle one first.
            for quarter in [1.0, 0.0, 2.0, -1.0, 3.0] {
                let (from, width) = (best.from + 0.25 * quarter * best.width, 0.5 * best.width);
                if let Turning::By(turning) = self.turning(from, width, resolution)?
                    && narrower.is_none_or(|w| turning > w.turning)
                {
                    narrower = Some(Window { from, width, turning });
                }
            }
            match narrower {
                Some(window) if window.turning >= resolution && window.from + window.width > window.from => {
                    best = window
                }
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
        for u in [best, window.from, window.end()] {
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

    /// How much the three chords before, in and after the window turn, if rounding turns them by
    /// less than an eighth of `wanted`.
    fn turning(&self, from: f64, width: f64, wanted: f64) -> Result<Turning, CurveError> {
        let (start, end) = (from - width, from + 2.0 * width);
        if !self.closed && (start < 0.0 || end > 1.0) {
            return Ok(Turning::OverTheEnd);
        }
        let [a, b, c, d] = [self.at(start)?, self.at(from)?, self.at(from + width)?, self.at(end)?];
        // A chord of length l between points that are off by eps |p| each is off by 2 eps |p| / l.
        let size = a.length().max(d.length());
        let shortest = 8.0 * 2.0 * f64::EPSILON * size / wanted;
        let [before, inside, after] = [b - a, c - b, d - c];
        if before.length() <= shortest || after.length() <= shortest {
            return Ok(Turning::Still);
        }
        Ok(Turning::By(if inside.length() <= shortest {
            angle::between(before, after)
        } else {
            angle::between(before, inside) + angle::between(inside, after)
        }))
    }

    fn at(&self, u: f64) -> Result<DVec3, CurveError> {
        let inside = if self.closed { wrap(u) } else { u.clamp(0.0, 1.0) };
        evaluate(self.curve, inside)
    }
}

#[cfg(test)]
#[path = "corners_tests.rs"]
mod tests;
