//! Combined Loop subdivision: masks, borders, details, evaluation.

mod address;
mod corner;
mod level;
pub mod masks;
mod stencil;
mod surface;

pub use address::{Address, FINEST_LEVEL, FaceCode};
pub use corner::{CornerTable, Pull, SpecialCorner, interior_angle};
pub use level::{GivenVertex, Kind, LevelMesh, LevelVertex, NONE, Origin, RingState, SideEnd};
pub use stencil::{LevelState, LimitRows, Rows, Step};
pub use surface::{Border, CornerRule, Details, Ends, Heading, LoopSurface, Side, plain_sides};
