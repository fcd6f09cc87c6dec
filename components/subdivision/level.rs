//! The connectivity of one level of a subdivided surface, over any set of its faces.
//!
//! ```text
//!            2                       2                 half-edge i of a face leaves corner i;
//!           / \                     / \                its first half is half-edge i of child i,
//!          /   \                   / 2 \               its second half is half-edge i of child i + 1
//!         /     \       ->       20 --- 12
//!        /       \               / \ 3 / \             the middle child has the corners 01, 12, 20;
//!       /         \             / 0 \ / 1 \            its half-edge i faces child i + 1
//!      0 --------- 1           0 --- 01 -- 1
//! ```

mod refine;

use glam::DVec3;

use super::address::{Address, FaceCode};
use super::corner::CornerTable;
use super::surface::{Border, Ends, LoopSurface, Side};
use crate::mesh::{Connectivity, FaceId, HalfedgeId};

pub use refine::{BorderStep, Quartered};

/// No element: what stands in a table where there is none.
pub const NONE: u32 = u32::MAX;

/// Some faces of one level of a subdivided surface, with the vertices they use.
///
/// Faces ascend by [`FaceCode`]; from level 1 on they come in whole families of four, so face
/// `4 g + c` is child `c` of [`LevelMesh::parent`]`(g)`. Where a neighbouring face is missing, the
/// mesh is *cut*: a half-edge there has neither twin nor border. The order of everything follows
/// from the codes alone, so that sums over a ring have the same bits in every selection of faces
/// that holds the whole ring.
#[derive(Clone, Debug, Default)]
pub struct LevelMesh {
    /// Which level; 0 is the root mesh.
    pub level: u32,
    /// The faces, ascending.
    pub codes: Vec<FaceCode>,
    /// The corners of each face: indices into `vertices`.
    pub corners: Vec<[u32; 3]>,
    /// The vertices used.
    pub vertices: Vec<LevelVertex>,
    /// The vertices on a given border, ascending by vertex.
    pub given: Vec<GivenVertex>,
    /// Those of `vertices` that are special corners, ascending.
    special: Vec<u32>,
    /// Their neighbours, ascending.
    beside: Vec<u32>,
    twins: Vec<u32>,
    borders: Vec<u32>,
    border_edges: Vec<BorderEdge>,
    parents: Vec<u32>,
}

/// One vertex of a [`LevelMesh`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelVertex {
    /// The half-edge at which its ring begins; the border one on a border.
    pub start: u32,
    /// How many edges meet here on the whole surface.
    pub valence: u32,
    /// What it is.
    pub kind: Kind,
    /// Are all its faces in the mesh?
    pub ring: RingState,
    /// Where it came from.
    pub origin: Origin,
    /// Its entry in the table of special corners, or [`NONE`].
    pub corner: u32,
}

/// What a vertex is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Inside the surface.
    Interior,
    /// On a plain border, between corners.
    Plain,
    /// A corner that only plain sides meet.
    PlainCorner,
    /// On a given border, corners included: its entry in [`LevelMesh::given`].
    Given(u32),
}

/// Whether all faces around a vertex are in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RingState {
    /// All of them.
    Whole,
    /// Some are missing.
    Cut,
}

/// Where a vertex came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// It is a vertex of the root mesh.
    Root,
    /// It stands for this vertex of the level before.
    Vertex(u32),
    /// It halves the edge of this half-edge of the level before.
    Edge(u32),
}

/// A vertex on a given border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GivenVertex {
    /// The vertex.
    pub vertex: u32,
    /// The curve's own value there: computed once, when the vertex is made.
    pub sample: DVec3,
    /// Is it the end of a side?
    pub end: SideEnd,
}

/// Whether a border vertex ends its side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SideEnd {
    /// It lies inside the side.
    Smooth,
    /// Two given sides meet here.
    Corner,
    /// A given side meets a plain one here. The plain side reads the point itself, so it has no
    /// detail.
    Mixed,
}

#[derive(Clone, Copy, Debug)]
struct BorderEdge {
    side: u32,
    /// Steps of this level from the side's first vertex to the start of the half-edge.
    step: u64,
}

impl LevelMesh {
    /// Level 0 over the whole surface.
    pub fn root(surface: &LoopSurface, corners: &CornerTable) -> Self {
        let mesh = &*surface.mesh;
        let halfedges = 3 * mesh.face_count();
        let mut borders = vec![NONE; halfedges];
        let mut border_edges = Vec::new();
        for (s, side) in surface.sides.iter().enumerate() {
            let edges = side.vertices.len() - usize::from(side.ends == Ends::Corners);
            for (step, &v) in side.vertices[..edges].iter().enumerate() {
                borders[mesh.outgoing(v).index()] = border_edges.len() as u32;
                border_edges.push(BorderEdge { side: s as u32, step: step as u64 });
            }
        }
        let twin = |h| mesh.twin(HalfedgeId::new(h)).map_or(NONE, |t| t.0);
        let mut level = Self {
            level: 0,
            codes: (0..mesh.face_count()).map(|f| FaceCode::root(FaceId::new(f))).collect(),
            corners: mesh.faces().iter().map(|f| f.map(|v| v.0)).collect(),
            vertices: Vec::with_capacity(mesh.vertex_count()),
            given: Vec::new(),
            special: Vec::new(),
            beside: Vec::new(),
            twins: (0..halfedges).map(twin).collect(),
            borders,
            border_edges,
            parents: Vec::new(),
        };
        for v in 0..mesh.vertex_count() {
            let id = crate::mesh::VertexId::new(v);
            let start = mesh.outgoing(id).0;
            let kind = level.root_kind(surface, mesh, id);
            let corner = corners.of(id);
            level.special.extend((corner != NONE).then_some(v as u32));
            level.vertices.push(LevelVertex {
                start,
                valence: mesh.valence(id),
                kind,
                ring: RingState::Whole,
                origin: Origin::Root,
                corner,
            });
        }
        level.note_beside();
        level
    }

    fn root_kind(&mut self, surface: &LoopSurface, mesh: &Connectivity, v: crate::mesh::VertexId) -> Kind {
        if !mesh.is_border(v) {
            return Kind::Interior;
        }
        let after = self.border_edges[self.borders[mesh.outgoing(v).index()] as usize];
        let last = mesh.ring(v).last().map_or(mesh.outgoing(v), HalfedgeId::previous);
        let before = self.border_edges[self.borders[last.index()] as usize];
        let corner = after.step == 0 && surface.sides[after.side as usize].ends == Ends::Corners;
        // Where two given curves meet, the older one gives the bits.
        let mut along = [(after.side, after.step), (before.side, before.step + 1)];
        along.sort_unstable();
        let samples = along.map(|(s, step)| sample(&surface.sides[s as usize], 0, step));
        let mixed = samples.iter().any(Option::is_none);
        match (samples[0].or(samples[1]), corner) {
            (None, true) => Kind::PlainCorner,
            (None, false) => Kind::Plain,
            (Some(sample), corner) => {
                let end = match (corner, mixed) {
                    (false, _) => SideEnd::Smooth,
                    (true, false) => SideEnd::Corner,
                    (true, true) => SideEnd::Mixed,
                };
                self.given.push(GivenVertex { vertex: v.0, sample, end });
                Kind::Given(self.given.len() as u32 - 1)
            }
        }
    }

    /// The same edge in the neighbouring face, if that face is here.
    #[inline]
    pub fn twin(&self, h: u32) -> Option<u32> {
        let twin = self.twins[h as usize];
        (twin != NONE).then_some(twin)
    }

    /// The side that half-edge `h` lies on, and how many steps of this level from its beginning.
    #[inline]
    pub fn border(&self, h: u32) -> Option<(u32, u64)> {
        let b = self.borders[h as usize];
        (b != NONE).then(|| {
            let edge = self.border_edges[b as usize];
            (edge.side, edge.step)
        })
    }

    /// The vertex that half-edge `h` leaves.
    #[inline]
    pub fn from(&self, h: u32) -> u32 {
        self.corners[h as usize / 3][h as usize % 3]
    }

    /// The vertex that half-edge `h` reaches.
    #[inline]
    pub fn to(&self, h: u32) -> u32 {
        self.from(next(h))
    }

    /// The vertex across `h` in its face.
    #[inline]
    pub fn opposite(&self, h: u32) -> u32 {
        self.from(previous(h))
    }

    /// The face of the level before that family `g` fills.
    pub fn parent(&self, family: u32) -> u32 {
        self.parents[family as usize]
    }

    /// The curve's value at `v`; zero off the given borders.
    pub fn sample(&self, v: u32) -> DVec3 {
        match self.vertices[v as usize].kind {
            Kind::Given(g) => self.given[g as usize].sample,
            _ => DVec3::ZERO,
        }
    }

    /// The next half-edge counter-clockwise around the vertex that `h` leaves, if that face is here.
    #[inline]
    pub fn turned(&self, h: u32) -> Option<u32> {
        self.twin(previous(h))
    }

    /// The half-edges that leave `v`, counter-clockwise from its start. Of a cut vertex, those that
    /// follow the start without a gap.
    pub fn ring(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let start = self.vertices[v as usize].start;
        let mut now = Some(start);
        core::iter::from_fn(move || {
            let h = now?;
            now = self.twin(previous(h)).filter(|&n| n != start);
            Some(h)
        })
    }

    /// Lists the neighbours of special corners.
    fn note_beside(&mut self) {
        let is_whole = |&v: &u32| self.vertices[v as usize].ring == RingState::Whole;
        let mut beside: Vec<u32> = if self.special.iter().all(is_whole) {
            self.special.iter().flat_map(|&v| self.neighbours(v)).collect()
        } else {
            // A ring with gaps does not lead to all of its neighbours.
            let ends = (0..self.twins.len() as u32).map(|h| [self.from(h), self.to(h)]);
            let across = |[a, b]: [u32; 2]| [(a, b), (b, a)];
            let special = |(a, b): (u32, u32)| (self.vertices[a as usize].corner != NONE).then_some(b);
            ends.flat_map(across).filter_map(special).collect()
        };
        beside.sort_unstable();
        beside.dedup();
        self.beside = beside;
    }

    /// Is a neighbour of an interior vertex a special corner?
    ///
    /// There are few of them: to look their neighbours up costs less than to visit all neighbours of others.
    pub fn is_beside_special(&self, v: u32) -> bool {
        self.beside.binary_search(&v).is_ok()
    }

    /// The neighbours of a vertex whose ring is whole, counter-clockwise; on a border from the next
    /// border vertex to the previous one.
    pub fn neighbours(&self, v: u32) -> impl Iterator<Item = u32> + '_ {
        let last = self.previous_on_border(v);
        self.ring(v).map(|h| self.to(h)).chain(last)
    }

    /// The border vertex before `v` with the surface on the left; `None` for an interior vertex.
    pub fn previous_on_border(&self, v: u32) -> Option<u32> {
        if self.vertices[v as usize].kind == Kind::Interior {
            return None;
        }
        self.ring(v).last().map(|h| self.opposite(h))
    }

    /// Can `face` be subdivided: are the rings of its corners whole?
    pub fn refinable(&self, face: u32) -> bool {
        self.corners[face as usize].iter().all(|&v| self.vertices[v as usize].ring == RingState::Whole)
    }

    /// All faces that can be subdivided, ascending.
    pub fn all_refinable(&self) -> Vec<u32> {
        (0..self.corners.len() as u32).filter(|&f| self.refinable(f)).collect()
    }

    /// The index here of the face with this code.
    pub fn find(&self, code: FaceCode) -> Option<u32> {
        self.codes.binary_search(&code).ok().map(|f| f as u32)
    }

    /// The indices here of `faces`, which ascend, without those that are not here.
    pub fn find_all(&self, faces: &[FaceCode]) -> Vec<u32> {
        let mut passed = 0;
        let place = |&face: &FaceCode| {
            // Most often the next, or near it: strides that double come there sooner than halving all.
            let left = &self.codes[passed..];
            let mut stride = 1;
            while left.get(stride).is_some_and(|&code| code < face) {
                stride *= 2;
            }
            let (begin, end) = (stride / 2, left.len().min(stride + 1));
            passed += begin + left[begin..end].partition_point(|&code| code < face);
            (self.codes.get(passed) == Some(&face)).then_some(passed as u32)
        };
        faces.iter().filter_map(place).collect()
    }

    /// The address of every vertex.
    pub fn addresses(&self, mesh: &Connectivity) -> Vec<Address> {
        let mut addresses = vec![Address::Face(FaceId(NONE), 0, 0); self.vertices.len()];
        for (&code, corners) in self.codes.iter().zip(&self.corners) {
            let lattice = code.corners(self.level);
            for (&v, (i, j)) in corners.iter().zip(lattice) {
                if matches!(addresses[v as usize], Address::Face(FaceId(NONE), ..)) {
                    addresses[v as usize] = Address::of(mesh, self.level, code.root_face(self.level), i, j);
                }
            }
        }
        addresses
    }
}

/// The curve's own value `step` steps of `level` along `side`; `None` on a plain side.
pub fn sample(side: &Side, level: u32, step: u64) -> Option<DVec3> {
    let Border::Given { curve, .. } = &side.border else { return None };
    Some(curve.sample(level, side.curve_index(level, step)?))
}

/// The next half-edge around its face.
#[inline]
pub const fn next(h: u32) -> u32 {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

/// The previous half-edge around its face.
#[inline]
pub const fn previous(h: u32) -> u32 {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::mesh::VertexId;

    /// Two levels below two faces of a strip of four.
    fn level() -> LevelMesh {
        let faces = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];
        let mesh = Connectivity::new(6, &faces).expect("a valid mesh");
        let points = (0..6).map(|v| DVec3::new(f64::from(v), f64::from(v % 2), 0.0)).collect();
        let corners: Vec<VertexId> = [0, 1, 5, 4].map(VertexId).to_vec();
        let surface = LoopSurface::plain(Arc::new(mesh), points, &corners);
        let root = LevelMesh::root(&surface, &CornerTable::new(&surface));
        let finer = root.refine(&surface, &[0, 1, 2, 3]);
        finer.refine(&surface, &[0, 1, 2, 3, 8, 9, 10, 11])
    }

    /// Any selection of faces, some of which are not there, is found as one by one.
    #[test]
    fn faces_are_found_together_as_alone() {
        let level = level();
        let all: Vec<FaceCode> = (0..64).map(FaceCode).collect();
        for (skip, every) in (0..64).flat_map(|skip| [1, 2, 3, 7, 16, 31].map(|every| (skip, every))) {
            let some: Vec<FaceCode> = all.iter().copied().skip(skip).step_by(every).collect();
            let alone: Vec<u32> = some.iter().filter_map(|&face| level.find(face)).collect();
            assert_eq!(level.find_all(&some), alone, "{every}th from {skip}");
        }
        assert_eq!(level.find_all(&all).len(), level.codes.len());
        assert!(level.find_all(&[]).is_empty());
    }
}
