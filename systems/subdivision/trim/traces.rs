//! What the engine adds to trims, and takes away again.

use selvedge_components::job::{AtCorrespond, AtModify, AtRefine, FitJob};
use selvedge_components::trim::{AtAudit, AtLocate, AtRelax, AtRemesh, TrimFailed, TrimJob, TrimReport};

use super::compose::Solved;
use super::{LocateWork, TrimWork};
use crate::subdivision::fit::FitWork;

/// What the engine adds to the first of some trims from remeshing on.
pub type WorkTraces = (TrimWork, Solved, FitJob, FitWork, AtRemesh, AtRelax, AtAudit, AtCorrespond, AtModify, AtRefine);
/// All that the engine adds to a trim but for its report, which stays until there is another.
pub type Traces = (TrimJob, LocateWork, AtLocate, TrimFailed, WorkTraces);

/// What a trim that has failed does not keep.
pub type FailedTraces = (LocateWork, AtLocate, TrimReport);
