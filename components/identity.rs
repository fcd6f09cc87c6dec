//! What orders entities when order shows, and what inputs are the same.

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

/// Are two numbers that a host has given the same? What is not a number is the same as itself: work that
/// was refused for it is not begun again in every pass.
pub fn same_number(a: f64, b: f64) -> bool {
    a == b || (a.is_nan() && b.is_nan())
}

/// As [`same_number`], where there may be none.
pub fn same_option(a: Option<f64>, b: Option<f64>) -> bool {
    a.zip(b).map_or(a.is_none() && b.is_none(), |(a, b)| same_number(a, b))
}
