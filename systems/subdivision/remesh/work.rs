//! A remeshing as work quanta: one try lays strips, relaxes them, and makes a surface of it all; a try
//! that finds the cage too coarse somewhere asks for a finer one there, and for another try.

mod finer;

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::Curve;
use selvedge_components::subdivision::{CornerTable, LoopSurface};

use super::adapt;
use super::arrange::{self, Arrangement};
use super::assemble::Remeshed;
use super::error::RemeshError;
use super::fineness::{self, Fineness};
use super::laid::{Laid, lay};
use super::leaves::Leaves;
use super::other::{self, OtherSide};
use super::preimage::{Extent, PreImage};
use super::remove::Trouble;
use super::track::{Near, Track};
use super::winding::Beyond;
use super::{Cut, RemeshOptions};
use finer::{around, refine_all};

/// A remeshing in progress: all its dense state.
#[derive(Debug)]
pub struct RemeshWork {
    surface: Arc<LoopSurface>,
    corners: CornerTable,
    cuts: Vec<Cut>,
    preimages: Vec<PreImage>,
    options: RemeshOptions,
    /// How the surface hangs together beyond what there is of it.
    beyond: Beyond,
    /// Whose other side it is, if it is one.
    other: Option<OtherSide>,
    /// How the curves meet, once that is known.
    plan: Option<Box<Arrangement>>,
    /// How fine it has to be, whatever tries ask for.
    asked: Vec<Fineness>,
    /// The least level that is asked for, by segment of the track.
    least: Vec<u32>,
    /// The tries that were too coarse.
    tried: u32,
    /// By segment of the track, how far apart the knots are that are given there, which a strip has to be wide
    /// enough for; halved where that leaves no rim.
    lengths: Vec<f64>,
    /// How many faces the first try has split, and all after it.
    split: [u64; 2],
    /// Of these, the ones that were so for slivers alone; and the best that came of them.
    thin: (u32, Option<Thin>),
    state: State,
}

/// Where a try stands.
#[derive(Debug)]
enum State {
    /// The cage is to be adapted.
    Coarse,
    /// It is to be cut, and strips laid.
    Adapted(Box<Leaves>),
    /// The strips are to be relaxed, and all of it put together.
    Laid(Box<Laid>),
    /// No finer cage can be had: the best of those with slivers is to be taken.
    Settled(Box<Remeshed>),
}

/// A surface whose strips have slivers.
#[derive(Debug)]
struct Thin {
    /// The worst shape of a triangle of a strip: below zero if it is folded, but not on another side.
    worst: f64,
    /// Where that is.
    worst_at: Option<Near>,
    /// The least level that was asked for, by segment of the track.
    least: Vec<u32>,
    remeshed: Box<Remeshed>,
}

/// What a quantum of laying led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RemeshQuantum {
    /// There is more to do.
    More,
    /// The strips are laid; they are to be relaxed.
    Laid,
}

/// What a quantum of relaxing led to.
#[derive(Debug)]
pub enum RelaxQuantum {
    /// There is more to do.
    More,
    /// The cage is too coarse: strips are to be laid on a finer one.
    Again,
    /// All is done.
    Finished(Box<Remeshed>),
}

/// How often a cage is made finer for slivers alone: each time costs as much as all before it.
const SLIVER_TRIES: u32 = 5;

/// The same where knots are given: most of those tries make the strip wider, and nothing finer.
const GIVEN_TRIES: u32 = 12;

/// How much wider a strip becomes at a time where it is too narrow for given knots.
const WIDER: f64 = 1.5;

/// The worst shape that a triangle of a strip may have. The smallest angle allowed between curves leaves four
/// times that at the tip of a wedge.
const WORST: f64 = 0.01;

/// What is said of a cage whose strips have slivers.
const SLIVERS: &str = "too coarse for triangles of any width";

impl RemeshWork {
    /// Begins to cut `surface` along curves, whose pre-images on it are given in the order of the
    /// curves.
    ///
    /// # Errors
    /// When there is no curve, or a curve is open.
    pub fn new(
        surface: Arc<LoopSurface>,
        cuts: Vec<Cut>,
        preimages: Vec<PreImage>,
        options: RemeshOptions,
    ) -> Result<Self, RemeshError> {
        check(&cuts, &preimages)?;
        let corners = CornerTable::new(&surface);
        let (plan, least, state) = (None, Vec::new(), State::Coarse);
        Ok(Self {
            surface,
            corners,
            cuts,
            preimages,
            options,
            beyond: Beyond::default(),
            other: None,
            plan,
            asked: Vec::new(),
            least,
            lengths: Vec::new(),
            tried: 0,
            split: [0; 2],
            thin: (0, None),
            state,
        })
    }

    /// Takes the surface for a part of a larger one, of which faces hang together `beyond` it.
    #[must_use]
    pub fn within(self, beyond: Beyond) -> Self {
        Self { beyond, ..self }
    }

    /// Makes the other side of a set of curves, which are turned already.
    #[must_use]
    pub fn on_other_side(self, other: OtherSide) -> Self {
        Self { other: Some(other), ..self }
    }

    /// Asks for a cage that is so fine along the curves.
    #[must_use]
    pub fn as_fine_as(self, asked: Vec<Fineness>) -> Self {
        Self { asked, ..self }
    }

    /// How fine the cage was asked to be along its borders, by tries or before them.
    pub fn fineness(&self) -> Vec<Fineness> {
        self.plan.as_deref().map_or_else(Vec::new, |plan| fineness::of(plan, &self.cuts, &self.least))
    }

    /// Takes the next step towards strips along the curves.
    ///
    /// # Errors
    /// When the curves do not separate what stays from what goes, nothing stays, or boundaries come too
    /// near to each other.
    pub fn advance(&mut self) -> Result<RemeshQuantum, RemeshError> {
        let step = self.step();
        step.or_else(|why| self.fall_back(why).map(|()| RemeshQuantum::Laid))
    }

    /// Goes back to the best cage with slivers, if there is one, where a finer one is not to be had.
    fn fall_back(&mut self, why: RemeshError) -> Result<(), RemeshError> {
        let best = self.thin.1.take().filter(|best| best.worst >= WORST).ok_or(why)?;
        self.least = best.least;
        self.state = State::Settled(best.remeshed);
        Ok(())
    }

    /// How many faces were split over all tries: what the work so far is about proportional to.
    pub const fn faces_split(&self) -> u64 {
        self.split[0] + self.split[1]
    }

    fn step(&mut self) -> Result<RemeshQuantum, RemeshError> {
        let Some(plan) = &self.plan else {
            let junctions = &self.options.junctions;
            let (surface, cuts, images) = (&self.surface, &self.cuts, &self.preimages);
            let plan = arrange::arrange(surface, cuts, images, junctions, &self.beyond, self.other.as_ref())?;
            self.least = fineness::along(&plan, cuts, &self.asked);
            self.lengths = other::gaps(&plan, cuts);
            let finest = adapt::finest(surface, &self.options.adapt);
            for (least, level) in self.least.iter_mut().zip(other::levels(&plan, surface, &self.lengths)) {
                *least = (*least).max(level).min(finest);
            }
            self.plan = Some(Box::new(plan));
            return Ok(RemeshQuantum::More);
        };
        match core::mem::replace(&mut self.state, State::Coarse) {
            State::Coarse => {
                let options = &self.options.adapt;
                let leaves = adapt::adapt(&self.surface, &self.corners, &plan.track, options, &self.least)?;
                let split = leaves.split_count() as u64;
                self.split = if self.tried == 0 { [split, 0] } else { [self.split[0], self.split[1] + split] };
                self.state = State::Adapted(Box::new(leaves));
                Ok(RemeshQuantum::More)
            }
            State::Adapted(leaves) => {
                let finest = leaves.finest();
                match lay(&self.surface, &self.corners, &self.cuts, plan, *leaves, &self.lengths, &self.options) {
                    Ok(laid) => self.state = State::Laid(Box::new(laid)),
                    Err(trouble) => {
                        self.lengths.iter_mut().for_each(|length| *length *= 0.5);
                        self.make_finer(trouble, finest)?;
                        return Ok(RemeshQuantum::More);
                    }
                }
                Ok(RemeshQuantum::Laid)
            }
            laid @ (State::Laid(_) | State::Settled(_)) => {
                self.state = laid;
                Ok(RemeshQuantum::Laid)
            }
        }
    }

    /// Takes the next step from strips that are laid to a surface.
    ///
    /// # Errors
    /// As [`Self::advance`], and where more would change than the reach allows.
    pub fn relax(&mut self) -> Result<RelaxQuantum, RemeshError> {
        if let State::Settled(best) = &mut self.state {
            return Ok(RelaxQuantum::Finished(best.clone()));
        }
        let (State::Laid(laid), Some(plan)) = (&mut self.state, &self.plan) else { return Ok(RelaxQuantum::Again) };
        if laid.relaxed.iter().any(|relaxed| relaxed.sweeps < self.options.relax.sweeps) {
            laid.sweep(plan, &self.options);
            return Ok(RelaxQuantum::More);
        }
        let finest = laid.leaves.finest();
        let (remeshed, slivers) = match laid.finish(&self.surface, &self.cuts, plan, &self.options) {
            Ok(done) => done,
            Err(trouble) => {
                let finer = self.make_finer(trouble, finest);
                finer.or_else(|why| self.fall_back(why))?;
                return Ok(RelaxQuantum::Again);
            }
        };
        let within = |remeshed: &Remeshed| {
            let reach = self.options.reach.map_or((0.0, DVec3::ZERO), |_| remeshed.reach(&plan.track));
            (reach, self.options.reach.is_none_or(|most| reach.0 <= most))
        };
        // The knots of the other side are given: a triangle that faces the wrong way cannot be helped there.
        let (worst, worst_at) = match self.other {
            None => (slivers.worst, slivers.worst_at),
            Some(_) => (slivers.flattest, slivers.flattest_at),
        };
        let best = match self.thin.1.take() {
            Some(best) if best.worst >= worst => best,
            _ => Thin { worst, worst_at, least: self.least.clone(), remeshed: Box::new(remeshed) },
        };
        // The knots of the other side are given, and do not follow a finer cage, but the rim's edges are others
        // there.
        let helps = self.other.is_none() || best.worst < WORST;
        let most = if self.other.is_some() { GIVEN_TRIES } else { SLIVER_TRIES };
        let may = self.thin.0 < most && self.tried < self.options.tries && helps;
        let any = !(slivers.places.is_empty() && slivers.narrow.is_empty());
        if may && any && within(&best.remeshed).1 {
            self.thin = (self.thin.0 + 1, Some(best));
            for place in &slivers.narrow {
                let lengths = &mut self.lengths;
                around(&plan.track, place, |segment| {
                    let length = &mut lengths[segment as usize];
                    *length = (WIDER * *length).max(0.5 * place.size);
                });
            }
            if slivers.places.is_empty() {
                self.state = State::Coarse;
                return Ok(RelaxQuantum::Again);
            }
            let finer = self.make_finer(Trouble::TooCoarse { what: SLIVERS, places: slivers.places }, finest);
            finer.or_else(|why| self.fall_back(why))?;
            return Ok(RelaxQuantum::Again);
        }
        let ((distance, at), _) = within(&best.remeshed);
        match self.options.reach {
            Some(reach) if distance > reach => {
                refine_all(&self.surface, &mut self.options.adapt).ok_or(RemeshError::OutOfReach {
                    distance,
                    at,
                    reach,
                })?;
                (self.tried, self.thin, self.state) = (0, (0, None), State::Coarse);
                self.least.fill(0);
                Ok(RelaxQuantum::Again)
            }
            _ => match best.worst_at.filter(|_| best.worst < WORST) {
                Some(near) => Err(self.unresolved(plan, SLIVERS, near, finest)),
                None => {
                    self.least = best.least;
                    Ok(RelaxQuantum::Finished(best.remeshed))
                }
            },
        }
    }
}

fn check(cuts: &[Cut], preimages: &[PreImage]) -> Result<(), RemeshError> {
    if cuts.is_empty() || preimages.len() != cuts.len() {
        return Err(RemeshError::NoCurves);
    }
    for (curve, (cut, image)) in cuts.iter().zip(preimages).enumerate() {
        if !cut.curve.closed() && image.extent == Extent::Round {
            let gap = cut.curve.position(0.0).distance(cut.curve.position(1.0));
            return Err(RemeshError::Open { curve, gap });
        }
    }
    Ok(())
}

impl Remeshed {
    /// How far from the curves the faces of `Omega` reach, and where.
    fn reach(&self, track: &Track) -> (f64, DVec3) {
        let mesh = &self.surface.mesh;
        let mut corners: Vec<_> = self.omega.iter().flat_map(|face| mesh.face(face.root_face(0))).collect();
        corners.sort_unstable();
        corners.dedup();
        let mut farthest = (0.0, DVec3::ZERO);
        for v in corners {
            let x = self.limit[v.index()];
            let distances = track.points.iter().map(|p| p.position.distance_squared(x));
            let distance = distances.fold(f64::INFINITY, f64::min).sqrt();
            if distance > farthest.0 {
                farthest = (distance, x);
            }
        }
        farthest
    }
}
