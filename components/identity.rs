//! What orders entities when order shows.

use bevy_ecs::prelude::{Component, Resource};

/// The number of an entity: given once, never given again, rising in the order of arrival.
///
/// Rows of a table are in no order (a removal swaps) and entity ids are used again, so whatever
/// needs an order (which of two jobs goes first, which of two curves is the older) asks this.
/// Written by the enroll stage for surfaces, curves and jobs that have none.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[component(immutable)]
pub struct Serial(pub u64);

/// Hands out numbers that rise and never come again in this world: [`Serial`]s, and the revisions
/// of snapshots.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct Serials {
    given: u64,
}

impl Serials {
    /// The next number; the first is 1.
    ///
    /// A `u64` counted up once a nanosecond lasts five centuries.
    pub fn next_number(&mut self) -> u64 {
        self.given += 1;
        self.given
    }
}
