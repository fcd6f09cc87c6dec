//! What happens: selvedge's stages, each a pure kernel and the thin system that runs it.
//!
//! | module | what |
//! | --- | --- |
//! | [`subdivision`] | evaluation and tessellation of combined Loop surfaces |

mod parallel;
pub mod subdivision;
