//! selvedge trims curved surfaces.
