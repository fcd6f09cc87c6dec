//! The plate with waves that trims are measured on.
#![allow(dead_code, reason = "each program uses its own part of this module")]

use std::error::Error;
use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec3;
use selvedge::curve::{Circle, Curve, Heading};
use selvedge::mesh::{Connectivity, VertexId};
use selvedge::subdivision::{CornerTable, LoopSurface, Scheme, limit_frame};
use selvedge::tolerance::Tolerance;
use selvedge::trim::TrimOptions;
use selvedge::{Engine, Pass};
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::projected_curve::{Pick, ProjectedCurve};
use selvedge_systems::subdivision::chain;
use selvedge_systems::subdivision::limit::LimitSurface;

/// The middle and the radius of a bore, in metres.
pub type Bore = [f64; 3];

/// A bicubic height field over a square of 0.4 m.
pub struct Plate {
    knots: [Vec<f64>; 2],
    counts: [usize; 2],
    heights: Vec<f64>,
}

/// The length of its sides, in metres.
pub const SIZE: f64 = 0.4;

impl Plate {
    /// The waves at the abscissae of a net of 20 by 20.
    pub fn waves() -> Self {
        const N: usize = 20;
        let knots: Vec<f64> = (0..N + 4).map(|k| (k.clamp(3, N) - 3) as f64 / (N - 3) as f64).collect();
        let at = |i: usize| (knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3.0;
        let heights = (0..N * N).map(|k| wave(at(k / N), at(k % N))).collect();
        Self { heights, counts: [N, N], knots: [knots.clone(), knots] }
    }

    /// The plate in a file; that of [`Plate::waves`] for `-`.
    pub fn read(path: &str) -> Result<Self, Box<dyn Error>> {
        if path == "-" {
            return Ok(Self::waves());
        }
        let text = std::fs::read_to_string(path)?;
        let mut numbers = text.split_ascii_whitespace().map(str::parse::<f64>);
        let mut next = || numbers.next().ok_or("the plate's file is too short")?.map_err(Box::<dyn Error>::from);
        let [p, q, n, m] = [next()? as usize, next()? as usize, next()? as usize, next()? as usize];
        if (p, q) != (3, 3) {
            return Err("the plate is not bicubic".into());
        }
        let mut knots = [Vec::new(), Vec::new()];
        for (list, count) in knots.iter_mut().zip([n + 4, m + 4]) {
            for _ in 0..count {
                list.push(next()?);
            }
        }
        let mut heights = Vec::new();
        for _ in 0..n * m {
            // Its place in the plane, which is known.
            next()?;
            next()?;
            heights.push(next()?);
        }
        Ok(Self { knots, counts: [n, m], heights })
    }

    fn height(&self, x: f64, y: f64) -> f64 {
        let [(i, a), (j, b)] = [(0, x), (1, y)].map(|(k, at)| basis(&self.knots[k], self.counts[k], at / SIZE));
        let row = |k: usize| (0..4).map(|l| b[l] * self.heights[(i + k) * self.counts[1] + j + l]).sum::<f64>();
        (0..4).map(|k| a[k] * row(k)).sum()
    }

    /// A cage of `n` by `n` squares whose limit surface meets the plate at its vertices.
    pub fn refit(&self, n: u32) -> Result<LoopSurface, Box<dyn Error>> {
        let mut surface = lattice(n, SIZE / f64::from(n), |x, y| self.height(x, y))?;
        for _ in 0..40 {
            let table = CornerTable::new(&surface);
            let root = chain::root(&surface, &table, &surface.details);
            let scheme = Scheme { surface: &surface, corners: &table };
            let limit = |v: usize| limit_frame(scheme, &root.mesh, &root.state, v as u32).map(|f| f.position);
            let off = |x: DVec3| self.height(x.x, x.y) - x.z;
            let moves: Vec<f64> = (0..surface.points.len()).map(|v| limit(v).map_or(0.0, off)).collect();
            surface.points.iter_mut().zip(moves).for_each(|(p, by)| p.z += by);
        }
        Ok(surface)
    }
}

/// The first of the four cubic B-splines that are not zero at `t`, and their values. [de Boor 1972]
fn basis(knots: &[f64], count: usize, t: f64) -> (usize, [f64; 4]) {
    let t = t.clamp(0.0, 1.0);
    let span = knots.partition_point(|&k| k <= t).clamp(4, count) - 1;
    let mut values = [1.0, 0.0, 0.0, 0.0];
    for degree in 1..4 {
        let mut saved = 0.0;
        for r in 0..degree {
            let (right, left) = (knots[span + r + 1] - t, t - knots[span + 1 + r - degree]);
            let part = values[r] / (right + left);
            values[r] = saved + right * part;
            saved = left * part;
        }
        values[degree] = saved;
    }
    (span - 3, values)
}

/// The heights, in metres, where the plate's sides are as long as 1.
fn wave(x: f64, y: f64) -> f64 {
    let turns = |x: f64| (TAU * x).sin_cos();
    0.010 * turns(2.0 * x).0 * turns(1.5 * y).1 + 0.002 * turns(4.3 * x + 2.1 * y).0
}

/// A plate of `n` by `n` squares of the same size, whatever `n`, under waves that run on.
pub fn endless(n: u32, square: f64) -> Result<LoopSurface, Box<dyn Error>> {
    lattice(n, square, |x, y| wave(x / SIZE, y / SIZE))
}

/// A cage of `n` by `n` squares under a height field.
fn lattice(n: u32, square: f64, height: impl Fn(f64, f64) -> f64) -> Result<LoopSurface, Box<dyn Error>> {
    let at = |i: u32| square * f64::from(i);
    let name = |i: u32, j: u32| i * (n + 1) + j;
    let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let faces: Vec<[u32; 3]> = squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    let places = (0..=n).flat_map(|i| (0..=n).map(move |j| (at(i), at(j))));
    let points: Vec<DVec3> = places.map(|(x, y)| DVec3::new(x, y, height(x, y))).collect();
    let mesh = Arc::new(Connectivity::new(points.len(), &faces).map_err(|f| format!("{f:?}"))?);
    let corners: Vec<VertexId> = [name(0, 0), name(n, 0), name(n, n), name(0, n)].map(VertexId).to_vec();
    Ok(LoopSurface::plain(mesh, points, &corners))
}

/// The first `count` of 64 bores of 12 mm, evenly over a square of 0.4 m in the middle of a plate of `size`.
pub fn even_bores(count: usize, size: f64) -> Vec<Bore> {
    let at = |k: usize| 0.5 * (size - SIZE) + SIZE * (k as f64 + 0.5) / 8.0;
    (0..count.min(64)).map(|k| k * 27 + 28).map(|k| [at(k % 64 / 8), at(k % 8), 0.012]).collect()
}

/// A surface, ready to have curves carried onto it.
pub fn indexed(surface: &LoopSurface) -> Result<Arc<SurfaceIndex<LimitSurface>>, Box<dyn Error>> {
    Ok(Arc::new(SurfaceIndex::new(Arc::new(LimitSurface::new(Arc::new(surface.clone()))?))?))
}

/// The circle of a bore, carried onto the surface from above.
pub fn circle(index: &Arc<SurfaceIndex<LimitSurface>>, [x, y, radius]: Bore) -> Result<Arc<dyn Curve>, Box<dyn Error>> {
    let above = Circle::new(DVec3::new(x, y, 0.1), DVec3::Z, radius)?;
    Ok(Arc::new(ProjectedCurve::new(Arc::new(above), DVec3::NEG_Z, Arc::clone(index), Pick::First)?))
}

/// An engine with the surface and its trims, none of which has begun.
pub fn engine(surface: &LoopSurface, bores: &[Bore], eps: f64) -> Result<Engine, Box<dyn Error>> {
    let index = indexed(surface)?;
    let mut engine = Engine::new();
    let source = engine.spawn_surface(surface);
    for &bore in bores {
        let curve = engine.spawn_curve(circle(&index, bore)?);
        engine.spawn_trim(source, &[(curve, Heading::Against)], Some(Tolerance::total(eps)), TrimOptions::default());
    }
    Ok(engine)
}

/// Passes until nothing is left to do; tells how many.
pub fn finish(engine: &mut Engine) -> usize {
    let mut passes = 1;
    while engine.update() != Pass::Idle {
        passes += 1;
    }
    passes
}
