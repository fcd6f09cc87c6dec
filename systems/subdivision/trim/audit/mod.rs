//! # Audit of a trim: the result against its source, by other means than those that made it
//!
//! Distances are measured at random places, both ways, by Gauss-Newton steps from places that
//! correspond, over the faces that the trim could change. Beyond them the limit surface has the bits it
//! had: looked at on the faces next to them, which any change would reach first. Source points under the strip need no way back of their own: the feet of the strip's
//! samples are such points, and lie as near to the result as the samples to them. Borders are
//! compared with the curves themselves; edges, loops and pieces are counted.

mod judge;
mod measure;

use std::sync::{Arc, OnceLock};

use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::trim::{TrimAudit, TrimAuditFault, TrimFault, TrimOptions, TrimQuantum};

use super::ground::{Ground, unevaluated};
use crate::closest::SurfaceIndex;
use crate::parallel::map_dear_in_order;
use crate::subdivision::limit::{LimitBuild, LimitSurface};
use crate::subdivision::region;
use crate::subdivision::remesh::Remeshed;

/// Faces measured in one work quantum: some milliseconds.
const QUANTUM: usize = 192;

/// Border samples judged in one work quantum: a curve may cost some microseconds a point.
const BORDER_QUANTUM: usize = 1024;

/// An audit in progress.
#[derive(Debug)]
pub struct TrimAuditWork {
    surface: Arc<LoopSurface>,
    stage: Stage,
    /// What has been found.
    found: TrimAudit,
}

/// How far an audit has come.
#[derive(Debug)]
enum Stage {
    /// The limit surface is being prepared, which what is given is to be measured with.
    Prepare(Box<LimitBuild>, Given),
    /// Distances, then borders.
    Measure(Box<Measuring>),
    Done,
}

/// What an audit is of.
#[derive(Clone, Debug)]
struct Given {
    ground: Arc<Ground>,
    remeshed: Arc<Remeshed>,
    /// The distance allowed, if one was asked for.
    allowed: Option<f64>,
    samples: u32,
    seed: u64,
}

impl TrimAuditWork {
    /// Begins to measure `surface`, the fitted form of `remeshed`, against `ground`.
    ///
    /// # Errors
    /// [`TrimFault::Unevaluated`].
    pub fn new(
        ground: Arc<Ground>,
        remeshed: Arc<Remeshed>,
        surface: Arc<LoopSurface>,
        allowed: Option<f64>,
        options: &TrimOptions,
    ) -> Result<Self, TrimFault> {
        // Borders are compared with the curves of the surface itself, not with what is remembered of them.
        let build = LimitBuild::new(Arc::new(surface.remembering())).map_err(|why| unevaluated(&why))?;
        let given = Given { ground, remeshed, allowed, samples: options.samples, seed: options.seed };
        Ok(Self { surface, stage: Stage::Prepare(Box::new(build), given), found: TrimAudit::default() })
    }

    /// What is measured.
    pub const fn surface(&self) -> &Arc<LoopSurface> {
        &self.surface
    }

    /// What has been found so far.
    pub const fn found(&self) -> &TrimAudit {
        &self.found
    }

    /// Prepares a level, measures some more faces or borders; all of them measured, judges.
    ///
    /// # Errors
    /// [`TrimFault::Audit`] with everything that is wrong.
    pub fn advance(&mut self) -> Result<TrimQuantum, TrimFault> {
        match &mut self.stage {
            Stage::Prepare(build, given) => {
                if let Some(limit) = build.advance().map_err(|why| unevaluated(&why))? {
                    let measuring = Measuring::new(given.clone(), Arc::clone(&self.surface), limit);
                    self.stage = Stage::Measure(Box::new(measuring));
                }
                Ok(TrimQuantum::More)
            }
            Stage::Measure(measuring) => {
                let step = measuring.advance();
                self.found = measuring.found;
                if step != Ok(TrimQuantum::More) {
                    self.stage = Stage::Done;
                }
                step
            }
            Stage::Done => Ok(TrimQuantum::Finished),
        }
    }
}

/// A trim that is being measured.
#[derive(Debug)]
struct Measuring {
    ground: Arc<Ground>,
    remeshed: Arc<Remeshed>,
    surface: Arc<LoopSurface>,
    limit: Arc<LimitSurface>,
    /// The result, ready to be searched everywhere: made when steps from a near place find no foot.
    searched: OnceLock<Option<SurfaceIndex<LimitSurface>>>,
    /// The distance allowed, if one was asked for.
    allowed: Option<f64>,
    /// A foot as near as this is taken for the right one, which overstates the distance if it is not; one
    /// that is farther is sought elsewhere, too.
    near: f64,
    samples: u32,
    seed: u64,
    omega: Vec<FaceCode>,
    /// The faces next to Omega.
    beside: Vec<FaceCode>,
    /// How many faces are measured, of Omega and then beside it.
    measured: usize,
    /// How many sides are compared with their curves.
    compared: usize,
    found: TrimAudit,
    faults: Vec<TrimAuditFault>,
}

impl Measuring {
    fn new(
        Given { ground, remeshed, allowed, samples, seed }: Given,
        surface: Arc<LoopSurface>,
        limit: LimitSurface,
    ) -> Self {
        let mut beside = region::neighbourhood(&surface.mesh, 0, &remeshed.omega);
        beside.retain(|face| remeshed.omega.binary_search(face).is_err());
        Self {
            surface,
            limit: Arc::new(limit),
            searched: OnceLock::new(),
            allowed,
            // Without a tolerance, what is a thousandth of an edge off is looked at twice.
            near: allowed.unwrap_or(1e-3 * ground.edge),
            samples,
            seed,
            omega: remeshed.omega.clone(),
            beside,
            measured: 0,
            compared: 0,
            found: TrimAudit::default(),
            faults: Vec::new(),
            ground,
            remeshed,
        }
    }

    fn advance(&mut self) -> Result<TrimQuantum, TrimFault> {
        if self.measured < self.omega.len() {
            self.measure_some();
            return Ok(TrimQuantum::More);
        }
        if self.measured < self.omega.len() + self.beside.len() {
            self.look_beside();
            return Ok(TrimQuantum::More);
        }
        if self.compared < self.surface.sides.len() {
            self.compare_some();
            return Ok(TrimQuantum::More);
        }
        let mut faults = Vec::new();
        self.judge_distances(&mut faults);
        faults.append(&mut self.faults);
        self.judge_topology(&mut faults);
        self.judge_cover(&mut faults);
        if faults.is_empty() { Ok(TrimQuantum::Finished) } else { Err(TrimFault::Audit { faults }) }
    }

    /// Measures the next faces.
    fn measure_some(&mut self) {
        let end = self.omega.len().min(self.measured + QUANTUM);
        let faces = &self.omega[self.measured..end];
        let each = map_dear_in_order(faces.len(), |i| self.measure(faces[i].root_face(0)));
        for face in each {
            farther(&mut self.found, &face);
        }
        self.measured = end;
    }

    /// Compares the next faces beside Omega with what they were.
    fn look_beside(&mut self) {
        let begin = self.measured - self.omega.len();
        let faces = &self.beside[begin..self.beside.len().min(begin + QUANTUM)];
        let each = map_dear_in_order(faces.len(), |i| self.change_of(faces[i].root_face(0)));
        self.measured += each.len();
        self.faults.extend(each.into_iter().flatten());
    }

    /// Compares the next sides, one at least, with their curves.
    fn compare_some(&mut self) {
        let mut samples = 0;
        while self.compared < self.surface.sides.len() && samples < BORDER_QUANTUM {
            let found = self.compare(self.compared);
            samples += found.0;
            self.faults.extend(found.1);
            self.compared += 1;
        }
        self.found.border_samples += samples;
    }
}

/// Takes over what is farther in `b`; samples add up.
fn farther(a: &mut TrimAudit, b: &TrimAudit) {
    // A distance that is no number counts as far.
    if b.to_source > a.to_source || b.to_source.is_nan() {
        (a.to_source, a.to_source_at) = (b.to_source, b.to_source_at);
    }
    if b.to_result > a.to_result || b.to_result.is_nan() {
        (a.to_result, a.to_result_at) = (b.to_result, b.to_result_at);
    }
    a.samples += b.samples;
}
