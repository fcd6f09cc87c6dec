//! The curves of scenarios.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge::curve::{BSpline, Circle, Curve, Polyline, RememberedCurve, Segment};
use selvedge::evaluate::{Evaluate, SurfacePoint};
use selvedge::mesh::{FaceId, HalfedgeId, VertexId};
use selvedge_systems::projected_curve::{Pick, ProjectedCurve};
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::subdivision::trim::Ground;

use super::Draw;

/// A plane in space: an origin and two unit directions.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    pub origin: DVec3,
    pub x: DVec3,
    pub y: DVec3,
}

impl Frame {
    /// Level, about a point.
    pub fn flat(origin: DVec3) -> Self {
        Self { origin, x: DVec3::X, y: DVec3::Y }
    }

    /// Tangent at a place, turned at random.
    pub fn tangent(ground: &Ground, at: SurfacePoint, draw: &mut Draw) -> Self {
        let jet = ground.limit().jet(at);
        let normal = jet.normal();
        let normal = if normal == DVec3::ZERO { DVec3::Z } else { normal };
        let (x, angle) = (normal.any_orthonormal_vector(), TAU * draw.unit());
        let x = x * angle.cos() + normal.cross(x) * angle.sin();
        Self { origin: jet.position, x, y: normal.cross(x) }
    }

    /// The same, moved within itself.
    pub fn moved(self, by: DVec2) -> Self {
        Self { origin: self.at(by), ..self }
    }

    fn normal(&self) -> DVec3 {
        self.x.cross(self.y)
    }

    fn at(&self, p: DVec2) -> DVec3 {
        self.origin + self.x * p.x + self.y * p.y
    }
}

/// What a curve looks like in its plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    Circle,
    Star,
    Blob,
    Slot,
    /// Straight, from beyond one rim to beyond the other where the surface is small.
    Line,
}

impl Shape {
    /// Any of them.
    pub fn any(draw: &mut Draw) -> Self {
        [Self::Circle, Self::Circle, Self::Star, Self::Blob, Self::Slot, Self::Line][draw.below(6)]
    }

    /// The plane curve of about radius `size`, counter-clockwise where it is closed.
    pub fn outline(self, frame: &Frame, size: f64, draw: &mut Draw) -> Option<Arc<dyn Curve>> {
        let at = |radius: f64, angle: f64| frame.at(radius * DVec2::from_angle(angle));
        Some(match self {
            Self::Circle => Arc::new(Circle::from_axes(frame.origin, frame.x, frame.y, size).ok()?),
            Self::Star => {
                let (tips, inner) = (3 + draw.below(3), draw.between(0.45, 0.8));
                let radius = |k: usize| if k.is_multiple_of(2) { size } else { inner * size };
                let corner = |k: usize| at(radius(k), TAU * k as f64 / (2 * tips) as f64);
                Arc::new(Polyline::closed((0..2 * tips).map(corner).collect()).ok()?)
            }
            Self::Blob => {
                let count = 6 + draw.below(5);
                let points = (0..count).map(|k| at(size * draw.between(0.6, 1.3), TAU * k as f64 / count as f64));
                Arc::new(BSpline::uniform_periodic(3, points.collect()).ok()?)
            }
            Self::Slot => {
                let width = draw.between(0.25, 0.6) * size;
                let corners =
                    [(-1., -1.), (0., -1.), (1., -1.), (1.25, 0.), (1., 1.), (0., 1.), (-1., 1.), (-1.25, 0.)];
                let points = corners.map(|(x, y)| frame.at(DVec2::new(x * size, y * width)));
                Arc::new(BSpline::uniform_periodic(3, points.to_vec()).ok()?)
            }
            Self::Line => {
                let far = 20.0 * size;
                Arc::new(Segment { start: frame.at(DVec2::new(-far, 0.0)), end: frame.at(DVec2::new(far, 0.0)) })
            }
        })
    }
}

/// Does a curve lie on a surface everywhere, and on one sheet?
pub fn lies_on(ground: &Ground, frame: &Frame, curve: &dyn Curve, within: f64) -> bool {
    (0..64).all(|k| {
        let Ok(found) = ground.index.closest(curve.position(f64::from(k) / 64.0)) else { return false };
        found.distance < within && ground.limit().jet(found.at).normal().dot(frame.normal()) > 0.5
    })
}

/// A plane curve carried onto the surface; where it leaves that, it goes on in its plane.
pub fn laid(ground: &Ground, frame: &Frame, plane: Arc<dyn Curve>) -> Option<Arc<dyn Curve>> {
    let onto =
        ProjectedCurve::new(Arc::clone(&plane), -frame.normal(), Arc::clone(&ground.index), Pick::Nearest).ok()?;
    let laid: Arc<dyn Curve> = Arc::new(Laid { onto, plane, near: 4.0 * ground.edge });
    Some(Arc::new(RememberedCurve::new(laid)))
}

#[derive(Debug)]
struct Laid {
    onto: ProjectedCurve<LimitSurface>,
    plane: Arc<dyn Curve>,
    near: f64,
}

impl Curve for Laid {
    fn position(&self, u: f64) -> DVec3 {
        let (on, plane) = (self.onto.position(u), self.plane.position(u));
        if on.distance(plane) < self.near { on } else { plane }
    }

    fn corners(&self) -> &[f64] {
        self.plane.corners()
    }

    fn closed(&self) -> bool {
        self.plane.closed()
    }
}

/// Exactly along the edges of a cage, once round a vertex.
#[derive(Debug)]
struct Round {
    limit: Arc<LimitSurface>,
    edges: Vec<HalfedgeId>,
    corners: Vec<f64>,
}

impl Curve for Round {
    fn position(&self, u: f64) -> DVec3 {
        let along = u.clamp(0.0, 1.0) * self.edges.len() as f64;
        let k = (along as usize).min(self.edges.len() - 1);
        let (h, t) = (self.edges[k], along - k as f64);
        let mut weights = [0.0; 3];
        weights[h.corner()] = 1.0 - t;
        weights[h.next().corner()] = t;
        self.limit.position(SurfacePoint::new(h.face(), weights[1], weights[2]))
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        true
    }
}

/// Along the edges round a vertex; `None` where that lies on a border.
pub fn round(ground: &Ground, vertex: VertexId) -> Option<Arc<dyn Curve>> {
    let mesh = &ground.surface.mesh;
    if mesh.is_border(vertex) {
        return None;
    }
    let (mut h, mut edges) = (mesh.outgoing(vertex), Vec::new());
    for _ in 0..mesh.valence(vertex) {
        edges.push(h.next());
        h = mesh.twin(h.previous())?;
    }
    let count = edges.len() as f64;
    let corners = (0..edges.len()).map(|k| k as f64 / count).collect();
    Some(Arc::new(Round { limit: Arc::clone(ground.limit()), edges, corners }))
}

/// Any place of a surface: within a face, at a vertex, or on an edge.
pub fn place(ground: &Ground, draw: &mut Draw) -> SurfacePoint {
    let mesh = &ground.surface.mesh;
    let face = FaceId::new(draw.below(mesh.face_count()));
    match draw.below(6) {
        0 => SurfacePoint::new(face, 0.0, 0.0),
        1 => SurfacePoint::new(face, draw.unit(), 0.0),
        _ => {
            let [s, t] = draw.in_triangle();
            SurfacePoint::new(face, s, t)
        }
    }
}
