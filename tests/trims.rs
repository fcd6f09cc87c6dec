//! Trims in a world: a quantum a pass, together where they touch, taken back without a trace.

mod support;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use selvedge::curve::{FnCurve, Heading, SpaceCurve};
use selvedge::diagnostics::SubdivisionDiagnostics;
use selvedge::evaluate::{Evaluate, SurfacePoint};
use selvedge::job::Cancelled;
use selvedge::mesh::FaceId;
use selvedge::subdivision::remesh::RemeshError;
use selvedge::subdivision::{ControlPoints, Position};
use selvedge::tolerance::Tolerance;
use selvedge::trim::{ResultOf, Stale, Trim, TrimFault, TrimJob, TrimOptions, TrimmedTo};
use selvedge::{despawn_surface, spawn_curve, spawn_trim};
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::subdivision::limit::LimitSurface;
use support::plate::{Plate, TOLERANCE, circle, tolerance, wide_plate};
use support::world::bits;

#[test]
fn a_bore_leaves_a_result_beside_its_source() {
    let mut plate = Plate::new();
    plate.run();
    let before = plate.source_bits();
    let trim = plate.bore(DVec2::new(0.013, -0.007), 0.06);
    plate.settle();
    let report = plate.report(trim).clone();
    assert!(report.audit.greatest().0 <= TOLERANCE);
    assert_eq!(report.together, [trim]);
    assert_eq!(plate.source_bits(), before, "the source is as it was");
    assert_eq!(plate.details(), report.details, "counts are those of the world");
    let result = plate.result().expect("a result");
    assert_eq!(result.mesh.euler(), 0);
    assert_eq!(result.details.count(), report.details);
}

#[test]
fn nothing_happens_when_nothing_has_changed() {
    let mut plate = Plate::new();
    plate.bore(DVec2::ZERO, 0.05);
    plate.settle();
    let written = |plate: &Plate| {
        let d = plate.world.resource::<SubdivisionDiagnostics>();
        [d.admit, d.locate, d.remesh, d.refine, d.audit, d.compose, d.advance].map(|c| c.written)
    };
    let before = written(&plate);
    let points = plate.world.get::<ControlPoints>(plate.source).expect("a surface").0.clone();
    plate.world.get_mut::<Position>(points[3]).expect("a point").set_changed();
    for _ in 0..3 {
        plate.run();
    }
    assert_eq!(written(&plate), before);
}

#[test]
fn an_edit_of_the_source_is_trimmed_anew() {
    let mut plate = Plate::new();
    let trim = plate.bore(DVec2::ZERO, 0.05);
    plate.settle();
    let before = bits(plate.result().expect("a result"));
    let points = plate.world.get::<ControlPoints>(plate.source).expect("a surface").0.clone();
    let old = *plate.world.get::<Position>(points[40]).expect("a point");
    plate.world.get_mut::<Position>(points[40]).expect("a point").0.z += 1e-6;
    plate.run();
    let result = plate.world.get::<TrimmedTo>(plate.source).expect("a result").0;
    assert!(plate.world.get::<Stale>(result).is_some(), "the last good result says that it is old");
    plate.settle();
    assert!(plate.world.get::<Stale>(result).is_none());
    assert!(plate.report(trim).audit.greatest().0 <= TOLERANCE);
    assert_ne!(bits(plate.result().expect("a result")), before);
    *plate.world.get_mut::<Position>(points[40]).expect("a point") = old;
    plate.run();
    plate.settle();
    assert_eq!(bits(plate.result().expect("a result")), before, "the way back leads to the same bits");
}

#[test]
fn two_bores_leave_what_both_leave() {
    let mut plate = Plate::new();
    let first = plate.bore(DVec2::new(-0.09, 0.0), 0.04);
    let second = plate.bore(DVec2::new(0.09, 0.02), 0.05);
    plate.settle();
    for trim in [first, second] {
        assert!(plate.report(trim).audit.greatest().0 <= TOLERANCE);
    }
    assert_eq!(plate.result().expect("a result").mesh.euler(), -1);
    // One is moved: the other stays.
    let moved = circle(&plate.surface, DVec2::new(0.09, -0.03), 0.05);
    let curve = plate.world.get::<Trim>(second).expect("a trim").cuts[0].curve;
    *plate.world.get_mut::<SpaceCurve>(curve).expect("a curve") = SpaceCurve { curve: moved };
    plate.run();
    plate.settle();
    assert_eq!(plate.result().expect("a result").mesh.euler(), -1);
    plate.world.despawn(first);
    plate.run();
    plate.settle();
    assert_eq!(plate.result().expect("a result").mesh.euler(), 0);
    plate.world.despawn(second);
    plate.run();
    plate.run();
    assert!(plate.result().is_none(), "what is left of a source without trims is the source");
    assert_eq!(plate.details(), 0);
    let mut results = plate.world.query::<&ResultOf>();
    assert_eq!(results.iter(&plate.world).count(), 0);
}

#[test]
fn a_cancelled_trim_leaves_no_trace() {
    let mut plate = Plate::new();
    let trim = plate.bore(DVec2::ZERO, 0.05);
    for _ in 0..12 {
        plate.run();
    }
    assert!(plate.state(trim).is_running());
    plate.world.entity_mut(trim).insert(Cancelled);
    plate.run();
    assert!(plate.world.get::<TrimJob>(trim).is_none());
    assert_eq!(plate.details(), 0);
    assert!(plate.result().is_none());
    plate.world.entity_mut(trim).remove::<Cancelled>();
    plate.run();
    plate.settle();
    assert!(plate.report(trim).details > 0);
}

#[test]
fn a_trim_that_fails_is_skipped_and_the_others_are_made() {
    let mut plate = Plate::new();
    let good = plate.bore(DVec2::ZERO, 0.05);
    let away = plate.bore_in_the_air();
    plate.settle();
    assert!(matches!(plate.failure(away), TrimFault::Misses { .. } | TrimFault::Remesh(_)), "{}", plate.failure(away));
    assert!(plate.report(good).audit.greatest().0 <= TOLERANCE);
    assert_eq!(plate.result().expect("a result").mesh.euler(), 0);
}

#[test]
fn what_cannot_be_trimmed_says_why() {
    let mut plate = Plate::new();
    let no_curve = plate.world.spawn_empty().id();
    let no_curve = plate.cut(no_curve, Heading::Along);
    let nan = spawn_curve(&mut plate.world, Arc::new(FnCurve::new(|_| DVec3::NAN)));
    let nan = plate.cut(nan, Heading::Along);
    let panics = spawn_curve(&mut plate.world, Arc::new(FnCurve::new(|u: f64| -> DVec3 { panic!("at {u}") })));
    let panics = plate.cut(panics, Heading::Along);
    let bad = plate.bore(DVec2::ZERO, 0.03);
    plate.world.entity_mut(bad).insert(Tolerance { fit: -1.0, chord: 1.0, curve: 1.0 });
    let small = plate.bore(DVec2::ZERO, 1e-6);
    let curve = spawn_curve(&mut plate.world, circle(&plate.surface, DVec2::ZERO, 0.05));
    let nowhere = plate.world.spawn_empty().id();
    let no_source =
        spawn_trim(&mut plate.world, nowhere, &[(curve, Heading::Against)], tolerance(), TrimOptions::default());
    let nothing = spawn_trim(&mut plate.world, plate.source, &[], tolerance(), TrimOptions::default());
    plate.settle();
    assert!(matches!(plate.failure(no_curve), TrimFault::NoCurve { .. }));
    assert!(matches!(plate.failure(nan), TrimFault::CurveFailed { .. }));
    assert!(matches!(plate.failure(panics), TrimFault::CurveFailed { .. }));
    assert!(matches!(plate.failure(bad), TrimFault::BadNumber { .. }));
    assert!(matches!(plate.failure(small), TrimFault::TooSmall { .. }), "{}", plate.failure(small));
    assert!(matches!(plate.failure(no_source), TrimFault::NoSource { .. }));
    assert!(matches!(plate.failure(nothing), TrimFault::Remesh(_)));
    assert!(plate.result().is_none());
    despawn_surface(&mut plate.world, plate.source);
    plate.run();
    assert!(matches!(plate.failure(bad), TrimFault::NoSource { .. }));
}

/// What is looked at of a wide plate is a part of it; what that leaves is what all of it would.
#[test]
fn a_bore_far_from_everything_is_made_on_a_part_of_its_source() {
    let mut plate = Plate::of(wide_plate(30));
    let bore = plate.bore(DVec2::new(0.013, -0.007), 0.06);
    plate.settle();
    let report = plate.report(bore).clone();
    assert!(report.cage.faces < plate.surface.mesh.face_count() / 2, "{:?}", report.cage);
    let result = plate.result().expect("a result").clone();
    assert_eq!(result.mesh.euler(), 0);
    assert_eq!(result.sides.len(), 5);
    assert!(selvedge_systems::check::surface_faults(&result, &Default::default()).is_empty());
    // Again, with a reach so large that it means nothing but that all of the source is looked at.
    plate.world.get_mut::<TrimOptions>(bore).expect("a trim").reach = Some(10.0);
    plate.run();
    plate.settle();
    let whole = plate.result().expect("a result");
    assert_eq!(result.mesh.faces().len(), whole.mesh.faces().len());
    assert_eq!(result.details.count(), whole.details.count());
    let limit = LimitSurface::new(Arc::new(result)).expect("sound");
    let whole = LimitSurface::new(Arc::new(whole.clone())).expect("sound");
    let whole = SurfaceIndex::new(Arc::new(whole)).expect("finite");
    for f in 0..limit.face_count() {
        for st in [DVec2::new(0.0, 0.0), DVec2::new(0.3, 0.4), DVec2::new(0.8, 0.1)] {
            let x = limit.position(SurfacePoint { face: FaceId::new(f), st });
            let off = whole.closest(x).expect("finite").distance;
            assert!(off < 1e-12, "face {f}: {off:e} off at {x}");
        }
    }
}

#[test]
fn bores_that_do_not_touch_are_made_side_by_side_and_stay_when_another_moves() {
    let mut plate = Plate::of(wide_plate(40));
    let places = [DVec2::new(-0.6, -0.6), DVec2::new(0.6, 0.55), DVec2::new(-0.55, 0.6)];
    let bores = places.map(|at| plate.bore(at, 0.06));
    plate.settle();
    for bore in bores {
        assert_eq!(plate.report(bore).together, [bore]);
    }
    let count: usize = bores.map(|bore| plate.report(bore).details).iter().sum();
    assert_eq!((plate.details(), plate.result().expect("a result").details.count()), (count, count));
    assert_eq!(plate.result().expect("a result").mesh.euler(), 1 - 3);
    let reports = bores.map(|bore| plate.report(bore).clone());
    let remeshed = plate.world.resource::<SubdivisionDiagnostics>().remesh.items;
    let moved = circle(&plate.surface, DVec2::new(0.6, 0.5), 0.05);
    let curve = plate.world.get::<Trim>(bores[1]).expect("a trim").cuts[0].curve;
    *plate.world.get_mut::<SpaceCurve>(curve).expect("a curve") = SpaceCurve { curve: moved };
    plate.run();
    plate.settle();
    assert_eq!(plate.report(bores[0]), &reports[0]);
    assert_ne!(plate.report(bores[1]), &reports[1]);
    assert_eq!(plate.report(bores[2]), &reports[2]);
    let again = plate.world.resource::<SubdivisionDiagnostics>().remesh.items - remeshed;
    // To take its part of the source, to see how its curves meet, to adapt, and to lay strips.
    assert_eq!(again, 4, "four quanta for the one that moved, none for the others");
}

/// A hole in a hole takes nothing away; a curve through the middle of everything takes half.
#[test]
fn what_lies_beyond_a_curve_far_away_goes_with_it() {
    let mut plate = Plate::of(wide_plate(44));
    let wide = plate.bore(DVec2::ZERO, 0.75);
    let within = plate.bore(DVec2::new(0.02, -0.03), 0.06);
    let beside = plate.bore(DVec2::new(0.93, 0.93), 0.06);
    plate.settle();
    for bore in [wide, within, beside] {
        plate.report(bore);
    }
    let result = plate.result().expect("a result");
    assert_eq!(result.mesh.euler(), -1);
    assert_eq!(result.mesh.border_loops().len(), 3);
    assert!(result.points.iter().zip(0..result.mesh.vertex_count()).all(|(p, _)| p.truncate().length() > 0.6));
}

/// What stays is on the left of every curve of a trim, however far apart they run.
#[test]
fn of_two_discs_one_in_the_other_the_inner_one_stays() {
    let mut plate = Plate::of(wide_plate(96));
    let discs = [(DVec2::ZERO, 1.6), (DVec2::new(0.02, -0.03), 0.06)].map(|(at, radius)| {
        let curve = circle(&plate.surface, at, radius);
        (spawn_curve(&mut plate.world, curve), Heading::Along)
    });
    let trim = spawn_trim(&mut plate.world, plate.source, &discs, tolerance(), TrimOptions::default());
    plate.settle();
    plate.report(trim);
    let result = plate.result().expect("a result");
    assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (1, 1));
    assert!(result.points.iter().all(|p| p.truncate().length() < 0.2));
}

/// A torus in a world, its surface ready to be hit.
fn torus() -> (Plate, Arc<SurfaceIndex<LimitSurface>>) {
    let plate = Plate::of(support::world::torus(40, 20));
    let limit = LimitSurface::new(Arc::new(plate.surface.clone())).expect("sound");
    (plate, Arc::new(SurfaceIndex::new(Arc::new(limit)).expect("finite")))
}

/// The closed curve on a surface that lines from `from(u)` along `along(u)` meet first.
fn met(
    plate: &mut Plate,
    index: &Arc<SurfaceIndex<LimitSurface>>,
    line: impl Fn(f64) -> [DVec3; 2] + Send + Sync + 'static,
) -> Entity {
    let index = Arc::clone(index);
    let curve = move |u: f64| {
        let [from, along] = line(u);
        index.first_hit(from, along, [0.0, f64::INFINITY]).map_or(DVec3::NAN, |hit| hit.position)
    };
    spawn_curve(&mut plate.world, Arc::new(FnCurve::new(curve).closed()))
}

/// Round the tube, at an angle round the axis.
fn meridian(plate: &mut Plate, index: &Arc<SurfaceIndex<LimitSurface>>, angle: f64) -> Entity {
    let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
    met(plate, index, move |u| {
        let (sine, cosine) = (std::f64::consts::TAU * u).sin_cos();
        [out, out * cosine + DVec3::Z * sine]
    })
}

/// A circle on the outside of the tube.
fn porthole(plate: &mut Plate, index: &Arc<SurfaceIndex<LimitSurface>>, angle: f64) -> Entity {
    let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let curve = met(plate, index, move |u| {
        let (sine, cosine) = (std::f64::consts::TAU * u).sin_cos();
        [out + 0.09 * (out.cross(DVec3::Z) * -cosine + DVec3::Z * sine), out]
    });
    plate.cut(curve, Heading::Against)
}

/// Two meridians leave one part of the tube or the other; headings that contradict each other are told.
#[test]
fn two_meridians_of_a_torus_separate_it() {
    for headings in [[Heading::Along, Heading::Against], [Heading::Against, Heading::Along], [Heading::Along; 2]] {
        let (mut plate, index) = torus();
        let cuts = [(0.1, headings[0]), (1.7, headings[1])].map(|(at, h)| (meridian(&mut plate, &index, at), h));
        let trim = spawn_trim(&mut plate.world, plate.source, &cuts, tolerance(), TrimOptions::default());
        plate.settle();
        if headings[0] == headings[1] {
            let why = plate.failure(trim);
            assert!(matches!(why, TrimFault::Remesh(RemeshError::DoesNotSeparate { .. })), "{why}");
            continue;
        }
        plate.report(trim);
        let result = plate.result().expect("a result");
        assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (0, 2));
        let turned = |p: &DVec3| DVec2::from_angle(-0.9).rotate(p.truncate()).x > 0.5;
        let between = result.points.iter().filter(|p| turned(p)).count();
        // A quarter of a turn is left, or the rest.
        assert_eq!(2 * between > result.points.len(), headings[0] == Heading::Against, "{headings:?}");
    }
}

/// A curve that does not separate is refused, and none of its neighbours, near or far, older or newer.
#[test]
fn what_does_not_separate_takes_nothing_good_with_it() {
    let (mut plate, index) = torus();
    let older = porthole(&mut plate, &index, -0.3);
    let curve = meridian(&mut plate, &index, 0.0);
    let wrong = plate.cut(curve, Heading::Along);
    let newer = porthole(&mut plate, &index, 0.3);
    let far = porthole(&mut plate, &index, 3.0);
    plate.settle();
    let why = plate.failure(wrong);
    assert!(matches!(why, TrimFault::Remesh(RemeshError::DoesNotSeparate { curve: 0, .. })), "{why}");
    for good in [older, newer, far] {
        plate.report(good);
    }
    let result = plate.result().expect("a result");
    assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (-3, 3));
}

#[test]
fn a_meridian_of_a_torus_does_not_separate_it() {
    let (mut plate, index) = torus();
    let curve = meridian(&mut plate, &index, 0.0);
    let trim = plate.cut(curve, Heading::Along);
    plate.settle();
    let why = plate.failure(trim);
    assert!(matches!(why, TrimFault::Remesh(RemeshError::DoesNotSeparate { .. })), "{why}");
    assert!(plate.result().is_none());
    assert_eq!(plate.details(), 0);
}

/// Beside a corner of the plate two curved sides are divided, and both have a sample there; the detail of
/// the corner is one all the same, and what is put together of parts is as near as the parts were.
#[test]
fn a_result_is_as_near_as_its_parts_were_at_a_corner_of_two_sides() {
    let surface = wide_plate(16);
    let limit = Arc::new(LimitSurface::new(Arc::new(surface.clone())).expect("sound"));
    let source = SurfaceIndex::new(limit).expect("finite");
    for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let mut plate = Plate::of(surface.clone());
        let centre = DVec2::new(x, y) * (0.4 - 0.057);
        let curve = spawn_curve(&mut plate.world, circle(&plate.surface, centre, 0.028));
        let bore = [(curve, Heading::Against)];
        let (fine, options) = (Some(Tolerance::total(2e-6)), TrimOptions::default());
        let trim = spawn_trim(&mut plate.world, plate.source, &bore, fine, options);
        plate.settle();
        let audited = plate.report(trim).audit.greatest().0;
        let result = plate.result().expect("a result");
        assert_eq!(result.details.count(), plate.report(trim).details, "one detail at each address");
        let trimmed = LimitSurface::new(Arc::new(result.clone())).expect("sound");
        let steps = || (0..=8).flat_map(|i| (0..=8 - i).map(move |j| [i, j].map(|k| f64::from(k) / 8.0)));
        let near = (0..trimmed.face_count()).map(FaceId::new).filter(|&face| {
            let middle = trimmed.position(SurfacePoint::new(face, 1.0 / 3.0, 1.0 / 3.0));
            middle.truncate().distance(centre) < 0.2
        });
        for face in near {
            for [s, t] in steps() {
                let at = trimmed.position(SurfacePoint::new(face, s, t));
                let off = source.closest(at).expect("finite").distance;
                assert!(off <= 1.1 * audited, "{off:e} at {at}, where {audited:e} was found");
            }
        }
    }
}
