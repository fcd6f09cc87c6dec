//! selvedge trims curved surfaces.

#[cfg(feature = "diagram")]
pub mod diagram;
pub mod io;
pub mod scenes;
