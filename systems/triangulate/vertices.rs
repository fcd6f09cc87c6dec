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
use super::{Normals, Subject};
use crate::parallel::{map_dear_in_order, map_in_order};
use crate::subdivision::limit::Piece;

#[derive(Clone, Copy)]
struct Vertex {
    position: DVec3,
    normal: DVec3,
    origin: SurfacePoint,
}

/// The vertices of `names`, and no triangles yet.
pub fn evaluate(subject: &Subject, names: &Names, normals: Normals) -> Triangles {
    let mesh = &*subject.surface.mesh;
    let corners = map_in_order(names.corner_count(), |v| {
        let h = corner_halfedge(mesh, VertexId::new(v));
        let origin = on_halfedge(h, 0.0);
        let mut vertex = Evaluator::new(subject, origin.face).vertex(origin, normals);
        // A face knows one of the lines that meet in a corner; the point is that of the older.
        vertex.position = subject.limit.on_border(VertexId::new(v)).unwrap_or(vertex.position);
        // A face's derivatives say less there: a smooth border vertex has one normal, its faces any angle.
        match (normals, subject.limit.normal_at(h)) {
            (Normals::Without, _) | (_, DVec3::ZERO) => vertex,
            (Normals::OfLimit, normal) => Vertex { normal, ..vertex },
        }
    });
    let first_edges = first_edges(mesh);
    let faces = map_dear_in_order(mesh.face_count(), |f| {
        let face = FaceId::new(f);
        let evaluator = Evaluator::new(subject, face);
        let on_edges = (first_edges[f]..first_edges[f + 1]).flat_map(|e| {
            let e = EdgeId::new(e);
            names.on_edge(e).iter().map(move |&steps| edge_origin(mesh, e, steps, names.n))
        });
        let inside =
            names.inside(face).iter().map(|&(i, j)| SurfacePoint::new(face, part(i, names.n), part(j, names.n)));
        let of = |origins: &mut dyn Iterator<Item = SurfacePoint>| -> Vec<Vertex> {
            origins.map(|origin| evaluator.vertex(origin, normals)).collect()
        };
        let mut on_edges = on_edges;
        let mut inside = inside;
        [of(&mut on_edges), of(&mut inside)]
    });
    let mut all = Triangles::default();
    all.positions.reserve(names.count());
    all.origins.reserve(names.count());
    let mut put = |vertices: &[Vertex]| {
        all.positions.extend(vertices.iter().map(|v| v.position));
        all.origins.extend(vertices.iter().map(|v| v.origin));
        if normals == Normals::OfLimit {
            all.normals.extend(vertices.iter().map(|v| v.normal));
        }
    };
    put(&corners);
    faces.iter().for_each(|[on_edges, _]| put(on_edges));
    faces.iter().for_each(|[_, inside]| put(inside));
    all
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
