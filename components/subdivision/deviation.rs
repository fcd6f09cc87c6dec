//! How far a face of a surface lies from the triangle of its corners, from above.
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
//!
//! Where a face is no polynomial, beside given borders and irregular vertices, fifteen points of it tell what
//! the rest is, and their second differences what it may be between them.

use glam::DVec3;

use super::boxspline::Quartic;

/// The greatest `|s (s - 1/2) (s - 1)|` on [0, 1], `sqrt(3) / 36`: what is left of `s^3`, `s^2 t`,
/// `s t^2` and `t^3` on the unit triangle; of the mixed ones on the edge `s + t = 1`.
const LEFT_OF_CUBES: f64 = 0.048_112_523;

/// The greatest `|s (s - 1/2) (s - 1) (s + 3/2)|`: what is left of `s^4` and `t^4`. Rounded up.
const LEFT_OF_FOURTH: f64 = 0.110_41;

/// The greatest `|s (s - 1/2) (s - 1) (s + 1/2)|`: what is left of `s^3 t` and `s t^3`.
const LEFT_OF_MIXED: f64 = 1.0 / 16.0;

/// How a face stands off the triangle of its corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviation {
    /// Four times the difference in the middle of the edges 01, 12 and 20, in model units.
    bulges: [DVec3; 3],
    rest: Rest,
}

/// What is left of the difference besides the quadratic.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rest {
    /// A sum of these, each times at most 1, in model units.
    Terms([DVec3; 8]),
    /// No farther than `along` up or down the unit vector `normal`, nor than `across` athwart it; over the
    /// edges no farther from the line through their ends than `edges`.
    Within { normal: DVec3, along: f64, across: f64, edges: [f64; 3] },
}

/// Limit points of a face that divide its edges by four: row by row, `i` steps towards the second corner by
/// row, and in a row `j` towards the third.
pub type QuarterPoints = [DVec3; 15];

/// Steps of the [`QuarterPoints`] along an edge.
const STEPS: usize = 4;

/// The place of `(i, j)` among the [`QuarterPoints`].
const fn quarter_point(i: usize, j: usize) -> usize {
    i * (STEPS + 1) - i * i.saturating_sub(1) / 2 + j
}

/// Three [`QuarterPoints`] in a row, in each direction of the lattice.
const LINES: [[usize; 3]; 18] = [
    [0, 1, 2],
    [1, 2, 3],
    [2, 3, 4],
    [0, 5, 9],
    [1, 6, 10],
    [5, 6, 7],
    [2, 6, 9],
    [2, 7, 11],
    [6, 7, 8],
    [3, 7, 10],
    [4, 8, 11],
    [5, 9, 12],
    [6, 10, 13],
    [9, 10, 11],
    [7, 10, 12],
    [8, 11, 13],
    [9, 12, 14],
    [11, 13, 14],
];

/// The [`QuarterPoints`] of the edges, from a corner to the next.
const EDGES: [[usize; 5]; 3] = [[0, 5, 9, 12, 14], [14, 13, 11, 8, 4], [4, 3, 2, 1, 0]];

/// What a smooth function may reach between three points of a lattice over what it is at them, in second
/// differences. Where these are equal in all directions it is a sixth; half as much again is for what they
/// change from one line of the lattice to the next.
const BETWEEN: f64 = 0.25;

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
            rest: Rest::Terms([cubes[0], cubes[1], cubes[2], cubes[3], ssss, tttt, ssst, sttt]),
        }
    }

    /// Of a face that is no polynomial, by limit points of it. What lies between the points is told by the
    /// second differences of the rest: so this is a bound where the surface does not bend otherwise between
    /// the points than it does at them.
    pub fn of_points(points: &QuarterPoints) -> Self {
        let [a, b, c] = [(0, 0), (STEPS, 0), (0, STEPS)].map(|(i, j)| points[quarter_point(i, j)]);
        let at = |i: usize, j: usize| {
            let [u, v, w] = [STEPS - i - j, i, j].map(|steps| steps as f64 / STEPS as f64);
            (points[quarter_point(i, j)] - (a * u + b * v + c * w), [u, v, w])
        };
        let bulges = [(2, 0), (2, 2), (0, 2)].map(|(i, j)| at(i, j).0 * 4.0);
        let mut rest = [DVec3::ZERO; 15];
        for i in 0..=STEPS {
            for j in 0..=STEPS - i {
                let (off, [u, v, w]) = at(i, j);
                rest[quarter_point(i, j)] = off - (bulges[0] * (u * v) + bulges[1] * (v * w) + bulges[2] * (w * u));
            }
        }
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let (mut most, mut bend) = ([0.0_f64; 2], [0.0_f64; 2]);
        let see = |most: &mut [f64; 2], r: DVec3| {
            let along = r.dot(normal);
            *most = [most[0].max(along.abs()), most[1].max((r - normal * along).length_squared())];
        };
        rest.iter().for_each(|&r| see(&mut most, r));
        for [p, q, r] in LINES {
            see(&mut bend, rest[p] + rest[r] - rest[q] * 2.0);
        }
        if !rest.iter().all(|r| r.length_squared().is_finite()) {
            // Squares that overflow tell nothing, and comparisons pass over what is no number.
            most = [f64::INFINITY; 2];
        }
        let along = most[0] + BETWEEN * bend[0];
        let across = most[1].sqrt() + BETWEEN * bend[1].sqrt();
        let edges = [[a, b], [b, c], [c, a]].map(|[from, to]| (to - from).normalize_or_zero());
        let edges = [0, 1, 2].map(|e| off_line(EDGES[e].map(|k| rest[k]), edges[e]));
        Self { bulges, rest: Rest::Within { normal, along, across, edges } }
    }

    /// The same, as seen from a face whose corner `first` is the first here.
    #[must_use]
    pub fn turned(&self, first: usize) -> Self {
        let turned = |e: usize| (e + 3 - first) % 3;
        let rest = match self.rest {
            Rest::Within { normal, along, across, edges } => {
                Rest::Within { normal, along, across, edges: [0, 1, 2].map(|e| edges[turned(e)]) }
            }
            rest @ Rest::Terms(_) => rest,
        };
        Self { bulges: [0, 1, 2].map(|e| self.bulges[turned(e)]), rest }
    }

    /// No point of the rest is longer.
    fn rest(&self) -> f64 {
        match &self.rest {
            Rest::Terms(terms) => terms.iter().map(|c| c.length()).sum(),
            Rest::Within { along, across, .. } => along.hypot(*across),
        }
    }

    /// No point of the rest is farther along the unit vector `direction`.
    fn rest_along(&self, direction: DVec3) -> f64 {
        match &self.rest {
            Rest::Terms(terms) => terms.iter().map(|c| c.dot(direction).abs()).sum(),
            Rest::Within { normal, along, across, .. } => {
                let up = normal.dot(direction);
                along * up.abs() + across * (direction - *normal * up).length()
            }
        }
    }

    /// No point of the face is farther from the point of its triangle with the same weights.
    pub fn greatest(&self) -> f64 {
        peak(self.bulges) + self.rest()
    }

    /// No point of the face is farther than this from the point of its triangle with the same weights,
    /// measured along the unit vector `direction`.
    pub fn along(&self, direction: DVec3) -> f64 {
        peak_of_form(self.bulges.map(|q| q.dot(direction))) + self.rest_along(direction)
    }

    /// Of the points of the face that are beyond edge `edge` of its triangle: none is farther beyond than the
    /// first, nor than the second up or down the unit vector `normal`. The unit vector `outward` points
    /// across the edge, and the corner that is left is `height` away from it.
    ///
    /// With the weight `w` of that corner, a point starts `w height` from the edge. Of the quadratic, two
    /// parts are at most `w` times their coefficient: they do not get it there, and if the third and the rest
    /// do, `w` is small.
    pub fn beyond(&self, edge: usize, outward: DVec3, height: f64, normal: DVec3) -> [f64; 2] {
        let bulges = [0, 1, 2].map(|e| self.bulges[(edge + e) % 3]);
        let [own, next, last] = bulges.map(|q| q.dot(outward));
        let beyond = 0.25 * own.max(0.0) + self.rest_along(outward);
        let weight = beyond / (height - next.max(last).max(0.0));
        if !(0.0..=1.0).contains(&weight) {
            return [outward, normal].map(|direction| self.along(direction));
        }
        let [own, next, last] = bulges.map(|q| q.dot(normal).abs());
        let high = 0.25 * own + weight * next.max(last) + self.rest_along(normal);
        [beyond, high.min(self.along(normal))]
    }

    /// No point over edge `edge` of the face is farther from the line through its ends than this, along the
    /// unit vector `across` that is athwart the line.
    pub fn off_edge(&self, edge: usize, across: DVec3) -> f64 {
        let rest = match &self.rest {
            Rest::Terms(_) => self.rest_along(across),
            Rest::Within { edges, .. } => edges[edge],
        };
        0.25 * self.bulges[edge].dot(across).abs() + rest
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

/// How far from the line in `direction` what has these values at five points in a row may be.
fn off_line(values: [DVec3; 5], direction: DVec3) -> f64 {
    let off = |r: DVec3| (r - direction * r.dot(direction)).length_squared();
    let most = values.iter().map(|&r| off(r)).fold(0.0, f64::max);
    let bend = values.windows(3).map(|r| off(r[0] + r[2] - r[1] * 2.0)).fold(0.0, f64::max);
    most.sqrt() + BETWEEN * bend.sqrt()
}

/// At least the greatest length of `w0 w1 q_01 + w1 w2 q_12 + w2 w0 q_20`, and that where all `q` are
/// parallel: along the longest of them, and across it by lengths alone.
fn peak(bulges: [DVec3; 3]) -> f64 {
    let longest =
        bulges.into_iter().fold(DVec3::ZERO, |a, b| if b.length_squared() > a.length_squared() { b } else { a });
    let direction = longest.normalize_or_zero();
    let along = bulges.map(|q| q.dot(direction));
    let across: [f64; 3] = core::array::from_fn(|e| (bulges[e] - direction * along[e]).length());
    let [along, across] = [along, across].map(peak_of_form);
    // What overflows is infinite, and so is the bound.
    (along * along + across * across).sqrt()
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
mod tests;
