//! What happens: selvedge's stages, each a pure kernel and the thin system that runs it.

pub mod parallel;
pub mod subdivision;
pub mod target;
