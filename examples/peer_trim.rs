//! The plate with bores that other libraries are measured on, with the same input files and clock:
//! prints what each stage costs, how many triangles come out, and how good they are.
//!
//! ```text
//! peer_trim PLATE.bsp BORES.txt CAGE EPS [trim]
//! peer_trim scaling EPS
//! peer_trim threads EPS
//! peer_trim edit EPS
//! ```
//!
//! The plate is refitted as a cage of `CAGE` by `CAGE` squares, which is not timed; then it is spawned,
//! bored, triangulated and audited in an engine, to `EPS` in all. `-` for a file is a plate of the same
//! waves, or one bore in its middle. `cpu` lines are processor seconds of
//! all threads together. With `trim` nothing is triangulated.
//!
//! `scaling` prints what a bore costs among 1, 8 and 64, on plates of 1e3, 1e4 and 1e5 triangles of one
//! size: what is near a bore is the same on all. `threads` prints how much sooner 64 bores are done on two
//! threads than on one. `edit` prints what it costs to make one bore of 64 another, and to triangulate what is
//! left then: on a cage on which all bores are made together, and on a finer one on which they are not.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

#[cfg(unix)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().collect();
    if let [_, table, eps] = args.as_slice() {
        let eps = eps.parse()?;
        match table.as_str() {
            "scaling" => return peer::scaling(eps),
            "threads" => return peer::threads(eps),
            "edit" => return peer::edit(eps),
            _ => return Err("peer_trim scaling|threads|edit EPS".into()),
        }
    }
    let [_, plate, bores, cage, eps, rest @ ..] = args.as_slice() else {
        return Err("peer_trim PLATE.bsp BORES.txt CAGE EPS [trim]".into());
    };
    let (plate, bores) = (wavy::Plate::read(plate)?, peer::read_bores(bores)?);
    let surface = plate.refit(cage.parse()?)?;
    let triangles = if rest.is_empty() { peer::Output::Triangles } else { peer::Output::Surface };
    peer::bore(&surface, &bores, eps.parse()?, triangles)
}

#[cfg(not(unix))]
fn main() {
    say!("needs the processor clock of a unix");
}

#[cfg(unix)]
#[path = "../benches/support/wavy.rs"]
mod wavy;

#[cfg(unix)]
mod peer {
    use std::error::Error;
    use std::time::{Duration, Instant};

    use nix::time::{ClockId, clock_gettime};
    use selvedge::bevy_ecs::prelude::{Entity, With};
    use selvedge::curve::{Heading, SpaceCurve};
    use selvedge::diagnostics::{GroundDiagnostics, SubdivisionDiagnostics};
    use selvedge::subdivision::LoopSurface;
    use selvedge::tolerance::Tolerance;
    use selvedge::triangles::Triangles;
    use selvedge::triangulation::{TriangulateOptions, TriangulationReport};
    use selvedge::trim::{TrimFailed, TrimOptions, TrimReport, TrimmedTo};
    use selvedge::{Engine, Pass};

    use super::wavy::{self, Bore, SIZE};

    /// What is asked for.
    #[derive(Clone, Copy, PartialEq, Eq)]
    pub enum Output {
        Surface,
        Triangles,
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

    fn processor_time() -> Result<Duration, Box<dyn Error>> {
        Ok(Duration::from(clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID)?))
    }

    /// The length of the squares of the cages in [`scaling`]: 22 of them make the plate.
    const SQUARE: f64 = SIZE / 22.0;

    pub fn scaling(eps: f64) -> Result<(), Box<dyn Error>> {
        say!(
            "{:>9} {:>5} {:>9} {:>11} {:>12} {:>12}",
            "triangles",
            "bores",
            "cpu s",
            "prepare s",
            "compose s",
            "ms a bore"
        );
        for n in [22, 71, 224] {
            let surface = wavy::endless(n, SQUARE)?;
            for count in [1, 8, 64] {
                let mut engine = wavy::engine(&surface, &wavy::even_bores(count, f64::from(n) * SQUARE), eps)?;
                let start = processor_time()?;
                wavy::finish(&mut engine);
                let all = (processor_time()? - start).as_secs_f64();
                let world = engine.world();
                let (d, ground) = (world.resource::<SubdivisionDiagnostics>(), world.resource::<GroundDiagnostics>());
                // What the snapshot of the source costs, and that of the result: once for all bores.
                let prepare = (d.admit.time + ground.gather.time).as_secs_f64();
                let compose = d.compose.time.as_secs_f64();
                let each = 1e3 * (all - prepare - compose) / count as f64;
                let faces = surface.mesh.face_count();
                say!("{faces:>9} {count:>5} {all:>9.3} {prepare:>11.4} {compose:>12.4} {each:>12.2}");
            }
        }
        Ok(())
    }

    pub fn threads(eps: f64) -> Result<(), Box<dyn Error>> {
        let surface = wavy::endless(22, SQUARE)?;
        let mut walls = Vec::new();
        for threads in [1, 2] {
            let mut engine = wavy::engine(&surface, &wavy::even_bores(64, SIZE), eps)?;
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
            let (start, cpu) = (Instant::now(), processor_time()?);
            pool.install(|| wavy::finish(&mut engine));
            walls.push(start.elapsed().as_secs_f64());
            let cpu = (processor_time()? - cpu).as_secs_f64();
            say!("threads {threads} wall {:.3} cpu {cpu:.3}", walls[walls.len() - 1]);
        }
        say!("ratio {:.2}", walls[0] / walls[1]);
        Ok(())
    }

    pub fn edit(eps: f64) -> Result<(), Box<dyn Error>> {
        say!("{:>9} {:>9} {:>9} {:>12}", "triangles", "together", "trims s", "triangles s");
        for finer in [1, 8] {
            let (n, square) = (22 * finer, SQUARE / f64::from(finer));
            let (surface, mut bores) = (wavy::endless(n, square)?, wavy::even_bores(64, SIZE));
            let mut engine = wavy::engine(&surface, &bores, eps)?;
            let mut curves = engine.world_mut().query_filtered::<Entity, With<SpaceCurve>>();
            let curve = curves.iter(engine.world()).min().ok_or("there are no curves")?;
            let tolerance = Tolerance::total(eps);
            for _ in 0..2 {
                let start = processor_time()?;
                passes(&mut engine);
                let trims = processor_time()? - start;
                let mut sources = engine.world_mut().query_filtered::<Entity, With<TrimmedTo>>();
                let source = sources.single(engine.world())?;
                let result = engine.result(source).ok_or("there is no result")?;
                engine.world_mut().entity_mut(result).insert((TriangulateOptions::default(), tolerance));
                passes(&mut engine);
                let all = processor_time()? - start;
                let mut reports = engine.world_mut().query::<&TrimReport>();
                let together = reports.iter(engine.world()).map(|r| r.together.len()).max().unwrap_or(0);
                let faces = surface.mesh.face_count();
                let [trims, triangles] = [trims, all - trims].map(|time| time.as_secs_f64());
                say!("{faces:>9} {together:>9} {trims:>9.3} {triangles:>12.3}");
                // The first bore moves by a millimetre.
                bores[0][0] += 1e-3;
                let moved = SpaceCurve { curve: wavy::circle(&wavy::indexed(&surface)?, bores[0])? };
                engine.world_mut().entity_mut(result).remove::<TriangulateOptions>();
                engine.world_mut().entity_mut(curve).insert(moved);
            }
        }
        Ok(())
    }

    /// Passes until nothing is left to do: how many, and the longest.
    fn passes(engine: &mut Engine) -> (usize, Duration) {
        let (mut count, mut longest) = (0, Duration::ZERO);
        loop {
            let pass = Instant::now();
            let state = engine.update();
            longest = longest.max(pass.elapsed());
            count += 1;
            if state == Pass::Idle {
                return (count, longest);
            }
        }
    }

    pub fn bore(surface: &LoopSurface, bores: &[Bore], eps: f64, output: Output) -> Result<(), Box<dyn Error>> {
        let index = wavy::indexed(surface)?;
        let mut engine = Engine::new();
        let (start, cpu) = (Instant::now(), processor_time()?);
        let source = engine.spawn_surface(surface);
        // On this plate triangles cost more than details do: they get the larger share.
        let tolerance = Tolerance { fit: 0.3 * eps, chord: 0.6 * eps, curve: 0.1 * eps };
        let mut trims = Vec::new();
        for &bore in bores {
            let curve = engine.spawn_curve(wavy::circle(&index, bore)?);
            let cuts = [(curve, Heading::Against)];
            trims.push(engine.spawn_trim(source, &cuts, Some(tolerance), TrimOptions::default()));
        }
        let trim_passes = passes(&mut engine);
        let trimmed = (start.elapsed(), processor_time()? - cpu);
        let result = engine.result(source).ok_or("there is no result")?;
        if output == Output::Triangles {
            engine.world_mut().entity_mut(result).insert((TriangulateOptions::default(), tolerance));
        }
        let triangle_passes = passes(&mut engine);
        let all = (start.elapsed(), processor_time()? - cpu);
        let world = engine.world();
        say!("faces.source {}", surface.mesh.face_count());
        say!("bores {}", bores.len());
        say!("wall.trim {:.4}\ncpu.trim {:.4}", trimmed.0.as_secs_f64(), trimmed.1.as_secs_f64());
        say!("wall {:.4}\ncpu {:.4}", all.0.as_secs_f64(), all.1.as_secs_f64());
        for (what, (count, longest)) in [("trim", trim_passes), ("triangulate", triangle_passes)] {
            say!("passes.{what} {count}\nlongest_pass_ms.{what} {:.2}", longest.as_secs_f64() * 1e3);
        }
        let d = world.resource::<SubdivisionDiagnostics>();
        let stages = [
            ("admit", d.admit),
            ("locate", d.locate),
            ("remesh", d.remesh),
            ("relax", d.relax),
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
            say!("wall.{name} {:.4}", counters.time.as_secs_f64());
        }
        let reports: Vec<&TrimReport> = trims.iter().filter_map(|&t| world.get(t)).collect();
        let failed = trims.iter().filter(|&&t| world.get::<TrimFailed>(t).is_some()).count();
        let failures = trims.iter().filter_map(|&trim| world.get::<TrimFailed>(trim));
        failures.for_each(|failed| say!("failure {failed}"));
        let greatest = reports.iter().map(|r| r.audit.greatest().0).fold(0.0, f64::max);
        let together = reports.iter().map(|r| r.together.len()).max().unwrap_or(0);
        say!("failed {failed}\nachieved_um {:.3}\nlargest_group {together}", greatest * 1e6);
        let details: usize = reports.iter().map(|r| r.details / r.together.len()).sum();
        let levels = reports.iter().map(|r| r.ladder.len()).max().unwrap_or(0);
        say!("details {details}\nlevels {levels}");
        if let Some(made) = world.get::<Triangles>(result) {
            say!("triangles {}", made.triangles.len());
        }
        if let Some(report) = world.get::<TriangulationReport>(result) {
            say!("worst_shape {:.4}", report.worst_shape);
        }
        Ok(())
    }
}
