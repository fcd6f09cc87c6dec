//! Combined Loop subdivision: evaluation in bulk, triangles, and the stages of fitting and trimming.

pub mod chain;
pub mod correspond;
pub mod evaluate;
pub mod fit;
pub mod job;
mod lanes;
pub mod limit;
pub mod modify;
pub mod natural;
mod open;
pub mod quasi;
pub mod refine;
pub mod region;
pub mod relax;
pub mod remesh;
mod rules;
mod system;
pub mod tessellate;
pub mod trim;
pub mod turns;

pub use system::{correspond_fits, modify_fits, refine_fits};

#[cfg(test)]
use selvedge_components::mesh::Connectivity;

/// Meshes of all kinds, the ones that evaluation at a point is tested on.
#[cfg(test)]
#[path = "../../components/subdivision/plain/tests/meshes.rs"]
#[allow(dead_code, reason = "each test uses its own part")]
mod test_meshes;
