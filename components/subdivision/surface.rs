//! A combined Loop subdivision surface as dense data.

use std::sync::Arc;

use glam::DVec3;

use super::address::Address;
pub use crate::curve::Heading;
use crate::curve::{CurveParameters, RememberedCurve, Traversal};
use crate::mesh::{Connectivity, VertexId};

/// A combined Loop subdivision surface with multiresolution details. [Litke et al. 2001, Section 2]
///
/// Dense and immutable: what a stage reads. The entities are the truth; this is gathered from them.
#[derive(Clone, Debug)]
pub struct LoopSurface {
    /// The faces of the control mesh.
    pub mesh: Arc<Connectivity>,
    /// The control points, in model units. Those on a given border are not read: the curve is.
    pub points: Vec<DVec3>,
    /// Every border edge belongs to exactly one side.
    pub sides: Vec<Side>,
    /// What acts at a corner between two sides.
    pub corner_rule: CornerRule,
    /// Detail coefficients, ascending by level and address.
    pub details: Details,
}

/// A stretch of border from corner to corner, or a whole closed border without one.
#[derive(Clone, Debug)]
pub struct Side {
    /// Its vertices, walked with the surface on the left; a closed side does not repeat the first.
    pub vertices: Vec<VertexId>,
    /// Does it run round, without a corner?
    pub ends: Ends,
    /// What the border is.
    pub border: Border,
}

impl LoopSurface {
    /// A surface whose borders are all plain, with the `corners` that are declared; those that do
    /// not lie on a border mean nothing and are passed over.
    pub fn plain(mesh: Arc<Connectivity>, points: Vec<DVec3>, corners: &[VertexId]) -> Self {
        let sides = plain_sides(&mesh, corners);
        Self { mesh, points, sides, corner_rule: CornerRule::default(), details: Details::default() }
    }

    /// The same surface, whose curves remember what they are asked: faces that meet at a border, the rings
    /// of its vertices and one pass over it after the other ask for the same points. To be dropped before a
    /// curve may change. See [`RememberedCurve`].
    #[must_use]
    pub fn remembering(&self) -> Self {
        let mut surface = self.clone();
        let mut known: Vec<(Arc<CurveParameters>, Arc<CurveParameters>)> = Vec::new();
        for side in &mut surface.sides {
            let Border::Given { curve, .. } = &mut side.border else { continue };
            let same = known.iter().find(|(of, _)| Arc::ptr_eq(of, curve)).map(|(_, remembers)| Arc::clone(remembers));
            let remembers = same.unwrap_or_else(|| {
                let remembers = Arc::new(curve.over(Arc::new(RememberedCurve::new(Arc::clone(curve.curve())))));
                known.push((Arc::clone(curve), Arc::clone(&remembers)));
                remembers
            });
            *curve = remembers;
        }
        surface
    }
}

/// The borders of `mesh` as plain sides, cut at the `corners`; by border loop, then along it.
pub fn plain_sides(mesh: &Connectivity, corners: &[VertexId]) -> Vec<Side> {
    let mut declared = vec![false; mesh.vertex_count()];
    for corner in corners {
        if let Some(slot) = declared.get_mut(corner.index()) {
            *slot = true;
        }
    }
    let mut sides = Vec::new();
    for mut walk in mesh.border_loops() {
        let Some(first) = walk.iter().position(|v| declared[v.index()]) else {
            sides.push(Side { vertices: walk, ends: Ends::Closed, border: Border::Plain });
            continue;
        };
        walk.rotate_left(first);
        walk.push(walk[0]);
        let mut begin = 0;
        for end in 1..walk.len() {
            if declared[walk[end].index()] {
                let vertices = walk[begin..=end].to_vec();
                sides.push(Side { vertices, ends: Ends::Corners, border: Border::Plain });
                begin = end;
            }
        }
    }
    sides
}

impl Side {
    /// How many edges it has on the root mesh.
    pub fn edge_count(&self) -> usize {
        self.vertices.len() - usize::from(self.ends == Ends::Corners)
    }

    /// The index in its curve's parameters of the place `step` steps of `level` from the side's
    /// first vertex; `None` on a plain side.
    pub fn curve_index(&self, level: u32, step: u64) -> Option<u64> {
        let Border::Given { curve, first, heading } = &self.border else { return None };
        Some(Traversal { first: *first, heading: *heading }.vertex(curve, level, step))
    }
}

/// Whether a side runs round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// From one corner to another, or back to the same one.
    Corners,
    /// Round, without a corner.
    Closed,
}

/// What the limit surface's border is along one side.
#[derive(Clone, Debug)]
pub enum Border {
    /// The cubic B-spline of the border's control points: Loop's own border.
    Plain,
    /// Exactly this curve.
    Given {
        /// The curve and its parameters, which it owns: all surfaces along it read the same.
        curve: Arc<CurveParameters>,
        /// The index in `curve` of the side's first vertex.
        first: u64,
        /// Which way the side walks along the curve.
        heading: Heading,
    },
}

/// What acts on the interior edges that start at a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum CornerRule {
    /// Regular lattice weights wherever the valence allows (2 and 3 convex; 5 and 6 concave, drawn
    /// towards a quadratic that is exact for quadratics), gamma without flatness elsewhere.
    #[default]
    Lattice,
    /// gamma and flatness as printed in [Litke et al. 2001, Section 2.1].
    Seed,
}

/// Detail coefficients by level. Level 0 may have details too.
///
/// An interior detail is added to the control point of its vertex; one on a given border is
/// subtracted where the vertex is read, and decays by 1/4 per level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Details {
    /// For each level, `(address, vector)` ascending by address.
    pub levels: Vec<Vec<(Address, DVec3)>>,
}

impl Details {
    /// The detail at `address` of `level`; zero where none is stored.
    pub fn at(&self, level: u32, address: Address) -> DVec3 {
        let Some(stored) = self.levels.get(level as usize) else { return DVec3::ZERO };
        stored.binary_search_by_key(&address, |d| d.0).map_or(DVec3::ZERO, |i| stored[i].1)
    }

    /// How many vectors are stored, over all levels.
    pub fn count(&self) -> usize {
        self.levels.iter().map(Vec::len).sum()
    }

    /// One more than the finest level that has a detail; 0 where there is none.
    pub fn depth(&self) -> u32 {
        self.levels.iter().rposition(|l| !l.is_empty()).map_or(0, |l| l as u32 + 1)
    }
}
