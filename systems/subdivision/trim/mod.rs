//! # Trim: from directed curves to what they leave
//!
//! | system | reads | writes | after | before |
//! | --- | --- | --- | --- | --- |
//! | admit | `Trim`, `TrimOptions`, `Tolerance`, `Budgets`, `Cancelled`; `SpaceCurve`, `Snapshot` and their failures | `TrimJob`, [`TrimWork`] and the marker of the first stage; or `TrimFailed` | `Check` | the stages |
//! | locate | [`TrimWork`] | where the curves run on the source | admit | remesh |
//! | remesh | [`TrimWork`] | the source's cage, cut, with strips along the curves | locate | relax |
//! | relax | [`TrimWork`] | the new cage; the fit of it, a `FitWork` with its markers | remesh | the fit |
//! | audit | [`TrimWork`], `FitWork` | what an independent measurement finds | the fit | advance |
//! | advance | `TrimJob`, `FitJob` | markers; at the end the result of the source and `TrimReport`, or `TrimFailed` | the stages | - |
//!
//! Why: between remeshing and audit a trim is a fit like any other, of the new cage to the limit
//! surface of its source, and the stages of fits make it. [Litke et al. 2001, Section 3]
//!
//! Trims of one source that touch are made together, from the source itself: nothing is ever fitted
//! to, or measured against, the result of another trim, so however many there are nothing drifts.

mod admit;
mod advance;
mod audit;
mod compose;
mod ground;
mod group;
mod locate;
mod other;
mod rename;
mod system;
mod traces;
mod work;
mod zone;

pub use admit::{Candidate, Known, Reads, Source, Verdict, admit_trims, anything_changed, verdict};
pub use advance::advance_trims;
pub use audit::TrimAuditWork;
pub use compose::{ComposedOf, Misfit, Solved, ZoneOf, compose, compose_results};
pub use ground::{Ground, GroundBuild};
pub use group::{Group, groups, replay};
pub use locate::{LocateWork, Located, Reach};
pub use other::OtherWork;
pub use system::{audit_trims, locate_trims, relax_trims, remesh_trims};
pub use work::{Blamed, TrimWork, fit_options};
pub use zone::{Zone, ZoneSide, reserve};

#[cfg(test)]
mod tests;
