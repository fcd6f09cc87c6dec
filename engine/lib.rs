//! selvedge trims curved surfaces.
//!
//! Surfaces, control points, curves and jobs are entities of a [`bevy_ecs`] world; what is edited is
//! found, and only what depends on it is done again. A host [`install`]s the engine into a world and
//! schedule of its own, or takes an [`Engine`], which is the same in a box. Nothing needs a window.
//!
//! ```
//! use std::sync::Arc;
//! use selvedge::mesh::Connectivity;
//! use selvedge::subdivision::fit::FitOptions;
//! use selvedge::{DVec3, Engine, Progress, Projection};
//!
//! // An octahedron, whose limit surface is to be the unit sphere.
//! let points = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
//! let faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
//! let mesh = Arc::new(Connectivity::new(6, &faces).expect("an octahedron has no fault"));
//!
//! let mut engine = Engine::new();
//! let cage = engine.spawn_cage(mesh, &points);
//! let sphere = Arc::new(Projection(|p: DVec3| p.normalize()));
//! let fit = engine.spawn_fit(cage, sphere, FitOptions { last_level: 2, ..FitOptions::default() });
//! engine.settle().expect("every stage has its system");
//!
//! let Some(Progress::Finished(report)) = engine.progress(fit) else { panic!("the fit has failed") };
//! assert!(report.ladder[2].max < 2e-3 && report.ladder[2].max < report.ladder[0].max);
//! ```

mod bake;
pub mod cli;
#[cfg(feature = "diagram")]
pub mod diagram;
mod engine;
mod install;
pub mod io;
#[cfg(feature = "bevy_app")]
mod plugin;
pub mod scenes;
mod spawn;

pub use bake::{BakeError, bake};
pub use engine::{Engine, Pass, Progress, SelvedgePass, Stalled, TrimProgress};
pub use install::{install, strict};
#[cfg(feature = "bevy_app")]
pub use plugin::SelvedgePlugin;
pub use spawn::{
    cancel_fit, despawn_surface, spawn_cage, spawn_curve, spawn_fit, spawn_surface, spawn_trim, tell_pre_image,
};

pub use bevy_ecs;
pub use glam::{self, DVec3};
pub use selvedge_components::target::{Projection, Target};
pub use selvedge_components::{
    audit, budget, curve, error, evaluate, guard, identity, job, mesh, report, subdivision, target, tolerance,
    triangles, triangulation, trim,
};
pub use selvedge_systems::triangulate::Triangulating;
pub use selvedge_systems::{diagnostics, schedule};

/// The program in the README is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
