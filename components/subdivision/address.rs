//! Where a vertex or a face of a subdivided mesh lies on its root mesh.

use bevy_ecs::prelude::Component;

use crate::evaluate::SurfacePoint;
use crate::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId, VertexId};

/// The finest level that addresses can name: 2^30 steps along an edge still fit 32 bits, and 60
/// bits of path leave a root mesh of 16 faces. [`FaceCode::finest`] tells what a larger one allows.
pub const FINEST_LEVEL: u32 = 30;

/// The corners of a face's quarters, in the order of [`FaceCode::child`]: `corners` are the face's own, `middles`
/// those of its edges, from a corner to the next.
///
/// ```
/// # use selvedge_components::subdivision::quartered;
/// assert_eq!(quartered(["a", "b", "c"], ["ab", "bc", "ca"])[1], ["ab", "b", "bc"]);
/// ```
#[inline]
pub fn quartered<T: Copy>([a, b, c]: [T; 3], [ab, bc, ca]: [T; 3]) -> [[T; 3]; 4] {
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// A vertex of the `level`-th regular subdivision of a root mesh.
///
/// Each vertex has exactly one address per level, whatever face it is reached from; addresses
/// sort by kind, then by root element, then by position.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[component(summary_tick)]
pub enum Address {
    /// A vertex of the root mesh.
    Corner(VertexId),
    /// Inside a root edge, `steps` of `2^level` from the end with the smaller vertex id.
    Edge(EdgeId, u32),
    /// Inside a root face: `(i, j)` steps of `2^level` towards its second and third corner.
    Face(FaceId, u32, u32),
}

impl Address {
    /// The address of the lattice point `(i, j)` of `face`, which weighs the corners with
    /// `(n - i - j, i, j) / n` for `n = 2^level`.
    pub fn of(mesh: &Connectivity, level: u32, face: FaceId, i: u32, j: u32) -> Self {
        let n = 1_u32 << level;
        let weights = [n - i - j, i, j];
        if let Some(corner) = weights.iter().position(|&w| w == n) {
            return Self::Corner(mesh.face(face)[corner]);
        }
        // On the edge opposite to the corner of weight zero, which runs from the next corner to
        // the one after.
        if let Some(corner) = weights.iter().position(|&w| w == 0) {
            let h = HalfedgeId::of(face, (corner + 1) % 3);
            let towards_end = weights[(corner + 2) % 3];
            let steps = if mesh.from(h) < mesh.to(h) { towards_end } else { n - towards_end };
            return Self::Edge(mesh.edge(h), steps);
        }
        Self::Face(face, i, j)
    }
}

/// A face of the `level`-th regular subdivision of a root mesh: the root face and the path of
/// quarters that leads to it, two bits a level. Children 0, 1, 2 hold the corner of that number,
/// child 3 is the middle one.
///
/// Codes of one level sort by root face, then along the path: children stand together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceCode(pub u64);

impl FaceCode {
    /// The finest level at which faces of a root mesh of `faces` faces still have codes.
    pub fn finest(faces: usize) -> u32 {
        ((faces.max(1) as u64).leading_zeros() / 2).min(FINEST_LEVEL)
    }

    /// The code of a root face, at level 0.
    pub const fn root(face: FaceId) -> Self {
        Self(face.0 as u64)
    }

    /// The root face of a code of `level`.
    pub const fn root_face(self, level: u32) -> FaceId {
        FaceId((self.0 >> (2 * level)) as u32)
    }

    /// Child `child` (0 to 3), one level finer.
    pub const fn child(self, child: usize) -> Self {
        Self(self.0 << 2 | child as u64)
    }

    /// The face that this one is a quarter of.
    pub const fn parent(self) -> Self {
        Self(self.0 >> 2)
    }

    /// Which quarter of its parent this is.
    pub const fn child_number(self) -> usize {
        (self.0 & 3) as usize
    }

    /// The lattice points `(i, j)` of the three corners in the root face, in steps of `2^-level`.
    pub fn corners(self, level: u32) -> [(u32, u32); 3] {
        let mut corners = [(0, 0), (1, 0), (0, 1)];
        for l in (0..level).rev() {
            let [a, b, c] = corners.map(|(i, j): (u32, u32)| (2 * i, 2 * j));
            let middle = |p: (u32, u32), q: (u32, u32)| (u32::midpoint(p.0, q.0), u32::midpoint(p.1, q.1));
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            // One of `quartered`; to make all of them for one is slower.
            corners = match self.0 >> (2 * l) & 3 {
                0 => [a, ab, ca],
                1 => [ab, b, bc],
                2 => [ca, bc, c],
                _ => [ab, bc, ca],
            };
        }
        corners
    }

    /// The place of the root face where the corners of a face of `level` weigh `weights`, which sum to 1.
    pub fn place(self, level: u32, weights: [f64; 3]) -> SurfacePoint {
        let scale = 1.0 / (1_u64 << level) as f64;
        let corners = self.corners(level).map(|(i, j)| [f64::from(i) * scale, f64::from(j) * scale]);
        let along = |k: usize| (0..3).map(|c| weights[c] * corners[c][k]).sum::<f64>();
        SurfacePoint::new(self.root_face(level), along(0), along(1))
    }

    /// The neighbour across the half-edge that leaves `corner`, at `level`, and the corner that
    /// the twin half-edge leaves there; `None` on a border of the root mesh.
    ///
    /// Half `i` of a parent's half-edge `i` belongs to child `i` (first half) and child `i + 1`
    /// (second half), as its half-edge `i` again; the middle child's half-edge `i` faces child
    /// `i + 1`, whose half-edge `i + 2` it is.
    pub fn across(self, mesh: &Connectivity, level: u32, corner: usize) -> Option<(Self, usize)> {
        if level == 0 {
            let twin = mesh.twin(HalfedgeId(3 * self.0 as u32 + corner as u32))?;
            return Some((Self::root(twin.face()), twin.corner()));
        }
        let (parent, child) = (self.parent(), self.child_number());
        if child == 3 {
            return Some((parent.child((corner + 1) % 3), (corner + 2) % 3));
        }
        if corner == (child + 1) % 3 {
            return Some((parent.child(3), (corner + 1) % 3));
        }
        let first_half = corner == child;
        let (other, twin) = parent.across(mesh, level - 1, corner)?;
        let half = if first_half { (twin + 1) % 3 } else { twin };
        Some((other.child(half), twin))
    }
}
