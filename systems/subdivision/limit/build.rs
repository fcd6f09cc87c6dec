//! A limit surface in the making, step by step: levels are the largest part of what it costs.

use std::sync::Arc;

use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::{CornerTable, FaceCode, LevelMesh, LoopSurface};

use super::plan::Plan;
use super::{KeptLevel, LimitError, LimitSurface};
use crate::subdivision::chain::{self, Level};
use crate::subdivision::{region, rules};

/// A [`LimitSurface`] that is being prepared.
#[derive(Debug)]
pub struct LimitBuild {
    surface: Arc<LoopSurface>,
    corners: CornerTable,
    /// Which faces to keep, as far as that is known.
    plan: Plan,
    kept: Vec<KeptLevel>,
    /// The level after those that are kept, once there is a first, and of its faces those that evaluation
    /// may come to.
    level: Option<Level>,
    reached: Vec<FaceCode>,
    /// The level after that, as far as it is there.
    finer: Finer,
}

/// A level in the making.
#[derive(Debug, Default)]
enum Finer {
    #[default]
    Nothing,
    Mesh(LevelMesh),
    Level(Level),
}

impl LimitBuild {
    /// Begins to prepare `surface`.
    ///
    /// # Errors
    /// [`LimitError::PointCount`], [`LimitError::TooFine`].
    pub fn new(surface: Arc<LoopSurface>) -> Result<Self, LimitError> {
        let (points, vertices) = (surface.points.len(), surface.mesh.vertex_count());
        if points != vertices {
            return Err(LimitError::PointCount { points, vertices });
        }
        let (faces, level) = (surface.mesh.face_count(), surface.details.depth().saturating_sub(1));
        let finest = FaceCode::finest(faces);
        if level > finest {
            return Err(LimitError::TooFine { level, faces, finest });
        }
        let corners = CornerTable::new(&surface);
        let reached = region::whole(&surface.mesh, 0);
        Ok(Self {
            surface,
            corners,
            plan: Plan::default(),
            kept: Vec::new(),
            level: None,
            reached,
            finer: Finer::default(),
        })
    }

    /// The surface that is prepared.
    pub fn surface(&self) -> &Arc<LoopSurface> {
        &self.surface
    }

    /// Takes the next step; the limit surface, once it is ready.
    ///
    /// # Errors
    /// [`LimitError::NotFinite`].
    pub fn advance(&mut self) -> Result<Option<LimitSurface>, LimitError> {
        let Some(level) = &self.level else {
            self.level = Some(self.root()?);
            return Ok(None);
        };
        let plan = &mut self.plan;
        if plan.advance(&self.surface, &self.corners).is_some() {
            return Ok(None);
        }
        let l = self.kept.len();
        let Some(refined) = plan.refined.get(l) else {
            let level = self.level.take().unwrap_or_default();
            self.kept.push(KeptLevel::new(level, &self.reached, &[], &[], Vec::new()));
            let (surface, corners) = (Arc::clone(&self.surface), core::mem::take(&mut self.corners));
            return Ok(Some(LimitSurface { surface, corners, levels: core::mem::take(&mut self.kept) }));
        };
        let (surface, corners) = (&*self.surface, &self.corners);
        self.finer = match core::mem::take(&mut self.finer) {
            Finer::Nothing => Finer::Mesh(rules::refine(surface, &level.mesh, &level.mesh.find_all(refined))),
            Finer::Mesh(mesh) => {
                let state = chain::descend(surface, corners, &surface.details, level, &mesh);
                Finer::Level(Level { mesh, state })
            }
            Finer::Level(finer) => {
                self.keep(l, finer);
                Finer::Nothing
            }
        };
        Ok(None)
    }

    /// Keeps the level that is there; `finer` is the next one.
    fn keep(&mut self, l: usize, finer: Level) {
        let plan = &mut self.plan;
        let unsettled = core::mem::take(&mut plan.unsettled[l]);
        let level = self.level.replace(finer).unwrap_or_default();
        let (split, refined) = (&plan.split[l], &plan.refined[l]);
        self.kept.push(KeptLevel::new(level, &self.reached, split, refined, unsettled));
        self.reached = region::children(split);
    }

    /// Takes all steps that are left.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn finish(mut self) -> Result<LimitSurface, LimitError> {
        loop {
            if let Some(limit) = self.advance()? {
                return Ok(limit);
            }
        }
    }

    fn root(&self) -> Result<Level, LimitError> {
        let level = chain::root(&self.surface, &self.corners, &self.surface.details);
        match level.state.effective.iter().position(|at| !at.is_finite()) {
            Some(v) => Err(LimitError::NotFinite { vertex: VertexId::new(v), at: level.state.effective[v] }),
            None => Ok(level),
        }
    }
}
