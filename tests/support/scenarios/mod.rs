//! Random worlds that are edited step by step, and what each must come to: what a world that was built as
//! the last edit leaves it comes to, bit for bit; and what an oracle that does not know how trims are made
//! lets pass.

mod edits;
mod grounds;
mod judge;
#[path = "../random.rs"]
mod random;
#[path = "../seam.rs"]
mod seam;
mod shapes;
mod view;
mod world;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

pub use grounds::Grounds;
pub use random::Draw;
use world::{Live, Model};

/// What became of a scenario.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// The cage.
    pub ground: &'static str,
    /// The edits, in order.
    pub edits: Vec<String>,
    /// Trims that were made in the end.
    pub made: usize,
    /// Why others were not.
    pub refused: Vec<String>,
    /// What differs from a world that was never edited.
    pub unequal: Option<String>,
    /// What the oracle finds.
    pub wrong: Option<String>,
    /// What is still done where nothing is left to do.
    pub busy: Option<String>,
    /// What a panic said.
    pub panicked: Option<String>,
    /// How long it took.
    pub took: Duration,
}

impl Outcome {
    /// Is all well?
    pub fn is_sound(&self) -> bool {
        self.unequal.is_none() && self.wrong.is_none() && self.busy.is_none() && self.panicked.is_none()
    }
}

/// Plays one scenario.
pub fn play(grounds: &Grounds, seed: u64) -> Outcome {
    let start = Instant::now();
    let mut outcome = Outcome::default();
    let played = catch_unwind(AssertUnwindSafe(|| through(grounds, seed, &mut outcome)));
    if let Err(why) = played {
        let text = why.downcast_ref::<String>().map(String::as_str).or(why.downcast_ref::<&str>().copied());
        outcome.panicked = Some(text.unwrap_or("a panic").to_owned());
    }
    outcome.took = start.elapsed();
    outcome
}

fn through(grounds: &Grounds, seed: u64, outcome: &mut Outcome) {
    let mut draw = Draw(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x5ce_a210);
    let ground = grounds.any(&mut draw);
    outcome.ground = ground.name;
    let mut model = Model::new(ground, &mut draw);
    let trims = 1 + draw.below(3);
    for _ in 0..trims {
        model.add_trim(ground, &mut draw);
    }
    let mut live = Live::of(&model);
    let rest = |live: &mut Live, draw: &mut Draw, outcome: &mut Outcome| {
        if draw.chance(0.5) {
            outcome.edits.push("settle".into());
            outcome.busy = outcome.busy.take().or(live.settle().err());
        } else {
            let passes = draw.below(40);
            outcome.edits.push(format!("{passes} passes"));
            (0..passes).for_each(|_| live.update());
        }
    };
    for _ in 0..1 + draw.below(5) {
        rest(&mut live, &mut draw, outcome);
        outcome.edits.push(edits::edit(ground, &mut model, &mut live, &mut draw));
    }
    if let Err(busy) = live.settle().and_then(|()| live.is_at_rest()) {
        outcome.busy = outcome.busy.take().or(Some(busy));
        return;
    }
    let threads = 1 + draw.below(3);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let mut fresh = Live::of(&model);
    if let Err(busy) = pool.install(|| fresh.settle()) {
        outcome.busy = Some(format!("fresh: {busy}"));
        return;
    }
    outcome.unequal = view::differ(&mut live, &mut fresh, &model);
    (outcome.made, outcome.refused) = live.counts();
    outcome.wrong = judge::judge(ground, &mut live, &model, &mut draw);
}
