//! Pictures of what the engine does, drawn in memory and written as PNG, without a window.
pub mod camera;
pub mod canvas;
mod clip;
pub mod colour;
pub mod colourbar;
pub mod colourmap;
pub mod error;
mod font;
pub mod grid;
pub mod overlay;
pub mod plot;
mod raster;
pub mod scene;
pub mod shade;
pub mod stencil;
pub mod units;
