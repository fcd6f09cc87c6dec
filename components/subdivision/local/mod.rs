//! The limit surface at one place, whatever lies around it: details above, given and plain borders,
//! corners, irregular vertices.
//!
//! A vertex with its neighbours is a [`Ring`]; a face with the rings of its corners is a [`Patch`].
//! Every rule of the scheme reads one ring, so a patch can be quartered again and again without
//! anything else. Where all three rings are regular and away from given borders the surface is one
//! polynomial; where they are not, quartering leads to such a polynomial, to a vertex or to the
//! border curve itself.

mod descent;
mod lattice;
mod patch;
mod ring;
mod tangents;

pub use descent::Descent;
pub use lattice::PatchLattice;
pub use patch::Patch;
pub use ring::Ring;
pub use tangents::Tangents;

use super::corner::CornerTable;
use super::level::{LevelMesh, RingState};
use super::stencil::LevelState;
use super::surface::LoopSurface;
use glam::DVec3;

/// What the rules of a surface need besides control points.
#[derive(Clone, Copy, Debug)]
pub struct Scheme<'a> {
    /// The surface: its sides are read.
    pub surface: &'a LoopSurface,
    /// Its special corners.
    pub corners: &'a CornerTable,
}

/// The limit surface at a vertex of a level mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LimitFrame {
    /// The limit position.
    pub position: DVec3,
    /// The tangents.
    pub tangents: Tangents,
}

impl LimitFrame {
    /// The unit normal, outward for counter-clockwise faces; zero where there is none.
    pub fn normal(&self) -> DVec3 {
        self.tangents.normal()
    }
}

/// The limit position and tangents at vertex `v` of `mesh`; `None` where its ring is cut.
///
/// `state` must hold the last details that there are around `v`: the limit is that of subdivision
/// without any more. Positions are those of [`LimitRows`](super::LimitRows) up to rounding, and on
/// a given border the curve's sample to the bit.
pub fn limit_frame(scheme: Scheme<'_>, mesh: &LevelMesh, state: &LevelState, v: u32) -> Option<LimitFrame> {
    if mesh.vertices[v as usize].ring == RingState::Cut {
        return None;
    }
    let ring = Ring::of(scheme, mesh, state, v);
    Some(LimitFrame { position: ring.limit(scheme), tangents: ring.tangents(scheme) })
}
