//! You will see a round bore cut into a contoured plate.
#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::error::Error;

use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Settings, run, subjects};

fn main() -> Result<(), Box<dyn Error>> {
    let scene = subjects::bore8()?;
    let settings = Settings::levels(3);
    let trimmed = run(&scene, &settings)?;
    for line in TrimRow::of(&trimmed, &settings)?.lines() { println!("{line}"); }
    for (name, settings) in [("hub", Settings::within(1e-6)), ("hub", Settings::levels(3))] {
        let scene = subjects::hubcap()?;
        let trimmed = run(&scene, &settings)?;
        println!("{name}");
        for line in TrimRow::of(&trimmed, &settings)?.lines() { println!("{line}"); }
    }
    Ok(())
}
