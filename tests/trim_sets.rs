//! Several trims of one source leave what each of them leaves: the common part.

mod support;

use bevy_ecs::prelude::*;
use glam::DVec2;
use selvedge::curve::Heading;
use selvedge::spawn_curve;
use selvedge::subdivision::remesh::RemeshError;
use selvedge::trim::{TrimFault, TrimState};
use support::plate::{Plate, TOLERANCE, circle, wide_plate};
use support::world::bits;

impl Plate {
    /// A trim that keeps the disc about `centre`.
    fn keep(&mut self, centre: DVec2, radius: f64) -> Entity {
        let curve = spawn_curve(&mut self.world, circle(&self.surface, centre, radius));
        self.cut(curve, Heading::Along)
    }

    fn made(&self, trims: &[Entity]) {
        for &trim in trims {
            assert!(self.report(trim).audit.greatest().0 <= TOLERANCE);
        }
    }
}

#[test]
fn two_keep_discs_that_overlap_leave_their_lens() {
    let mut plate = Plate::new();
    let (a, b) = (DVec2::new(-0.04, 0.003), DVec2::new(0.04, -0.002));
    let trims = [plate.keep(a, 0.07), plate.keep(b, 0.07)];
    plate.settle();
    plate.made(&trims);
    let result = plate.result().expect("a result");
    assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (1, 1));
    assert_eq!(result.sides.len(), 2, "two arcs, with a corner at each end");
    for p in &result.points {
        let p = p.truncate();
        assert!(p.distance(a) < 0.07 + 1e-3 && p.distance(b) < 0.07 + 1e-3, "{p} is in both discs");
    }
}

/// Near enough to be made together, and so far apart that each is made by itself.
#[test]
fn of_keep_discs_apart_the_newer_fails_and_the_older_stands() {
    for (plate, radius, away) in [(Plate::new(), 0.05, 0.09), (Plate::of(wide_plate(40)), 0.06, 0.6)] {
        let mut plate = plate;
        let (older, newer) = (plate.keep(DVec2::new(-away, 0.01), radius), plate.keep(DVec2::new(away, 0.0), radius));
        let bore = plate.bore(DVec2::new(-away, 0.02), 0.3 * radius);
        plate.settle();
        let why = plate.failure(newer);
        assert!(matches!(why, TrimFault::Remesh(RemeshError::NothingLeft { .. })), "{why}");
        plate.made(&[older, bore]);
        let result = plate.result().expect("a result");
        assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (0, 2));
        assert!(result.points.iter().all(|p| p.x < -away + 1.05 * radius), "the older disc");
        // What stood in its way is gone.
        plate.world.despawn(older);
        plate.world.despawn(bore);
        plate.run();
        plate.settle();
        plate.made(&[newer]);
    }
}

#[test]
fn a_bore_through_the_rim_of_a_keep_disc_takes_its_share_of_the_disc() {
    let mut plate = Plate::new();
    let disc = plate.keep(DVec2::ZERO, 0.09);
    let bore = plate.bore(DVec2::new(0.08, 0.0), 0.04);
    plate.settle();
    plate.made(&[disc, bore]);
    let result = plate.result().expect("a result");
    assert_eq!((result.mesh.euler(), result.sides.len()), (1, 2));
    let sound = |p: DVec2| p.length() < 0.091 && p.distance(DVec2::new(0.08, 0.0)) > 0.039;
    assert!(result.points.iter().all(|p| sound(p.truncate())));
}

#[test]
fn a_bore_within_a_keep_disc_leaves_a_ring_whichever_is_older_and_wherever_they_are() {
    // One after the other on a small plate, and on a wide one far enough apart to be made apart.
    for (plate, wide, thin) in [(Plate::new(), 0.1, 0.03), (Plate::of(wide_plate(44)), 0.75, 0.06)] {
        let mut plate = plate;
        let within = plate.bore(DVec2::new(0.01, 0.0), thin);
        let disc = plate.keep(DVec2::ZERO, wide);
        let beyond = plate.bore(DVec2::new(1.2 * wide, 0.0), thin);
        plate.settle();
        plate.made(&[within, disc, beyond]);
        let result = plate.result().expect("a result");
        assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (0, 2));
        assert!(result.points.iter().all(|p| p.truncate().length() < wide + 0.01));
    }
}

#[test]
fn bores_that_overlap_still_make_one_hole() {
    let mut plate = Plate::new();
    let trims = [plate.bore(DVec2::new(-0.03, 0.0), 0.05), plate.bore(DVec2::new(0.03, 0.004), 0.05)];
    plate.settle();
    plate.made(&trims);
    let result = plate.result().expect("a result");
    assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (0, 2));
}

/// The curves of one trim are one border: two discs that it keeps may lie apart.
#[test]
fn one_trim_may_keep_two_discs() {
    let mut plate = Plate::new();
    let curves = [DVec2::new(-0.09, 0.0), DVec2::new(0.09, 0.0)]
        .map(|at| (spawn_curve(&mut plate.world, circle(&plate.surface, at, 0.05)), Heading::Along));
    let trim = selvedge::spawn_trim(
        &mut plate.world,
        plate.source,
        &curves,
        support::plate::tolerance(),
        selvedge::trim::TrimOptions::default(),
    );
    plate.settle();
    plate.made(&[trim]);
    let result = plate.result().expect("a result");
    assert_eq!((result.mesh.euler(), result.mesh.border_loops().len()), (2, 2));
}

#[test]
fn what_trims_have_in_common_has_the_same_bits_on_one_thread_and_on_four() {
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let mut plate = Plate::of(wide_plate(20));
            let trims = [
                plate.keep(DVec2::new(-0.1, 0.0), 0.3),
                plate.keep(DVec2::new(0.1, 0.03), 0.3),
                plate.bore(DVec2::new(0.0, 0.27), 0.06),
                plate.bore(DVec2::new(0.0, -0.1), 0.05),
            ];
            plate.settle();
            trims.iter().for_each(|&trim| assert_eq!(plate.state(trim), TrimState::Finished));
            bits(plate.result().expect("a result"))
        })
    };
    assert_eq!(made(1), made(4));
}
