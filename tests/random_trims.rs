//! Random trims, each looked at by an oracle that does not know how they were made.

#[path = "support/sweep.rs"]
mod sweep;

use sweep::{Case, STRATA, Subjects, Verdict, oracle, run};

/// Four of each stratum: none panics, none is a false success, none has a sliver, and at most one in 64 is
/// refused.
#[test]
fn random_trims_are_sound_or_say_why() {
    let subjects = Subjects::new();
    let mut refused = Vec::new();
    for (s, stratum) in STRATA.iter().enumerate() {
        for number in 0..4 {
            let number = (s as u64) << 32 | number;
            let (verdict, _, worst_shape) = run(&Case::new(&subjects, stratum, number));
            assert!(worst_shape > 0.01, "{stratum:?} {number}: {worst_shape}");
            match verdict {
                Verdict::Sound => {}
                Verdict::Refused(why) => refused.push(format!("{stratum:?} {number}: {why}")),
                wrong => panic!("{stratum:?} {number}: {wrong:?}"),
            }
        }
    }
    assert!(refused.len() <= 1, "{refused:#?}");
}

/// Where faces are stretched beside an irregular vertex, edges of the rim point away from the curve.
#[test]
fn stretched_faces_beside_a_curve_are_not_folded() {
    let subjects = Subjects::new();
    for number in [2, 7] {
        let (verdict, _, worst_shape) = run(&Case::new(&subjects, &STRATA[11], 11 << 32 | number));
        assert_eq!(verdict, Verdict::Sound, "{number}");
        assert!(worst_shape > 0.05, "{number}: {worst_shape}");
    }
}

/// The oracle can tell: what is inside the outlines of a source that was not cut is found on it.
#[test]
fn a_source_that_was_not_cut_is_no_result() {
    let subjects = Subjects::new();
    for (s, stratum) in STRATA.iter().enumerate() {
        let case = Case::new(&subjects, stratum, (s as u64) << 32);
        let found = oracle(&case, &case.ground.surface);
        assert!(matches!(&found, Err(what) if what.ends_with("inside an outline")), "{stratum:?}: {found:?}");
    }
}
