//! The cages that scenarios begin with.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use selvedge::Engine;
use selvedge::curve::Heading;
use selvedge::io::{Cage, Limits, obj};
use selvedge::mesh::{Connectivity, VertexId};
use selvedge::scenes::trims;
use selvedge::subdivision::LoopSurface;
use selvedge::tolerance::Tolerance;
use selvedge::trim::TrimOptions;
use selvedge_systems::subdivision::trim::Ground;

use super::Draw;
use super::shapes::{Shape, laid};

/// A cage, ready for curves to be laid on it.
pub struct Start {
    pub name: &'static str,
    pub ground: Arc<Ground>,
}

impl Start {
    /// Is it about level, with a border round it?
    pub fn is_flat(&self) -> bool {
        matches!(self.name, "plate8" | "baked" | "disc")
    }
}

/// All of them.
pub struct Grounds(Vec<Start>);

impl Grounds {
    /// Makes them.
    pub fn new() -> Self {
        let cage = |bytes: &[u8]| {
            let cage = Cage::from_polygons(obj::read(bytes, &Limits::default()).expect("a file")).expect("a cage");
            (cage.positions, cage.triangles)
        };
        let (spot, spot_faces) = cage(include_bytes!("../../../data/cages/spot_control_mesh.obj"));
        let (rim, rim_faces) = cage(include_bytes!("../../../data/cages/loop_xord_boundary.obj"));
        let (ico, ico_faces) = cage(include_bytes!("../../../data/cages/loop_icosahedron.obj"));
        let plate8 = trims::ground::plate8().expect("a plate");
        let baked = baked(&plate8.surface);
        let mut all = vec![
            ("plate8", plate8),
            ("disc", trims::ground::contoured_disc().expect("a disc")),
            ("spot", ready(plain(spot, &spot_faces))),
            ("torus", ready(torus(20, 10))),
            ("voxels", ready(voxels())),
            ("ball", ready(finer(finer(plain(ico, &ico_faces))))),
            ("rim", ready(finer(cornered(rim, &rim_faces)))),
            ("baked", ready(baked)),
        ];
        let all = all.drain(..).map(|(name, ground)| Start { name, ground }).collect();
        Self(all)
    }

    /// One of them.
    pub fn any(&self, draw: &mut Draw) -> &Start {
        &self.0[draw.below(self.0.len())]
    }
}

fn ready(surface: LoopSurface) -> Arc<Ground> {
    Arc::new(Ground::new(Arc::new(surface), 0).expect("sound"))
}

fn plain(points: Vec<DVec3>, faces: &[[u32; 3]]) -> LoopSurface {
    LoopSurface::plain(Arc::new(Connectivity::new(points.len(), faces).expect("sound")), points, &[])
}

/// Corners at border vertices of two faces or one.
fn cornered(points: Vec<DVec3>, faces: &[[u32; 3]]) -> LoopSurface {
    let mesh = Connectivity::new(points.len(), faces).expect("sound");
    let corners: Vec<VertexId> = mesh.border_loops().concat().into_iter().filter(|&v| mesh.valence(v) < 4).collect();
    LoopSurface::plain(Arc::new(mesh), points, &corners)
}

/// Every face quartered; corners stay.
fn finer(surface: LoopSurface) -> LoopSurface {
    let mut points = surface.points.clone();
    let mut middle: BTreeMap<(u32, u32), u32> = BTreeMap::new();
    let mut between = |a: VertexId, b: VertexId| {
        let key = (a.0.min(b.0), a.0.max(b.0));
        *middle.entry(key).or_insert_with(|| {
            points.push((points[key.0 as usize] + points[key.1 as usize]) * 0.5);
            points.len() as u32 - 1
        })
    };
    let mut faces = Vec::new();
    for &[a, b, c] in surface.mesh.faces() {
        let [ab, bc, ca] = [between(a, b), between(b, c), between(c, a)];
        faces.extend([[a.0, ab, ca], [ab, b.0, bc], [ca, bc, c.0], [ab, bc, ca]]);
    }
    let ends = surface.sides.iter().filter(|side| side.ends == selvedge::subdivision::Ends::Corners);
    let corners: Vec<VertexId> = ends.map(|side| side.vertices[0]).collect();
    LoopSurface::plain(Arc::new(Connectivity::new(points.len(), &faces).expect("sound")), points, &corners)
}

fn torus(n: u32, m: u32) -> LoopSurface {
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let (mut faces, mut points) = (Vec::new(), Vec::new());
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        faces.extend([[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
        let (a, b) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
        let r = 1.0 + 0.4 * b.cos();
        points.push(DVec3::new(r * a.cos(), r * a.sin(), 0.4 * b.sin()));
    }
    plain(points, &faces)
}

/// A block of cubes with a notch.
fn voxels() -> LoopSurface {
    let filled = |c: [i32; 3]| {
        (0..4).contains(&c[0]) && (0..4).contains(&c[1]) && (0..3).contains(&c[2]) && !(c[0] > 1 && c[2] > 1)
    };
    let mut names: BTreeMap<[i32; 3], u32> = BTreeMap::new();
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for (x, y, z) in (0..4).flat_map(|x| (0..4).flat_map(move |y| (0..3).map(move |z| (x, y, z)))) {
        for (axis, up) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut beside = [x, y, z];
            beside[axis] += 2 * up - 1;
            if !filled([x, y, z]) || filled(beside) {
                continue;
            }
            let corner = |s: i32, t: i32| {
                let mut at = [x, y, z];
                at[axis] += up;
                at[(axis + 1) % 3] += s;
                at[(axis + 2) % 3] += t;
                at
            };
            let round = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            let mut quad = round.map(|at| {
                *names.entry(at).or_insert_with(|| {
                    points.push(DVec3::from(at.map(f64::from)));
                    points.len() as u32 - 1
                })
            });
            if up == 0 {
                quad.reverse();
            }
            faces.extend([[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]);
        }
    }
    plain(points, &faces)
}

/// A plate with a hole in it, details and all.
fn baked(plate: &LoopSurface) -> LoopSurface {
    let ground = ready(plate.clone());
    let mut engine = Engine::new();
    let source = engine.spawn_surface(plate);
    let frame = super::shapes::Frame::flat(DVec3::new(-0.02, 0.0, 0.0));
    let curve = Shape::Circle.outline(&frame, 0.05, &mut Draw(1)).and_then(|c| laid(&ground, &frame, c));
    let curve = engine.spawn_curve(curve.expect("a circle"));
    let tolerance = Some(Tolerance { fit: 2e-5, chord: 2e-5, curve: 2e-5 });
    engine.spawn_trim(source, &[(curve, Heading::Against)], tolerance, TrimOptions::default());
    engine.settle().expect("trims end");
    let result = engine.result(source).expect("a result");
    LoopSurface::clone(engine.surface(result).expect("gathered").expect("sound"))
}
