//! The half-edges of a triangle mesh.

use super::edges::EdgeGroups;
use super::faults::inspect;
use super::{EdgeId, FaceId, Fault, HalfedgeId, VertexId};

/// No half-edge: what stands in the tables where a twin is missing.
const NONE: u32 = u32::MAX;

/// The connectivity of an oriented 2-manifold triangle mesh, with or without borders.
///
/// Always true, because [`Connectivity::new`] refuses anything else:
/// 1. every edge has one face or two, and two faces run through it in opposite directions;
/// 2. the faces around a vertex form one fan (a border vertex) or one ring (an interior one);
/// 3. no face names a vertex twice, no two faces have the same corners, no vertex is unused.
///
/// Faces run counter-clockwise seen from outside. Half-edge `3 f + i` runs from corner `i` to
/// corner `i + 1` of face `f`, so only twins are stored. Edge ids are given in the order in which
/// the half-edges first meet them, so they depend on the faces alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connectivity {
    faces: Vec<[VertexId; 3]>,
    twins: Vec<u32>,
    edges: Vec<EdgeId>,
    first_halfedge: Vec<HalfedgeId>,
    outgoing: Vec<HalfedgeId>,
    valence: Vec<u32>,
}

impl Connectivity {
    /// Builds the half-edges of `faces` over vertices `0..vertex_count`.
    ///
    /// Costs O(vertices + faces log(valence)), without hashing.
    ///
    /// # Errors
    /// Every [`Fault`] of the mesh, as [`faults`](super::faults) lists them, when there is one.
    pub fn new(vertex_count: usize, faces: &[[u32; 3]]) -> Result<Self, Vec<Fault>> {
        let groups = inspect(vertex_count, faces)?;
        let twins = match_twins(faces.len(), &groups);
        let (edges, first_halfedge) = number_edges(&twins);
        let (outgoing, valence) = fans(vertex_count, faces, &twins);
        Ok(Self {
            faces: faces.iter().map(|f| f.map(VertexId)).collect(),
            twins,
            edges,
            first_halfedge,
            outgoing,
            valence,
        })
    }

    /// How many vertices.
    pub fn vertex_count(&self) -> usize {
        self.outgoing.len()
    }

    /// How many faces.
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// How many undirected edges.
    pub fn edge_count(&self) -> usize {
        self.first_halfedge.len()
    }

    /// The corners of every face, counter-clockwise.
    pub fn faces(&self) -> &[[VertexId; 3]] {
        &self.faces
    }

    /// The corners of `face`, counter-clockwise.
    #[inline]
    pub fn face(&self, face: FaceId) -> [VertexId; 3] {
        self.faces[face.index()]
    }

    /// The vertex that `h` leaves.
    #[inline]
    pub fn from(&self, h: HalfedgeId) -> VertexId {
        self.faces[h.face().index()][h.corner()]
    }

    /// The vertex that `h` reaches.
    #[inline]
    pub fn to(&self, h: HalfedgeId) -> VertexId {
        self.from(h.next())
    }

    /// The vertex across `h` in its face.
    #[inline]
    pub fn opposite(&self, h: HalfedgeId) -> VertexId {
        self.from(h.previous())
    }

    /// The same edge walked the other way, in the neighbouring face; `None` on a border.
    #[inline]
    pub fn twin(&self, h: HalfedgeId) -> Option<HalfedgeId> {
        let twin = self.twins[h.index()];
        (twin != NONE).then_some(HalfedgeId(twin))
    }

    /// The undirected edge of `h`.
    #[inline]
    pub fn edge(&self, h: HalfedgeId) -> EdgeId {
        self.edges[h.index()]
    }

    /// The half-edge of `edge` with the smaller id; its direction is the edge's own.
    #[inline]
    pub fn halfedge(&self, edge: EdgeId) -> HalfedgeId {
        self.first_halfedge[edge.index()]
    }

    /// How many edges meet at `v`.
    #[inline]
    pub fn valence(&self, v: VertexId) -> u32 {
        self.valence[v.index()]
    }

    /// Does `v` lie on a border?
    #[inline]
    pub fn is_border(&self, v: VertexId) -> bool {
        self.twins[self.outgoing[v.index()].index()] == NONE
    }

    /// The half-edge at which the ring of `v` begins: the one along the border, with the surface
    /// on its left, for a border vertex; the one of the smallest id for an interior vertex.
    #[inline]
    pub fn outgoing(&self, v: VertexId) -> HalfedgeId {
        self.outgoing[v.index()]
    }

    /// The half-edges that leave `v`, counter-clockwise, from [`Self::outgoing`].
    ///
    /// The ring of a border vertex of valence `k` has `k - 1` half-edges that leave; its last
    /// neighbour is reached by [`Self::last_border_neighbour`].
    #[inline]
    pub fn ring(&self, v: VertexId) -> Ring<'_> {
        Ring { mesh: self, start: self.outgoing(v), next: Some(self.outgoing(v)) }
    }

    /// The neighbours of `v`, counter-clockwise; on a border from the next border vertex to the
    /// previous one.
    pub fn neighbours(&self, v: VertexId) -> impl Iterator<Item = VertexId> + '_ {
        let last = self.last_border_neighbour(v);
        self.ring(v).map(|h| self.to(h)).chain(last)
    }

    /// The border vertex before `v`, walking with the surface on the left.
    pub fn last_border_neighbour(&self, v: VertexId) -> Option<VertexId> {
        if !self.is_border(v) {
            return None;
        }
        self.ring(v).last().map(|h| self.from(h.previous()))
    }

    /// The borders, each a loop of vertices walked with the surface on the left, begun at its
    /// smallest vertex; ordered by that vertex.
    pub fn border_loops(&self) -> Vec<Vec<VertexId>> {
        let mut seen = vec![false; self.vertex_count()];
        let mut loops = Vec::new();
        for start in (0..self.vertex_count()).map(VertexId::new) {
            if seen[start.index()] || !self.is_border(start) {
                continue;
            }
            let mut walk = Vec::new();
            let mut v = start;
            while !seen[v.index()] {
                seen[v.index()] = true;
                walk.push(v);
                v = self.to(self.outgoing(v));
            }
            loops.push(walk);
        }
        loops
    }

    /// Vertices - edges + faces.
    pub fn euler(&self) -> i64 {
        self.vertex_count() as i64 - self.edge_count() as i64 + self.face_count() as i64
    }
}

/// The half-edges that leave one vertex, counter-clockwise.
#[derive(Clone, Debug)]
pub struct Ring<'a> {
    mesh: &'a Connectivity,
    start: HalfedgeId,
    next: Option<HalfedgeId>,
}

impl Iterator for Ring<'_> {
    type Item = HalfedgeId;

    #[inline]
    fn next(&mut self) -> Option<HalfedgeId> {
        let now = self.next?;
        self.next = self.mesh.twin(now.previous()).filter(|&h| h != self.start);
        Some(now)
    }
}

/// The twin of every half-edge, or [`NONE`] on a border.
fn match_twins(face_count: usize, groups: &EdgeGroups) -> Vec<u32> {
    let mut twins = vec![NONE; 3 * face_count];
    for group in groups.iter() {
        if let [(_, a), (_, b)] = *group {
            twins[a as usize] = b;
            twins[b as usize] = a;
        }
    }
    twins
}

fn number_edges(twins: &[u32]) -> (Vec<EdgeId>, Vec<HalfedgeId>) {
    let mut edges = vec![EdgeId(NONE); twins.len()];
    let mut first = Vec::with_capacity(twins.len() / 2);
    for h in 0..twins.len() {
        if edges[h].0 != NONE {
            continue;
        }
        let id = EdgeId::new(first.len());
        first.push(HalfedgeId::new(h));
        edges[h] = id;
        if twins[h] != NONE {
            edges[twins[h] as usize] = id;
        }
    }
    (edges, first)
}

/// Where each vertex's ring begins, and its valence.
fn fans(vertex_count: usize, faces: &[[u32; 3]], twins: &[u32]) -> (Vec<HalfedgeId>, Vec<u32>) {
    let mut outgoing = vec![HalfedgeId(NONE); vertex_count];
    let mut valence = vec![0_u32; vertex_count];
    for (h, &twin) in twins.iter().enumerate() {
        let v = faces[h / 3][h % 3] as usize;
        let on_border = twin == NONE;
        // A vertex has at most one border half-edge that leaves; where there is one, it wins.
        if on_border || outgoing[v].0 == NONE {
            outgoing[v] = HalfedgeId::new(h);
        }
        // A half-edge that leaves counts its own edge; a border edge that arrives is no half-edge
        // that leaves, and counts here.
        valence[v] += 1;
        if on_border {
            valence[faces[h / 3][(h + 1) % 3] as usize] += 1;
        }
    }
    (outgoing, valence)
}
