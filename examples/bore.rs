//! You will see a round bore cut into a contoured plate: its error ladder on four levels, then down to
//! 13 um, 1 um and 10 nm; the same in a plate sixteen times as large, also with a bound on how far
//! anything may change; in `out/` the stages of remeshing, the points that correspond anew, where each
//! level works, and error maps. `--json` prints the figures; `--levels`, `--eps`, `--reach` ask otherwise.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use clap::Parser;
use selvedge::scenes::trim_pictures::{errors, regions, stages};
use selvedge::scenes::trims::row::TrimRow;
use selvedge::scenes::trims::{Scene, Settings, run, subjects};

/// Edge of both plates' squares, in metres.
const H: f64 = 0.05;

#[derive(Parser)]
struct Arguments {
    /// Print the figures as JSON, and draw nothing.
    #[arg(long)]
    json: bool,
    /// Only the plate of 0.4 m, down to this level.
    #[arg(long)]
    levels: Option<u32>,
    /// Only the plate of 0.4 m, within this distance in metres.
    #[arg(long, conflicts_with = "levels")]
    eps: Option<f64>,
    /// Only the plate of 1.6 m, changed no farther than each of these from the curve: in metres, or in
    /// edges of its squares as in `2h,h,h/2`.
    #[arg(long, value_delimiter = ',', value_parser = length, conflicts_with_all = ["levels", "eps"])]
    reach: Vec<f64>,
}

/// `0.1`, `2h`, `h`, `h/4`.
fn length(text: &str) -> Result<f64, String> {
    let number = |text: &str| text.parse::<f64>().map_err(|why| format!("{text}: {why}"));
    match text.split_once('h') {
        None => number(text),
        Some(("", "")) => Ok(H),
        Some((factor, "")) => Ok(H * number(factor)?),
        Some(("", part)) => Ok(H / number(part.trim_start_matches('/'))?),
        Some(_) => Err(format!("{text} is not a length")),
    }
}

fn jobs(asked: &Arguments) -> Result<Vec<(Scene, Settings)>, Box<dyn Error>> {
    const EPS: f64 = 13e-6;
    let (small, large) = (subjects::bore8()?, subjects::bore32()?);
    let reach = |scene: &Scene, reach: f64| {
        let name = format!("{}, reach {:.1} mm", scene.name, 1e3 * reach);
        (Scene { name, ..scene.clone() }, Settings::within(EPS).reaching(reach))
    };
    if let Some(levels) = asked.levels {
        return Ok(vec![(small, Settings::levels(levels))]);
    }
    if let Some(eps) = asked.eps {
        return Ok(vec![(small, Settings::within(eps))]);
    }
    if !asked.reach.is_empty() {
        return Ok(asked.reach.iter().map(|&r| reach(&large, r)).collect());
    }
    let mut jobs = vec![(small.clone(), Settings::levels(3))];
    jobs.extend([EPS, 1e-6, 1e-8].map(|eps| (small.clone(), Settings::within(eps))));
    jobs.push((large.clone(), Settings::within(EPS)));
    jobs.extend([2.0, 1.0, 0.5, 0.25].map(|part| reach(&large, part * H)));
    Ok(jobs)
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked = Arguments::parse();
    let mut rows = Vec::new();
    for (scene, settings) in jobs(&asked)? {
        rows.push(TrimRow::of(&run(&scene, &settings)?, &settings)?);
    }
    if asked.json {
        say!("{}", TrimRow::json(&rows)?);
        return Ok(());
    }
    rows.iter().flat_map(TrimRow::lines).for_each(|line| say!("{line}"));
    std::fs::create_dir_all("out")?;
    let small = run(&subjects::bore8()?, &Settings::within(1e-6))?;
    stages::figure(&small)?.save("out/bore_stages.png")?;
    stages::resampled(&small)?.save("out/bore_resampled.png")?;
    errors::maps(&small, &errors::MapStyle::above(4))?.save("out/bore_errors.png")?;
    regions::figure(&run(&subjects::bore32()?, &Settings::within(1e-6))?)?.save("out/bore_regions.png")?;
    Ok(())
}
