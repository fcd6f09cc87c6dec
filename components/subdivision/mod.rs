//! Combined Loop subdivision: masks, borders, details, evaluation.

mod address;
pub mod masks;
mod surface;

pub use address::{Address, FINEST_LEVEL, FaceCode};
pub use surface::{Border, CornerRule, Details, Ends, Heading, LoopSurface, Side};
