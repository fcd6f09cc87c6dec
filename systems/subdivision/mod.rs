//! Combined Loop subdivision: the stages of fitting and trimming.

pub mod chain;
pub mod correspond;
pub mod evaluate;
pub mod fit;
mod lanes;
pub mod modify;
pub mod quasi;
pub mod refine;
pub mod region;
pub mod tessellate;
