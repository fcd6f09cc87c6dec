//! Combined Loop subdivision: masks, borders, details, evaluation.

mod address;
mod border;
pub mod boxspline;
mod corner;
mod deviation;
mod entities;
pub mod fit;
mod lattice;
mod level;
mod local;
pub mod masks;
pub mod plain;
pub mod remesh;
mod stencil;
mod surface;

pub use address::{Address, FINEST_LEVEL, FaceCode, quartered};
pub use corner::{CornerTable, Pull, SpecialCorner, interior_angle};
pub use deviation::{Deviation, QuarterPoints};
pub use entities::{
    Cage, ControlPointIndex, ControlPointOf, ControlPoints, Detail, DetailLevel, DetailOf, Position, Sides, Snapshot,
};
pub use lattice::{Lattice, TooFine};
pub use level::{
    BorderStep, GivenVertex, Kind, LevelMesh, LevelVertex, NONE, Origin, Quartered, RingState, SideEnd, next, previous,
    sample as border_sample,
};
pub use local::{Descent, LimitFrame, Patch, PatchLattice, Ring, Scheme, Tangents, limit_frame};
pub use plain::{PlainError, PlainLoop, PlainTopology, VertexRule};
pub use stencil::{LevelState, LimitRows, Rows, Step};
pub use surface::{Border, CornerRule, Details, Ends, Heading, LoopSurface, Side, plain_sides};
