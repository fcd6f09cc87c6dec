//! `selvedge demo`: the main job, on input that comes with the program.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use selvedge_components::subdivision::{CornerRule, LoopSurface};
use selvedge_components::target::Projection;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

use super::hubcap;
use super::limit::{write_glb, write_limit};
use crate::scenes::{limit, octant};
use crate::{DVec3, Engine, Progress};

pub(super) fn run(out: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(out)?;
    hubcap::run(out)?;
    write_limit(&limit::spot()?, Density::Chord(5e-4), out, "spot")?;
    fit_octant(out)?;
    say!("the files are in {}", out.display());
    Ok(())
}

/// Fits the octant as a host would: the surface and the job are entities, the engine takes passes.
fn fit_octant(out: &Path) -> Result<(), Box<dyn Error>> {
    let meshes = octant::meshes()?;
    let mesh = meshes.last().ok_or("the octant has no mesh")?;
    let source = octant::surface(mesh, CornerRule::Lattice)?;
    let mut engine = Engine::new();
    let surface = engine.spawn_surface(&source);
    let sphere = Arc::new(Projection(|p: DVec3| p * (octant::RADIUS / p.length())));
    let job = engine.spawn_fit(surface, sphere, octant::options(octant::Method::Lsq));
    let passes = engine.settle()?;
    let report = match engine.progress(job) {
        Some(Progress::Finished(report)) => report,
        other => return Err(format!("the octant was not fitted: {other:?}").into()),
    };
    say!("octant {}: fitted to a sphere of radius {} m in {passes} passes", mesh.name, octant::RADIUS);
    for rung in &report.ladder {
        say!("  level {}: max {:.2e} m, mean {:.1e} m, {} details", rung.level, rung.max, rung.mean, rung.details);
    }
    let Some(Ok(fitted)) = engine.surface(surface) else { return Err("the fitted octant is gone".into()) };
    write_octant(out, fitted)
}

fn write_octant(out: &Path, fitted: &LoopSurface) -> Result<(), Box<dyn Error>> {
    let options = TriangulateOptions { density: Density::Chord(2e-5), ..TriangulateOptions::default() };
    write_glb(out, "octant", &triangulate(fitted, &options)?.triangles)?;
    #[cfg(feature = "diagram")]
    {
        use crate::scenes::octant_pictures as pictures;
        use selvedge_systems::subdivision::fit::Storage;
        let meshes = octant::meshes()?;
        let mesh = meshes.last().ok_or("the octant has no mesh")?;
        let fit = octant::fit(mesh, octant::Method::Lsq, Storage::F64, 5, 5)?;
        pictures::figure(&fit)?.save(out.join("octant.png"))?;
        pictures::error_maps(&fit)?.save(out.join("octant_error_maps.png"))?;
        let deep = octant::fit(mesh, octant::Method::Lsq, Storage::F64, 5, 16)?;
        let quasi = octant::fit(mesh, octant::Method::Quasi, Storage::F64, 5, 5)?;
        pictures::ladder_plot(&[&quasi.row, &deep.row])?.save(out.join("octant_ladder.png"))?;
    }
    Ok(())
}
