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
//!
//! *Steps.* The work is cut into steps by what there is to do, not by the clock ([`TriangulationWork`]). A pass
//! takes as many as cost [`SPENT_A_PASS`]: a small surface has its triangles in the pass that it asks in, a
//! large one in a later pass, and until then those that it had.

mod assemble;
mod bound;
mod check;
pub mod closure;
mod forest;
mod grow;
mod inner;
mod known;
mod measure;
mod names;
mod reach;
mod sample;
mod system;
mod vertices;
mod work;

use std::sync::Arc;

use selvedge_components::budget::Budgets;
use selvedge_components::subdivision::LoopSurface;
use selvedge_components::tolerance::Tolerance;
use selvedge_components::triangles::Triangles;
pub use selvedge_components::triangulation::{
    ChordReport, Density, Normals, TriangulateError, TriangulateOptions, TriangulationFailed, TriangulationReport,
};

pub use system::{Triangulating, triangulate_surfaces};
pub use work::{TriangulationState, TriangulationWork};

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
    TriangulationWork::new(surface, options)?.finish()
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
#[derive(Debug)]
struct Subject {
    surface: Arc<LoopSurface>,
    limit: LimitSurface,
    reach: Reach,
}

/// What a pass spends on one surface at least, unless it is done before, in units of
/// [`TriangulationWork::spent`]: some milliseconds on one core.
pub const SPENT_A_PASS: usize = 3 * QUANTUM;

/// What a step costs, where the work can be cut as finely.
const QUANTUM: usize = 1 << 12;

/// What a face or a vertex costs that does not lie within one polynomial, beside one that does.
const DEAR: usize = 4;

/// The end of the next items from `first` on, of `count`, that are a [`QUANTUM`] together, and what they cost: each
/// what `cost` says, and one.
fn quantum(first: usize, count: usize, cost: impl Fn(usize) -> usize) -> (usize, usize) {
    let (mut end, mut spent) = (first, 0);
    while end < count && spent < QUANTUM {
        spent += 1 + cost(end);
        end += 1;
    }
    (end, spent)
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
    // Points that are not finite are another fault.
    let sizes = surface.points.iter().map(|p| p.abs().max_element()).filter(|size| size.is_finite());
    let size = sizes.fold(0.0, f64::max);
    // A limit point is a sum of a dozen rounded products, its distance to a triangle one more.
    let least = 32.0 * f64::EPSILON * size;
    if chord < least { Err(TriangulateError::ChordBelowRounding { chord, least }) } else { Ok(()) }
}

fn within_budget(triangles: usize, options: &TriangulateOptions) -> Result<(), TriangulateError> {
    // Half-edges of a level, some 1.3 times the faces that come out, have 32-bit names.
    let limit = options.most_triangles.min(1 << 29);
    if triangles > limit { Err(TriangulateError::TooManyTriangles { triangles, limit }) } else { Ok(()) }
}
