//! How far one polynomial of a surface lies from the triangle of its corners, from above.
//!
//! Both are compared at the same parameters: so no point of either is farther from the other. The
//! difference vanishes at the corners. It is split into the quadratic `Q` that has its values in the
//! middles of the edges, and a rest that vanishes there too. With corner weights `w` and `q_ij` four
//! times the difference in the middle of edge `ij`,
//!
//! ```text
//! Q(w) = w0 w1 q_01 + w1 w2 q_12 + w2 w0 q_20
//! ```
//!
//! whose greatest value has a closed form. The rest falls with the cube of the size, and each monomial
//! of the third and fourth power has its own greatest value of it. So the bound is sharp where the
//! surface is quadratic, and becomes so everywhere as faces get smaller.

use glam::DVec3;

use super::boxspline::Quartic;

/// The greatest `|s (s - 1/2) (s - 1)|` on [0, 1], `sqrt(3) / 36`: what is left of `s^3`, `s^2 t`,
/// `s t^2` and `t^3` on the unit triangle; of the mixed ones on the edge `s + t = 1`.
const LEFT_OF_CUBES: f64 = 0.048_112_523;

/// The greatest `|s (s - 1/2) (s - 1) (s + 3/2)|`: what is left of `s^4` and `t^4`. Rounded up.
const LEFT_OF_FOURTH: f64 = 0.110_41;

/// The greatest `|s (s - 1/2) (s - 1) (s + 1/2)|`: what is left of `s^3 t` and `s t^3`.
const LEFT_OF_MIXED: f64 = 1.0 / 16.0;

/// How a face that lies within one [`Quartic`] stands off the triangle of its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Four times the difference in the middle of the edges 01, 12 and 20, in model units.
    bulges: [DVec3; 3],
    /// What the rest is a sum of, each times at most 1, in model units.
    rest: [DVec3; 8],
}

impl Deviation {
    /// Of the face with the corners `at`, `at + (size, 0)` and `at + (0, size)` in the domain of
    /// `quartic`; a negative `size` turns the face about `at` by half a turn.
    pub fn new(quartic: &Quartic, at: [f64; 2], size: f64) -> Self {
        let c = &quartic.coefficients;
        let [s, t] = at;
        let (h2, h3, h4) = (size * size, size * size * size, size * size * size * size);
        // Taylor coefficients at the corner, by powers of s and t; `c` as `EXPONENTS` orders them.
        let ss = (c[2] + (c[3] * 3.0 + c[4] * (6.0 * s) + c[8] * (3.0 * t)) * s + c[7] * t) * h2;
        let st = (c[6] + (c[7] * 2.0 + c[8] * (3.0 * s)) * s + (c[10] * 2.0 + c[12] * (3.0 * t)) * t) * h2;
        let tt = (c[9] + (c[11] * 3.0 + c[13] * (6.0 * t) + c[12] * (3.0 * s)) * t + c[10] * s) * h2;
        let sss = (c[3] + c[4] * (4.0 * s) + c[8] * t) * h3;
        let sst = (c[7] + c[8] * (3.0 * s)) * h3;
        let stt = (c[10] + c[12] * (3.0 * t)) * h3;
        let ttt = (c[11] + c[12] * s + c[13] * (4.0 * t)) * h3;
        let [ssss, ssst, sttt, tttt] = [c[4], c[8], c[12], c[13]].map(|c| c * h4);
        let (along_s, along_t) = (ss + sss * 1.5 + ssss * 1.75, tt + ttt * 1.5 + tttt * 1.75);
        let across = st + (sst + stt) * 0.5 + (ssst + sttt) * 0.25;
        let cubes = [sss, sst, stt, ttt].map(|c| c * LEFT_OF_CUBES);
        let [ssss, tttt] = [ssss, tttt].map(|c| c * LEFT_OF_FOURTH);
        let [ssst, sttt] = [ssst, sttt].map(|c| c * LEFT_OF_MIXED);
        Self {
            bulges: [-along_s, across - along_s - along_t, -along_t],
            rest: [cubes[0], cubes[1], cubes[2], cubes[3], ssss, tttt, ssst, sttt],
        }
    }

    /// No point of the rest is longer.
    fn rest(&self) -> f64 {
        self.rest.iter().map(|c| c.length()).sum()
    }

    /// No point of the face is farther from the point of its triangle with the same weights.
    pub fn greatest(&self) -> f64 {
        peak(self.bulges) + self.rest()
    }

    /// No point of the face is farther than this from the point of its triangle with the same weights,
    /// measured along the unit vector `direction`.
    pub fn along(&self, direction: DVec3) -> f64 {
        let rest: f64 = self.rest.iter().map(|c| c.dot(direction).abs()).sum();
        peak_of_form(self.bulges.map(|q| q.dot(direction))) + rest
    }

    /// In the middle of an edge the face is this far, along the unit vector `direction`, from the middle
    /// of its triangle's edge: a bound from below for [`Deviation::along`].
    pub fn in_the_middle(&self, direction: DVec3) -> f64 {
        self.bulges.iter().map(|q| 0.25 * q.dot(direction).abs()).fold(0.0, f64::max)
    }

    /// The same for a triangle whose corners, given by their weights on this face, are corners of the face
    /// or middles of its edges: there the rest vanishes, and elsewhere it is what it was.
    pub fn of_piece(&self, corners: [[f64; 3]; 3]) -> Self {
        let bulge = |from: [f64; 3], to: [f64; 3]| {
            let way: [f64; 3] = core::array::from_fn(|c| to[c] - from[c]);
            (0..3).fold(DVec3::ZERO, |sum, e| sum - self.bulges[e] * (way[e] * way[(e + 1) % 3]))
        };
        Self { bulges: [0, 1, 2].map(|e| bulge(corners[e], corners[(e + 1) % 3])), rest: self.rest }
    }
}

/// At least the greatest length of `w0 w1 q_01 + w1 w2 q_12 + w2 w0 q_20`, and that where all `q` are
/// parallel: along the longest of them, and across it by lengths alone.
fn peak(bulges: [DVec3; 3]) -> f64 {
    let longest =
        bulges.into_iter().fold(DVec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    let direction = longest.normalize_or_zero();
    let along = bulges.map(|q| q.dot(direction));
    let across: [f64; 3] = core::array::from_fn(|e| (bulges[e] - direction * along[e]).length());
    peak_of_form(along).hypot(peak_of_form(across))
}

/// The greatest `|w0 w1 a + w1 w2 b + w2 w0 c|` where no weight is negative and they sum to 1.
///
/// On an edge that is a quarter of its coefficient. Inside, the gradient is the same for all weights:
/// they are as `b (a + c - b)`, `c (a + b - c)`, `a (b + c - a)`, and the value is `a b c` over their sum.
fn peak_of_form([a, b, c]: [f64; 3]) -> f64 {
    let edges = 0.25 * a.abs().max(b.abs()).max(c.abs());
    let weights = [b * (a + c - b), c * (a + b - c), a * (b + c - a)];
    let sum: f64 = weights.iter().sum();
    let inside = weights.iter().all(|&w| w * sum > 0.0);
    if inside { edges.max((a * b * c / sum).abs()) } else { edges }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subdivision::boxspline::Net;

    /// Numbers in [-1, 1) that are the same on every run: the top bits of a linear congruence. [Knuth]
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    /// Weights of the points that divide each edge of a triangle by `n`.
    fn lattice(n: u32) -> impl Iterator<Item = [f64; 3]> {
        let part = move |i: u32| f64::from(i) / f64::from(n);
        (0..=n).flat_map(move |i| (0..=n - i).map(move |j| [part(n - i - j), part(i), part(j)]))
    }

    /// The greatest distance at the same weights between the quartic and its triangle over `corners`.
    fn sampled(quartic: &Quartic, corners: [[f64; 2]; 3]) -> f64 {
        let positions = corners.map(|[s, t]| quartic.position(s, t));
        let off = |w: [f64; 3]| {
            let [s, t] = [0, 1].map(|k| (0..3).map(|c| w[c] * corners[c][k]).sum());
            quartic.position(s, t).distance((0..3).map(|c| positions[c] * w[c]).sum())
        };
        lattice(60).map(off).fold(0.0, f64::max)
    }

    fn corners([s, t]: [f64; 2], size: f64) -> [[f64; 2]; 3] {
        [[s, t], [s + size, t], [s, t + size]]
    }

    const PLACES: [([f64; 2], f64); 6] = [
        ([0.0, 0.0], 1.0),
        ([0.5, 0.0], 0.5),
        ([0.5, 0.5], -0.5),
        ([0.25, 0.5], 0.25),
        ([0.75, 0.25], -0.25),
        ([0.0, 0.875], 0.125),
    ];

    fn rough(seed: u64) -> Quartic {
        let mut next = numbers(seed);
        let net: Net = core::array::from_fn(|_| DVec3::new(next(), next(), next()));
        Quartic::new(&net)
    }

    /// However rough the net, wherever the face: no sample lies beyond the bound.
    #[test]
    fn no_sample_exceeds_the_bound() {
        for seed in 0..40 {
            let quartic = rough(seed);
            for (at, size) in PLACES {
                let deviation = Deviation::new(&quartic, at, size);
                let (bound, found) = (deviation.greatest(), sampled(&quartic, corners(at, size)));
                assert!(found <= bound * (1.0 + 1e-12), "{seed} {at:?}: {found} beyond {bound}");
                assert!(found > 0.125 * bound, "{seed} {at:?}: {found} is far below {bound}");
            }
        }
    }

    /// The same for the triangles that closures cut a face into.
    #[test]
    fn no_sample_of_a_piece_exceeds_its_bound() {
        let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [ab, bc] = [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5]];
        for seed in 0..40 {
            let quartic = rough(seed);
            for (at, size) in PLACES {
                let (deviation, face) = (Deviation::new(&quartic, at, size), corners(at, size));
                for piece in [[a, ab, c], [ab, b, c], [ab, b, bc], [a, ab, bc], [a, bc, c]] {
                    let place = |w: [f64; 3]| [0, 1].map(|k| (0..3).map(|c| w[c] * face[c][k]).sum());
                    let (bound, found) = (deviation.of_piece(piece).greatest(), sampled(&quartic, piece.map(place)));
                    assert!(found <= bound * (1.0 + 1e-12), "{seed} {at:?} {piece:?}: {found} beyond {bound}");
                }
            }
        }
    }

    /// Whatever the direction, no sample stands off farther along it, and none is needed that is much farther.
    #[test]
    fn no_sample_exceeds_the_bound_along_a_direction() {
        for seed in 0..40 {
            let quartic = rough(seed);
            let mut next = numbers(seed + 100);
            for (at, size) in PLACES {
                let direction = DVec3::new(next(), next(), next()).normalize();
                let mut flat = quartic;
                flat.coefficients.iter_mut().for_each(|c| *c = direction * c.dot(direction));
                let bound = Deviation::new(&quartic, at, size).along(direction);
                let found = sampled(&flat, corners(at, size));
                assert!(found <= bound * (1.0 + 1e-12), "{seed} {at:?}: {found} beyond {bound}");
                assert!(found > 0.125 * bound, "{seed} {at:?}: {found} is far below {bound}");
            }
        }
    }

    /// On a quadratic height field there is no rest, and all that is left points one way: the bound is
    /// the greatest value itself, up to how near a sample comes.
    #[test]
    fn the_bound_is_sharp_on_quadratics() {
        let mut next = numbers(7);
        for _ in 0..100 {
            let mut quartic = Quartic { coefficients: [DVec3::ZERO; 14] };
            for k in [2, 6, 9] {
                quartic.coefficients[k] = DVec3::Z * next();
            }
            for (at, size) in PLACES {
                let bound = Deviation::new(&quartic, at, size).greatest();
                let found = sampled(&quartic, corners(at, size));
                assert!((0.998 * bound..=bound * (1.0 + 1e-12)).contains(&found), "{found} of {bound}");
            }
        }
    }

    /// What is not quadratic loses its share as faces get smaller: the bound becomes sharp.
    #[test]
    fn the_bound_gets_sharp_on_small_faces() {
        for seed in 0..20 {
            let mut quartic = rough(seed);
            quartic.coefficients.iter_mut().for_each(|c| *c *= DVec3::Z);
            for (size, share) in [(1.0 / 64.0, 0.9), (1.0 / 1024.0, 0.99)] {
                let bound = Deviation::new(&quartic, [0.25, 0.25], size).greatest();
                let found = sampled(&quartic, corners([0.25, 0.25], size));
                assert!(found > share * bound && found <= bound * (1.0 + 1e-9), "{seed}: {found} of {bound}");
            }
        }
    }
}
