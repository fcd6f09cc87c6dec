//! Binary glTF 2.0 (GLB): a JSON scene and one buffer of numbers in single precision.
//!
//! The crate `gltf` frames the container and `gltf-json` gives the scene its types. The scene is then
//! walked here and not through `gltf::Document`, whose accessors trust indices, offsets and counts
//! and panic where a file lies about them.

mod accessor;
mod error;
mod read;
mod scene;
mod write;

pub use error::GlbError;
pub use read::{Extras, Weld, extras, read};
pub use write::{Glb, Object, ObjectReport, write};
