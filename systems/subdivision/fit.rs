//! Fitting a combined Loop surface to a target by multiresolution details.
//!
//! One level at a time, three stages in turn: *correspond* finds the target's points closest to the
//! limit points, *modify* moves the control points and boundary details of the level, *refine*
//! measures the result two subdivisions deeper and opens the next level where it is not good
//! enough. [Litke et al. 2001, Section 3.3; the least-squares rule replaces its quasi-interpolation
//! by default.]

use std::sync::Arc;

use bevy_ecs::prelude::Component;
use glam::DVec3;
use selvedge_components::mesh::VertexId;
pub use selvedge_components::subdivision::fit::{
    FitError, FitOptions, Outcome, Quantum, Region, Rule, Rung, Stage, Storage,
};
use selvedge_components::subdivision::{Address, CornerTable, Details, FaceCode, LoopSurface};

use super::natural::Natural;
use super::open::{OpenLevel, Opening};
use super::region;
use crate::target::Target;

/// A fit in progress: all its dense state.
///
/// Lives as a component on its job while that runs. What it holds is derived: losing it costs time
/// and nothing else.
#[derive(Component, Debug)]
pub struct FitWork {
    /// What is fitted, as it was given.
    surface: Arc<LoopSurface>,
    /// The same, whose curves remember what they are asked: one level asks for the points of the one before.
    pub(super) remembering: Arc<LoopSurface>,
    pub(super) target: Arc<dyn Target>,
    pub(super) options: FitOptions,
    pub(super) corners: CornerTable,
    pub(super) details: Details,
    pub(super) stage: Stage,
    pub(super) open: OpenLevel,
    /// The next level, while it is being opened.
    pub(super) opening: Option<Opening>,
    pub(super) ladder: Vec<Rung>,
    pub(super) initial: Option<Rung>,
    pub(super) outcome: Option<Outcome>,
    /// Greatest error among patches that are not worked on any more, and where.
    pub(super) settled: (f64, DVec3),
    pub(super) unreachable: (f64, DVec3),
    /// By level, that after the root's first: the patches that hold details which the surface came with. They
    /// are measured at every level that has such, wherever else the fit works: details of a level show two
    /// levels deeper.
    pub(super) watched: Vec<Vec<FaceCode>>,
    /// Where to look first.
    pub(super) natural: Natural,
}

impl FitWork {
    /// Begins to fit `surface`, details and all, to `target`.
    ///
    /// # Errors
    /// When the options cannot be met or the surface is not finite.
    pub fn new(surface: Arc<LoopSurface>, target: Arc<dyn Target>, options: FitOptions) -> Result<Self, FitError> {
        check_options(&surface, &options)?;
        let remembering = Arc::new(surface.remembering());
        let corners = CornerTable::new(&surface);
        let details = surface.details.clone();
        if let Some(v) = surface.points.iter().position(|p| !p.is_finite()) {
            return Err(FitError::NotFinite { vertex: VertexId::new(v), at: surface.points[v] });
        }
        let level = first_level(&surface)?;
        let opening = Opening::new(level, region::whole(&surface.mesh, level), Vec::new());
        let detailed = region::detailed(&surface.mesh, &details);
        let watched = (1..).zip(detailed).map(|(level, faces)| within(&options.region, &surface, level, faces));
        let watched = watched.collect();
        Ok(Self {
            surface,
            remembering,
            target,
            options,
            corners,
            details,
            stage: Stage::Refine,
            open: OpenLevel { level, ..OpenLevel::default() },
            opening: Some(opening),
            ladder: Vec::new(),
            initial: None,
            outcome: None,
            settled: (0.0, DVec3::ZERO),
            unreachable: (0.0, DVec3::ZERO),
            watched,
            natural: Natural::default(),
        })
    }

    /// Takes `natural`, which names places of the target, as where to look first.
    #[must_use]
    pub fn with_natural(mut self, natural: Natural) -> Self {
        self.natural = natural;
        self
    }

    /// The stage that [`Self::advance`] would run next. A fit begins with [`Stage::Refine`], which
    /// measures the surface as it was given.
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// Runs one work quantum of the stage that is next.
    ///
    /// # Errors
    /// As the stages do; the fit cannot go on then.
    pub fn advance(&mut self) -> Result<Quantum, FitError> {
        match self.stage {
            Stage::Correspond => self.correspond(),
            Stage::Modify => self.modify(),
            Stage::Refine => self.refine(),
        }
    }

    /// Runs to the end.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn run(&mut self) -> Result<Outcome, FitError> {
        loop {
            if self.advance()? == Quantum::Finished {
                // A finished fit always has an outcome.
                return Ok(self.outcome.unwrap_or(Outcome::Within));
            }
        }
    }

    /// The ladder so far: one rung per level that is done.
    pub fn ladder(&self) -> &[Rung] {
        &self.ladder
    }

    /// The error before any detail, once it has been measured.
    pub fn initial(&self) -> Option<&Rung> {
        self.initial.as_ref()
    }

    /// How it ended; `None` while it runs.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcome
    }

    /// The level in work.
    pub fn level(&self) -> u32 {
        self.open.level
    }

    /// The coefficients that the level in work may move.
    pub fn active(&self) -> &[(u32, Address)] {
        &self.open.active
    }

    /// The details so far, those of the source included.
    pub fn details(&self) -> &Details {
        &self.details
    }

    /// What is being fitted.
    pub fn surface(&self) -> &Arc<LoopSurface> {
        &self.surface
    }

    /// The points measured at the level in work and their distances to the target, for pictures:
    /// the triangles of that level, two subdivisions deeper.
    pub fn error_map(&self) -> ErrorMap {
        let finest = &self.open.levels[2];
        let mut positions: Vec<DVec3> = (0..finest.mesh.vertices.len()).map(|v| finest.mesh.sample(v as u32)).collect();
        let mut errors = vec![0.0; positions.len()];
        let measured = self.open.measured.iter().zip(&self.open.distances);
        for (&v, (&x, &error)) in self.open.tested.iter().zip(measured) {
            positions[v as usize] = x;
            errors[v as usize] = error;
        }
        ErrorMap { positions, errors, triangles: finest.mesh.corners.clone() }
    }

    pub(super) fn go_to(&mut self, stage: Stage) -> Quantum {
        self.stage = stage;
        Quantum::Next(stage)
    }
}

/// Limit points with their distances to the target.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorMap {
    /// Limit points.
    pub positions: Vec<DVec3>,
    /// Their distances to the target.
    pub errors: Vec<f64>,
    /// Three points each.
    pub triangles: Vec<[u32; 3]>,
}

/// The level that a fit begins with: 0, or the one at which measuring two levels deeper meets the
/// finest of the source's own details.
fn first_level(surface: &LoopSurface) -> Result<u32, FitError> {
    /// 4^11: some seconds of work, and about 3 GiB two levels deeper.
    const MOST_FACES: u64 = 1 << 22;
    let depth = surface.details.depth();
    let level = depth.saturating_sub(3);
    let faces = (surface.mesh.face_count() as u64).saturating_mul(1 << (2 * level).min(62));
    if level > 0 && faces > MOST_FACES {
        return Err(FitError::SourceTooDeep { depth, faces, limit: MOST_FACES });
    }
    Ok(level)
}

fn check_options(surface: &LoopSurface, options: &FitOptions) -> Result<(), FitError> {
    if let Some(tolerance) = options.tolerance {
        if !(tolerance.is_finite() && tolerance > 0.0) {
            return Err(FitError::BadTolerance { tolerance });
        }
        let size = surface.points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        // A limit point is a sum of a dozen rounded products, a closest point one of a few dozen.
        let least = 32.0 * f64::EPSILON * size;
        if tolerance < least {
            return Err(FitError::ToleranceBelowRounding { tolerance, least });
        }
    }
    let faces = surface.mesh.face_count();
    // Measuring goes two levels deeper.
    let finest = FaceCode::finest(faces).saturating_sub(2);
    if options.last_level > finest {
        return Err(FitError::TooFine { level: options.last_level, faces, finest });
    }
    Ok(())
}

/// The faces of `level` among `faces` where `region` lets details stand.
pub(super) fn within(region: &Region, surface: &LoopSurface, level: u32, mut faces: Vec<FaceCode>) -> Vec<FaceCode> {
    match region {
        Region::Whole => {}
        Region::Faces(omega) => faces.retain(|f| omega.binary_search(&FaceCode(f.0 >> (2 * level))).is_ok()),
        Region::Around { vertex, rings, from_level } => {
            if level >= *from_level {
                let zone = zone(surface, level, *vertex, *rings);
                faces.retain(|f| zone.binary_search(f).is_ok());
            }
        }
    }
    faces
}

/// All faces of `level` within `rings` rings of a root vertex.
pub(super) fn zone(surface: &LoopSurface, level: u32, vertex: VertexId, rings: u32) -> Vec<FaceCode> {
    let mesh = &surface.mesh;
    let corner_faces = mesh.ring(vertex).map(|h| {
        // The child at a corner has that corner's number, on every level.
        (0..level).fold(FaceCode::root(h.face()), |code, _| code.child(h.corner()))
    });
    let first = region::ascending(corner_faces.collect());
    (1..rings).fold(first, |zone, _| region::neighbourhood(mesh, level, &zone))
}
