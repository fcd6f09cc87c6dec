//! Which surfaces have something new, found without reading a row of those that have not.

use bevy_ecs::entity::{Entity, EntityHashMap};

use super::rows::{News, Rows, Table, runs};

/// How many rows there were at the last gathering, in all and for each owner.
///
/// A row can leave in many ways (despawned, a component removed, given to another) and leaves no
/// trace in its table. But whatever comes in is new there, so a set of rows with nothing new in it
/// and as many rows as before is the same set.
#[derive(Debug, Default)]
pub struct Ledger {
    rows: usize,
    per_owner: EntityHashMap<usize>,
}

/// Where each surface stands in the arrays that run over surfaces.
#[derive(Debug, Default)]
pub struct Slots {
    of: EntityHashMap<usize>,
}

impl Slots {
    /// Slots in the order of `surfaces`.
    pub fn new(surfaces: impl IntoIterator<Item = Entity>) -> Self {
        Self { of: surfaces.into_iter().enumerate().map(|(slot, surface)| (surface, slot)).collect() }
    }

    /// The slot of a surface; `None` for what is no surface.
    pub fn of(&self, surface: Entity) -> Option<usize> {
        self.of.get(&surface).copied()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.of.len()
    }
}

/// For each slot, the most that is new about any of its rows. Brings `ledger` up to date.
pub fn survey<R: Rows>(tables: &[Table<R>], slots: &Slots, ledger: &mut Ledger) -> Vec<News> {
    let mut marks = vec![News::None; slots.count()];
    let mut moved = tables.iter().map(|t| t.rows.count()).sum::<usize>() != ledger.rows;
    for (table, (stretch, news)) in tables.iter().flat_map(|t| t.news.iter().map(move |news| (t, news))) {
        moved |= *news == News::Structure;
        for (owner, _) in runs(table.rows, stretch.clone()) {
            if let Some(slot) = slots.of(owner) {
                marks[slot] = marks[slot].max(*news);
            }
        }
    }
    if moved {
        let counted = count(tables);
        for (&owner, &slot) in &slots.of {
            if counted.per_owner.get(&owner) != ledger.per_owner.get(&owner) {
                marks[slot] = News::Structure;
            }
        }
        *ledger = counted;
    }
    marks
}

fn count<R: Rows>(tables: &[Table<R>]) -> Ledger {
    let mut ledger = Ledger::default();
    for table in tables {
        ledger.rows += table.rows.count();
        for (owner, run) in runs(table.rows, 0..table.rows.count()) {
            *ledger.per_owner.entry(owner).or_default() += run.len();
        }
    }
    ledger
}
