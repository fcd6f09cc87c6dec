//! A forest becomes triangles: names for the vertices, closures for the leaves.

use core::ops::Range;

use glam::{DVec2, DVec3};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, HalfedgeId};
use selvedge_components::subdivision::{Address, FINEST_LEVEL, FaceCode, NONE};
use selvedge_components::triangles::Triangles;
use smallvec::SmallVec;

use super::closure;
use super::forest::Forest;
use super::measure::{Facet, Over, shape};
use super::pyramid::{Floor, Pyramid, locate};
use super::sample::{LeafPlace, Pieces};
use super::{Normals, Subject, TriangulateError, Triangulation, TriangulationReport};

/// The triangles of a forest, and how they came about.
#[derive(Debug)]
pub struct Assembly {
    /// The levels under the leaves.
    pub pyramid: Pyramid,
    triangles: Triangles,
    /// By level and vertex: its index among the positions.
    names: Vec<Vec<u32>>,
    /// By level and place of a leaf.
    cuts: Vec<Vec<Cut>>,
}

/// How a leaf was cut.
#[derive(Clone, Copy, Debug, Default)]
struct Cut {
    /// Its first triangle.
    first: u32,
    /// The vertices that halve its edges.
    halves: [Option<u32>; 3],
}

impl Cut {
    /// Its triangles: one more for each vertex inside an edge.
    fn triangles(&self) -> Range<usize> {
        let first = self.first as usize;
        first..first + 1 + self.halves.iter().flatten().count()
    }
}

/// Builds the triangles of `forest`.
///
/// # Errors
/// [`TriangulateError::LimitNotFinite`].
pub fn assemble(subject: &Subject, forest: &Forest, normals: Normals) -> Result<Assembly, TriangulateError> {
    let pyramid = Pyramid::new(subject, &forest.leaves())?;
    let (names, addresses) = number(subject, &pyramid);
    let mut positions = vec![DVec3::ZERO; addresses.len()];
    for (floor, names) in pyramid.floors.iter().zip(&names) {
        for (&name, &x) in names.iter().zip(&floor.limit).filter(|(name, _)| **name != NONE) {
            positions[name as usize] = x;
        }
    }
    let normals = match normals {
        Normals::OfLimit => pyramid.normals(subject, &names, addresses.len()),
        Normals::Without => Vec::new(),
    };
    let origins = addresses.iter().map(|&a| origin(&subject.surface.mesh, a)).collect();
    let triangles = Triangles { positions, normals, origins, ..Triangles::default() };
    let mut assembly = Assembly { pyramid, triangles, names, cuts: Vec::new() };
    assembly.cut_leaves(forest);
    Ok(assembly)
}

impl Assembly {
    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.triangles.triangles.len()
    }

    /// The squared distance of a point to the triangles of a leaf.
    pub fn own(&self, leaf: LeafPlace) -> impl Fn(DVec3) -> f64 + use<> {
        let facets: SmallVec<[Facet; 4]> = self.indices(leaf).iter().map(|&t| Facet::new(self.positions(t))).collect();
        move |x| {
            let inside = |t: &Facet| t.under(x).filter(Over::inside);
            match facets.iter().find_map(inside) {
                Some(over) => over.squared,
                None => facets.iter().map(|t| t.squared(x)).fold(f64::INFINITY, f64::min),
            }
        }
    }

    /// The squared distance of a point of the limit surface over a leaf to all triangles. Near an
    /// irregular vertex the surface slides: the foot may lie beyond the leaf's own triangles, on those
    /// around.
    pub fn near<'a>(&'a self, around: &'a Around, leaf: LeafPlace) -> impl Fn(DVec3) -> f64 + 'a {
        let own = self.own(leaf);
        let mut beyond: Vec<u32> = self.indices(leaf).iter().flatten().flat_map(|&v| around.of(v)).copied().collect();
        beyond.sort_unstable();
        beyond.dedup();
        let facets: Vec<Facet> =
            beyond.into_iter().map(|t| Facet::new(self.positions(self.triangles.triangles[t as usize]))).collect();
        move |x| facets.iter().map(|t| t.squared(x)).fold(own(x), f64::min)
    }

    fn indices(&self, (level, place): LeafPlace) -> &[[u32; 3]] {
        &self.triangles.triangles[self.cuts[level][place].triangles()]
    }

    fn positions(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|v| self.triangles.positions[v as usize])
    }

    /// The triangles of a leaf: for each corner its position, and its weights on the leaf.
    pub fn pieces(&self, (level, place): LeafPlace) -> Pieces {
        let Cut { halves, .. } = self.cuts[level][place];
        let corners = self.corners(level, place);
        let weights = |v: u32| -> [f64; 3] {
            core::array::from_fn(|c| {
                let half = halves[c] == Some(v) || halves[(c + 2) % 3] == Some(v);
                if corners[c] == v {
                    1.0
                } else if half {
                    0.5
                } else {
                    0.0
                }
            })
        };
        let piece = |t: &[u32; 3]| t.map(|v| (self.triangles.positions[v as usize], weights(v)));
        self.indices((level, place)).iter().map(piece).collect()
    }

    fn corners(&self, level: usize, place: usize) -> [u32; 3] {
        let floor = &self.pyramid.floors[level];
        floor.level.mesh.corners[floor.faces[place] as usize].map(|v| self.names[level][v as usize])
    }

    /// The triangles around every vertex.
    pub fn around(&self) -> Around {
        Around::new(self.triangles.positions.len(), &self.triangles.triangles)
    }

    /// Hands the triangles out.
    pub fn finish(self) -> Triangulation {
        let positions = &self.triangles.positions;
        let shapes = self.triangles.triangles.iter().map(|t| shape(t.map(|v| positions[v as usize])));
        let report = TriangulationReport {
            leaves: self.pyramid.floors.iter().map(|f| f.faces.len()).collect(),
            worst_shape: shapes.fold(f64::INFINITY, f64::min),
            chord: None,
        };
        Triangulation { triangles: self.triangles, report }
    }

    /// Cuts every leaf into its triangles, in the order of root faces and paths.
    fn cut_leaves(&mut self, forest: &Forest) {
        let floors = &self.pyramid.floors;
        let finer: Vec<Finer> = floors.windows(2).enumerate().map(|(l, pair)| Finer::new(l, pair, forest)).collect();
        for floor in floors {
            self.cuts.push(vec![Cut::default(); floor.faces.len()]);
        }
        for (code, l, place) in self.leaves_in_order(forest) {
            let corners = self.corners(l, place);
            let halves = match finer.get(l) {
                Some(finer) => finer.halves(&self.pyramid.floors, l, self.pyramid.floors[l].faces[place]),
                None => [None; 3],
            };
            let halves = halves.map(|half| half.map(|v| self.names[l + 1][v as usize]));
            let Triangles { positions, triangles, faces, .. } = &mut self.triangles;
            self.cuts[l][place] = Cut { first: triangles.len() as u32, halves };
            closure::close(corners, halves, |v| positions[v as usize], |t| triangles.push(t));
            faces.resize(triangles.len(), code.root_face(self.pyramid.floors.len() as u32 - 1));
        }
    }

    /// Level and place of every leaf, with its code brought to the finest level there is, by which they
    /// ascend.
    fn leaves_in_order(&self, forest: &Forest) -> Vec<(FaceCode, usize, usize)> {
        let finest = self.pyramid.floors.len() - 1;
        let mut leaves = Vec::with_capacity(forest.leaf_count());
        for (l, floor) in self.pyramid.floors.iter().enumerate() {
            let down = 2 * (finest - l);
            let codes = floor.faces.iter().map(|&f| FaceCode(floor.level.mesh.codes[f as usize].0 << down));
            leaves.extend(codes.enumerate().map(|(place, code)| (code, l, place)));
        }
        leaves.sort_unstable();
        leaves
    }
}

/// The triangles around every vertex.
#[derive(Debug)]
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

    fn of(&self, v: u32) -> &[u32] {
        &self.triangles[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }
}

/// Which faces of a level are quartered, and where their quarters are.
struct Finer {
    split: Vec<bool>,
    family: Vec<u32>,
}

impl Finer {
    fn new(level: usize, floors: &[Floor], forest: &Forest) -> Self {
        let (coarse, fine) = (&floors[0].level.mesh, &floors[1].level.mesh);
        let mut split = vec![false; coarse.corners.len()];
        for f in locate(&coarse.codes, forest.split_faces(level as u32)) {
            split[f as usize] = true;
        }
        let mut family = vec![NONE; coarse.corners.len()];
        for g in 0..fine.corners.len() as u32 / 4 {
            family[fine.parent(g) as usize] = g;
        }
        Self { split, family }
    }

    /// The vertices of the next level that halve the edges of a face.
    fn halves(&self, floors: &[Floor], level: usize, face: u32) -> [Option<u32>; 3] {
        [0, 1, 2].map(|edge| self.half(floors, level, 3 * face + edge))
    }

    /// The vertex of the next level that halves this half-edge, if the neighbour across is quartered.
    fn half(&self, floors: &[Floor], level: usize, halfedge: u32) -> Option<u32> {
        let twin = floors[level].level.mesh.twin(halfedge)?;
        let (neighbour, edge) = (twin / 3, twin % 3);
        if !self.split[neighbour as usize] {
            return None;
        }
        // The first half of edge `e` is half-edge `e` of child `e`, which ends in the middle.
        let child = 4 * self.family[neighbour as usize] + edge;
        Some(floors[level + 1].level.mesh.to(3 * child + edge))
    }
}

/// Names all vertices by their addresses on the finest level there is: the names by level and vertex,
/// and the addresses by name.
fn number(subject: &Subject, pyramid: &Pyramid) -> (Vec<Vec<u32>>, Vec<Address>) {
    let mesh = &*subject.surface.mesh;
    let addresses: Vec<Vec<Address>> = pyramid.floors.iter().map(|f| f.level.mesh.addresses(mesh)).collect();
    let mut order: Vec<(Address, u32)> = Vec::new();
    let mut names = pyramid.name(|l, v| {
        let found = order.len() as u32;
        order.push((finest(addresses[l][v as usize], l as u32), found));
        found
    });
    order.sort_unstable();
    let mut rank = vec![NONE; order.len()];
    for (name, &(_, found)) in order.iter().enumerate() {
        rank[found as usize] = name as u32;
    }
    for name in names.iter_mut().flatten().filter(|name| **name != NONE) {
        *name = rank[*name as usize];
    }
    (names, order.into_iter().map(|(address, _)| address).collect())
}

/// The same place in steps of the finest level.
fn finest(address: Address, level: u32) -> Address {
    let shift = FINEST_LEVEL - level;
    match address {
        Address::Corner(_) => address,
        Address::Edge(e, steps) => Address::Edge(e, steps << shift),
        Address::Face(f, i, j) => Address::Face(f, i << shift, j << shift),
    }
}

/// The place of an address of the finest level on the first face that has it.
fn origin(mesh: &Connectivity, address: Address) -> SurfacePoint {
    let part = |steps: u32| f64::from(steps) / f64::from(1_u32 << FINEST_LEVEL);
    let on_edge = |h: HalfedgeId, along: f64| {
        let mut weights = [0.0; 3];
        weights[h.corner()] = 1.0 - along;
        weights[(h.corner() + 1) % 3] = along;
        SurfacePoint { face: h.face(), st: DVec2::new(weights[1], weights[2]) }
    };
    match address {
        Address::Corner(v) => on_edge(mesh.ring(v).min().unwrap_or(mesh.outgoing(v)), 0.0),
        Address::Edge(e, steps) => {
            let h = mesh.halfedge(e);
            on_edge(h, if mesh.from(h) < mesh.to(h) { part(steps) } else { 1.0 - part(steps) })
        }
        Address::Face(face, i, j) => SurfacePoint::new(face, part(i), part(j)),
    }
}
