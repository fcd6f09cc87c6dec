//! # Make room: many knots move so that one may leave a bad place
//!
//! ```text
//!   ---- q              The rim comes down to the curve along `q r`, so `p` must be to the left of that
//!         |             line; but its neighbours are as far to the right as it is, and as close as they
//!         r ------      may be. Those between `p` and a knot some way off are spaced anew, from there to
//!  . . . . . p . .      where `p` is to be.
//! ```
//!
//! Where the faces of a source are stretched, edges of the rim are long across the curve and short along
//! it. Then a knot alone finds no place where its triangle is not folded. A move is taken where the worst
//! triangle of all that it touches is no worse, and all that are thin are wider together.

use glam::DVec3;

use super::super::relax::Slider;
use super::settle::{LOOKS, Settling, THIN};

/// How many knots to either side are spaced anew, tried in this order.
const ASIDES: [usize; 3] = [2, 4, 8];

/// How even they become: as they were, half-way, or wholly. Towards the tip of a narrow wedge gaps grow.
const EVEN: [f64; 3] = [0.0, 0.5, 1.0];

/// How many times as wide as the one next to it a gap may become: more than a knot alone may make it, for a
/// knot that is off its place by half a gap is better than a fold.
const UNEVEN: f64 = 4.0;

/// Knots around one, from the last to its left that stays to the first to its right, with one more beyond
/// each where there is one: their parameters rise.
#[derive(Clone)]
struct Crowd {
    /// The number of the first, counted on from below zero.
    first: i64,
    t: Vec<f64>,
    /// The places of those that stay, and between them of the one.
    ends: [usize; 2],
    own: usize,
}

/// What is known of the triangles around a crowd.
#[derive(Clone, Copy)]
struct Look {
    worst: f64,
    /// The sum of shapes, of each no more than [`THIN`].
    sum: f64,
}

impl Settling<'_> {
    /// Moves knot `i` and its neighbours to where the triangles around them are wider, if there is such a
    /// place. `at` follows. Tells whether it did.
    pub(super) fn make_room(&self, i: usize, knots: &mut [Slider], at: &mut [DVec3]) -> bool {
        let mut best: Option<(Crowd, Vec<f64>, f64)> = None;
        for aside in ASIDES {
            let Some(crowd) = self.crowd(i, knots, aside) else { continue };
            let before = self.look(&crowd, at);
            for t in crowd.candidates() {
                self.put(&crowd, &t, at);
                let look = self.look(&crowd, at);
                let gain = look.sum - before.sum;
                let is_better = look.worst >= before.worst && gain > 0.0;
                if is_better && best.as_ref().is_none_or(|(.., most)| gain > *most) {
                    best = Some((crowd.clone(), t, gain));
                }
            }
            self.put(&crowd, &crowd.t, at);
            if best.is_some() {
                break;
            }
        }
        let Some((crowd, t, _)) = best else { return false };
        for k in crowd.ends[0] + 1..crowd.ends[1] {
            let rounds = (crowd.first + k as i64).div_euclid(knots.len() as i64) as f64;
            knots[crowd.index(k, knots.len())].t = t[k] - rounds;
        }
        self.put(&crowd, &t, at);
        true
    }

    /// Notes where those of a crowd are that may move.
    fn put(&self, crowd: &Crowd, t: &[f64], at: &mut [DVec3]) {
        for k in crowd.ends[0] + 1..crowd.ends[1] {
            at[crowd.index(k, at.len())] = self.position(t[k]);
        }
    }

    /// The knots around `i`, `aside` to either side or as far as they may move.
    fn crowd(&self, i: usize, knots: &[Slider], aside: usize) -> Option<Crowd> {
        let n = knots.len() as i64;
        let exists = |k: i64| self.strip.closed || (0..n).contains(&k);
        let is_free = |k: i64| exists(k) && knots[k.rem_euclid(n) as usize].base.is_some();
        // Round a closed strip both sides would meet.
        let most = if self.strip.closed { (n - 3) / 2 } else { n }.min(aside as i64);
        let i = i as i64;
        let far = |sign: i64| (1..=most).find(|d| !is_free(i + sign * d)).unwrap_or(most);
        let (from, to) = (i - far(-1), i + far(1));
        if most < 1 || !exists(from) || !exists(to) {
            return None;
        }
        let (first, last) = (from - i64::from(exists(from - 1)), to + i64::from(exists(to + 1)));
        let t = (first..=last).map(|k| knots[k.rem_euclid(n) as usize].t + k.div_euclid(n) as f64);
        let place = |k: i64| (k - first) as usize;
        Some(Crowd { first, t: t.collect(), ends: [place(from), place(to)], own: place(i) })
    }

    /// The triangles that have one of a crowd as a corner.
    fn look(&self, crowd: &Crowd, at: &[DVec3]) -> Look {
        let mut look = Look { worst: f64::INFINITY, sum: 0.0 };
        for k in crowd.ends[0]..crowd.ends[1] {
            let shape = self.worst(crowd.index(k, at.len()), at);
            look = Look { worst: look.worst.min(shape), sum: look.sum + shape.min(THIN) };
        }
        look
    }
}

impl Crowd {
    /// Which knot one of them is, of `n`.
    fn index(&self, k: usize, n: usize) -> usize {
        (self.first + k as i64).rem_euclid(n as i64) as usize
    }

    /// Parameters that they might have.
    fn candidates(&self) -> impl Iterator<Item = Vec<f64>> + '_ {
        let [from, to] = self.ends.map(|k| self.t[k]);
        let places = (1..LOOKS).map(move |k| from + (to - from) * f64::from(k) / f64::from(LOOKS));
        let spaced = places.flat_map(|x| EVEN.map(|even| self.spaced(x, even)));
        spaced.filter(|t| self.is_even(t))
    }

    /// With the one at `x`, and those between it and the ends a part of the way to even steps.
    fn spaced(&self, x: f64, even: f64) -> Vec<f64> {
        let mut t = self.t.clone();
        for [from, to, end] in [[self.ends[0], self.own, 0], [self.own, self.ends[1], 1]] {
            let (a, b) = (self.t[from], self.t[to]);
            let (c, d) = if end == 0 { (a, x) } else { (x, b) };
            for (k, t) in (from..=to).zip(&mut t[from..=to]) {
                let share = (self.t[k] - a) / (b - a);
                let step = (k - from) as f64 / (to - from) as f64;
                *t = c + (d - c) * (share + even * (step - share));
            }
        }
        t
    }

    /// Are gaps next to each other alike enough, or as alike as they were?
    fn is_even(&self, t: &[f64]) -> bool {
        let uneven = |t: &[f64], k: usize| {
            let (before, after) = (t[k] - t[k - 1], t[k + 1] - t[k]);
            if before > 0.0 && after > 0.0 { (before / after).max(after / before) } else { f64::INFINITY }
        };
        // Of the ends, one that may not move is a corner, which divides its gaps as it likes.
        let inner = self.ends[0] + 1..self.ends[1];
        let outer = self.ends.into_iter().filter(|&k| k > 0 && k + 1 < t.len());
        inner.chain(outer).all(|k| uneven(t, k) <= UNEVEN.max(uneven(&self.t, k)))
    }
}
