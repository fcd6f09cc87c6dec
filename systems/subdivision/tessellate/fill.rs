//! Lattice points of many faces, face by face.

use std::ops::Range;

use glam::DVec3;
use selvedge_components::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::plain::{AsStored, CornerPieces, PatchReader};
use selvedge_components::subdivision::{Lattice, PlainLoop};

use super::grid::{Grid, Part};
use super::sample::Sample;
use crate::parallel;

/// Faces that are worked on together: enough to outweigh handing them to a thread, few enough that
/// threads finish together.
const FACES_PER_BLOCK: usize = 64;
/// Root vertices that are worked on together, for the same reason.
const VERTICES_PER_BLOCK: usize = 1024;

/// Which faces are wanted.
#[derive(Clone, Copy, Debug)]
pub enum Faces<'a> {
    /// Every face.
    All,
    /// Those with `true`; one entry per face.
    Only(&'a [bool]),
}

impl Faces<'_> {
    pub(super) fn contains(self, face: FaceId) -> bool {
        match self {
            Self::All => true,
            Self::Only(wanted) => wanted[face.index()],
        }
    }
}

/// The lattice points of one triangle and of the pieces of one that is not regular.
#[derive(Clone, Debug)]
pub(super) struct Grids {
    inside: Grid,
    edges: [Grid; 3],
    middle: Grid,
    /// For each depth at which a corner is left: the two quarters along the spokes, and the one between.
    corners: Vec<[Grid; 2]>,
}

impl Grids {
    pub fn new(lattice: &Lattice) -> Self {
        let n = lattice.steps();
        let sizes = (0..).map(|depth| n >> (depth + 2)).take_while(|&size| size > 0);
        Self {
            inside: Grid::new(n, Part::Inside),
            edges: [0, 1, 2].map(|edge| Grid::edge(n, edge)),
            middle: if n > 1 { Grid::new(n / 2, Part::Closed) } else { Grid::default() },
            corners: sizes.map(|size| [Part::BelowFar, Part::Beyond].map(|part| Grid::new(size, part))).collect(),
        }
    }
}

/// Everything one pass over a surface reads.
pub(super) struct Pass<'a, S> {
    pub surface: &'a PlainLoop,
    pub lattice: &'a Lattice,
    pub grids: &'a Grids,
    pub faces: Faces<'a>,
    pub sample: S,
}

/// A run of faces and what they own of the result.
struct Block<'a> {
    faces: Range<usize>,
    /// Points inside edges, from those of `first_edge` on.
    edges: &'a mut [DVec3],
    first_edge: usize,
    /// Points inside faces.
    inside: &'a mut [DVec3],
}

/// Scratch of one block.
struct Scratch<'a> {
    reader: PatchReader<'a>,
    pieces: CornerPieces<'a, AsStored>,
    run: Vec<DVec3>,
    /// The whole lattice of one face.
    face: Vec<DVec3>,
}

impl<S: Sample> Pass<'_, S> {
    /// Writes the samples of the wanted faces to `out`, numbered as [`Lattice`] says; others stay.
    pub fn fill(&self, out: &mut [DVec3]) {
        let (corners, rest) = out.split_at_mut(self.lattice.corner_count());
        let (edges, inside) = rest.split_at_mut(self.lattice.edge_point_count());
        self.fill_corners(corners);
        if self.lattice.level() > 0 {
            parallel::for_each(self.blocks(edges, inside), |block| self.fill_block(block));
            self.fill_foreign_edges(edges);
        }
    }

    fn mesh(&self) -> &Connectivity {
        self.surface.topology().mesh()
    }

    fn fill_corners(&self, corners: &mut [DVec3]) {
        let mesh = self.mesh();
        let wanted =
            |v: VertexId| matches!(self.faces, Faces::All) || mesh.ring(v).any(|h| self.faces.contains(h.face()));
        let blocks: Vec<_> = corners.chunks_mut(VERTICES_PER_BLOCK).enumerate().collect();
        parallel::for_each(blocks, |(block, corners)| {
            for (i, corner) in corners.iter_mut().enumerate() {
                let v = VertexId::new(block * VERTICES_PER_BLOCK + i);
                if wanted(v) {
                    *corner = self.sample.vertex(self.surface, v);
                }
            }
        });
    }

    /// Cuts the result: edges are numbered by the first face that has them, so a run of faces owns a
    /// run of edges.
    fn blocks<'a>(&self, mut edges: &'a mut [DVec3], mut inside: &'a mut [DVec3]) -> Vec<Block<'a>> {
        let (mesh, faces) = (self.mesh(), self.mesh().face_count());
        let mut first_edge = 0;
        let mut blocks = Vec::with_capacity(faces.div_ceil(FACES_PER_BLOCK));
        for start in (0..faces).step_by(FACES_PER_BLOCK) {
            let end = faces.min(start + FACES_PER_BLOCK);
            let mut next_edge = first_edge;
            while next_edge < mesh.edge_count() && mesh.halfedge(EdgeId::new(next_edge)).face().index() < end {
                next_edge += 1;
            }
            let (own_edges, rest) = edges.split_at_mut((next_edge - first_edge) * self.lattice.per_edge());
            let (own_inside, others) = inside.split_at_mut((end - start) * self.lattice.per_face());
            blocks.push(Block { faces: start..end, edges: own_edges, first_edge, inside: own_inside });
            (edges, inside, first_edge) = (rest, others, next_edge);
        }
        blocks
    }

    fn scratch(&self) -> Scratch<'_> {
        let reader = PatchReader::new(self.surface, AsStored);
        Scratch { reader, pieces: reader.scratch(), run: Vec::new(), face: Vec::new() }
    }

    fn fill_block(&self, block: Block<'_>) {
        let per_edge = self.lattice.per_edge();
        let mut scratch = self.scratch();
        let (mut edges, mut inside) = (block.edges, block.inside);
        let mut next_edge = EdgeId::new(block.first_edge);
        for face in block.faces.map(FaceId::new) {
            let (own_inside, rest) = inside.split_at_mut(self.lattice.per_face());
            inside = rest;
            let wanted = self.faces.contains(face);
            if wanted {
                self.prepare(face, &mut scratch);
                self.fill_inside(face, &mut scratch, own_inside);
            }
            for h in [0, 1, 2].map(|i| HalfedgeId::of(face, i)) {
                if self.mesh().edge(h) == next_edge && self.mesh().halfedge(next_edge) == h {
                    let (own_edge, rest) = edges.split_at_mut(per_edge);
                    edges = rest;
                    next_edge.0 += 1;
                    if wanted {
                        self.fill_edge(h, &mut scratch, own_edge);
                    }
                }
            }
        }
    }

    /// Edges of wanted faces whose own face is not wanted.
    fn fill_foreign_edges(&self, edges: &mut [DVec3]) {
        let Faces::Only(_) = self.faces else { return };
        let (mesh, mut scratch) = (self.mesh(), self.scratch());
        for (e, edge) in edges.chunks_exact_mut(self.lattice.per_edge()).enumerate() {
            let h = mesh.halfedge(EdgeId::new(e));
            let twin = mesh.twin(h).filter(|t| !self.faces.contains(h.face()) && self.faces.contains(t.face()));
            if let Some(twin) = twin {
                self.prepare(twin.face(), &mut scratch);
                self.fill_edge(twin, &mut scratch, edge);
            }
        }
    }

    /// Samples the whole lattice of a face that is not regular.
    fn prepare(&self, face: FaceId, scratch: &mut Scratch<'_>) {
        if self.surface.topology().is_regular(face) {
            return;
        }
        let n = self.lattice.steps() as u32;
        scratch.face.resize(self.row(n as usize) + 1, DVec3::ZERO);
        let half = n / 2;
        let middle = scratch.reader.middle(face);
        self.sample_piece(&middle, &self.grids.middle, scratch, |a, b| (half - a, half - b));
        for corner in 0..3 {
            scratch.reader.corner(face, corner, &mut scratch.pieces);
            let place = |a: u32, b: u32| from_corner(n, corner, a, b);
            for (depth, [along, between]) in self.grids.corners.iter().enumerate() {
                let size = n >> (depth + 2);
                if depth > 0 {
                    scratch.pieces.descend();
                }
                let [first, second, third] = [0, 1, 2].map(|quarter| scratch.pieces.quarter(depth as u8, quarter));
                self.sample_piece(&first, along, scratch, |a, b| place(size + a, b));
                self.sample_piece(&second, along, scratch, |a, b| place(a, size + b));
                if size > 1 {
                    self.sample_piece(&third, between, scratch, |a, b| place(size - a, size - b));
                }
            }
        }
    }

    fn sample_piece(
        &self,
        quartic: &Quartic,
        grid: &Grid,
        scratch: &mut Scratch<'_>,
        place: impl Fn(u32, u32) -> (u32, u32),
    ) {
        scratch.run.resize(grid.lattice.len(), DVec3::ZERO);
        self.sample.piece(quartic, grid, &mut scratch.run);
        for (&(a, b), &value) in grid.lattice.iter().zip(&scratch.run) {
            let (i, j) = place(a, b);
            scratch.face[self.row(i as usize) + j as usize] = value;
        }
    }

    /// Where row `i` begins in a face's whole lattice.
    fn row(&self, i: usize) -> usize {
        // Row i' has steps + 1 - i' points.
        i * (self.lattice.steps() + 1) - i * i.saturating_sub(1) / 2
    }

    fn fill_inside(&self, face: FaceId, scratch: &mut Scratch<'_>, out: &mut [DVec3]) {
        if let Some(net) = self.surface.regular_net(face) {
            return self.sample.piece(&Quartic::new(&net), &self.grids.inside, out);
        }
        let (n, mut rest) = (self.lattice.steps(), out);
        for i in 1..n - 1 {
            let row = self.row(i);
            let (own, others) = rest.split_at_mut(n - 1 - i);
            own.copy_from_slice(&scratch.face[row + 1..row + n - i]);
            rest = others;
        }
    }

    /// Writes the points inside the edge of `h`, from its end with the smaller vertex id on.
    fn fill_edge(&self, h: HalfedgeId, scratch: &mut Scratch<'_>, out: &mut [DVec3]) {
        let grid = &self.grids.edges[h.corner()];
        if let Some(net) = self.surface.regular_net(h.face()) {
            self.sample.piece(&Quartic::new(&net), grid, out);
        } else {
            for (value, &(i, j)) in out.iter_mut().zip(&grid.lattice) {
                *value = scratch.face[self.row(i as usize) + j as usize];
            }
        }
        if self.mesh().from(h) > self.mesh().to(h) {
            out.reverse();
        }
    }
}

/// Lattice coordinates in a face with `n` steps of what lies `a` steps towards the corner after
/// `corner` and `b` towards the one after that.
fn from_corner(n: u32, corner: u8, a: u32, b: u32) -> (u32, u32) {
    match corner {
        0 => (a, b),
        1 => (n - a - b, a),
        _ => (b, n - a - b),
    }
}
