//! Where the vertices stand.
//!
//! A vertex is evaluated on the first face that has it, and as that face evaluates: how the forest grew
//! leaves no trace in its bits.

use glam::{DVec2, DVec3};
use selvedge_components::evaluate::{Evaluate, Jet, SurfacePoint};
use selvedge_components::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::triangles::Triangles;

use super::names::Names;
use super::{DEAR, Normals, QUANTUM, Subject, quantum};
use crate::parallel::{map_dear_in_order, map_in_order};
use crate::subdivision::limit::Piece;

#[derive(Clone, Copy)]
struct Vertex {
    position: DVec3,
    normal: DVec3,
    origin: SurfacePoint,
}

/// The vertices of a forest in the making: root vertices, then face by face those inside its edges and those
/// inside it.
#[derive(Debug)]
pub struct VertexWork {
    first_edges: Vec<usize>,
    /// How many root vertices, and of how many root faces the rest, are evaluated.
    corners: usize,
    faces: usize,
    /// Root vertices and those inside edges.
    on_edges: Triangles,
    inside: Triangles,
}

impl VertexWork {
    /// Begins with the vertices of `names`.
    pub fn new(mesh: &Connectivity, names: &Names) -> Self {
        let mut work = Self {
            first_edges: first_edges(mesh),
            corners: 0,
            faces: 0,
            on_edges: Triangles::default(),
            inside: Triangles::default(),
        };
        work.on_edges.positions.reserve(names.count());
        work.on_edges.origins.reserve(names.count());
        work
    }

    /// Evaluates some more vertices. Returns what that costs: nothing when all are there.
    pub fn advance(&mut self, subject: &Subject, names: &Names, normals: Normals) -> usize {
        if self.corners < names.corner_count() {
            let range = self.corners..names.corner_count().min(self.corners + QUANTUM / DEAR);
            let count = range.len();
            self.corners = range.end;
            let vertices = map_in_order(count, |v| corner(subject, VertexId::new(range.start + v), normals));
            put(&mut self.on_edges, &vertices, normals);
            return DEAR * count;
        }
        let first = self.faces;
        let cost = |f: usize| {
            let edges = (self.first_edges[f]..self.first_edges[f + 1]).map(|e| names.on_edge(EdgeId::new(e)).len());
            let vertices = edges.sum::<usize>() + names.inside(FaceId::new(f)).len();
            if subject.limit.is_polynomial(FaceId::new(f)) { vertices } else { DEAR * vertices }
        };
        let (end, spent) = quantum(first, self.first_edges.len() - 1, cost);
        let faces = map_dear_in_order(end - first, |f| self.of_face(subject, names, first + f, normals));
        for [on_edges, inside] in &faces {
            put(&mut self.on_edges, on_edges, normals);
            put(&mut self.inside, inside, normals);
        }
        self.faces = end;
        spent
    }

    /// The vertices of a root face: those inside its edges that no face before it has, and those inside it.
    fn of_face(&self, subject: &Subject, names: &Names, f: usize, normals: Normals) -> [Vec<Vertex>; 2] {
        let (mesh, face) = (&*subject.surface.mesh, FaceId::new(f));
        let evaluator = Evaluator::new(subject, face);
        let on_edges = (self.first_edges[f]..self.first_edges[f + 1]).flat_map(|e| {
            let e = EdgeId::new(e);
            names.on_edge(e).iter().map(move |&steps| edge_origin(mesh, e, steps, names.n))
        });
        let inside =
            names.inside(face).iter().map(|&(i, j)| SurfacePoint::new(face, part(i, names.n), part(j, names.n)));
        let vertex = |origin: SurfacePoint| evaluator.vertex(origin, normals);
        [on_edges.map(vertex).collect(), inside.map(vertex).collect()]
    }

    /// The vertices, by their names, and no triangles yet.
    pub fn finish(self) -> Triangles {
        let (mut all, inside) = (self.on_edges, self.inside);
        all.positions.extend(inside.positions);
        all.origins.extend(inside.origins);
        all.normals.extend(inside.normals);
        all
    }
}

fn put(all: &mut Triangles, vertices: &[Vertex], normals: Normals) {
    all.positions.extend(vertices.iter().map(|v| v.position));
    all.origins.extend(vertices.iter().map(|v| v.origin));
    if normals == Normals::OfLimit {
        all.normals.extend(vertices.iter().map(|v| v.normal));
    }
}

/// A root vertex.
fn corner(subject: &Subject, v: VertexId, normals: Normals) -> Vertex {
    let h = corner_halfedge(&subject.surface.mesh, v);
    let origin = on_halfedge(h, 0.0);
    let mut vertex = Evaluator::new(subject, origin.face).vertex(origin, normals);
    // A face knows one of the lines that meet in a corner; the point is that of the older.
    vertex.position = subject.limit.on_border(v).unwrap_or(vertex.position);
    if normals == Normals::OfLimit {
        // A face's derivatives say less there: a smooth border vertex has one normal, its faces any angle.
        let normal = subject.limit.normal_at(h);
        vertex.normal = if normal == DVec3::ZERO { vertex.normal } else { normal };
    }
    vertex
}

/// By face: the first edge that no face before it has. Edges are numbered by the first face that has
/// them.
fn first_edges(mesh: &Connectivity) -> Vec<usize> {
    let mut first = Vec::with_capacity(mesh.face_count() + 1);
    let mut next = 0;
    for f in 0..=mesh.face_count() {
        while next < mesh.edge_count() && mesh.halfedge(EdgeId::new(next)).face().index() < f {
            next += 1;
        }
        first.push(next);
    }
    first
}

/// What evaluates a face.
struct Evaluator<'a> {
    subject: &'a Subject,
    quartic: Option<Quartic>,
}

impl<'a> Evaluator<'a> {
    fn new(subject: &'a Subject, face: FaceId) -> Self {
        let quartic = match subject.limit.piece(subject.limit.root(face)) {
            Some(Piece::Quartic(quartic)) => Some(quartic),
            _ => None,
        };
        Self { subject, quartic }
    }

    fn vertex(&self, origin: SurfacePoint, normals: Normals) -> Vertex {
        let jet = match (&self.quartic, normals) {
            (Some(quartic), _) => quartic.jet(origin.st.x, origin.st.y),
            (None, Normals::OfLimit) => self.subject.limit.jet(origin),
            (None, Normals::Without) => Jet { position: self.subject.limit.position(origin), ..Jet::default() },
        };
        Vertex { position: jet.position, normal: jet.normal(), origin }
    }
}

fn part(steps: u32, n: u32) -> f64 {
    f64::from(steps) / f64::from(n)
}

fn corner_halfedge(mesh: &Connectivity, v: VertexId) -> HalfedgeId {
    mesh.ring(v).min().unwrap_or(mesh.outgoing(v))
}

fn edge_origin(mesh: &Connectivity, e: EdgeId, steps: u32, n: u32) -> SurfacePoint {
    let h = mesh.halfedge(e);
    on_halfedge(h, if mesh.from(h) < mesh.to(h) { part(steps, n) } else { 1.0 - part(steps, n) })
}

fn on_halfedge(h: HalfedgeId, along: f64) -> SurfacePoint {
    let mut weights = [0.0; 3];
    weights[h.corner()] = 1.0 - along;
    weights[(h.corner() + 1) % 3] = along;
    SurfacePoint { face: h.face(), st: DVec2::new(weights[1], weights[2]) }
}
