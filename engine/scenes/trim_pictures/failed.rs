//! A trim that failed: what is known of it.

use glam::DVec3;
use selvedge_components::subdivision::remesh::{PreImageError, RemeshError};
use selvedge_components::trim::{TrimAuditFault, TrimFault};

use super::{TrimPictureError, root_faces};
use crate::diagram::canvas::{Canvas, Ends, Stroke};
use crate::diagram::colour::{Colour, palette};
use crate::diagram::domain::Domain;
use crate::diagram::grid::{Cell, Grid};
use crate::scenes::trims::Scene;

/// Pixels across the diagram.
const SIZE: u32 = 900;

/// The given cage, the curves as far as they can be evaluated, and the place of the failure with its
/// words.
///
/// # Errors
/// As the drawing.
pub fn picture(scene: &Scene, why: &TrimFault) -> Result<Canvas, TrimPictureError> {
    const PIECES: u32 = 512;
    let all = root_faces(scene.ground.limit());
    let mut page = Domain::new(&all, SIZE)?;
    page.fill(&all, Colour::hex(0xf1_f1_ee));
    page.edges(&all, palette::SLATE, 0.8);
    for cut in scene.trims.iter().flatten() {
        let points = (0..=PIECES).map(|k| cut.curve.position(f64::from(k) / f64::from(PIECES)));
        let points: Vec<DVec3> = points.collect();
        for run in points.split(|p| !p.is_finite()) {
            page.curve(run, Ends::Open, &Stroke::new(palette::BLUE, 2.2));
        }
    }
    for place in places(why) {
        page.mark(place, "here", palette::RED);
    }
    let cell = Cell::new(page.into_canvas(), format!("{}: {why}", scene.name));
    Ok(Grid::new(1, 19.0).compose(&[cell])?)
}

/// The places that a failure names; none if it names none.
pub fn places(why: &TrimFault) -> Vec<DVec3> {
    let of_remesh = |why: &RemeshError| match why {
        RemeshError::PreImage { source, .. } => of_image(source),
        RemeshError::DoesNotSeparate { at, .. }
        | RemeshError::TooFine { at, .. }
        | RemeshError::Gap { at, .. }
        | RemeshError::BorderGap { at, .. }
        | RemeshError::Tangential { at, .. }
        | RemeshError::AlongBorder { at, .. }
        | RemeshError::TouchesBorder { at, .. }
        | RemeshError::Coincident { at, .. }
        | RemeshError::Tangled { at, .. }
        | RemeshError::Cusp { at, .. }
        | RemeshError::Unresolved { at, .. }
        | RemeshError::OutOfReach { at, .. } => vec![*at],
        _ => Vec::new(),
    };
    let of_audit = |fault: &TrimAuditFault| match fault {
        TrimAuditFault::Distance { at, .. }
        | TrimAuditFault::Outside { at, .. }
        | TrimAuditFault::OffCurve { at, .. } => Some(*at),
        _ => None,
    };
    let places = match why {
        TrimFault::Misses { at, .. } | TrimFault::TooSmall { at, .. } => vec![*at],
        TrimFault::Remesh(why) => of_remesh(why),
        TrimFault::NotReached { outcome } => of_outcome(outcome),
        TrimFault::Audit { faults } => faults.iter().filter_map(of_audit).collect(),
        _ => Vec::new(),
    };
    places.into_iter().filter(|p| p.is_finite()).collect()
}

fn of_outcome(outcome: &selvedge_components::subdivision::fit::Outcome) -> Vec<DVec3> {
    use selvedge_components::subdivision::fit::Outcome;
    match outcome {
        Outcome::Within => Vec::new(),
        Outcome::LevelsSpent { at, .. } | Outcome::Stalled { at, .. } | Outcome::OutOfReach { at, .. } => vec![*at],
    }
}

fn of_image(why: &PreImageError) -> Vec<DVec3> {
    match why {
        PreImageError::NotFinite { at, .. }
        | PreImageError::TooFarOff { at, .. }
        | PreImageError::LeavesSurface { at, .. }
        | PreImageError::Ambiguous { at, .. }
        | PreImageError::NoLength { at, .. }
        | PreImageError::Crossing { at, .. } => vec![*at],
        _ => Vec::new(),
    }
}
