//! The main job: a contoured disc becomes a hubcap.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use selvedge_components::subdivision::LoopSurface;
use selvedge_components::triangles::Triangles;
use selvedge_components::trim::{TrimFault, TrimReport};
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

use super::limit::write_glb;
use crate::io::obj;
use crate::scenes::trims::{Scene, Settings, subjects};
use crate::{Engine, TrimProgress};

/// The distance asked for, in metres.
const TOLERANCE: f64 = 1e-6;
/// Between the triangles written and the limit surface, in metres.
const CHORD: f64 = 2e-5;

/// Trims the disc as a host would, and writes the hubcap, its cage, a report and pictures.
pub(super) fn run(out: &Path) -> Result<(), Box<dyn Error>> {
    let scene = subjects::hubcap()?;
    let settings = Settings::within(TOLERANCE);
    let (surface, report) = match trim(&scene, &settings) {
        Ok(done) => done,
        Err(Failure::Trim(why)) => {
            #[cfg(feature = "diagram")]
            crate::scenes::trim_pictures::failed::picture(&scene, &why)?.save(out.join("hubcap_failed.png"))?;
            return Err(why.into());
        }
        Err(Failure::Other(why)) => return Err(why),
    };
    let lines = lines(&scene, &report);
    lines.iter().for_each(|line| println!("{line}"));
    fs::write(out.join("hubcap.txt"), lines.join("\n") + "\n")?;
    write(out, &surface)?;
    #[cfg(feature = "diagram")]
    draw(out, &scene, &settings, &surface)?;
    Ok(())
}

enum Failure {
    Trim(TrimFault),
    Other(Box<dyn Error>),
}

/// The surface, the curves and the trim are entities; the engine takes passes.
fn trim(scene: &Scene, settings: &Settings) -> Result<(Arc<LoopSurface>, TrimReport), Failure> {
    let other = |why: &str| Failure::Other(why.into());
    let mut engine = Engine::new();
    let source = engine.spawn_surface(&scene.ground.surface);
    let mut last = None;
    for cuts in &scene.trims {
        let curves: Vec<_> = cuts.iter().map(|cut| (engine.spawn_curve(Arc::clone(&cut.curve)), cut.heading)).collect();
        last = Some(engine.spawn_trim(source, &curves, settings.tolerance, settings.options.clone()));
    }
    let passes = engine.settle().map_err(|why| Failure::Other(why.into()))?;
    let last = last.ok_or_else(|| other("the scene has no trim"))?;
    let report = match engine.trim_progress(last) {
        Some(TrimProgress::Finished(report)) => *report,
        Some(TrimProgress::Failed(failed)) => return Err(Failure::Trim(failed.why)),
        unfinished => return Err(other(&format!("the trim is {unfinished:?} after {passes} passes"))),
    };
    let result = engine.result(source).and_then(|result| engine.surface(result));
    let Some(Ok(surface)) = result else { return Err(other("the trim has no result")) };
    Ok((Arc::clone(surface), report))
}

fn lines(scene: &Scene, report: &TrimReport) -> Vec<String> {
    let cuts: usize = scene.trims.iter().map(Vec::len).sum();
    let mut lines = vec![format!("{}: {cuts} curves cut from a disc of 0.4 m, within {TOLERANCE:e} m", scene.name)];
    lines.extend(report.initial.map(|rung| format!("  before any detail: max {:.3e} m", rung.max)));
    lines.extend(report.ladder.iter().map(|rung| {
        format!("  level {}: max {:.3e} m, mean {:.2e} m, {} details", rung.level, rung.max, rung.mean, rung.details)
    }));
    let (audit, cage) = (&report.audit, &report.cage);
    lines.push(format!(
        "  audit: {:.3e} m at {} other places, {} border points the curves' own bits, {} loops, Euler number {}",
        audit.greatest().0,
        audit.samples,
        audit.border_samples,
        audit.loops,
        audit.euler
    ));
    lines.push(format!(
        "  cage: {} faces, {} of them beyond reach, valence up to {}, worst shape {:.3}",
        cage.faces, cage.outside, cage.greatest_valence, cage.worst_shape
    ));
    lines
}

fn write(out: &Path, surface: &LoopSurface) -> Result<(), Box<dyn Error>> {
    let options = TriangulateOptions { density: Density::Chord(CHORD), ..TriangulateOptions::default() };
    write_glb(out, "hubcap", &triangulate(surface, &options)?.triangles)?;
    let corners = surface.mesh.faces().iter().map(|f| f.map(|v| v.0)).collect();
    let cage = Triangles { positions: surface.points.clone(), triangles: corners, ..Triangles::default() };
    write_glb(out, "hubcap_cage", &cage)?;
    Ok(obj::write(&mut fs::File::create(out.join("hubcap_cage.obj"))?, &cage)?)
}

/// The pictures need what lies between the stages, which a world does not keep: the same kernels run
/// once more, and must come to the same details.
#[cfg(feature = "diagram")]
fn draw(out: &Path, scene: &Scene, settings: &Settings, surface: &LoopSurface) -> Result<(), Box<dyn Error>> {
    use crate::diagram::camera::{Frame, View};
    use crate::scenes::trim_pictures::{errors, stages, views};
    let trimmed = crate::scenes::trims::run(scene, settings)?;
    if trimmed.surface.details != surface.details {
        return Err("the engine and its kernels have come to different details".into());
    }
    views::figure(&trimmed, &View::from_angles(-70.0, 46.0), Frame::new(900, 720))?.save(out.join("hubcap.png"))?;
    stages::figure(&trimmed)?.save(out.join("hubcap_stages.png"))?;
    errors::maps(&trimmed, &errors::MapStyle::above(2))?.save(out.join("hubcap_errors.png"))?;
    errors::ladder("hubcap of 0.4 m", &[("within 1 \u{b5}m", &trimmed)])?.save(out.join("hubcap_ladder.png"))?;
    Ok(())
}
