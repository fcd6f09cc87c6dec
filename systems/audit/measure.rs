//! Distances between triangles and a surface, both ways, at random places.

use glam::DVec3;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, HalfedgeId, VertexId};
use selvedge_components::triangles::Triangles;

use super::domain::Place;
use super::{Audit, AuditFault, Measured};
use crate::foot;
use crate::parallel::map_in_order;
use crate::triangulate::{squared_to_segment, squared_to_triangle};

/// The greater of both, each way.
fn or(a: Measured, b: Measured) -> Measured {
    let mut all = Measured { samples: a.samples + b.samples, ..a };
    // A distance that is no number counts as far.
    if b.to_triangles > all.to_triangles || b.to_triangles.is_nan() {
        (all.to_triangles, all.to_triangles_at) = (b.to_triangles, b.to_triangles_at);
    }
    if b.to_surface > all.to_surface || b.to_surface.is_nan() {
        (all.to_surface, all.to_surface_at) = (b.to_surface, b.to_surface_at);
    }
    all
}

/// Measures every triangle.
pub fn measure(
    triangles: &Triangles,
    mesh: &Connectivity,
    places: &[Place],
    limit: &dyn Evaluate,
    against: &Audit<'_>,
    found: &mut Vec<AuditFault>,
) -> Measured {
    let each = map_in_order(places.len(), |t| {
        let corners = triangles.triangles[t].map(|v| triangles.positions[v as usize]);
        let border = [0, 1, 2].map(|c| mesh.twin(HalfedgeId::new(3 * t + c)).is_none());
        Probe { triangles, mesh, triangle: t, corners, border, place: &places[t], limit }.measure(against)
    });
    if let Some(limit) = against.chord {
        for (triangle, &(distance, at)) in each.iter().map(Measured::greatest).collect::<Vec<_>>().iter().enumerate() {
            if distance > limit || distance.is_nan() {
                found.push(AuditFault::Chord { triangle, distance, limit, at });
            }
        }
    }
    each.into_iter().fold(Measured::default(), or)
}

/// One triangle beside the surface.
struct Probe<'a> {
    triangles: &'a Triangles,
    mesh: &'a Connectivity,
    triangle: usize,
    corners: [DVec3; 3],
    /// Which edges are open.
    border: [bool; 3],
    place: &'a Place,
    limit: &'a dyn Evaluate,
}

impl Probe<'_> {
    fn measure(&self, against: &Audit<'_>) -> Measured {
        let mut places = Places::new(against.seed, self.triangle as u64);
        let mut all = Measured::default();
        for _ in 0..against.points {
            all = or(all, self.inside(against, places.inside()));
        }
        for edge in 0..3 {
            for _ in 0..against.points.div_ceil(4) {
                all = or(all, self.on_edge(against, edge, places.along()));
            }
        }
        all
    }

    fn inside(&self, against: &Audit<'_>, b: [f64; 3]) -> Measured {
        let at = self.place.at(b);
        let x = self.limit.position(at);
        self.both(against, at, x, self.squared_to_mesh(x), b)
    }

    /// The squared distance to the triangles here: near an irregular vertex the surface slides, and
    /// a point of it may be over another triangle than the one with its parameters.
    fn squared_to_mesh(&self, x: DVec3) -> f64 {
        let mut least = f64::INFINITY;
        for v in self.triangles.triangles[self.triangle] {
            for h in self.mesh.ring(VertexId(v)) {
                let corners = self.triangles.triangles[h.face().index()].map(|v| self.triangles.positions[v as usize]);
                least = least.min(squared_to_triangle(x, corners));
            }
        }
        least
    }

    /// A point of a border is measured to the edge that stands for it.
    fn on_edge(&self, against: &Audit<'_>, edge: usize, share: f64) -> Measured {
        let (next, mut b) = ((edge + 1) % 3, [0.0; 3]);
        (b[edge], b[next]) = (1.0 - share, share);
        let at = self.place.at(b);
        let x = self.limit.position(at);
        let squared = if self.border[edge] {
            squared_to_segment(x, self.corners[edge], self.corners[next])
        } else {
            self.squared_to_mesh(x)
        };
        self.both(against, at, x, squared, b)
    }

    fn both(&self, against: &Audit<'_>, at: SurfacePoint, x: DVec3, squared: f64, b: [f64; 3]) -> Measured {
        let y = b[0] * self.corners[0] + b[1] * self.corners[1] + b[2] * self.corners[2];
        Measured {
            to_triangles: squared.sqrt(),
            to_triangles_at: x,
            to_surface: self.to_surface(against, at, y),
            to_surface_at: y,
            samples: 2,
        }
    }
}

impl Probe<'_> {
    /// From above: where the surface is rough the first foot found may not be the nearest, so one that
    /// is too far is looked for from other places too.
    fn to_surface(&self, against: &Audit<'_>, at: SurfacePoint, y: DVec3) -> f64 {
        let foot = |starts: &[SurfacePoint], enough: f64| {
            foot::distance(self.limit, &against.surface.mesh, starts.iter().copied(), y, enough)
        };
        let first = foot(&[at], 0.0);
        match against.chord {
            Some(chord) if first > chord => first.min(foot(&foot::AROUND.map(|b| self.place.at(b)), chord)),
            _ => first,
        }
    }
}

/// Places that fill a triangle evenly, from a random start: additive recurrence with the plastic
/// number, whose powers are the most irrational pair. [Roberts 2018]
struct Places {
    u: f64,
    v: f64,
}

impl Places {
    const FIRST: f64 = 0.754_877_666_246_692_7;
    const SECOND: f64 = 0.569_840_290_998_053_2;

    fn new(seed: u64, triangle: u64) -> Self {
        let mut bits = seed ^ triangle.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let mut unit = || {
            // SplitMix64. [Steele, Lea, Flood 2014]
            bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = bits;
            z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z ^ z >> 31) as f64 / 2.0_f64.powi(64)
        };
        Self { u: unit(), v: unit() }
    }

    fn step(&mut self) {
        self.u = (self.u + Self::FIRST).fract();
        self.v = (self.v + Self::SECOND).fract();
    }

    /// The weights of the corners at the next place.
    fn inside(&mut self) -> [f64; 3] {
        self.step();
        let (u, v) = if self.u + self.v > 1.0 { (1.0 - self.u, 1.0 - self.v) } else { (self.u, self.v) };
        [1.0 - u - v, u, v]
    }

    /// A share of an edge.
    fn along(&mut self) -> f64 {
        self.step();
        self.u
    }
}
