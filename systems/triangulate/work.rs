//! A triangulation in the making, some leaves at a time.
//!
//! To keep a chord, faces are quartered by what bounds and samples of them say ([`grow`](super::grow)). Then the
//! finished triangles, closures and all, are measured ([`check`](super::check)), and leaves that stand off too far
//! after all are quartered too.

use std::sync::Arc;

use selvedge_components::subdivision::{FaceCode, LoopSurface};

use super::assemble::{AssembleWork, Assembly};
use super::check::CheckWork;
use super::forest::Forest;
use super::grow::GrowWork;
use super::known::Known;
use super::reach::Reach;
use super::sample::{Farthest, Place, is_beyond};
use super::{
    ChordReport, Density, SPENT_A_PASS, Subject, TriangulateError, TriangulateOptions, Triangulation, check_chord,
    unreadable, within_budget,
};
use crate::subdivision::limit::LimitBuild;

/// A surface that is being triangulated.
#[derive(Debug)]
pub struct TriangulationWork {
    options: TriangulateOptions,
    /// The surface, once its limit can be evaluated.
    subject: Option<Subject>,
    forest: Forest,
    known: Known,
    stage: Stage,
    /// What it has cost so far: see [`Self::spent`].
    spent: usize,
}

/// What a pass has come to.
#[derive(Debug)]
pub enum TriangulationState {
    /// There is more to do.
    Busy(Box<TriangulationWork>),
    /// The triangles.
    Done(Box<Triangulation>),
}

#[derive(Debug)]
enum Stage {
    Prepare(Box<LimitBuild>),
    Grow(GrowWork),
    Assemble(Box<AssembleWork>),
    Check(Box<CheckWork>),
}

impl TriangulationWork {
    /// Begins to triangulate the limit surface of `surface`, details and all, as it is now.
    ///
    /// # Errors
    /// When the options cannot be met.
    pub fn new(surface: &LoopSurface, options: &TriangulateOptions) -> Result<Self, TriangulateError> {
        let faces = surface.mesh.face_count();
        let finest = FaceCode::finest(faces);
        let mut options = *options;
        // A copy of the control points and details: little beside the triangles they make.
        let build = LimitBuild::new(Arc::new(surface.remembering())).map_err(unreadable)?;
        match options.density {
            Density::Level(level) if level > finest => {
                return Err(TriangulateError::TooFine { level, faces, finest });
            }
            // Codes of this level fit 64 bits, so their number does.
            Density::Level(level) => within_budget(faces << (2 * level), &options)?,
            Density::Chord(chord) => {
                check_chord(surface, chord)?;
                options.last_level = options.last_level.min(finest);
            }
        }
        let (forest, known) = (Forest::new(faces), Known::default());
        Ok(Self { options, subject: None, forest, known, stage: Stage::Prepare(Box::new(build)), spent: 0 })
    }

    /// What the steps so far have cost, in units of looking at a face within a polynomial or evaluating a vertex
    /// there: a fraction of a microsecond to one. The same surface costs the same, on any number of threads.
    pub fn spent(&self) -> usize {
        self.spent
    }

    /// Takes the next step; the triangles, once they are there. A step costs a few thousand, or what one
    /// root face does, or one level of the limit surface.
    ///
    /// # Errors
    /// [`TriangulateError::LimitNotFinite`], [`TriangulateError::PointNotFinite`],
    /// [`TriangulateError::TooManyTriangles`].
    pub fn advance(&mut self) -> Result<Option<Triangulation>, TriangulateError> {
        if matches!(self.stage, Stage::Prepare(_)) {
            self.prepare()?;
            return Ok(None);
        }
        let Self { options, subject: Some(subject), forest, known, stage, spent } = self else { return Ok(None) };
        let chord = match options.density {
            Density::Chord(chord) => Some(chord),
            Density::Level(_) => None,
        };
        match (stage, chord) {
            (Stage::Grow(work), Some(chord)) => {
                if work.advance(subject, forest, chord, options, known, spent)? {
                    self.stage = Stage::Assemble(Box::default());
                }
            }
            (Stage::Assemble(work), _) => {
                if let Some(made) = work.advance(subject, forest, options.normals, spent)? {
                    within_budget(made.triangle_count(), options)?;
                    if chord.is_none() {
                        return Ok(Some(made.finish()));
                    }
                    self.stage = Stage::Check(Box::new(CheckWork::new(made)));
                }
            }
            (Stage::Check(work), Some(chord)) => {
                if work.advance(subject, chord, options.last_level, known, spent) {
                    return Ok(self.judge(chord));
                }
            }
            // Without a chord nothing grows or is measured; and the surface is prepared.
            (Stage::Grow(_) | Stage::Check(_), None) | (Stage::Prepare(_), _) => {}
        }
        Ok(None)
    }

    /// Takes the steps of a pass: as many as cost [`SPENT_A_PASS`].
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn pass(mut self) -> Result<TriangulationState, TriangulateError> {
        let enough = self.spent + SPENT_A_PASS;
        while self.spent < enough {
            if let Some(triangulation) = self.advance()? {
                return Ok(TriangulationState::Done(Box::new(triangulation)));
            }
        }
        Ok(TriangulationState::Busy(Box::new(self)))
    }

    /// Takes all steps that are left.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn finish(mut self) -> Result<Triangulation, TriangulateError> {
        loop {
            if let Some(triangulation) = self.advance()? {
                return Ok(triangulation);
            }
        }
    }

    /// Goes on with the limit surface.
    fn prepare(&mut self) -> Result<(), TriangulateError> {
        let Stage::Prepare(build) = &mut self.stage else { return Ok(()) };
        // A level at a time, and what there is of each: from some faces on a pass each.
        self.spent += 2 * build.surface().mesh.face_count();
        let Some(limit) = build.advance().map_err(unreadable)? else { return Ok(()) };
        let surface = Arc::clone(build.surface());
        let reach = Reach::new(&surface.mesh, &surface.details);
        self.stage = match self.options.density {
            Density::Level(level) => {
                self.forest = Forest::uniform(surface.mesh.face_count(), level);
                Stage::Assemble(Box::default())
            }
            Density::Chord(_) => Stage::Grow(GrowWork::new(&self.forest, self.forest.leaves(), &self.options)),
        };
        self.subject = Some(Subject { surface, limit, reach });
        Ok(())
    }

    /// What comes of measured triangles: leaves that stand off too far are quartered, or all is done.
    fn judge(&mut self, chord: f64) -> Option<Triangulation> {
        let next = Stage::Assemble(Box::default());
        let (Stage::Check(work), Some(subject)) = (core::mem::replace(&mut self.stage, next), &self.subject) else {
            return None;
        };
        let (assembly, found) = work.finish();
        let mut too_far = failing(&assembly, &found, chord);
        let stuck = too_far.get(self.options.last_level as usize).map_or(0, Vec::len);
        too_far.truncate(self.options.last_level as usize);
        if too_far.iter().all(Vec::is_empty) {
            return Some(finish(assembly, &found, chord, stuck));
        }
        let new = self.forest.split(&subject.surface.mesh, &too_far);
        self.stage = Stage::Grow(GrowWork::new(&self.forest, new, &self.options));
        None
    }
}

/// By level, ascending: the codes of those leaves whose farthest point is farther off than `limit`.
fn failing(assembly: &Assembly, found: &[Farthest], limit: f64) -> Vec<Vec<FaceCode>> {
    let mut failing: Vec<Vec<FaceCode>> = Vec::new();
    for (Place { level, code }, _) in
        assembly.leaves.iter().map(|leaf| leaf.place).zip(found).filter(|(_, found)| is_beyond(found, limit))
    {
        failing.resize(failing.len().max(level as usize + 1), Vec::new());
        failing[level as usize].push(code);
    }
    failing
}

fn finish(assembly: Assembly, found: &[Farthest], chord: f64, failing: usize) -> Triangulation {
    let farthest = found.iter().fold(Farthest::default(), |all, &leaf| all.or(leaf));
    let mut done = assembly.finish();
    done.report.chord = Some(ChordReport {
        asked: chord,
        achieved: farthest.squared.sqrt(),
        at: farthest.at,
        samples: farthest.samples,
        failing,
    });
    done
}
