//! Files in and out: what is read is what was written, and cages are what the files say.

mod cages;
#[cfg(feature = "gltf")]
mod glb;
mod obj;
mod octant;
mod tags;
mod triangulation;

#[cfg(feature = "gltf")]
#[path = "../support/glb.rs"]
mod by_hand;
