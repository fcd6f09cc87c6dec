//! You will see a contoured disc trimmed into a hubcap: eleven curves with rounded and sharp corners in
//! one trim, its error ladder down to level 3 and down to 1 um; in `out/` the hubcap with its cages, the
//! stages, error maps of every level and the ladder. `--json` prints the figures.
#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::error::Error;

use selvedge::diagram::camera::{Frame, View};
use selvedge::scenes::trim_pictures::{errors, stages, views};
use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Settings, run, subjects};

fn main() -> Result<(), Box<dyn Error>> {
    let scene = subjects::hubcap()?;
    let (levels, within) = (Settings::levels(3), Settings::within(1e-6));
    let (all, adaptive) = (run(&scene, &levels)?, run(&scene, &within)?);
    let rows = [TrimRow::of(&all, &levels)?, TrimRow::of(&adaptive, &within)?];
    if std::env::args().any(|arg| arg == "--json") {
        println!("{}", TrimRow::json(&rows)?);
        return Ok(());
    }
    rows.iter().flat_map(TrimRow::lines).for_each(|line| println!("{line}"));
    std::fs::create_dir_all("out")?;
    let view = View::from_angles(-70.0, 46.0);
    views::figure(&adaptive, &view, Frame::new(900, 720))?.save("out/hubcap_views.png")?;
    stages::figure(&adaptive)?.save("out/hubcap_stages.png")?;
    errors::maps(&adaptive, &errors::MapStyle::above(3))?.save("out/hubcap_errors.png")?;
    let ladders = [("everywhere to level 3", &all), ("within 1 \u{b5}m", &adaptive)];
    errors::ladder("hubcap of 0.4 m", &ladders)?.save("out/hubcap_ladder.png")?;
    Ok(())
}
