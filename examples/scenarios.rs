//! You will see a table: random worlds, edited step by step, and whether each has come to what a world
//! that was never edited comes to.
//!
//! `scenarios [COUNT] [SEED] [--json]`: `COUNT` scenarios, 200 unless told, from number `SEED` on; few with
//! `--json`, which prints one row each.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

#[path = "../tests/support/scenarios/mod.rs"]
mod scenarios;

use std::collections::BTreeMap;
use std::time::Duration;

use scenarios::{Grounds, Outcome, play};
use serde_json::{Value, json};

#[derive(Default)]
struct Table {
    sound: usize,
    classes: BTreeMap<&'static str, usize>,
    made: usize,
    refused: BTreeMap<String, usize>,
    slowest: (Duration, u64),
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (flags, numbers): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|arg| arg.starts_with("--"));
    let json = flags.iter().any(|flag| flag == "--json");
    let number = |k: usize| numbers.get(k).map(|text| text.parse::<u64>()).transpose();
    let (count, first) = (number(0)?.unwrap_or(if json { 8 } else { 200 }), number(1)?.unwrap_or(0));
    let grounds = Grounds::new();
    let (mut table, mut rows) = (Table::default(), Vec::new());
    for seed in first..first + count {
        let outcome = play(&grounds, seed);
        if json {
            rows.push(row(seed, &outcome));
        } else if !outcome.is_sound() || count == 1 {
            say!("{seed} {} {:?}", outcome.ground, outcome.edits);
            table.faults(&outcome).iter().for_each(|(class, what)| say!("    {}: {what}", class.to_uppercase()));
        }
        table.add(seed, outcome);
    }
    if json {
        say!("{}", Value::from(rows));
        return Ok(());
    }
    say!("{count} scenarios, {} sound; {} trims made", table.sound, table.made);
    table.classes.iter().for_each(|(class, count)| say!("{count:6} {class}"));
    table.refused.iter().for_each(|(why, count)| say!("{count:6} refused: {why}"));
    say!("slowest: {:.2} s, number {}", table.slowest.0.as_secs_f64(), table.slowest.1);
    Ok(())
}

impl Table {
    fn faults<'a>(&self, outcome: &'a Outcome) -> Vec<(&'static str, &'a String)> {
        let all = [
            ("unequal", &outcome.unequal),
            ("wrong", &outcome.wrong),
            ("busy", &outcome.busy),
            ("panicked", &outcome.panicked),
        ];
        all.into_iter().filter_map(|(class, what)| Some((class, what.as_ref()?))).collect()
    }

    fn add(&mut self, seed: u64, outcome: Outcome) {
        self.sound += usize::from(outcome.is_sound());
        let classes: Vec<_> = self.faults(&outcome).iter().map(|fault| fault.0).collect();
        classes.into_iter().for_each(|class| *self.classes.entry(class).or_default() += 1);
        self.made += outcome.made;
        self.slowest = self.slowest.max((outcome.took, seed));
        outcome.refused.into_iter().for_each(|why| *self.refused.entry(why).or_default() += 1);
    }
}

fn row(seed: u64, outcome: &Outcome) -> Value {
    json!({
        "number": seed,
        "ground": outcome.ground,
        "edits": outcome.edits,
        "made": outcome.made,
        "refused": outcome.refused,
        "unequal": outcome.unequal,
        "wrong": outcome.wrong,
        "busy": outcome.busy,
        "panicked": outcome.panicked,
        "seconds": outcome.took.as_secs_f64(),
    })
}
