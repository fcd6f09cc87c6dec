//! Which trims begin, begin again, go on together, or are refused.

mod system;
mod together;

use bevy_ecs::entity::Entity;
use selvedge_components::trim::{TrimFault, TrimInputs, TrimJob, TrimState};

pub use system::{Known, Reads, admit_trims};

/// A trim that is to be made, and where it stands.
#[derive(Clone, Debug)]
pub struct Candidate<'a> {
    /// The trim.
    pub trim: Entity,
    /// What it would read if it began now.
    pub now: TrimInputs,
    /// Why it cannot begin, if it cannot.
    pub refusal: Option<TrimFault>,
    /// Is one of its curves not checked yet?
    pub unchecked: bool,
    /// Where it stands, if it was ever begun and has all that it needs to go on.
    pub job: Option<&'a TrimJob>,
}

/// What is to be done about a trim before the stages run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing: it goes on, or is over.
    Keep,
    /// Its source was not gathered yet.
    Wait,
    /// Its curves are to be located.
    Locate,
    /// It cannot be made.
    Refuse,
}

/// Is the source of a trim gathered, or refused for good?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Yes.
    Known,
    /// Not yet.
    Ungathered,
}

/// Has anything about the trims of one source changed: one of them, its inputs, or which they are?
pub fn anything_changed(candidates: &[Candidate<'_>], before: &[Entity]) -> bool {
    let now = candidates.iter().map(|c| c.trim);
    now.ne(before.iter().copied()) || candidates.iter().any(|c| c.job.is_none_or(|job| job.inputs != c.now))
}

/// Decides about one trim of a source about which something has `changed`, or not.
///
/// A trim that failed is tried again whenever anything about the trims of its source has changed:
/// what was in its way may be gone.
pub fn verdict(candidate: &Candidate<'_>, source: Source, changed: bool) -> Verdict {
    let same = candidate.job.filter(|job| job.inputs == candidate.now);
    if candidate.refusal.is_some() {
        let refused = same.is_some_and(|job| job.state == TrimState::Failed);
        return if refused { Verdict::Keep } else { Verdict::Refuse };
    }
    match same {
        Some(job) if job.state != TrimState::Failed || !changed => Verdict::Keep,
        _ if source == Source::Ungathered => Verdict::Wait,
        _ => Verdict::Locate,
    }
}
