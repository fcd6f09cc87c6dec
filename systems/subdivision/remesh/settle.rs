//! # Settle: knots leave the places where the strip would be thin
//!
//! ```text
//!    q ------ r           q           Where the cage changes its level along a curve, the rim steps
//!     \      /            |  p'       towards the curve or away from it. Seen from a rim edge `q r`
//!      \    /             r /         that points at the curve the tip of an isosceles triangle lies
//!   .... p ....   but  ...p.....      on the line of that edge, and has no area: `p` is to go to the
//!                                     right of it, as far as its neighbours like.
//! ```
//!
//! Relaxation looks at rim edges only. Here the knots of thin triangles are moved to where the worst
//! of all triangles around them is best, folded ones being worse than flat ones. A move changes no
//! other triangle, so the worst of a strip never becomes worse; where none is thin nothing moves.

use core::ops::Range;

use glam::DVec3;
use selvedge_components::curve::{Curve, Heading};

use super::super::relax::{Slider, curve_parameter};
use super::attach::Strip;

/// A knot moves if a triangle around it has a lower shape: an angle of some six degrees at one end of
/// the longest edge. Above it relaxation's own places are better, for they are spaced evenly.
pub(super) const THIN: f64 = 0.1;

/// Below this shape a knot that finds no better place asks its neighbours for room.
const FOLDED: f64 = 0.02;

/// How often neighbours are asked for room along a strip: each time costs some hundred times what a move of
/// one knot does. A strip that needs more is too coarse.
const ROOMS: u32 = 64;

/// Sweeps over the thin places: a knot may have to wait for a neighbour that is in its way.
const SWEEPS: u32 = 8;

/// Places looked at between two neighbours, and again between the two around the best.
pub(super) const LOOKS: u32 = 16;

/// The part of the way between its neighbours that a knot keeps from either. A border vertex lies at
/// the mean `((a + c) + 4 b) / 6` of the parameters, so an uneven knot is off its place by a sixth of what
/// the gaps differ by: here by no more than a third of the smaller one.
const ASIDE: f64 = 0.25;

/// A strip with the places of its rim, whose knots slide along a curve.
pub(super) struct Settling<'a> {
    /// The strip.
    pub strip: &'a Strip,
    /// The rim's limit points and the unit normals there.
    pub rim: Vec<(DVec3, DVec3)>,
    /// The curve.
    pub curve: &'a dyn Curve,
    /// Which way it is walked.
    pub heading: Heading,
}

impl Settling<'_> {
    /// Moves the knots of thin triangles.
    pub fn settle(&self, knots: &mut [Slider]) {
        let mut at: Vec<DVec3> = knots.iter().map(|k| self.position(k.t)).collect();
        let mut left = ROOMS;
        for _ in 0..SWEEPS {
            let mut moved = false;
            for i in (0..knots.len()).filter(|&i| knots[i].base.is_some()).collect::<Vec<_>>() {
                let own = self.worst_around(i, &at);
                if own >= THIN {
                    continue;
                }
                let found = self.best(i, knots, &mut at).filter(|(_, shape)| *shape > own);
                if let Some((t, _)) = found {
                    knots[i].t = t;
                    moved = true;
                }
                at[i] = self.position(knots[i].t);
                if found.map_or(own, |(_, shape)| shape) < FOLDED && left > 0 {
                    left -= 1;
                    moved |= self.make_room(i, knots, &mut at);
                }
            }
            if !moved {
                return;
            }
        }
    }

    /// By knot, the worst shape of the triangles that begin with it; below zero where one is folded.
    pub fn shapes(&self, knots: &[Slider]) -> Vec<f64> {
        let at: Vec<DVec3> = knots.iter().map(|k| self.position(k.t)).collect();
        (0..at.len()).map(|i| self.worst(i, &at)).collect()
    }

    /// By knot, the least shape of the triangles that begin with it, whichever way they face.
    pub fn flattest(&self, knots: &[Slider]) -> Vec<f64> {
        let at: Vec<DVec3> = knots.iter().map(|k| self.position(k.t)).collect();
        (0..at.len()).map(|i| self.begun(i, &at).map(f64::abs).fold(f64::INFINITY, f64::min)).collect()
    }

    pub(super) fn position(&self, t: f64) -> DVec3 {
        self.curve.position(curve_parameter(self.curve, self.heading, t))
    }

    /// The best place of knot `i` between its neighbours, and the worst shape there.
    fn best(&self, i: usize, knots: &[Slider], at: &mut [DVec3]) -> Option<(f64, f64)> {
        let n = knots.len();
        let before = knots[(i + n - 1) % n].t - if i == 0 { 1.0 } else { 0.0 };
        let after = knots[(i + 1) % n].t + if i + 1 == n { 1.0 } else { 0.0 };
        let aside = ASIDE * (after - before);
        let (mut low, mut high) = (before + aside, after - aside);
        // The gaps of the neighbours stay as even, or as uneven as they are.
        let most = (1.0 - ASIDE) / ASIDE;
        let gap = |k: usize| {
            let next = (k + 1) % n;
            knots[next].t - knots[k % n].t + if next == 0 { 1.0 } else { 0.0 }
        };
        if knots[(i + n - 1) % n].base.is_some() {
            let beyond = gap(i + n - 2);
            (low, high) = (low.max(before + beyond / most), high.min(before + most * beyond));
        }
        if knots[(i + 1) % n].base.is_some() {
            let beyond = gap(i + 1);
            (low, high) = (low.max(after - most * beyond), high.min(after - beyond / most));
        }
        if low > high || low.is_nan() || high.is_nan() {
            return None;
        }
        let mut best: Option<(f64, f64)> = None;
        for _ in 0..2 {
            let step = (high - low) / f64::from(LOOKS);
            for k in 0..=LOOKS {
                let t = low + step * f64::from(k);
                at[i] = self.position(t);
                let shape = self.worst_around(i, at);
                if best.is_none_or(|b| shape > b.1) {
                    best = Some((t, shape));
                }
            }
            let (t, _) = best?;
            (low, high) = ((t - step).max(low), (t + step).min(high));
        }
        best
    }

    /// The worst shape of the triangles that have knot `i` as a corner.
    fn worst_around(&self, i: usize, at: &[DVec3]) -> f64 {
        let n = at.len();
        let before = if i > 0 || self.strip.closed { self.link((i + n - 1) % n, at) } else { f64::INFINITY };
        before.min(self.worst(i, at))
    }

    /// The worst shape of the triangles between knot `i` and the rim, and to the next knot.
    pub(super) fn worst(&self, i: usize, at: &[DVec3]) -> f64 {
        self.begun(i, at).fold(f64::INFINITY, f64::min)
    }

    /// The shapes of the triangles between knot `i` and the rim, and to the next knot.
    fn begun<'a>(&'a self, i: usize, at: &'a [DVec3]) -> impl Iterator<Item = f64> + 'a {
        let own = self.strip.knots[i];
        let seen: Range<u32> = own.first..own.first + own.span;
        let fan = seen.map(move |j| {
            let (q, r) = (self.rim_at(j), self.rim_at(j + 1));
            shape([r.0, q.0, at[i]], q.1 + r.1)
        });
        fan.chain([self.link(i, at)])
    }

    /// The shape of the triangle between knot `i` and the next.
    fn link(&self, i: usize, at: &[DVec3]) -> f64 {
        if !self.strip.closed && i + 1 == at.len() {
            return f64::INFINITY;
        }
        let own = self.strip.knots[i];
        let q = self.rim_at(own.first + own.span);
        shape([q.0, at[i], at[(i + 1) % at.len()]], q.1)
    }

    fn rim_at(&self, j: u32) -> (DVec3, DVec3) {
        self.rim[j as usize % self.rim.len()]
    }
}

/// As [`shape`](super::super::relax::shape), and below zero where the triangle faces away from `up`.
pub(super) fn shape([a, b, c]: [DVec3; 3], up: DVec3) -> f64 {
    let plain = super::super::relax::shape([a, b, c]);
    if (b - a).cross(c - a).dot(up) < 0.0 { -plain } else { plain }
}

#[cfg(test)]
mod tests {
    use super::super::attach::{Knot, KnotKind};
    use super::*;

    /// The x axis from 0 to 1.
    #[derive(Debug)]
    struct Axis;

    impl Curve for Axis {
        fn position(&self, u: f64) -> DVec3 {
            DVec3::X * u
        }

        fn closed(&self) -> bool {
            false
        }
    }

    /// A strip from end to end below the rim given, with knots at `t`.
    fn strip(rim: &[[f64; 2]], t: &[f64]) -> (Strip, Vec<(DVec3, DVec3)>, Vec<Slider>) {
        let at = |i: usize| DVec3::new(rim[i][0], rim[i][1], 0.0);
        let knot = |(i, &t): (usize, &f64)| {
            let kind = if i == 0 || i + 2 == rim.len() { KnotKind::End } else { KnotKind::Smooth };
            Knot { t, kind, first: i as u32, span: 1, given: false }
        };
        let knots: Vec<Knot> = t.iter().enumerate().map(knot).collect();
        let slide = |k: &Knot| {
            let base = (k.kind == KnotKind::Smooth).then(|| [at(k.first as usize), at(k.first as usize + 1)]);
            Slider { t: k.t, base, width: 1.0 }
        };
        let sliders = knots.iter().map(slide).collect();
        let points = (0..rim.len()).map(|i| (at(i), DVec3::Z)).collect();
        (Strip { cut: 0, rim: (0..rim.len() as u32).collect(), knots, closed: false }, points, sliders)
    }

    fn worst(shapes: &[f64]) -> f64 {
        shapes.iter().copied().fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn a_knot_leaves_the_line_of_a_rim_edge_that_points_at_the_curve() {
        // The rim steps away from the curve at x = 0.5, and the isosceles place is below the step.
        let rim = [[0.1, 0.1], [0.3, 0.1], [0.5, 0.1], [0.5, 0.25], [0.7, 0.25], [0.95, 0.25]];
        let (strip, rim, mut knots) = strip(&rim, &[0.0, 0.4, 0.5, 0.7, 1.0]);
        let settling = Settling { strip: &strip, rim, curve: &Axis, heading: Heading::Along };
        assert!(worst(&settling.shapes(&knots)) < 1e-12);
        settling.settle(&mut knots);
        assert!(worst(&settling.shapes(&knots)) > 0.1, "{:?}", settling.shapes(&knots));
        assert!(knots.windows(2).all(|k| k[0].t < k[1].t), "they keep their order");
        assert_eq!([knots[0].t, knots[4].t], [0.0, 1.0]);
    }

    /// Beside a triangle that faces the wrong way one of hardly any width is not the worst, but the flattest.
    #[test]
    fn a_sliver_beside_a_folded_triangle_is_seen() {
        let rim = [[0.1, 0.2], [0.5, 0.3], [0.3, 0.3], [0.7, 0.3], [0.9, 0.2]];
        let (strip, rim, knots) = strip(&rim, &[0.0, 0.4, 0.40001, 1.0]);
        let settling = Settling { strip: &strip, rim, curve: &Axis, heading: Heading::Along };
        assert!(settling.shapes(&knots)[1] < -0.5);
        let flattest = settling.flattest(&knots)[1];
        assert!(flattest > 0.0 && flattest < 1e-4, "{flattest}");
    }

    /// The rim comes down to the curve and goes back up, steeply: a knot has to pass below the way up, where
    /// its neighbours are.
    #[test]
    fn neighbours_make_room_for_a_knot_that_is_on_the_wrong_side_of_its_rim_edge() {
        let rim = [
            [0.013, 0.153],
            [0.21, 0.296],
            [0.327, 0.144],
            [0.49, 0.331],
            [0.585, 0.198],
            [0.674, 0.081],
            [0.77, 0.319],
            [0.825, 0.238],
            [0.873, 0.183],
            [0.919, 0.151],
            [0.969, 0.142],
        ];
        let (strip, rim, mut knots) = strip(&rim, &[0.0, 0.245, 0.368, 0.408, 0.474, 0.6, 0.62, 0.66, 0.75, 1.0]);
        let settling = Settling { strip: &strip, rim, curve: &Axis, heading: Heading::Along };
        assert!(worst(&settling.shapes(&knots)) < 0.0, "one is folded");
        settling.settle(&mut knots);
        assert!(worst(&settling.shapes(&knots)) > 0.05, "{:?}", settling.shapes(&knots));
        assert!(knots.windows(2).all(|k| k[0].t < k[1].t), "they keep their order");
    }

    #[test]
    fn knots_of_fair_triangles_keep_their_bits() {
        let rim = [[0.1, 0.1], [0.3, 0.1], [0.5, 0.1], [0.7, 0.1], [0.9, 0.1]];
        let (strip, rim, mut knots) = strip(&rim, &[0.0, 0.4, 0.61, 1.0]);
        let settling = Settling { strip: &strip, rim, curve: &Axis, heading: Heading::Along };
        let before: Vec<u64> = knots.iter().map(|k| k.t.to_bits()).collect();
        settling.settle(&mut knots);
        assert_eq!(before, knots.iter().map(|k| k.t.to_bits()).collect::<Vec<_>>());
    }
}
