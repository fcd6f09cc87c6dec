//! Trims that are made together: when they part, and when they begin.

mod system;

pub(super) use system::{begin_groups, mark_others, mark_stale, part};
