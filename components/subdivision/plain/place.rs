//! Where in a face a point lies, as a regular piece and a place in it.

/// How often a face is quartered towards a vertex at most. What is left there is the limit of the
/// vertex: around it the surface is smaller than the control mesh by the largest eigenvalue below
/// one of any Loop vertex, 5/8, for each level, and `(5/8)^84 < 2^-56` vanishes beside the rounding of
/// the position itself.
pub const DEEPEST: u8 = 84;

/// A part of a face over which the surface is one polynomial and a bend ([`Band`](super::Band)), or a single
/// vertex.
///
/// A small number, so that what is made for the pieces of a face can stand in a list:
/// `4 depth + corner`. Corner 3 is none, its two pieces are the middle of a face and a whole one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece(u16);

impl Piece {
    /// The middle quarter of a face that is not regular, turned by half a turn.
    pub const MIDDLE: Self = Self::new(3, 0);
    /// The whole of a regular face.
    pub const WHOLE: Self = Self::new(3, 1);

    /// What is left behind around `corner` by quartering towards it `depth` times more than once and once
    /// again; of a regular corner all that is left before. At depth [`DEEPEST`] it is the vertex at that
    /// corner.
    #[inline(always)]
    pub const fn new(corner: u8, depth: u8) -> Self {
        Self(4 * depth as u16 + corner as u16)
    }

    /// The piece at `index` in a list of all pieces.
    #[inline(always)]
    pub const fn from_index(index: usize) -> Self {
        Self(index as u16)
    }

    /// Its place in a list of all pieces.
    #[inline(always)]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// The corner that it was left behind at: 0, 1 or 2; 3 for [`Self::MIDDLE`] and [`Self::WHOLE`].
    #[inline(always)]
    pub const fn corner(self) -> u8 {
        self.0 as u8 & 3
    }

    /// How often its face was quartered towards its corner, less one: at most [`DEEPEST`].
    #[inline(always)]
    pub const fn depth(self) -> u8 {
        (self.0 >> 2) as u8
    }
}

/// Where in a face a point lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The piece, as a number (see [`Piece`]).
    pub piece: u64,
    /// The point in the piece's own coordinates: they fill the unit triangle, of which a band is the part
    /// that is not nearest to its corner.
    pub s: f64,
    /// The other coordinate.
    pub t: f64,
    /// How much faster than the face's these run: a power of two, negative where they are turned by half
    /// a turn.
    pub scale: f64,
    /// What the excess of a band weighs there, and in the derivatives by the piece's coordinates; zero in a
    /// whole face and around a regular corner, of no meaning in other pieces that have none.
    pub weights: [f64; 3],
}

/// Is `(s, t)` in the unit triangle?
#[inline(always)]
pub fn is_inside(s: f64, t: f64) -> bool {
    (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
}

/// Puts `(s, t)` into the unit triangle. What is not a number becomes 0.
#[inline(always)]
pub fn clamp(s: f64, t: f64) -> (f64, f64) {
    if is_inside(s, t) { (s, t) } else { clamp_outside(s, t) }
}

#[cold]
fn clamp_outside(s: f64, t: f64) -> (f64, f64) {
    // The maximum with a NaN is the other number. Past 1 a coordinate's size no longer matters.
    let within = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, 2.0) };
    let (s, t) = (within(s), within(t));
    let sum = s + t;
    if sum <= 1.0 { (s, t) } else { (s / sum, t / sum) }
}

/// The piece of a face in which `(s, t)` of its unit triangle lies, and the place in it.
///
/// Bit `i` of `regular` says that corner `i` of a face that is not regular is: all that is left around it
/// after the first quartering is one polynomial. [`WHOLE`] stands for a face that is one itself.
///
/// All differences are exact or of one rounding of `1 - s - t` or of a weight in the piece, so a point
/// as near to a corner as its coordinates can say is found in a piece of its own size.
///
/// Without a branch, because for random places none could be foreseen, and so that a loop over places
/// is done in lanes.
#[inline(always)]
pub fn in_face(s: f64, t: f64, regular: u64) -> Found {
    // Exact, or off by one rounding of a number no larger than the distance to the corner.
    let r = (1.0 - s - t).max(0.0);
    let (first, second, third) = (s + t < 0.5, s > 0.5, t > 0.5);
    let corner = pick(first, second, [0, 1, 2]);
    // The weights of the two corners after the corner that it is nearest to.
    let (a, b) = (pick(first, second, [s, t, r]), pick(first, second, [t, r, s]));
    let whole = (regular >> corner) & 1 != 0;

    // Left behind at the depth where doubling has brought their sum to above a half. The exponent of
    // what comes before the sum says how often that is; a half itself is below.
    let exponent = ((a + b).clamp(NEAREST, 0.5).to_bits() - 1) >> 52;
    let exponent = if whole { DEPTH_0 } else { exponent };
    let depth = DEPTH_0 - exponent;
    let doubled = f64::from_bits((1024 + DEPTH_0 - exponent) << 52);
    let (a, b) = (a * doubled, b * doubled);
    let c = (1.0 - a - b).max(0.0);

    let at_vertex = depth == u64::from(DEEPEST);
    let s_there = if at_vertex { 0.0 } else { pick(first, second, [a, c, b]) };
    let t_there = if at_vertex { 0.0 } else { pick(first, second, [b, a, c]) };
    // Of a vertex the tangent plane is taken, along the face.
    let scale_there = if at_vertex { 1.0 } else { doubled };

    let (at_corner, all) = (first | second | third, regular == WHOLE);
    let [weight, by_c, by_a, by_b] = weigh_excess(a, b, c);
    // By the weights of the face's corners in turn.
    let by = [[by_c, by_b, by_a], [by_a, by_c, by_b], [by_b, by_a, by_c]].map(|by| pick(first, second, by));
    Found {
        piece: pick(all, at_corner, [Piece::WHOLE.0.into(), 4 * depth + corner, Piece::MIDDLE.0.into()]),
        s: pick(all, at_corner, [s, s_there, 1.0 - 2.0 * s]),
        t: pick(all, at_corner, [t, t_there, 1.0 - 2.0 * t]),
        scale: pick(all, at_corner, [1.0, scale_there, -2.0]),
        weights: [weight, by[1] - by[0], by[2] - by[0]].map(|weight| if all | whole { 0.0 } else { weight }),
    }
}

/// What the next point of a corner weighs over the band that a step towards it leaves behind, at the
/// weights `c` of the corner and `a` and `b` of the two after it; and the derivatives by `c`, `a`, `b`.
///
/// In each of the band's quarters it is the weight of one of the twelve control points there: beside the
/// corner in two, across the edge in that between. With `x = 1 - 2 a` and `y = 1 - 2 b` these are
/// `4/3 c^3 (1 - c + x)`, `4/3 c^3 (1 - c + y)` and `4/3 c^3 (1 - c) + x y (4 c^2 + x y) / 6`, and `x`
/// and `y` are above zero in the last alone.
#[inline(always)]
pub(super) fn weigh_excess(a: f64, b: f64, c: f64) -> [f64; 4] {
    let (x, y) = (1.0 - 2.0 * a, 1.0 - 2.0 * b);
    let (in_first, in_second) = (x < 0.0, y < 0.0);
    let (x, beyond_x) = if in_first { (0.0, x) } else { (x, 0.0) };
    let (y, beyond_y) = if in_second { (0.0, y) } else { (y, 0.0) };
    let (xy, square) = (x * y, 4.0 * (c * c));
    let cube = square * c * (1.0 / 3.0);
    let sum = a + b + (beyond_x + beyond_y);
    let by_xy = (square + 2.0 * xy) * (1.0 / 3.0);
    [
        cube * sum + xy * (square + xy) * (1.0 / 6.0),
        square * sum - cube + c * xy * (4.0 / 3.0),
        if in_first { cube * -2.0 } else { -(y * by_xy) },
        if in_second { cube * -2.0 } else { -(x * by_xy) },
    ]
}

/// Stands for the regular corners of a face that is one polynomial.
pub const WHOLE: u64 = 8;

/// The exponent of numbers in `[1/4, 1/2)`, as it is stored.
const DEPTH_0: u64 = 1021;
/// In the middle of `(2^-86, 2^-85]`: what lies nearer to a corner than depth [`DEEPEST`] begins.
const NEAREST: f64 = 1.5 * f64::from_bits((1023 - 86) << 52);

/// The first of `values` if `first`, else the second if `second`, else the third.
#[inline(always)]
fn pick<T: Copy>(first: bool, second: bool, values: [T; 3]) -> T {
    if first {
        values[0]
    } else if second {
        values[1]
    } else {
        values[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subdivision::boxspline::basis;
    use crate::subdivision::plain::tests::meshes::Random;

    /// The excess weighs what its control point does in the net of each quarter of a band.
    #[test]
    fn excess_weighs_as_its_control_point() {
        let mut random = Random(9);
        for _ in 0..3000 {
            let (u, v) = random.place();
            // Beside the first edge, beside the second, between: the corner's place in the net, the place in
            // the band, and how its coordinates run along the quarter's.
            let quarters = [
                (6, 0.5 + 0.5 * u, 0.5 * v, 2.0),
                (7, 0.5 * u, 0.5 + 0.5 * v, 2.0),
                (4, 0.5 - 0.5 * u, 0.5 - 0.5 * v, -2.0),
            ];
            for (point, a, b, scale) in quarters {
                let expected = basis(u, v).map(|row| row[point]);
                let [weight, by_c, by_a, by_b] = weigh_excess(a, b, (1.0 - a - b).max(0.0));
                let found = [weight, (by_a - by_c) / scale, (by_b - by_c) / scale];
                for (x, y) in found.into_iter().zip(expected) {
                    assert!((x - y).abs() < 1e-15, "{found:?}, not {expected:?}, for {point} at ({u}, {v})");
                }
            }
        }
    }

    /// A piece's coordinates run straight along the face's, as fast as it says, and fill its triangle.
    #[test]
    fn pieces_are_scaled_copies_of_the_face() {
        let mut random = Random(5);
        for regular in 0..=WHOLE {
            let mut seen: Vec<Option<[f64; 2]>> = vec![None; 4 * usize::from(DEEPEST + 1)];
            let mut found = 0;
            for i in 0..20_000 {
                let (s, t) = random.place();
                let near = 2_f64.powi(-(i % 5));
                let (s, t) = (s * near, t * near);
                let Found { piece, s: x, t: y, scale, .. } = in_face(s, t, regular);
                let size = 1e-15 + f64::EPSILON * scale.abs();
                assert!(x > -size && y > -size && x + y < 1.0 + size, "({x}, {y}) in {piece}");
                let origin = [x - scale * s, y - scale * t];
                match seen[piece as usize].replace(origin) {
                    Some(o) => assert!((0..2).all(|k| (o[k] - origin[k]).abs() < 4.0 * size)),
                    None => found += 1,
                }
            }
            if regular == WHOLE {
                assert_eq!((found, seen[Piece::WHOLE.index()]), (1, Some([0.0; 2])));
                continue;
            }
            // Four where every corner is regular; more around each that is not.
            assert_eq!(regular == 7, found == 4, "{found} pieces");
        }
    }
}
