//! Combined Loop surfaces: evaluation in bulk and tessellation.

mod lanes;
pub mod tessellate;
