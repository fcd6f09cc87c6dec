//! # Refine: measure, and open the next level where it is needed
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the level's state, the target | the rung of the ladder, the next level | modify | correspond |
//!
//! The seed tests a patch at its vertices after one subdivision, which is blind to an error between
//! points that were fitted; here it is the 15 points after two. All patches that the level could
//! influence are tested, those that had passed before too.

use glam::DVec3;
use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::{FaceCode, LimitRows};

use super::chain::Level;
use super::fit::{FitError, FitWork, Outcome, Quantum, Region, Rung, Stage, within};
use super::open::{OpenLevel, Opening, keep};
use super::region;
use crate::parallel::{map_dear_in_order, map_in_order};

/// Closest points per work quantum.
const QUANTUM: usize = 4096;

/// Points that are measured together.
const PART: usize = 64;

/// The true maximum may exceed the one over 15 points by some 5 to 10 %: patches pass below this
/// part of the tolerance.
pub const MARGIN: f64 = 0.85;

/// Where details can move what is too far off, a level leaves at most `lambda^2` of it, 0.39 at the
/// highest valences. Two levels in a row that each leave more than this part of it have come to an end.
const SLOW: f64 = 0.9;

impl FitWork {
    /// Opens the next level, step by step, or measures the next points of the one that is open; all of
    /// them measured, the next level is begun, or the fit is finished.
    ///
    /// # Errors
    /// When the target has no answer, or the next level would pass the budget.
    pub fn refine(&mut self) -> Result<Quantum, FitError> {
        if let Some(opening) = &mut self.opening {
            let Some(next) = opening.advance(&self.remembering, &self.corners, &self.details) else {
                return Ok(Quantum::More);
            };
            self.opening = None;
            return self.take_level(next);
        }
        if self.ladder.last().is_some_and(|rung| rung.level == self.open.level) {
            return Ok(self.open_next());
        }
        let open = &mut self.open;
        let begin = open.distances.len();
        let end = open.tested.len().min(begin + QUANTUM);
        let (surface, corners, target, natural) = (&self.remembering, &self.corners, &self.target, &self.natural);
        let Level { mesh, state } = &open.levels[2];
        let parts = map_dear_in_order((end - begin).div_ceil(PART), |i| {
            let part = begin + i * PART..end.min(begin + (i + 1) * PART);
            let points = LimitRows::points(surface, corners, mesh, state, &open.tested[part.clone()]);
            let found = points.into_iter().zip(part).map(|(x, row)| {
                let natural = || natural.place(&surface.mesh, mesh, open.tested[row]);
                let hint = open.test_hints.get(row).copied().unwrap_or_else(natural);
                Ok((x, target.closest(x, hint)?))
            });
            found.collect::<Result<Vec<_>, _>>()
        });
        for part in parts {
            for (x, foot) in part.map_err(FitError::Target)? {
                keep(&mut open.test_hints, open.distances.len(), foot.at);
                open.distances.push(foot.position.distance(x));
                open.measured.push(x);
            }
        }
        if end < open.tested.len() {
            return Ok(Quantum::More);
        }
        self.judge()
    }

    /// All points of the level are measured: what now?
    fn judge(&mut self) -> Result<Quantum, FitError> {
        self.open.errors = self.open.patch_errors();
        let patches = &self.open.errors;
        let begun = self.initial.is_some();
        let rung = self.rung(patches);
        if !begun {
            self.initial = Some(rung);
            // The surface as it was given: go on to fit level 0 unless it is good enough.
            if self.options.tolerance.is_some_and(|t| rung.max <= MARGIN * t) {
                return Ok(self.finish(Outcome::Within));
            }
            return Ok(self.go_to(Stage::Correspond));
        }
        self.ladder.push(rung);
        if self.is_stuck() {
            self.unreachable = larger(self.unreachable, (rung.max_here, rung.max_at));
            return Ok(self.finish(self.judgement((rung.max, rung.max_at))));
        }
        let spent = self.open.level == self.options.last_level;
        let known = self.watched(self.open.level + 1).is_empty();
        if spent || (known && patches.iter().all(|p| p.1 <= self.limit())) {
            return Ok(self.finish(self.judgement((rung.max, rung.max_at))));
        }
        if self.is_stalled() {
            return Ok(self.finish(Outcome::Stalled { achieved: rung.max, at: rung.max_at }));
        }
        // A quantum of its own opens the next level; until then the rung can be looked at.
        Ok(Quantum::More)
    }

    /// Have the last two levels each left too much of what the one before it had left?
    fn is_stalled(&self) -> bool {
        self.options.stalled_at.is_some_and(|share| self.leaves_more_than(share, |rung| rung.max))
    }

    /// Where details were there before, a level may show what none before it could: that says nothing.
    fn leaves_more_than(&self, share: f64, of: impl Fn(&Rung) -> f64) -> bool {
        let [.., a, b, c] = &self.ladder[..] else { return false };
        b.level as usize > self.watched.len() && of(b) > share * of(a) && of(c) > share * of(b)
    }

    /// The error at which a patch is not good enough.
    fn limit(&self) -> f64 {
        self.options.tolerance.map_or(-1.0, |t| MARGIN * t)
    }

    /// Is something too far off that no level brings nearer? Next to faces that nothing may move each
    /// level doubles its details along them and leaves what those faces are off.
    fn is_stuck(&self) -> bool {
        let fails = |rung: &Rung| self.options.tolerance.is_some() && rung.max_here > self.limit();
        matches!(self.options.region, Region::Faces(_))
            && self.ladder.last().is_some_and(fails)
            && self.leaves_more_than(SLOW, |rung| rung.max_here)
    }

    fn judgement(&self, (achieved, at): (f64, DVec3)) -> Outcome {
        match self.options.tolerance {
            Some(tolerance) if achieved > tolerance => {
                if self.unreachable.0 > tolerance {
                    Outcome::OutOfReach { achieved, at }
                } else {
                    Outcome::LevelsSpent { achieved, at }
                }
            }
            _ => Outcome::Within,
        }
    }

    /// Begins to open the level after this one.
    fn open_next(&mut self) -> Quantum {
        let failing: Vec<FaceCode> = self.open.errors.iter().filter(|p| p.1 > self.limit()).map(|p| p.0).collect();
        let level = self.open.level + 1;
        let faces = within(&self.options.region, &self.remembering, level, region::children(&failing));
        self.opening = Some(Opening::new(level, faces, self.watched(level).to_vec()));
        Quantum::More
    }

    /// The patches of a level that are measured in any case, for details that were there before.
    fn watched(&self, level: u32) -> &[FaceCode] {
        self.watched.get(level.wrapping_sub(1) as usize).map_or(&[], Vec::as_slice)
    }

    /// Goes on with a level that has been opened.
    fn take_level(&mut self, mut next: OpenLevel) -> Result<Quantum, FitError> {
        next.allow(&self.remembering, &self.options.region);
        if self.initial.is_none() {
            for (v, &at) in next.levels[0].state.effective.iter().enumerate() {
                if !at.is_finite() {
                    return Err(FitError::NotFinite { vertex: VertexId::new(v), at });
                }
            }
            // The surface as it was given is measured first.
            self.open = next;
            return Ok(Quantum::More);
        }
        let (level, patches) = (next.level, &self.open.errors);
        if next.movable.is_empty() && self.watched(level).is_empty() {
            self.unreachable = worst(patches.iter());
            let all = larger(self.unreachable, self.settled);
            return Ok(self.finish(self.judgement(all)));
        }
        let details = self.details.count() + next.movable.len();
        if details > self.options.most_details {
            return Err(FitError::TooManyDetails { level, details, limit: self.options.most_details });
        }
        // What the next level cannot influence keeps the error it has.
        let left = patches.iter().filter(|p| !(0..4).all(|c| next.influenced.binary_search(&p.0.child(c)).is_ok()));
        let left = worst(left);
        if self.options.tolerance.is_some_and(|t| left.0 > t) {
            self.unreachable = larger(self.unreachable, left);
        }
        self.settled = larger(self.settled, left);
        self.open = next;
        // With nothing to move there is only to measure.
        Ok(if self.open.movable.is_empty() { Quantum::More } else { self.go_to(Stage::Correspond) })
    }

    fn rung(&self, patches: &[(FaceCode, f64, DVec3)]) -> Rung {
        let open = &self.open;
        let here = worst(patches.iter());
        let (max, max_at) = larger(here, self.settled);
        let samples = open.distances.len();
        Rung {
            level: open.level,
            max,
            max_at,
            max_here: here.0,
            mean: open.distances.iter().sum::<f64>() / samples.max(1) as f64,
            details: self.details.count(),
            active: open.movable.len(),
            samples,
        }
    }

    fn finish(&mut self, outcome: Outcome) -> Quantum {
        self.outcome = Some(outcome);
        Quantum::Finished
    }
}

impl OpenLevel {
    /// The greatest distance over each influenced patch, and where.
    fn patch_errors(&self) -> Vec<(FaceCode, f64, DVec3)> {
        let mesh = &self.levels[2].mesh;
        let mut row_of = vec![usize::MAX; mesh.vertices.len()];
        self.tested.iter().enumerate().for_each(|(row, &v)| row_of[v as usize] = row);
        map_in_order(self.influenced.len(), |i| {
            let patch = self.influenced[i];
            let first = mesh.codes.partition_point(|code| code.0 >> 4 < patch.0);
            let faces = mesh.codes[first..].iter().zip(&mesh.corners[first..]);
            let corners = faces.take_while(|(code, _)| code.0 >> 4 == patch.0).flat_map(|(_, corners)| corners);
            // On given borders nothing is measured: the surface is the curve there.
            let rows = corners.map(|&v| row_of[v as usize]).filter(|&row| row != usize::MAX);
            let found = rows.map(|row| (self.distances[row], self.measured[row]));
            let (error, at) = found.fold((0.0, DVec3::ZERO), larger);
            (patch, error, at)
        })
    }
}

fn worst<'a>(patches: impl Iterator<Item = &'a (FaceCode, f64, DVec3)>) -> (f64, DVec3) {
    patches.fold((0.0, DVec3::ZERO), |worst, p| larger(worst, (p.1, p.2)))
}

/// The larger; the first where both are the same.
fn larger(a: (f64, DVec3), b: (f64, DVec3)) -> (f64, DVec3) {
    if b.0 > a.0 { b } else { a }
}
