//! Limit positions and tangents at vertices.

use core::f64::consts::PI;

use glam::DVec3;

use super::PlainLoop;
use super::topology::VertexRule;
use crate::mesh::{HalfedgeId, VertexId};
use crate::subdivision::boxspline::Vector;
use crate::subdivision::masks;

impl PlainLoop {
    /// Where the surface passes for the vertex `v`.
    ///
    /// Interior: `1 - k w` of itself and `w` of each neighbour, `w` as in [`masks::limit_weight`].
    /// Border: `(1, 4, 1) / 6` along the border. Corner: the control point.
    pub fn vertex_limit(&self, v: VertexId) -> DVec3 {
        let (mesh, q) = (self.topology().mesh(), self.point(v));
        match self.topology().rule(v) {
            VertexRule::Interior => {
                let k = mesh.valence(v) as usize;
                let w = self.topology().mask(k).limit;
                let sum = mesh.ring(v).fold(DVec3::ZERO, |sum, h| sum + self.point(mesh.to(h)));
                q * (1.0 - k as f64 * w) + sum * w
            }
            VertexRule::Border => {
                let [next, previous] = self.border_neighbours(v);
                border_limit(q, next, previous)
            }
            VertexRule::Corner => q,
        }
    }

    /// The tangents at the vertex that `h` leaves, along `h` and along the other edge of its face at
    /// that vertex.
    ///
    /// At an interior vertex they are the images of the two edges under the affine map that is the
    /// subdominant eigenvector's part of the ring: `2/k sum cos(2 pi (i - j) / k) r_i` along edge
    /// `j`. At valence 6, at every edge of a border that runs along it, at regular border vertices and
    /// at corners of valence 2 and 3 they are the derivatives by the face's coordinates; elsewhere
    /// those derivatives vanish or grow without bound as the vertex is approached, and these
    /// tangents are what they are proportional to.
    pub fn vertex_tangents(&self, h: HalfedgeId) -> (DVec3, DVec3) {
        let mesh = self.topology().mesh();
        let v = mesh.from(h);
        let ring: Vec<HalfedgeId> = mesh.ring(v).collect();
        let first = ring.iter().position(|&g| g == h).unwrap_or(0);
        let spokes: Vec<DVec3> = mesh.neighbours(v).map(|n| self.point(n)).collect();
        spoke_tangents(self.topology().rule(v), self.point(v), &spokes, first)
    }

    /// The unit normal at the vertex `v`, outward for counter-clockwise faces; zero where the
    /// surface has none.
    ///
    /// At a border it is that of the border's tangent and the transverse one; at a corner that of its
    /// two border edges, or of one and the ring's middle edge where these two are parallel.
    pub fn vertex_normal(&self, v: VertexId) -> DVec3 {
        let mesh = self.topology().mesh();
        let spokes: Vec<DVec3> = mesh.neighbours(v).map(|n| self.point(n)).collect();
        vertex_normal(self.topology().rule(v), self.point(v), &spokes)
    }

    /// The next and the previous border vertex's control points.
    pub(super) fn border_neighbours(&self, v: VertexId) -> [DVec3; 2] {
        let mesh = self.topology().mesh();
        let next = mesh.to(mesh.outgoing(v));
        let previous = mesh.last_border_neighbour(v).expect("a border vertex has a previous one");
        [self.point(next), self.point(previous)]
    }
}

/// The unit normal at a vertex with control point `q` and neighbours `spokes`, counter-clockwise and on
/// a border from the next border vertex to the previous one: see [`PlainLoop::vertex_normal`].
pub fn vertex_normal(rule: VertexRule, q: DVec3, spokes: &[DVec3]) -> DVec3 {
    let (a, b) = match rule {
        VertexRule::Interior => spoke_tangents(VertexRule::Interior, q, spokes, 0),
        VertexRule::Border => border_frame(q, spokes),
        VertexRule::Corner => return corner_normal(q, spokes),
    };
    a.cross(b).normalize_or_zero()
}

/// `(1, 4, 1) / 6`: a cubic B-spline at its knot.
#[inline(always)]
pub(super) fn border_limit<V: Vector>(q: V, next: V, previous: V) -> V {
    ((next + previous) + q * 4.0) * (1.0 / 6.0)
}

/// The tangents along spokes `first` and `first + 1`.
pub(super) fn spoke_tangents(rule: VertexRule, q: DVec3, spokes: &[DVec3], first: usize) -> (DVec3, DVec3) {
    let along = |j: usize| match rule {
        VertexRule::Interior => interior_tangent(spokes, j),
        VertexRule::Border => {
            let (along, across) = border_frame(q, spokes);
            let angle = PI * j as f64 / (spokes.len() - 1) as f64;
            // Exactly along the border at both of its edges, whatever the rounding of a sine.
            if j == 0 || j + 1 == spokes.len() {
                along * angle.cos()
            } else {
                along * angle.cos() + across * angle.sin()
            }
        }
        VertexRule::Corner => corner_tangent(q, spokes, j),
    };
    (along(first), along((first + 1) % spokes.len()))
}

fn interior_tangent(spokes: &[DVec3], j: usize) -> DVec3 {
    let k = spokes.len();
    let weigh =
        |sum: DVec3, (i, &r): (usize, &DVec3)| sum + r * masks::tangent_weights(((i + k - j) % k) as u32, k as u32).0;
    spokes.iter().enumerate().fold(DVec3::ZERO, weigh) * (2.0 / k as f64)
}

/// The border's tangent towards the next border vertex and the transverse one, inward, at a smooth
/// border vertex.
///
/// The transverse weights are the left eigenvector of the one-sided subdivision matrix to the
/// eigenvalue `lambda = 3/8 + cos(theta) / 4`, `theta = pi / (k - 1)`: `sin(i theta)` on spoke `i`
/// inside, `a = (sin theta - sum) / (8 lambda - 2)` on both border spokes. Valence 2 has no spoke
/// inside: there the second difference of the border is what bends the face, and its eigenvalue
/// is 1/4.
fn border_frame(q: DVec3, spokes: &[DVec3]) -> (DVec3, DVec3) {
    let k = spokes.len();
    let (head, tail) = (spokes[0], spokes[k - 1]);
    let along = (head - tail) * 0.5;
    if k == 2 {
        return (along, (head + tail) * 0.5 - q);
    }
    let theta = PI / (k - 1) as f64;
    let inside = spokes[1..k - 1].iter().enumerate().map(|(i, &r)| (r, (theta * (i + 1) as f64).sin()));
    let (sum, total) = inside.fold((DVec3::ZERO, 0.0), |(sum, total), (r, w)| (sum + (r - q) * w, total + w));
    let end = (theta.sin() - total) / (1.0 + 2.0 * theta.cos());
    let across = sum + ((head - q) + (tail - q)) * end;
    (along, across * (2.0 / (k - 1) as f64))
}

/// Along a border edge the end tangent of the border, a spline without bending there. Along the
/// spoke inside at valence 3 the sum of both, the limit of the spoke's own ratio. For more spokes
/// there is no finite limit that all faces share; the control mesh's edge stands for it.
fn corner_tangent(q: DVec3, spokes: &[DVec3], j: usize) -> DVec3 {
    if spokes.len() == 3 && j == 1 { (spokes[0] - q) + (spokes[2] - q) } else { spokes[j] - q }
}

fn corner_normal(q: DVec3, spokes: &[DVec3]) -> DVec3 {
    let k = spokes.len();
    let (head, tail) = (spokes[0] - q, spokes[k - 1] - q);
    let across = head.cross(tail);
    // Squared sine of the angle between the border edges: below it rounding alone decides.
    if across.length_squared() <= f64::EPSILON * head.length_squared() * tail.length_squared() {
        return head.cross(spokes[k / 2] - q).normalize_or_zero();
    }
    // At a reflex corner the product points inward; the faces' own areas tell.
    let areas = spokes.windows(2).fold(DVec3::ZERO, |sum, r| sum + (r[0] - q).cross(r[1] - q));
    if areas.dot(across) < 0.0 { -across.normalize_or_zero() } else { across.normalize_or_zero() }
}
