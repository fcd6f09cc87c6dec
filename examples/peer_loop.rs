//! The Loop workloads that other libraries are measured on, with the same input files, numbers and
//! clock, so that both sides can be run in one call.
//!
//! ```text
//! peer_loop refine MESH.obj LEVEL TAG [REPS]     cage to limit points and triangles; points moved; normals
//! peer_loop eval   MESH.obj PLACES TAG [REPS]    position and derivatives at random places
//! ```
//!
//! Prints `name value unit` lines: `NAME` is the median of wall seconds, `NAME.cpu` that of processor
//! seconds on one thread, `NAME.rate` is per processor second.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

#[cfg(unix)]
fn main() -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
    let args: Vec<String> = std::env::args().collect();
    let [_, mode, file, number, tag, rest @ ..] = args.as_slice() else {
        return Err("peer_loop refine|eval MESH.obj LEVEL|PLACES TAG [REPS]".into());
    };
    let reps = rest.first().map_or(Ok(7), |r| r.parse())?;
    let cage = peer::read_obj(file)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| match mode.as_str() {
        "refine" => peer::refine(&cage, number.parse()?, tag, reps),
        "eval" => peer::eval(&cage, number.parse()?, tag, reps),
        other => Err(format!("{other} is neither refine nor eval").into()),
    })
}

#[cfg(not(unix))]
fn main() {
    say!("needs the processor clock of a unix");
}

#[cfg(unix)]
mod peer {
    use std::error::Error;
    use std::sync::Arc;
    use std::time::{Duration, Instant};

    use glam::DVec3;
    use nix::sys::resource::{UsageWho, getrusage};
    use nix::time::{ClockId, clock_gettime};
    use selvedge_components::evaluate::{Jet, SurfacePoint};
    use selvedge_components::mesh::{Connectivity, FaceId};
    use selvedge_components::subdivision::PlainLoop;
    use selvedge_systems::subdivision::evaluate::{jets, jets_by_face};
    use selvedge_systems::subdivision::tessellate::{Faces, Tessellator, triangles};

    type Done = Result<(), Box<dyn Error + Send + Sync>>;

    pub struct Cage {
        points: Vec<DVec3>,
        faces: Vec<[u32; 3]>,
    }

    pub fn read_obj(path: &str) -> Result<Cage, Box<dyn Error + Send + Sync>> {
        let mut cage = Cage { points: Vec::new(), faces: Vec::new() };
        for line in std::fs::read_to_string(path)?.lines() {
            let mut words = line.split_ascii_whitespace();
            match words.next() {
                Some("v") => {
                    let p: Vec<f64> = words.map(str::parse).collect::<Result<_, _>>()?;
                    cage.points.push(DVec3::from_slice(&p));
                }
                Some("f") => {
                    let f: Vec<u32> = words.map(str::parse).collect::<Result<_, _>>()?;
                    cage.faces.push([f[0] - 1, f[1] - 1, f[2] - 1]);
                }
                _ => {}
            }
        }
        Ok(cage)
    }

    fn surface(cage: &Cage) -> Result<PlainLoop, Box<dyn Error + Send + Sync>> {
        let mesh = Connectivity::new(cage.points.len(), &cage.faces).map_err(|f| format!("{f:?}"))?;
        Ok(PlainLoop::new(Arc::new(mesh), cage.points.clone(), &[])?)
    }

    fn processor_time() -> Duration {
        clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
    }

    fn put(name: &str, value: f64, unit: &str) {
        say!("{name} {value:.6} {unit}");
    }

    fn put_peak(name: &str) {
        let kib = getrusage(UsageWho::RUSAGE_SELF).map_or(0, |usage| usage.max_rss());
        put(&format!("{name}peak"), kib as f64 / 1024.0, "MiB");
    }

    fn median(mut seconds: Vec<f64>) -> f64 {
        seconds.sort_by(f64::total_cmp);
        let n = seconds.len();
        if n % 2 == 1 { seconds[n / 2] } else { 0.5 * (seconds[n / 2 - 1] + seconds[n / 2]) }
    }

    /// Times `run`, prints what the head says and returns its last result.
    fn time<T>(name: &str, points: usize, reps: usize, mut run: impl FnMut() -> T) -> T {
        let (mut wall, mut cpu, mut result) = (Vec::new(), Vec::new(), None);
        for _ in 0..reps.max(1) {
            drop(result.take());
            let (start, spent) = (Instant::now(), processor_time());
            result = Some(run());
            cpu.push((processor_time() - spent).as_secs_f64());
            wall.push(start.elapsed().as_secs_f64());
        }
        let (least, most) = wall.iter().fold((f64::MAX, 0.0_f64), |(l, m), &w| (l.min(w), m.max(w)));
        put(name, median(wall), "s");
        put(&format!("{name}.min"), least, "s");
        put(&format!("{name}.max"), most, "s");
        put(&format!("{name}.cpu_min"), cpu.iter().copied().fold(f64::MAX, f64::min), "s");
        let cpu = median(cpu);
        put(&format!("{name}.cpu"), cpu, "s");
        put(&format!("{name}.rate"), points as f64 / cpu * 1e-6, "Mpts/s");
        result.expect("at least one run")
    }

    pub fn refine(cage: &Cage, level: u32, tag: &str, reps: usize) -> Done {
        let name = format!("W1.selvedge.{tag}.L{level}.");
        let count = Tessellator::new(surface(cage)?.topology().mesh(), level)?.lattice().vertex_count();
        put(&format!("{name}points"), count as f64, "points");
        // From a list of faces: connectivity, numbering, limit points, triangles.
        let cold = || -> Result<_, Box<dyn Error + Send + Sync>> {
            let surface = surface(cage)?;
            let tessellator = Tessellator::new(surface.topology().mesh(), level)?;
            let positions = tessellator.positions(&surface)?;
            let triangles = triangles(surface.topology().mesh(), tessellator.lattice());
            Ok((surface, tessellator, positions, triangles))
        };
        let (mut surface, tessellator, mut positions, triangles) = time(&format!("{name}cold"), count, reps, cold)?;
        put_peak(&name);
        time(&format!("{name}moved_f64"), count, reps, || -> Done {
            surface.move_points(&cage.points)?;
            tessellator.write_positions(&surface, Faces::All, &mut positions)?;
            Ok(())
        })?;
        time(&format!("{name}normals_f64"), count, reps, || tessellator.normals(&surface))?;
        put(&format!("{name}triangles"), triangles.len() as f64, "triangles");
        put_peak(&format!("{name}normals_"));
        Ok(())
    }

    /// splitmix64, as the other side draws its places.
    struct Random(u64);

    impl Random {
        fn unit(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    pub fn eval(cage: &Cage, places: usize, tag: &str, reps: usize) -> Done {
        let name = format!("W2.selvedge.{tag}.");
        let mut random = Random(42);
        let mut at = Vec::with_capacity(places);
        for _ in 0..places {
            let face = (random.unit() * cage.faces.len() as f64) as usize;
            let (s, t) = (random.unit(), random.unit());
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            // The other side keeps them in 32 bits; the same places here.
            at.push(SurfacePoint::new(FaceId::new(face), f64::from(s as f32), f64::from(t as f32)));
        }
        let mesh = Arc::new(Connectivity::new(cage.points.len(), &cage.faces).map_err(|f| format!("{f:?}"))?);
        let build = || PlainLoop::new(Arc::clone(&mesh), cage.points.clone(), &[]);
        let surface = time(&format!("{name}build"), places, reps, build)?;
        let mut results = vec![Jet::default(); places];
        time(&format!("{name}P_Du_Dv_random"), places, reps, || jets(&surface, &at, &mut results))?;
        at.sort_by_key(|p| p.face);
        time(&format!("{name}P_Du_Dv_sorted"), places, reps, || jets_by_face(&surface, &at, &mut results))?;
        put_peak(&name);
        Ok(())
    }
}
