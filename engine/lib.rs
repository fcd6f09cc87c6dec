//! selvedge trims curved surfaces.

pub mod io;
