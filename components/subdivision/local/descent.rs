//! The way from a face into one of its quarters, again and again.

use glam::DVec3;

use crate::evaluate::Jet;

/// A point of a face, seen from ever smaller quarters of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Descent {
    /// The weights of the corners of the quarter reached so far: not negative, with sum 1.
    pub weights: [f64; 3],
    /// The derivatives of the second and third weight by the face's `s`, and by its `t`.
    by_s: [f64; 2],
    by_t: [f64; 2],
}

impl Descent {
    /// Begins at `(s, t)` of a face. What lies outside the face is brought to its rim; what is not a
    /// number becomes 0.
    #[inline]
    pub fn new(s: f64, t: f64) -> Self {
        // `max` prefers the number.
        let (s, t) = (s.max(0.0).min(1.0), t.max(0.0).min(1.0));
        let sum = s + t;
        if sum > 1.0 {
            return Self::from([0.0, s / sum, t / sum]);
        }
        Self::from([1.0 - s - t, s, t])
    }

    /// Goes into the quarter that holds the point and tells which: 0 to 2 at the corners, 3 in the
    /// middle.
    ///
    /// Doubling is exact, and so is taking 1 from what then lies above it: a point as near to a
    /// corner as its coordinates can say stays there.
    #[inline]
    pub fn enter(&mut self) -> usize {
        let [a, b, c] = self.weights;
        if a >= 0.5 {
            self.weights = [2.0 * a - 1.0, 2.0 * b, 2.0 * c];
        } else if b >= 0.5 {
            self.weights = [2.0 * a, 2.0 * b - 1.0, 2.0 * c];
        } else if c >= 0.5 {
            self.weights = [2.0 * a, 2.0 * b, 2.0 * c - 1.0];
        } else {
            self.weights = [1.0 - 2.0 * c, 1.0 - 2.0 * a, 1.0 - 2.0 * b];
            // The middle quarter's second and third weight are 1 - 2 a = 2 (b + c) - 1 and 1 - 2 b.
            let turned = |[s, t]: [f64; 2]| [2.0 * (s + t), -2.0 * s];
            (self.by_s, self.by_t) = (turned(self.by_s), turned(self.by_t));
            return 3;
        }
        let doubled = |[s, t]: [f64; 2]| [2.0 * s, 2.0 * t];
        (self.by_s, self.by_t) = (doubled(self.by_s), doubled(self.by_t));
        if a >= 0.5 {
            0
        } else if b >= 0.5 {
            1
        } else {
            2
        }
    }

    /// Derivatives by the face's coordinates from those by the quarter's.
    #[inline]
    pub fn back(&self, jet: Jet) -> Jet {
        let by = |[s, t]: [f64; 2]| -> DVec3 { jet.ds * s + jet.dt * t };
        Jet { position: jet.position, ds: by(self.by_s), dt: by(self.by_t) }
    }
}

impl From<[f64; 3]> for Descent {
    /// Begins where the corners weigh `weights`, which are not negative and sum to 1.
    fn from(weights: [f64; 3]) -> Self {
        Self { weights, by_s: [1.0, 0.0], by_t: [0.0, 1.0] }
    }
}
