//! Surfaces drawn from a seed.
#![allow(dead_code, reason = "each test binary uses its own part of this module")]

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{Circle, CurveParameters, Extent, Heading};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId, VertexId};
use selvedge_components::subdivision::{Border, CornerRule, CornerTable, Details, Ends, FaceCode, LoopSurface, Side};
use selvedge_systems::subdivision::{chain, region};

#[path = "random.rs"]
mod random;

pub use random::Draw;

impl Draw {
    /// In the cube [-1, 1].
    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - DVec3::ONE
    }

    /// Anywhere on a surface of `faces` faces.
    pub fn place(&mut self, faces: usize) -> SurfacePoint {
        let [s, t] = self.in_triangle();
        SurfacePoint::new(FaceId::new(self.remainder(faces)), s, t)
    }
}

/// Adds details drawn from `seed` to levels 0 to `levels - 1`: on level 0 everywhere, from then on
/// around ever fewer faces; about `size` large and smaller from level to level.
pub fn add_details(surface: &mut LoopSurface, levels: u32, size: f64, seed: u64) {
    let mut draw = Draw(seed);
    let corners = CornerTable::new(surface);
    let mut stored = Vec::new();
    for level in 0..levels {
        let faces = region::whole(&surface.mesh, level);
        let share = 0.4_f64.powi(level as i32);
        let some: Vec<FaceCode> = faces.into_iter().filter(|f| f.0 == 0 || draw.unit() < share).collect();
        let families = if level == 0 { some } else { region::children(&region::parents(&some)) };
        let built = chain::build(surface, &corners, &Details::default(), level, &families);
        let addresses = built.mesh.addresses(&surface.mesh);
        let mut list: Vec<_> = (0..addresses.len())
            .filter(|v| v % 2 == 0)
            .map(|v| (addresses[v], draw.vector() * (size * 0.3_f64.powi(level as i32))))
            .collect();
        list.sort_by_key(|d| d.0);
        stored.push(list);
    }
    surface.details = Details { levels: stored };
}

/// A disc whose border is a circle of radius 1: `rings` rings of faces around a vertex of valence
/// `sectors`. The parameters along the circle are uneven.
pub fn disc(sectors: usize, rings: usize, seed: u64, heading: Heading) -> LoopSurface {
    let mut draw = Draw(seed);
    let name =
        |r: usize, i: usize| if r == 0 { 0 } else { (1 + sectors * (r * (r - 1) / 2) + i % (sectors * r)) as u32 };
    let mut triangles = Vec::new();
    for r in 1..=rings {
        for s in 0..sectors {
            for i in 0..r {
                let (outer, inner) = (s * r + i, s * (r - 1) + i);
                triangles.push([name(r, outer), name(r, outer + 1), name(r - 1, inner)]);
                if i + 1 < r {
                    triangles.push([name(r, outer + 1), name(r - 1, inner + 1), name(r - 1, inner)]);
                }
            }
        }
    }
    let count = sectors * rings;
    let uneven: Vec<f64> = {
        let steps: Vec<f64> = (0..count).map(|_| 0.3 + draw.unit()).collect();
        let total: f64 = steps.iter().sum();
        let sums = steps.iter().scan(0.0, |sum, s| {
            *sum += s / total;
            Some(*sum)
        });
        std::iter::once(0.0).chain(sums).take(count).collect()
    };
    let circle = Circle::new(DVec3::ZERO, DVec3::Z, 1.0).expect("a circle");
    let curve = CurveParameters::new(Arc::new(circle), Extent::Closed, uneven.clone(), &[]).expect("they ascend");
    let mut points = vec![DVec3::ZERO; 1 + sectors * rings * (rings + 1) / 2];
    for r in 1..=rings {
        for i in 0..sectors * r {
            let u = uneven[(i * count) / (sectors * r)];
            let turned = match heading {
                Heading::Along => u,
                Heading::Against => -u,
            };
            let at = DVec2::from_angle(turned * std::f64::consts::TAU) * (r as f64 / rings as f64);
            points[name(r, i) as usize] = at.extend(0.2 * draw.unit());
        }
    }
    let vertices: Vec<VertexId> = (0..count).map(|i| VertexId(name(rings, i))).collect();
    let border = Border::Given { curve: Arc::new(curve), first: 0, heading };
    LoopSurface {
        mesh: Arc::new(Connectivity::new(points.len(), &triangles).expect("a disc is a manifold")),
        points,
        sides: vec![Side { vertices, ends: Ends::Closed, border }],
        corner_rule: CornerRule::Lattice,
        details: Details::default(),
    }
}

/// A closed surface like a ball, with vertices of every valence from 3 to some above 6: a regular
/// octahedron, twice quartered, with edges flipped at random.
pub fn ball(flips: usize, seed: u64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let mut points: Vec<DVec3> = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..2 {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for f in &triangles {
            let m = [0, 1, 2].map(|i| {
                let (a, b) = (f[i], f[(i + 1) % 3]);
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    points.push((points[a as usize] + points[b as usize]).normalize());
                    points.len() as u32 - 1
                })
            });
            finer.extend([[f[0], m[0], m[2]], [m[0], f[1], m[1]], [m[2], m[1], f[2]], m]);
        }
        triangles = finer;
    }
    let mut draw = Draw(seed);
    for _ in 0..flips {
        flip(points.len(), &mut triangles, &mut draw);
    }
    for p in &mut points {
        *p *= 1.0 + 0.2 * draw.unit();
    }
    (points, triangles)
}

/// Turns one edge between two triangles, if the mesh stays a manifold of valence 3 and more.
fn flip(vertices: usize, triangles: &mut [[u32; 3]], draw: &mut Draw) {
    let mesh = Connectivity::new(vertices, triangles).expect("flips keep a manifold");
    let h = mesh.halfedge(selvedge_components::mesh::EdgeId::new(draw.remainder(mesh.edge_count())));
    let Some(twin) = mesh.twin(h) else { return };
    let [a, b, c, d] = [mesh.from(h), mesh.to(h), mesh.opposite(h), mesh.opposite(twin)];
    let thin = [a, b].iter().any(|&v| mesh.valence(v) < 4);
    if thin || mesh.neighbours(c).any(|n| n == d) {
        return;
    }
    triangles[h.face().index()] = [a.0, d.0, c.0];
    triangles[twin.face().index()] = [d.0, b.0, c.0];
}
