//! One tolerance, in model units, shared out to where it is spent.

use bevy_ecs::prelude::Component;

use crate::identity::same_number;

/// How far results may stand off, in model units. Each part is a bound on a distance.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// A fitted or trimmed limit surface to the limit surface it stands for.
    pub fit: f64,
    /// Triangles to the limit surface.
    pub chord: f64,
    /// How far a given curve may lie off the surface; reported beside the error.
    pub curve: f64,
}

impl Tolerance {
    /// Is this what was asked for before? See [`same_number`].
    pub fn same_as(&self, other: &Self) -> bool {
        same_number(self.fit, other.fit) && same_number(self.chord, other.chord) && same_number(self.curve, other.curve)
    }

    /// As [`Self::same_as`], where there may be none.
    pub fn same_option(a: Option<Self>, b: Option<Self>) -> bool {
        a.zip(b).map_or(a.is_none() && b.is_none(), |(a, b)| a.same_as(&b))
    }

    /// Shares one overall bound out: 0.6 to the fit, 0.3 to the chords, 0.1 to the curve.
    ///
    /// ```
    /// # use selvedge_components::tolerance::Tolerance;
    /// let t = Tolerance::total(1e-5);
    /// assert!((t.fit + t.chord + t.curve - 1e-5).abs() < 1e-20);
    /// ```
    pub const fn total(eps: f64) -> Self {
        Self { fit: 0.6 * eps, chord: 0.3 * eps, curve: 0.1 * eps }
    }
}
