//! Which trims of a source touch, and are made together.

use bevy_ecs::entity::Entity;

/// Trims that are made together, in their order; the first carries the work.
pub type Group = Vec<Entity>;

/// The groups of the trims of one source, in the order of the first of each.
pub fn groups(trims: &[Entity]) -> Vec<Group> {
    if trims.is_empty() { Vec::new() } else { vec![trims.to_vec()] }
}
