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
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::VertexId;
pub use selvedge_components::subdivision::fit::{
    FitError, FitOptions, Outcome, Quantum, Region, Rule, Rung, Stage, Storage,
};
use selvedge_components::subdivision::{
    Address, CornerTable, Details, FaceCode, Kind, LevelMesh, LimitRows, LoopSurface, NONE, RingState, SideEnd, Step,
};

use super::chain::{self, Level};
use super::modify::Solve;
use super::region;
use crate::target::Target;

/// A fit in progress: all its dense state.
///
/// Lives as a component on its job while that runs. What it holds is derived: losing it costs time
/// and nothing else.
#[derive(Component, Debug)]
pub struct FitWork {
    pub(super) surface: Arc<LoopSurface>,
    pub(super) target: Arc<dyn Target>,
    pub(super) options: FitOptions,
    pub(super) corners: CornerTable,
    pub(super) details: Details,
    pub(super) stage: Stage,
    pub(super) open: OpenLevel,
    pub(super) ladder: Vec<Rung>,
    pub(super) initial: Option<Rung>,
    pub(super) outcome: Option<Outcome>,
    /// Greatest error among patches that are not worked on any more, and where.
    pub(super) settled: (f64, DVec3),
    pub(super) unreachable: (f64, DVec3),
    /// By root vertex: the place of the target that stands for it.
    pub(super) natural: Arc<[SurfacePoint]>,
}

/// The level in work.
#[derive(Debug)]
pub(super) struct OpenLevel {
    pub level: u32,
    /// Levels `j`, `j + 1` and `j + 2`.
    pub levels: [Level; 3],
    pub steps: [Step; 2],
    /// Limit rows at `j + 1`, what is fitted, and at `j + 2`, what is measured.
    pub fit_rows: LimitRows,
    pub test_rows: LimitRows,
    /// The patches of level `j` that the movable vertices influence, ascending.
    pub influenced: Vec<FaceCode>,
    /// Vertices of level `j` that may move, ascending, and their addresses.
    pub movable: Vec<u32>,
    pub addresses: Vec<Address>,
    pub active: Vec<(u32, Address)>,
    /// What has been added to each movable vertex, as a move of its effective point.
    pub moves: Vec<DVec3>,
    /// Which time round, at this level.
    pub round: u32,
    /// Residuals of the fitted rows, as far as they have been found, and where they were found.
    pub residuals: Vec<DVec3>,
    pub hints: Vec<Option<SurfacePoint>>,
    pub solve: Option<Solve>,
    /// Distances of the measured rows, as far as they have been found.
    pub distances: Vec<f64>,
    pub test_hints: Vec<Option<SurfacePoint>>,
}

impl FitWork {
    /// Begins to fit `surface`, details and all, to `target`.
    ///
    /// # Errors
    /// When the options cannot be met or the surface is not finite.
    pub fn new(surface: Arc<LoopSurface>, target: Arc<dyn Target>, options: FitOptions) -> Result<Self, FitError> {
        check_options(&surface, &options)?;
        let corners = CornerTable::new(&surface);
        let details = surface.details.clone();
        let level = first_level(&surface)?;
        let faces = region::whole(&surface.mesh, level);
        let mut open = OpenLevel::new(&surface, &corners, &details, level, faces);
        for (v, &at) in open.levels[0].state.effective.iter().enumerate() {
            if !at.is_finite() {
                return Err(FitError::NotFinite { vertex: VertexId::new(v), at });
            }
        }
        open.allow(&surface, &options.region);
        Ok(Self {
            surface,
            target,
            options,
            corners,
            details,
            stage: Stage::Refine,
            open,
            ladder: Vec::new(),
            initial: None,
            outcome: None,
            settled: (0.0, DVec3::ZERO),
            unreachable: (0.0, DVec3::ZERO),
            natural: Arc::new([]),
        })
    }

    /// Takes `natural`, by root vertex a place of the target, as where to look first.
    #[must_use]
    pub fn with_natural(mut self, natural: Arc<[SurfacePoint]>) -> Self {
        self.natural = natural;
        self.open.look_first_at(&self.surface, &self.natural);
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
        let limit = self.open.test_rows.apply(&finest.state);
        for ((&v, x), &error) in self.open.test_rows.vertices.iter().zip(limit).zip(&self.open.distances) {
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

impl OpenLevel {
    /// Opens `level` with the vertices around `faces` movable.
    pub fn new(
        surface: &LoopSurface,
        corners: &CornerTable,
        details: &Details,
        level: u32,
        faces: Vec<FaceCode>,
    ) -> Self {
        let mesh = &surface.mesh;
        let grow = |level, faces: &[FaceCode]| region::neighbourhood(mesh, level, faces);
        // A vertex of N(faces) moves the patches of its two rings.
        let around = grow(level, &faces);
        let influenced = grow(level, &grow(level, &around));
        // Two more rings: whole rings around every vertex of the influenced patches, two levels finer.
        let rim = grow(level, &influenced);
        let mut held = grow(level, &rim);
        if level > 0 {
            held = region::children(&region::parents(&held));
        }
        let base = chain::build(surface, corners, details, level, &held);
        let local = |at: &LevelMesh, faces: &[FaceCode]| faces.iter().filter_map(|&f| at.find(f)).collect::<Vec<_>>();
        let (finer, first) = chain::refine(surface, corners, details, &base, &local(&base.mesh, &rim));
        let quarters = grow(level + 1, &region::children(&influenced));
        let (finest, second) = chain::refine(surface, corners, details, &finer, &local(&finer.mesh, &quarters));
        let inside = |at: &LevelMesh, shift: u32| {
            let mut inside = vec![false; at.vertices.len()];
            for (code, corners) in at.codes.iter().zip(&at.corners) {
                if influenced.binary_search(&FaceCode(code.0 >> shift)).is_ok() {
                    corners.iter().for_each(|&v| inside[v as usize] = true);
                }
            }
            inside
        };
        let (fitted, measured) = (inside(&finer.mesh, 2), inside(&finest.mesh, 4));
        let fit_rows = LimitRows::new(surface, corners, &finer.mesh, |v| {
            fitted[v as usize] && finer.mesh.vertices[v as usize].kind == Kind::Interior
        });
        let test_rows = LimitRows::new(surface, corners, &finest.mesh, |v| measured[v as usize]);
        let addresses = base.mesh.addresses(mesh);
        let movable = movable(&base.mesh, &around);
        let mut open = Self {
            level,
            levels: [base, finer, finest],
            steps: [first, second],
            residuals: Vec::new(),
            hints: vec![None; fit_rows.vertices.len()],
            fit_rows,
            distances: Vec::new(),
            test_hints: vec![None; test_rows.vertices.len()],
            test_rows,
            influenced,
            moves: Vec::new(),
            active: Vec::new(),
            movable,
            addresses,
            round: 0,
            solve: None,
        };
        open.list_active();
        open
    }

    /// Takes away the movable vertices that the region does not allow.
    pub fn allow(&mut self, surface: &LoopSurface, region: &Region) {
        let mesh = &self.levels[0].mesh;
        let allowed = match region {
            Region::Whole => return,
            Region::Faces(omega) => {
                let level = self.level;
                let inside = |code: FaceCode| omega.binary_search(&FaceCode(code.0 >> (2 * level))).is_ok();
                inner_vertices(mesh, &inside)
            }
            Region::Around { vertex, rings, from_level } => {
                if self.level < *from_level {
                    return;
                }
                let zone = zone(surface, self.level, *vertex, *rings);
                inner_vertices(mesh, &|code| zone.binary_search(&code).is_ok())
            }
        };
        self.movable.retain(|&v| allowed[v as usize]);
        self.list_active();
    }

    /// Lets the search for each point begin at the place that stands for the nearest root vertex of
    /// its face.
    pub fn look_first_at(&mut self, surface: &LoopSurface, natural: &[SurfacePoint]) {
        let Self { levels, fit_rows, hints, test_rows, test_hints, .. } = self;
        let both = [(&levels[1].mesh, &*fit_rows, hints), (&levels[2].mesh, &*test_rows, test_hints)];
        for (mesh, rows, hints) in both {
            let nearest = nearest_roots(surface, mesh);
            for (&v, hint) in rows.vertices.iter().zip(hints) {
                *hint = natural.get(nearest[v as usize].index()).copied().or(*hint);
            }
        }
    }

    fn list_active(&mut self) {
        self.moves = vec![DVec3::ZERO; self.movable.len()];
        self.active = self.movable.iter().map(|&v| (self.level, self.addresses[v as usize])).collect();
        self.active.sort_unstable();
    }
}

/// For each vertex of a level the root vertex that is nearest on a root face of it.
fn nearest_roots(surface: &LoopSurface, mesh: &LevelMesh) -> Vec<VertexId> {
    let (mut nearest, steps) = (vec![VertexId(NONE); mesh.vertices.len()], 1_u32 << mesh.level);
    for (code, corners) in mesh.codes.iter().zip(&mesh.corners) {
        let root = surface.mesh.face(code.root_face(mesh.level));
        for (&v, (i, j)) in corners.iter().zip(code.corners(mesh.level)) {
            let weights = [steps - i - j, i, j];
            let heaviest = (1..3).fold(0, |best, c| if weights[c] > weights[best] { c } else { best });
            nearest[v as usize] = root[heaviest];
        }
    }
    nearest
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

/// The vertices of `faces` that have whole rings and are free to move: not on a plain border, and
/// not where a given one meets it.
fn movable(mesh: &LevelMesh, faces: &[FaceCode]) -> Vec<u32> {
    let mut marked = vec![false; mesh.vertices.len()];
    for face in faces.iter().filter_map(|&f| mesh.find(f)) {
        mesh.corners[face as usize].iter().for_each(|&v| marked[v as usize] = true);
    }
    let free = |v: u32| match mesh.vertices[v as usize].kind {
        Kind::Interior => true,
        Kind::Given(g) => mesh.given[g as usize].end != SideEnd::Mixed,
        Kind::Plain | Kind::PlainCorner => false,
    };
    let whole = |v: u32| mesh.vertices[v as usize].ring == RingState::Whole;
    (0..mesh.vertices.len() as u32).filter(|&v| marked[v as usize] && whole(v) && free(v)).collect()
}

/// The vertices all of whose patches (those of two rings) are `inside`.
fn inner_vertices(mesh: &LevelMesh, inside: &dyn Fn(FaceCode) -> bool) -> Vec<bool> {
    let mut inner = vec![true; mesh.vertices.len()];
    for (code, corners) in mesh.codes.iter().zip(&mesh.corners) {
        if !inside(*code) {
            corners.iter().for_each(|&v| inner[v as usize] = false);
        }
    }
    for (v, vertex) in mesh.vertices.iter().enumerate() {
        if vertex.ring == RingState::Cut {
            inner[v] = false;
        }
    }
    // One more ring: a vertex with a neighbour that is not inner moves a patch outside.
    let outer: Vec<bool> = (0..mesh.vertices.len() as u32)
        .map(|v| !inner[v as usize] || mesh.neighbours(v).any(|n| !inner[n as usize]))
        .collect();
    outer.into_iter().map(|o| !o).collect()
}
