//! # Remesh: a cage that ends at the curves
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the source, details and all; directed curves | the new cage, or what stands against it | check | relax |
//!
//! Steps, each a kernel of its own: [`preimage`] finds where the curves run, [`adapt`] makes the cage
//! fine enough there, [`closure`] makes it conforming, [`remove`] takes away what lies on the right,
//! [`attach`] lays a strip of triangles between the rest and each curve, [`relax`](super::relax)
//! spaces its vertices, `settle` moves those of thin triangles, [`cleanup`] mends valences, and [`assemble`] makes a surface of it.
//! [Litke et al. 2001, Section 3.1] [`work`] runs them, a quantum at a time.
//!
//! Everything is measured in space, on the limit surface, but only over connected ground; so cages
//! of any shape will do. Where two boundaries come too near to each other for the cage, the curves
//! that need it are taken a level finer and the whole is done again.

pub mod adapt;
pub mod arrange;
pub mod assemble;
pub mod attach;
mod borders;
pub mod cleanup;
pub mod closure;
pub mod contour;
mod crossing;
mod cusps;
pub mod field;
mod fineness;
pub mod hints;
pub mod junction;
mod laid;
pub mod leaves;
pub mod other;
pub mod path;
pub mod preimage;
pub mod remove;
mod room;
mod seats;
mod sets;
mod settle;
mod sides;
mod stretch;
mod strip_parameters;
pub mod track;
pub mod winding;
pub mod work;

#[cfg(test)]
pub(crate) mod tests;

use std::collections::HashMap;
use std::sync::Arc;

use selvedge_components::curve::{Curve, Heading};
use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::LoopSurface;
pub use selvedge_components::subdivision::remesh as error;
use selvedge_components::trim::Omega;

pub use adapt::AdaptOptions;
pub use assemble::{FaceOrigin, Remeshed, SideOrigin, VertexOrigin};
pub use error::{PreImageError, RemeshError};
pub use fineness::Fineness;
pub use hints::Hints;
pub use junction::JunctionOptions;
pub use other::OtherSide;
pub use preimage::{Extent, PathPoint, PreImage, TraceOptions, trace, trace_near, trace_parts};
pub use remove::Fate;
pub use winding::Beyond;
pub use work::{RelaxQuantum, RemeshQuantum, RemeshWork};

use super::relax::RelaxOptions;
use arrange::Arrangement;
use closure::{Adapted, Part};
use leaves::Leaves;
use remove::{Remains, Trouble};
use track::Track;

/// One directed curve that cuts: what lies on its left stays.
#[derive(Clone, Debug)]
pub struct Cut {
    /// The curve.
    pub curve: Arc<dyn Curve>,
    /// Which way it is walked.
    pub heading: Heading,
    /// The set of curves that it belongs to, such as those of one trim. The curves of one set are
    /// one border together, with islands in holes; of several sets the common part stays.
    pub set: u32,
}

impl Cut {
    /// A curve of the first set.
    pub const fn new(curve: Arc<dyn Curve>, heading: Heading) -> Self {
        Self { curve, heading, set: 0 }
    }

    /// The same curve in another set.
    #[must_use]
    pub fn of_set(&self, set: u32) -> Self {
        Self { set, ..self.clone() }
    }
}

/// How a cage is remeshed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemeshOptions {
    /// How fine the cage becomes.
    pub adapt: AdaptOptions,
    /// The part of its size that a triangle's corner must be away from a curve to stay: the room
    /// for the strip.
    pub margin: f64,
    /// How the strip settles.
    pub relax: RelaxOptions,
    /// The faces that are fitted, and beyond which nothing changes.
    pub omega: Omega,
    /// How far from the curves these may reach, in model units. The whole cage is refined first as often
    /// as that takes.
    pub reach: Option<f64>,
    /// What is asked of the places where curves cross.
    pub junctions: JunctionOptions,
    /// How often the cage is made finer where boundaries come too near to each other.
    pub tries: u32,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        Self {
            adapt: AdaptOptions::default(),
            margin: 0.3,
            relax: RelaxOptions::default(),
            omega: Omega::Neighbourhood,
            reach: None,
            junctions: JunctionOptions::default(),
            tries: 12,
        }
    }
}

/// Cuts `surface` along curves, whose pre-images on it are given in the order of the curves. A curve
/// that leaves the surface and comes back is one cut for each part, with the same curve.
///
/// This is [`RemeshWork`], run to its end.
///
/// # Errors
/// When there is no curve, a curve is open, the curves do not separate what stays from what goes,
/// nothing stays, or boundaries come too near to each other; see [`RemeshError`].
pub fn remesh(
    surface: impl Into<Arc<LoopSurface>>,
    cuts: &[Cut],
    preimages: &[PreImage],
    options: &RemeshOptions,
) -> Result<Remeshed, RemeshError> {
    run(&mut RemeshWork::new(surface.into(), cuts.to_vec(), preimages.to_vec(), *options)?)
}

fn run(work: &mut RemeshWork) -> Result<Remeshed, RemeshError> {
    loop {
        while work.advance()? == RemeshQuantum::More {}
        loop {
            match work.relax()? {
                RelaxQuantum::More => {}
                RelaxQuantum::Again => break,
                RelaxQuantum::Finished(remeshed) => return Ok(*remeshed),
            }
        }
    }
}

/// All that the last stage reads.
struct Work<'a> {
    options: &'a RemeshOptions,
    surface: &'a LoopSurface,
    cuts: &'a [Cut],
    plan: &'a Arrangement,
    leaves: &'a Leaves,
    adapted: &'a Adapted,
    remains: &'a Remains,
    strips: &'a [attach::Strip],
    /// By strip.
    parameters: Vec<strip_parameters::StripParameters>,
}

impl Work<'_> {
    /// The curve that a knot of a strip lies on, of two the one that goes on from there.
    fn curve_of(&self, strip: u32, knot: u32) -> u32 {
        let contour = &self.plan.contours[self.strips[strip as usize].cut as usize];
        contour.spans[self.parameters[strip as usize].spots[knot as usize].span as usize].cut
    }
}

fn manifold(vertices: usize, triangles: &[[u32; 3]]) -> Result<Connectivity, Trouble> {
    Connectivity::new(vertices, triangles).map_err(|faults| Trouble::Error(RemeshError::NotManifold { faults }))
}

/// The triangles that segments cross, with the segments. Of a leaf in several triangles all count.
fn crossed(adapted: &Adapted, track: &Track, leaves: &Leaves) -> Vec<(u32, u32)> {
    let mut first = HashMap::new();
    for (f, piece) in adapted.sources.iter().enumerate() {
        first.entry((piece.level, piece.leaf)).or_insert(f as u32);
    }
    let mut crossed = Vec::new();
    // Segments that run through leaves of a level alone cross none of a finer one.
    let mut within = vec![true; track.points.len()];
    for level in 0..=leaves.finest() {
        let visits = track.visits(level, |segment| within[segment as usize]);
        within = track.having(&visits, |visit| leaves.is_split(level, visit.code));
        for visit in visits {
            let Some(&begin) = first.get(&(level, visit.code)) else { continue };
            let own = adapted.sources[begin as usize..].iter();
            let count = own.take_while(|p| (p.level, p.leaf) == (level, visit.code)).count() as u32;
            crossed.extend((begin..begin + count).map(|f| (f, visit.segment)));
        }
    }
    crossed.dedup();
    crossed
}

impl Part {
    /// Is it all of its leaf?
    pub fn is_whole(self) -> bool {
        self == Self::Whole
    }
}
