//! You will see every stage of the engine, in the order in which they run: its set, its system, and
//! what that reads, writes, inserts and removes. `--json` prints one array.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use bevy_ecs::prelude::*;
use selvedge::schedule::{STAGES, StageContract};

fn main() -> Result<(), Box<dyn Error>> {
    // The list is what the engine promises; that its systems keep to it is checked against a
    // schedule here, as a host would that wants to know what runs in its own.
    let (mut world, mut schedule) = (World::new(), Schedule::default());
    selvedge::install(&mut world, &mut schedule);
    schedule.initialize(&mut world)?;
    let running: Vec<String> = schedule.systems()?.map(|(_, system)| system.name().to_string()).collect();
    let runs = |stage: &StageContract| running.iter().any(|r| r.ends_with(stage.system));

    if std::env::args().any(|arg| arg == "--json") {
        let row = |stage: &StageContract| {
            serde_json::json!({
                "set": stage.set, "system": stage.system, "runs": runs(stage), "does": stage.does, "reads": stage.reads,
                "writes": stage.writes, "inserts": stage.inserts, "removes": stage.removes,
            })
        };
        say!("{}", serde_json::Value::from(STAGES.iter().map(row).collect::<Vec<_>>()));
        return Ok(());
    }
    for stage in STAGES {
        say!("{}", stage.set);
        let mark = if runs(stage) { "" } else { "   (does not run)" };
        say!("  {} {}{mark}", stage.system, stage.does);
        let lists =
            [("reads", stage.reads), ("writes", stage.writes), ("inserts", stage.inserts), ("removes", stage.removes)];
        for (verb, names) in lists.into_iter().filter(|(_, names)| !names.is_empty()) {
            say!("    {verb:8} {}", names.join(", "));
        }
    }
    Ok(())
}
