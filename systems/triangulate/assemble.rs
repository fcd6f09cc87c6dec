//! A forest becomes triangles: names for the vertices, closures for the leaves.
//!
//! Each root face is worked on alone. Its vertices are its corners and the middles of the edges of all
//! that is quartered in it; those on a root edge are shared with what is quartered across. A leaf has a
//! vertex inside an edge where the middle of the edge is a vertex: then its neighbour is finer.

use core::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use selvedge_components::mesh::FaceId;
use selvedge_components::triangles::Triangles;
use smallvec::SmallVec;

use super::closure;
use super::forest::{Forest, Tile};
use super::measure::{Facet, Over, shape};
use super::names::{Names, Plot};
use super::sample::{Pieces, Place};
use super::vertices::VertexWork;
use super::{Normals, QUANTUM, Subject, TriangulateError, Triangulation, TriangulationReport, quantum};
use crate::parallel::{map_dear_in_order, map_in_order};

/// The triangles of a forest, and how they came about.
#[derive(Debug)]
pub struct Assembly {
    triangles: Triangles,
    /// In the order of root faces and paths.
    pub leaves: Vec<Leaf>,
    /// By root face: its first leaf; after the last, how many there are.
    first_leaves: Vec<usize>,
}

/// How a leaf was cut.
#[derive(Clone, Copy, Debug)]
pub struct Leaf {
    /// Which face it is.
    pub place: Place,
    corners: [u32; 3],
    /// The vertices that halve its edges.
    halves: [Option<u32>; 3],
    /// Its first triangle.
    first: u32,
}

/// A leaf and how it is cut: its level, its code, and whether there is a vertex inside each edge.
pub type LeafKey = (u32, u64, [bool; 3]);

impl Leaf {
    /// What tells it from other leaves of any forest.
    pub fn key(&self) -> LeafKey {
        (self.place.level, self.place.code.0, self.halves.map(|half| half.is_some()))
    }

    /// The vertices at the ends of its edges, from a corner to the next.
    pub fn edges(&self) -> [[u32; 2]; 3] {
        let [a, b, c] = self.corners;
        [[a, b], [b, c], [c, a]]
    }

    /// Its triangles: one more for each vertex inside an edge.
    fn triangles(&self) -> Range<usize> {
        let first = self.first as usize;
        first..first + 1 + self.halves.iter().flatten().count()
    }
}

/// The triangles of a forest in the making.
#[derive(Debug)]
pub enum AssembleWork {
    /// What stands on the first root faces.
    Plots(Vec<Plot>),
    /// Vertices that have names, some of them evaluated.
    Vertices(Names, VertexWork),
    /// Triangles of the first root faces.
    Cut(Names, Assembly),
}

impl Default for AssembleWork {
    fn default() -> Self {
        Self::Plots(Vec::new())
    }
}

impl AssembleWork {
    /// Takes the next step of building the triangles of `forest`, and adds to `spent` what it costs; the
    /// triangles, once they are there.
    ///
    /// # Errors
    /// [`TriangulateError::LimitNotFinite`].
    pub fn advance(
        &mut self,
        subject: &Subject,
        forest: &Forest,
        normals: Normals,
        spent: &mut usize,
    ) -> Result<Option<Assembly>, TriangulateError> {
        let mesh = &subject.surface.mesh;
        let faces = mesh.face_count();
        match self {
            Self::Plots(plots) if plots.len() < faces => {
                // As many as have a quantum of leaves on the average.
                let count = QUANTUM.saturating_mul(faces) / forest.leaf_count();
                let (first, count) = (plots.len(), count.clamp(1, faces - plots.len()));
                plots.extend(map_dear_in_order(count, |f| Plot::new(mesh, forest, FaceId::new(first + f))));
                *spent += plots[first..].iter().map(|plot| plot.leaves.len()).sum::<usize>();
            }
            Self::Plots(plots) => {
                let names = Names::new(Arc::clone(mesh), 1 << forest.finest(), core::mem::take(plots));
                *spent += names.count() / 8;
                let work = VertexWork::new(mesh, &names);
                *self = Self::Vertices(names, work);
            }
            Self::Vertices(names, work) => {
                let evaluated = work.advance(subject, names, normals);
                *spent += evaluated;
                if evaluated == 0
                    && let Self::Vertices(names, work) = core::mem::take(self)
                {
                    *self = Self::Cut(names, Assembly::new(work.finish(), forest.leaf_count()));
                }
            }
            Self::Cut(names, assembly) => {
                let first = assembly.first_leaves.len() - 1;
                let (end, leaves) = quantum(first, faces, |f| names.plot(FaceId::new(f)).leaves.len());
                let positions = &assembly.triangles.positions;
                let cut = map_dear_in_order(end - first, |f| cut_leaves(names, FaceId::new(first + f), positions));
                cut.into_iter().for_each(|cut| assembly.add(cut));
                *spent += leaves / 2;
                if end == faces
                    && let Self::Cut(_, assembly) = core::mem::take(self)
                {
                    assembly.check()?;
                    return Ok(Some(assembly));
                }
            }
        }
        Ok(None)
    }
}

/// What one root face comes to; leaves count their triangles from its first.
struct Cut {
    leaves: Vec<Leaf>,
    triangles: Vec<[u32; 3]>,
}

/// Cuts the leaves of a root face into their triangles.
fn cut_leaves(names: &Names, face: FaceId, positions: &[DVec3]) -> Cut {
    let plot = names.plot(face);
    let mut cut = Cut {
        leaves: Vec::with_capacity(plot.leaves.len()),
        triangles: Vec::with_capacity(plot.leaves.len() + plot.leaves.len() / 4),
    };
    for tile in &plot.leaves {
        let Tile { level, code, corners } = *tile;
        let corners = corners.map(|at| names.of(face, at));
        let halves = if tile.is_coarse() { tile.middles().map(|at| names.find(face, at)) } else { [None; 3] };
        let first = cut.triangles.len() as u32;
        closure::close(corners, halves, |v| positions[v as usize], |t| cut.triangles.push(t));
        cut.leaves.push(Leaf { place: Place { level, code }, corners, halves, first });
    }
    cut
}

impl Assembly {
    /// Vertices and no triangles; leaves are to come, and a few more triangles.
    fn new(vertices: Triangles, leaves: usize) -> Self {
        let mut triangles = vertices;
        let most = leaves + leaves / 4;
        triangles.triangles.reserve(most);
        triangles.faces.reserve(most);
        Self { triangles, leaves: Vec::with_capacity(leaves), first_leaves: vec![0] }
    }

    /// Adds the next root face.
    fn add(&mut self, cut: Cut) {
        let Triangles { triangles, faces, .. } = &mut self.triangles;
        let (face, first) = (FaceId::new(self.first_leaves.len() - 1), triangles.len() as u32);
        self.leaves.extend(cut.leaves.into_iter().map(|leaf| Leaf { first: leaf.first + first, ..leaf }));
        triangles.extend(cut.triangles);
        faces.resize(triangles.len(), face);
        self.first_leaves.push(self.leaves.len());
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.triangles.triangles.len()
    }

    /// The squared distance of a point to the triangles of a leaf.
    pub fn own(&self, leaf: &Leaf) -> impl Fn(DVec3) -> f64 + use<> {
        let facets: SmallVec<[Facet; 4]> = self.indices(leaf).iter().map(|&t| Facet::new(self.positions(t))).collect();
        move |x| {
            let inside = |t: &Facet| t.under(x).filter(Over::inside);
            match facets.iter().find_map(inside) {
                Some(over) => over.squared,
                None => facets.iter().map(|t| t.squared(x)).fold(f64::INFINITY, f64::min),
            }
        }
    }

    /// The triangles at the corners of those of a leaf, these among them.
    pub fn beyond(&self, around: &Around, leaf: &Leaf) -> Vec<Facet> {
        let mut beyond: Vec<u32> = self.indices(leaf).iter().flatten().flat_map(|&v| around.of(v)).copied().collect();
        beyond.sort_unstable();
        beyond.dedup();
        beyond.into_iter().map(|t| Facet::new(self.corners(t))).collect()
    }

    /// The unit normals of all triangles; zero for one that has no area.
    pub fn normals(&self) -> Vec<DVec3> {
        map_in_order(self.triangle_count(), |t| {
            let [a, b, c] = self.corners(t as u32);
            (b - a).cross(c - a).normalize_or_zero()
        })
    }

    /// Which of the leaves stand on a root face.
    pub fn leaves_of(&self, face: usize) -> Range<usize> {
        self.first_leaves[face]..self.first_leaves[face + 1]
    }

    /// The triangles of a leaf.
    pub fn triangles_of(&self, leaf: &Leaf) -> Range<u32> {
        let range = leaf.triangles();
        range.start as u32..range.end as u32
    }

    /// The vertices of a triangle.
    pub fn triangle(&self, t: u32) -> [u32; 3] {
        self.triangles.triangles[t as usize]
    }

    /// Where the corners of a triangle stand.
    pub fn corners(&self, t: u32) -> [DVec3; 3] {
        self.positions(self.triangle(t))
    }

    fn indices(&self, leaf: &Leaf) -> &[[u32; 3]] {
        &self.triangles.triangles[leaf.triangles()]
    }

    fn positions(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.triangles.positions[v as usize])
    }

    /// The triangles of a leaf: for each corner its position, and its weights on the leaf.
    pub fn pieces(&self, leaf: &Leaf) -> Pieces {
        let weights = |v: u32| -> [f64; 3] {
            core::array::from_fn(|c| {
                let half = leaf.halves[c] == Some(v) || leaf.halves[(c + 2) % 3] == Some(v);
                if leaf.corners[c] == v {
                    1.0
                } else if half {
                    0.5
                } else {
                    0.0
                }
            })
        };
        let piece = |t: &[u32; 3]| t.map(|v| (self.triangles.positions[v as usize], weights(v)));
        self.indices(leaf).iter().map(piece).collect()
    }

    /// How many vertices there are.
    pub fn vertex_count(&self) -> usize {
        self.triangles.positions.len()
    }

    /// Where a vertex stands.
    pub fn position(&self, v: u32) -> DVec3 {
        self.triangles.positions[v as usize]
    }

    /// The triangles around every vertex.
    pub fn around(&self) -> Around {
        Around::new(self.triangles.positions.len(), &self.triangles.triangles)
    }

    /// Hands the triangles out.
    pub fn finish(self) -> Triangulation {
        let positions = &self.triangles.positions;
        let shapes = self.triangles.triangles.iter().map(|t| shape(t.map(|v| positions[v as usize])));
        let mut report =
            TriangulationReport { worst_shape: shapes.fold(f64::INFINITY, f64::min), ..Default::default() };
        for leaf in &self.leaves {
            let level = leaf.place.level as usize;
            report.leaves.resize(report.leaves.len().max(level + 1), 0);
            report.leaves[level] += 1;
        }
        Triangulation { triangles: self.triangles, report }
    }

    fn check(&self) -> Result<(), TriangulateError> {
        let Triangles { positions, triangles, faces, .. } = &self.triangles;
        let Some(wrong) = positions.iter().position(|x| !x.is_finite()) else { return Ok(()) };
        let first = triangles.iter().position(|t| t.contains(&(wrong as u32))).unwrap_or(0);
        Err(TriangulateError::LimitNotFinite { face: faces[first], at: positions[wrong] })
    }
}

/// The triangles around every vertex.
#[derive(Debug, Default)]
pub struct Around {
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0; vertices + 1];
        for &v in triangles.iter().flatten() {
            starts[v as usize + 1] += 1;
        }
        for v in 0..vertices {
            starts[v + 1] += starts[v];
        }
        let (mut next, mut around) = (starts.clone(), vec![0; 3 * triangles.len()]);
        for (t, corners) in triangles.iter().enumerate() {
            for &v in corners {
                around[next[v as usize] as usize] = t as u32;
                next[v as usize] += 1;
            }
        }
        Self { starts, triangles: around }
    }

    /// The triangles around a vertex.
    pub fn of(&self, v: u32) -> &[u32] {
        &self.triangles[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }
}
