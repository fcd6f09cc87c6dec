//! Ready-made scenes: the ones that the demo, the examples and the tests share.

pub mod limit;
#[cfg(feature = "diagram")]
pub mod limit_pictures;
pub mod octant;
#[cfg(feature = "diagram")]
pub mod octant_pictures;
#[cfg(feature = "diagram")]
pub mod stencil_pictures;
pub mod stencils;
#[cfg(feature = "diagram")]
pub mod trim_pictures;
pub mod trims;
