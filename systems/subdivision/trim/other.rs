//! The other side of a trim, made after what stays: the same stages, one quantum at a time.

use std::sync::Arc;

use selvedge_components::subdivision::LoopSurface;
use selvedge_components::subdivision::fit::{Outcome, Quantum};
use selvedge_components::trim::{OtherReport, TrimFault, TrimQuantum};

use super::audit::TrimAuditWork;
use super::work::TrimWork;
use crate::subdivision::fit::FitWork;
use crate::subdivision::remesh::{self, OtherSide, Remeshed};

/// What a trim removes, being made. Lives in the work of the trims that it is made with.
#[derive(Debug)]
pub struct OtherWork {
    /// The trim, by index among those made together.
    pub trim: usize,
    /// The cage.
    pub remeshed: Arc<Remeshed>,
    /// The fit of it.
    fit: Box<FitWork>,
    stage: Stage,
}

#[derive(Debug)]
enum Stage {
    Fit,
    Audit(Box<TrimAuditWork>),
    Done(Box<TrimAuditWork>),
}

impl OtherWork {
    /// Works the curves of one trim into the cage, turned, and begins the fit.
    ///
    /// # Errors
    /// As [`remesh::remesh_other`] and [`FitWork::new`].
    pub(super) fn new(work: &TrimWork, trim: usize, kept: Arc<Remeshed>) -> Result<Self, TrimFault> {
        let (cuts, images) = work.cuts();
        let other = OtherSide { set: trim as u32, kept };
        let surface = Arc::clone(&work.ground().surface);
        let remeshed = remesh::remesh_other(surface, &cuts, &images, &work.remesh_options(), other)
            .map_err(|why| work.named(why))?;
        let fit = Box::new(work.fit_of(&remeshed)?);
        Ok(Self { trim, remeshed: Arc::new(remeshed), fit, stage: Stage::Fit })
    }

    /// One quantum more of the fit, or of the audit after it.
    ///
    /// # Errors
    /// As those.
    pub(super) fn advance(&mut self, work: &TrimWork) -> Result<TrimQuantum, TrimFault> {
        match &mut self.stage {
            Stage::Fit => {
                if self.fit.advance()? == Quantum::Finished {
                    // A finished fit always says how.
                    let outcome = self.fit.outcome().unwrap_or(Outcome::Within);
                    if outcome != Outcome::Within {
                        return Err(TrimFault::NotReached { outcome });
                    }
                    let details = self.fit.details().clone();
                    let surface = LoopSurface { details, ..self.remeshed.surface.clone() };
                    let audit = work.audit_of(Arc::clone(&self.remeshed), Arc::new(surface))?;
                    self.stage = Stage::Audit(Box::new(audit));
                }
                Ok(TrimQuantum::More)
            }
            Stage::Audit(audit) => {
                let step = audit.advance()?;
                if step == TrimQuantum::Finished
                    && let Stage::Audit(audit) = core::mem::replace(&mut self.stage, Stage::Fit)
                {
                    self.stage = Stage::Done(audit);
                }
                Ok(step)
            }
            Stage::Done(_) => Ok(TrimQuantum::Finished),
        }
    }

    fn audit(&self) -> Option<&TrimAuditWork> {
        match &self.stage {
            Stage::Done(audit) => Some(audit),
            Stage::Fit | Stage::Audit(_) => None,
        }
    }

    /// Is it made?
    pub(super) fn is_done(&self) -> bool {
        self.audit().is_some()
    }

    /// The surface, once it is made.
    pub fn surface(&self) -> Option<&Arc<LoopSurface>> {
        self.audit().map(TrimAuditWork::surface)
    }

    /// How it went, once it is made.
    pub(super) fn report(&self, work: &TrimWork) -> Option<OtherReport> {
        let fit = &self.fit;
        Some(OtherReport {
            initial: fit.initial().copied(),
            ladder: fit.ladder().to_vec(),
            outcome: fit.outcome()?,
            details: fit.details().count(),
            cage: work.cage(&self.remeshed),
            audit: *self.audit()?.found(),
        })
    }
}
