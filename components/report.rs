//! What a job says about its result.

use bevy_ecs::prelude::Component;

use crate::subdivision::fit::{Outcome, Rung};

/// How a fit went. Written when it has finished; replaced whole when it has finished again.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct FitReport {
    /// The error before any detail.
    pub initial: Option<Rung>,
    /// The error ladder, level by level.
    pub ladder: Vec<Rung>,
    /// How it ended.
    pub outcome: Outcome,
    /// Detail coefficients that the surface has now, over all levels.
    pub details: usize,
}
