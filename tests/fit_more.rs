//! A trim whose tolerance is not met over the faces that it changes is fitted over their neighbours too.

mod support;
#[path = "support/sweep.rs"]
mod sweep;

use std::sync::Arc;

use selvedge::budget::Budgets;
use selvedge::subdivision::LoopSurface;
use selvedge::trim::{Omega, TrimOptions};
use selvedge::{spawn_curve, spawn_trim};
use selvedge_systems::subdivision::trim::{LocateWork, TrimWork};
use support::plate::Plate;
use support::world::bits;
use sweep::{Case, STRATA, Subjects, Verdict, run};

/// Bores in spot that the faces they change alone cannot be fitted to, or not soon.
const BORES: [u64; 2] = [10 << 32 | 2, 10 << 32 | 25];

fn case(number: u64) -> Case {
    Case::new(&Subjects::new(), &STRATA[(number >> 32) as usize], number)
}

fn with(omega: Omega) -> TrimOptions {
    TrimOptions { omega, ..TrimOptions::default() }
}

fn by_hand(case: &Case, omega: Omega) -> Arc<LoopSurface> {
    let located = LocateWork::new(Arc::clone(&case.ground), case.cuts.clone(), with(omega), Some(case.tolerance));
    let located = located.and_then(|mut work| work.run()).expect("curves on spot");
    let mut work = TrimWork::on_all(Arc::clone(&case.ground), vec![located]);
    if let Err(why) = work.run(&Budgets::default()) {
        panic!("{omega:?}: {why}");
    }
    Arc::clone(work.result().expect("an audited result"))
}

/// The result of a world, and the greatest distance that its audit has found.
fn in_a_world(case: &Case, omega: Omega) -> (LoopSurface, f64) {
    let mut plate = Plate::of(LoopSurface::clone(&case.ground.surface));
    let cuts: Vec<_> =
        case.cuts.iter().map(|cut| (spawn_curve(&mut plate.world, Arc::clone(&cut.curve)), cut.heading)).collect();
    let trim = spawn_trim(&mut plate.world, plate.source, &cuts, Some(case.tolerance), with(omega));
    plate.settle();
    let off = plate.report(trim).audit.greatest().0;
    (plate.result().expect("a result").clone(), off)
}

#[test]
fn bores_that_their_own_faces_cannot_be_fitted_to_are_sound_with_their_neighbours() {
    for number in BORES {
        let verdict = run(&case(number)).0;
        assert_eq!(verdict, Verdict::Sound, "{number}");
    }
}

#[test]
fn what_is_fitted_again_is_what_fitting_the_neighbours_at_once_makes() {
    let case = case(BORES[0]);
    let (again, at_once) = (by_hand(&case, Omega::Changed), by_hand(&case, Omega::Neighbourhood));
    assert!(bits(&again) == bits(&at_once), "the same bits");
    // A world works in a part of the source, where sums have another order.
    let (result, off) = in_a_world(&case, Omega::Changed);
    assert!(off <= case.tolerance.fit, "{off}");
    assert_eq!(result.mesh.faces(), at_once.mesh.faces());
    assert_eq!(result.details.count(), at_once.details.count());
}

/// A bore beside one that needs its neighbours is made together with that, and so fitted over them too; by
/// itself it is what it would be if it had always been.
#[test]
fn what_a_trim_needed_together_with_another_goes_with_that() {
    let (easy, hard) = (case(10 << 32 | 1), case(BORES[0]));
    let run = |cases: &[&Case]| {
        let mut plate = Plate::of(LoopSurface::clone(&hard.ground.surface));
        let mut trims = Vec::new();
        for case in cases {
            let cut = &case.cuts[0];
            let cut = (spawn_curve(&mut plate.world, Arc::clone(&cut.curve)), cut.heading);
            let tolerance = Some(case.tolerance);
            trims.push(spawn_trim(&mut plate.world, plate.source, &[cut], tolerance, TrimOptions::default()));
        }
        plate.settle();
        (plate, trims)
    };
    let (alone, _) = run(&[&easy]);
    let (mut parted, trims) = run(&[&easy, &hard]);
    assert_eq!(parted.report(trims[0]).together, trims);
    parted.world.despawn(trims[1]);
    parted.settle();
    assert!(parted.result().map(bits) == alone.result().map(bits), "the same bits");
}
