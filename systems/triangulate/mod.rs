//! # Triangulate: a limit surface becomes triangles
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | a surface with its details, `Tolerance` | [`Triangles`] and a [`TriangulationReport`] | refine | audit |
//!
//! The triangles come from a forest: each root face is quartered, and its quarters again, until a
//! leaf lies close enough to the limit surface ([`Density::Chord`]) or is of the level asked for
//! ([`Density::Level`]). Neighbouring leaves differ by one level at most, and a leaf that has a
//! finer neighbour is cut so that it meets the neighbour's vertices ([`closure`]): no vertex lies
//! inside an edge. Every vertex stands at its limit position; on a given border that is the curve's
//! own sample, bit for bit.
//!
//! *Numbering.* Vertices ascend by where they stand on the root mesh: root vertices in their order,
//! then for each root edge the vertices inside it, from the end with the smaller vertex id, then for
//! each root face the vertices inside it, by `s` and then by `t`. Triangles ascend by root face,
//! then along the path of quarters. Two triangulations of one surface give a vertex that both have
//! the same bits, whatever their densities.

mod adapt;
mod assemble;
pub mod closure;
mod forest;
mod measure;
mod pyramid;
mod reach;
mod sample;

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::{CornerTable, FaceCode, LoopSurface};
use selvedge_components::triangles::Triangles;
use thiserror::Error;

use forest::Forest;
pub(crate) use measure::{shape, squared_to_segment, squared_to_triangle};
use reach::Reach;

use crate::subdivision::limit::{LimitError, LimitSurface};

/// How a surface is triangulated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangulateOptions {
    /// How fine.
    pub density: Density,
    /// The finest level of leaves when the density is a chord; or the finest that addresses allow, if
    /// that is coarser.
    pub last_level: u32,
    /// The most triangles that may come out.
    pub most_triangles: usize,
    /// Whether vertices get the normals of the limit surface.
    pub normals: Normals,
}

impl Default for TriangulateOptions {
    /// Level 3, with normals.
    fn default() -> Self {
        Self { density: Density::Level(3), last_level: 16, most_triangles: 16_000_000, normals: Normals::OfLimit }
    }
}

/// How fine a triangulation is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Every root face is quartered this many times.
    Level(u32),
    /// Every root face is quartered where it takes that to keep this distance, in model units,
    /// between the triangles and the limit surface.
    Chord(f64),
}

/// Whether vertices get normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normals {
    /// Unit normals of the limit surface.
    OfLimit,
    /// None.
    Without,
}

/// A triangulated surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangulation {
    /// The vertices and triangles.
    pub triangles: Triangles,
    /// The root face that each triangle lies on.
    pub faces: Vec<FaceId>,
    /// What came out.
    pub report: TriangulationReport,
}

/// What a triangulation has come to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangulationReport {
    /// Leaves of each level; those of the coarsest first.
    pub leaves: Vec<usize>,
    /// The least `2 area / longest^2` over all triangles: 0.866 is equilateral, 0 degenerate.
    pub worst_shape: f64,
    /// The chord, where one was asked for.
    pub chord: Option<ChordReport>,
}

/// How far the triangles stand off the limit surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChordReport {
    /// What was asked for, in model units.
    pub asked: f64,
    /// The greatest distance found between the finished triangles and points of the limit surface,
    /// other ones than those that decided where to refine.
    pub achieved: f64,
    /// The point of the limit surface where it was found.
    pub at: DVec3,
    /// How many points were measured.
    pub samples: usize,
    /// Leaves of the last level that stand off further than asked; 0 unless `achieved > asked`.
    pub failing: usize,
}

impl ChordReport {
    /// Is the distance that was asked for kept everywhere?
    pub fn kept(&self) -> bool {
        self.failing == 0
    }
}

/// Why a surface was not triangulated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TriangulateError {
    /// The chord is not a positive number.
    #[error("the chord {chord} is not a positive distance")]
    BadChord {
        /// What was asked for.
        chord: f64,
    },
    /// The chord is below what the coordinates can hold.
    #[error("the chord {chord} is below {least}, the rounding of coordinates of this size")]
    ChordBelowRounding {
        /// What was asked for.
        chord: f64,
        /// The least that can be asked for.
        least: f64,
    },
    /// The level is finer than faces of this mesh can be addressed.
    #[error("level {level} is finer than the finest that {faces} root faces allow, {finest}")]
    TooFine {
        /// What was asked for.
        level: u32,
        /// Root faces.
        faces: usize,
        /// The finest possible.
        finest: u32,
    },
    /// The surface cannot be evaluated.
    #[error(transparent)]
    Limit(#[from] LimitError),
    /// A point of the limit surface is NaN or infinite: a curve or a detail is.
    #[error("the limit surface is not finite on {face}: {at}")]
    LimitNotFinite {
        /// The root face.
        face: FaceId,
        /// The point.
        at: DVec3,
    },
    /// There would be more triangles than allowed.
    #[error("there would be {triangles} triangles or more, and {limit} are allowed")]
    TooManyTriangles {
        /// How many there would be at least.
        triangles: usize,
        /// How many there may be.
        limit: usize,
    },
}

/// Triangulates the limit surface of `surface`, details and all.
///
/// Costs time and memory in proportion to the triangles that come out and the details that are
/// stored. A chord that the last level does not keep is no error: [`ChordReport::failing`] says so.
///
/// # Errors
/// When the options cannot be met or the surface is not finite.
pub fn triangulate(surface: &LoopSurface, options: &TriangulateOptions) -> Result<Triangulation, TriangulateError> {
    let subject = Subject::new(surface)?;
    let faces = surface.mesh.face_count();
    let finest = FaceCode::finest(faces);
    match options.density {
        Density::Level(level) if level > finest => Err(TriangulateError::TooFine { level, faces, finest }),
        Density::Level(level) => {
            // Codes of this level fit 64 bits, so their number does.
            within_budget(faces << (2 * level), options)?;
            Ok(assemble::assemble(&subject, &Forest::uniform(faces, level), options.normals)?.finish())
        }
        Density::Chord(chord) => {
            check_chord(surface, chord)?;
            let options = TriangulateOptions { last_level: options.last_level.min(finest), ..*options };
            adapt::adapt(&subject, chord, &options)
        }
    }
}

/// A surface and what every pass over it reads.
struct Subject<'a> {
    surface: &'a LoopSurface,
    corners: CornerTable,
    limit: LimitSurface,
    reach: Reach,
}

impl<'a> Subject<'a> {
    fn new(surface: &'a LoopSurface) -> Result<Self, LimitError> {
        Ok(Self {
            // A copy of the control points and details: little beside the triangles they make.
            limit: LimitSurface::new(Arc::new(surface.clone()))?,
            corners: CornerTable::new(surface),
            reach: Reach::new(&surface.mesh, &surface.details),
            surface,
        })
    }
}

fn check_chord(surface: &LoopSurface, chord: f64) -> Result<(), TriangulateError> {
    if !(chord.is_finite() && chord > 0.0) {
        return Err(TriangulateError::BadChord { chord });
    }
    let size = surface.points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    // A limit point is a sum of a dozen rounded products, its distance to a triangle one more.
    let least = 32.0 * f64::EPSILON * size;
    if chord < least { Err(TriangulateError::ChordBelowRounding { chord, least }) } else { Ok(()) }
}

fn within_budget(triangles: usize, options: &TriangulateOptions) -> Result<(), TriangulateError> {
    // Half-edges of a level, some 1.3 times the faces that come out, have 32-bit names.
    let limit = options.most_triangles.min(1 << 29);
    if triangles > limit { Err(TriangulateError::TooManyTriangles { triangles, limit }) } else { Ok(()) }
}

#[cfg(test)]
mod tests;
