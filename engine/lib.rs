//! selvedge trims curved surfaces.

#[cfg(feature = "diagram")]
pub mod diagram;
