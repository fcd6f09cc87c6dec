//! You will see twenty trims of one plate, one after the other: bores, stars, slots, and bores through the
//! edges of earlier ones; every error is measured against the plate as it was given. Figures after each
//! fifth trim, and the cage after the last in `out/`. `--json` prints the figures alone.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use selvedge::scenes::trim_pictures::stages;
use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Scene, Settings, run, subjects};

fn main() -> Result<(), Box<dyn Error>> {
    let settings = Settings::within(1e-5);
    let all = subjects::successive()?;
    let (mut rows, mut last) = (Vec::new(), None);
    for count in 1..=all.trims.len() {
        let name = format!("{count} {}", all.name);
        let scene = Scene { name, trims: all.trims[..count].to_vec(), ..all.clone() };
        let trimmed = run(&scene, &settings)?;
        if count % 5 == 0 {
            rows.push(TrimRow::of(&trimmed, &settings)?);
        }
        last = Some(trimmed);
    }
    if std::env::args().any(|arg| arg == "--json") {
        say!("{}", TrimRow::json(&rows)?);
        return Ok(());
    }
    rows.iter().flat_map(TrimRow::lines).for_each(|line| say!("{line}"));
    std::fs::create_dir_all("out")?;
    let last = last.ok_or("there are twenty trims")?;
    stages::cages(&[&last], f64::INFINITY)?.save("out/successive.png")?;
    Ok(())
}
