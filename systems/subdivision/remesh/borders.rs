//! The borders of the source: where their edges lie on its sides, and what curve a plain one is.

use glam::DVec3;
use selvedge_components::curve::{Curve, CurveParameters};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{EdgeId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Address, Ends, LoopSurface, Side};

/// Where the border edges of the source lie on its sides.
pub(super) struct Borders<'a> {
    pub surface: &'a LoopSurface,
    /// By edge: the side and the step.
    pub of_edge: Vec<Option<(u32, u32)>>,
}

impl<'a> Borders<'a> {
    pub fn new(surface: &'a LoopSurface) -> Self {
        let mesh = &surface.mesh;
        let mut of_edge = vec![None; mesh.edge_count()];
        for (s, side) in surface.sides.iter().enumerate() {
            for (step, &v) in side.vertices[..side.edge_count()].iter().enumerate() {
                of_edge[mesh.edge(mesh.outgoing(v)).index()] = Some((s as u32, step as u32));
            }
        }
        Self { surface, of_edge }
    }

    /// The border edge that leaves or reaches the vertex at `address`.
    pub fn edge(&self, address: Address, leaving: bool) -> Option<EdgeId> {
        let mesh = &self.surface.mesh;
        match address {
            Address::Edge(e, _) => Some(e),
            Address::Corner(v) if leaving => Some(mesh.edge(mesh.outgoing(v))),
            Address::Corner(v) => mesh.ring(v).last().map(|h| mesh.edge(h.previous())),
            Address::Face(..) => None,
        }
    }

    /// How far along its edge a vertex of level `birth` is, in the direction of the side.
    pub fn within(&self, e: EdgeId, steps: u32, birth: u32) -> f64 {
        let mesh = &self.surface.mesh;
        let h = mesh.halfedge(e);
        let share = f64::from(steps) / f64::from(1_u32 << birth);
        if mesh.from(h) < mesh.to(h) { share } else { 1.0 - share }
    }

    /// The side and the place on it of a point on the border.
    pub fn place(&self, at: SurfacePoint) -> Option<(u32, f64)> {
        let mesh = &self.surface.mesh;
        let weights = [1.0 - at.st.x - at.st.y, at.st.x, at.st.y];
        let on_border = |i: &usize| mesh.twin(HalfedgeId::of(at.face, *i)).is_none();
        let off = |i: usize| weights[(i + 2) % 3].abs();
        let i = (0..3).filter(on_border).min_by(|&a, &b| off(a).total_cmp(&off(b)))?;
        let (side, step) = self.of_edge[mesh.edge(HalfedgeId::of(at.face, i)).index()]?;
        Some((side, f64::from(step) + weights[(i + 1) % 3].clamp(0.0, 1.0)))
    }
}

/// The parameter that a given side's own hierarchy has `x` root edges from the side's first vertex,
/// unwrapped along the curve: of a vertex of `level` the coefficient there.
pub(super) fn given_parameter(side: &Side, curve: &CurveParameters, x: f64, level: Option<u32>) -> f64 {
    // A place between vertices is looked up on a level so fine that the next one is as good.
    let fine = level.unwrap_or(BETWEEN);
    let steps = (x * (1_u64 << fine) as f64).round() as u64;
    side.curve_index(fine, steps).map_or(0.0, |index| {
        if level.is_some() { curve.coefficient(fine, index) } else { curve.parameter(fine, index) }
    })
}

/// The level on which places between vertices are looked up, to begin the search for the nearest.
const BETWEEN: u32 = 6;

/// Do all control points of a plain side lie on one line, in order along it?
pub(super) fn is_straight(surface: &LoopSurface, side: &Side) -> bool {
    if side.ends == Ends::Closed {
        return false;
    }
    let points: Vec<DVec3> = side.vertices.iter().map(|&v| effective(surface, v)).collect();
    let (a, b) = (points[0], points[points.len() - 1]);
    let way = (b - a).normalize_or_zero();
    let size = points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    // What rounding of the coordinates alone does.
    let slack = 8.0 * f64::EPSILON * size;
    points.windows(2).all(|p| (p[1] - p[0]).dot(way) > 0.0)
        && points.iter().all(|&p| (p - a - way * (p - a).dot(way)).length() <= slack)
}

fn effective(surface: &LoopSurface, v: VertexId) -> DVec3 {
    surface.points[v.index()] + surface.details.at(0, Address::Corner(v))
}

/// The border that a plain side has: a uniform cubic B-spline; at a corner it ends in the control
/// point there, as if the next one beyond were the mirror image of the one before.
#[derive(Debug)]
pub(super) struct PlainBorder {
    points: Vec<DVec3>,
    ends: Ends,
}

impl PlainBorder {
    pub fn new(surface: &LoopSurface, side: &Side) -> Self {
        Self { points: side.vertices.iter().map(|&v| effective(surface, v)).collect(), ends: side.ends }
    }

    fn control(&self, i: i64) -> DVec3 {
        let n = self.points.len() as i64;
        let at = |i: i64| self.points[i as usize];
        match self.ends {
            Ends::Closed => at(i.rem_euclid(n)),
            Ends::Corners if i < 0 => 2.0 * at(0) - at(1),
            Ends::Corners if i >= n => 2.0 * at(n - 1) - at(n - 2),
            Ends::Corners => at(i),
        }
    }

    fn spans(&self) -> usize {
        self.points.len() - usize::from(self.ends == Ends::Corners)
    }

    /// The first control point that counts at `u`, and how far beyond its successor `u` is.
    fn span(&self, u: f64) -> (i64, f64) {
        let n = self.spans() as f64;
        let x = match self.ends {
            Ends::Closed => (u - u.floor()) * n,
            Ends::Corners => u.clamp(0.0, 1.0) * n,
        };
        let i = x.floor().min(n - 1.0);
        (i as i64 - 1, x - i)
    }
}

impl Curve for PlainBorder {
    fn position(&self, u: f64) -> DVec3 {
        let (i, t) = self.span(u);
        let (s, t2) = (1.0 - t, t * t);
        let weights = [s * s * s, 4.0 + t2 * (3.0 * t - 6.0), 1.0 + 3.0 * t * (1.0 + t * s), t2 * t].map(|w| w / 6.0);
        (i..).zip(weights).fold(DVec3::ZERO, |sum, (i, w)| sum + w * self.control(i))
    }

    fn derivative(&self, u: f64) -> DVec3 {
        let (i, t) = self.span(u);
        let s = 1.0 - t;
        let weights = [-s * s, t * (3.0 * t - 4.0), 1.0 + t * (2.0 - 3.0 * t), t * t].map(|w| 0.5 * w);
        let sum = (i..).zip(weights).fold(DVec3::ZERO, |sum, (i, w)| sum + w * self.control(i));
        sum * self.spans() as f64
    }

    fn closed(&self) -> bool {
        self.ends == Ends::Closed
    }
}
