//! Surfaces, curves and a closest point to test with.

use core::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::Curve;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Border, CornerRule, Details, Ends, LoopSurface, PlainLoop, Side};

use selvedge_components::target::{Foot, Target, TargetError};

/// A surface without details or given borders, whose vertices `corners` are corners.
pub fn surface(points: Vec<DVec3>, faces: &[[u32; 3]], corners: &[u32]) -> LoopSurface {
    let mesh = Arc::new(Connectivity::new(points.len(), faces).expect("a manifold"));
    let mut sides = Vec::new();
    for border in mesh.border_loops() {
        let at: Vec<usize> = (0..border.len()).filter(|&i| corners.contains(&border[i].0)).collect();
        if at.is_empty() {
            sides.push(Side { vertices: border, ends: Ends::Closed, border: Border::Plain });
            continue;
        }
        for (k, &from) in at.iter().enumerate() {
            let to = at.get(k + 1).map_or(at[0] + border.len(), |&to| to);
            let vertices = (from..=to).map(|i| border[i % border.len()]).collect();
            sides.push(Side { vertices, ends: Ends::Corners, border: Border::Plain });
        }
    }
    LoopSurface { mesh, points, sides, corner_rule: CornerRule::Lattice, details: Details::default() }
}

/// The regular lattice of `n` by `n` squares of size `h` about the origin, cut by their diagonals.
pub fn lattice(n: u32, h: f64, height: impl Fn(f64, f64) -> f64) -> LoopSurface {
    let at = |i: u32| (f64::from(i) - 0.5 * f64::from(n)) * h;
    let name = |i: u32, j: u32| i * (n + 1) + j;
    let points = (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j)));
    let points = points.map(|(i, j)| DVec3::new(at(i), at(j), height(at(i), at(j)))).collect();
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let faces: Vec<[u32; 3]> = squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    surface(points, &faces, &[name(0, 0), name(n, 0), name(n, n), name(0, n)])
}

/// The contoured plate of the measured ladders.
pub fn plate8() -> LoopSurface {
    let text = include_str!("../../../../data/plates/plate8.obj");
    let rows = |tag: &str| -> Vec<[f64; 3]> {
        let lines = text.lines().filter_map(|l| l.strip_prefix(tag));
        lines
            .map(|l| {
                core::array::from_fn(|i| l.split_whitespace().nth(i).and_then(|w| w.parse().ok()).expect("a number"))
            })
            .collect()
    };
    let points = rows("v ").into_iter().map(DVec3::from_array).collect();
    let faces: Vec<[u32; 3]> = rows("f ").into_iter().map(|f| f.map(|v| v as u32 - 1)).collect();
    surface(points, &faces, &[0, 8, 72, 80])
}

/// A sphere-like cage: poles of valence `n` and `rows` rings between.
pub fn globe(n: u32, rows: u32) -> LoopSurface {
    let mut points = vec![DVec3::Z, -DVec3::Z];
    for r in 0..rows {
        let polar = core::f64::consts::PI * f64::from(r + 1) / f64::from(rows + 1);
        for k in 0..n {
            let turn = TAU * (f64::from(k) + 0.5 * f64::from(r)) / f64::from(n);
            points.push(DVec3::new(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos()));
        }
    }
    let name = |r: u32, k: u32| 2 + r * n + k % n;
    let mut faces = Vec::new();
    for k in 0..n {
        faces.push([0, name(0, k), name(0, k + 1)]);
        faces.push([1, name(rows - 1, k + 1), name(rows - 1, k)]);
        for r in 0..rows - 1 {
            faces.push([name(r, k), name(r + 1, k), name(r, k + 1)]);
            faces.push([name(r, k + 1), name(r + 1, k), name(r + 1, k + 1)]);
        }
    }
    surface(points, &faces, &[])
}

/// A torus of `n` by `m` squares, cut by their diagonals.
pub fn torus(n: u32, m: u32) -> LoopSurface {
    let points = (0..n)
        .flat_map(|i| (0..m).map(move |j| (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m))));
    let points = points.map(|(a, b)| {
        let r = 1.0 + 0.4 * b.cos();
        DVec3::new(r * a.cos(), r * a.sin(), 0.4 * b.sin())
    });
    let name = |i: u32, j: u32| (i % n) * m + j % m;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    surface(points.collect(), &faces, &[])
}

/// Closest points on a plain surface: from a hint or the nearest of many samples by Gauss-Newton,
/// walking from face to face.
#[derive(Debug)]
pub struct Walker {
    surface: PlainLoop,
    mesh: Arc<Connectivity>,
    samples: Vec<(DVec3, SurfacePoint)>,
}

impl Walker {
    pub fn new(surface: &LoopSurface) -> Self {
        let corners: Vec<VertexId> =
            surface.sides.iter().filter(|s| s.ends == Ends::Corners).map(|s| s.vertices[0]).collect();
        let plain = PlainLoop::new(Arc::clone(&surface.mesh), surface.points.clone(), &corners).expect("plain");
        let mut samples = Vec::new();
        for f in 0..surface.mesh.face_count() {
            for (i, j) in (0..=4).flat_map(|i| (0..=4 - i).map(move |j| (i, j))) {
                let at = SurfacePoint::new(FaceId::new(f), f64::from(i) / 4.0, f64::from(j) / 4.0);
                samples.push((plain.position(at), at));
            }
        }
        Self { surface: plain, mesh: Arc::clone(&surface.mesh), samples }
    }

    pub fn position(&self, at: SurfacePoint) -> DVec3 {
        self.surface.position(at)
    }

    pub fn normal(&self, at: SurfacePoint) -> DVec3 {
        self.surface.normal(at)
    }

    fn walk(&self, to: DVec3, mut at: SurfacePoint) -> (DVec3, SurfacePoint) {
        for _ in 0..60 {
            let jet = self.surface.jet(at);
            let off = to - jet.position;
            let (a, b, c) = (jet.ds.dot(jet.ds), jet.ds.dot(jet.dt), jet.dt.dot(jet.dt));
            let (f, g) = (jet.ds.dot(off), jet.dt.dot(off));
            let det = a * c - b * b;
            let step = DVec2::new(c * f - b * g, a * g - b * f) / det;
            let (next, crossed) = self.go(at, step, (a, b, c, f, g));
            let moved = (next.st - at.st).length();
            at = next;
            if !crossed && moved < 1e-15 {
                break;
            }
        }
        (self.surface.position(at), at)
    }

    /// One step, through an edge at most; along a border where it leads out.
    fn go(&self, at: SurfacePoint, step: DVec2, (a, b, c, f, g): (f64, f64, f64, f64, f64)) -> (SurfacePoint, bool) {
        let weights = |p: DVec2| [1.0 - p.x - p.y, p.x, p.y];
        let (w, d) = (weights(at.st), [-step.x - step.y, step.x, step.y]);
        let mut hit = (1.0, None);
        for k in 0..3 {
            if d[k] < 0.0 && w[k] + d[k] < 0.0 {
                let t = (w[k].max(0.0) / -d[k]).min(1.0);
                if t < hit.0 || hit.1.is_none() {
                    hit = (t, Some(k));
                }
            }
        }
        let Some(k) = hit.1 else { return (SurfacePoint { face: at.face, st: at.st + step }, false) };
        let mut p = weights(at.st + step * hit.0).map(|x| x.max(0.0));
        p[k] = 0.0;
        let total = p[0] + p[1] + p[2];
        p = p.map(|x| x / total);
        let h = HalfedgeId::of(at.face, (k + 1) % 3);
        if let Some(twin) = self.mesh.twin(h) {
            let mut q = [0.0; 3];
            q[twin.corner()] = p[h.next().corner()];
            q[twin.next().corner()] = p[h.corner()];
            return (SurfacePoint::new(twin.face(), q[1], q[2]), true);
        }
        if hit.0 > 1e-14 {
            return (SurfacePoint::new(at.face, p[1], p[2]), true);
        }
        // Along the border edge: from corner k + 1 to k + 2.
        let unit = |i: usize| [DVec2::ZERO, DVec2::X, DVec2::Y][i];
        let along = unit((k + 2) % 3) - unit((k + 1) % 3);
        let slope = along.x * f + along.y * g;
        let bend = a * along.x * along.x + 2.0 * b * along.x * along.y + c * along.y * along.y;
        let wanted = p[(k + 2) % 3] + slope / bend;
        let mut q = [0.0; 3];
        if !(0.0..=1.0).contains(&wanted) {
            // On to the next border edge.
            let end = if wanted > 1.0 { (k + 2) % 3 } else { (k + 1) % 3 };
            let v = self.mesh.face(at.face)[end];
            let next = if wanted > 1.0 {
                self.mesh.outgoing(v)
            } else {
                self.mesh.ring(v).last().map_or(self.mesh.outgoing(v), HalfedgeId::previous)
            };
            if next.face() != at.face {
                let corner = if wanted > 1.0 { next.corner() } else { next.next().corner() };
                q[corner] = 1.0;
                return (SurfacePoint::new(next.face(), q[1], q[2]), true);
            }
        }
        let wanted = wanted.clamp(0.0, 1.0);
        q[(k + 2) % 3] = wanted;
        q[(k + 1) % 3] = 1.0 - wanted;
        (SurfacePoint::new(at.face, q[1], q[2]), false)
    }
}

impl Target for Walker {
    fn closest(&self, to: DVec3, hint: Option<SurfacePoint>) -> Result<Foot, TargetError> {
        let nearest = || {
            let by = |s: &&(DVec3, SurfacePoint)| s.0.distance_squared(to);
            self.samples.iter().min_by(|a, b| by(a).total_cmp(&by(b))).expect("samples").1
        };
        let (mut position, mut at) = self.walk(to, hint.unwrap_or_else(nearest));
        if hint.is_some() {
            // A hint that led astray.
            let again = self.walk(to, nearest());
            if again.0.distance(to) < position.distance(to) - 1e-9 {
                (position, at) = again;
            }
        }
        Ok(Foot { position, at: Some(at) })
    }
}

/// A flat curve laid on a surface: `plane(u)` in the axes `x`, `y` about `centre`, moved to the
/// closest point of the surface.
pub struct Laid<F> {
    pub walker: Arc<Walker>,
    pub plane: F,
    pub centre: DVec3,
    pub x: DVec3,
    pub y: DVec3,
    pub corners: Vec<f64>,
}

impl<F> core::fmt::Debug for Laid<F> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Laid")
    }
}

impl<F: Fn(f64) -> DVec2 + Send + Sync> Curve for Laid<F> {
    fn position(&self, u: f64) -> DVec3 {
        let p = (self.plane)(u);
        let at = self.centre + self.x * p.x + self.y * p.y;
        self.walker.closest(at, None).expect("a foot").position
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        true
    }
}

/// A flat curve laid vertically on a plate, the surface of a regular lattice: there the limit point of
/// a place has the lattice's own x and y, so the place is known.
pub struct OnPlate<F> {
    pub walker: Arc<Walker>,
    /// The curve in x and y.
    pub plane: F,
    pub corners: Vec<f64>,
}

impl<F> core::fmt::Debug for OnPlate<F> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("OnPlate")
    }
}

impl<F: Fn(f64) -> DVec2 + Send + Sync> Curve for OnPlate<F> {
    fn position(&self, u: f64) -> DVec3 {
        let p = (self.plane)(u);
        let faces = self.walker.mesh.face_count() as f64;
        let n = (faces / 2.0).sqrt().round();
        // The lattice is centred, and its first point is its lowest.
        let h = -2.0 * self.walker.surface.points()[0].x / n;
        let q = (p / h + DVec2::splat(0.5 * n)).clamp(DVec2::ZERO, DVec2::splat(n));
        let cell = q.floor().min(DVec2::splat(n - 1.0));
        let f = q - cell;
        let face = 2 * (cell.x * n + cell.y) as u32;
        // Faces (00, 10, 11) and (00, 11, 01).
        let at = if f.x >= f.y {
            SurfacePoint::new(FaceId(face), f.x - f.y, f.y)
        } else {
            SurfacePoint::new(FaceId(face + 1), f.x, f.y - f.x)
        };
        p.extend(self.walker.position(at).z)
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        true
    }
}

/// A circle, clockwise seen from above: what stays is outside.
pub fn circle(centre: DVec2, radius: f64) -> impl Fn(f64) -> DVec2 + Send + Sync {
    move |u| {
        let (s, c) = (TAU * u).sin_cos();
        centre + radius * DVec2::new(c, -s)
    }
}

/// A polygon, in the order of its points.
pub fn polygon(points: Vec<DVec2>) -> (impl Fn(f64) -> DVec2 + Send + Sync, Vec<f64>) {
    let n = points.len();
    let corners = (0..n).map(|i| i as f64 / n as f64).collect();
    let at = move |u: f64| {
        let x = u * n as f64;
        let i = (x.floor() as usize).min(n - 1);
        points[i].lerp(points[(i + 1) % n], x - i as f64)
    };
    (at, corners)
}

/// Numbers in [0, 1) that look random: the same on every run.
#[derive(Clone, Debug)]
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}
