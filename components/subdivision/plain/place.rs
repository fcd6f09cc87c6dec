//! Where in a face a point lies, as a regular piece and a place in it.

/// How often a face is quartered towards a vertex at most. What is left there is the limit of the
/// vertex: around it the surface is smaller than the control mesh by the largest eigenvalue below
/// one of any Loop vertex, 5/8, for each level, and `(5/8)^84 < 2^-56` vanishes beside the rounding of
/// the position itself.
pub const DEEPEST: u8 = 84;

/// A part of a face over which the surface is one polynomial, or a single vertex.
///
/// A small number, so that what is made for the pieces of a face can stand in a list:
/// `16 depth + 4 corner + quarter`. Quarter 3 is all of what is left around the corner; corner 3 is
/// none, its two quarters are the middle of a face and a whole one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece(u16);

impl Piece {
    /// The middle quarter of a face that is not regular, turned by half a turn.
    pub const MIDDLE: Self = Self::new(3, 0, 0);
    /// The whole of a regular face.
    pub const WHOLE: Self = Self::new(3, 0, 1);

    /// A quarter of what is left around `corner` after quartering towards it `depth` times more than
    /// once: 0 and 1 lie next to the corner's two edges, 2 between, turned by half a turn. 3 is no
    /// quarter but all that is left. At depth [`DEEPEST`] it is the vertex at that corner, whatever the
    /// quarter.
    #[inline(always)]
    pub const fn new(corner: u8, depth: u8, quarter: u8) -> Self {
        Self(16 * depth as u16 + 4 * corner as u16 + quarter as u16)
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
        (self.0 >> 2) as u8 & 3
    }

    /// How often its face was quartered towards its corner, less one: at most [`DEEPEST`].
    #[inline(always)]
    pub const fn depth(self) -> u8 {
        (self.0 >> 4) as u8
    }

    /// Which quarter around its corner it is.
    #[inline(always)]
    pub const fn quarter(self) -> u8 {
        self.0 as u8 & 3
    }
}

/// Puts `(s, t)` into the unit triangle. What is not a number becomes 0.
#[inline(always)]
pub fn clamp(s: f64, t: f64) -> (f64, f64) {
    if s >= 0.0 && t >= 0.0 && s + t <= 1.0 { (s, t) } else { clamp_outside(s, t) }
}

#[cold]
fn clamp_outside(s: f64, t: f64) -> (f64, f64) {
    // The maximum with a NaN is the other number. Past 1 a coordinate's size no longer matters.
    let within = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, 2.0) };
    let (s, t) = (within(s), within(t));
    let sum = s + t;
    if sum <= 1.0 { (s, t) } else { (s / sum, t / sum) }
}

/// The piece of a face in which `(s, t)` of its unit triangle lies, as a number (see [`Piece`]), the place
/// in the piece's own coordinates, and how much faster than the face's these run: a power of two, negative
/// where they are turned by half a turn.
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
pub fn in_face(s: f64, t: f64, regular: u64) -> (u64, f64, f64, f64) {
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

    // 0 beside the first edge, 1 beside the second, 2 between.
    let (beside_first, beside_second) = (a > 0.5, b > 0.5);
    let turn = pick(whole, beside_first | beside_second, [1.0, 2.0, -2.0]);
    let shift_a = pick(whole, beside_first, [0.0, -1.0, pick(beside_second, true, [0.0, 1.0, 1.0])]);
    let shift_b = pick(whole, beside_first, [0.0, 0.0, pick(beside_second, true, [-1.0, 1.0, 1.0])]);
    let quarter = pick(whole, beside_first, [3, 0, pick(beside_second, true, [1, 2, 2])]);
    let (x, y) = (a * turn + shift_a, b * turn + shift_b);
    let z = 1.0 - x - y;

    let at_vertex = depth == u64::from(DEEPEST);
    let s_there = pick(at_vertex, first, [0.0, x, pick(second, true, [z, y, y])]);
    let t_there = pick(at_vertex, first, [0.0, y, pick(second, true, [x, z, z])]);
    let there = 16 * depth + 4 * corner + quarter;
    // Of a vertex the tangent plane is taken, along the face.
    let scale_there = if at_vertex { 1.0 } else { doubled * turn };

    let (at_corner, all) = (first | second | third, regular == WHOLE);
    (
        pick(all, at_corner, [Piece::WHOLE.0.into(), there, Piece::MIDDLE.0.into()]),
        pick(all, at_corner, [s, s_there, 1.0 - 2.0 * s]),
        pick(all, at_corner, [t, t_there, 1.0 - 2.0 * t]),
        pick(all, at_corner, [1.0, scale_there, -2.0]),
    )
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
    use crate::subdivision::plain::tests::meshes::Random;

    /// A piece's coordinates run straight along the face's, as fast as it says, and fill its triangle.
    #[test]
    fn pieces_are_scaled_copies_of_the_face() {
        let mut random = Random(5);
        for regular in 0..=WHOLE {
            let mut seen: Vec<Option<[f64; 2]>> = vec![None; 16 * usize::from(DEEPEST + 1)];
            let mut found = 0;
            for i in 0..20_000 {
                let (s, t) = random.place();
                let near = 2_f64.powi(-(i % 5));
                let (s, t) = (s * near, t * near);
                let (piece, x, y, scale) = in_face(s, t, regular);
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
