//! Surfaces that several tests share.
#![allow(dead_code, reason = "each test binary uses its own part of this module")]

pub mod plate;
pub mod world;

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3};
use selvedge_components::curve::{Curve, CurveParameters, Extent};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::{Border, CornerRule, Details, Ends, Heading, LoopSurface, Side};

/// The graph of a function over a straight line in the plane.
#[derive(Clone, Copy, Debug)]
pub struct Graph {
    pub from: DVec2,
    pub to: DVec2,
    pub height: fn(DVec2) -> f64,
}

impl Curve for Graph {
    fn position(&self, u: f64) -> DVec3 {
        let at = self.from + (self.to - self.from) * u;
        at.extend((self.height)(at))
    }
}

/// A planar triangle mesh with its sides, each from corner to corner, surface on the left.
pub struct Patch {
    pub places: Vec<DVec2>,
    pub triangles: Vec<[u32; 3]>,
    pub sides: Vec<Vec<u32>>,
}

/// Lattice directions of unit length, 60 degrees apart.
pub fn lattice(k: usize) -> DVec2 {
    DVec2::from_angle(std::f64::consts::FRAC_PI_3 * k as f64)
}

/// Vertices of a lattice, found again by place.
#[derive(Default)]
struct Names {
    places: Vec<DVec2>,
    known: BTreeMap<(i64, i64), u32>,
}

impl Names {
    fn of(&mut self, at: DVec2) -> u32 {
        let key = ((at.x * 1e6).round() as i64, (at.y * 1e6).round() as i64);
        *self.known.entry(key).or_insert_with(|| {
            self.places.push(at);
            self.places.len() as u32 - 1
        })
    }

    fn sector(&mut self, a: DVec2, b: DVec2, n: usize, triangles: &mut Vec<[u32; 3]>) {
        for i in 0..n {
            for j in 0..n - i {
                let at = |i: usize, j: usize| i as f64 * a + j as f64 * b;
                triangles.push([self.of(at(i, j)), self.of(at(i + 1, j)), self.of(at(i, j + 1))]);
                if i + j + 2 <= n {
                    triangles.push([self.of(at(i + 1, j)), self.of(at(i + 1, j + 1)), self.of(at(i, j + 1))]);
                }
            }
        }
    }

    fn walk(&mut self, from: DVec2, to: DVec2, n: usize) -> Vec<u32> {
        (0..=n).map(|i| self.of(from + (to - from) * (i as f64 / n as f64))).collect()
    }
}

/// A parallelogram of `n` by `n` lattice cells: corners of valence 2, 3, 2, 3.
pub fn parallelogram(n: usize) -> Patch {
    let (a, b) = (lattice(0), lattice(1));
    let mut names = Names::default();
    let mut triangles = Vec::new();
    let at = |i: usize, j: usize| i as f64 * a + j as f64 * b;
    for i in 0..n {
        for j in 0..n {
            triangles.push([names.of(at(i, j)), names.of(at(i + 1, j)), names.of(at(i, j + 1))]);
            triangles.push([names.of(at(i + 1, j)), names.of(at(i + 1, j + 1)), names.of(at(i, j + 1))]);
        }
    }
    let corners = [at(0, 0), at(n, 0), at(n, n), at(0, n)];
    let sides = (0..4).map(|k| names.walk(corners[k], corners[(k + 1) % 4], n)).collect();
    Patch { places: names.places, triangles, sides }
}

/// `sectors` lattice sectors of 60 degrees around the origin, `n` cells deep: the origin is a corner
/// of valence `sectors + 1`.
pub fn fan(sectors: usize, n: usize) -> Patch {
    let mut names = Names::default();
    let mut triangles = Vec::new();
    for s in 0..sectors {
        names.sector(lattice(s), lattice(s + 1), n, &mut triangles);
    }
    let rim = |s: usize| n as f64 * lattice(s);
    let mut sides = vec![names.walk(DVec2::ZERO, rim(0), n)];
    for s in 0..sectors {
        sides.push(names.walk(rim(s), rim(s + 1), n));
    }
    sides.push(names.walk(rim(sectors), DVec2::ZERO, n));
    Patch { places: names.places, triangles, sides }
}

/// The graph of `height` over `patch`, its borders given as curves with uniform parameters; the
/// interior is taken as it stands, without details.
pub fn graph(patch: &Patch, height: fn(DVec2) -> f64) -> LoopSurface {
    let sides = patch.sides.iter().map(|ids| {
        let at = |i: usize| patch.places[ids[i] as usize];
        let curve = Graph { from: at(0), to: at(ids.len() - 1), height };
        let uniform = (0..ids.len()).map(|i| i as f64 / (ids.len() - 1) as f64).collect();
        given(ids, parameters(Arc::new(curve), uniform))
    });
    LoopSurface {
        mesh: Arc::new(Connectivity::new(patch.places.len(), &patch.triangles).expect("a lattice is a manifold")),
        points: patch.places.iter().map(|&at| at.extend(height(at))).collect(),
        sides: sides.collect(),
        corner_rule: CornerRule::Lattice,
        details: Details::default(),
    }
}

/// Parameters from corner to corner of a curve.
pub fn parameters(curve: Arc<dyn Curve>, list: Vec<f64>) -> Arc<CurveParameters> {
    Arc::new(CurveParameters::new(curve, Extent::Open, list, &[]).expect("the list ascends from corner to corner"))
}

/// A side that walks along its curve.
pub fn given(vertices: &[u32], curve: Arc<CurveParameters>) -> Side {
    Side {
        vertices: vertices.iter().map(|&v| VertexId(v)).collect(),
        ends: Ends::Corners,
        border: Border::Given { curve, first: 0, heading: Heading::Along },
    }
}

/// `d = sum over the three lattice directions of D_e^2 f / 12`, the boundary detail and the interior
/// offset that make the scheme reproduce `f` up to cubics. [Litke et al. 2001, Section 2.2]
pub fn detail(height: fn(DVec2) -> f64, at: DVec2) -> f64 {
    (0..3).map(|k| height(at + lattice(k)) + height(at - lattice(k)) - 2.0 * height(at)).sum::<f64>() / 12.0
}

/// A surface whose borders are all plain and without corners.
pub fn plain(points: Vec<DVec3>, triangles: &[[u32; 3]]) -> LoopSurface {
    let mesh = Connectivity::new(points.len(), triangles).expect("the test's mesh is a manifold");
    LoopSurface::plain(Arc::new(mesh), points, &[])
}

/// An arc of a great circle of radius `radius`, from one axis to the next.
#[derive(Clone, Copy, Debug)]
pub struct GreatArc {
    pub from: DVec3,
    pub to: DVec3,
    pub radius: f64,
}

impl Curve for GreatArc {
    fn position(&self, u: f64) -> DVec3 {
        let angle = self.from.angle_between(self.to);
        let (a, b) = (((1.0 - u) * angle).sin(), (u * angle).sin());
        (a * self.from + b * self.to) * (self.radius / angle.sin())
    }
}

/// A fan of `sectors` sectors, each `n` cells deep, over a spherical cap of radius 0.5: its tip is a
/// corner of interior angle `angle` at the pole. Lattice sectors are brought to the angle by an
/// affine map; where none does (three sectors, and more than five), the sectors share it evenly.
pub fn spherical_fan(sectors: usize, n: usize, angle: f64) -> LoopSurface {
    let mut patch = if matches!(sectors, 1 | 2 | 4 | 5) {
        let mut patch = fan(sectors, n);
        let to = DMat2::from_cols(DVec2::X, DVec2::from_angle(angle));
        let map = to * DMat2::from_cols(DVec2::X, lattice(sectors)).inverse();
        patch.places.iter_mut().for_each(|at| *at = map * *at);
        patch
    } else {
        fan_of(sectors, n, angle / sectors as f64)
    };
    let size = patch.places.iter().map(|at| at.length()).fold(0.0, f64::max);
    patch.places.iter_mut().for_each(|at| *at *= 0.33 / size);
    let lift = move |at: DVec2| at.extend((0.25 - at.length_squared()).sqrt());
    let sides = patch.sides.iter().map(|ids| {
        let at = |i: usize| patch.places[ids[i] as usize];
        let curve = Lifted { from: at(0), to: at(ids.len() - 1) };
        let uniform = (0..ids.len()).map(|i| i as f64 / (ids.len() - 1) as f64).collect();
        given(ids, parameters(Arc::new(curve), uniform))
    });
    let mut surface = LoopSurface {
        sides: sides.collect(),
        mesh: Arc::new(Connectivity::new(patch.places.len(), &patch.triangles).expect("a fan is a manifold")),
        points: patch.places.iter().map(|&at| lift(at)).collect(),
        corner_rule: CornerRule::Lattice,
        details: Details::default(),
    };
    smooth_interior(&mut surface);
    surface
}

/// A straight line in the plane, lifted to the sphere of radius 0.5.
#[derive(Clone, Copy, Debug)]
struct Lifted {
    from: DVec2,
    to: DVec2,
}

impl Curve for Lifted {
    fn position(&self, u: f64) -> DVec3 {
        let at = self.from + (self.to - self.from) * u;
        at.extend((0.25 - at.length_squared()).sqrt())
    }
}

/// Like [`fan`], with sectors of any angle.
pub fn fan_of(sectors: usize, n: usize, angle: f64) -> Patch {
    let mut names = Names::default();
    let mut triangles = Vec::new();
    let ray = |s: usize| DVec2::from_angle(angle * s as f64);
    for s in 0..sectors {
        names.sector(ray(s), ray(s + 1), n, &mut triangles);
    }
    let rim = |s: usize| n as f64 * ray(s);
    let mut sides = vec![names.walk(DVec2::ZERO, rim(0), n)];
    for s in 0..sectors {
        sides.push(names.walk(rim(s), rim(s + 1), n));
    }
    sides.push(names.walk(rim(sectors), DVec2::ZERO, n));
    Patch { places: names.places, triangles, sides }
}

/// Moves the interior control points to the mean of their neighbours, again and again: the start
/// that a fit has when nothing is known of the interior.
pub fn smooth_interior(surface: &mut LoopSurface) {
    let mesh = surface.mesh.clone();
    for _ in 0..1000 {
        for v in (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| !mesh.is_border(v)) {
            let sum: DVec3 = mesh.neighbours(v).map(|n| surface.points[n.index()]).sum();
            surface.points[v.index()] = sum / f64::from(mesh.valence(v));
        }
    }
}

/// The sphere octant of radius 0.5 over one of the meshes of `data/plates/octant.json`.
pub fn octant(name: &str) -> LoopSurface {
    octant_along(name, |from, to| Arc::new(GreatArc { from, to, radius: 0.5 }))
}

/// As [`octant`], along the quarter circles that `arc` gives from one axis to the next.
pub fn octant_along(name: &str, arc: impl Fn(DVec3, DVec3) -> Arc<dyn Curve>) -> LoopSurface {
    let text = include_str!("../../data/plates/octant.json");
    let json: serde_json::Value = serde_json::from_str(text).expect("the file is JSON");
    let mesh = &json["meshes"][name];
    let triangles: Vec<[u32; 3]> = serde_json::from_value(mesh["triangles"].clone()).expect("triangles");
    let chains: Vec<Vec<u32>> = serde_json::from_value(mesh["sides"].clone()).expect("sides");
    let count = mesh["vertices"].as_u64().expect("a count") as usize;
    let mut points = vec![DVec3::ZERO; count];
    let sides = chains.iter().enumerate().map(|(k, ids)| {
        let curve = arc(DVec3::AXES[k], DVec3::AXES[(k + 1) % 3]);
        let list: Vec<f64> = (0..ids.len()).map(|i| i as f64 / (ids.len() - 1) as f64).collect();
        for (&v, &u) in ids.iter().zip(&list) {
            points[v as usize] = curve.position(u);
        }
        given(ids, parameters(curve, list))
    });
    let sides = sides.collect();
    let mesh = Arc::new(Connectivity::new(count, &triangles).expect("the octant is a manifold"));
    let mut surface =
        LoopSurface { mesh, points, sides, corner_rule: CornerRule::Lattice, details: Details::default() };
    smooth_interior(&mut surface);
    surface
}
