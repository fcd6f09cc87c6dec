//! Loop surfaces with plain borders and without details: exact at any place, in closed form nearly
//! everywhere.
//!
//! A face whose corners are regular is one polynomial ([`Quartic`]). Any other face falls into
//! infinitely many such polynomials: its middle quarter, and around each corner the quarters that
//! subdivision towards that corner leaves behind ([`Piece`]). A point lies in one of them, and few
//! steps of the corner's neighbourhood lead there, so no value is approximated.

mod fan;
mod limit;
mod patch;
mod place;
mod topology;

use std::sync::Arc;

use glam::DVec3;

pub use limit::vertex_normal;
pub use patch::PatchReader;
pub use place::{Piece, Place};
pub use topology::{PlainError, PlainTopology, VertexRule};

use super::boxspline::Quartic;
use crate::evaluate::{Evaluate, Jet, SurfacePoint};
use crate::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId, VertexId};
use fan::edge_point;

/// A Loop surface without details whose borders, if any, are cubic B-splines.
///
/// Holds what moves with the control points: the points, and where faces are not regular also those
/// of one subdivision step, which separates irregular vertices from each other.
#[derive(Clone, Debug)]
pub struct PlainLoop {
    topology: Arc<PlainTopology>,
    points: Vec<DVec3>,
    /// Vertices and edge midpoints one step finer, by root vertex and root edge; zero where no face
    /// needs them.
    vertices: Vec<DVec3>,
    edges: Vec<DVec3>,
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
        let (vertices, edges) = (topology.mesh().vertex_count(), topology.mesh().edge_count());
        check(&points, vertices)?;
        let (vertices, edges) = (vec![DVec3::ZERO; vertices], vec![DVec3::ZERO; edges]);
        let mut surface = Self { topology, points, vertices, edges };
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

    fn take_first_step(&mut self) {
        let topology = Arc::clone(&self.topology);
        let mesh = topology.mesh();
        for v in (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| topology.is_stepped(v)) {
            self.vertices[v.index()] = self.stepped_vertex(v);
        }
        for e in (0..mesh.edge_count()).map(EdgeId::new) {
            let h = mesh.halfedge(e);
            if topology.is_stepped(mesh.from(h)) || topology.is_stepped(mesh.to(h)) {
                self.edges[e.index()] = self.stepped_edge(h);
            }
        }
    }

    fn stepped_vertex(&self, v: VertexId) -> DVec3 {
        let (mesh, q) = (self.topology.mesh(), self.point(v));
        match self.topology.rule(v) {
            VertexRule::Interior => {
                let k = mesh.valence(v) as usize;
                let w = self.topology.mask(k).step;
                let sum = mesh.ring(v).fold(DVec3::ZERO, |sum, h| sum + self.point(mesh.to(h)));
                q * (1.0 - k as f64 * w) + sum * w
            }
            VertexRule::Border => {
                let [next, previous] = self.border_neighbours(v);
                (next + previous) * 0.125 + q * 0.75
            }
            VertexRule::Corner => q,
        }
    }

    fn stepped_edge(&self, h: HalfedgeId) -> DVec3 {
        let mesh = self.topology.mesh();
        let (a, b) = (self.point(mesh.from(h)), self.point(mesh.to(h)));
        match mesh.twin(h) {
            Some(twin) => edge_point(a, b, self.point(mesh.opposite(h)), self.point(mesh.opposite(twin))),
            None => (a + b) * 0.5,
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
        PatchReader::new(self).jet(at)
    }
}

/// The polynomial of a regular face, and that of any piece of another.
impl PlainLoop {
    /// The polynomial of `face` where [`PlainTopology::is_regular`].
    #[inline]
    pub fn quartic(&self, face: FaceId) -> Option<Quartic> {
        self.topology.is_regular(face).then(|| Quartic::new(&self.regular_net(face)))
    }
}

#[cfg(test)]
mod tests;
