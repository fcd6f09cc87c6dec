//! You will see an octant of a sphere fitted level by level: its error ladders by two rules on two
//! meshes, down to rounding around the irregular vertex; pictures of the cage, the limit surface, the
//! fit and its six error maps in `out/`. `--json` prints the ladders, `--f32` stores single precision.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use selvedge::scenes::octant::{self, Method};
use selvedge::scenes::octant_pictures as pictures;
use selvedge_systems::subdivision::fit::Storage;

fn main() -> Result<(), Box<dyn Error>> {
    let asked = |flag: &str| std::env::args().any(|arg| arg == flag);
    let storage = if asked("--f32") { Storage::F32 } else { Storage::F64 };
    let meshes = octant::meshes()?;

    let mut fits = Vec::new();
    for mesh in &meshes {
        for method in Method::ALL {
            fits.push(octant::fit(mesh, method, storage, 5, 5)?);
        }
    }
    // Once more, on around the irregular vertex.
    let deep = octant::fit(&meshes[meshes.len() - 1], Method::Lsq, storage, 5, 16)?;

    std::fs::create_dir_all("out")?;
    let best = &fits[fits.len() - Method::ALL.len()];
    pictures::figure(best)?.save("out/octant.png")?;
    pictures::error_maps(best)?.save("out/octant_error_maps.png")?;
    let mut rows: Vec<_> = fits.iter().map(|fit| &fit.row).collect();
    // The deep ladder begins with the rungs of the one it goes on from.
    let mut plotted = rows.clone();
    plotted[fits.len() - Method::ALL.len()] = &deep.row;
    pictures::ladder_plot(&plotted)?.save("out/octant_ladder.png")?;
    rows.push(&deep.row);

    if asked("--json") {
        say!("{}", serde_json::to_string(&rows)?);
        return Ok(());
    }
    for row in rows {
        say!("{} by {:?}: {:.3e} m before any detail", row.mesh, row.rule, row.initial_max_m);
        for level in &row.levels {
            let ratio = level.ratio.map_or(String::new(), |ratio| format!("   /{ratio:.2}"));
            say!(
                "  {:2}  max {:.3e}  mean {:.3e}  {:5} details{ratio}",
                level.level,
                level.zone_max_m,
                level.mean_m,
                level.details
            );
        }
    }
    Ok(())
}
