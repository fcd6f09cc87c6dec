//! Worlds that are edited step by step come to what a world that was never edited comes to.

#[path = "support/scenarios/mod.rs"]
mod scenarios;

use scenarios::{Grounds, play};

/// Each of these has a curve, a trim or a point that comes, goes or becomes another, between passes and while
/// work is under way.
#[test]
fn edited_worlds_come_to_what_fresh_ones_do() {
    let grounds = Grounds::new();
    for seed in SEEDS {
        let outcome = play(&grounds, seed);
        assert!(outcome.is_sound(), "{seed}: {outcome:#?}");
    }
}

/// Scenarios that are quick, of every cage.
const SEEDS: [u64; 16] = [0, 2000, 2001, 2002, 2003, 2004, 2006, 2007, 2009, 2010, 2011, 2012, 2013, 2015, 2018, 2020];
