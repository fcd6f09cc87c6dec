//! Calls of user code, kept from doing harm.

use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec3;
use thiserror::Error;

/// User code did not give a point.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CallError {
    /// It panicked.
    #[error("it panicked: {message}")]
    Panicked {
        /// What the panic said.
        message: String,
    },
    /// It gave a point that is NaN or infinite.
    #[error("it gave {value}, which is not finite")]
    NotFinite {
        /// What it gave.
        value: DVec3,
    },
}

/// Calls user code for a point, and turns a panic or a point that is not finite into an error.
///
/// Costs a few nanoseconds beside the call. A host built with `panic = "abort"` aborts all the
/// same. State that the user code itself left broken stays so; nothing of ours is touched by it.
///
/// # Errors
/// [`CallError`], when there is no finite point.
///
/// ```
/// # use selvedge_components::guard::{CallError, guarded};
/// # use glam::DVec3;
/// assert_eq!(guarded(|| DVec3::X), Ok(DVec3::X));
/// assert!(matches!(guarded(|| DVec3::NAN), Err(CallError::NotFinite { .. })));
/// ```
pub fn guarded(call: impl FnOnce() -> DVec3) -> Result<DVec3, CallError> {
    let value = caught(call).map_err(|message| CallError::Panicked { message })?;
    if value.is_finite() { Ok(value) } else { Err(CallError::NotFinite { value }) }
}

/// Runs `work`, and gives the message of the panic that ended it, if one did.
///
/// # Errors
/// What the panic said. Whatever `work` was changing must be thrown away then.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        let text = payload.downcast_ref::<&str>().map(ToString::to_string);
        text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_that_says_what_the_panic_said() {
        let plain = guarded(|| panic!("out of curve"));
        assert_eq!(plain, Err(CallError::Panicked { message: "out of curve".into() }));
        let formatted = guarded(|| panic!("no point at {}", 0.5));
        assert_eq!(formatted, Err(CallError::Panicked { message: "no point at 0.5".into() }));
    }

    #[test]
    fn infinity_is_no_point() {
        let value = DVec3::new(0.0, f64::INFINITY, 0.0);
        assert_eq!(guarded(|| value), Err(CallError::NotFinite { value }));
    }
}
