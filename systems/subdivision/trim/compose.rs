//! # Compose: the result of a source, of what its trims have left

use std::sync::Arc;

use bevy_ecs::entity::Entity;
use bevy_ecs::prelude::Component;
use selvedge_components::subdivision::LoopSurface;

use crate::subdivision::remesh::Remeshed;

/// What trims made together have left: on the first of them, once it has finished. Derived.
#[derive(Component, Clone, Debug)]
pub struct Solved {
    /// The trims, in their order.
    pub together: Vec<Entity>,
    /// A number that no other solution of this world has.
    pub number: u64,
    /// The cage.
    pub remeshed: Arc<Remeshed>,
    /// What is left of the source, details and all.
    pub surface: Arc<LoopSurface>,
}

/// What a result was put together of: the numbers of the solutions, ascending.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub struct ComposedOf(pub Vec<u64>);

/// What is left of a source by all of `pieces`; `None` where there is none.
pub fn compose(pieces: &[&Solved]) -> Option<Arc<LoopSurface>> {
    pieces.first().map(|piece| Arc::clone(&piece.surface))
}
