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
    fn count(&self) -> usize;
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
    fn count(&self) -> usize {
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
    fn count(&self) -> usize {
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
    fn count(&self) -> usize {
        self.0.len()
    }

    fn owner(&self, row: usize) -> Entity {
        self.0[row].0
    }
}

/// One table: its rows, and what is new about them.
#[derive(Clone, Debug)]
pub struct Table<R> {
    /// The rows.
    pub rows: R,
    /// Stretches of rows that have news of one kind, ascending; rows in none of them have none.
    pub news: Vec<(Range<usize>, News)>,
}

/// `range` of the rows as stretches of one owner: tables are mostly filled surface by surface, so
/// owners are looked up once a stretch.
pub fn runs<R: Rows>(rows: R, range: Range<usize>) -> impl Iterator<Item = (Entity, Range<usize>)> {
    let Range { mut start, end: stop } = range;
    core::iter::from_fn(move || {
        if start >= stop {
            return None;
        }
        let owner = rows.owner(start);
        let end = (start + 1..stop).find(|&row| rows.owner(row) != owner).unwrap_or(stop);
        let run = (owner, start..end);
        start = end;
        Some(run)
    })
}

/// The stretches of rows for which `news` has some. `touched` tells of a range of rows whether any
/// may have news; it is asked for many rows at once, and most have none.
pub fn stretches(
    rows: usize,
    touched: impl Fn(Range<usize>) -> bool,
    news: impl Fn(usize) -> News,
) -> Vec<(Range<usize>, News)> {
    /// Ticks of this many rows are a few cache lines, and are compared some at a time.
    const BLOCK: usize = 256;
    let mut found: Vec<(Range<usize>, News)> = Vec::new();
    for block in (0..rows).step_by(BLOCK).map(|start| start..rows.min(start + BLOCK)) {
        if !touched(block.clone()) {
            continue;
        }
        for row in block {
            match (news(row), found.last_mut()) {
                (News::None, _) => {}
                (new, Some((stretch, kind))) if stretch.end == row && *kind == new => stretch.end += 1,
                (new, _) => found.push((row..row + 1, new)),
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_are_all_rows_with_news_in_order_and_as_long_as_can_be() {
        let kinds = [News::None, News::Value, News::Structure];
        for seed in 0..50_usize {
            // Long and short stretches of all kinds, over a few blocks.
            let rows = 3 + 97 * seed;
            let of = |row: usize| kinds[(row / (1 + 37 * (seed % 11)) + row * (seed % 3) / 5) % 3];
            let found = stretches(rows, |range| range.into_iter().any(|row| of(row) != News::None), of);
            let mut spread = vec![News::None; rows];
            for (stretch, kind) in &found {
                assert!(!stretch.is_empty() && *kind != News::None);
                spread[stretch.clone()].fill(*kind);
            }
            assert_eq!(spread, (0..rows).map(of).collect::<Vec<_>>());
            let touching = found.windows(2).filter(|w| w[0].0.end == w[1].0.start && w[0].1 == w[1].1);
            assert_eq!(touching.count(), 0);
        }
    }
}
