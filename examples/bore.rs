//! You will see a round bore cut into a contoured plate.
#![expect(clippy::print_stdout, reason = "an example talks to its user")]

use std::error::Error;

use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Settings, run, subjects};

fn main() -> Result<(), Box<dyn Error>> {
    let which = std::env::args().nth(1).unwrap_or_default();
    let eps: f64 = std::env::args().nth(2).unwrap_or("3".into()).parse()?;
    let scenes = match which.as_str() {
        "bore8" => vec![subjects::bore8()?], "bore32" => vec![subjects::bore32()?], "hub" => vec![subjects::hubcap()?],
        "stars" => subjects::stars()?, "succ" => vec![subjects::successive()?],
        _ => { let mut v = vec![]; for w in subjects::WALLS.into_iter().chain([-0.01,-0.03]) { v.push(subjects::thin_wall(w)?); } v }
    };
    let settings = if eps >= 1.0 || eps == 0.0 { Settings::levels(eps as u32) } else { Settings::within(eps) };
    for scene in scenes {
    let trimmed = match run(&scene, &settings) { Ok(t) => t, Err(w) => { println!("{}: {w}", scene.name); continue } };
    let t = std::time::Instant::now();
    for line in TrimRow::of(&trimmed, &settings)?.lines() { println!("{line}"); }
    println!("measured in {:?}", t.elapsed());
    }
    Ok(())
}
