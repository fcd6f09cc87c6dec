//! You will see a plate with a bore and the wall of the bore, a swept tube: two surfaces that share a
//! trim curve and meet along it without an open edge, to the bit, on every level. `--json` prints the
//! figures alone; else a picture of both goes to `out/`.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use selvedge::diagram::camera::{Frame, View};
use selvedge::scenes::trim_pictures::views;
use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Settings, run, shared, subjects};

fn main() -> Result<(), Box<dyn Error>> {
    let settings = Settings::within(1e-6);
    let scene = subjects::bore8()?;
    let trimmed = run(&scene, &settings)?;
    let wall = shared::wall(&trimmed)?;
    let mut rows = Vec::new();
    for level in 0..=3 {
        let open = shared::open_seam_edges(&trimmed, &wall, level)?;
        let row = TrimRow::of(&trimmed, &settings)?;
        let name = format!("plate and bore wall, level {level}");
        rows.push(TrimRow { name, open_edges: row.open_edges + open, ..row }.kept()?);
    }
    if std::env::args().any(|arg| arg == "--json") {
        say!("{}", TrimRow::json(&rows)?);
        return Ok(());
    }
    rows.iter().flat_map(TrimRow::lines).for_each(|line| say!("{line}"));
    std::fs::create_dir_all("out")?;
    let view = View::from_angles(-65.0, 36.0);
    views::together(&[&trimmed.surface, &wall], &view, Frame::new(1200, 820))?.save("out/shared_curve.png")?;
    Ok(())
}
