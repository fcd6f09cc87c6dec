//! # Admit and advance: jobs begin, move on and end
//!
//! | system | reads | writes | after | before |
//! | --- | --- | --- | --- | --- |
//! | admit | `Fit`, `FitTarget`, `FitOptions`, `Tolerance`, `Budgets`, `Cancelled`; `Snapshot`, `SurfaceFailed` | `FitJob`, `FitWork` and the marker of the first stage; or `FitFailed` | `Check` | the stages |
//! | advance | `FitJob`, `FitWork` | markers; at the end the details of the surface and `FitReport`, or `FitFailed` | the stages | - |
//!
//! Why: the stages only set what they have to say, [`FitJob::step`]; all markers move together at
//! the end of the pass. So one pass is one step at most for every job, whatever the order of the stages, and
//! jobs at different stages move in the same pass.
//!
//! Until a fit has finished, its details belong to the job, and the surface is as it was. Whatever
//! ends it otherwise (an error, a budget, [`Cancelled`], an edit, the job or the surface being
//! despawned by the host) takes them away again.
//!
//! [`FitJob::step`]: selvedge_components::job::FitJob::step
//! [`Cancelled`]: selvedge_components::job::Cancelled

mod admit;
mod advance;
mod commit;
mod system;

pub use admit::{Order, SurfaceNow, Verdict, Wish, first_on_each_surface, verdict};
pub use advance::{Move, next_move};
pub use commit::{Commit, Place, commit};
pub(in crate::subdivision) use system::{Coefficient, deliver, discard, mark};
pub use system::{Running, admit_fits, advance_fits};
