//! A curve carried along a direction onto a surface.

use std::fmt;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use selvedge_components::curve::Curve;
use thiserror::Error;

use crate::closest::{Hit, SurfaceIndex, Walk};

/// Which of the places where a ray passes through the surface is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Pick {
    /// The first from the curve's point in the direction.
    #[default]
    First,
    /// The last in the direction.
    Last,
    /// The nearest to the curve's point, in the direction or against it.
    Nearest,
}

/// Why a curve cannot be projected.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ProjectError {
    /// The direction is no direction.
    #[error("a curve cannot be projected along {direction}")]
    NoDirection {
        /// What was given.
        direction: DVec3,
    },
}

/// The projection of a curve, a plane one say, onto a surface along a direction.
///
/// Nothing is sampled beforehand: each position is the place where the line through the curve's point
/// passes through the surface, to rounding. Where the line misses the surface the position is NaN,
/// which whoever asks under a guard is told as an error with the parameter.
pub struct ProjectedCurve<S> {
    curve: Arc<dyn Curve>,
    direction: DVec3,
    onto: Arc<SurfaceIndex<S>>,
    pick: Pick,
    revision: u64,
}

impl<S: Walk> ProjectedCurve<S> {
    /// Projects `curve` along `direction`, of whatever length.
    ///
    /// # Errors
    /// [`ProjectError::NoDirection`] for a direction that is zero or not finite.
    pub fn new(
        curve: Arc<dyn Curve>,
        direction: DVec3,
        onto: Arc<SurfaceIndex<S>>,
        pick: Pick,
    ) -> Result<Self, ProjectError> {
        let direction = direction.try_normalize().ok_or(ProjectError::NoDirection { direction })?;
        Ok(Self { curve, direction, onto, pick, revision: 0 })
    }

    /// The same projection under another revision: one that rises when the surface has become another.
    #[must_use]
    pub fn with_revision(self, revision: u64) -> Self {
        Self { revision, ..self }
    }

    /// Where the curve's point at `u` is carried to.
    pub fn hit(&self, u: f64) -> Option<Hit> {
        let (from, along) = (self.curve.position(u), self.direction);
        if !from.is_finite() {
            return None;
        }
        let ahead = [0.0, f64::INFINITY];
        match self.pick {
            Pick::First => self.onto.first_hit(from, along, ahead),
            Pick::Last => self.onto.hits(from, along, ahead).pop(),
            Pick::Nearest => {
                let behind = self.onto.first_hit(from, -along, ahead).map(|h| Hit { t: -h.t, ..h });
                match (self.onto.first_hit(from, along, ahead), behind) {
                    (Some(a), Some(b)) if b.t.abs() < a.t.abs() => Some(b),
                    (None, behind) => behind,
                    (ahead, _) => ahead,
                }
            }
        }
    }

    /// The derivative of the projection where the curve's is `velocity`: the move of the surface's
    /// place, `S_s s' + S_t t'`, that stays on the moving line.
    fn carried(&self, u: f64, velocity: DVec3) -> DVec3 {
        let Some(hit) = self.hit(u) else { return DVec3::NAN };
        let jet = self.onto.surface().jet(hit.at);
        let rates = DMat3::from_cols(jet.ds, jet.dt, -self.direction).inverse() * velocity;
        jet.ds * rates.x + jet.dt * rates.y
    }
}

impl<S> fmt::Debug for ProjectedCurve<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ProjectedCurve")
            .field("curve", &self.curve)
            .field("direction", &self.direction)
            .field("pick", &self.pick)
            .field("revision", &self.revision)
            .finish_non_exhaustive()
    }
}

impl<S: Walk> Curve for ProjectedCurve<S> {
    fn position(&self, u: f64) -> DVec3 {
        self.hit(u).map_or(DVec3::NAN, |hit| hit.position)
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.carried(u, self.curve.derivative(u))
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        self.carried(u, self.curve.derivative_before(u))
    }

    /// Those of the curve that is projected: on a smooth surface there are no others.
    fn corners(&self) -> &[f64] {
        self.curve.corners()
    }

    fn closed(&self) -> bool {
        self.curve.closed()
    }

    fn revision(&self) -> u64 {
        self.revision.wrapping_add(self.curve.revision())
    }
}
