//! What happens: selvedge's stages, each a pure kernel and the thin system that runs it.
//!
//! | module | what |
//! | --- | --- |
//! | [`schedule`] | the sets: phases of a pass, stages of a method |
//! | [`enroll`], [`gather`], [`check`] | what every surface goes through first |
//! | [`subdivision`] | the stages of subdivision surfaces |
//! | [`spatial`], [`closest`] | what is near; closest points of surfaces |
//! | [`triangulate`], [`audit`] | triangles out, and measured anew |
//! | [`foot`] | points of a surface below points near it |
//! | [`projected_curve`] | a curve carried onto a surface |
//! | [`target`] | what a surface is fitted to |
//! | [`diagnostics`] | what each stage did, and how long it took |
//! | [`parallel`] | work on many items at once, with the same bits |
//!
//! A stage is a folder (or a file): its kernels, pure functions over slices, and in a file named
//! `system.rs` the system that runs them. Only files of that name know the world.

pub mod audit;
pub mod check;
pub mod closest;
pub mod diagnostics;
pub mod enroll;
pub mod foot;
pub mod gather;
pub mod parallel;
pub mod projected_curve;
pub mod schedule;
pub mod spatial;
pub mod subdivision;
pub mod triangulate;

pub use selvedge_components::target;
