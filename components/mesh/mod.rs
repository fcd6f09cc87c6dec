//! Triangle connectivity with typed ids. Topology knows no positions.

mod connectivity;
mod edges;
mod faults;
mod ids;
mod orient;

pub use connectivity::{Connectivity, Ring};
pub use faults::{Fault, faults, position_faults};
pub use ids::{EdgeId, FaceId, HalfedgeId, VertexId};
pub use orient::{Oriented, orient};
