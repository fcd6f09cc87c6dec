//! Pictures of what the engine does, drawn in memory and written as PNG, without a window.
//!
//! | module | what |
//! | --- | --- |
//! | [`scene`] | surfaces and lines seen together through a [`camera`]; they hide each other |
//! | [`shade`] | how a surface looks: lit, with its own colours, or by numbers on a [`colourmap`] |
//! | [`overlay`] | wireframes, control cages, borders and curves in space |
//! | [`colourbar`] | the bar beside a picture of numbers |
//! | [`domain`] | cages in the plane of their mean normal: fates, regions, places |
//! | [`plot`] | errors over levels on a logarithmic axis |
//! | [`stencil`] | the weights of a subdivision rule on a piece of mesh |
//! | [`grid`] | several pictures as one figure with captions |
//! | [`canvas`], [`colour`], [`units`] | lines, text and pixels; light and code; numbers with units |
//!
//! The same input gives the same bytes. What cannot be drawn is refused with a [`DiagramError`]
//! that says what and where; nothing panics.
//!
//! [`DiagramError`]: error::DiagramError
//!
//! ```
//! use glam::DVec3;
//! use selvedge::diagram::{camera::{Frame, View}, error::DiagramError, scene::Scene, shade::Surface};
//! use selvedge_components::triangles::Triangles;
//!
//! let tent = Triangles {
//!     positions: vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.5), DVec3::Y],
//!     triangles: vec![[0, 1, 2], [0, 2, 3]],
//!     ..Triangles::default()
//! };
//! let picture = Scene::of(Surface::new(&tent)).picture(&View::from_angles(-60.0, 30.0), Frame::new(320, 240))?;
//! assert_eq!(&picture.png()?[1..4], b"PNG");
//! # Ok::<(), DiagramError>(())
//! ```

pub mod camera;
pub mod canvas;
mod clip;
pub mod colour;
pub mod colourbar;
pub mod colourmap;
pub mod domain;
mod edges;
pub mod error;
mod font;
pub mod grid;
mod labels;
pub mod overlay;
pub mod plot;
mod raster;
pub mod scene;
pub mod shade;
pub mod stencil;
pub mod units;
