//! Snapshots are what the entities say, and are made anew only where a value has changed.

mod support;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use glam::DVec3;
use selvedge::curve::{Curve, CurveFault, CurveParameters, SpaceCurve};
use selvedge::diagnostics::{Counters, GroundDiagnostics};
use selvedge::error::{CurveFailed, SurfaceFailed, SurfaceFault};
use selvedge::mesh::{Fault, VertexId};
use selvedge::subdivision::{
    Address, Border, Cage, ControlPointIndex, ControlPointOf, ControlPoints, Detail, DetailLevel, DetailOf, Details,
    Heading, LoopSurface, Position, Sides, Snapshot,
};
use selvedge::{despawn_surface, spawn_surface};
use support::world::{bits, by_hand, details_of, dump_without_resources, host, octahedron, snapshot, torus};

/// A torus with a few details on three levels.
fn source() -> LoopSurface {
    let mut surface = torus(5, 4);
    let value = |i: u32| 0.01 * DVec3::new(f64::from(i), 1.0, -0.5);
    let corner = |v: u32| (Address::Corner(VertexId(v)), value(v));
    surface.details =
        Details { levels: vec![vec![corner(3), corner(7)], vec![], vec![corner(0), corner(1), corner(9)]] };
    surface
}

fn gather(world: &World) -> Counters {
    world.resource::<GroundDiagnostics>().gather
}

#[derive(Component)]
struct Tag<const N: usize>;

fn tag<const N: usize>(world: &mut World, entities: &[Entity]) {
    for (_, &entity) in entities.iter().enumerate().filter(|(i, _)| i % 5 == N) {
        world.entity_mut(entity).insert(Tag::<N>);
    }
}

/// Spreads all control points and details over five archetypes, and leaves the rows in disorder.
fn scatter(world: &mut World) {
    let parts = world.query_filtered::<Entity, Or<(With<Position>, With<Detail>)>>().iter(world).collect::<Vec<_>>();
    tag::<3>(world, &parts);
    tag::<1>(world, &parts);
    tag::<0>(world, &parts);
    tag::<2>(world, &parts);
    for &part in parts.iter().step_by(3) {
        world.entity_mut(part).insert(Tag::<4>);
        world.entity_mut(part).remove::<Tag<4>>();
    }
}

#[test]
fn a_surface_comes_back_from_its_entities_digit_for_digit() {
    let (mut world, mut schedule) = host();
    let source = source();
    let surface = spawn_surface(&mut world, &source);
    schedule.run(&mut world);
    let back = &snapshot(&world, surface).surface;
    assert_eq!(bits(back), bits(&source));
    assert_eq!(back.details, source.details);
    assert_eq!((&back.mesh, back.corner_rule), (&source.mesh, source.corner_rule));
}

#[test]
fn five_archetypes_of_a_hosts_own_make_the_same_bits() {
    let (mut world, mut schedule) = host();
    let source = source();
    let surface = spawn_surface(&mut world, &source);
    scatter(&mut world);
    let archetypes = world.archetypes().iter().filter(|a| a.table_id() != bevy_ecs::storage::TableId::empty());
    assert!(archetypes.count() > 10);
    schedule.run(&mut world);
    assert_eq!(bits(&snapshot(&world, surface).surface), bits(&source));
    // Moving rows once they are gathered changes nothing either.
    let (before, revision) = (gather(&world), snapshot(&world, surface).revision);
    scatter(&mut world);
    schedule.run(&mut world);
    assert_eq!(snapshot(&world, surface).revision, revision);
    assert_eq!(gather(&world).written, before.written);
}

#[test]
fn a_pass_in_which_nothing_changed_reads_nothing() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &source());
    scatter(&mut world);
    schedule.run(&mut world);
    let (before, held) = (gather(&world), snapshot(&world, surface).clone());
    for _ in 0..3 {
        schedule.run(&mut world);
    }
    let after = gather(&world);
    assert_eq!((after.items, after.tables, after.written), (before.items, before.tables, before.written));
    assert_eq!(after.runs, before.runs + 3);
    assert!(after.skipped > before.skipped);
    assert!(Arc::ptr_eq(&held.surface, &snapshot(&world, surface).surface));
    assert_eq!(held.revision, snapshot(&world, surface).revision);
}

#[test]
fn touching_everything_with_the_same_value_writes_nothing() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &source());
    scatter(&mut world);
    schedule.run(&mut world);
    let (before, held) = (gather(&world), snapshot(&world, surface).clone());
    let checks = world.resource::<GroundDiagnostics>().check.items;
    let mut touched = 0;
    fn touch<T: Component<Mutability = bevy_ecs::component::Mutable>>(world: &mut World) -> u64 {
        world.query::<&mut T>().iter_mut(world).map(|mut value| value.set_changed()).count() as u64
    }
    // All of them are read again, whether by single values or as a whole: both must see no news.
    for whole in [false, true] {
        touched += touch::<Position>(&mut world) + touch::<Detail>(&mut world);
        touch::<Cage>(&mut world);
        touch::<Sides>(&mut world);
        if whole {
            touch::<ControlPoints>(&mut world);
            touch::<ControlPointIndex>(&mut world);
            touch::<ControlPointOf>(&mut world);
            touch::<DetailLevel>(&mut world);
            touch::<Address>(&mut world);
            touch::<DetailOf>(&mut world);
        }
        schedule.run(&mut world);
    }
    // The same values again, as new components.
    for entity in world.query_filtered::<Entity, With<Position>>().iter(&world).collect::<Vec<_>>() {
        let same = *world.get::<Position>(entity).unwrap();
        world.entity_mut(entity).remove::<Position>().insert(same);
        touched += 1;
    }
    schedule.run(&mut world);
    assert_eq!(gather(&world).items, before.items + touched);
    assert_eq!(gather(&world).written, before.written);
    assert_eq!(world.resource::<GroundDiagnostics>().check.items, checks, "nothing is checked again");
    assert!(Arc::ptr_eq(&held.surface, &snapshot(&world, surface).surface));
    assert_eq!(held.revision, snapshot(&world, surface).revision);
}

#[test]
fn an_edit_is_gathered_in_place_unless_somebody_holds_what_was() {
    let (mut world, mut schedule) = host();
    let source = source();
    let surface = spawn_surface(&mut world, &source);
    let other = spawn_surface(&mut world, &octahedron());
    schedule.run(&mut world);
    let (place, revision) = (Arc::as_ptr(&snapshot(&world, surface).surface), snapshot(&world, surface).revision);
    let untouched = snapshot(&world, other).revision;
    let point = world.get::<ControlPoints>(surface).unwrap().0[6];
    world.get_mut::<Position>(point).unwrap().0.x += 1.0;
    schedule.run(&mut world);
    let edited = snapshot(&world, surface).clone();
    assert!(edited.revision > revision);
    assert_eq!(Arc::as_ptr(&edited.surface), place, "nobody held it");
    assert_eq!(edited.surface.points[6], source.points[6] + DVec3::X);
    assert_eq!(snapshot(&world, other).revision, untouched);

    let held = bits(&edited.surface);
    let detail = world.query_filtered::<Entity, With<Detail>>().iter(&world).next().unwrap();
    world.get_mut::<Detail>(detail).unwrap().0.z = 7.0;
    schedule.run(&mut world);
    let again = snapshot(&world, surface);
    assert!(again.revision > edited.revision);
    assert_eq!(bits(&edited.surface), held, "it was held");
    assert_ne!(bits(&again.surface), held);
    assert_eq!(bits(&again.surface.clone()), by_hand(&mut world, surface));
}

#[test]
fn the_structure_is_as_old_as_the_last_change_of_anything_but_values() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &source());
    schedule.run(&mut world);
    let first = snapshot(&world, surface).clone();
    assert_eq!(first.structure, first.revision);
    let point = world.get::<ControlPoints>(surface).unwrap().0[6];
    let detail = world.query_filtered::<Entity, With<Detail>>().iter(&world).next().unwrap();
    world.get_mut::<Position>(point).unwrap().0.x += 1.0;
    world.get_mut::<Detail>(detail).unwrap().0.x += 1.0;
    schedule.run(&mut world);
    // The same row as another entity is no other structure either.
    let row = (*world.get::<Position>(point).unwrap(), ControlPointOf(surface), ControlPointIndex(6));
    world.despawn(point);
    let again = world.spawn(row).id();
    world.get_mut::<ControlPoints>(surface).unwrap().0[6] = again;
    schedule.run(&mut world);
    let moved = snapshot(&world, surface).clone();
    assert!(moved.revision > first.revision);
    assert_eq!(moved.structure, first.structure);
    world.despawn(detail);
    schedule.run(&mut world);
    let fewer = snapshot(&world, surface).clone();
    assert_eq!((fewer.structure, fewer.revision > moved.revision), (fewer.revision, true));
    world.get_mut::<Sides>(surface).unwrap().corner_rule = selvedge::subdivision::CornerRule::Seed;
    schedule.run(&mut world);
    assert!(snapshot(&world, surface).structure > fewer.structure);
    // A value that is no number is found although the structure was found sound before.
    world.get_mut::<Position>(again).unwrap().0.x = f64::INFINITY;
    schedule.run(&mut world);
    assert!(world.get::<SurfaceFailed>(surface).is_some());
}

/// Every way in which a control point can leave is noticed, whatever else comes in its place, and
/// however often trackers of removal are cleared in between.
#[test]
fn a_control_point_that_is_gone_is_a_fault_until_it_is_back() {
    type Leave = fn(&mut World, Entity, Entity);
    let ways: [Leave; 5] = [
        |world, point, _| assert!(world.despawn(point)),
        |world, point, _| {
            world.entity_mut(point).remove::<Position>();
        },
        |world, point, _| {
            world.entity_mut(point).remove::<ControlPointIndex>();
        },
        |world, point, other| {
            world.entity_mut(point).insert(ControlPointOf(other));
        },
        |world, point, other| {
            // One goes, one comes: as many as before.
            world.despawn(point);
            world.spawn((Position::default(), ControlPointIndex(99), ControlPointOf(other)));
        },
    ];
    for leave in ways {
        let (mut world, mut schedule) = host();
        let surface = spawn_surface(&mut world, &source());
        let other = spawn_surface(&mut world, &octahedron());
        schedule.run(&mut world);
        let point = world.get::<ControlPoints>(surface).unwrap().0[4];
        leave(&mut world, point, other);
        world.clear_trackers();
        world.clear_trackers();
        schedule.run(&mut world);
        let failed = world.get::<SurfaceFailed>(surface).expect("a point is missing");
        assert_eq!(failed.0, [SurfaceFault::PointMissing { index: 4, listed: point }]);
        assert!(world.get::<Snapshot>(surface).is_none());

        let idle = gather(&world);
        schedule.run(&mut world);
        assert_eq!((gather(&world).written, gather(&world).items), (idle.written, idle.items), "told once");

        let mended = world.spawn((Position::default(), ControlPointIndex(4), ControlPointOf(surface))).id();
        world.get_mut::<ControlPoints>(surface).unwrap().0[4] = mended;
        if let Ok(mut stray) = world.get_entity_mut(point) {
            stray.remove::<ControlPointOf>();
        }
        schedule.run(&mut world);
        assert!(world.get::<SurfaceFailed>(surface).is_none());
        assert_eq!(bits(&snapshot(&world, surface).surface.clone()), by_hand(&mut world, surface));
    }
}

#[test]
fn details_that_come_go_and_move_are_noticed() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &source());
    schedule.run(&mut world);
    let details: Vec<_> = world.query_filtered::<Entity, With<Detail>>().iter(&world).collect();
    let mut last = snapshot(&world, surface).revision;
    type Change<'a> = Box<dyn FnMut(&mut World) + 'a>;
    let mut changes: Vec<Change<'_>> = vec![
        Box::new(|world| assert!(world.despawn(details[0]))),
        Box::new(|world| {
            world.entity_mut(details[1]).remove::<DetailOf>();
        }),
        Box::new(|world| world.get_mut::<DetailLevel>(details[2]).unwrap().0 = 1),
        Box::new(|world| *world.get_mut::<Address>(details[3]).unwrap() = Address::Corner(VertexId(19))),
        Box::new(|world| {
            let place = (DetailLevel(3), Address::Corner(VertexId(2)));
            world.spawn((Detail(DVec3::Y), place, DetailOf(surface)));
        }),
    ];
    for change in &mut changes {
        change(&mut world);
        world.clear_trackers();
        schedule.run(&mut world);
        let now = snapshot(&world, surface).clone();
        assert!(now.revision > last);
        last = now.revision;
        assert_eq!(bits(&now.surface), by_hand(&mut world, surface));
        assert_eq!(now.surface.details.count(), details_of(&mut world, surface));
    }
}

#[test]
fn what_a_host_disables_is_still_gathered() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &source());
    schedule.run(&mut world);
    let (held, counted) = (snapshot(&world, surface).clone(), gather(&world));
    let points = world.get::<ControlPoints>(surface).unwrap().0.clone();
    world.entity_mut(points[2]).insert(Disabled);
    world.entity_mut(surface).insert(Disabled);
    schedule.run(&mut world);
    assert_eq!((snapshot(&world, surface).revision, gather(&world).written), (held.revision, counted.written));
    world.get_mut::<Position>(points[3]).unwrap().0 = DVec3::ONE;
    schedule.run(&mut world);
    world.entity_mut(surface).remove::<Disabled>();
    schedule.run(&mut world);
    assert_eq!(snapshot(&world, surface).surface.points[3], DVec3::ONE, "an edit while it was disabled");
}

#[test]
fn every_fault_is_told_and_stops_its_surface_alone() {
    let (mut world, mut schedule) = host();
    let sound = spawn_surface(&mut world, &octahedron());
    let mut open = octahedron();
    open.mesh = Arc::new(selvedge::mesh::Connectivity::new(6, &[[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 5, 2]]).unwrap());
    let open = spawn_surface(&mut world, &open);
    let few = {
        let mut surface = octahedron();
        surface.points.pop();
        spawn_surface(&mut world, &surface)
    };
    let bare = world.spawn(Cage { mesh: octahedron().mesh }).id();
    let bad = spawn_surface(&mut world, &source());
    let nan = world.get::<ControlPoints>(bad).unwrap().0[1];
    world.get_mut::<Position>(nan).unwrap().0.y = f64::NAN;
    world.spawn((Detail(DVec3::X), DetailLevel(2), Address::Corner(VertexId(99)), DetailOf(bad)));
    schedule.run(&mut world);

    assert!(world.get::<SurfaceFailed>(sound).is_none() && world.get::<Snapshot>(sound).is_some());
    let faults = |surface| world.get::<SurfaceFailed>(surface).unwrap().0.clone();
    assert_eq!(faults(few), [SurfaceFault::PointCount { listed: 5, vertices: 6 }]);
    assert_eq!(faults(bare), [SurfaceFault::PointCount { listed: 0, vertices: 6 }]);
    assert!(faults(open).iter().all(|f| matches!(f, SurfaceFault::SideMissing { .. })), "{:?}", faults(open));
    assert_eq!(faults(open).len(), 6);
    let told = faults(bad);
    assert!(matches!(told[0], SurfaceFault::Mesh(Fault::NotFinite { vertex: VertexId(1), .. })), "{told:?}");
    assert_eq!(told[1], SurfaceFault::DetailNowhere { level: 2, address: Address::Corner(VertexId(99)) });
    assert_eq!(told.len(), 2);
    for failed in [open, few, bare, bad] {
        assert!(world.get::<Snapshot>(failed).is_none());
    }
}

/// A level that no mesh has, and a place with two details: neither is ever looked at as an array.
#[test]
fn details_that_cannot_be_put_in_order_are_faults() {
    let (mut world, mut schedule) = host();
    let surface = spawn_surface(&mut world, &source());
    let place = (Address::Corner(VertexId(3)), DetailOf(surface));
    world.spawn((Detail(DVec3::X), DetailLevel(u32::MAX), place));
    world.spawn((Detail(DVec3::Y), DetailLevel(0), place));
    schedule.run(&mut world);
    let told = &world.get::<SurfaceFailed>(surface).unwrap().0;
    assert_eq!(told[0], SurfaceFault::DetailTwice { level: 0, address: place.0 });
    assert!(matches!(told[1], SurfaceFault::DetailTooFine { level: u32::MAX, finest: 29 | 30 }), "{told:?}");
}

#[test]
fn budgets_that_stopped_a_surface_let_it_through_when_they_are_raised() {
    let (mut world, mut schedule) = host();
    let limited = selvedge::budget::Budgets { details: 4, ..Default::default() };
    world.insert_resource(limited);
    let surface = spawn_surface(&mut world, &source());
    schedule.run(&mut world);
    let failed = world.get::<SurfaceFailed>(surface).expect("five details are too many");
    assert!(matches!(failed.0[..], [SurfaceFault::Budget(over)] if over.needed == 5 && over.limit == 4));
    world.insert_resource(selvedge::budget::Budgets::default());
    schedule.run(&mut world);
    assert!(world.get::<SurfaceFailed>(surface).is_none() && world.get::<Snapshot>(surface).is_some());
}

#[test]
fn a_despawned_surface_leaves_nothing_of_itself() {
    let (mut world, mut schedule) = host();
    let stays = spawn_surface(&mut world, &octahedron());
    schedule.run(&mut world);
    let before = dump_without_resources(&mut world);
    let goes = spawn_surface(&mut world, &source());
    schedule.run(&mut world);
    despawn_surface(&mut world, goes);
    schedule.run(&mut world);
    assert_eq!(dump_without_resources(&mut world), before);
    assert!(world.get::<Snapshot>(stays).is_some());
}

/// A curve of a host's own, that can change inside.
#[derive(Debug)]
struct Moody {
    revision: Arc<AtomicU64>,
    position: fn(f64) -> DVec3,
}

impl Curve for Moody {
    fn position(&self, u: f64) -> DVec3 {
        (self.position)(u)
    }

    fn revision(&self) -> u64 {
        self.revision.load(Ordering::Relaxed)
    }
}

/// A square whose border from corner to corner and back is `curve`.
fn along(curve: impl Curve + 'static) -> LoopSurface {
    let mesh = Arc::new(selvedge::mesh::Connectivity::new(4, &[[0, 1, 2], [0, 2, 3]]).unwrap());
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
    let mut surface = LoopSurface::plain(mesh, points, &[VertexId(0)]);
    let curve = Arc::new(CurveParameters::even(Arc::new(curve), 4).unwrap());
    surface.sides[0].border = Border::Given { curve, first: 0, heading: Heading::Along };
    surface
}

#[test]
fn a_curve_that_has_changed_inside_makes_another_surface_of_it() {
    let (mut world, mut schedule) = host();
    let revision = Arc::new(AtomicU64::new(3));
    let surface = spawn_surface(&mut world, &along(Moody { revision: revision.clone(), position: DVec3::splat }));
    schedule.run(&mut world);
    let before = snapshot(&world, surface).revision;
    schedule.run(&mut world);
    assert_eq!(snapshot(&world, surface).revision, before);
    revision.store(4, Ordering::Relaxed);
    schedule.run(&mut world);
    assert!(snapshot(&world, surface).revision > before);
}

#[test]
fn a_curve_that_gives_no_point_stops_what_is_along_it_and_says_where() {
    let (mut world, mut schedule) = host();
    let revision = Arc::new(AtomicU64::new(0));
    let poles: [fn(f64) -> DVec3; 2] = [
        |u| if u == 0.5 { DVec3::NAN } else { DVec3::splat(u) },
        |u| if u == 0.5 { panic!("a pole") } else { DVec3::splat(u) },
    ];
    for position in poles {
        let surface = spawn_surface(&mut world, &along(Moody { revision: revision.clone(), position }));
        let curve = world.spawn(SpaceCurve::new(Moody { revision: revision.clone(), position })).id();
        schedule.run(&mut world);
        let told = &world.get::<SurfaceFailed>(surface).expect("the curve has a pole").0;
        assert!(matches!(told[..], [SurfaceFault::SideCurve { side: 0, vertex: VertexId(2), .. }]), "{told:?}");
        let told = &world.get::<CurveFailed>(curve).expect("the curve has a pole").0;
        assert!(matches!(told[..], [CurveFault::Evaluation { to: 0.5, .. }]), "{told:?}");
        let checked = world.resource::<GroundDiagnostics>().check;
        schedule.run(&mut world);
        let again = world.resource::<GroundDiagnostics>().check;
        assert_eq!((again.items, again.written), (checked.items, checked.written), "told once");
        world.entity_mut(curve).insert(SpaceCurve::new(Moody { revision: revision.clone(), position: DVec3::splat }));
        schedule.run(&mut world);
        assert!(world.get::<CurveFailed>(curve).is_none(), "it is mended");
    }
    // A list of parameters that ends before the side does.
    let mut long = along(Moody { revision, position: DVec3::splat });
    let Border::Given { first, .. } = &mut long.sides[0].border else { panic!("it is given") };
    *first = 1;
    let surface = spawn_surface(&mut world, &long);
    schedule.run(&mut world);
    let told = &world.get::<SurfaceFailed>(surface).expect("there are too few parameters").0;
    assert_eq!(told[..], [SurfaceFault::SideParameters { side: 0, edges: 4, available: 3 }]);
}

/// Whatever a host does, and whatever the rows have been through, the snapshot is what a slow walk
/// over all entities finds; and its revision rises if and only if that has changed.
#[test]
fn snapshots_follow_any_sequence_of_edits() {
    use proptest::prelude::*;
    use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
    let config = Config { cases: 48, failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
    let edit = (0_u8..9, 0_usize..40, -1.0_f64..1.0);
    runner
        .run(&prop::collection::vec(prop::collection::vec(edit, 0..4), 1..12), |passes| {
            let (mut world, mut schedule) = host();
            let surfaces = [spawn_surface(&mut world, &source()), spawn_surface(&mut world, &octahedron())];
            schedule.run(&mut world);
            let mut last = surfaces.map(|s| (bits(&snapshot(&world, s).surface), snapshot(&world, s).revision));
            for edits in passes {
                for (kind, which, value) in edits {
                    edit_once(&mut world, surfaces[which % 2], kind, which, value);
                }
                schedule.run(&mut world);
                for (surface, last) in surfaces.iter().zip(&mut last) {
                    let now = snapshot(&world, *surface).clone();
                    prop_assert_eq!(bits(&now.surface), by_hand(&mut world, *surface));
                    prop_assert_eq!(bits(&now.surface) != last.0, now.revision > last.1);
                    *last = (bits(&now.surface), now.revision);
                }
            }
            Ok(())
        })
        .unwrap();
}

fn edit_once(world: &mut World, surface: Entity, kind: u8, which: usize, value: f64) {
    let points = world.get::<ControlPoints>(surface).unwrap().0.clone();
    let index = which % points.len();
    let point = points[index];
    let details: Vec<_> = world.query::<(Entity, &DetailOf)>().iter(world).filter(|d| d.1.0 == surface).collect();
    let detail = details.get(which % details.len().max(1)).map(|d| d.0);
    match (kind, detail) {
        (0, _) => world.get_mut::<Position>(point).unwrap().0.x = value,
        (1, _) => world.get_mut::<Position>(point).unwrap().set_changed(),
        (2, _) => {
            world.entity_mut(point).insert(Tag::<0>);
        }
        (3, _) => {
            world.entity_mut(point).remove::<Tag<0>>();
        }
        (4, _) => {
            // The same point as another entity.
            let row =
                (*world.get::<Position>(point).unwrap(), ControlPointOf(surface), ControlPointIndex(index as u32));
            world.despawn(point);
            let again = world.spawn(row).id();
            world.get_mut::<ControlPoints>(surface).unwrap().0[index] = again;
        }
        (5, Some(detail)) => world.get_mut::<Detail>(detail).unwrap().0.y = value,
        (6, Some(detail)) => assert!(world.despawn(detail)),
        (7, Some(detail)) => {
            world.entity_mut(detail).insert(Tag::<1>);
        }
        _ => {
            let place = (DetailLevel(which as u32 % 4), Address::Corner(VertexId(index as u32)));
            let mut query = world.query::<(&DetailLevel, &Address, &DetailOf)>();
            if !query.iter(world).any(|d| (*d.0, *d.1) == place && d.2.0 == surface) {
                world.spawn((Detail(DVec3::splat(value)), place, DetailOf(surface)));
            }
        }
    }
}
