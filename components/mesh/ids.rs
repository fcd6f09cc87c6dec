//! Every index has a type.

use core::fmt;

macro_rules! id {
    ($(#[$doc:meta])* $name:ident, $letter:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
        #[repr(transparent)]
        pub struct $name(pub u32);

        impl $name {
            /// The id of the `index`-th element.
            ///
            /// Meshes of more than `u32::MAX` elements are refused before any id is made.
            #[inline]
            pub const fn new(index: usize) -> Self {
                debug_assert!(index <= u32::MAX as usize);
                Self(index as u32)
            }

            /// The position of this element in every array that runs over its kind.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($letter, "{}"), self.0)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}", self.0)
            }
        }
    };
}

id!(
    /// A vertex of one mesh; prints as `v7`.
    VertexId, "v"
);
id!(
    /// An undirected edge of one mesh; prints as `e7`.
    EdgeId, "e"
);
id!(
    /// A triangle of one mesh; prints as `f7`.
    FaceId, "f"
);
id!(
    /// A half-edge of one mesh: `3 f + i` runs from corner `i` to corner `i + 1` of face `f`.
    HalfedgeId, "h"
);

impl HalfedgeId {
    /// The half-edge that leaves corner `corner` (0, 1 or 2) of `face`.
    #[inline]
    pub const fn of(face: FaceId, corner: usize) -> Self {
        Self(3 * face.0 + corner as u32)
    }

    /// The face on the left.
    #[inline]
    pub const fn face(self) -> FaceId {
        FaceId(self.0 / 3)
    }

    /// The corner (0, 1 or 2) of [`Self::face`] that this half-edge leaves.
    #[inline]
    pub const fn corner(self) -> usize {
        (self.0 % 3) as usize
    }

    /// The next half-edge around the face.
    #[inline]
    pub const fn next(self) -> Self {
        Self(if self.0 % 3 == 2 { self.0 - 2 } else { self.0 + 1 })
    }

    /// The previous half-edge around the face.
    #[inline]
    pub const fn previous(self) -> Self {
        Self(if self.0.is_multiple_of(3) { self.0 + 2 } else { self.0 - 1 })
    }
}
