//! The other side of a trim, made after what stays: the same stages, one quantum at a time.

use std::sync::Arc;

use selvedge_components::subdivision::LoopSurface;
use selvedge_components::subdivision::fit::{Outcome, Quantum};
use selvedge_components::subdivision::remesh::RemeshError;
use selvedge_components::trim::{OtherReport, TrimFault, TrimQuantum};

use super::audit::TrimAuditWork;
use super::work::TrimWork;
use crate::subdivision::fit::FitWork;
use crate::subdivision::remesh::{Beyond, OtherSide, RelaxQuantum, RemeshQuantum, RemeshWork, Remeshed};

/// What a trim removes, being made. Lives in the work of the trims that it is made with.
#[derive(Debug)]
pub struct OtherWork {
    /// The trim, by index among those made together.
    pub trim: usize,
    stage: Stage,
}

#[derive(Debug)]
enum Stage {
    Remesh(Box<RemeshWork>),
    Relax(Box<RemeshWork>),
    Fit(Made),
    Audit(Made, Box<TrimAuditWork>),
    Done(Made, Box<TrimAuditWork>),
    /// It has failed.
    Failed,
}

/// The cage, and its fit.
#[derive(Debug)]
struct Made {
    remeshed: Arc<Remeshed>,
    fit: Box<FitWork>,
}

/// Begins to work the curves of one trim into the cage, turned; with parameters of its own if nothing is `kept`.
///
/// # Errors
/// As [`RemeshWork::new`].
pub(super) fn cutting(work: &TrimWork, trim: usize, kept: Option<Arc<Remeshed>>) -> Result<RemeshWork, RemeshError> {
    let (cuts, images) = work.cuts();
    let other = OtherSide { set: trim as u32, kept };
    let (surface, turned) = (Arc::clone(&work.ground().surface), other.turned(&cuts));
    let cutting = RemeshWork::new(surface, turned, images, work.remesh_options())?;
    let beyond = work.zone().map_or_else(Beyond::default, |zone| zone.beyond.clone());
    Ok(cutting.within(beyond).on_other_side(other).as_fine_as(work.asked().to_vec()))
}

impl OtherWork {
    /// Begins to work the curves of one trim into the cage, turned.
    ///
    /// # Errors
    /// As [`RemeshWork::new`].
    pub(super) fn new(work: &TrimWork, trim: usize, kept: Arc<Remeshed>) -> Result<Self, TrimFault> {
        let cutting = cutting(work, trim, Some(kept)).map_err(|why| work.named(why))?;
        Ok(Self { trim, stage: Stage::Remesh(Box::new(cutting)) })
    }

    /// One quantum more.
    ///
    /// # Errors
    /// As the stages of what stays.
    pub(super) fn advance(&mut self, work: &TrimWork) -> Result<TrimQuantum, TrimFault> {
        let (stage, step) = match core::mem::replace(&mut self.stage, Stage::Failed) {
            Stage::Remesh(mut cutting) => match cutting.advance().map_err(|why| work.named(why))? {
                RemeshQuantum::More => (Stage::Remesh(cutting), TrimQuantum::More),
                RemeshQuantum::Laid => (Stage::Relax(cutting), TrimQuantum::More),
            },
            Stage::Relax(mut cutting) => match cutting.relax().map_err(|why| work.named(why))? {
                RelaxQuantum::More => (Stage::Relax(cutting), TrimQuantum::More),
                RelaxQuantum::Again => (Stage::Remesh(cutting), TrimQuantum::More),
                RelaxQuantum::Finished(remeshed) if !work.keeps_to_its_zone(&remeshed) => {
                    return Ok(TrimQuantum::Widen);
                }
                RelaxQuantum::Finished(remeshed) => {
                    let fit = Box::new(work.fit_of(&remeshed)?);
                    (Stage::Fit(Made { remeshed: Arc::new(*remeshed), fit }), TrimQuantum::More)
                }
            },
            Stage::Fit(mut made) => match made.fit.advance()? {
                Quantum::Finished => {
                    let audit = made.audit(work)?;
                    (Stage::Audit(made, Box::new(audit)), TrimQuantum::More)
                }
                Quantum::More | Quantum::Next(_) => (Stage::Fit(made), TrimQuantum::More),
            },
            Stage::Audit(made, mut audit) => match audit.advance()? {
                TrimQuantum::Finished => (Stage::Done(made, audit), TrimQuantum::Finished),
                step => (Stage::Audit(made, audit), step),
            },
            stage @ (Stage::Done(..) | Stage::Failed) => (stage, TrimQuantum::Finished),
        };
        self.stage = stage;
        Ok(step)
    }

    /// The cage, once it is made.
    pub fn remeshed(&self) -> Option<&Arc<Remeshed>> {
        match &self.stage {
            Stage::Fit(made) | Stage::Audit(made, _) | Stage::Done(made, _) => Some(&made.remeshed),
            Stage::Remesh(_) | Stage::Relax(_) | Stage::Failed => None,
        }
    }

    fn done(&self) -> Option<(&Made, &TrimAuditWork)> {
        match &self.stage {
            Stage::Done(made, audit) => Some((made, audit)),
            _ => None,
        }
    }

    /// Is it made?
    pub(super) fn is_done(&self) -> bool {
        self.done().is_some()
    }

    /// The surface, once it is made.
    pub fn surface(&self) -> Option<&Arc<LoopSurface>> {
        self.done().map(|(_, audit)| audit.surface())
    }

    /// How it went, once it is made.
    pub(super) fn report(&self, work: &TrimWork) -> Option<OtherReport> {
        let (Made { remeshed, fit }, audit) = self.done()?;
        Some(OtherReport {
            initial: fit.initial().copied(),
            ladder: fit.ladder().to_vec(),
            outcome: fit.outcome()?,
            details: fit.details().count(),
            cage: work.cage(remeshed),
            audit: *audit.found(),
        })
    }
}

impl Made {
    /// Begins the audit of the fit, which is done.
    fn audit(&self, work: &TrimWork) -> Result<TrimAuditWork, TrimFault> {
        // A finished fit always says how.
        let outcome = self.fit.outcome().unwrap_or(Outcome::Within);
        if outcome != Outcome::Within {
            return Err(TrimFault::NotReached { outcome });
        }
        let surface = LoopSurface { details: self.fit.details().clone(), ..self.remeshed.surface.clone() };
        work.audit_of(Arc::clone(&self.remeshed), Arc::new(surface))
    }
}
