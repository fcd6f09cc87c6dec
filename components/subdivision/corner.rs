//! What acts on the interior edges that start at a border vertex that is not lattice-regular.

use core::f64::consts::PI;

use glam::DVec3;

use super::level::{NONE, sample};
use super::masks::corner_weight;
use super::surface::{Border, CornerRule, Ends, LoopSurface, Side};
use crate::mesh::{Connectivity, HalfedgeId, VertexId};

/// Lattice weight of an interior edge on its far end: gamma for `theta` of 60 degrees.
pub const LATTICE_WEIGHT: f64 = 0.375;

/// Below this sine of their angle two tangents count as parallel: the angle is known to about 1e-7,
/// so the plane that they span would be off by a thousandth.
pub(super) const PARALLEL: f64 = 1e-4;

/// The rule of one special border vertex, fixed on the root mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecialCorner {
    /// The vertex of the root mesh.
    pub vertex: VertexId,
    /// gamma: the weight of the far end of an interior edge that starts here.
    pub weight: f64,
    /// What its new edge points are drawn to.
    pub pull: Pull,
    /// The sides that leave and that arrive here (both the same for a smooth vertex).
    pub sides: [u32; 2],
}

/// What the new points on the interior edges at a corner are drawn to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pull {
    /// Nothing.
    None,
    /// The quadratic through the new border samples and the corner's detail: `e <- (1 - s) e + s Q`.
    /// Linear in the control points, and exact for quadratics.
    Quadratic {
        /// `s = 1 - mu / (3/8 + cos(pi / (k - 1)) / 4)` with `mu = 3/8`: the in-plane and normal
        /// zero-boundary modes then shrink by 3/8, faster than the boundary's 1/2.
        s: f64,
    },
    /// The tangent plane, at the distance of the point itself: the seed's flatness, which is not
    /// linear in the control points. [Litke et al. 2001, Section 2.1]
    Flat {
        /// `s = 1 - 1 / (4 gamma + cos(pi / (k - 1)))`.
        s: f64,
        /// Unit normal of the plane of the two tangents.
        normal: DVec3,
    },
}

/// The special border vertices of a surface: those on given borders where the lattice weights do
/// not serve. Pure Loop borders have none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CornerTable {
    /// The rules, ascending by vertex.
    pub corners: Vec<SpecialCorner>,
}

impl CornerTable {
    /// Finds the special vertices of `surface`.
    pub fn new(surface: &LoopSurface) -> Self {
        let mut corners = Vec::new();
        for (s, side) in surface.sides.iter().enumerate() {
            if matches!(side.border, Border::Plain) {
                continue;
            }
            let smooth =
                if side.ends == Ends::Closed { &side.vertices[..] } else { &side.vertices[1..side.vertices.len() - 1] };
            corners.extend(smooth.iter().filter_map(|&v| smooth_corner(&surface.mesh, v, s as u32)));
        }
        for (arriving, leaving) in corner_pairs(&surface.sides) {
            corners.extend(true_corner(surface, arriving, leaving));
        }
        corners.sort_unstable_by_key(|c| c.vertex);
        Self { corners }
    }

    /// The entry of root vertex `v`, or [`NONE`].
    pub fn of(&self, v: VertexId) -> u32 {
        self.corners.binary_search_by_key(&v, |c| c.vertex).map_or(NONE, |i| i as u32)
    }
}

/// A smooth border vertex of another valence than 4 acts as a corner of interior angle pi.
fn smooth_corner(mesh: &Connectivity, vertex: VertexId, side: u32) -> Option<SpecialCorner> {
    let k = mesh.valence(vertex);
    (k != 4 && k > 2).then(|| SpecialCorner {
        vertex,
        weight: corner_weight(PI, k),
        pull: Pull::None,
        sides: [side; 2],
    })
}

/// `(arriving, leaving)` sides of every corner.
fn corner_pairs(sides: &[Side]) -> Vec<(u32, u32)> {
    let open = || sides.iter().enumerate().filter(|(_, s)| s.ends == Ends::Corners);
    let mut leaving: Vec<(VertexId, u32)> = open().map(|(i, s)| (s.vertices[0], i as u32)).collect();
    leaving.sort_unstable();
    let arriving = open().filter_map(|(i, s)| Some((*s.vertices.last()?, i as u32)));
    arriving
        .filter_map(|(v, i)| {
            let at = leaving.binary_search_by_key(&v, |l| l.0).ok()?;
            Some((i, leaving[at].1))
        })
        .collect()
}

/// The interior angle at the corner where side `arriving` ends and side `leaving` begins, in
/// (0, 2 pi): from the tangents; which of the two angles it is, from the fan of root triangles.
pub fn interior_angle(surface: &LoopSurface, arriving: u32, leaving: u32) -> f64 {
    let (before, after) = (&surface.sides[arriving as usize], &surface.sides[leaving as usize]);
    let phi = tangent_in(surface, after, Way::Forward).angle_between(tangent_in(surface, before, Way::Backward));
    if fan_angle(surface, after.vertices[0]) > PI { 2.0 * PI - phi } else { phi }
}

fn true_corner(surface: &LoopSurface, arriving: u32, leaving: u32) -> Option<SpecialCorner> {
    let sides = [leaving, arriving];
    let given = |s: &u32| matches!(surface.sides[*s as usize].border, Border::Given { .. });
    let vertex = surface.sides[leaving as usize].vertices[0];
    let k = surface.mesh.valence(vertex);
    if k < 3 || !sides.iter().all(given) {
        return None;
    }
    let angle = interior_angle(surface, arriving, leaving);
    let zero_boundary = (PI / f64::from(k - 1)).cos();
    let weight = corner_weight(angle, k);
    match surface.corner_rule {
        CornerRule::Lattice if angle < PI && k == 3 => None,
        CornerRule::Lattice if angle > PI && (k == 5 || k == 6) => {
            let s = 1.0 - 0.375 / (LATTICE_WEIGHT + 0.25 * zero_boundary);
            Some(SpecialCorner { vertex, weight: LATTICE_WEIGHT, pull: Pull::Quadratic { s }, sides })
        }
        CornerRule::Lattice => Some(SpecialCorner { vertex, weight, pull: Pull::None, sides }),
        CornerRule::Seed => {
            let s = 1.0 - 1.0 / (4.0 * weight + zero_boundary);
            let ahead = tangent_in(surface, &surface.sides[leaving as usize], Way::Forward);
            let back = tangent_in(surface, &surface.sides[arriving as usize], Way::Backward);
            // Parallel tangents span no plane: there is nothing to flatten to.
            let across = ahead.cross(back);
            let pull = match across.try_normalize() {
                Some(normal) if across.length() >= PARALLEL => Pull::Flat { s, normal },
                _ => Pull::None,
            };
            Some(SpecialCorner { vertex, weight, pull, sides })
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    Forward,
    Backward,
}

/// Unit tangent that leads into `side` from its first vertex, or back into it from its last.
///
/// A one-sided difference of second order over steps of 2^-12 edges: angles come out right to about
/// 1e-7, and the samples are the curve's own.
fn tangent_in(surface: &LoopSurface, side: &Side, way: Way) -> DVec3 {
    const FINE: u32 = 12;
    let edges = (side.vertices.len() - 1) as u64;
    let at = |step: u64| {
        let step = if way == Way::Forward { step } else { (edges << FINE) - step };
        sample(side, FINE, step)
    };
    let difference = match (at(0), at(1), at(2)) {
        (Some(a), Some(b), Some(c)) => 4.0 * (b - a) - (c - a),
        _ => {
            let n = side.vertices.len();
            let (a, b) = if way == Way::Forward { (0, 1) } else { (n - 1, n - 2) };
            surface.points[side.vertices[b].index()] - surface.points[side.vertices[a].index()]
        }
    };
    difference.normalize_or_zero()
}

/// Sum of the angles of the root triangles around border vertex `v`.
fn fan_angle(surface: &LoopSurface, v: VertexId) -> f64 {
    let mesh = &surface.mesh;
    let at = |v: VertexId| surface.points[v.index()];
    let angle = |h: HalfedgeId| (at(mesh.to(h)) - at(v)).angle_between(at(mesh.opposite(h)) - at(v));
    mesh.ring(v).map(angle).filter(|a| a.is_finite()).sum()
}
