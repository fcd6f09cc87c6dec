//! You will see a host run the engine in a world and schedule of its own, frame by frame: a surface is
//! fitted to a sphere, the host edits it in mid-fit, and the fit begins again. `--json` prints one
//! array of frames.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::ScheduleLabel;
use selvedge::job::{FitJob, JobState};
use selvedge::mesh::Connectivity;
use selvedge::report::FitReport;
use selvedge::schedule::SelvedgeSystems;
use selvedge::subdivision::fit::FitOptions;
use selvedge::subdivision::{ControlPointIndex, Position};
use selvedge::{DVec3, Projection, install, spawn_cage, spawn_fit, strict};

/// The host's own label; the engine does not know it.
#[derive(ScheduleLabel, Clone, Debug, PartialEq, Eq, Hash)]
struct Frame;

/// The host's own state; the engine does not touch it.
#[derive(Resource, Default)]
struct Clock {
    frame: u64,
}

/// One line of the log.
#[derive(serde::Serialize)]
struct Seen {
    frame: u64,
    state: String,
    level: u32,
    quanta: u64,
    error: Option<f64>,
}

#[derive(Resource, Default)]
struct Log(Vec<Seen>);

/// A host's system that edits sources: before the engine looks at them.
fn sculpt(mut clock: ResMut<Clock>, mut points: Query<(&mut Position, &ControlPointIndex)>) {
    clock.frame += 1;
    if clock.frame == 20 {
        for (mut point, _) in points.iter_mut().filter(|(_, index)| index.0 == 0) {
            point.0 *= 1.2;
        }
    }
}

/// A host's system that looks at results: after the engine has written them.
fn watch(clock: Res<Clock>, jobs: Query<&FitJob>, mut log: ResMut<Log>) {
    for job in &jobs {
        let state = match job.state {
            JobState::Running(stage) => stage.to_string(),
            JobState::Finished => "finished".into(),
            JobState::Failed => "failed".into(),
        };
        log.0.push(Seen { frame: clock.frame, state, level: job.level, quanta: job.quanta, error: job.error });
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut world, mut schedule) = (World::new(), Schedule::new(Frame));
    world.init_resource::<Clock>();
    world.init_resource::<Log>();
    // From here on, two systems without an order between them are an error: the host's own too.
    schedule.set_build_settings(strict());
    install(&mut world, &mut schedule);
    schedule.add_systems((sculpt.before(SelvedgeSystems::Gather), watch.after(SelvedgeSystems::Finish)));

    let points = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];
    let faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
    let mesh = Connectivity::new(6, &faces).expect("an octahedron has no fault");
    let cage = spawn_cage(&mut world, Arc::new(mesh), &points);
    let sphere = Arc::new(Projection(|p: DVec3| p.normalize()));
    let options = FitOptions { tolerance: Some(2e-3), ..FitOptions::default() };
    let fit = spawn_fit(&mut world, cage, sphere, options);

    // A host has frames of its own; this one stops when the fit is there.
    while world.get::<FitReport>(fit).is_none() && world.resource::<Clock>().frame < 10_000 {
        schedule.run(&mut world);
    }
    let log = &world.resource::<Log>().0;
    if std::env::args().any(|arg| arg == "--json") {
        say!("{}", serde_json::to_string(log)?);
        return Ok(());
    }
    say!("frame  stage       level  quanta  error");
    let mut last = String::new();
    for seen in log {
        let error = seen.error.map_or("-".into(), |error| format!("{error:.2e}"));
        let line = format!("{:10}  {:5}", seen.state, seen.level);
        if line != last {
            say!("{:5}  {line}  {:6}  {error}", seen.frame, seen.quanta);
        }
        last = line;
    }
    Ok(())
}
