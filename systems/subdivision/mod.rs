//! Combined Loop subdivision: evaluation in bulk, triangles, and the stages of fitting and trimming.

pub mod chain;
pub mod correspond;
pub mod evaluate;
pub mod fit;
pub mod job;
mod lanes;
pub mod limit;
pub mod modify;
pub mod quasi;
pub mod refine;
pub mod region;
pub mod relax;
pub mod remesh;
mod system;
pub mod tessellate;

pub use system::{correspond_fits, modify_fits, refine_fits};
