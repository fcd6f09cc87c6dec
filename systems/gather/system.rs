//! The system that gathers.

use core::ops::Range;
use std::sync::Arc;

use bevy_ecs::change_detection::{ContiguousComponentTicksRef, ContiguousRef, Tick};
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use glam::DVec3;
use selvedge_components::budget::Budgets;
use selvedge_components::error::{SurfaceFailed, SurfaceFault};
use selvedge_components::identity::{Serial, Serials};
use selvedge_components::subdivision::{
    Address, Cage, ControlPointIndex, ControlPointOf, ControlPoints, Detail, DetailLevel, DetailOf, Details, FaceCode,
    LoopSurface, Position, Sides, Snapshot,
};

use super::{
    DetailBuild, DetailRows, Ledger, News, PointBuild, PointRows, Rows, Slots, Table, patch_details, patch_points,
    runs, same_details, same_places, same_points, scatter_details, scatter_points, stretches, survey,
};
use crate::diagnostics::{Counters, GroundDiagnostics};

/// What the gather stage remembers from one pass to the next.
#[derive(Debug, Default)]
pub struct Memory {
    points: Ledger,
    details: Ledger,
    /// Of surfaces along curves that were gathered last, or could not be: the revisions of the curves.
    curves: EntityHashMap<Vec<Option<u64>>>,
}

/// A surface, also one that the host has disabled: its edits must not be missed.
type Surface = (
    Entity,
    Option<&'static Serial>,
    Ref<'static, Cage>,
    Ref<'static, Sides>,
    Ref<'static, ControlPoints>,
    Option<&'static mut Snapshot>,
    Option<&'static SurfaceFailed>,
    Has<Disabled>,
);
type Point =
    (Entity, Ref<'static, Position>, Ref<'static, ControlPointOf>, Ref<'static, ControlPointIndex>, Has<Disabled>);
type Coefficient =
    (Ref<'static, Detail>, Ref<'static, DetailLevel>, Ref<'static, Address>, Ref<'static, DetailOf>, Has<Disabled>);

/// Brings the snapshot of every surface up to date with its entities.
pub fn gather_surfaces(
    mut commands: Commands,
    mut surfaces: Query<Surface>,
    (points, details): (Query<Point>, Query<Coefficient>),
    mut memory: Local<Memory>,
    mut serials: If<ResMut<Serials>>,
    budgets: Option<Res<Budgets>>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    // Other budgets may let through what they had stopped.
    let retry = budgets.is_some_and(|budgets| budgets.is_changed());
    let mut sources: Vec<_> = surfaces.iter_mut().map(Source::new).collect();
    sources.sort_unstable_by_key(|s| (s.serial, s.entity));
    let slots = Slots::new(sources.iter().map(|s| s.entity));
    let (points, details) = (point_tables(&points), detail_tables(&details));
    for untouched in points.iter().map(|t| t.news.is_empty()).chain(details.iter().map(|t| t.news.is_empty())) {
        run.counted.tables += u64::from(!untouched);
        run.counted.skipped += u64::from(untouched);
    }

    let point_news = survey(&points, &slots, &mut memory.points);
    let detail_news = survey(&details, &slots, &mut memory.details);
    for (slot, source) in sources.iter_mut().enumerate() {
        let retry = retry || source.is_mended(&memory.curves);
        source.plan(point_news[slot], detail_news[slot], retry);
    }
    run.counted.items += patch(&mut sources, &slots, &points, &details);
    let (built_points, built_details, rows) = rebuild(&sources, &slots, &points, &details);
    run.counted.items += rows;
    memory.curves.clear();
    for ((source, points), details) in sources.into_iter().zip(built_points).zip(built_details) {
        let (entity, had_none) = (source.entity, source.snapshot.is_none());
        let curves = source.sides.revisions();
        let written = source.write(points, details, &mut commands, &mut serials.0);
        run.counted.written += u64::from(written);
        // The check, which comes next, may take the snapshot away.
        if (written || had_none) && curves.iter().any(Option::is_some) {
            memory.curves.insert(entity, curves);
        }
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.gather += run.finish();
    }
}

/// One surface, and what is to be done about it.
struct Source<'w> {
    entity: Entity,
    serial: Option<Serial>,
    cage: Ref<'w, Cage>,
    sides: Ref<'w, Sides>,
    listed: Ref<'w, ControlPoints>,
    snapshot: Option<Mut<'w, Snapshot>>,
    failed: Option<&'w SurfaceFailed>,
    points: News,
    details: News,
    patched: usize,
}

type Built<T> = Option<Result<T, Vec<SurfaceFault>>>;

impl<'w> Source<'w> {
    fn new(item: <Surface as bevy_ecs::query::QueryData>::Item<'w, '_>) -> Self {
        let (entity, serial, cage, sides, listed, snapshot, failed, _) = item;
        let (serial, points, details) = (serial.copied(), News::None, News::None);
        Self { entity, serial, cage, sides, listed, snapshot, failed, points, details, patched: 0 }
    }

    /// Has a curve along a surface that failed become another one since it was looked at?
    fn is_mended(&self, before: &EntityHashMap<Vec<Option<u64>>>) -> bool {
        self.snapshot.is_none() && before.get(&self.entity).is_some_and(|before| *before != self.sides.revisions())
    }

    /// Decides what has to be gathered: nothing, values that have changed, or all.
    fn plan(&mut self, points: News, details: News, retry: bool) {
        (self.points, self.details) = (points, details);
        let shell = retry || self.cage.is_changed() || self.sides.is_changed() || self.listed.is_changed();
        match &self.snapshot {
            Some(snapshot) => {
                let remeshed = self.cage.is_changed() && !same_mesh(&self.cage, &snapshot.surface);
                if remeshed || self.listed.is_changed() {
                    self.points = News::Structure;
                }
                if remeshed {
                    self.details = News::Structure;
                }
            }
            // A surface that failed is tried again once anything about it was touched.
            None if self.failed.is_none() || shell || points != News::None || details != News::None => {
                (self.points, self.details) = (News::Structure, News::Structure);
            }
            None => {}
        }
    }

    /// Writes what was gathered. Returns whether there was anything to write.
    fn write(
        mut self,
        points: Built<Vec<DVec3>>,
        details: Built<Details>,
        commands: &mut Commands,
        serials: &mut Serials,
    ) -> bool {
        let mut faults = Vec::new();
        let (listed, vertices) = (self.listed.0.len(), self.cage.mesh.vertex_count());
        if points.is_some() && listed != vertices {
            faults.push(SurfaceFault::PointCount { listed, vertices });
        }
        let points = keep_faults(points, &mut faults);
        let details = keep_faults(details, &mut faults);
        if !faults.is_empty() {
            return self.fail(faults, commands);
        }
        if self.snapshot.is_some() {
            return self.update(points, details, serials);
        }
        let (Some(points), Some(details)) = (points, details) else { return false };
        let surface = Arc::new(self.surface(points, details));
        let (revision, curves) = (serials.next_number(), self.sides.revisions());
        commands.entity(self.entity).try_insert(Snapshot { surface, revision, structure: revision, curves });
        true
    }

    fn surface(&self, points: Vec<DVec3>, details: Details) -> LoopSurface {
        let Sides { sides, corner_rule } = Sides::clone(&self.sides);
        LoopSurface { mesh: Arc::clone(&self.cage.mesh), points, sides, corner_rule, details }
    }

    fn fail(self, faults: Vec<SurfaceFault>, commands: &mut Commands) -> bool {
        let failed = SurfaceFailed(faults);
        let news = self.snapshot.is_some() || self.failed != Some(&failed);
        if news {
            commands.entity(self.entity).try_remove::<Snapshot>().try_insert(failed);
        }
        news
    }

    /// Puts what is really different into the snapshot.
    fn update(&mut self, points: Option<Vec<DVec3>>, details: Option<Details>, serials: &mut Serials) -> bool {
        let Some(snapshot) = &mut self.snapshot else { return false };
        let held = &mut snapshot.bypass_change_detection().surface;
        let (mut changed, mut structure) = (self.patched > 0, false);
        if self.cage.is_changed() && !same_mesh(&self.cage, held) {
            Arc::make_mut(held).mesh = Arc::clone(&self.cage.mesh);
            structure = true;
        }
        if self.sides.is_changed() && !self.sides.same_as(held) {
            let Sides { sides, corner_rule } = Sides::clone(&self.sides);
            let surface = Arc::make_mut(held);
            (surface.sides, surface.corner_rule) = (sides, corner_rule);
            structure = true;
        }
        if let Some(points) = points.filter(|points| !same_points(points, held)) {
            Arc::make_mut(held).points = points;
            changed = true;
        }
        if let Some(details) = details.filter(|details| !same_details(details, held)) {
            structure |= !same_places(&details, held);
            Arc::make_mut(held).details = details;
            changed = true;
        }
        let curves = self.sides.revisions();
        structure |= curves != snapshot.curves;
        if structure || changed {
            snapshot.revision = serials.next_number();
            snapshot.curves = curves;
        }
        if structure {
            snapshot.structure = snapshot.revision;
        }
        structure || changed
    }
}

fn same_mesh(cage: &Cage, surface: &LoopSurface) -> bool {
    Arc::ptr_eq(&cage.mesh, &surface.mesh) || cage.mesh == surface.mesh
}

fn keep_faults<T>(built: Built<T>, faults: &mut Vec<SurfaceFault>) -> Option<T> {
    match built? {
        Ok(made) => Some(made),
        Err(mut found) => {
            faults.append(&mut found);
            None
        }
    }
}

/// Writes single values into snapshots. Returns how many rows were gone through.
fn patch(
    sources: &mut [Source<'_>],
    slots: &Slots,
    points: &[Table<PointRows<'_>>],
    details: &[Table<DetailRows<'_>>],
) -> u64 {
    let mut count = 0;
    for_each_run_with_news(points, |owner, rows, run| {
        let Some(source) = slots.of(owner).map(|slot| &mut sources[slot]) else { return };
        let Some(snapshot) = source.snapshot.as_mut().filter(|_| source.points == News::Value) else { return };
        count += run.len() as u64;
        source.patched += patch_points(rows, run, &mut snapshot.bypass_change_detection().surface);
    });
    for_each_run_with_news(details, |owner, rows, run| {
        let Some(source) = slots.of(owner).map(|slot| &mut sources[slot]) else { return };
        let Some(snapshot) = source.snapshot.as_mut().filter(|_| source.details == News::Value) else { return };
        count += run.len() as u64;
        source.patched += patch_details(rows, run, &mut snapshot.bypass_change_detection().surface);
    });
    count
}

/// Calls `work` with every stretch of rows of one owner that has news.
fn for_each_run_with_news<R: Rows>(tables: &[Table<R>], mut work: impl FnMut(Entity, R, Range<usize>)) {
    for table in tables {
        for (owner, run) in table.news.iter().flat_map(|(stretch, _)| runs(table.rows, stretch.clone())) {
            work(owner, table.rows, run);
        }
    }
}

type Rebuilt = (Vec<Built<Vec<DVec3>>>, Vec<Built<Details>>, u64);

/// Gathers whole arrays anew for the surfaces that need it.
fn rebuild(
    sources: &[Source<'_>],
    slots: &Slots,
    points: &[Table<PointRows<'_>>],
    details: &[Table<DetailRows<'_>>],
) -> Rebuilt {
    let mut point_builds: Vec<_> =
        sources.iter().map(|s| (s.points == News::Structure).then(|| PointBuild::new(&s.listed.0))).collect();
    let mut rows = 0;
    if point_builds.iter().any(Option::is_some) {
        rows += scatter_points(points, slots, &mut point_builds);
    }
    let mut detail_builds: Vec<_> =
        sources.iter().map(|s| (s.details == News::Structure).then(DetailBuild::default)).collect();
    if detail_builds.iter().any(Option::is_some) {
        rows += scatter_details(details, slots, &mut detail_builds);
    }
    let finest = |s: &Source<'_>| FaceCode::finest(s.cage.mesh.face_count());
    (
        point_builds.into_iter().map(|build| build.map(PointBuild::finish)).collect(),
        detail_builds.into_iter().zip(sources).map(|(build, s)| build.map(|b| b.finish(finest(s)))).collect(),
        rows as u64,
    )
}

fn point_tables<'q>(points: &'q Query<Point>) -> Vec<Table<PointRows<'q>>> {
    let tables = points.contiguous_iter().expect("every component asked for is stored in tables");
    tables
        .map(|(entities, positions, owners, indices, _)| {
            let (positions, values) = ContiguousRef::split(positions);
            let (owners, owner_ticks) = ContiguousRef::split(owners);
            let (indices, index_ticks) = ContiguousRef::split(indices);
            let rows = PointRows { entities, owners, indices, positions };
            Table { rows, news: news(rows.count(), &values, &[owner_ticks, index_ticks]) }
        })
        .collect()
}

fn detail_tables<'q>(details: &'q Query<Coefficient>) -> Vec<Table<DetailRows<'q>>> {
    let tables = details.contiguous_iter().expect("every component asked for is stored in tables");
    tables
        .map(|(values, levels, addresses, owners, _)| {
            let (values, value_ticks) = ContiguousRef::split(values);
            let (levels, level_ticks) = ContiguousRef::split(levels);
            let (addresses, address_ticks) = ContiguousRef::split(addresses);
            let (owners, owner_ticks) = ContiguousRef::split(owners);
            let rows = DetailRows { owners, levels, addresses, values };
            Table { rows, news: news(rows.count(), &value_ticks, &[level_ticks, address_ticks, owner_ticks]) }
        })
        .collect()
}

/// What the ticks say about `rows` rows.
fn news(
    rows: usize,
    value: &ContiguousComponentTicksRef<'_>,
    structure: &[ContiguousComponentTicksRef<'_>],
) -> Vec<(Range<usize>, News)> {
    let may_have = |ticks: &&ContiguousComponentTicksRef<'_>| ticks.summary_tick_is_changed() != Some(false);
    let (value, structure) = (Some(value).filter(may_have), structure.iter().filter(may_have).collect::<Vec<_>>());
    if value.is_none() && structure.is_empty() {
        return Vec::new();
    }
    let since =
        |ticks: &ContiguousComponentTicksRef<'_>, tick: Tick| tick.is_newer_than(ticks.last_run(), ticks.this_run());
    // A row that came in has the tick of its arrival as that of its last change too, or a later one.
    let changed = |ticks: &ContiguousComponentTicksRef<'_>, range: Range<usize>| {
        ticks.changed()[range].iter().fold(false, |any, &tick| any | since(ticks, tick))
    };
    let touched = |range: Range<usize>| {
        value.is_some_and(|v| changed(v, range.clone())) || structure.iter().any(|s| changed(s, range.clone()))
    };
    stretches(rows, touched, |row| {
        let structure = structure.iter().any(|ticks| since(ticks, ticks.changed()[row]));
        match value.filter(|ticks| since(ticks, ticks.changed()[row])) {
            _ if structure => News::Structure,
            Some(ticks) if since(ticks, ticks.added()[row]) => News::Structure,
            Some(_) => News::Value,
            None => News::None,
        }
    })
}
