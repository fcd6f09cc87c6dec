//! Any closure as a curve: a black box that gives positions and nothing else.

use core::fmt;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use super::Curve;

/// A curve whose positions a closure gives. What else there is to know of it can be stated:
/// that it is closed, where its corners are ([`find_corners`](super::find_corners) finds them),
/// and its revision.
///
/// ```
/// use core::f64::consts::TAU;
/// use glam::DVec3;
/// use selvedge_components::curve::{Curve, FnCurve};
///
/// let wave = FnCurve::new(|u| DVec3::new((TAU * u).cos(), (TAU * u).sin(), (3.0 * TAU * u).sin())).closed();
/// assert!((wave.derivative(0.0) - DVec3::new(0.0, TAU, 3.0 * TAU)).length() < 1e-8);
/// ```
pub struct FnCurve<F> {
    position: F,
    closed: bool,
    corners: Vec<f64>,
    revision: AtomicU64,
}

impl<F: Fn(f64) -> DVec3 + Send + Sync> FnCurve<F> {
    /// The open curve without corners, of revision 0, at `position(u)` for `u` in [0, 1].
    pub fn new(position: F) -> Self {
        Self { position, closed: false, corners: Vec::new(), revision: AtomicU64::new(0) }
    }

    /// The same, stated to end where it begins and to run on from there.
    #[must_use]
    pub fn closed(mut self) -> Self {
        self.closed = true;
        self
    }

    /// The same, with corners as in [`Curve::corners`]; [`faults`](super::faults) tells what is
    /// wrong with them.
    #[must_use]
    pub fn with_corners(mut self, corners: Vec<f64>) -> Self {
        self.corners = corners;
        self
    }

    /// The same, of another revision.
    #[must_use]
    pub fn with_revision(self, revision: u64) -> Self {
        self.set_revision(revision);
        self
    }

    /// States that the closure gives another curve from now on. A revision only ever rises:
    /// a smaller one than before is ignored.
    pub fn set_revision(&self, revision: u64) {
        self.revision.fetch_max(revision, Ordering::AcqRel);
    }
}

impl<F: Fn(f64) -> DVec3 + Send + Sync> Curve for FnCurve<F> {
    fn position(&self, u: f64) -> DVec3 {
        (self.position)(u)
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        self.closed
    }

    fn revision(&self) -> u64 {
        self.revision.load(Ordering::Acquire)
    }
}

impl<F> fmt::Debug for FnCurve<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FnCurve")
            .field("closed", &self.closed)
            .field("corners", &self.corners)
            .field("revision", &self.revision)
            .finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    #[test]
    fn it_is_used_as_an_object_and_says_what_was_stated() {
        let curve = FnCurve::new(DVec3::splat).closed().with_corners(vec![0.0, 0.5]).with_revision(7);
        let curve: Arc<dyn Curve> = Arc::new(curve);
        assert_eq!(curve.position(0.25), DVec3::splat(0.25));
        assert_eq!((curve.closed(), curve.corners(), curve.revision()), (true, [0.0, 0.5].as_slice(), 7));
        assert!(format!("{curve:?}").contains("revision: 7"));
    }

    #[test]
    fn a_revision_only_rises() {
        let curve = FnCurve::new(|_| DVec3::ZERO);
        curve.set_revision(3);
        curve.set_revision(2);
        assert_eq!(curve.revision(), 3);
    }
}
