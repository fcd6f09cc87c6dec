//! # Check: every fault named and placed, before anything is done
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | `Snapshot` | `SurfaceFailed` and no `Snapshot`, where there is a fault | `Gather` | `Solve` |
//! | `SpaceCurve` | `CurveFailed`, where there is a fault; `CurveUnchecked` while it waits | `Gather` | `Solve` |
//!
//! Why: a kernel that may rely on what it reads is short and fast. What is refused here has no
//! snapshot, so nothing goes further with it; all its faults are told at once, so that they can be
//! mended at once.

mod curve;
mod surface;
mod system;

pub use curve::curve_faults;
pub use surface::{surface_faults, value_faults};
pub use system::{Checked, Sound, check_curves, check_surfaces};
