//! Which rule acts at each vertex, and which faces one polynomial covers.

use std::sync::Arc;

use thiserror::Error;

use super::block;

use crate::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use crate::subdivision::masks;

/// What subdivision does with a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VertexRule {
    /// Loop's mask of its valence.
    Interior,
    /// `1/8, 6/8, 1/8` along the border: the border is a cubic B-spline.
    Border,
    /// It stays where it is: the border has a corner there.
    Corner,
}

/// Why a mesh and what is declared about it make no plain surface.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlainError {
    /// A vertex is declared a corner that the mesh does not have.
    #[error("corner {vertex} does not exist: the mesh has {vertices} vertices")]
    NoSuchCorner {
        /// The declared corner.
        vertex: VertexId,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex is declared a corner but no border runs through it.
    #[error("corner {vertex} is not on a border")]
    CornerInside {
        /// The declared corner.
        vertex: VertexId,
    },
    /// There are more irregular faces than 32 bits can number the surroundings of.
    #[error("{points} points around the irregular faces of {faces}; 32 bits number them")]
    TooLarge {
        /// How many faces the mesh has.
        faces: usize,
        /// How many points would be needed.
        points: u64,
    },
    /// There is not exactly one control point for each vertex.
    #[error("{points} control points for {vertices} vertices")]
    PointCount {
        /// How many control points were given.
        points: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A control point is NaN or infinite.
    #[error("the control point of {vertex} is not finite: {at}")]
    NotFinite {
        /// Its vertex.
        vertex: VertexId,
        /// The control point.
        at: glam::DVec3,
    },
}

/// The connectivity of a Loop surface with plain borders, and what follows from it alone: nothing
/// here changes when control points move.
#[derive(Clone, Debug)]
pub struct PlainTopology {
    mesh: Arc<Connectivity>,
    rules: Vec<VertexRule>,
    /// For each face its place in `corners`; for a regular one its place in `nets` with all bits turned.
    faces: Vec<u32>,
    /// The corners of faces that are not regular.
    corners: Vec<[FinerCorner; 3]>,
    /// The control points of those that are, in the order of a [`Net`](crate::subdivision::boxspline::Net);
    /// [`NONE`] where some of them are phantoms.
    nets: Vec<[u32; 12]>,
    /// For each vertex where the block of its finer points begins; [`NONE`] of vertices that only regular
    /// faces touch.
    blocks: Vec<u32>,
    /// How many points all blocks have.
    finer_points: u32,
    /// For each valence up to the largest, and [`USUAL_MASKS`] at least: the masks of an interior vertex.
    masks: Vec<InteriorMask>,
}

/// So many masks there always are: no look is needed whether one of a smaller valence is there.
pub(super) const USUAL_MASKS: usize = 32;

/// Weights of each neighbour of an interior vertex, under one step and in the limit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InteriorMask {
    pub step: f64,
    pub limit: f64,
    /// That of a step of the vertex and its ring's mean, beside 1: each way of the vertex, from one step to the
    /// next, is this times the one before.
    pub eigenvalue: f64,
}

impl InteriorMask {
    /// The mask of valence `k`.
    fn new(k: u32) -> Self {
        let step = masks::neighbour_weight(k);
        Self { step, limit: masks::limit_weight(k), eigenvalue: 0.625 - f64::from(k) * step }
    }
}

/// Where the finer points of a corner of a face that is not regular are kept, and how the face lies there.
/// Small, because faces are many: what else a corner needs stands in its face's other blocks, at places that
/// follow from these.
#[derive(Clone, Copy, Debug)]
pub(super) struct FinerCorner {
    /// The corner's own block.
    pub block: u32,
    /// The place in the ring of the midpoint of the edge to the face's next corner.
    pub first: u32,
    /// The valence; at a border with a mark in the two highest bits.
    kind: u32,
}

/// The marks of a border in [`FinerCorner::kind`]. Valences are below: 32 bits do not number the points around
/// a larger one ([`PlainError::TooLarge`]).
const BORDER: u32 = 1 << 30;
const CORNER: u32 = 1 << 31;

impl FinerCorner {
    fn new(rule: VertexRule, block: u32, valence: u32, first: u32) -> Self {
        let mark = match rule {
            VertexRule::Interior => 0,
            VertexRule::Border => BORDER,
            VertexRule::Corner => CORNER,
        };
        Self { block, first, kind: valence | mark }
    }

    #[inline(always)]
    pub fn rule(self) -> VertexRule {
        match self.kind & (BORDER | CORNER) {
            0 => VertexRule::Interior,
            BORDER => VertexRule::Border,
            _ => VertexRule::Corner,
        }
    }

    #[inline(always)]
    pub fn valence(self) -> u32 {
        self.kind & !(BORDER | CORNER)
    }

    /// Are all three interior vertices of valences below `end`, a power of two?
    #[inline(always)]
    pub fn are_interior_below([a, b, c]: &[Self; 3], end: u32) -> bool {
        a.kind | b.kind | c.kind < end
    }

    /// Is it an interior vertex of valence 6?
    #[inline(always)]
    fn is_regular(&self) -> bool {
        self.kind == 6
    }

    /// Which are, of the corners of a face, as [`PlainTopology::regular_corners`] says it.
    #[inline(always)]
    pub fn regular_among([a, b, c]: &[Self; 3]) -> u64 {
        u64::from(a.is_regular()) | u64::from(b.is_regular()) << 1 | u64::from(c.is_regular()) << 2
    }

    /// Where the point of the ring is that stands `after` places after the face's first there; `None` beyond
    /// a border.
    #[inline(always)]
    pub fn ring_point(self, after: i32) -> Option<u32> {
        let (k, at) = (self.valence() as i32, self.first as i32 + after);
        let beyond = if at < 0 {
            k
        } else if at >= k {
            -k
        } else {
            0
        };
        let is_there = beyond == 0 || self.rule() == VertexRule::Interior;
        is_there.then(|| self.block + block::RING + (at + beyond) as u32)
    }
}

/// No such place.
pub(super) const NONE: u32 = u32::MAX;

impl PlainTopology {
    /// Classifies the vertices and faces of `mesh`. Border vertices are smooth but for `corners`.
    ///
    /// # Errors
    /// [`PlainError::NoSuchCorner`], [`PlainError::CornerInside`], [`PlainError::TooLarge`].
    pub fn new(mesh: Arc<Connectivity>, corners: &[VertexId]) -> Result<Self, PlainError> {
        let rules = vertex_rules(&mesh, corners)?;
        let is_regular = |v: VertexId| match rules[v.index()] {
            VertexRule::Interior => mesh.valence(v) == 6,
            VertexRule::Border => mesh.valence(v) == 4,
            VertexRule::Corner => mesh.valence(v) == 2,
        };
        let (mut count, mut nets) = (0, Vec::new());
        let place = |(f, corners): (usize, &[VertexId; 3])| {
            if corners.iter().all(|&v| is_regular(v)) {
                nets.push(regular_net(&mesh, FaceId::new(f)).unwrap_or([NONE; 12]));
                return !(nets.len() as u32 - 1);
            }
            count += 1;
            count - 1
        };
        let faces: Vec<u32> = mesh.faces().iter().enumerate().map(place).collect();
        let (blocks, finer_points) = blocks(&mesh, &faces)?;
        let corners = finer_corners(&mesh, &rules, &faces, &blocks);
        let masks = interior_masks(&mesh);
        Ok(Self { mesh, rules, faces, corners, nets, blocks, finer_points, masks })
    }

    /// The faces.
    pub fn mesh(&self) -> &Arc<Connectivity> {
        &self.mesh
    }

    /// The rule that acts at `v`.
    #[inline]
    pub fn rule(&self, v: VertexId) -> VertexRule {
        self.rules[v.index()]
    }

    /// Is the surface one polynomial over `face`? It is where every corner is an interior vertex of
    /// valence 6, a smooth border vertex of valence 4 or a declared corner of valence 2.
    #[inline]
    pub fn is_regular(&self, face: FaceId) -> bool {
        is_regular(self.faces[face.index()])
    }

    /// How many faces are not regular.
    pub fn irregular_count(&self) -> usize {
        self.corners.len()
    }

    /// Which corners of a face that is not regular are: bit `i` says so of corner `i`. Only those inside
    /// count, not those on borders. `None` of a face that is regular itself.
    #[inline(always)]
    pub fn regular_corners(&self, face: FaceId) -> Option<u64> {
        self.irregular_corners(face).map(FinerCorner::regular_among)
    }

    /// The corners of a face, unless it is regular.
    #[inline(always)]
    pub(super) fn irregular_corners(&self, face: FaceId) -> Option<&[FinerCorner; 3]> {
        self.corners.get(self.faces[face.index()] as usize)
    }

    /// The corners of a face that is not regular.
    #[inline(always)]
    pub(super) fn finer_corners(&self, face: FaceId) -> &[FinerCorner; 3] {
        &self.corners[self.faces[face.index()] as usize]
    }

    /// The control points of a regular face, but where some are phantoms.
    #[inline(always)]
    pub(super) fn net(&self, face: FaceId) -> Option<&[u32; 12]> {
        self.nets.get(!self.faces[face.index()] as usize).filter(|net| net[0] != NONE)
    }

    /// Where the block of `v` begins, if it has one.
    #[inline(always)]
    pub(super) fn block(&self, v: VertexId) -> Option<u32> {
        Some(self.blocks[v.index()]).filter(|&block| block != NONE)
    }

    /// How many finer points are kept.
    pub(super) fn finer_count(&self) -> usize {
        self.finer_points as usize
    }

    /// The masks of an interior vertex of `valence`, which must occur in the mesh.
    #[inline]
    pub(super) fn mask(&self, valence: usize) -> InteriorMask {
        self.masks[valence]
    }

    /// Those of valences below [`USUAL_MASKS`]; of no meaning for those that do not occur in the mesh.
    #[inline]
    pub(super) fn usual_masks(&self) -> &[InteriorMask; USUAL_MASKS] {
        self.masks.first_chunk().expect("there always are so many")
    }
}

fn vertex_rules(mesh: &Connectivity, corners: &[VertexId]) -> Result<Vec<VertexRule>, PlainError> {
    let rule = |v| if mesh.is_border(v) { VertexRule::Border } else { VertexRule::Interior };
    let mut rules: Vec<_> = (0..mesh.vertex_count()).map(|v| rule(VertexId::new(v))).collect();
    for &vertex in corners {
        match rules.get_mut(vertex.index()) {
            None => return Err(PlainError::NoSuchCorner { vertex, vertices: mesh.vertex_count() }),
            Some(VertexRule::Interior) => return Err(PlainError::CornerInside { vertex }),
            Some(rule) => *rule = VertexRule::Corner,
        }
    }
    Ok(rules)
}

/// Is the face with this place regular? Half of all numbers are more than there are faces, which have three
/// half-edges each.
const fn is_regular(place: u32) -> bool {
    place > u32::MAX / 2
}

/// The control points of a regular face; `None` where a border runs through a corner.
fn regular_net(mesh: &Connectivity, face: FaceId) -> Option<[u32; 12]> {
    let mut net = [NONE; 12];
    for corner in 0..3 {
        let h = HalfedgeId::of(face, corner);
        net[corner] = mesh.from(h).0;
        net[3 + corner] = mesh.opposite(mesh.twin(h)?).0;
        // The third and fourth neighbour after the one that `h` leads to.
        let one = mesh.twin(h.previous())?;
        let two = mesh.twin(one.previous())?;
        let three = mesh.twin(two.previous())?;
        net[6 + 2 * corner] = mesh.to(three).0;
        net[7 + 2 * corner] = mesh.opposite(three).0;
    }
    Some(net)
}

/// Computed once for each valence that occurs: a cosine costs more than the sum it weighs.
fn interior_masks(mesh: &Connectivity) -> Vec<InteriorMask> {
    let mut masks = vec![InteriorMask::default(); USUAL_MASKS];
    for v in (0..mesh.vertex_count()).map(VertexId::new) {
        let k = mesh.valence(v);
        if masks.len() <= k as usize {
            masks.resize(k as usize + 1, InteriorMask::default());
        }
        let mask = &mut masks[k as usize];
        if mask.step == 0.0 {
            *mask = InteriorMask::new(k);
        }
    }
    masks
}

/// Where the block of each vertex of a face that is not regular begins, [`NONE`] of the others; and how many
/// points there are in all. In the order in which the faces come: those who walk over faces find blocks
/// together whatever the numbers of the vertices are.
fn blocks(mesh: &Connectivity, faces: &[u32]) -> Result<(Vec<u32>, u32), PlainError> {
    let mut begin = vec![NONE; mesh.vertex_count()];
    let mut total = 0_u64;
    for (corners, _) in mesh.faces().iter().zip(faces).filter(|(_, place)| !is_regular(**place)) {
        for v in corners {
            if begin[v.index()] == NONE {
                // Too many are counted to their end, for the error.
                begin[v.index()] = total.min(u64::from(NONE - 1)) as u32;
                total += u64::from(block::size(mesh.valence(*v)));
            }
        }
    }
    match u32::try_from(total) {
        Ok(points) if points < NONE => Ok((begin, points)),
        _ => Err(PlainError::TooLarge { faces: mesh.face_count(), points: total }),
    }
}

fn finer_corners(mesh: &Connectivity, rules: &[VertexRule], faces: &[u32], blocks: &[u32]) -> Vec<[FinerCorner; 3]> {
    // For each half-edge that leaves a vertex with a block: the place of its edge's midpoint there.
    let mut slots = vec![NONE; 3 * mesh.face_count()];
    for v in (0..mesh.vertex_count()).filter(|&v| blocks[v] != NONE) {
        for (slot, h) in (blocks[v] + block::RING..).zip(mesh.ring(VertexId::new(v))) {
            slots[h.index()] = slot;
        }
    }
    let corner = |h: HalfedgeId| {
        let v = mesh.from(h);
        let block = blocks[v.index()];
        FinerCorner::new(rules[v.index()], block, mesh.valence(v), slots[h.index()] - block - block::RING)
    };
    let faces = (0..mesh.face_count()).filter(|&f| !is_regular(faces[f])).map(FaceId::new);
    faces.map(|f| [0, 1, 2].map(|i| corner(HalfedgeId::of(f, i)))).collect()
}
