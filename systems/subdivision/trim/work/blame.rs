//! Which of the trims that are made together a failure is about.

use glam::DVec3;
use selvedge_components::subdivision::fit::Outcome;
use selvedge_components::subdivision::remesh::{PreImageError, RemeshError};
use selvedge_components::trim::{TrimAuditFault, TrimFault};
use thiserror::Error;

use super::TrimWork;
use crate::subdivision::remesh::PreImage;

/// A failure of trims made together, and which of them is to go.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("trim {trim}: {why}")]
pub struct Blamed {
    /// The trim, by index among those made together.
    pub trim: usize,
    /// Where it is about curves of two of them, the older.
    pub with: Option<usize>,
    /// What happened.
    pub why: TrimFault,
}

impl TrimWork {
    /// A failure for which no single curve can be named is that of the newest trim: those before it
    /// may be sound without it.
    pub fn newest(&self, why: TrimFault) -> Blamed {
        Blamed { trim: self.members.len().saturating_sub(1), with: None, why }
    }

    /// A failure at a place is that of the trim whose curve is nearest; one at no place the newest's.
    pub fn nearest(&self, why: TrimFault) -> Blamed {
        let Some(at) = place_of(&why) else { return self.newest(why) };
        let away = |image: &PreImage| {
            let distances = image.points.iter().map(|p| p.position.distance_squared(at));
            distances.fold(f64::INFINITY, f64::min)
        };
        let owners = self.owners().into_iter().map(|owner| owner.0);
        let nearest = self.parts().zip(owners).map(|((_, image), trim)| (away(image), trim));
        match nearest.reduce(|a, b| if b.0 < a.0 { b } else { a }) {
            Some((_, trim)) => Blamed { trim, with: None, why },
            None => self.newest(why),
        }
    }

    /// Names the trim whose curve an error is about, and the curve as that trim counts its own.
    pub(super) fn blame(&self, mut why: RemeshError) -> Blamed {
        let owners = self.owners();
        if let RemeshError::Gap { curves, .. }
        | RemeshError::Tangential { curves, .. }
        | RemeshError::Coincident { curves, .. } = &mut why
        {
            // Of two that do not go together, the newer one is in the way.
            let [older, newer] = curves.map(|part| owners.get(part).map(|owner| owner.0));
            *curves = curves.map(|part| owners.get(part).map_or(part, |owner| owner.1));
            return match newer {
                Some(trim) => Blamed { trim, with: older.filter(|&older| older != trim), why: why.into() },
                None => self.newest(why.into()),
            };
        }
        let blamed = match &mut why {
            RemeshError::PreImage { source: PreImageError::Crossing { curves, .. }, curve } => {
                // Of two curves that cross, the newer one is in the way.
                let newer = curves[0].max(curves[1]);
                *curves = curves.map(|part| owners.get(part).map_or(part, |owner| owner.1));
                Some((curve, newer))
            }
            RemeshError::PreImage { curve, .. }
            | RemeshError::Open { curve, .. }
            | RemeshError::DoesNotSeparate { curve, .. }
            | RemeshError::NothingLeft { curve }
            | RemeshError::TooFine { curve, .. }
            | RemeshError::Tangled { curve, .. }
            | RemeshError::Cusp { curve, .. }
            | RemeshError::BorderGap { curve, .. }
            | RemeshError::AlongBorder { curve, .. }
            | RemeshError::TouchesBorder { curve, .. }
            | RemeshError::Unresolved { curve, .. } => {
                let part = *curve;
                Some((curve, part))
            }
            _ => None,
        };
        let Some((curve, part)) = blamed else { return self.newest(why.into()) };
        let Some(&(trim, own)) = owners.get(part) else { return self.newest(why.into()) };
        *curve = own;
        Blamed { trim, with: None, why: why.into() }
    }

    /// An error with its curves as the trims count them.
    pub(in super::super) fn named(&self, why: RemeshError) -> TrimFault {
        self.blame(why).why
    }
}

/// Where something went wrong, if that is one place.
fn place_of(why: &TrimFault) -> Option<DVec3> {
    match why {
        TrimFault::NotReached { outcome } => match outcome {
            Outcome::LevelsSpent { at, .. } | Outcome::Stalled { at, .. } | Outcome::OutOfReach { at, .. } => Some(*at),
            Outcome::Within => None,
        },
        TrimFault::Audit { faults } => faults.iter().find_map(|fault| match fault {
            TrimAuditFault::Distance { at, .. }
            | TrimAuditFault::Outside { at, .. }
            | TrimAuditFault::OffCurve { at, .. } => Some(*at),
            _ => None,
        }),
        _ => None,
    }
}
