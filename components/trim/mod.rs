//! Trims: what is asked for, where it stands, and what came of it.
//!
//! A trim is an entity. What is left of a source after all of its trims is one more entity, its
//! [result](ResultOf), derived and read-only; the source itself is never changed.
//!
//! ```text
//! Trim -> AtLocate -> AtRemesh -> AtRelax -> AtRefine -> AtCorrespond -> AtModify -+-> AtAudit -> TrimReport
//!            |           |  ^         |          ^                                 |       |
//!            |           |  +-finer---+          +---- next level, next round -----+       |
//!            +-----------+------------+-----------------------+-----------------------+--> TrimFailed
//! ```

mod asked;
mod fault;
mod job;
mod report;

pub use asked::{
    BorderLine, Junction, Omega, OtherSide, OtherSideOf, PreImagePoint, PreImages, ResultOf, Sides, Stale, Trim,
    TrimCurve, TrimOptions, TrimmedTo,
};
pub use fault::{TrimAuditFault, TrimFailed, TrimFault};
pub use job::{AtAudit, AtLocate, AtRelax, AtRemesh, CutInput, TrimInputs, TrimJob, TrimQuantum, TrimStage, TrimState};
pub use report::{OtherReport, Relaxed, TrimAudit, TrimReport, TrimmedCage};
