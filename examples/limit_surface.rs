//! You will see a control cage from a file become its limit surface, within a chord of a thousandth of
//! its size, with what the file format costs; GLB, OBJ and a picture go to `out/`. Takes a path to an
//! OBJ or GLB file (Spot without one); `--json` prints the figures.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

use std::error::Error;
use std::fs;
use std::path::PathBuf;
use std::time::Instant;

use selvedge::glam::DVec3;
use selvedge::io::{Limits, glb, obj, read_cage};
use selvedge::scenes::limit::{LimitRow, limit, spot};
use selvedge::scenes::limit_pictures;
use selvedge_systems::triangulate::{Density, TriangulateOptions};

fn main() -> Result<(), Box<dyn Error>> {
    let (flags, paths): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let path = paths.first().map(PathBuf::from);
    let cage = path
        .as_ref()
        .map_or_else(|| spot().map_err(Box::<dyn Error>::from), |p| Ok(read_cage(p, &Limits::default())?))?;
    let name = path.as_ref().and_then(|p| p.file_stem()).map_or("spot".into(), |stem| stem.to_string_lossy());

    let (low, high) = cage.positions.iter().fold((DVec3::MAX, DVec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
    let options =
        TriangulateOptions { density: Density::Chord(1e-3 * low.distance(high)), ..TriangulateOptions::default() };
    let start = Instant::now();
    let made = limit(&cage, &options)?;
    let seconds = start.elapsed().as_secs_f64();

    fs::create_dir_all("out")?;
    let triangles = &made.triangulation.triangles;
    let file = glb::write(&[glb::Object { name: &name, surface: triangles, extras: None }])?;
    fs::write(format!("out/{name}.glb"), &file.bytes)?;
    obj::write(&mut fs::File::create(format!("out/{name}.obj"))?, triangles)?;
    limit_pictures::figure(&cage, triangles, 720)?.save(format!("out/{name}.png"))?;

    let mut row = serde_json::to_value(LimitRow::new(name, &cage, &made))?;
    row["file_error"] = file.objects[0].error.into();
    row["seconds"] = seconds.into();
    if flags.iter().any(|flag| flag == "--json") {
        say!("{}", serde_json::json!([row]));
    } else {
        say!("{row:#}");
    }
    Ok(())
}
