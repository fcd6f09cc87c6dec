//! Wavefront OBJ: text, one statement a line.

mod read;
mod write;

pub use read::{ObjError, read};
pub use write::{write, write_cage};
