//! Combined Loop subdivision: masks, borders, details, evaluation.

mod address;
pub mod boxspline;
mod corner;
mod level;
pub mod masks;
pub mod plain;
mod stencil;
mod surface;

pub use address::{Address, FINEST_LEVEL, FaceCode};
pub use corner::{CornerTable, Pull, SpecialCorner, interior_angle};
pub use level::{GivenVertex, Kind, LevelMesh, LevelVertex, NONE, Origin, RingState, SideEnd};
pub use plain::{PlainError, PlainLoop, PlainTopology, VertexRule};
pub use stencil::{LevelState, LimitRows, Rows, Step};
pub use surface::{Border, CornerRule, Details, Ends, Heading, LoopSurface, Side};
