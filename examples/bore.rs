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
    if std::env::var("PIC").is_err() { for line in TrimRow::of(&trimmed, &settings)?.lines() { println!("{line}"); } }
    if std::env::var("PIC").is_ok() {
        use selvedge::scenes::trim_pictures::*;
        use selvedge::diagram::camera::*;
        std::fs::create_dir_all("out")?;
        let t = std::time::Instant::now();
        stages::figure(&trimmed)?.save("out/p_stages.png")?; println!("{:?}", t.elapsed());
        stages::resampled(&trimmed)?.save("out/p_resampled.png")?;println!("{:?}", t.elapsed());
        regions::figure(&trimmed)?.save("out/p_regions.png")?;println!("{:?}", t.elapsed());
        let view = View::from_angles(-70.0, 38.0);
        let style = errors::MapStyle { view: View::from_angles(-90.0, 89.9).orthographic(), frame: Frame::new(520,520), level: std::env::var("PIC")?.parse()?, columns: 3 };
        errors::maps(&trimmed, &style)?.save("out/p_errors.png")?;println!("{:?}", t.elapsed());
        views::figure(&trimmed, &view, Frame::new(900,640))?.save("out/p_views.png")?;println!("{:?}", t.elapsed());
        views::portrait(&trimmed, &view, Frame::new(1400,1000))?.save("out/p_portrait.png")?;println!("{:?}", t.elapsed());
        errors::ladder("ladder", &[("bore", &trimmed)])?.save("out/p_ladder.png")?;println!("{:?}", t.elapsed());
        return Ok(());
    }
    println!("measured in {:?}", t.elapsed());
    }
    Ok(())
}
