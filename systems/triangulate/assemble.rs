//! A forest becomes triangles: names for the vertices, closures for the leaves.

use glam::{DVec2, DVec3};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId};
use selvedge_components::subdivision::{Address, FINEST_LEVEL, FaceCode, NONE};
use selvedge_components::triangles::Triangles;

use super::closure;
use super::forest::Forest;
use super::measure::{Over, shape, squared_to_triangle};
use super::pyramid::{Floor, Pyramid, locate};
use super::{Normals, Subject, TriangulateError, Triangulation, TriangulationReport};

/// The triangles of a forest, and how they came about.
#[derive(Debug)]
pub struct Assembly {
    /// The levels under the leaves.
    pub pyramid: Pyramid,
    triangles: Triangles,
    /// The root face of each triangle.
    faces: Vec<FaceId>,
    /// By level and place of a leaf: its first triangle, and the one after its last.
    spans: Vec<Vec<[u32; 2]>>,
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
    let mut assembly = Assembly { pyramid, triangles, faces: Vec::new(), spans: Vec::new() };
    assembly.cut_leaves(forest, &names);
    Ok(assembly)
}

impl Assembly {
    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.triangles.triangles.len()
    }

    /// The squared distance of a point of the limit surface over the leaf at `place` of a level to the
    /// triangles. Near an irregular vertex the surface slides: the foot of a point may lie beyond the
    /// leaf's own triangles, on those around.
    pub fn near<'a>(&'a self, around: &'a Around, level: usize, place: usize) -> impl Fn(DVec3) -> f64 + 'a {
        let [begin, end] = self.spans[level][place].map(|t| t as usize);
        let own = &self.triangles.triangles[begin..end];
        let corners = |t: [u32; 3]| t.map(|v| self.triangles.positions[v as usize]);
        move |x| {
            let inside = |t: &[u32; 3]| Over::new(x, corners(*t)).filter(Over::inside);
            if let Some(over) = own.iter().find_map(inside) {
                return over.squared;
            }
            let neighbours = own.iter().flatten().flat_map(|&v| around.of(v));
            let distances = neighbours.map(|&t| squared_to_triangle(x, corners(self.triangles.triangles[t as usize])));
            distances.fold(f64::INFINITY, f64::min)
        }
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
        Triangulation { triangles: self.triangles, faces: self.faces, report }
    }

    /// Cuts every leaf into its triangles, in the order of root faces and paths.
    fn cut_leaves(&mut self, forest: &Forest, names: &[Vec<u32>]) {
        let finest = self.pyramid.floors.len() as u32;
        let neighbours: Vec<Finer> =
            self.pyramid.floors.windows(2).enumerate().map(|(l, f)| Finer::new(l, f, forest)).collect();
        let mut leaves: Vec<(FaceCode, u32, u32)> = Vec::with_capacity(forest.leaf_count());
        for (l, floor) in self.pyramid.floors.iter().enumerate() {
            let down = 2 * (finest - 1 - l as u32);
            let codes = floor.faces.iter().map(|&f| FaceCode(floor.level.mesh.codes[f as usize].0 << down));
            leaves.extend(codes.enumerate().map(|(place, code)| (code, l as u32, place as u32)));
            self.spans.push(vec![[0; 2]; floor.faces.len()]);
        }
        leaves.sort_unstable();
        let Triangles { positions, triangles, .. } = &mut self.triangles;
        for (code, l, place) in leaves {
            let (l, place) = (l as usize, place as usize);
            let floor = &self.pyramid.floors[l];
            let face = floor.faces[place];
            let corners = floor.level.mesh.corners[face as usize].map(|v| names[l][v as usize]);
            let halves = match neighbours.get(l) {
                Some(finer) => {
                    [0, 1, 2].map(|e| Some(names[l + 1][finer.half(&self.pyramid.floors, l, 3 * face + e)? as usize]))
                }
                None => [None; 3],
            };
            let begin = triangles.len() as u32;
            closure::close(corners, halves, |v| positions[v as usize], |t| triangles.push(t));
            self.spans[l][place] = [begin, triangles.len() as u32];
            self.faces.resize(triangles.len(), code.root_face(finest - 1));
        }
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
