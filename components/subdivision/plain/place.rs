//! Where in a face a point lies, as a regular piece and a place in it.

use glam::DVec3;

use super::fan::Quarter;
use crate::evaluate::Jet;

/// How often a face is quartered towards a vertex at most. What is left there is the limit of the
/// vertex: around it the surface is smaller than the control mesh by the largest eigenvalue below
/// one of any Loop vertex, 5/8, for each level, and `(5/8)^84 < 2^-56` vanishes beside the rounding of
/// the position itself.
pub(super) const DEEPEST: u32 = 84;

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
        /// At least 0.
        depth: u8,
        /// Which quarter: 0 and 1 at the ends of the two spokes, 2 between.
        quarter: u8,
    },
    /// The vertex at a corner of the face.
    Vertex {
        /// 0, 1 or 2.
        corner: u8,
    },
}

impl Piece {
    /// Orders the pieces of one face so that each is reached from those before it in few steps.
    #[inline]
    pub const fn rank(self) -> u32 {
        match self {
            Self::Whole => 0,
            Self::Middle => 1,
            Self::Vertex { corner } => 2 + corner as u32,
            Self::Corner { corner, depth, quarter } => 5 + 9 * depth as u32 + 3 * corner as u32 + quarter as u32,
        }
    }

    /// The piece of this rank.
    #[inline]
    pub const fn of_rank(rank: u32) -> Self {
        match rank {
            0 => Self::Whole,
            1 => Self::Middle,
            2..=4 => Self::Vertex { corner: rank as u8 - 2 },
            _ => {
                let (depth, place) = ((rank - 5) / 9, (rank - 5) % 9);
                Self::Corner { corner: (place / 3) as u8, depth: depth as u8, quarter: (place % 3) as u8 }
            }
        }
    }

    /// The corner whose coordinates this piece's follow.
    #[inline]
    pub const fn corner(self) -> u8 {
        match self {
            Self::Corner { corner, .. } | Self::Vertex { corner } => corner,
            Self::Whole | Self::Middle => 0,
        }
    }

    /// How much faster this piece's coordinates run than the corner's: a power of two, negative where
    /// the piece is turned by half a turn.
    #[inline]
    pub fn scale(self) -> f64 {
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

    pub(super) const QUARTERS: [Quarter; 3] = [Quarter::First, Quarter::Second, Quarter::Middle];
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
pub(super) fn clamp(s: f64, t: f64) -> (f64, f64) {
    let (s, t) = (s.max(0.0), t.max(0.0));
    let sum = s + t;
    if sum <= 1.0 {
        (s, t)
    } else if sum.is_finite() {
        (s / sum, t / sum)
    } else {
        // Infinity or overflow: the far edge, shared between those that are too large.
        let (s, t) = (s.min(1.0), t.min(1.0));
        (s / (s + t), t / (s + t))
    }
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
    #[inline(always)]
    pub fn in_irregular(s: f64, t: f64) -> Self {
        let (s, t) = clamp(s, t);
        let r = 1.0 - s - t;
        if s > 0.5 {
            Self::around(1, t, r)
        } else if t > 0.5 {
            Self::around(2, r, s)
        } else if s + t < 0.5 {
            Self::around(0, s, t)
        } else {
            Self { piece: Piece::Middle, s: 1.0 - 2.0 * s, t: 1.0 - 2.0 * t }
        }
    }

    /// The place with weights `a` and `b`, together at most 1/2, on the two corners after `corner`.
    #[inline(always)]
    fn around(corner: u8, a: f64, b: f64) -> Self {
        let (mut a, mut b) = (2.0 * a.max(0.0), 2.0 * b.max(0.0));
        let mut depth = 0;
        while a + b <= 0.5 {
            if depth == DEEPEST {
                return Self { piece: Piece::Vertex { corner }, s: 0.0, t: 0.0 };
            }
            (a, b) = (2.0 * a, 2.0 * b);
            depth += 1;
        }
        let piece = |quarter| Piece::Corner { corner, depth: depth as u8, quarter };
        if a > 0.5 {
            Self { piece: piece(0), s: 2.0 * a - 1.0, t: 2.0 * b }
        } else if b > 0.5 {
            Self { piece: piece(1), s: 2.0 * a, t: 2.0 * b - 1.0 }
        } else {
            Self { piece: piece(2), s: 1.0 - 2.0 * a, t: 1.0 - 2.0 * b }
        }
    }
}

impl Piece {
    /// Derivatives by the face's coordinates from those by the piece's own.
    #[inline(always)]
    pub fn to_face(self, jet: Jet) -> Jet {
        let scale = self.scale();
        let (ds, dt) = turn(self.corner(), jet.ds * scale, jet.dt * scale);
        Jet { position: jet.position, ds, dt }
    }
}

/// Derivatives by the face's `s` and `t` from those from `corner` towards the next corner (`a`) and
/// the one after (`b`).
#[inline(always)]
pub(super) fn turn(corner: u8, a: DVec3, b: DVec3) -> (DVec3, DVec3) {
    match corner {
        0 => (a, b),
        1 => (-b, a - b),
        _ => (b - a, -a),
    }
}
