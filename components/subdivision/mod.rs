//! Combined Loop subdivision: masks, borders, details, evaluation.

mod address;
pub mod boxspline;
mod lattice;
pub mod masks;
pub mod plain;
mod surface;

pub use address::{Address, FINEST_LEVEL, FaceCode};
pub use lattice::{Lattice, TooFine};
pub use plain::{PlainError, PlainLoop, PlainTopology, VertexRule};
pub use surface::{Border, CornerRule, Details, Ends, Heading, LoopSurface, Side};
