//! A scene's trims, done and measured.

use std::sync::Arc;
use std::time::{Duration, Instant};

use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::{Details, FaceCode, LoopSurface};
use selvedge_components::target::Target;
use selvedge_systems::closest::SurfaceTarget;
use selvedge_systems::subdivision::fit::{FitOptions, FitWork, Outcome, Quantum, Region, Rung};
use selvedge_systems::subdivision::remesh::{
    Cut, FaceOrigin, PreImage, RemeshError, RemeshOptions, Remeshed, TraceOptions, remesh, trace_parts,
};

use super::ground::Ground;
use super::{Subject, TrimSceneError};

/// What a scene's trims are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The greatest distance between the trimmed and the given limit surface, in metres; none refines
    /// all that may move down to the last level.
    pub tolerance: Option<f64>,
    /// The finest level of details.
    pub last_level: u32,
    /// How the cages are made.
    pub remesh: RemeshOptions,
}

impl Settings {
    /// Down to a distance, in metres.
    pub fn within(tolerance: f64) -> Self {
        Self { tolerance: Some(tolerance), last_level: 16, remesh: RemeshOptions::default() }
    }

    /// Down to a level, wherever the trim may change anything.
    pub fn levels(last_level: u32) -> Self {
        Self { tolerance: None, last_level, remesh: RemeshOptions::default() }
    }

    /// The same, with nothing changed farther than `reach` from the curves, in metres.
    #[must_use]
    pub fn reaching(self, reach: f64) -> Self {
        Self { remesh: RemeshOptions { reach: Some(reach), ..self.remesh }, ..self }
    }
}

/// What one trim has come to.
#[derive(Clone, Debug)]
pub struct Level {
    /// Where the curves run on the surface that was trimmed, in the order of the cuts.
    pub cuts: Vec<Cut>,
    /// The pre-image of each.
    pub images: Vec<PreImage>,
    /// The new cage before any fit.
    pub remeshed: Remeshed,
    /// The faces of the new cage that may change: the region of influence.
    pub omega: Vec<FaceCode>,
    /// The error of the new cage before any detail.
    pub initial: Option<Rung>,
    /// The error after each level.
    pub ladder: Vec<Rung>,
    /// How the fit ended.
    pub outcome: Outcome,
    /// All details after this trim.
    pub details: Details,
}

/// A scene, trimmed.
#[derive(Clone, Debug)]
pub struct Trimmed {
    /// What was trimmed.
    pub name: String,
    /// The surface that was given, against which every error is measured.
    pub ground: Ground,
    /// What is left.
    pub surface: Arc<LoopSurface>,
    /// The trims.
    pub trims: Vec<Level>,
    /// By face of what is left: the face of the given surface that it still is, to the bit.
    pub untouched: Vec<Option<FaceId>>,
    /// The longest step: a pre-image, a cage or a work quantum of a fit.
    pub longest_step: Duration,
    /// All steps together.
    pub time: Duration,
}

impl Trimmed {
    /// The surface after `level` of its last trim's fit; before any detail of it for `None`.
    pub fn after(&self, level: Option<u32>) -> LoopSurface {
        let Some(last) = self.trims.last() else { return (*self.surface).clone() };
        let given = &last.remeshed.surface;
        let Some(level) = level else { return given.clone() };
        // Levels beyond hold what the surface brought with it.
        let count = self.surface.details.levels.len().max(given.details.levels.len());
        let of = |details: &Details, l: usize| details.levels.get(l).cloned().unwrap_or_default();
        let levels = (0..count)
            .map(|l| of(if l <= level as usize { &self.surface.details } else { &given.details }, l))
            .collect();
        LoopSurface { details: Details { levels }, ..given.clone() }
    }
}

/// Does the trims of `scene`, each on what the one before has left; every fit is made to the surface
/// that was given first, so nothing drifts.
///
/// # Errors
/// The first trim that fails, and why.
pub fn run(scene: &Subject, settings: &Settings) -> Result<Trimmed, TrimSceneError> {
    let root = &scene.ground;
    let mut now = root.clone();
    let faces = root.surface.mesh.face_count();
    let mut untouched: Vec<Option<FaceId>> = (0..faces).map(|f| Some(FaceId::new(f))).collect();
    let mut clock = Clock::default();
    let mut trims = Vec::new();
    for (trim, cuts) in scene.trims.iter().enumerate() {
        let failed = |source| TrimSceneError::Remesh { trim, source };
        let (cuts, images) = clock.time(|| trace_all(&now, cuts)).map_err(failed)?;
        let remeshed = clock.time(|| remesh(&now.surface, &cuts, &images, &settings.remesh)).map_err(failed)?;
        let omega = remeshed.omega();
        untouched = still_untouched(&remeshed, &omega, &untouched);
        let options = FitOptions {
            tolerance: settings.tolerance,
            last_level: settings.last_level,
            region: Region::Faces(omega.clone()),
            ..FitOptions::default()
        };
        let work = fit(&remeshed, Arc::new(root.target()), options, &mut clock)
            .map_err(|source| TrimSceneError::Fit { trim, source })?;
        let surface = LoopSurface { details: work.details().clone(), ..remeshed.surface.clone() };
        trims.push(Level {
            cuts,
            images,
            omega,
            initial: work.initial().copied(),
            ladder: work.ladder().to_vec(),
            outcome: work.outcome().unwrap_or(Outcome::Within),
            details: surface.details.clone(),
            remeshed,
        });
        // What the next trim is laid on.
        now = clock.time(|| Ground::new(surface))?;
    }
    Ok(Trimmed {
        name: scene.name.clone(),
        ground: root.clone(),
        surface: Arc::clone(&now.surface),
        trims,
        untouched,
        longest_step: clock.longest,
        time: clock.sum,
    })
}

/// The parts of the curves that lie on a surface, as a cut each, and their pre-images.
fn trace_all(on: &Ground, cuts: &[Cut]) -> Result<(Vec<Cut>, Vec<PreImage>), RemeshError> {
    /// How far a curve may lie off the surface: one that is laid on the given surface lies off a
    /// trimmed one by that one's error.
    const OFF: f64 = 1e-4;
    let mesh = &on.surface.mesh;
    let options = TraceOptions { curve: OFF, step: mean_edge(&on.surface) / 8.0 };
    let (mut parts, mut images) = (Vec::new(), Vec::new());
    for (curve, cut) in cuts.iter().enumerate() {
        let found = trace_parts(mesh, &on.target(), &*cut.curve, options)
            .map_err(|source| RemeshError::PreImage { curve, source })?;
        parts.extend(found.iter().map(|_| cut.clone()));
        images.extend(found);
    }
    Ok((parts, images))
}

fn mean_edge(surface: &LoopSurface) -> f64 {
    let mesh = &surface.mesh;
    let ends = mesh.faces().iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    let sum: f64 = ends.map(|(a, b)| surface.points[a.index()].distance(surface.points[b.index()])).sum();
    sum / (3 * mesh.face_count()) as f64
}

fn fit(
    remeshed: &Remeshed,
    target: Arc<SurfaceTarget<selvedge_systems::subdivision::limit::LimitSurface>>,
    options: FitOptions,
    clock: &mut Clock,
) -> Result<FitWork, selvedge_systems::subdivision::fit::FitError> {
    let target: Arc<dyn Target> = target;
    let surface = Arc::new(remeshed.surface.clone());
    let mut work = clock.time(|| FitWork::new(surface, target, options))?;
    while clock.time(|| work.advance())? != Quantum::Finished {}
    Ok(work)
}

/// Which faces of a new cage are faces of the root still: whole ones of the old cage beyond the region
/// of influence that were so before.
fn still_untouched(remeshed: &Remeshed, omega: &[FaceCode], before: &[Option<FaceId>]) -> Vec<Option<FaceId>> {
    let inside = |f: usize| omega.binary_search(&FaceCode::root(FaceId::new(f))).is_ok();
    let origin = |(f, origin): (usize, &FaceOrigin)| match *origin {
        FaceOrigin::Leaf { level: 0, code } if !inside(f) => before[code.root_face(0).index()],
        _ => None,
    };
    remeshed.face_origin.iter().enumerate().map(origin).collect()
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
