//! B-splines and rational B-splines of any degree.

use glam::DVec3;

use super::net::{Jet, LastStep, MAX_DEGREE, Net};
use super::{Branch, CORNER_TURN, Curve, Extent, ShapeError, canonical, turn};

/// A B-spline curve, polynomial or rational, over clamped, unclamped or periodic knots.
///
/// The knots are scaled so that the domain, from knot `degree` to knot `n` for `n` control points,
/// is [0, 1]. Evaluated by de Boor's algorithm [de Boor 1972]. Inside, a knot may be repeated up
/// to `degree` times; where it is, the curve has a corner if its tangent turns there by
/// [`CORNER_TURN`] or more (the double knots of a circle in quarters are none). A curve whose
/// ends are the same point to the bit is closed.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{BSpline, Curve};
///
/// let points = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
/// let one_piece = BSpline::new(3, vec![0.0, 0.0, 0.0, 0.0, 2.0, 2.0, 2.0, 2.0], points.clone())?;
/// assert_eq!(one_piece.position(0.5), DVec3::new(0.75, 0.5, 0.0));
///
/// let ring = BSpline::uniform_periodic(3, points)?;
/// assert!(ring.closed());
/// # Ok::<(), selvedge_components::curve::ShapeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BSpline {
    degree: usize,
    /// Scaled: knot `degree` is 0 and knot `n` is 1, exactly.
    knots: Vec<f64>,
    net: Net,
    /// How many control points the caller gave; a periodic curve repeats its first ones.
    given: usize,
    extent: Extent,
    corners: Vec<f64>,
}

impl BSpline {
    /// The curve of `n` control points over `n + degree + 1` knots.
    ///
    /// # Errors
    /// [`ShapeError::Degree`] outside 1 to [`MAX_DEGREE`]; [`ShapeError::TooFew`] control points
    /// (at least `degree + 1`); [`ShapeError::WrongCount`] of knots; [`ShapeError::KnotOrder`],
    /// also where the domain has no length; [`ShapeError::KnotMultiplicity`];
    /// [`ShapeError::PointNotFinite`].
    pub fn new(degree: usize, knots: Vec<f64>, points: Vec<DVec3>) -> Result<Self, ShapeError> {
        checked_degree(degree)?;
        let n = points.len();
        at_least("control points", n, degree + 1)?;
        if knots.len() != n + degree + 1 {
            return Err(ShapeError::WrongCount { what: "knots", count: knots.len(), needed: n + degree + 1 });
        }
        let knots = scaled(&knots, degree, n)?;
        checked_multiplicity(&knots, degree, degree + 1)?;
        Ok(Self { degree, knots, net: Net::plain(points)?, given: n, extent: Extent::Open, corners: Vec::new() }
            .finish())
    }

    /// The curve that meets the first and the last of the control points, over equally spaced knots.
    ///
    /// # Errors
    /// As [`BSpline::new`].
    pub fn clamped(degree: usize, points: Vec<DVec3>) -> Result<Self, ShapeError> {
        checked_degree(degree)?;
        at_least("control points", points.len(), degree + 1)?;
        let spans = points.len() - degree;
        let knots = (0..points.len() + degree + 1).map(|i| i.saturating_sub(degree).min(spans) as f64);
        Self::new(degree, knots.collect(), points)
    }

    /// The closed curve of `n >= 3` control points over the `n + 1` knots of one period; span `i`
    /// is shaped by the control points `i` to `i + degree`, counted round.
    ///
    /// # Errors
    /// As [`BSpline::new`]; a knot may be repeated up to `degree` times, those at both ends
    /// counted together.
    pub fn periodic(degree: usize, period: Vec<f64>, points: Vec<DVec3>) -> Result<Self, ShapeError> {
        checked_degree(degree)?;
        let n = points.len();
        at_least("control points", n, 3)?;
        if period.len() != n + 1 {
            return Err(ShapeError::WrongCount { what: "knots of a period", count: period.len(), needed: n + 1 });
        }
        let period = scaled(&period, 0, n)?;
        let around = |k: isize| {
            let (turn, i) = (k.div_euclid(n as isize), k.rem_euclid(n as isize));
            period[i as usize] + turn as f64
        };
        let knots: Vec<_> = (-(degree as isize)..=(n + degree) as isize).map(around).collect();
        checked_multiplicity(&knots, degree, degree)?;
        let wrapped = (0..n + degree).map(|i| points[i % n]).collect();
        let net = Net::plain(wrapped)?;
        Ok(Self { degree, knots, net, given: n, extent: Extent::Closed, corners: Vec::new() }.finish())
    }

    /// The closed curve over equally spaced knots.
    ///
    /// # Errors
    /// As [`BSpline::periodic`].
    pub fn uniform_periodic(degree: usize, points: Vec<DVec3>) -> Result<Self, ShapeError> {
        let period = (0..=points.len()).map(|i| i as f64).collect();
        Self::periodic(degree, period, points)
    }

    /// The rational curve of the same knots and control points, and one weight for each point given.
    ///
    /// # Errors
    /// [`ShapeError::WrongCount`] or [`ShapeError::Weight`].
    pub fn with_weights(self, weights: &[f64]) -> Result<Self, ShapeError> {
        if weights.len() != self.given {
            return Err(ShapeError::WrongCount { what: "weights", count: weights.len(), needed: self.given });
        }
        let wrapped: Vec<_> = (0..self.net.len()).map(|i| weights[i % self.given]).collect();
        Ok(Self { net: self.net.with_weights(&wrapped)?, ..self }.finish())
    }

    /// The degree, at least 1.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The knots, scaled: those of the domain run from 0 to 1.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// Finds out whether the ends meet, and the corners.
    fn finish(mut self) -> Self {
        let ends = [0.0, 1.0].map(|u| self.jet(u, Branch::After).position);
        if ends[0] == ends[1] {
            self.extent = Extent::Closed;
        }
        self.corners = Vec::new();
        let inside = self.knots.chunk_by(|a, b| a == b).filter(|run| run[0] > 0.0 && run[0] < 1.0);
        let mut candidates: Vec<_> = inside.filter(|run| run.len() >= self.degree).map(|run| run[0]).collect();
        if self.extent == Extent::Closed {
            candidates.insert(0, 0.0);
        }
        // The sides of a candidate must be told apart while it is tested: corners are still empty,
        // and both derivatives come from the spans themselves.
        candidates.retain(|&u| turn(&self, u).is_some_and(|by| by >= CORNER_TURN));
        self.corners = candidates;
        self
    }

    /// The span that `u` in [0, 1] lies in; at a knot, the one on the given side.
    fn span(&self, u: f64, branch: Branch) -> usize {
        let past_equal = match branch {
            Branch::After => u < 1.0,
            Branch::Before => u <= 0.0,
        };
        let knots = self.knots.partition_point(|&k| if past_equal { k <= u } else { k < u });
        knots.saturating_sub(1).clamp(self.degree, self.net.len() - 1)
    }

    fn jet(&self, u: f64, branch: Branch) -> Jet {
        let (p, s, k) = (self.degree, self.span(u, branch), &self.knots);
        let first = s - p;
        let share = |step: usize, i: usize| {
            let j = first + step + i;
            (u - k[j]) / (k[j + p + 1 - step] - k[j])
        };
        let width = k[s + 1] - k[s];
        let last = LastStep { share: (u - k[s]) / width, speed: p as f64 / width };
        self.net.evaluate(first, p + 1, share, last)
    }
}

fn checked_degree(degree: usize) -> Result<(), ShapeError> {
    let fits = (1..=MAX_DEGREE).contains(&degree);
    fits.then_some(()).ok_or(ShapeError::Degree { degree, limit: MAX_DEGREE })
}

fn at_least(what: &'static str, count: usize, needed: usize) -> Result<(), ShapeError> {
    if count < needed { Err(ShapeError::TooFew { what, count, needed }) } else { Ok(()) }
}

/// The knots scaled so that knot `first` is 0 and knot `last` is 1. Equal knots stay equal.
fn scaled(knots: &[f64], first: usize, last: usize) -> Result<Vec<f64>, ShapeError> {
    let is_wrong = |i: usize| !knots[i].is_finite() || (i > 0 && knots[i] < knots[i - 1]);
    if let Some(index) = (0..knots.len()).find(|&i| is_wrong(i)) {
        let before = if index > 0 { knots[index - 1] } else { f64::NEG_INFINITY };
        return Err(ShapeError::KnotOrder { index, knot: knots[index], before });
    }
    let (start, width) = (knots[first], knots[last] - knots[first]);
    let scaled: Vec<_> = knots.iter().map(|k| (k - start) / width).collect();
    if !(width > 0.0 && scaled.iter().all(|k| k.is_finite())) {
        return Err(ShapeError::KnotOrder { index: last, knot: knots[last], before: start });
    }
    Ok(scaled)
}

/// Inside (0, 1) no knot may be repeated more than `degree` times, at its ends `ends` times.
fn checked_multiplicity(knots: &[f64], degree: usize, ends: usize) -> Result<(), ShapeError> {
    let mut index = 0;
    for run in knots.chunk_by(|a, b| a == b) {
        let u = run[0];
        let most = if u > 0.0 && u < 1.0 { degree } else { ends };
        if (0.0..=1.0).contains(&u) && run.len() > most {
            return Err(ShapeError::KnotMultiplicity { index, u, multiplicity: run.len(), degree: most });
        }
        index += run.len();
    }
    Ok(())
}

impl Curve for BSpline {
    fn position(&self, u: f64) -> DVec3 {
        self.jet(canonical(u, self.extent), Branch::After).position
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.jet(canonical(u, Extent::Open), Branch::After).derivative
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        let end = u <= 0.0 && self.closed();
        self.jet(if end { 1.0 } else { canonical(u, Extent::Open) }, Branch::Before).derivative
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        self.extent == Extent::Closed
    }
}

#[cfg(test)]
#[path = "bspline_tests.rs"]
mod tests;
