//! Dense arrays from rows: whole, or only the values that have changed.

use core::ops::Range;
use std::sync::Arc;

use bevy_ecs::entity::Entity;
use glam::DVec3;
use selvedge_components::error::SurfaceFault;
use selvedge_components::subdivision::{Address, Details, LoopSurface};

use super::rows::{DetailRows, PointRows, Rows, Table, runs};
use super::survey::Slots;

/// The same number, digit for digit? Zeros of different sign are not, and a NaN is itself.
pub fn same_bits(a: DVec3, b: DVec3) -> bool {
    a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits)
}

/// The control points of one surface, being put in order.
#[derive(Debug)]
pub struct PointBuild<'a> {
    listed: &'a [Entity],
    points: Vec<DVec3>,
    found: Vec<bool>,
    unlisted: Vec<(u32, Entity)>,
}

impl<'a> PointBuild<'a> {
    /// Nothing yet of the control points `listed`, in index order.
    pub fn new(listed: &'a [Entity]) -> Self {
        let n = listed.len();
        Self { listed, points: vec![DVec3::ZERO; n], found: vec![false; n], unlisted: Vec::new() }
    }

    fn put(&mut self, entity: Entity, index: u32, at: DVec3) {
        let i = index as usize;
        if self.listed.get(i) == Some(&entity) {
            self.points[i] = at;
            self.found[i] = true;
        } else {
            self.unlisted.push((index, entity));
        }
    }

    /// The control points in index order.
    ///
    /// # Errors
    /// Every entity that says it is one and is not listed as such, and every one that is missing.
    pub fn finish(mut self) -> Result<Vec<DVec3>, Vec<SurfaceFault>> {
        let missing = self.found.iter().zip(self.listed).enumerate().filter(|(_, (found, _))| !**found);
        let missing = missing.map(|(i, (_, &listed))| SurfaceFault::PointMissing { index: i as u32, listed });
        let mut faults: Vec<_> = missing.collect();
        self.unlisted.sort_unstable();
        let unlisted = self.unlisted.into_iter();
        faults.extend(unlisted.map(|(index, entity)| SurfaceFault::PointUnlisted { entity, index }));
        if faults.is_empty() { Ok(self.points) } else { Err(faults) }
    }
}

/// Puts every row of the tables where its surface has a build. Returns how many rows were put.
pub fn scatter_points(tables: &[Table<PointRows<'_>>], slots: &Slots, builds: &mut [Option<PointBuild<'_>>]) -> usize {
    let mut rows = 0;
    for table in tables {
        for (owner, run) in runs(table.rows, 0..table.rows.count()) {
            let Some(build) = slots.of(owner).and_then(|slot| builds[slot].as_mut()) else { continue };
            rows += run.len();
            for row in run {
                let PointRows { entities, indices, positions, .. } = table.rows;
                build.put(entities[row], indices[row].0, positions[row].0);
            }
        }
    }
    rows
}

/// The detail coefficients of one surface, in no order yet.
#[derive(Debug, Default)]
pub struct DetailBuild {
    found: Vec<(u32, Address, DVec3)>,
}

impl DetailBuild {
    /// The details by level and address, where no level is finer than `finest`.
    ///
    /// # Errors
    /// Every detail of a finer level, and every place that has two.
    pub fn finish(mut self, finest: u32) -> Result<Details, Vec<SurfaceFault>> {
        // The value is part of the key only so that faults come in one order.
        self.found
            .sort_unstable_by_key(|&(level, address, value)| (level, address, value.to_array().map(f64::to_bits)));
        let mut faults: Vec<_> = self
            .found
            .windows(2)
            .filter(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1))
            .map(|pair| SurfaceFault::DetailTwice { level: pair[0].0, address: pair[0].1 })
            .collect();
        let too_fine = self.found.iter().filter(|d| d.0 > finest);
        faults.extend(too_fine.map(|d| SurfaceFault::DetailTooFine { level: d.0, finest }));
        if !faults.is_empty() {
            return Err(faults);
        }
        let depth = self.found.last().map_or(0, |d| d.0 as usize + 1);
        let mut details = Details { levels: vec![Vec::new(); depth] };
        for (level, address, value) in self.found {
            details.levels[level as usize].push((address, value));
        }
        Ok(details)
    }
}

/// Hands every row of the tables to its surface's build, where it has one. Returns how many.
pub fn scatter_details(tables: &[Table<DetailRows<'_>>], slots: &Slots, builds: &mut [Option<DetailBuild>]) -> usize {
    let mut rows = 0;
    for table in tables {
        for (owner, run) in runs(table.rows, 0..table.rows.count()) {
            let Some(build) = slots.of(owner).and_then(|slot| builds[slot].as_mut()) else { continue };
            rows += run.len();
            let DetailRows { levels, addresses, values, .. } = table.rows;
            build.found.extend(run.map(|row| (levels[row].0, addresses[row], values[row].0)));
        }
    }
    rows
}

/// Writes the values of `run`, rows of one surface, into `surface`, which copies itself first if
/// somebody holds it as it was. Returns how many were really different.
pub fn patch_points(rows: PointRows<'_>, mut run: Range<usize>, surface: &mut Arc<LoopSurface>) -> usize {
    let differs = |row: usize, points: &[DVec3]| {
        let held = points.get(rows.indices[row].0 as usize);
        held.is_some_and(|&held| !same_bits(held, rows.positions[row].0))
    };
    // Nothing is copied for values that are only touched.
    let Some(first) = run.find(|&row| differs(row, &surface.points)) else { return 0 };
    let points = &mut Arc::make_mut(surface).points;
    let mut changed = 0;
    for row in first..run.end {
        if differs(row, points) {
            points[rows.indices[row].0 as usize] = rows.positions[row].0;
            changed += 1;
        }
    }
    changed
}

/// As [`patch_points`], for detail coefficients.
pub fn patch_details(rows: DetailRows<'_>, run: Range<usize>, surface: &mut Arc<LoopSurface>) -> usize {
    let mut changed = 0;
    for row in run {
        let level = rows.levels[row].0 as usize;
        let stored = surface.details.levels.get(level).map_or(&[][..], Vec::as_slice);
        let Ok(i) = stored.binary_search_by_key(&rows.addresses[row], |d| d.0) else { continue };
        if !same_bits(stored[i].1, rows.values[row].0) {
            Arc::make_mut(surface).details.levels[level][i].1 = rows.values[row].0;
            changed += 1;
        }
    }
    changed
}

/// Is `points` what `surface` has, digit for digit?
pub fn same_points(points: &[DVec3], surface: &LoopSurface) -> bool {
    points.len() == surface.points.len() && points.iter().zip(&surface.points).all(|(&a, &b)| same_bits(a, b))
}

/// Are these the details that `surface` has, digit for digit?
pub fn same_details(details: &Details, surface: &LoopSurface) -> bool {
    let same_level = |a: &Vec<(Address, DVec3)>, b: &Vec<(Address, DVec3)>| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && same_bits(a.1, b.1))
    };
    let held = &surface.details.levels;
    details.levels.len() == held.len() && details.levels.iter().zip(held).all(|(a, b)| same_level(a, b))
}

/// Do these details sit where those of `surface` do?
pub fn same_places(details: &Details, surface: &LoopSurface) -> bool {
    let same_level =
        |a: &Vec<(Address, DVec3)>, b: &Vec<(Address, DVec3)>| a.iter().map(|d| d.0).eq(b.iter().map(|d| d.0));
    let held = &surface.details.levels;
    details.levels.len() == held.len() && details.levels.iter().zip(held).all(|(a, b)| same_level(a, b))
}
