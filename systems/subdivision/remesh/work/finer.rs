//! What a try that was too coarse asks of the next one.

use selvedge_components::subdivision::{LoopSurface, NONE};

use super::super::adapt::{self, AdaptOptions};
use super::super::arrange::Arrangement;
use super::super::error::RemeshError;
use super::super::remove::{Place, Trouble};
use super::super::track::{Near, Track};
use super::{RemeshWork, State};

/// How many faces may be split over all tries but the first: a second or two of work. Where boundaries do not
/// come apart for less, they touch ...
const MOST_SPLIT: u64 = 1 << 16;

/// ... and this many times as many as the first try has split: each try may double them.
const MOST_TIMES: u64 = 16;

impl RemeshWork {
    /// Asks for a finer cage where one has been too coarse, whose finest level is given.
    pub(super) fn make_finer(&mut self, trouble: Trouble, finest: u32) -> Result<(), RemeshError> {
        self.state = State::Coarse;
        let (what, places) = match trouble {
            Trouble::Error(why) => return Err(why),
            Trouble::TooCoarse { what, places } => (what, places),
        };
        let Some(plan) = &self.plan else { return Ok(()) };
        let track = &plan.track;
        let [first, after] = self.split;
        if (self.tried == self.options.tries || after > MOST_SPLIT + MOST_TIMES * first)
            && let Some(first) = places.first()
        {
            return Err(self.unresolved(plan, what, first.near, finest));
        }
        self.tried += 1;
        let before = self.least.clone();
        places.iter().for_each(|place| ask_for_finer(track, place, place.level + 1, &mut self.least));
        if self.least == before {
            // What was asked for before has come, and has gone with what was cut: the next try would be
            // this one over again.
            let asked = |place: &Place| before[place.near.segment as usize] + 1;
            places.iter().for_each(|place| ask_for_finer(track, place, asked(place), &mut self.least));
        }
        let limit = adapt::finest(&self.surface, &self.options.adapt);
        match places.first() {
            Some(first) if self.least.iter().any(|&level| level > limit) => {
                Err(self.unresolved(plan, what, first.near, finest))
            }
            _ => Ok(()),
        }
    }

    /// No finer cage can be had, or none has helped.
    pub(super) fn unresolved(&self, plan: &Arrangement, what: &'static str, near: Near, level: u32) -> RemeshError {
        let contour = &plan.contours[plan.track.points[near.segment as usize].cut as usize];
        let spot = contour.spot(&self.cuts, plan.track.parameter(near));
        // The end of one stretch is the beginning of the next, which is another curve's.
        let (u, curve) = (spot.u, contour.spans[spot.span as usize].cut as usize);
        let at = self.cuts[curve].curve.position(u);
        RemeshError::Unresolved { what, curve, u, at, tries: self.tried, level }
    }
}

/// Brings the whole cage a level further; `None` if it may not become finer.
///
/// Each level of the whole cage halves the reach. Details finer than its level would have no place on
/// the new cage, so it is at least as fine as they are.
pub(super) fn refine_all(surface: &LoopSurface, options: &mut AdaptOptions) -> Option<()> {
    options.base = (options.base + 1).max(surface.details.depth().saturating_sub(1));
    let faces = (surface.mesh.face_count() as u64).checked_shl(2 * options.base)?;
    (options.base <= options.finest && faces <= options.most_faces as u64).then_some(())
}

/// How far along the curve to either side of a place that is too coarse the cage is refined, in sizes
/// of its triangles there: as far as the triangles around its neighbours reach.
const ASIDE: f64 = 3.0;

/// Asks for level `wanted` along the curve near `place`.
fn ask_for_finer(track: &Track, place: &Place, wanted: u32, least: &mut [u32]) {
    around(track, place, |segment| least[segment as usize] = least[segment as usize].max(wanted));
}

/// The segments along the curve near `place`; the one there may come twice.
pub(super) fn around(track: &Track, place: &Place, mut each: impl FnMut(u32)) {
    let cut = track.points[place.near.segment as usize].cut;
    let whole = track.tracks[cut as usize];
    let from = track.along(place.near);
    for (sign, reach) in [(1.0, ASIDE * place.size), (-1.0, ASIDE * place.size)] {
        let mut at = place.near.segment;
        for _ in 0..whole.count {
            each(at);
            let far = (track.points[at as usize].along - from) * sign;
            let far = if whole.closed { far - (far / whole.length).floor() * whole.length } else { far };
            let next = if sign > 0.0 { track.points[at as usize].next } else { track.points[at as usize].previous };
            let is_segment = next != NONE && track.points[next as usize].next != NONE;
            if !is_segment || (far > reach && at != place.near.segment) {
                break;
            }
            at = next;
        }
    }
}
