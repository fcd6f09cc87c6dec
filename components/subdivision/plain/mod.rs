//! Loop surfaces with plain borders and without details: exact at any place, in closed form nearly
//! everywhere.
//!
//! A face whose corners are regular is one polynomial ([`Quartic`](super::boxspline::Quartic)). Any other face falls into
//! infinitely many pieces: its middle quarter, one polynomial again, and around each corner the bands that
//! subdivision towards that corner leaves behind ([`Band`]). A point lies in one of them, and few
//! steps of the corner's neighbourhood lead there, so no value is approximated.

mod band;
mod block;
mod corner;
mod finer;
mod limit;
mod patch;
pub mod place;
mod topology;

use std::sync::Arc;

use glam::DVec3;

pub use band::{Band, Bands};
pub use corner::CornerPieces;
pub use finer::UsualFace;
pub use limit::vertex_normal;
pub use patch::{AsStored, Load, PatchReader};
pub use place::Piece;
pub use topology::{PlainError, PlainTopology, VertexRule};

use crate::evaluate::{Evaluate, Jet, SurfacePoint};
use crate::mesh::{Connectivity, VertexId};
use block::Blocks;

/// A Loop surface without details whose borders, if any, are cubic B-splines.
///
/// Holds what moves with the control points: the points, and where faces are not regular also those
/// of one subdivision step, which separates irregular vertices from each other.
#[derive(Clone, Debug)]
pub struct PlainLoop {
    topology: Arc<PlainTopology>,
    points: Vec<DVec3>,
    /// The points of one subdivision step around the corners of faces that are not regular.
    finer: Blocks,
}

impl PlainLoop {
    /// The surface of `mesh` with control points `points`; its borders are smooth but for `corners`.
    ///
    /// # Errors
    /// Those of [`PlainTopology::new`] and [`PlainLoop::on`].
    pub fn new(mesh: Arc<Connectivity>, points: Vec<DVec3>, corners: &[VertexId]) -> Result<Self, PlainError> {
        Self::on(Arc::new(PlainTopology::new(mesh, corners)?), points)
    }

    /// The surface with control points `points` on a known topology.
    ///
    /// # Errors
    /// [`PlainError::PointCount`], [`PlainError::NotFinite`].
    pub fn on(topology: Arc<PlainTopology>, points: Vec<DVec3>) -> Result<Self, PlainError> {
        check(&points, topology.mesh().vertex_count())?;
        let finer = Blocks::new(topology.finer_count());
        let mut surface = Self { topology, points, finer };
        surface.take_first_step();
        Ok(surface)
    }

    /// Moves the control points.
    ///
    /// # Errors
    /// As [`PlainLoop::on`]; the surface is unchanged then.
    pub fn move_points(&mut self, points: &[DVec3]) -> Result<(), PlainError> {
        check(points, self.points.len())?;
        self.points.copy_from_slice(points);
        self.take_first_step();
        Ok(())
    }

    /// What does not change when control points move.
    pub fn topology(&self) -> &Arc<PlainTopology> {
        &self.topology
    }

    /// The control points.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The control point of `v`.
    #[inline]
    pub fn point(&self, v: VertexId) -> DVec3 {
        self.points[v.index()]
    }

    /// The unit normal at `at`; zero where the surface has none.
    pub fn normal(&self, at: SurfacePoint) -> DVec3 {
        let Some(&corners) = self.topology.mesh().faces().get(at.face.index()) else { return DVec3::ZERO };
        let (s, t) = place::clamp(at.st.x, at.st.y);
        let weights = [1.0 - s - t, s, t];
        match weights.iter().position(|&w| w == 1.0) {
            Some(corner) => self.vertex_normal(corners[corner]),
            None => self.jet(at).normal(),
        }
    }

    /// Fills the blocks of finer points, each from the ring of its vertex alone.
    fn take_first_step(&mut self) {
        let topology = &*self.topology;
        let mesh = topology.mesh();
        let (mut ring, mut scratch) = (Vec::new(), Vec::new());
        for v in (0..mesh.vertex_count()).map(VertexId::new) {
            if let Some(block) = topology.block(v) {
                ring.clear();
                ring.extend(mesh.neighbours(v).map(|n| self.points[n.index()]));
                let around = (self.points[v.index()], &ring[..]);
                self.finer.write(block, topology.mask(ring.len()), topology.rule(v), around, &mut scratch);
            }
        }
    }
}

fn check(points: &[DVec3], vertices: usize) -> Result<(), PlainError> {
    if points.len() != vertices {
        return Err(PlainError::PointCount { points: points.len(), vertices });
    }
    match points.iter().position(|p| !p.is_finite()) {
        Some(i) => Err(PlainError::NotFinite { vertex: VertexId::new(i), at: points[i] }),
        None => Ok(()),
    }
}

impl Evaluate for PlainLoop {
    fn face_count(&self) -> usize {
        self.topology.mesh().face_count()
    }

    /// Exact to rounding. Derivatives near a vertex that is not regular are as exact relative to
    /// their own size, which vanishes or grows as a power of the distance; at the vertex itself they
    /// are [`PlainLoop::vertex_tangents`]. A face that does not exist gives NaN.
    fn jet(&self, at: SurfacePoint) -> Jet {
        self.jet_at(at)
    }
}

#[cfg(test)]
mod tests;
