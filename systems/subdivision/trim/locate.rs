//! # Locate: where the curves of a trim run on its source
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the source's limit surface, the curves | the approximate pre-images | admit | remesh |
//!
//! One curve in a work quantum. The pre-image decides which faces go and which stay, and never where
//! the new border lies, which is the curve itself.

use std::sync::Arc;

use bevy_ecs::prelude::{Component, Entity};
use glam::DVec3;
use selvedge_components::curve::Curve;
use selvedge_components::evaluate::Evaluate;
use selvedge_components::subdivision::FaceCode;
use selvedge_components::subdivision::remesh::{PreImageError, RemeshError};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{Omega, PreImagePoint, PreImages, TrimFault, TrimOptions, TrimQuantum, TrimStage};

use super::ground::{Ground, diagonal};
use super::zone::{Extent, SidesMet, reserve};
use crate::closest::Search;
use crate::subdivision::region;
use crate::subdivision::remesh::{Cut, Hints, JunctionOptions, PreImage, TraceOptions, trace_near};

/// Where no tolerance says how far a curve may lie off the surface: this part of the source's size.
const OFF: f64 = 0.01;

/// Steps along a curve while it is located, per edge of the cage.
const STEPS_PER_EDGE: f64 = 8.0;

/// A trim whose curves are known to run on its source.
#[derive(Clone, Debug)]
pub struct Located {
    /// The curves.
    pub cuts: Vec<Cut>,
    /// For each part of a curve that lies on the source: the index of its cut, and where it runs.
    pub parts: Vec<(usize, PreImage)>,
    /// How the trim is made.
    pub options: TrimOptions,
    /// Its tolerance, if it has one.
    pub tolerance: Option<Tolerance>,
}

/// A trim whose curves are being located. Lives as a component on it from then on: what it has found
/// is derived, and losing it costs time and nothing else.
#[derive(Component, Clone, Debug)]
pub struct LocateWork {
    ground: Arc<Ground>,
    found: Arc<Located>,
    /// By cut, where it is said to run.
    given: PreImages,
    next: usize,
    /// How far it reaches: the first guess, once it is located, and what was needed beyond that.
    reaches: Vec<Reach>,
}

/// How far a trim is thought to change its source.
#[derive(Clone, Debug)]
pub struct Reach {
    /// The trims made together that needed it, which are the whole of why; none of the first guess.
    pub with: Vec<Entity>,
    /// The root faces that the trim may change, ascending.
    pub reserved: Vec<FaceCode>,
    pub(super) rings: u32,
    pub(super) omega: Omega,
}

/// Rings around the faces that a curve runs through that it is first thought to change: faces as near
/// as 1.2 of their size become finer, which are in two of them; the next closes them off, so its
/// vertices change; the limit surface changes over one more, and what is fitted over that one and
/// another. What needs more says so, and is done again.
const RINGS: u32 = 5;

/// Of them, those in which the limit surface changes and no face is divided.
const OUTER_RINGS: u32 = 2;

impl LocateWork {
    /// Begins to locate `cuts` on `ground`.
    ///
    /// # Errors
    /// [`TrimFault::BadNumber`], [`TrimFault::BelowRounding`]; [`TrimFault::Remesh`] where there is no curve.
    pub fn new(
        ground: Arc<Ground>,
        cuts: Vec<Cut>,
        options: TrimOptions,
        tolerance: Option<Tolerance>,
    ) -> Result<Self, TrimFault> {
        let positive = |what, value: f64| {
            if value.is_finite() && value > 0.0 { Ok(()) } else { Err(TrimFault::BadNumber { what, value }) }
        };
        let limit = ground.rounding;
        let above_rounding = |what, value: f64| {
            positive(what, value)?;
            if value >= limit { Ok(()) } else { Err(TrimFault::BelowRounding { what, value, limit }) }
        };
        if let Some(tolerance) = tolerance {
            above_rounding("the tolerance of the fit", tolerance.fit)?;
            above_rounding("the tolerance of the curve", tolerance.curve)?;
        }
        if let Some(reach) = options.reach {
            positive("the reach", reach)?;
        }
        if cuts.is_empty() {
            return Err(RemeshError::NoCurves.into());
        }
        Ok(Self {
            ground,
            found: Arc::new(Located { cuts, parts: Vec::new(), options, tolerance }),
            given: PreImages::default(),
            next: 0,
            reaches: Vec::new(),
        })
    }

    /// Looks for the curves where they are said to run.
    #[must_use]
    pub fn with_given(self, given: &PreImages) -> Self {
        Self { given: given.clone(), ..self }
    }

    /// The source that the curves run on.
    pub const fn ground(&self) -> &Arc<Ground> {
        &self.ground
    }

    /// What has been found so far: all of it once [`Self::advance`] says so.
    pub const fn found(&self) -> &Arc<Located> {
        &self.found
    }

    /// Locates the next curve; all of them located, [`TrimStage::Remesh`] is next.
    ///
    /// # Errors
    /// When the curve misses the source, lies too far off, or has no usable pre-image.
    pub fn advance(&mut self) -> Result<TrimQuantum, TrimFault> {
        let index = self.next;
        if let Some(Cut { curve, .. }) = self.found.cuts.get(index) {
            let parts = self.locate(index, &**curve)?;
            Arc::make_mut(&mut self.found).parts.extend(parts.into_iter().map(|part| (index, part)));
            self.next += 1;
        }
        if self.next < self.found.cuts.len() {
            return Ok(TrimQuantum::More);
        }
        self.reach(Vec::new(), RINGS, self.found.options.omega);
        Ok(TrimQuantum::Next(TrimStage::Remesh))
    }

    /// The root faces that the trim may change, ascending, once it is located.
    pub fn reserved(&self) -> &[FaceCode] {
        self.reaches.last().map_or(&[], |reach| &reach.reserved)
    }

    /// How far it reaches, once it is located: the first guess, and what was needed beyond that.
    pub fn reaches(&self) -> &[Reach] {
        &self.reaches
    }

    /// Forgets what was needed beyond so many steps from the first guess: it was needed together with
    /// trims that are others now.
    pub fn go_back(&mut self, step: usize) {
        self.reaches.truncate(step + 1);
        if let Some(Reach { omega, .. }) = self.reaches.last() {
            Arc::make_mut(&mut self.found).options.omega = *omega;
        }
    }

    /// The fit of the trims made together needs more faces than those that the remeshing changes.
    pub fn fit_more(&mut self, with: &[Entity]) {
        self.more(with, Omega::Neighbourhood);
    }

    /// The trims made together change more than is reserved: reserves one ring more.
    pub fn widen(&mut self, with: &[Entity]) {
        self.more(with, self.found.options.omega);
    }

    fn more(&mut self, with: &[Entity], omega: Omega) {
        let rings = self.reaches.last().map_or(RINGS, |reach| reach.rings) + 1;
        Arc::make_mut(&mut self.found).options.omega = omega;
        self.reach(with.to_vec(), rings, omega);
    }

    fn reach(&mut self, with: Vec<Entity>, rings: u32, omega: Omega) {
        let (surface, images) = (&self.ground.surface, self.found.parts.iter().map(|(_, image)| image));
        // A small reach refines the whole cage.
        let reserved = match self.found.options.reach {
            Some(_) => region::whole(&surface.mesh, 0),
            None => {
                // Where the first guess was too small, nothing is taken to be out of reach.
                let sides = if rings == RINGS { SidesMet::Divided } else { SidesMet::All };
                reserve(surface, images, Extent { rings, outer: OUTER_RINGS, sides })
            }
        };
        self.reaches.push(Reach { with, reserved, rings, omega });
    }

    /// Locates all curves.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn run(&mut self) -> Result<Arc<Located>, TrimFault> {
        while self.advance()? == TrimQuantum::More {}
        Ok(Arc::clone(&self.found))
    }

    fn locate(&self, index: usize, curve: &dyn Curve) -> Result<Vec<PreImage>, TrimFault> {
        let limit = self.found.tolerance.map_or(OFF * self.ground.size, |t| t.curve);
        let options = TraceOptions { curve: limit, step: self.ground.edge / STEPS_PER_EDGE };
        let given = self.given.0.get(index).map_or(&[][..], |given| given);
        // Near another sheet it is the one that a given place lies on.
        let search = if given.is_empty() { Search::Everywhere } else { Search::AroundHint };
        let target = self.ground.target(search);
        let mesh = &self.ground.surface.mesh;
        let parts = self.hints(given, curve).and_then(|hints| trace_near(mesh, &target, curve, options, &hints));
        let parts = parts.map_err(|source| RemeshError::PreImage { curve: index, source })?;
        if parts.is_empty() {
            return Err(self.miss(index, curve, limit));
        }
        if let Some(Tolerance { fit, .. }) = self.found.tolerance {
            let points: Vec<DVec3> = parts.iter().flat_map(|part| &part.points).map(|p| p.position).collect();
            let size = diagonal(&points);
            if size < fit {
                return Err(TrimFault::TooSmall { curve: index, size, at: points[0], tolerance: fit });
            }
        }
        Ok(parts)
    }

    /// The given places, each of which is near the curve.
    fn hints(&self, given: &[PreImagePoint], curve: &dyn Curve) -> Result<Hints, PreImageError> {
        let hints = Hints::new(&self.ground.surface.mesh, given)?;
        // It says on which sheet, and near which faces: beyond an edge it would say neither.
        let limit = self.ground.edge;
        for (index, &PreImagePoint { u, at: place }) in given.iter().enumerate() {
            let at = curve.position(u);
            let distance = self.ground.limit().position(place).distance(at);
            if distance > limit || distance.is_nan() {
                return Err(PreImageError::GivenOff { index, u, at, distance, limit });
            }
        }
        Ok(hints)
    }

    /// The curve does not meet the surface: how far off it is where it is nearest. Or it does along a border
    /// alone.
    fn miss(&self, curve: usize, of: &dyn Curve, limit: f64) -> TrimFault {
        const LOOKS: u32 = 64;
        let (mut distance, mut u, mut at) = (f64::INFINITY, 0.0, of.position(0.0));
        for look in (0..LOOKS).map(|k| f64::from(k) / f64::from(LOOKS)) {
            let point = of.position(look);
            let found = self.ground.index.closest(point).ok();
            if let Some(found) = found.filter(|found| found.distance < distance) {
                (distance, u, at) = (found.distance, look, point);
            }
        }
        if distance <= limit {
            // It is on the source, and nowhere within its borders.
            let limit = JunctionOptions::default().angle;
            return RemeshError::AlongBorder { curve, u, at, angle: 0.0, limit }.into();
        }
        TrimFault::Misses { curve, u, at, distance, limit }
    }
}
