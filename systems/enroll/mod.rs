//! # Enroll: whatever needs an order gets a number
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | `Cage`, `SpaceCurve`, `Fit`, `Trim` | `Serial` where there is none | - | the gathering |
//!
//! Why: a host spawns surfaces, curves and jobs as it likes, and everything that shows an order
//! asks for their serials. Those that arrive between two passes are numbered in the order of their
//! entities, the one order that they have.

mod system;

pub use system::enroll;
