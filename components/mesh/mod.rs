//! Triangle connectivity with typed ids. Topology knows no positions.

mod connectivity;
mod faults;
mod ids;

pub use connectivity::{Connectivity, Ring};
pub use faults::{Fault, Oriented, faults, orient, position_faults};
pub use ids::{EdgeId, FaceId, HalfedgeId, VertexId};
