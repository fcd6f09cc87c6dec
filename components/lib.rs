//! What is: the plain data that selvedge's entities carry, and how it evaluates at a point.
//!
//! | module | what |
//! | --- | --- |
//! | [`mesh`] | triangle connectivity with typed ids, and everything that can be wrong with it |
//! | [`curve`] | curves in space, black boxes allowed |
//! | [`subdivision`] | combined Loop subdivision: masks, borders, details, evaluation |
//! | [`evaluate`] | what every surface can be asked |
//! | [`tolerance`], [`triangles`] | how exact, and what comes out |

pub mod curve;
pub mod evaluate;
pub mod mesh;
pub mod subdivision;
pub mod tolerance;
pub mod triangles;
