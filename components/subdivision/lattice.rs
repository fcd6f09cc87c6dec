//! The vertices of a uniformly subdivided mesh, numbered without a table.

use thiserror::Error;

use super::address::{Address, FINEST_LEVEL};
use crate::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId, VertexId};

/// A mesh at this level has more vertices than 32 bits can number.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("level {level} of this mesh has {vertices} vertices; {limit} can be numbered")]
pub struct TooFine {
    /// The level asked for.
    pub level: u32,
    /// How many vertices it has; the level's own limit is [`FINEST_LEVEL`].
    pub vertices: u128,
    /// How many there may be.
    pub limit: u32,
}

/// Numbers the vertices that `2^level` steps along every edge give a mesh, in the order of their
/// [`Address`]: root vertices, then edge by edge, then face by face.
///
/// Along an edge numbers rise from the end with the smaller vertex id. In a face they rise with `i`
/// and, for equal `i`, with `j`, the steps towards its second and third corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lattice {
    level: u32,
    vertices: u32,
    edges: u32,
    faces: u32,
}

impl Lattice {
    /// The numbering of level `level` of `mesh`.
    ///
    /// # Errors
    /// [`TooFine`] when 32 bits do not hold it or the level is above [`FINEST_LEVEL`].
    pub fn new(mesh: &Connectivity, level: u32) -> Result<Self, TooFine> {
        let steps = 1_u128 << level.min(FINEST_LEVEL + 1);
        let inside = (steps - 1) * (steps.max(2) - 2) / 2;
        let count = [(mesh.vertex_count(), 1), (mesh.edge_count(), steps - 1), (mesh.face_count(), inside)];
        let vertices: u128 = count.iter().map(|&(n, each)| n as u128 * each).sum();
        if vertices > u128::from(u32::MAX) || level > FINEST_LEVEL {
            return Err(TooFine { level, vertices, limit: u32::MAX });
        }
        let [vertices, edges, faces] = count.map(|(n, _)| n as u32);
        Ok(Self { level, vertices, edges, faces })
    }

    /// The level.
    pub const fn level(&self) -> u32 {
        self.level
    }

    /// Steps along an edge, `2^level`.
    pub const fn steps(&self) -> usize {
        1 << self.level
    }

    /// How many vertices lie inside each edge.
    pub const fn per_edge(&self) -> usize {
        self.steps() - 1
    }

    /// How many vertices lie inside each face.
    pub const fn per_face(&self) -> usize {
        let n = self.steps();
        if n > 2 { (n - 1) * (n - 2) / 2 } else { 0 }
    }

    /// How many root vertices there are: they have the first numbers.
    pub const fn corner_count(&self) -> usize {
        self.vertices as usize
    }

    /// How many vertices lie inside edges: they have the next numbers.
    pub const fn edge_point_count(&self) -> usize {
        self.edges as usize * self.per_edge()
    }

    /// How many vertices there are.
    pub const fn vertex_count(&self) -> usize {
        self.corner_count() + self.edge_point_count() + self.faces as usize * self.per_face()
    }

    /// How many triangles there are.
    pub const fn triangle_count(&self) -> usize {
        self.faces as usize * self.steps() * self.steps()
    }

    /// The number of the vertex `steps` from the end of `edge` with the smaller vertex id.
    #[inline]
    pub const fn edge(&self, edge: EdgeId, steps: usize) -> u32 {
        self.vertices + edge.0 * self.per_edge() as u32 + steps as u32 - 1
    }

    /// The number of the first vertex inside `face`: (1, 1).
    #[inline]
    pub const fn face(&self, face: FaceId) -> u32 {
        self.vertices + self.edges * self.per_edge() as u32 + face.0 * self.per_face() as u32
    }

    /// The place of `(i, j)`, from 1 on and together below the steps, among the vertices inside its
    /// face.
    #[inline]
    pub const fn inside(&self, i: usize, j: usize) -> usize {
        // Row i' has steps - 1 - i' vertices.
        (i - 1) * (self.steps() - 1) - (i - 1) * i / 2 + j - 1
    }

    /// The number of the vertex at `address`, which must be one of this level.
    pub const fn number(&self, address: Address) -> u32 {
        match address {
            Address::Corner(v) => v.0,
            Address::Edge(e, steps) => self.edge(e, steps as usize),
            Address::Face(f, i, j) => self.face(f) + self.inside(i as usize, j as usize) as u32,
        }
    }

    /// The number of the vertex `steps` along `h`, ends included.
    #[inline]
    pub fn along(&self, mesh: &Connectivity, h: HalfedgeId, steps: usize) -> u32 {
        let (from, to, n): (VertexId, VertexId, usize) = (mesh.from(h), mesh.to(h), self.steps());
        match steps {
            0 => from.0,
            _ if steps == n => to.0,
            _ => self.edge(mesh.edge(h), if from < to { steps } else { n - steps }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles and their numbers, counted by hand from the order of addresses.
    #[test]
    fn numbers_rise_with_addresses_and_leave_no_gap() {
        let mesh = Connectivity::new(4, &[[0, 1, 2], [2, 1, 3]]).expect("a sound mesh");
        for level in 0..5 {
            let lattice = Lattice::new(&mesh, level).expect("small");
            let n = 1_u32 << level;
            let mut addresses: Vec<Address> = (0..2)
                .flat_map(|f| (0..=n).flat_map(move |i| (0..=n - i).map(move |j| (FaceId(f), i, j))))
                .map(|(f, i, j)| Address::of(&mesh, level, f, i, j))
                .collect();
            addresses.sort_unstable();
            addresses.dedup();
            let numbers: Vec<u32> = addresses.iter().map(|&a| lattice.number(a)).collect();
            assert_eq!(numbers, (0..lattice.vertex_count() as u32).collect::<Vec<_>>(), "level {level}");
        }
    }

    /// What cannot be numbered is refused, whatever the level.
    #[test]
    fn too_fine_a_level_is_an_error() {
        let mesh = Connectivity::new(3, &[[0, 1, 2]]).expect("a sound mesh");
        assert!(Lattice::new(&mesh, 15).is_ok());
        for level in [17, 30, 31, 63, 64, u32::MAX] {
            let error = Lattice::new(&mesh, level).expect_err("too many");
            assert_eq!((error.level, error.limit), (level, u32::MAX));
        }
    }
}
