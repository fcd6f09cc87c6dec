//! # Triangulate: a limit surface becomes triangles
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | `Snapshot`, [`TriangulateOptions`], `Tolerance` | [`Triangles`] and [`TriangulationReport`], or [`TriangulationFailed`] | `Solve` | `Audit` |
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
mod check;
pub mod closure;
mod forest;
mod grow;
mod inner;
mod measure;
mod names;
mod reach;
mod sample;
mod system;
mod vertices;

use std::sync::Arc;

use selvedge_components::budget::Budgets;
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::triangles::Triangles;
pub use selvedge_components::triangulation::{
    ChordReport, Density, Normals, TriangulateError, TriangulateOptions, TriangulationFailed, TriangulationReport,
};

use forest::Forest;
pub use system::triangulate_surfaces;

pub(crate) use measure::{shape, squared_to_segment, squared_to_triangle};
use reach::Reach;

use crate::subdivision::limit::{LimitError, LimitSurface};

/// A triangulated surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Triangulation {
    /// The vertices and triangles.
    pub triangles: Triangles,
    /// What came out.
    pub report: TriangulationReport,
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

/// The options as a surface with this tolerance, in a world with these budgets, means them.
pub fn effective(options: &TriangulateOptions, tolerance: Option<&Tolerance>, budgets: &Budgets) -> TriangulateOptions {
    let most = usize::try_from(budgets.triangles).unwrap_or(usize::MAX);
    TriangulateOptions {
        density: tolerance.map_or(options.density, |tolerance| Density::Chord(tolerance.chord)),
        most_triangles: options.most_triangles.min(most),
        ..*options
    }
}

/// A surface and what every pass over it reads.
struct Subject {
    surface: Arc<LoopSurface>,
    limit: LimitSurface,
    reach: Reach,
}

impl Subject {
    fn new(surface: &LoopSurface) -> Result<Self, TriangulateError> {
        // A copy of the control points and details: little beside the triangles they make.
        let surface = Arc::new(surface.remembering());
        Ok(Self {
            limit: LimitSurface::new(Arc::clone(&surface)).map_err(unreadable)?,
            reach: Reach::new(&surface.mesh, &surface.details),
            surface,
        })
    }
}

fn unreadable(why: LimitError) -> TriangulateError {
    match why {
        LimitError::PointCount { points, vertices } => TriangulateError::PointCount { points, vertices },
        LimitError::NotFinite { vertex, at } => TriangulateError::PointNotFinite { vertex, at },
        LimitError::TooFine { level, faces, finest } => TriangulateError::TooFine { level, faces, finest },
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
