//! Rows of tables, as slices, and what is new about them.

use core::ops::Range;

use bevy_ecs::entity::Entity;
use selvedge_components::subdivision::{
    Address, ControlPointIndex, ControlPointOf, Detail, DetailLevel, DetailOf, Position,
};

/// What has happened to a row since the last gathering.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum News {
    /// Nothing.
    None,
    /// Its value was touched; it may be the same as before.
    Value,
    /// It is new, or has another owner or place.
    Structure,
}

/// Rows of one table that belong to surfaces.
pub trait Rows: Copy {
    /// How many there are.
    fn len(&self) -> usize;
    /// Whom a row belongs to.
    fn owner(&self, row: usize) -> Entity;
}

/// Control points of one table; all slices are equally long.
#[derive(Clone, Copy, Debug)]
pub struct PointRows<'a> {
    /// Who they are.
    pub entities: &'a [Entity],
    /// Whom they belong to.
    pub owners: &'a [ControlPointOf],
    /// Which they are.
    pub indices: &'a [ControlPointIndex],
    /// Where they are.
    pub positions: &'a [Position],
}

impl Rows for PointRows<'_> {
    fn len(&self) -> usize {
        self.entities.len()
    }

    fn owner(&self, row: usize) -> Entity {
        self.owners[row].0
    }
}

/// Detail coefficients of one table; all slices are equally long.
#[derive(Clone, Copy, Debug)]
pub struct DetailRows<'a> {
    /// Whom they belong to.
    pub owners: &'a [DetailOf],
    /// The levels that they act at.
    pub levels: &'a [DetailLevel],
    /// Where on their level.
    pub addresses: &'a [Address],
    /// The coefficients.
    pub values: &'a [Detail],
}

impl Rows for DetailRows<'_> {
    fn len(&self) -> usize {
        self.owners.len()
    }

    fn owner(&self, row: usize) -> Entity {
        self.owners[row].0
    }
}

/// Detail coefficients of one table, as far as they tell whom they belong to.
#[derive(Clone, Copy, Debug)]
pub struct OwnerRows<'a>(pub &'a [DetailOf]);

impl Rows for OwnerRows<'_> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn owner(&self, row: usize) -> Entity {
        self.0[row].0
    }
}

/// One table: its rows, and what is new about each; `None` where nothing is about any.
#[derive(Clone, Debug)]
pub struct Table<R> {
    /// The rows.
    pub rows: R,
    /// One entry per row.
    pub news: Option<Vec<News>>,
}

/// The rows as stretches of one owner: tables are mostly filled surface by surface, so owners are
/// looked up once a stretch.
pub fn runs<R: Rows>(rows: R) -> impl Iterator<Item = (Entity, Range<usize>)> {
    let mut start = 0;
    core::iter::from_fn(move || {
        if start == rows.len() {
            return None;
        }
        let owner = rows.owner(start);
        let end = (start + 1..rows.len()).find(|&row| rows.owner(row) != owner).unwrap_or(rows.len());
        let run = (owner, start..end);
        start = end;
        Some(run)
    })
}
