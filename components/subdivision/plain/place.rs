//! Where in a face a point lies, as a regular piece and a place in it.

use crate::subdivision::boxspline::Vector;

/// How often a face is quartered towards a vertex at most. What is left there is the limit of the
/// vertex: around it the surface is smaller than the control mesh by the largest eigenvalue below
/// one of any Loop vertex, 5/8, for each level, and `(5/8)^84 < 2^-56` vanishes beside the rounding of
/// the position itself.
pub const DEEPEST: u8 = 84;

/// A part of a face over which the surface is one polynomial, or a single vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// The whole of a regular face.
    Whole,
    /// The middle quarter of a face that is not regular.
    Middle,
    /// A quarter of what is left around `corner` after quartering towards it `depth` times more than
    /// once.
    Corner {
        /// 0, 1 or 2.
        corner: u8,
        /// At least 0, below [`DEEPEST`].
        depth: u8,
        /// Which quarter: 0 and 1 next to the corner's two edges, 2 between.
        quarter: u8,
    },
    /// The vertex at a corner of the face.
    Vertex {
        /// 0, 1 or 2.
        corner: u8,
    },
}

impl Piece {
    /// The corner whose coordinates this piece's follow.
    #[inline(always)]
    pub const fn corner(self) -> u8 {
        match self {
            Self::Corner { corner, .. } | Self::Vertex { corner } => corner,
            Self::Whole | Self::Middle => 0,
        }
    }

    /// How much faster this piece's coordinates run than the corner's: a power of two, negative where
    /// the piece is turned by half a turn.
    #[inline(always)]
    pub const fn scale(self) -> f64 {
        match self {
            Self::Whole | Self::Vertex { .. } => 1.0,
            Self::Middle => -2.0,
            // Built from its exponent: 2^(depth + 2).
            Self::Corner { depth, quarter, .. } => {
                let size = f64::from_bits((1025 + depth as u64) << 52);
                if quarter == 2 { -size } else { size }
            }
        }
    }
}

/// Derivatives by a face's coordinates from those by coordinates that run from `corner` towards the
/// next corner (`a`) and the one after (`b`), `scale` times as fast.
#[inline(always)]
pub fn to_face<V: Vector>(corner: u8, scale: f64, a: V, b: V) -> [V; 2] {
    let (a, b) = (a * scale, b * scale);
    match corner {
        0 => [a, b],
        1 => [b * -1.0, a - b],
        _ => [b - a, a * -1.0],
    }
}

/// A place in a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The piece.
    pub piece: Piece,
    /// The piece's own coordinates, in its unit triangle.
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

/// Which quarter of a face that is not regular holds `(s, t)`: the corner's number, or 3 for the
/// middle; and the weights of the two corners after that corner, or `(s, t)` again.
#[inline(always)]
pub fn quarter_of_face(s: f64, t: f64) -> (u8, f64, f64) {
    // Exact, or off by one rounding of a number no larger than the distance to the corner.
    let r = 1.0 - s - t;
    let r = r.max(0.0);
    let (second, third, first) = (u8::from(s > 0.5), u8::from(t > 0.5), u8::from(s + t < 0.5));
    // Looked up instead of branched to: the quarters of random places cannot be foreseen. At most one
    // of the three is 1.
    let quarter = 3 - 2 * second - third - 3 * first;
    let weights = [r, s, t, r, s, t];
    (quarter, weights[usize::from(quarter) + 1], weights[usize::from(quarter) + 2])
}

/// Which quarter next to a corner holds the place with weights `a` and `b`, together in (1/2, 1].
#[inline(always)]
pub fn quarter_of_corner(a: f64, b: f64) -> u8 {
    // 0 beside the first edge, 1 beside the second, 2 between.
    2_u8.saturating_sub(2 * u8::from(a > 0.5) + u8::from(b > 0.5))
}

/// The coordinates in quarter `quarter` of what has weights `a` and `b` at the corner, and how much
/// faster they run than those weights.
#[inline(always)]
pub fn in_quarter(quarter: u8, a: f64, b: f64) -> (f64, f64, f64) {
    const TURN: [(f64, f64, f64); 3] = [(2.0, -1.0, 0.0), (2.0, 0.0, -1.0), (-2.0, 1.0, 1.0)];
    let (turn, s, t) = TURN[usize::from(quarter)];
    (a * turn + s, b * turn + t, turn)
}

impl Place {
    /// The place of `(s, t)` in a regular face.
    #[inline(always)]
    pub fn in_regular(s: f64, t: f64) -> Self {
        let (s, t) = clamp(s, t);
        Self { piece: Piece::Whole, s, t }
    }

    /// The place of `(s, t)` in a face that is not regular.
    ///
    /// All differences are exact or of one rounding of `1 - s - t`, so a point as near to a corner
    /// as its coordinates can say is found in a piece of its own size.
    pub fn in_irregular(s: f64, t: f64) -> Self {
        let (s, t) = clamp(s, t);
        let (corner, a, b) = quarter_of_face(s, t);
        if corner == 3 {
            return Self { piece: Piece::Middle, s: 1.0 - 2.0 * s, t: 1.0 - 2.0 * t };
        }
        let (mut a, mut b) = (2.0 * a, 2.0 * b);
        for depth in 0..DEEPEST {
            if a + b > 0.5 {
                let quarter = quarter_of_corner(a, b);
                let (s, t, _) = in_quarter(quarter, a, b);
                return Self { piece: Piece::Corner { corner, depth, quarter }, s, t };
            }
            (a, b) = (2.0 * a, 2.0 * b);
        }
        Self { piece: Piece::Vertex { corner }, s: 0.0, t: 0.0 }
    }
}
