//! You will see every stencil of the scheme for valences 3 to 12, and what boundary details do to a
//! plate; the pictures go to `out/`. `--json` prints the weights.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;

use selvedge::scenes::{stencil_pictures as pictures, stencils};

fn main() -> Result<(), Box<dyn Error>> {
    let rows = stencils::all().map_err(|faults| faults[0].clone())?;
    std::fs::create_dir_all("out")?;
    pictures::rings(&rows, "vertex")?.save("out/stencils_vertex.png")?;
    pictures::rings(&rows, "limit")?.save("out/stencils_limit.png")?;
    pictures::rings(&rows, "interior detail")?.save("out/stencils_detail.png")?;
    pictures::details()?.save("out/boundary_details.png")?;
    if std::env::args().any(|arg| arg == "--json") {
        say!("{}", serde_json::to_string(&rows)?);
        return Ok(());
    }
    for row in &rows {
        let valence = row.valence.map_or(String::new(), |k| format!(", valence {k}"));
        let weights: Vec<String> = row.weights.iter().map(|(place, w)| format!("{place} {w:.6}")).collect();
        say!("Fig. {:3} {}{valence}: {}", row.figure, row.name, weights.join(", "));
    }
    Ok(())
}
