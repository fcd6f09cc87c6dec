//! Files in and out: control cages, triangles, tags.
//!
//! | module | what |
//! | --- | --- |
//! | [`obj`] | Wavefront OBJ: polygons in, triangles out, every double kept |
//! | [`glb`] | binary glTF: triangles in and out (feature `gltf`) |
//! | [`tags`] | corners and creases, in OpenSubdiv's notation |
//! | [`octant`] | meshes of the octant of a sphere |
//!
//! Every reader takes bytes and [`Limits`] and gives [`Polygons`], which promise nothing;
//! [`Cage::from_polygons`] judges them and cuts them into triangles. [`read_cage`] does it all for a
//! path. Whatever a file claims is checked before it is believed: a reader answers with a typed error
//! that names the line or the element, in time that grows with the file and not with its claims.

mod cage;
mod check;
#[cfg(feature = "gltf")]
pub mod glb;
mod limits;
pub mod obj;
pub mod octant;
mod path;
mod polygons;
pub mod tags;
mod triangulate;

pub use cage::{Cage, CageError, Import, PlacedFault};
pub use check::WriteError;
pub use limits::{Limits, TooLarge};
pub use path::{ReadError, read_cage};
pub use polygons::{Place, Polygons, PrimitivePlace, Reading, TooFewSides};
pub use triangulate::{Triangulation, triangulate};
