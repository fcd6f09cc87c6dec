//! Trims that are made together: remesh, what begins their fit, and what ends it.

mod blame;
mod others;
mod report;

use std::sync::Arc;

use bevy_ecs::prelude::Component;
use selvedge_components::budget::Budgets;
use selvedge_components::subdivision::fit::{FitOptions, Outcome, Region};
use selvedge_components::subdivision::remesh::RemeshError;
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::target::{Guarded, Target};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{Omega, TrimFault, TrimOptions, TrimQuantum, TrimStage};

use super::audit::TrimAuditWork;
use super::compose::ZoneOf;
use super::ground::Ground;
use super::locate::Located;
use super::other::OtherWork;
use super::zone::Zone;
use crate::closest::Search;
use crate::subdivision::fit::FitWork;
use crate::subdivision::natural::Natural;
use crate::subdivision::region;
use crate::subdivision::remesh::{
    Cut, FaceOrigin, Fineness, JunctionOptions, PreImage, RelaxQuantum, RemeshOptions, RemeshQuantum, RemeshWork,
    Remeshed,
};

pub use blame::Blamed;

/// Trims in progress that are made together: all their dense state, but for that of their fit.
///
/// Lives as a component on the first of them while it runs. What it holds is derived: losing it
/// costs time and nothing else.
#[derive(Component, Debug)]
pub struct TrimWork {
    /// The source, or the zone of it that is worked on.
    ground: Arc<Ground>,
    members: Vec<Arc<Located>>,
    /// The faces that the trims may change, ascending.
    reserved: Vec<FaceCode>,
    /// The part of the source that is worked on; `None` before that is known, and where it is all.
    zone: Option<Arc<ZoneOf>>,
    prepared: bool,
    /// How fine the cage has to be along the curves for the other sides that are wanted.
    asked: Vec<Fineness>,
    /// The other side that is being made for that, and how many members have been asked.
    alone: (usize, Option<Box<RemeshWork>>),
    cutting: Option<Box<RemeshWork>>,
    options: TrimOptions,
    tolerance: Option<Tolerance>,
    remeshed: Option<Arc<Remeshed>>,
    /// The fit of the new cage, until it is taken.
    fit: Option<Box<FitWork>>,
    /// What may be spent.
    budgets: Budgets,
    audit: Option<TrimAuditWork>,
    /// Is the audit of what stays done?
    audited: bool,
    /// The other sides that are wanted, in the order of their trims, as far as they were begun.
    others: Vec<OtherWork>,
}

impl TrimWork {
    /// Begins to trim `ground` by the curves of all `members`, which may change the `reserved` faces.
    ///
    /// Options and tolerances of trims that are made together are the strictest of each. The members
    /// are in the order of the trims.
    pub fn new(ground: Arc<Ground>, members: Vec<Arc<Located>>, reserved: Vec<FaceCode>) -> Self {
        let options = members.iter().map(|m| m.options.clone()).reduce(|a, b| strictest_options(&a, &b));
        let tolerance = members.iter().filter_map(|m| m.tolerance).reduce(strictest_tolerance);
        let options = options.unwrap_or_default();
        Self {
            ground,
            members,
            options,
            tolerance,
            reserved,
            zone: None,
            prepared: false,
            asked: Vec::new(),
            alone: (0, None),
            cutting: None,
            remeshed: None,
            fit: None,
            budgets: Budgets::default(),
            audit: None,
            audited: false,
            others: Vec::new(),
        }
    }

    /// As [`Self::new`], with all of the source to be changed.
    pub fn on_all(ground: Arc<Ground>, members: Vec<Arc<Located>>) -> Self {
        let all = region::whole(&ground.surface.mesh, 0);
        Self::new(ground, members, all)
    }

    /// The part of the source that is worked on; `None` where that is all of it.
    pub const fn zone(&self) -> Option<&Arc<ZoneOf>> {
        self.zone.as_ref()
    }

    /// Goes on with the part of the source that the trims can touch, as if it were all.
    fn prepare(&mut self) -> Result<(), TrimFault> {
        self.prepared = true;
        let source = Arc::clone(&self.ground.surface);
        let zone = Zone::around(&source.mesh, &self.reserved);
        let Some((zone, (surface, sides))) =
            zone.and_then(|zone| Some((zone.extract(&source)?, zone)).map(|(s, z)| (z, s)))
        else {
            return Ok(());
        };
        let narrow = |located: &Arc<Located>| {
            let parts = located.parts.iter().map(|(cut, image)| Some((*cut, zone.narrow(image)?)));
            Some(Arc::new(Located { parts: parts.collect::<Option<_>>()?, ..Located::clone(located) }))
        };
        let Some(members) = self.members.iter().map(narrow).collect() else { return Ok(()) };
        self.ground = Arc::new(Ground::new(Arc::new(surface), self.ground.revision)?);
        self.members = members;
        let beyond = zone.beyond(&source.mesh, &self.ground.surface.mesh);
        self.zone = Some(Arc::new(ZoneOf { zone, sides, beyond }));
        Ok(())
    }

    /// Has the remeshing kept to the faces that are reserved? In a zone nothing else may change, and of
    /// the border what is not in it as a whole.
    pub(super) fn keeps_to_its_zone(&self, remeshed: &Remeshed) -> bool {
        let Some(zone) = &self.zone else { return true };
        let is_reserved = |face: &FaceCode| match remeshed.face_origin[face.root_face(0).index()] {
            FaceOrigin::Leaf { level, code } | FaceOrigin::Closure { level, code } => {
                let root = zone.zone.faces[code.root_face(level).index()];
                self.reserved.binary_search(&FaceCode::root(root)).is_ok()
            }
            FaceOrigin::Strip { .. } => true,
        };
        zone.keeps_partial_sides(&self.ground.surface, remeshed) && remeshed.omega.iter().all(is_reserved)
    }

    /// The source, ready to be searched.
    pub const fn ground(&self) -> &Arc<Ground> {
        &self.ground
    }

    /// The new cage, once there is one.
    pub const fn remeshed(&self) -> Option<&Arc<Remeshed>> {
        self.remeshed.as_ref()
    }

    /// The parts of all curves that lie on the source, as cuts, in the order of the trims.
    pub fn parts(&self) -> impl Iterator<Item = (&Cut, &PreImage)> {
        self.members.iter().flat_map(|m| m.parts.iter().map(|(cut, part)| (&m.cuts[*cut], part)))
    }

    /// For each of [`Self::parts`] the trim and its curve, by index.
    fn owners(&self) -> Vec<(usize, usize)> {
        let members = self.members.iter().enumerate();
        members.flat_map(|(trim, m)| m.parts.iter().map(move |&(cut, _)| (trim, cut))).collect()
    }

    /// Works the curves into the cage, as far as one quantum goes; [`TrimStage::Relax`] is next. The
    /// first quantum takes the part of the source that this can touch.
    ///
    /// # Errors
    /// As [`RemeshWork::advance`].
    pub fn remesh(&mut self) -> Result<TrimQuantum, Blamed> {
        if !self.prepared {
            self.prepare().map_err(|why| self.newest(why))?;
            return Ok(TrimQuantum::More);
        }
        let mut cutting = match self.cutting.take() {
            Some(cutting) => cutting,
            None if self.ask_other_sides() => return Ok(TrimQuantum::More),
            None => Box::new(self.begin_cutting().map_err(|why| self.blame(why))?),
        };
        let step = cutting.advance().map_err(|why| self.blame(why))?;
        self.cutting = Some(cutting);
        Ok(match step {
            RemeshQuantum::More => TrimQuantum::More,
            RemeshQuantum::Laid => TrimQuantum::Next(TrimStage::Relax),
        })
    }

    fn begin_cutting(&self) -> Result<RemeshWork, RemeshError> {
        let (cuts, images) = self.cuts();
        let options = self.remesh_options();
        let cutting = RemeshWork::new(Arc::clone(&self.ground.surface), cuts, images, options)?;
        let cutting = cutting.as_fine_as(self.asked.clone());
        Ok(match &self.zone {
            Some(zone) => cutting.within(zone.beyond.clone()),
            None => cutting,
        })
    }

    /// Lets the new vertices settle, and begins the fit of the new cage, which [`Self::take_fit`] hands
    /// on. Where the cage is too coarse [`TrimStage::Remesh`] is next; where the part of the source turns
    /// out too small, [`TrimQuantum::Widen`] says so.
    ///
    /// # Errors
    /// As [`RemeshWork::relax`] and [`FitWork::new`].
    pub fn relax(&mut self, budgets: &Budgets) -> Result<TrimQuantum, Blamed> {
        let Some(mut cutting) = self.cutting.take() else { return Ok(TrimQuantum::Next(TrimStage::Remesh)) };
        let remeshed = match cutting.relax().map_err(|why| self.blame(why))? {
            RelaxQuantum::Finished(remeshed) => *remeshed,
            RelaxQuantum::More => {
                self.cutting = Some(cutting);
                return Ok(TrimQuantum::More);
            }
            RelaxQuantum::Again => {
                self.cutting = Some(cutting);
                return Ok(TrimQuantum::Next(TrimStage::Remesh));
            }
        };
        if !self.keeps_to_its_zone(&remeshed) {
            return Ok(TrimQuantum::Widen);
        }
        self.asked = cutting.fineness();
        self.budgets = *budgets;
        self.fit = Some(Box::new(self.fit_of(&remeshed).map_err(|why| self.newest(why))?));
        self.remeshed = Some(Arc::new(remeshed));
        Ok(TrimQuantum::Next(TrimStage::Fit))
    }

    /// All parts as cuts, each of the set of its trim: what stays is what every trim leaves.
    pub(super) fn cuts(&self) -> (Vec<Cut>, Vec<PreImage>) {
        let parts = self.owners().into_iter().zip(self.parts());
        parts.map(|((trim, _), (cut, image))| (cut.of_set(trim as u32), image.clone())).unzip()
    }

    pub(super) fn remesh_options(&self) -> RemeshOptions {
        let junctions = self.tolerance.map_or_else(JunctionOptions::default, |t| JunctionOptions::within(t.fit));
        let TrimOptions { omega, reach, .. } = self.options;
        RemeshOptions { omega, reach, junctions, ..RemeshOptions::default() }
    }

    /// Begins the fit of a new cage to the limit surface of its source.
    pub(super) fn fit_of(&self, remeshed: &Remeshed) -> Result<FitWork, TrimFault> {
        let target: Arc<dyn Target> = Arc::new(self.ground.target(Search::AroundHint));
        let guarded = Arc::new(Guarded::new(target, self.budgets));
        let options = fit_options(&self.options, self.tolerance.as_ref(), &self.budgets, remeshed.omega.clone());
        let natural = Natural::new(&remeshed.surface.mesh, remeshed.natural.clone(), |f| remeshed.on_one_face(f));
        Ok(FitWork::new(Arc::new(remeshed.surface.clone()), guarded, options)?.with_natural(natural))
    }

    /// Begins the audit of `surface`, the fitted form of `remeshed`.
    pub(super) fn audit_of(
        &self,
        remeshed: Arc<Remeshed>,
        surface: Arc<LoopSurface>,
    ) -> Result<TrimAuditWork, TrimFault> {
        let (ground, limit) = (Arc::clone(&self.ground), self.tolerance.map(|t| t.fit));
        TrimAuditWork::new(ground, remeshed, surface, limit, &self.options)
    }

    /// The fit that remeshing has begun; it is not ours any more.
    pub fn take_fit(&mut self) -> Option<FitWork> {
        self.fit.take().map(|fit| *fit)
    }

    /// Runs one work quantum of the audit of `fit`, which is done.
    ///
    /// # Errors
    /// [`TrimFault::Audit`] with everything that is wrong; [`TrimFault::Unevaluated`].
    pub fn audit(&mut self, fit: &FitWork) -> Result<TrimQuantum, Blamed> {
        let Some(audit) = &mut self.audit else {
            let Some(remeshed) = self.remeshed.clone() else { return Ok(TrimQuantum::Finished) };
            let surface = Arc::new(LoopSurface { details: fit.details().clone(), ..remeshed.surface.clone() });
            let audit = self.audit_of(remeshed, surface);
            self.audit = Some(audit.map_err(|why| self.newest(why))?);
            return Ok(TrimQuantum::More);
        };
        if self.audited {
            return self.advance_others();
        }
        let step = audit.advance().map_err(|why| self.nearest(why))?;
        self.audited = step == TrimQuantum::Finished;
        Ok(if self.audited && self.next_other().is_some() { TrimQuantum::More } else { step })
    }

    /// What is left of the source, once the audit has begun.
    pub fn result(&self) -> Option<&Arc<LoopSurface>> {
        self.audit.as_ref().map(TrimAuditWork::surface)
    }

    /// Runs all stages to the end: what a host without a schedule does.
    ///
    /// # Errors
    /// As the stages do, [`TrimFault::NotReached`] when the fit ends above its tolerance.
    pub fn run(&mut self, budgets: &Budgets) -> Result<FitWork, Blamed> {
        let (given, members) = (Arc::clone(&self.ground), self.members.clone());
        match self.run_once(budgets) {
            Err(blamed) if self.may_fit_more(&blamed.why) => {
                let mut wider = Self::new(given, members, core::mem::take(&mut self.reserved));
                wider.options.omega = Omega::Neighbourhood;
                *self = wider;
                self.run_once(budgets)
            }
            done => done,
        }
    }

    /// Has a fit failed for want of faces that it may change, where more are to be had?
    pub fn may_fit_more(&self, why: &TrimFault) -> bool {
        let why = if let TrimFault::OtherSide { why } = why { why } else { why };
        let TrimFault::NotReached { outcome } = why else { return false };
        let short = matches!(outcome, Outcome::OutOfReach { .. } | Outcome::Stalled { .. });
        short && self.options.omega == Omega::Changed
    }

    fn run_once(&mut self, budgets: &Budgets) -> Result<FitWork, Blamed> {
        let (given, members) = (Arc::clone(&self.ground), self.members.clone());
        let mut stage = TrimStage::Remesh;
        while stage != TrimStage::Fit {
            match if stage == TrimStage::Relax { self.relax(budgets)? } else { self.remesh()? } {
                TrimQuantum::Next(next) => stage = next,
                TrimQuantum::Widen => {
                    let omega = self.options.omega;
                    *self = Self::on_all(Arc::clone(&given), members.clone());
                    self.options.omega = omega;
                    stage = TrimStage::Remesh;
                }
                TrimQuantum::More | TrimQuantum::Finished => {}
            }
        }
        // Remeshing has just begun a fit.
        let Some(mut fit) = self.take_fit() else { return Err(self.newest(RemeshError::NoCurves.into())) };
        match fit.run().map_err(|why| self.newest(why.into()))? {
            Outcome::Within => {}
            outcome => return Err(self.nearest(TrimFault::NotReached { outcome })),
        }
        while self.audit(&fit)? == TrimQuantum::More {}
        Ok(fit)
    }
}

fn strictest_tolerance(a: Tolerance, b: Tolerance) -> Tolerance {
    Tolerance { fit: a.fit.min(b.fit), chord: a.chord.min(b.chord), curve: a.curve.min(b.curve) }
}

fn strictest_options(a: &TrimOptions, b: &TrimOptions) -> TrimOptions {
    let reach = a.reach.into_iter().chain(b.reach).reduce(f64::min);
    let (last_level, samples) = (a.last_level.max(b.last_level), a.samples.max(b.samples));
    // What one of them may fit, all may.
    let omega = if a.omega == b.omega { a.omega } else { Omega::Neighbourhood };
    TrimOptions { last_level, samples, omega, reach, ..a.clone() }
}

/// Levels leave a quarter of the error or less, but where patches fail beside others that may not move.
/// Those are closed in on by half-size steps, each of which leaves about half: freeing the others is cheaper.
const STALLED: f64 = 0.4;

/// How the cage that trims leave is fitted: over `omega`, and nowhere else.
pub fn fit_options(
    options: &TrimOptions,
    tolerance: Option<&Tolerance>,
    budgets: &Budgets,
    omega: Vec<FaceCode>,
) -> FitOptions {
    FitOptions {
        rule: options.rule,
        tolerance: tolerance.map(|t| t.fit),
        last_level: options.last_level,
        region: Region::Faces(omega),
        stalled_at: (options.omega == Omega::Changed).then_some(STALLED),
        storage: options.storage,
        most_details: usize::try_from(budgets.details).unwrap_or(usize::MAX),
    }
}
