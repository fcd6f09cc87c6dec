//! What a surface is fitted to: anything that knows its closest point.

use core::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use thiserror::Error;

/// A point of a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// The point, in model units.
    pub position: DVec3,
    /// Where it lies on the target, if the target has addresses.
    pub at: Option<SurfacePoint>,
}

/// Why a target gave no point.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TargetError {
    /// The target's answer was NaN or infinite.
    #[error("the target has no finite point closest to {to}: it answered {answer}")]
    NotFinite {
        /// What was asked for.
        to: DVec3,
        /// What came back.
        answer: DVec3,
    },
    /// The host's projection panicked.
    #[error("the target's projection panicked at {to}")]
    Panicked {
        /// What was asked for.
        to: DVec3,
    },
}

/// A surface that is fitted to, and measured against.
pub trait Target: fmt::Debug + Send + Sync {
    /// The closest point to `to`; `hint` is where an earlier, nearby question was answered, and
    /// may limit the search.
    ///
    /// # Errors
    /// When there is no finite answer.
    fn closest(&self, to: DVec3, hint: Option<SurfacePoint>) -> Result<Foot, TargetError>;
}

/// A projection given by a closure: an implicit surface, say, or one that is not the engine's own.
pub struct Projection<F>(pub F);

impl<F> fmt::Debug for Projection<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Projection")
    }
}

impl<F: Fn(DVec3) -> DVec3 + Send + Sync> Target for Projection<F> {
    fn closest(&self, to: DVec3, _: Option<SurfacePoint>) -> Result<Foot, TargetError> {
        // The closure is the host's: whatever state it leaves behind by panicking is its own.
        let answer = catch_unwind(AssertUnwindSafe(|| (self.0)(to))).map_err(|_| TargetError::Panicked { to })?;
        if answer.is_finite() {
            Ok(Foot { position: answer, at: None })
        } else {
            Err(TargetError::NotFinite { to, answer })
        }
    }
}
