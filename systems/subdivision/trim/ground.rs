//! A source, ready to be trimmed.

use std::sync::Arc;

use bevy_ecs::prelude::Component;
use glam::DVec3;
use selvedge_components::subdivision::LoopSurface;
use selvedge_components::trim::TrimFault;

use crate::closest::{IndexBuild, Search, SurfaceIndex, SurfaceTarget};
use crate::subdivision::limit::{LimitBuild, LimitSurface};

/// The limit surface of a source, ready to be searched: what curves are located on, fitted to and
/// measured against. Derived from a snapshot, shared by all trims of it, and dropped at will.
#[derive(Component, Clone, Debug)]
pub struct Ground {
    /// The source.
    pub surface: Arc<LoopSurface>,
    /// The revision of the snapshot that it was made of.
    pub revision: u64,
    /// Its limit surface, ready to be searched.
    pub index: Arc<SurfaceIndex<LimitSurface>>,
    /// The mean length of the edges of the cage, in model units.
    pub edge: f64,
    /// The diagonal of the box around the control points, in model units.
    pub size: f64,
    /// How far evaluated points may lie off by rounding alone, in model units.
    pub rounding: f64,
}

/// Limit points are sums of some twenty products of coordinates; fits that go on as deep as they can
/// end at some ten units of rounding.
const ROUNDINGS: f64 = 16.0;

impl Ground {
    /// Prepares `surface`, which was gathered at `revision`.
    ///
    /// # Errors
    /// [`TrimFault::Unevaluated`].
    pub fn new(surface: Arc<LoopSurface>, revision: u64) -> Result<Self, TrimFault> {
        let mut build = GroundBuild::new(surface, revision)?;
        loop {
            if let Some(ground) = build.advance()? {
                return Ok(ground);
            }
        }
    }

    /// The limit surface.
    pub fn limit(&self) -> &Arc<LimitSurface> {
        self.index.surface()
    }

    /// The limit surface as what is fitted to: on the sheet that a hint lies on, for the other side
    /// of a thin part may be nearer.
    pub fn target(&self, search: Search) -> SurfaceTarget<LimitSurface> {
        SurfaceTarget { index: Arc::clone(&self.index), search, revision: self.revision }
    }
}

/// A [`Ground`] in the making, step by step.
#[derive(Debug)]
pub struct GroundBuild {
    surface: Arc<LoopSurface>,
    revision: u64,
    stage: Stage,
}

#[derive(Debug)]
enum Stage {
    Limit(Box<LimitBuild>),
    Index(IndexBuild<LimitSurface>),
}

impl GroundBuild {
    /// Begins to prepare `surface`, which was gathered at `revision`.
    ///
    /// # Errors
    /// [`TrimFault::Unevaluated`].
    pub fn new(surface: Arc<LoopSurface>, revision: u64) -> Result<Self, TrimFault> {
        let limit = LimitBuild::new(Arc::clone(&surface)).map_err(|why| unevaluated(&why))?;
        Ok(Self { surface, revision, stage: Stage::Limit(Box::new(limit)) })
    }

    /// The revision of the snapshot that is being prepared.
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// Takes the next step; the ground, once it is prepared.
    ///
    /// # Errors
    /// [`TrimFault::Unevaluated`].
    pub fn advance(&mut self) -> Result<Option<Ground>, TrimFault> {
        match &mut self.stage {
            Stage::Limit(limit) => {
                if let Some(limit) = limit.advance().map_err(|why| unevaluated(&why))? {
                    self.stage = Stage::Index(IndexBuild::new(Arc::new(limit)));
                }
                Ok(None)
            }
            Stage::Index(index) => {
                Ok(index.advance().map_err(|why| unevaluated(&why))?.map(|index| self.ground(index)))
            }
        }
    }

    fn ground(&self, index: SurfaceIndex<LimitSurface>) -> Ground {
        let surface = Arc::clone(&self.surface);
        let (edge, size) = (mean_edge(&surface), diagonal(&surface.points));
        let greatest = surface.points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let rounding = ROUNDINGS * f64::EPSILON * greatest;
        Ground { surface, revision: self.revision, index: Arc::new(index), edge, size, rounding }
    }
}

/// The source cannot be evaluated.
pub(super) fn unevaluated(why: &dyn core::fmt::Display) -> TrimFault {
    TrimFault::Unevaluated { why: why.to_string() }
}

fn mean_edge(surface: &LoopSurface) -> f64 {
    let (faces, points) = (surface.mesh.faces(), &surface.points);
    let edges = faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let total: f64 = edges.map(|(a, b)| points[a.index()].distance(points[b.index()])).sum();
    total / (3 * faces.len().max(1)) as f64
}

/// The diagonal of the box around `points`.
pub(super) fn diagonal(points: &[DVec3]) -> f64 {
    let low = points.iter().fold(DVec3::INFINITY, |low, &p| low.min(p));
    let high = points.iter().fold(DVec3::NEG_INFINITY, |high, &p| high.max(p));
    if points.is_empty() { 0.0 } else { low.distance(high) }
}
