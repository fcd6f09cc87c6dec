//! Trims that are made together: locate, remesh, and what begins and ends their fit.

use std::sync::Arc;

use bevy_ecs::prelude::Component;
use selvedge_components::budget::Budgets;
use selvedge_components::curve::Curve;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::fit::{FitOptions, Outcome, Region};
use selvedge_components::subdivision::remesh::RemeshError;
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::target::{Guarded, Target};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{TrimFault, TrimOptions, TrimQuantum, TrimReport, TrimStage, TrimmedCage};

use super::audit::TrimAuditWork;
use super::ground::{Ground, diagonal};
use crate::closest::Search;
use crate::subdivision::fit::FitWork;
use crate::subdivision::relax::shape;
use crate::subdivision::remesh::{self, Cut, PreImage, RemeshOptions, Remeshed, TraceOptions, trace_parts};

/// Trims in progress that are made together: all their dense state, but for that of their fit.
///
/// Lives as a component on the first of them while it runs. What it holds is derived: losing it
/// costs time and nothing else.
#[derive(Component, Debug)]
pub struct TrimWork {
    ground: Arc<Ground>,
    cuts: Vec<Cut>,
    options: TrimOptions,
    tolerance: Option<Tolerance>,
    stage: TrimStage,
    /// The curves located so far: for each part of one that lies on the source its cut and where it
    /// runs.
    parts: Vec<(usize, PreImage)>,
    located: usize,
    remeshed: Option<Arc<Remeshed>>,
    audit: Option<TrimAuditWork>,
}

/// Where no tolerance says how far a curve may lie off the surface: this part of the source's size.
const OFF: f64 = 0.01;

/// Steps along a curve while it is located, of an edge of the cage.
const STEPS_PER_EDGE: f64 = 8.0;

impl TrimWork {
    /// Begins to trim `ground` by `cuts`, which are the curves of all trims that are made together.
    ///
    /// # Errors
    /// [`TrimFault::BadNumber`], [`TrimFault::Remesh`] where there is no curve.
    pub fn new(
        ground: Arc<Ground>,
        cuts: Vec<Cut>,
        options: TrimOptions,
        tolerance: Option<Tolerance>,
    ) -> Result<Self, TrimFault> {
        let positive = |what, value: f64| {
            if value.is_finite() && value > 0.0 { Ok(()) } else { Err(TrimFault::BadNumber { what, value }) }
        };
        if let Some(tolerance) = tolerance {
            positive("the tolerance of the fit", tolerance.fit)?;
            positive("the tolerance of the curve", tolerance.curve)?;
        }
        if let Some(reach) = options.reach {
            positive("the reach", reach)?;
        }
        if cuts.is_empty() {
            return Err(RemeshError::NoCurves.into());
        }
        let stage = TrimStage::Locate;
        let (parts, located, remeshed, audit) = (Vec::new(), 0, None, None);
        Ok(Self { ground, cuts, options, tolerance, stage, parts, located, remeshed, audit })
    }

    /// The stage that is next.
    pub const fn stage(&self) -> TrimStage {
        self.stage
    }

    /// The curves.
    pub fn cuts(&self) -> &[Cut] {
        &self.cuts
    }

    /// The source, ready to be searched.
    pub const fn ground(&self) -> &Arc<Ground> {
        &self.ground
    }

    /// The new cage, once there is one.
    pub const fn remeshed(&self) -> Option<&Arc<Remeshed>> {
        self.remeshed.as_ref()
    }

    /// Where the curves run on the source, as far as they are located: the index of each one's cut,
    /// and the pre-image of a part of it.
    pub fn parts(&self) -> &[(usize, PreImage)] {
        &self.parts
    }

    /// Locates the next curve on the source; all of them located, [`TrimStage::Remesh`] is next.
    ///
    /// # Errors
    /// When the curve misses the source, lies too far off, or has no usable pre-image.
    pub fn locate(&mut self) -> Result<TrimQuantum, TrimFault> {
        let cut = self.located;
        if let Some(Cut { curve, .. }) = self.cuts.get(cut) {
            let found = self.locate_one(cut, &**curve)?;
            self.parts.extend(found.into_iter().map(|part| (cut, part)));
            self.located += 1;
        }
        if self.located < self.cuts.len() {
            return Ok(TrimQuantum::More);
        }
        self.stage = TrimStage::Remesh;
        Ok(TrimQuantum::Next(self.stage))
    }

    fn locate_one(&self, index: usize, curve: &dyn Curve) -> Result<Vec<PreImage>, TrimFault> {
        let limit = self.tolerance.map_or(OFF * self.ground.size, |t| t.curve);
        let options = TraceOptions { curve: limit, step: self.ground.edge / STEPS_PER_EDGE };
        let target = self.ground.target(Search::Everywhere);
        let parts = trace_parts(&self.ground.surface.mesh, &target, curve, options)
            .map_err(|source| RemeshError::PreImage { curve: index, source })?;
        if parts.is_empty() {
            return Err(self.miss(index, curve, limit));
        }
        if let Some(tolerance) = self.tolerance {
            let points: Vec<_> = parts.iter().flat_map(|part| &part.points).map(|p| p.position).collect();
            let size = diagonal(&points);
            if size < tolerance.fit {
                return Err(TrimFault::TooSmall { curve: index, size, at: points[0], tolerance: tolerance.fit });
            }
        }
        Ok(parts)
    }

    fn miss(&self, curve: usize, of: &dyn Curve, limit: f64) -> TrimFault {
        const LOOKS: u32 = 64;
        let mut nearest = (f64::INFINITY, 0.0, of.position(0.0));
        for u in (0..LOOKS).map(|k| f64::from(k) / f64::from(LOOKS)) {
            let at = of.position(u);
            if let Some(found) = self.ground.index.closest(at).ok().filter(|found| found.distance < nearest.0) {
                nearest = (found.distance, u, at);
            }
        }
        let (distance, u, at) = nearest;
        TrimFault::Misses { curve, u, at, distance, limit }
    }

    /// Works the curves into the cage and begins the fit of it.
    ///
    /// # Errors
    /// As [`remesh::remesh`] and [`FitWork::new`].
    pub fn remesh(&mut self, budgets: &Budgets) -> Result<FitWork, TrimFault> {
        let options = RemeshOptions { reach: self.options.reach, ..RemeshOptions::default() };
        let cuts: Vec<Cut> = self.parts.iter().map(|&(cut, _)| self.cuts[cut].clone()).collect();
        let images: Vec<PreImage> = self.parts.iter().map(|(_, part)| part.clone()).collect();
        let remeshed = remesh::remesh(&self.ground.surface, &cuts, &images, &options)
            .map_err(|why| TrimFault::Remesh(self.of_cuts(why)))?;
        let target: Arc<dyn Target> = Arc::new(self.ground.target(Search::AroundHint));
        let guarded = Arc::new(Guarded::new(target, *budgets));
        let fit = fit_options(&self.options, self.tolerance.as_ref(), budgets, remeshed.omega());
        let natural: Arc<[SurfacePoint]> = remeshed.natural.clone().into();
        let work = FitWork::new(Arc::new(remeshed.surface.clone()), guarded, fit)?.with_natural(natural);
        self.remeshed = Some(Arc::new(remeshed));
        self.stage = TrimStage::Fit;
        Ok(work)
    }

    /// An error that names parts of curves, with the curves themselves.
    fn of_cuts(&self, mut why: RemeshError) -> RemeshError {
        let cut = |part: usize| self.parts.get(part).map_or(part, |part| part.0);
        match &mut why {
            RemeshError::PreImage { curve, .. }
            | RemeshError::Open { curve, .. }
            | RemeshError::DoesNotSeparate { curve, .. }
            | RemeshError::TooFine { curve, .. }
            | RemeshError::Tangled { curve, .. }
            | RemeshError::Cusp { curve, .. }
            | RemeshError::BorderGap { curve, .. }
            | RemeshError::AlongBorder { curve, .. }
            | RemeshError::Unresolved { curve, .. } => *curve = cut(*curve),
            RemeshError::Gap { curves, .. }
            | RemeshError::Tangential { curves, .. }
            | RemeshError::Coincident { curves, .. } => *curves = curves.map(cut),
            _ => {}
        }
        why
    }

    /// The fit is done: measures it next.
    ///
    /// # Errors
    /// [`TrimFault::NotReached`] when it ended above its tolerance; [`TrimFault::Unevaluated`].
    pub fn begin_audit(&mut self, fit: &FitWork) -> Result<(), TrimFault> {
        let outcome = fit.outcome().unwrap_or(Outcome::Within);
        let limit = self.tolerance.map(|t| t.fit);
        if outcome != Outcome::Within {
            return Err(TrimFault::NotReached { outcome });
        }
        let Some(remeshed) = self.remeshed.clone() else { return Ok(()) };
        let surface = Arc::new(LoopSurface { details: fit.details().clone(), ..remeshed.surface.clone() });
        self.audit = Some(TrimAuditWork::new(Arc::clone(&self.ground), remeshed, surface, limit, &self.options)?);
        self.stage = TrimStage::Audit;
        Ok(())
    }

    /// Runs one work quantum of the audit.
    ///
    /// # Errors
    /// [`TrimFault::Audit`] with everything that is wrong.
    pub fn audit(&mut self) -> Result<TrimQuantum, TrimFault> {
        self.audit.as_mut().map_or(Ok(TrimQuantum::Finished), TrimAuditWork::advance)
    }

    /// What is left of the source, once the audit has begun.
    pub fn result(&self) -> Option<&Arc<LoopSurface>> {
        self.audit.as_ref().map(TrimAuditWork::surface)
    }

    /// The report; `None` before the audit is done.
    pub fn report(&self, fit: &FitWork) -> Option<TrimReport> {
        let (remeshed, audit) = (self.remeshed.as_ref()?, self.audit.as_ref()?);
        Some(TrimReport {
            together: Vec::new(),
            off: self.parts.iter().map(|(_, part)| part.distance()).fold(0.0, f64::max),
            initial: fit.initial().copied(),
            ladder: fit.ladder().to_vec(),
            outcome: fit.outcome()?,
            details: fit.details().count(),
            relaxed: remeshed.relaxed.clone(),
            cage: self.cage(remeshed),
            audit: *audit.found(),
        })
    }

    fn cage(&self, remeshed: &Remeshed) -> TrimmedCage {
        let mesh = &remeshed.surface.mesh;
        let omega = remeshed.omega();
        let changed = remeshed.changed.iter();
        let worst = |worst: f64, face: &FaceCode| {
            worst.min(shape(mesh.face(face.root_face(0)).map(|v| remeshed.limit[v.index()])))
        };
        TrimmedCage {
            faces: mesh.face_count(),
            outside: mesh.face_count() - omega.len(),
            changed_radius: self.changed_radius(remeshed),
            greatest_valence: changed.map(|&v| mesh.valence(v)).max().unwrap_or(0),
            worst_shape: omega.iter().fold(f64::INFINITY, worst),
        }
    }

    /// The farthest from the curves that a control point has changed.
    fn changed_radius(&self, remeshed: &Remeshed) -> f64 {
        let path: Vec<_> = self.parts.iter().flat_map(|(_, part)| &part.points).map(|p| p.position).collect();
        let away = |v: &VertexId| {
            let x = remeshed.limit[v.index()];
            path.iter().map(|p| p.distance_squared(x)).fold(f64::INFINITY, f64::min)
        };
        remeshed.changed.iter().map(away).fold(0.0, f64::max).sqrt()
    }

    /// Runs all stages to the end: what a host without a schedule does.
    ///
    /// # Errors
    /// As the stages do.
    pub fn run(&mut self, budgets: &Budgets) -> Result<FitWork, TrimFault> {
        while self.locate()? == TrimQuantum::More {}
        let mut fit = self.remesh(budgets)?;
        fit.run()?;
        self.begin_audit(&fit)?;
        while self.audit()? == TrimQuantum::More {}
        Ok(fit)
    }
}

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
        storage: options.storage,
        most_details: usize::try_from(budgets.details).unwrap_or(usize::MAX),
    }
}
