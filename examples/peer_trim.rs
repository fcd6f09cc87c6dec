//! The plate with bores that other libraries are measured on, with the same input files and clock:
//! prints what each stage costs, how many triangles come out, and how good they are.
//!
//! ```text
//! peer_trim PLATE.bsp BORES.txt CAGE EPS [trim]
//! ```
//!
//! The plate is refitted as a cage of `CAGE` by `CAGE` squares, which is not timed; then it is spawned,
//! bored, triangulated and audited in an engine, to `EPS` in all. `-` for a file is a plate of the same
//! waves, or one bore in its middle. `cpu` lines are processor seconds of
//! all threads together. With `trim` nothing is triangulated.
#![expect(clippy::print_stdout, reason = "its output is what it is for")]

#[cfg(unix)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, plate, bores, cage, eps, rest @ ..] = args.as_slice() else {
        return Err("peer_trim PLATE.bsp BORES.txt CAGE EPS [trim]".into());
    };
    let (plate, bores) = (peer::Plate::read(plate)?, peer::read_bores(bores)?);
    let surface = plate.refit(cage.parse()?)?;
    let triangles = if rest.is_empty() { peer::Output::Triangles } else { peer::Output::Surface };
    peer::bore(&surface, &bores, eps.parse()?, triangles)
}

#[cfg(not(unix))]
fn main() {
    println!("needs the processor clock of a unix");
}

#[cfg(unix)]
mod peer {
    use std::error::Error;
    use std::f64::consts::TAU;
    use std::sync::Arc;
    use std::time::{Duration, Instant};

    use glam::DVec3;
    use nix::time::{ClockId, clock_gettime};
    use selvedge::curve::{Circle, Curve, Heading};
    use selvedge::diagnostics::{GroundDiagnostics, SubdivisionDiagnostics};
    use selvedge::mesh::{Connectivity, VertexId};
    use selvedge::subdivision::{CornerTable, LoopSurface, Scheme, limit_frame};
    use selvedge::tolerance::Tolerance;
    use selvedge::triangles::Triangles;
    use selvedge::triangulation::{TriangulateOptions, TriangulationReport};
    use selvedge::trim::{TrimFailed, TrimOptions, TrimReport};
    use selvedge::{Engine, Pass};
    use selvedge_systems::closest::SurfaceIndex;
    use selvedge_systems::projected_curve::{Pick, ProjectedCurve};
    use selvedge_systems::subdivision::chain;
    use selvedge_systems::subdivision::limit::LimitSurface;

    type Bore = [f64; 3];

    /// What is asked for.
    #[derive(Clone, Copy, PartialEq, Eq)]
    pub enum Output {
        Surface,
        Triangles,
    }

    /// A bicubic height field over a square of 0.4 m.
    pub struct Plate {
        knots: [Vec<f64>; 2],
        counts: [usize; 2],
        heights: Vec<f64>,
    }

    const SIZE: f64 = 0.4;

    impl Plate {
        /// The waves at the abscissae of a net of 20 by 20.
        fn waves() -> Self {
            const N: usize = 20;
            let knots: Vec<f64> = (0..N + 4).map(|k| (k.clamp(3, N) - 3) as f64 / (N - 3) as f64).collect();
            let at = |i: usize| (knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3.0;
            let turns = |x: f64| (TAU * x).sin_cos();
            let wave =
                |x: f64, y: f64| 0.010 * turns(2.0 * x).0 * turns(1.5 * y).1 + 0.002 * turns(4.3 * x + 2.1 * y).0;
            let heights = (0..N * N).map(|k| wave(at(k / N), at(k % N))).collect();
            Self { heights, counts: [N, N], knots: [knots.clone(), knots] }
        }

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
            let at = |i: u32| SIZE * f64::from(i) / f64::from(n);
            let name = |i: u32, j: u32| i * (n + 1) + j;
            let squares = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            let faces: Vec<[u32; 3]> = squares
                .flat_map(|(i, j)| {
                    let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
                    [[a, b, c], [a, c, d]]
                })
                .collect();
            let places = (0..=n).flat_map(|i| (0..=n).map(move |j| (at(i), at(j))));
            let points: Vec<DVec3> = places.map(|(x, y)| DVec3::new(x, y, self.height(x, y))).collect();
            let mesh = Arc::new(Connectivity::new(points.len(), &faces).map_err(|f| format!("{f:?}"))?);
            let corners: Vec<VertexId> = [name(0, 0), name(n, 0), name(n, n), name(0, n)].map(VertexId).to_vec();
            let mut surface = LoopSurface::plain(mesh, points, &corners);
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

    pub fn read_bores(path: &str) -> Result<Vec<Bore>, Box<dyn Error>> {
        if path == "-" {
            return Ok(vec![[0.5 * SIZE, 0.5 * SIZE, SIZE / 8.0]]);
        }
        let text = std::fs::read_to_string(path)?;
        let bore = |line: &str| -> Result<Bore, Box<dyn Error>> {
            let numbers: Vec<f64> = line.split_ascii_whitespace().map(str::parse).collect::<Result<_, _>>()?;
            Ok(numbers.try_into().map_err(|_| "a bore is three numbers")?)
        };
        text.lines().map(bore).collect()
    }

    fn circle(index: &Arc<SurfaceIndex<LimitSurface>>, [x, y, radius]: Bore) -> Result<Arc<dyn Curve>, Box<dyn Error>> {
        let above = Circle::new(DVec3::new(x, y, 0.1), DVec3::Z, radius)?;
        Ok(Arc::new(ProjectedCurve::new(Arc::new(above), DVec3::NEG_Z, Arc::clone(index), Pick::First)?))
    }

    fn processor_time() -> Result<Duration, Box<dyn Error>> {
        Ok(Duration::from(clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID)?))
    }

    pub fn bore(surface: &LoopSurface, bores: &[Bore], eps: f64, output: Output) -> Result<(), Box<dyn Error>> {
        let index = Arc::new(SurfaceIndex::new(Arc::new(LimitSurface::new(Arc::new(surface.clone()))?))?);
        let mut engine = Engine::new();
        let (start, cpu) = (Instant::now(), processor_time()?);
        let source = engine.spawn_surface(surface);
        let tolerance = Tolerance::total(eps);
        let mut trims = Vec::new();
        for &bore in bores {
            let curve = engine.spawn_curve(circle(&index, bore)?);
            let cuts = [(curve, Heading::Against)];
            trims.push(engine.spawn_trim(source, &cuts, Some(tolerance), TrimOptions::default()));
        }
        let (mut passes, mut longest) = (0, Duration::ZERO);
        loop {
            let pass = Instant::now();
            let state = engine.update();
            longest = longest.max(pass.elapsed());
            passes += 1;
            if state == Pass::Idle {
                break;
            }
        }
        let trimmed = (start.elapsed(), processor_time()? - cpu);
        let result = engine.result(source).ok_or("there is no result")?;
        if output == Output::Triangles {
            engine.world_mut().entity_mut(result).insert((TriangulateOptions::default(), tolerance));
            engine.update();
        }
        let all = (start.elapsed(), processor_time()? - cpu);
        let world = engine.world();
        println!("faces.source {}", surface.mesh.face_count());
        println!("bores {}", bores.len());
        println!("wall.trim {:.4}\ncpu.trim {:.4}", trimmed.0.as_secs_f64(), trimmed.1.as_secs_f64());
        println!("wall {:.4}\ncpu {:.4}", all.0.as_secs_f64(), all.1.as_secs_f64());
        println!("passes {passes}\nlongest_pass_ms {:.2}", longest.as_secs_f64() * 1e3);
        let d = world.resource::<SubdivisionDiagnostics>();
        let stages = [
            ("admit", d.admit),
            ("locate", d.locate),
            ("remesh", d.remesh),
            ("correspond", d.correspond),
            ("modify", d.modify),
            ("refine", d.refine),
            ("audit", d.audit),
            ("advance", d.advance),
            ("compose", d.compose),
        ];
        let ground = world.resource::<GroundDiagnostics>();
        let grounds = [("gather", ground.gather), ("check", ground.check), ("triangulate", ground.triangulate)];
        for (name, counters) in stages.iter().chain(&grounds) {
            println!("wall.{name} {:.4}", counters.time.as_secs_f64());
        }
        let reports: Vec<&TrimReport> = trims.iter().filter_map(|&t| world.get(t)).collect();
        let failed = trims.iter().filter(|&&t| world.get::<TrimFailed>(t).is_some()).count();
        let failures = trims.iter().filter_map(|&trim| world.get::<TrimFailed>(trim));
        failures.for_each(|failed| println!("failure {failed}"));
        let greatest = reports.iter().map(|r| r.audit.greatest().0).fold(0.0, f64::max);
        let together = reports.iter().map(|r| r.together.len()).max().unwrap_or(0);
        println!("failed {failed}\nachieved_um {:.3}\nlargest_group {together}", greatest * 1e6);
        let details: usize = reports.iter().map(|r| r.details / r.together.len()).sum();
        let levels = reports.iter().map(|r| r.ladder.len()).max().unwrap_or(0);
        println!("details {details}\nlevels {levels}");
        if let Some(made) = world.get::<Triangles>(result) {
            println!("triangles {}", made.triangles.len());
        }
        if let Some(report) = world.get::<TriangulationReport>(result) {
            println!("worst_shape {:.4}", report.worst_shape);
        }
        Ok(())
    }
}
