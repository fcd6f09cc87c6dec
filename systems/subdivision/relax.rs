//! # Relax: the new vertices settle along the curve
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the strip, the rim's limit points, the curve | the parameters of the smooth knots | remesh | correspond |
//!
//! Each smooth knot moves towards the tip of an isosceles triangle over its rim edge `q r`:
//! `((q + r) / 2 - c(u)) . (q - r) = 0` [Litke et al. 2001, Section 3.1]. Where the rim turns inwards
//! the perpendiculars of neighbours cross, and knots that followed them would lose their order; so a
//! knot keeps to the middle part of the way between its neighbours.

use glam::DVec3;
use selvedge_components::curve::Curve;
use selvedge_components::curve::Heading;
pub use selvedge_components::trim::Relaxed;

/// How the relaxation is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelaxOptions {
    /// The part of the way to the solution that a knot goes in a sweep, in (0, 1].
    pub step: f64,
    /// How many sweeps; the parameters converge within a few.
    pub sweeps: u32,
    /// The middle part between its neighbours that a knot keeps to, in (0, 1).
    pub middle: f64,
}

impl Default for RelaxOptions {
    fn default() -> Self {
        Self { step: 0.5, sweeps: 20, middle: 0.4 }
    }
}

/// A knot to be relaxed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slider {
    /// The travel parameter; rises from knot to knot.
    pub t: f64,
    /// The ends of its rim edge; `None` for a corner, which stays.
    pub base: Option<[DVec3; 2]>,
    /// The length of the rim that it sees.
    pub width: f64,
}

/// The curve's parameter of travel parameter `t`: on a closed curve in [0, 1).
pub fn curve_parameter(curve: &dyn Curve, heading: Heading, t: f64) -> f64 {
    let u = if heading == Heading::Along { t } else { -t };
    if !curve.closed() {
        return u.clamp(0.0, 1.0);
    }
    let inside = u - u.floor();
    // Rounding may bring it to one, which is zero.
    if inside >= 1.0 { 0.0 } else { inside }
}

/// The knots of one strip while they are relaxed. The last knot of a closed strip is followed by the
/// first, one later.
#[derive(Clone, Debug)]
pub struct Strung {
    knots: Vec<Slider>,
    /// By knot, the least gap to its neighbours.
    gaps: Vec<f64>,
    /// By knot, its isosceles place, once that has been found: it does not depend on the neighbours, which
    /// only say how near to it the knot may come.
    tips: Vec<Option<f64>>,
    options: RelaxOptions,
}

impl Strung {
    /// Knots to be relaxed.
    pub fn new(knots: Vec<Slider>, options: RelaxOptions) -> Self {
        let gaps = least_gaps(&knots, options);
        let tips = vec![None; knots.len()];
        Self { knots, gaps, tips, options }
    }

    /// The knots as they stand.
    pub fn knots(&self) -> &[Slider] {
        &self.knots
    }

    /// The knots, for their parameters to be set otherwise.
    pub(super) fn knots_mut(&mut self) -> &mut [Slider] {
        &mut self.knots
    }

    /// Moves every smooth knot once, by where its neighbours stood before.
    pub fn sweep(&mut self, curve: &dyn Curve, heading: Heading) {
        let n = self.knots.len();
        let old: Vec<f64> = self.knots.iter().map(|k| k.t).collect();
        for i in 0..n {
            let Some(base) = self.knots[i].base else { continue };
            let before = old[(i + n - 1) % n] - if i == 0 { 1.0 } else { 0.0 };
            let after = old[(i + 1) % n] + if i + 1 == n { 1.0 } else { 0.0 };
            let edge = 0.5 * (1.0 - self.options.middle) * (after - before);
            // The middle part, less what lies nearer to a neighbour than the least gap.
            let edge = edge.max(self.gaps[i].min(0.5 * (after - before)));
            let (low, high) = (before + edge, after - edge);
            if low > high || low.is_nan() || high.is_nan() {
                // Its neighbours have lost their order, which no list of parameters will take.
                continue;
            }
            let tip = self.tips[i].unwrap_or_else(|| {
                let (t, arrived) = isosceles(curve, heading, old[i], base, [before, after]);
                self.tips[i] = arrived.then_some(t);
                t
            });
            self.knots[i].t = (1.0 - self.options.step) * old[i] + self.options.step * tip.clamp(low, high);
        }
    }

    /// How far the knots are from their isosceles places: see [`Relaxed::residual`].
    pub fn residual(&self, curve: &dyn Curve, heading: Heading) -> f64 {
        let off = self.knots.iter().filter_map(|k| {
            let [q, r] = k.base?;
            let p = curve.position(curve_parameter(curve, heading, k.t));
            Some((0.5 * (q + r) - p).dot(q - r).abs() / (q - r).length_squared())
        });
        off.fold(0.0, f64::max)
    }
}

/// Newton steps in a sweep: the next sweep goes on where this one stops.
const NEWTON: u32 = 3;

/// A Newton step shorter than this part of the way between the neighbours has come to the tip: the one after
/// it would be as short as its square.
const ARRIVED: f64 = 1e-4;

/// Steps from `t` towards the tip of an isosceles triangle over `q r`, between `low` and `high`. Tells
/// whether that is where they have come to.
fn isosceles(
    curve: &dyn Curve,
    heading: Heading,
    mut t: f64,
    [q, r]: [DVec3; 2],
    [low, high]: [f64; 2],
) -> (f64, bool) {
    let sign = if heading == Heading::Along { 1.0 } else { -1.0 };
    for _ in 0..NEWTON {
        let u = curve_parameter(curve, heading, t);
        let f = (0.5 * (q + r) - curve.position(u)).dot(q - r);
        let df = -sign * curve.derivative(u).dot(q - r);
        // A curve that runs across the rim edge has no isosceles place nearby.
        let next = if df != 0.0 { t - f / df } else { f64::NAN };
        let before = t;
        t = if next.is_finite() { next.clamp(low, high) } else { t.clamp(low, high) };
        if t == next && (t - before).abs() <= ARRIVED * (high - low) {
            return (t, true);
        }
        if t == before {
            break;
        }
    }
    (t, false)
}

/// By knot, the least gap to its neighbours: a part of the gap that suits the rim beside it, for all
/// of them to fill the way between the two corners. A rim that bends round a corner would draw one
/// knot after the other into it.
fn least_gaps(knots: &[Slider], options: RelaxOptions) -> Vec<f64> {
    let n = knots.len();
    let fixed: Vec<usize> = (0..n).filter(|&i| knots[i].base.is_none()).collect();
    let share = 0.5 * (1.0 - options.middle);
    let gap = |i: usize| 0.5 * (knots[i % n].width + knots[(i + 1) % n].width);
    // The way to fill, from knot to knot; all round where no corner divides it.
    let ways: Vec<(usize, usize, f64)> = match fixed.as_slice() {
        [] => vec![(0, n, 1.0)],
        fixed => (0..fixed.len())
            .map(|k| {
                let (from, to) = (fixed[k], fixed[(k + 1) % fixed.len()]);
                let round = k + 1 == fixed.len();
                let count = if round { to + n - from } else { to - from };
                (from, count, knots[to].t - knots[from].t + if round { 1.0 } else { 0.0 })
            })
            .collect(),
    };
    let mut gaps = vec![0.0; n];
    for (from, count, way) in ways {
        let total: f64 = (from..from + count).map(gap).sum();
        for i in from..from + count {
            let own = gap(i).min(gap(i + n - 1));
            gaps[i % n] = if total > 0.0 { share * way * own / total } else { share * way / count as f64 };
        }
    }
    gaps
}

/// `2 area / longest edge^2` of a triangle: 0 for a degenerate one, 0.87 for an equilateral one.
pub fn shape([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}
