//! Both sides of a trim: what stays and what goes, with the same samples where they meet.

#[path = "support/seam.rs"]
mod seam;
mod support;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use seam::{Seam, seam};
use selvedge::curve::{Concatenation, Curve, Extent, Heading, Segment, SpaceCurve};
use selvedge::subdivision::remesh::RemeshError;
use selvedge::subdivision::{ControlPoints, LoopSurface, Position, Snapshot};
use selvedge::trim::{OtherSide, OtherSideOf, Sides, Stale, Trim, TrimCurve, TrimFault, TrimOptions};
use selvedge::{spawn_curve, spawn_trim};
use support::plate::{Plate, TOLERANCE, circle, laid, tolerance, wide_plate};

fn both() -> TrimOptions {
    TrimOptions { sides: Sides::Both, ..TrimOptions::default() }
}

impl Plate {
    fn part(&mut self, curves: &[(Arc<dyn Curve>, Heading)]) -> Entity {
        let cuts: Vec<_> = curves.iter().map(|(c, h)| (spawn_curve(&mut self.world, Arc::clone(c)), *h)).collect();
        spawn_trim(&mut self.world, self.source, &cuts, tolerance(), both())
    }

    fn bore_both(&mut self, centre: DVec2, radius: f64) -> Entity {
        let curve = circle(&self.surface, centre, radius);
        self.part(&[(curve, Heading::Against)])
    }

    fn other(&self, trim: Entity) -> &LoopSurface {
        let other = self.world.get::<OtherSide>(trim).expect("the trim has another side").0;
        assert_eq!(self.world.get::<OtherSideOf>(other).map(|of| of.0), Some(trim));
        &self.world.get::<Snapshot>(other).expect("a result has a snapshot").surface
    }

    /// The other side of a trim is within tolerance, and meets what stays without an open edge.
    fn meets(&self, trim: Entity) {
        let report = self.report(trim);
        let other = report.other.as_ref().expect("it was asked for");
        assert!(report.audit.greatest().0 <= TOLERANCE && other.audit.greatest().0 <= TOLERANCE);
        let of_curve = |cut: &TrimCurve| Arc::clone(&self.world.get::<SpaceCurve>(cut.curve).expect("a curve").curve);
        let curves: Vec<_> = self.world.get::<Trim>(trim).expect("a trim").cuts.iter().map(of_curve).collect();
        for level in 0..=3 {
            let seam = seam(self.result().expect("a result"), self.other(trim), &curves, level).expect("triangles");
            let Seam { expected, found, open } = seam;
            assert!(expected > 0 && found == expected && open == 0, "level {level}: {seam:?}");
        }
    }
}

#[test]
fn a_bore_and_its_plug_meet_to_the_bit() {
    let mut plate = Plate::new();
    let trim = plate.bore_both(DVec2::new(0.013, -0.007), 0.06);
    plate.settle();
    plate.meets(trim);
    let (kept, plug) = (plate.result().expect("a result"), plate.other(trim));
    assert_eq!((kept.mesh.euler(), plug.mesh.euler()), (0, 1));
    assert!(plug.points.iter().all(|p| p.truncate().distance(DVec2::new(0.013, -0.007)) < 0.061));
}

#[test]
fn a_slot_that_splits_a_surface_gives_three_parts() {
    let mut plate = Plate::new();
    let line = |x: f64| laid(&plate.surface, Segment { start: DVec3::new(x, -0.5, 0.0), end: DVec3::new(x, 0.5, 0.0) });
    let slot = [(line(-0.021), Heading::Along), (line(0.024), Heading::Against)];
    let trim = plate.part(&slot);
    plate.settle();
    plate.meets(trim);
    let (kept, strip) = (plate.result().expect("a result"), plate.other(trim));
    assert_eq!((kept.mesh.euler(), strip.mesh.euler()), (2, 1));
    assert!(strip.points.iter().all(|p| p.x > -0.022 && p.x < 0.025));
}

/// A star of five points: convex corners of what stays are concave ones of what goes.
#[test]
fn a_cut_out_with_corners_fits_its_hole() {
    let mut plate = Plate::new();
    let corner = |k: usize| {
        let radius = if k.is_multiple_of(2) { 0.1 } else { 0.05 };
        (radius * DVec2::from_angle(0.3 + core::f64::consts::TAU * (k % 10) as f64 / 10.0)).extend(0.0)
    };
    let sides = (0..10).map(|k| Arc::new(Segment { start: corner(k), end: corner(k + 1) }) as Arc<dyn Curve>);
    let star = Concatenation::new(sides.collect(), Extent::Closed, 1e-12).expect("a closed star");
    let star = laid(&plate.surface, star);
    let trim = plate.part(&[(star, Heading::Against)]);
    plate.settle();
    plate.meets(trim);
    assert_eq!(plate.other(trim).mesh.euler(), 1);
}

/// Each part is what would be left without its trim, less what stays; so what two trims both remove
/// is in neither.
#[test]
fn every_trim_of_a_source_has_its_own_part() {
    let mut plate = Plate::of(wide_plate(30));
    let left = plate.bore_both(DVec2::new(-0.05, 0.0), 0.1);
    let right = plate.bore_both(DVec2::new(0.06, 0.01), 0.1);
    let away = plate.bore_both(DVec2::new(0.4, 0.4), 0.07);
    let plain = plate.bore(DVec2::new(-0.5, 0.4), 0.07);
    plate.settle();
    for trim in [left, right, away] {
        plate.meets(trim);
        assert_eq!(plate.other(trim).mesh.euler(), 1);
    }
    assert!(plate.world.get::<OtherSide>(plain).is_none() && plate.report(plain).other.is_none());
    assert_eq!(plate.other(left).sides.len(), 2, "a crescent");
    let in_right = |p: &DVec3| p.truncate().distance(DVec2::new(0.06, 0.01)) < 0.099;
    assert!(!plate.other(left).points.iter().any(in_right));
}

#[test]
fn a_ring_between_two_curves_of_one_trim_is_one_part() {
    let mut plate = Plate::new();
    let [wide, thin] = [0.1, 0.04].map(|r| circle(&plate.surface, DVec2::ZERO, r));
    let trim = plate.part(&[(wide, Heading::Against), (thin, Heading::Along)]);
    plate.settle();
    plate.meets(trim);
    assert_eq!((plate.result().expect("a result").mesh.euler(), plate.other(trim).mesh.euler()), (1, 0));
}

#[test]
fn the_other_side_follows_its_trim_and_goes_with_it() {
    let mut plate = Plate::new();
    let trim = plate.bore_both(DVec2::ZERO, 0.05);
    plate.settle();
    let other = plate.world.get::<OtherSide>(trim).expect("another side").0;
    let before = support::world::bits(plate.other(trim));
    let points = plate.world.get::<ControlPoints>(plate.source).expect("a surface").0.clone();
    let old = *plate.world.get::<Position>(points[40]).expect("a point");
    plate.world.get_mut::<Position>(points[40]).expect("a point").0.z += 1e-6;
    plate.run();
    let there = (plate.world.get_entity(other).is_ok(), plate.world.get::<Stale>(other).is_some());
    assert_eq!(there, (true, true), "the last good one says that it is old {:?}", plate.state(trim));
    plate.settle();
    assert!(plate.world.get::<Stale>(other).is_none());
    plate.meets(trim);
    assert_ne!(support::world::bits(plate.other(trim)), before);
    *plate.world.get_mut::<Position>(points[40]).expect("a point") = old;
    plate.run();
    plate.settle();
    assert_eq!(support::world::bits(plate.other(trim)), before, "the way back leads to the same bits");
    plate.world.get_mut::<TrimOptions>(trim).expect("a trim").sides = Sides::Left;
    plate.run();
    plate.settle();
    assert!(plate.world.get_entity(other).is_err() && plate.world.get::<OtherSide>(trim).is_none());
    plate.world.get_mut::<TrimOptions>(trim).expect("a trim").sides = Sides::Both;
    plate.run();
    plate.settle();
    let other = plate.world.get::<OtherSide>(trim).expect("another side").0;
    plate.world.despawn(trim);
    plate.run();
    plate.run();
    assert!(plate.world.get_entity(other).is_err());
}

/// A hole within a hole removes nothing: it has no other side, and says so.
#[test]
fn a_trim_without_another_side_fails_as_a_whole() {
    let mut plate = Plate::new();
    let wide = plate.bore(DVec2::ZERO, 0.09);
    let within = plate.bore_both(DVec2::new(0.005, 0.0), 0.04);
    plate.settle();
    let why = plate.failure(within);
    let TrimFault::OtherSide { why } = why else { panic!("{why}") };
    assert!(matches!(**why, TrimFault::Remesh(RemeshError::NothingLeft { .. })), "{why}");
    assert!(plate.report(wide).audit.greatest().0 <= TOLERANCE);
    assert_eq!(plate.result().expect("a result").mesh.euler(), 0);
}
