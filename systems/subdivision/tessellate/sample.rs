//! What is computed at a lattice point.

use glam::DVec3;
use pulp::Arch;
use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::PlainLoop;
use selvedge_components::subdivision::boxspline::Quartic;

use super::grid::Grid;
use crate::subdivision::lanes;

/// One vector at each lattice point.
pub(super) trait Sample: Sync + Send {
    /// At a root vertex.
    fn vertex(&self, surface: &PlainLoop, v: VertexId) -> DVec3;

    /// At the points of `grid` on one polynomial.
    fn piece(&self, quartic: &Quartic, grid: &Grid, out: &mut [DVec3]);
}

/// The limit point.
pub(super) struct Position(pub Arch);

impl Sample for Position {
    fn vertex(&self, surface: &PlainLoop, v: VertexId) -> DVec3 {
        surface.vertex_limit(v)
    }

    fn piece(&self, quartic: &Quartic, grid: &Grid, out: &mut [DVec3]) {
        self.0.dispatch(lanes::Positions { quartic, s: &grid.s, t: &grid.t, points: out });
    }
}

/// The unit normal; zero where there is none. A piece's coordinates are turned and scaled, which the
/// direction of the normal does not see.
pub(super) struct Normal(pub Arch);

impl Sample for Normal {
    fn vertex(&self, surface: &PlainLoop, v: VertexId) -> DVec3 {
        surface.vertex_normal(v)
    }

    fn piece(&self, quartic: &Quartic, grid: &Grid, out: &mut [DVec3]) {
        self.0.dispatch(lanes::Normals { quartic, s: &grid.s, t: &grid.t, normals: out });
    }
}
