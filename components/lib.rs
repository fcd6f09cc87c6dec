//! What is: the plain data that selvedge's entities carry, and how it evaluates at a point.
//!
//! | module | what |
//! | --- | --- |
//! | [`mesh`] | triangle connectivity with typed ids, and everything that can be wrong with it |
//! | [`curve`] | curves in space, black boxes allowed |
//! | [`subdivision`] | combined Loop subdivision: masks, borders, details, evaluation |
//! | [`evaluate`] | what every surface can be asked |
//! | [`identity`] | what orders entities when order shows |
//! | [`job`], [`target`] | work that takes many passes, where it stands, and what a surface is fitted to |
//! | [`trim`] | what is cut away, and what came of it |
//! | [`tolerance`], [`budget`] | how exact, and at what cost |
//! | [`error`], [`report`], [`triangles`] | what comes out |
//! | [`triangulation`], [`audit`] | triangles asked for, and measured by someone else |
//! | [`guard`] | calls of user code, kept from doing harm |

pub mod audit;
pub mod budget;
pub mod curve;
pub mod error;
pub mod evaluate;
pub mod guard;
pub mod identity;
pub mod job;
pub mod mesh;
pub mod report;
pub mod subdivision;
pub mod target;
pub mod tolerance;
pub mod triangles;
pub mod triangulation;
pub mod trim;
