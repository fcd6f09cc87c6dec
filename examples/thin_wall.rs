//! You will see a bore move towards the rim of a disc: walls from 20 mm down to 0.1 mm, then through the
//! rim, which it meets in two corners. Cages and figures; `--json` prints the figures alone.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use selvedge::scenes::trim_pictures::stages;
use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Settings, run, subjects};

fn main() -> Result<(), Box<dyn Error>> {
    let json = std::env::args().any(|arg| arg == "--json");
    let settings = Settings::within(1e-5);
    let (mut rows, mut trimmed) = (Vec::new(), Vec::new());
    for wall in subjects::WALLS.into_iter().chain(subjects::THROUGH) {
        let done = run(&subjects::thin_wall(wall)?, &settings)?;
        rows.push(TrimRow::of(&done, &settings)?);
        trimmed.push(done);
    }
    if json {
        say!("{}", TrimRow::json(&rows)?);
        return Ok(());
    }
    rows.iter().flat_map(TrimRow::lines).for_each(|line| say!("{line}"));
    std::fs::create_dir_all("out")?;
    let shown: Vec<_> = [0, 2, 4, 8, 9].map(|i| &trimmed[i]).to_vec();
    stages::cages(&shown, 0.06)?.save("out/thin_wall.png")?;
    Ok(())
}
