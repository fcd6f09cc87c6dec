//! `selvedge limit`: a cage from a file to its limit surface.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};

use selvedge_components::triangles::Triangles;
use selvedge_systems::triangulate::{Density, TriangulateOptions, Triangulation};

use crate::io::{Cage, Limits, obj, read_cage};
use crate::scenes::limit::limit;

/// What `selvedge limit` is told.
#[derive(Debug, clap::Args)]
pub(super) struct Arguments {
    /// An OBJ or GLB file; a `.tags.json` file beside it declares corners.
    cage: PathBuf,
    /// The greatest distance between triangles and limit surface, in the units of the file.
    #[arg(long, conflicts_with = "level")]
    chord: Option<f64>,
    /// Quarter every face this many times.
    #[arg(long, default_value_t = 3)]
    level: u32,
    /// Where the files go.
    #[arg(long, default_value = "out")]
    out: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let cage = read_cage(&arguments.cage, &Limits::default())?;
    let density = arguments.chord.map_or(Density::Level(arguments.level), Density::Chord);
    let name = arguments.cage.file_stem().map_or("limit".into(), |stem| stem.to_string_lossy().into_owned());
    write_limit(&cage, density, &arguments.out, &name)
}

/// Writes the limit surface of `cage` as OBJ, GLB and a picture, as far as the features go.
pub(super) fn write_limit(cage: &Cage, density: Density, out: &Path, name: &str) -> Result<(), Box<dyn Error>> {
    let made = limit(cage, &TriangulateOptions { density, ..TriangulateOptions::default() })?;
    let Triangulation { triangles, report, .. } = &made.triangulation;
    say!(
        "{name}: {} control points, {} faces; {} triangles on the limit surface, worst shape {:.3}",
        cage.positions.len(),
        cage.triangles.len(),
        triangles.triangles.len(),
        report.worst_shape,
    );
    say!("  {} corners of the border kept", cage.corners.len());
    for what in &cage.import.unkept {
        say!("  not kept: {what}");
    }
    if let Some(chord) = &report.chord {
        say!("  chord asked {:.3e}, achieved {:.3e} over {} samples", chord.asked, chord.achieved, chord.samples);
    }
    fs::create_dir_all(out)?;
    obj::write(&mut fs::File::create(out.join(format!("{name}.obj")))?, triangles)?;
    write_glb(out, name, triangles)?;
    #[cfg(feature = "diagram")]
    crate::scenes::limit_pictures::figure(cage, triangles, 720)?.save(out.join(format!("{name}.png")))?;
    Ok(())
}

/// Writes a GLB file, where the feature is on, and says what single precision costs.
pub(super) fn write_glb(out: &Path, name: &str, triangles: &Triangles) -> Result<(), Box<dyn Error>> {
    #[cfg(feature = "gltf")]
    {
        let object = crate::io::glb::Object { name, surface: triangles, extras: None };
        let file = crate::io::glb::write(&[object])?;
        fs::write(out.join(format!("{name}.glb")), &file.bytes)?;
        for object in &file.objects {
            say!("  {name}.glb: single precision moves no vertex by more than {:.2e}", object.error);
        }
    }
    let _ = (out, name, triangles);
    Ok(())
}
