//! Combined Loop subdivision: the stages of fitting and trimming.

pub mod chain;
pub mod correspond;
pub mod fit;
pub mod modify;
pub mod quasi;
pub mod refine;
pub mod region;
pub mod relax;
pub mod remesh;
