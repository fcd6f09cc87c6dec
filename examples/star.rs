//! You will see a star with sharp convex and concave corners, an S-shaped slot, and a hole with an island
//! in it, cut into a plate: figures, and in `out/` their stages and error maps. `--json` prints the figures
//! alone.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use selvedge::scenes::trim_pictures::{errors, stages};
use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Settings, run, subjects};

fn main() -> Result<(), Box<dyn Error>> {
    let settings = Settings::within(1e-5);
    let scenes = subjects::stars()?;
    let rows = TrimRow::of_all(&scenes, &settings)?;
    if std::env::args().any(|arg| arg == "--json") {
        say!("{}", TrimRow::json(&rows)?);
        return Ok(());
    }
    rows.iter().flat_map(TrimRow::lines).for_each(|line| say!("{line}"));
    std::fs::create_dir_all("out")?;
    for (scene, file) in scenes.iter().zip(["star", "slot", "island"]) {
        let trimmed = run(scene, &settings)?;
        stages::figure(&trimmed)?.save(format!("out/{file}_stages.png"))?;
        errors::maps(&trimmed, &errors::MapStyle::above(3))?.save(format!("out/{file}_errors.png"))?;
    }
    Ok(())
}
