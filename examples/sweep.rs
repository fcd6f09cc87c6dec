//! You will see a table: random trims by stratum, how many were made, refused or wrong, and why;
//! how long the slowest took, and the worst shape of a face that was made.
//!
//! `sweep [COUNT] [--from STRATUM] [--json]`: `COUNT` trims in all, 1000 unless told; few with `--json`,
//! which prints rows. With `--from`, the strata before that one, counted from 0, are left out.

#[macro_use]
#[path = "../engine/cli/say.rs"]
mod say;

#[path = "../tests/support/sweep.rs"]
mod sweep;

use std::collections::BTreeMap;
use std::time::Duration;

use serde::Serialize;
use sweep::{Case, STRATA, Subjects, Verdict, run};

#[derive(Default, Serialize)]
struct Row {
    stratum: String,
    cases: usize,
    sound: usize,
    refused: usize,
    false_successes: usize,
    panics: usize,
    slowest_s: f64,
    /// The worst shape, twice the area over the longest edge squared, of a face that a trim has made.
    worst_shape: Option<f64>,
    reasons: BTreeMap<String, usize>,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let json = args.iter().any(|a| a == "--json");
    let number = |a: Option<&String>| a.map(|a| a.parse::<usize>()).transpose();
    let count = number(args.first().filter(|a| !a.starts_with("--")))?;
    let from = number(args.iter().skip_while(|a| *a != "--from").nth(1))?.unwrap_or(0);
    let count = count.unwrap_or(if json { 32 } else { 1000 });
    let subjects = Subjects::new();
    let mut rows = Vec::new();
    for (s, stratum) in STRATA.iter().enumerate().skip(from) {
        let cases = (count * (s + 1)).div_ceil(STRATA.len()) - (count * s).div_ceil(STRATA.len());
        let name = format!("{} {:?} {:?} {:?}", stratum.subject, stratum.shape, stratum.place, stratum.sizes);
        let mut row = Row { stratum: name, cases, ..Row::default() };
        let mut slowest = Duration::ZERO;
        for number in 0..cases as u64 {
            let number = (s as u64) << 32 | number;
            let (verdict, took, worst_shape) = run(&Case::new(&subjects, stratum, number));
            slowest = slowest.max(took);
            let made = Some(worst_shape).filter(|shape| shape.is_finite());
            row.worst_shape = row.worst_shape.into_iter().chain(made).reduce(f64::min);
            let reason = match verdict {
                Verdict::Sound => {
                    row.sound += 1;
                    continue;
                }
                Verdict::Refused(why) => {
                    row.refused += 1;
                    format!("{number}: {why}")
                }
                Verdict::FalseSuccess(what) => {
                    row.false_successes += 1;
                    format!("{number}: WRONG: {what}")
                }
                Verdict::Panicked => {
                    row.panics += 1;
                    format!("{number}: PANIC")
                }
            };
            *row.reasons.entry(reason).or_default() += 1;
        }
        row.slowest_s = slowest.as_secs_f64();
        if !json {
            say!(
                "{:48} {:4} cases  {:4} sound  {:3} refused  {:3} wrong  {:3} panics  slowest {:.2} s  worst shape {:.3}",
                row.stratum,
                row.cases,
                row.sound,
                row.refused,
                row.false_successes,
                row.panics,
                row.slowest_s,
                row.worst_shape.unwrap_or(f64::NAN)
            );
            row.reasons.keys().for_each(|why| say!("    {why}"));
        }
        rows.push(row);
    }
    if json {
        say!("{}", serde_json::to_string(&rows)?);
    }
    Ok(())
}
