//! A scene's trims, done step by step.

use std::sync::Arc;
use std::time::{Duration, Instant};

use selvedge_components::budget::Budgets;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::fit::{Outcome, Quantum, Rung};
use selvedge_components::subdivision::{Details, FaceCode, LoopSurface};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{Omega, TrimFault, TrimOptions, TrimQuantum, TrimStage};
use selvedge_systems::subdivision::fit::FitWork;
use selvedge_systems::subdivision::remesh::{Cut, FaceOrigin, PreImage, Remeshed};
use selvedge_systems::subdivision::trim::{Ground, LocateWork, TrimWork};

use super::Scene;

/// What a scene's trims are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The tolerance; none refines all that may move down to the last level.
    pub tolerance: Option<Tolerance>,
    /// Everything else.
    pub options: TrimOptions,
}

impl Settings {
    /// Down to a distance between the trimmed and the given limit surface, in metres.
    pub fn within(fit: f64) -> Self {
        // Curves laid on the given surface lie off it by rounding; triangles are asked for apart.
        let tolerance = Tolerance { fit, chord: fit, curve: fit };
        Self { tolerance: Some(tolerance), options: TrimOptions { last_level: 16, ..TrimOptions::default() } }
    }

    /// Down to a level, wherever the trims may change anything.
    pub fn levels(last_level: u32) -> Self {
        let options = TrimOptions { last_level, omega: Omega::Neighbourhood, ..TrimOptions::default() };
        Self { tolerance: None, options }
    }

    /// The same, with nothing changed farther than `reach` from the curves, in metres.
    #[must_use]
    pub fn reaching(self, reach: f64) -> Self {
        Self { options: TrimOptions { reach: Some(reach), ..self.options }, ..self }
    }
}

/// A scene, trimmed.
#[derive(Debug)]
pub struct Trimmed {
    /// What was trimmed.
    pub name: String,
    /// The surface that was given, against which every error is measured.
    pub ground: Arc<Ground>,
    /// What is left.
    pub surface: Arc<LoopSurface>,
    /// The parts of the curves that lie on the given surface, as cuts.
    pub cuts: Vec<Cut>,
    /// Where each of them runs.
    pub images: Vec<PreImage>,
    /// The new cage, before any fit.
    pub remeshed: Arc<Remeshed>,
    /// The error of the new cage before any detail.
    pub initial: Option<Rung>,
    /// The error after each level.
    pub ladder: Vec<Rung>,
    /// The longest step that cannot be interrupted.
    pub longest_step: Duration,
    /// All steps together.
    pub time: Duration,
}

impl Trimmed {
    /// The surface with the details of levels up to `level`; before any fit for `None`.
    pub fn after(&self, level: Option<u32>) -> LoopSurface {
        let given = &self.remeshed.surface;
        let Some(level) = level else { return given.clone() };
        // Levels beyond hold what the given surface brought with it.
        let count = self.surface.details.levels.len().max(given.details.levels.len());
        let of = |details: &Details, l: usize| details.levels.get(l).cloned().unwrap_or_default();
        let levels = (0..count)
            .map(|l| of(if l <= level as usize { &self.surface.details } else { &given.details }, l))
            .collect();
        LoopSurface { details: Details { levels }, ..given.clone() }
    }

    /// The faces of what is left beyond the region of influence, each with the face of the given surface,
    /// or of a level of it where the whole cage was refined first, that it still is.
    pub fn untouched(&self) -> impl Iterator<Item = (FaceId, u32, FaceCode)> + '_ {
        let outside = |f: FaceId| self.remeshed.omega.binary_search(&FaceCode::root(f)).is_err();
        self.remeshed.face_origin.iter().enumerate().filter_map(move |(f, origin)| match *origin {
            FaceOrigin::Leaf { level, code } if outside(FaceId::new(f)) => Some((FaceId::new(f), level, code)),
            _ => None,
        })
    }
}

/// Does the trims of a scene together, as [`selvedge_systems::subdivision::trim`] makes those that
/// touch: from the surface that was given, whatever their number. Where the faces that they change are
/// too few for the tolerance, the ones beside them are fitted, too.
///
/// # Errors
/// What stands against them; [`TrimFault::NotReached`] where the tolerance is not kept.
pub fn run(scene: &Scene, settings: &Settings) -> Result<Trimmed, TrimFault> {
    let mut clock = Clock::default();
    let mut located = Vec::with_capacity(scene.trims.len());
    for cuts in &scene.trims {
        let Settings { options, tolerance } = settings.clone();
        let mut work = LocateWork::new(Arc::clone(&scene.ground), cuts.clone(), options, tolerance)?;
        while clock.time(|| work.advance())? == TrimQuantum::More {}
        located.push(work);
    }
    let (mut work, mut fit) = fitted(scene, &located, &mut clock)?;
    if work.may_fit_more(&not_reached(&fit)) {
        located.iter_mut().for_each(|located| located.fit_more(&[]));
        (work, fit) = fitted(scene, &located, &mut clock)?;
    }
    if outcome(&fit) != Outcome::Within {
        return Err(not_reached(&fit));
    }
    let remeshed = Arc::clone(work.remeshed().expect("a cage that is fitted"));
    let surface = LoopSurface { details: fit.details().clone(), ..remeshed.surface.clone() };
    Ok(Trimmed {
        name: scene.name.clone(),
        ground: Arc::clone(&scene.ground),
        surface: Arc::new(surface),
        cuts: work.parts().map(|(cut, _)| cut.clone()).collect(),
        images: work.parts().map(|(_, image)| image.clone()).collect(),
        remeshed,
        initial: fit.initial().copied(),
        ladder: fit.ladder().to_vec(),
        longest_step: clock.longest,
        time: clock.sum,
    })
}

/// The new cage of trims that are located, and its fit, which has ended one way or another.
fn fitted(scene: &Scene, located: &[LocateWork], clock: &mut Clock) -> Result<(TrimWork, FitWork), TrimFault> {
    let budgets = Budgets::default();
    let found = located.iter().map(|located| Arc::clone(located.found())).collect();
    let mut work = TrimWork::on_all(Arc::clone(&scene.ground), found);
    let mut stage = TrimStage::Remesh;
    while stage != TrimStage::Fit {
        let step = clock.time(|| if stage == TrimStage::Relax { work.relax(&budgets) } else { work.remesh() });
        if let TrimQuantum::Next(next) = step.map_err(|blamed| blamed.why)? {
            stage = next;
        }
    }
    let mut fit = work.take_fit().expect("remeshing has just begun a fit");
    while clock.time(|| fit.advance())? != Quantum::Finished {}
    Ok((work, fit))
}

fn outcome(fit: &FitWork) -> Outcome {
    fit.outcome().unwrap_or(Outcome::Within)
}

fn not_reached(fit: &FitWork) -> TrimFault {
    TrimFault::NotReached { outcome: outcome(fit) }
}

/// Adds up steps.
#[derive(Debug, Default)]
struct Clock {
    longest: Duration,
    sum: Duration,
}

impl Clock {
    fn time<R>(&mut self, step: impl FnOnce() -> R) -> R {
        let start = Instant::now();
        let result = step();
        let took = start.elapsed();
        self.longest = self.longest.max(took);
        self.sum += took;
        result
    }
}
