//! Curves in space: what a surface is trimmed by, and what its border can be.

use core::fmt::Debug;

use glam::DVec3;

/// A piecewise smooth curve in space, evaluated at a parameter `u` in [0, 1].
///
/// [`Curve::position`] is all that it takes: a curve is a black box to every stage. An
/// implementation must be a pure function of `u` (the same bits for the same `u`, always), or
/// raise [`Curve::revision`] when it changes.
pub trait Curve: Debug + Send + Sync {
    /// The point at `u` in [0, 1], in model units.
    fn position(&self, u: f64) -> DVec3;

    /// The derivative with respect to `u`, in model units per unit of `u`; one-sided (from the
    /// right, and at 1 from the left) where the curve has a corner.
    ///
    /// By default a difference of fourth order, which stays inside [0, 1] of an open curve.
    fn derivative(&self, u: f64) -> DVec3 {
        difference(self, u)
    }

    /// The parameters inside (0, 1), ascending, where the tangent turns at once; a closed curve
    /// that has a corner where it begins lists 0.
    fn corners(&self) -> &[f64] {
        &[]
    }

    /// Does the curve end where it begins, and run on from there?
    fn closed(&self) -> bool {
        false
    }

    /// Rises whenever the curve has become another one.
    fn revision(&self) -> u64 {
        0
    }
}

/// The derivative by differences of fourth order. The step balances the rounding error of the
/// positions, `1e-16 / h`, against the truncation error, `h^4`.
fn difference<C: Curve + ?Sized>(curve: &C, u: f64) -> DVec3 {
    const STEP: f64 = 1e-3;
    let centre = u.clamp(2.0 * STEP, 1.0 - 2.0 * STEP);
    let at = |k: f64| curve.position(centre + k * STEP);
    (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * STEP)
}

/// placeholder until parameters.rs lands
#[derive(Clone, Debug)]
pub struct CurveParameters {
    #[allow(missing_docs)]
    pub curve: std::sync::Arc<dyn Curve>,
    #[allow(missing_docs)]
    pub u: Vec<f64>,
    #[allow(missing_docs)]
    pub closed: bool,
    #[allow(missing_docs)]
    pub corners: Vec<usize>,
}
impl CurveParameters {
    #[allow(missing_docs)]
    pub fn parameter(&self, l: u32, i: u64) -> f64 {
        self.at(l, i as i64)
    }
    fn is_corner(&self, l: u32, i: i64) -> bool {
        i % (1 << l) == 0
            && ((!self.closed && (i == 0 || i == self.last(l)))
                || self.corners.binary_search(&((i >> l) as usize)).is_ok())
    }
    fn last(&self, l: u32) -> i64 {
        (self.u.len() as i64 - i64::from(!self.closed)) << l
    }
    fn at(&self, l: u32, i: i64) -> f64 {
        let n = self.last(l);
        if self.closed && i < 0 {
            return self.at(l, i + n) - 1.0;
        }
        if self.closed && i >= n {
            return self.at(l, i - n) + 1.0;
        }
        if l == 0 {
            return self.u[i as usize];
        }
        let k = i >> 1;
        if i % 2 != 0 {
            return (self.at(l - 1, k) + self.at(l - 1, k + 1)) / 2.0;
        }
        if self.is_corner(l - 1, k) {
            self.at(l - 1, k)
        } else {
            ((self.at(l - 1, k - 1) + self.at(l - 1, k + 1)) + 6.0 * self.at(l - 1, k)) / 8.0
        }
    }
    #[allow(missing_docs)]
    pub fn sample(&self, l: u32, i: u64) -> DVec3 {
        let (mut l, mut i) = (l, i as i64);
        while l > 0 && i % 2 == 0 {
            l -= 1;
            i /= 2;
        }
        let wrap = |u: f64| if self.curve.closed() { u - u.floor() } else { u };
        if self.is_corner(l, i) {
            return self.curve.position(wrap(self.at(l, i)));
        }
        self.curve.position(wrap(((self.at(l, i - 1) + self.at(l, i + 1)) + 4.0 * self.at(l, i)) / 6.0))
    }
    #[allow(missing_docs)]
    pub fn count(&self, l: u32) -> u64 {
        self.last(l) as u64 + u64::from(!self.closed)
    }
    #[allow(missing_docs)]
    pub fn closed(&self) -> bool {
        self.closed
    }
}
