//! Unit normals of the limit surface at vertices of a level.

use core::f64::consts::PI;

use glam::DVec3;
use selvedge_components::curve::{Branch, tangent};
use selvedge_components::subdivision::plain::vertex_normal;
use selvedge_components::subdivision::{
    Border, Heading, Kind, LevelMesh, LoopSurface, NONE, Origin, SideEnd, VertexRule, border_sample,
};

use super::Subject;
use crate::parallel::map_in_order;
use crate::subdivision::chain::{self, Level};

/// The normals at `vertices` of `level`, whose rings are whole and whose limit points no finer detail
/// moves; zero where the surface has none. Outward for counter-clockwise faces.
///
/// Interior vertices and those on plain borders: from the tangent masks. Next to a special corner
/// the ring has another rule than the masks assume: there the ring of the next level is read. On a
/// given border: the curve's tangent and the transverse one.
pub fn at(subject: &Subject, level: &Level, vertices: &[u32]) -> Vec<DVec3> {
    let mesh = &level.mesh;
    let beside_corner = |&v: &u32| {
        mesh.vertices[v as usize].kind == Kind::Interior
            && mesh.ring(v).any(|h| mesh.vertices[mesh.to(h) as usize].corner != NONE)
    };
    let mut normals = map_in_order(vertices.len(), |i| {
        let v = vertices[i];
        match mesh.vertices[v as usize].kind {
            Kind::Interior => ring_normal(VertexRule::Interior, level, v),
            Kind::Plain => ring_normal(VertexRule::Border, level, v),
            Kind::PlainCorner => ring_normal(VertexRule::Corner, level, v),
            Kind::Given(_) => given_normal(subject.surface, level, v),
        }
    });
    let beside: Vec<usize> = (0..vertices.len()).filter(|&i| beside_corner(&vertices[i])).collect();
    if !beside.is_empty() {
        let finer = one_step(subject, level, beside.iter().map(|&i| vertices[i]));
        let place = standing_for(&finer.mesh, mesh.vertices.len());
        for i in beside {
            normals[i] = ring_normal(VertexRule::Interior, &finer, place[vertices[i] as usize]);
        }
    }
    normals
}

fn ring_normal(rule: VertexRule, level: &Level, v: u32) -> DVec3 {
    let points = &level.state.effective;
    let spokes: Vec<DVec3> = level.mesh.neighbours(v).map(|n| points[n as usize]).collect();
    vertex_normal(rule, points[v as usize], &spokes)
}

/// The level after `level` around some of its vertices.
fn one_step(subject: &Subject, level: &Level, vertices: impl Iterator<Item = u32>) -> Level {
    let mut faces: Vec<u32> = vertices.flat_map(|v| level.mesh.ring(v)).map(|h| h / 3).collect();
    faces.sort_unstable();
    faces.dedup();
    faces.retain(|&f| level.mesh.refinable(f));
    chain::refine(subject.surface, &subject.corners, &subject.surface.details, level, &faces).0
}

/// By vertex of the coarser level: the vertex of `finer` that stands for it.
fn standing_for(finer: &LevelMesh, coarse: usize) -> Vec<u32> {
    let mut place = vec![NONE; coarse];
    for (v, vertex) in finer.vertices.iter().enumerate() {
        if let Origin::Vertex(p) = vertex.origin {
            place[p as usize] = v as u32;
        }
    }
    place
}

/// On a given border. Where two given curves meet, both tangents are curves' own; elsewhere the
/// transverse tangent comes from the ring.
fn given_normal(surface: &LoopSurface, level: &Level, v: u32) -> DVec3 {
    let mesh = &level.mesh;
    let Kind::Given(g) = mesh.vertices[v as usize].kind else { return DVec3::ZERO };
    let rim = Rim::new(surface, level, v);
    let [ahead, behind] = rim.tangents();
    let faces = fan_area(level, v);
    match mesh.given[g as usize].end {
        SideEnd::Smooth => (ahead - behind).cross(rim.transverse()).normalize_or_zero(),
        SideEnd::Corner | SideEnd::Mixed => {
            let across = ahead.cross(behind);
            // Squared sine of the angle between the sides, unit tangents right to rounding: below it
            // rounding alone decides.
            if across.length_squared() <= f64::EPSILON {
                return faces.normalize_or_zero();
            }
            // At a reflex corner the product points inward; the faces' own areas tell.
            if across.dot(faces) < 0.0 { -across.normalize_or_zero() } else { across.normalize_or_zero() }
        }
    }
}

/// The sum of the area vectors of the faces around `v`.
fn fan_area(level: &Level, v: u32) -> DVec3 {
    let points = &level.state.effective;
    let at = |v: u32| points[v as usize];
    level
        .mesh
        .ring(v)
        .fold(DVec3::ZERO, |sum, h| sum + (at(level.mesh.to(h)) - at(v)).cross(at(level.mesh.opposite(h)) - at(v)))
}

/// The border through one vertex.
struct Rim<'a> {
    surface: &'a LoopSurface,
    level: &'a Level,
    vertex: u32,
    /// Half-edges of the border that leave and arrive.
    edges: [u32; 2],
    /// Vertices before and after.
    next: u32,
    previous: u32,
}

impl<'a> Rim<'a> {
    fn new(surface: &'a LoopSurface, level: &'a Level, vertex: u32) -> Self {
        let mesh = &level.mesh;
        let leaving = mesh.vertices[vertex as usize].start;
        let last = mesh.ring(vertex).last().unwrap_or(leaving);
        // The border half-edge that arrives is the one before the last that leaves.
        let arriving = if last % 3 == 0 { last + 2 } else { last - 1 };
        Self {
            surface,
            level,
            vertex,
            edges: [leaving, arriving],
            next: mesh.to(leaving),
            previous: mesh.from(arriving),
        }
    }

    /// The curve's value `offset` steps of `deeper` levels below this one from the vertex: forward
    /// along the edge that leaves, or backward along the one that arrives.
    fn sample(&self, edge: usize, deeper: u32, offset: u64) -> Option<DVec3> {
        let (side, step) = self.level.mesh.border(self.edges[edge])?;
        let level = self.level.mesh.level + deeper;
        let step = if edge == 0 { (step << deeper) + offset } else { ((step + 1) << deeper) - offset };
        border_sample(&self.surface.sides[side as usize], level, step)
    }

    /// The unit one-sided tangents away from the vertex: ahead and behind. On a plain side, along the
    /// control mesh's edge, where a cubic B-spline without bending at its end leaves.
    fn tangents(&self) -> [DVec3; 2] {
        let points = &self.level.state.effective;
        let along_mesh = |v: u32| (points[v as usize] - points[self.vertex as usize]).normalize_or_zero();
        [(0, self.next), (1, self.previous)].map(|(edge, v)| self.tangent(edge).unwrap_or_else(|| along_mesh(v)))
    }

    /// The curve's tangent; `None` on a plain side, or where the curve stands still.
    fn tangent(&self, edge: usize) -> Option<DVec3> {
        let (side, step) = self.level.mesh.border(self.edges[edge])?;
        let side = &self.surface.sides[side as usize];
        let index = side.curve_index(self.level.mesh.level, step + edge as u64)?;
        let Border::Given { curve, heading, .. } = &side.border else { return None };
        let u = curve.parameter(self.level.mesh.level, index);
        let rising = (*heading == Heading::Along) == (edge == 0);
        if rising {
            tangent(&**curve.curve(), u, Branch::After)
        } else {
            tangent(&**curve.curve(), u, Branch::Before).map(|t| -t)
        }
    }

    /// The transverse tangent, inward.
    ///
    /// At a given border the rules are those of a corner of angle pi: with `theta = pi / (k - 1)` the
    /// weights `sin(i theta)` on the interior spokes and `a = (sin theta - sum) / 2` on both border
    /// spokes are a left eigenvector, to the eigenvalue 1/2, of a step along a plain border. A given
    /// border deviates from that step: each level's deviation, weighed the same and doubled per
    /// level, adds its part.
    fn transverse(&self) -> DVec3 {
        // The parts halve from level to level, the deviations being of second order, so the last one
        // found is what all later ones add up to, but for a millionth of the first.
        const LEVELS: u32 = 10;
        let mesh = &self.level.mesh;
        let spokes: Vec<u32> = mesh.neighbours(self.vertex).collect();
        let mut band = Band::at(self);
        let [previous, centre, next] = band.effective();
        if spokes.len() == 2 {
            // One triangle: what bends it is the border's own second difference.
            return 0.5 * (next + previous) - centre;
        }
        let theta = PI / (spokes.len() - 1) as f64;
        let inside = spokes[1..spokes.len() - 1].iter().enumerate();
        let (sum, total) = inside.fold((DVec3::ZERO, 0.0), |(sum, total), (i, &v)| {
            let w = (theta * (i + 1) as f64).sin();
            (sum + w * (self.level.state.effective[v as usize] - centre), total + w)
        });
        let end = 0.5 * (theta.sin() - total);
        let weigh = |[p, c, n]: [DVec3; 3]| end * ((n - c) + (p - c));
        let mut tangent = sum + weigh([previous, centre, next]);
        let mut part = DVec3::ZERO;
        for deeper in 1..=LEVELS {
            let Some(finer) = band.step(self, deeper) else { break };
            let deviation = finer.deviation(&band);
            part = f64::from(1_u32 << deeper) * (weigh(deviation) - total * deviation[1]);
            tangent += part;
            band = finer;
        }
        tangent + part
    }
}

/// The border before, at and after a vertex: samples and details.
#[derive(Clone, Copy)]
struct Band {
    samples: [DVec3; 3],
    details: [DVec3; 3],
}

impl Band {
    fn at(rim: &Rim) -> Self {
        let (mesh, state) = (&rim.level.mesh, &rim.level.state);
        let around = [rim.previous, rim.vertex, rim.next];
        let details = around.map(|v| state.detail(mesh, v));
        // Where the neighbour is not on the curve it has no detail: its effective point is all.
        Self { samples: core::array::from_fn(|i| state.effective[around[i] as usize] + details[i]), details }
    }

    fn effective(&self) -> [DVec3; 3] {
        core::array::from_fn(|i| self.samples[i] - self.details[i])
    }

    /// What this one has beyond one step of a plain border from `coarser`.
    fn deviation(&self, coarser: &Self) -> [DVec3; 3] {
        let ([p, c, n], [fine_p, fine_c, fine_n]) = (coarser.effective(), self.effective());
        [fine_p - 0.5 * (p + c), fine_c - (0.75 * c + 0.125 * (p + n)), fine_n - 0.5 * (c + n)]
    }

    /// The same, `deeper` levels below.
    fn step(&self, rim: &Rim, deeper: u32) -> Option<Self> {
        let [p, c, n] = self.details;
        let samples = [rim.sample(1, deeper, 1)?, self.samples[1], rim.sample(0, deeper, 1)?];
        Some(Self { samples, details: [(p + c) * 0.125, c * 0.25, (c + n) * 0.125] })
    }
}
