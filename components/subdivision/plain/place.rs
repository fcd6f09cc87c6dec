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

    /// How much faster its coordinates run than the face's: a power of two, negative where it is
    /// turned by half a turn.
    #[inline(always)]
    pub const fn scale(self) -> f64 {
        // Looked up, because for random places no branch on what they lie in could be foreseen.
        let turn = [2.0, 2.0, -2.0, 1.0, 2.0, 2.0, -2.0, 1.0, 2.0, 2.0, -2.0, 1.0, -1.0, 0.5, 0.5, 0.5];
        if self.depth() == DEEPEST {
            return 1.0;
        }
        // Built from its exponent: 2^(depth + 1).
        turn[self.0 as usize & 15] * f64::from_bits((1024 + self.depth() as u64) << 52)
    }
}

/// A place in a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The piece.
    pub piece: Piece,
    /// The piece's own coordinates, in its unit triangle. They run along the face's.
    pub s: f64,
    /// As `s`.
    pub t: f64,
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

impl Place {
    /// The place of `(s, t)` in a regular face.
    #[inline(always)]
    pub fn in_regular(s: f64, t: f64) -> Self {
        let (s, t) = clamp(s, t);
        Self { piece: Piece::WHOLE, s, t }
    }

    /// The place of `(s, t)` in a face that is not regular and whose corners are as `regular` says.
    #[inline(always)]
    pub fn in_irregular(s: f64, t: f64, regular: u64) -> Self {
        let (s, t) = clamp(s, t);
        let (piece, s, t) = in_piece(s, t, regular);
        Self { piece: Piece(piece as u16), s, t }
    }
}

/// The piece of a face that is not regular in which `(s, t)` of its unit triangle lies, as a number
/// (see [`Piece`]), and the place there. Bit `i` of `regular` says that corner `i` is regular: all that
/// is left around it after the first quartering is one polynomial.
///
/// All differences are exact or of one rounding of `1 - s - t` or of a weight in the piece, so a point
/// as near to a corner as its coordinates can say is found in a piece of its own size.
///
/// Without a branch, because for random places none could be foreseen, and so that a loop over places
/// is done in lanes.
#[inline(always)]
pub fn in_piece(s: f64, t: f64, regular: u64) -> (u64, f64, f64) {
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
    if first | second | third { (there, s_there, t_there) } else { (12, 1.0 - 2.0 * s, 1.0 - 2.0 * t) }
}

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
        for regular in 0..8 {
            let mut seen: Vec<Option<Place>> = vec![None; 16 * usize::from(DEEPEST + 1)];
            let mut found = 0;
            for i in 0..20_000 {
                let (s, t) = random.place();
                let near = 2_f64.powi(-(i % 5));
                let at = Place::in_irregular(s * near, t * near, regular);
                let size = 1e-15 + f64::EPSILON * at.piece.scale().abs();
                assert!(at.s > -size && at.t > -size && at.s + at.t < 1.0 + size, "{at:?}");
                let origin =
                    Place { s: at.s - at.piece.scale() * s * near, t: at.t - at.piece.scale() * t * near, ..at };
                match seen[at.piece.index()].replace(origin) {
                    Some(o) => assert!((o.s - origin.s).abs() < 4.0 * size && (o.t - origin.t).abs() < 4.0 * size),
                    None => found += 1,
                }
            }
            // Four where every corner is regular; more around each that is not.
            assert_eq!(regular == 7, found == 4, "{found} pieces");
        }
    }
}
