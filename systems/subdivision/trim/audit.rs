//! # Audit of a trim: the result against its source, by other means than those that made it
//!
//! Distances are measured at random places, both ways, by Gauss-Newton steps from places that
//! correspond, over the faces that the trim could change: beyond them the limit surface has the bits
//! it had. Source points under the strip need no way back of their own: the feet of the strip's
//! samples are such points, and lie as near to the result as the samples to them. Borders are
//! compared with the curves themselves; edges, loops and pieces are counted.

use std::sync::{Arc, OnceLock};

use glam::{DVec2, DVec3};
use selvedge_components::curve::Traversal;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{Border, Ends, FaceCode, LoopSurface};
use selvedge_components::trim::{TrimAudit, TrimAuditFault, TrimFault, TrimOptions, TrimQuantum};

use super::ground::{Ground, unevaluated};
use crate::closest::SurfaceIndex;
use crate::foot;
use crate::parallel::map_dear_in_order;
use crate::subdivision::limit::{LimitBuild, LimitSurface, Nest};
use crate::subdivision::remesh::{FaceOrigin, Remeshed};

/// Faces measured in one work quantum: some milliseconds.
const QUANTUM: usize = 64;

/// Steps that end within this part of what is taken for near have most likely found the foot.
const LIKELY: f64 = 0.5;

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
        let build = LimitBuild::new(Arc::clone(&surface)).map_err(|why| unevaluated(&why))?;
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
    /// How many faces of Omega are measured.
    measured: usize,
    /// How many sides are compared with their curves.
    compared: usize,
    found: TrimAudit,
    faults: Vec<TrimAuditFault>,
}

/// Is a distance within another? One that is no number is not within any.
fn is_within(distance: f64, other: f64) -> bool {
    distance <= other
}

impl Measuring {
    fn new(
        Given { ground, remeshed, allowed, samples, seed }: Given,
        surface: Arc<LoopSurface>,
        limit: LimitSurface,
    ) -> Self {
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

    /// Samples one face of the result, and the piece of the source that it stands for. What is no farther
    /// than the farthest so far is not measured to the end.
    fn measure(&self, face: FaceId) -> TrimAudit {
        let mut draw = Draw::new(self.seed, face.0);
        let mut found = TrimAudit { samples: 0, ..self.found };
        let origin = self.remeshed.face_origin[face.index()];
        let mut result = Nest::new(&self.limit, face);
        let mut source = match origin {
            FaceOrigin::Leaf { level, code } => {
                Some((level, code, Nest::new(self.ground.limit(), code.root_face(level))))
            }
            _ => None,
        };
        for _ in 0..self.samples {
            let weights = draw.weights();
            let x = result.position(result.root(), weights);
            let mut off = f64::INFINITY;
            if let Some((level, code, source)) = &mut source {
                off = x.distance(position(source, code.place(*level, weights)));
            }
            // The place with the same weights is no nearer than the foot.
            if !is_within(off, found.to_source) {
                off = self.to_source(self.start(face, origin, weights), x, found.to_source);
            }
            farther(&mut found, &TrimAudit { to_source: off, to_source_at: x, samples: 1, ..TrimAudit::default() });
            if let Some((level, code, source)) = &mut source {
                let aside = draw.weights_near(weights);
                let y = position(source, code.place(*level, aside));
                let mut off = y.distance(result.position(result.root(), aside));
                if !is_within(off, found.to_result) {
                    off = self.to_result(SurfacePoint::new(face, aside[1], aside[2]), y, found.to_result);
                }
                farther(&mut found, &TrimAudit { to_result: off, to_result_at: y, samples: 1, ..TrimAudit::default() });
            }
        }
        found
    }

    /// A place of the source near the foot of the place of the result where the corners of `face` weigh
    /// `weights`: the same of the piece that it stands for, or between the places that its corners stand
    /// for, or that of the nearest corner.
    fn start(&self, face: FaceId, origin: FaceOrigin, weights: [f64; 3]) -> SurfacePoint {
        if let FaceOrigin::Leaf { level, code } = origin {
            return code.place(level, weights);
        }
        let natural = self.surface.mesh.face(face).map(|v| self.remeshed.natural[v.index()]);
        if natural.iter().all(|at| at.face == natural[0].face) {
            let st = (0..3).fold(DVec2::ZERO, |sum, c| sum + natural[c].st * weights[c]);
            return SurfacePoint::new(natural[0].face, st.x, st.y);
        }
        let heaviest = (1..3).fold(0, |best, c| if weights[c] > weights[best] { c } else { best });
        natural[heaviest]
    }

    /// The distance of a point of the result to the source, from above, or something within `enough`: by
    /// steps from `start`, or if those lead to no near foot, from all over its face, or by a search
    /// everywhere.
    fn to_source(&self, start: SurfacePoint, x: DVec3, enough: f64) -> f64 {
        let (source, mesh) = (&**self.ground.limit(), &self.ground.surface.mesh);
        let off = self.steps(source, mesh, start, x, enough);
        if off <= self.near.max(enough) {
            return off;
        }
        self.ground.index.closest(x).map_or(off, |found| off.min(found.distance))
    }

    /// The distance of a point of the source to the result, likewise.
    fn to_result(&self, start: SurfacePoint, y: DVec3, enough: f64) -> f64 {
        let off = self.steps(&self.limit, &self.surface.mesh, start, y, enough);
        if off <= self.near.max(enough) {
            return off;
        }
        let index = self.searched.get_or_init(|| SurfaceIndex::new(Arc::clone(&self.limit)).ok());
        let found = index.as_ref().and_then(|index| index.closest(y).ok());
        found.map_or(off, |found| off.min(found.distance))
    }

    fn steps(&self, surface: &LimitSurface, mesh: &Connectivity, start: SurfacePoint, x: DVec3, enough: f64) -> f64 {
        let off = foot::distance(surface, mesh, [start], x, enough);
        if off <= enough.max(LIKELY * self.near) {
            return off;
        }
        let around = foot::AROUND.map(|w| SurfacePoint::new(start.face, w[1], w[2]));
        off.min(foot::distance(surface, mesh, around, x, enough))
    }

    fn judge_distances(&self, faults: &mut Vec<TrimAuditFault>) {
        let Some(limit) = self.allowed else { return };
        let TrimAudit { to_source, to_source_at, to_result, to_result_at, .. } = self.found;
        let both = [
            ("the result from the source", to_source, to_source_at),
            ("the source from the result", to_result, to_result_at),
        ];
        for (what, distance, at) in both {
            if distance > limit || distance.is_nan() {
                faults.push(TrimAuditFault::Distance { what, distance, limit, at });
            }
        }
    }

    /// Every border sample of a side of the result is its curve's own value. Returns how many there are.
    fn compare(&self, s: usize) -> (usize, Vec<TrimAuditFault>) {
        let (mesh, side) = (&self.surface.mesh, &self.surface.sides[s]);
        let Border::Given { curve, first, heading } = &side.border else { return (0, Vec::new()) };
        let along = Traversal { first: *first, heading: *heading };
        // Where a side begins at a corner, the older of the two that meet gives the bits.
        let first_step = u64::from(side.ends == Ends::Corners);
        // Vertices of the side, and places two levels below, through the evaluator.
        let steps = |level: u32| (first_step..(side.edge_count() as u64) << level).map(move |step| (level, step));
        let places: Vec<(u32, u64)> = [0, 2].into_iter().flat_map(steps).collect();
        let faults = map_dear_in_order(places.len(), |i| {
            let (level, step) = places[i];
            let u = curve.parameter(level, along.vertex(curve, level, step));
            let (edge, part) = ((step >> level) as usize, step & ((1 << level) - 1));
            let ends = [edge, (edge + 1) % side.vertices.len()].map(|i| side.vertices[i]);
            let at = on_edge(mesh, ends, part as f64 / f64::from(1_u32 << level))?;
            let (found, sample) = (self.limit.position(at), curve.curve().position(u));
            let same = found.to_array().map(f64::to_bits) == sample.to_array().map(f64::to_bits);
            Some((!same).then_some(TrimAuditFault::OffCurve { side: s, u, at: found, sample }))
        });
        let compared = faults.iter().flatten().count();
        (compared, faults.into_iter().flatten().flatten().collect())
    }

    /// Borders are simple loops made of sides; loops, parts and Euler number make a surface that is no
    /// more knotted than the source.
    fn judge_topology(&mut self, faults: &mut Vec<TrimAuditFault>) {
        let mesh = &self.surface.mesh;
        let loops = mesh.border_loops();
        let edges: usize = loops.iter().map(Vec::len).sum();
        let named: usize = self.surface.sides.iter().map(|side| side.edge_count()).sum();
        if edges != named {
            faults.push(TrimAuditFault::Border { edges, named });
        }
        let (euler, parts) = (mesh.euler(), parts(mesh));
        (self.found.loops, self.found.euler) = (loops.len(), euler);
        // Twice the genus of all parts together: even, and not above the source's.
        let twice_genus = 2 * parts as i64 - euler - loops.len() as i64;
        let source = &self.ground.surface.mesh;
        let most = 2 * self::parts(source) as i64 - source.euler() - source.border_loops().len() as i64;
        if twice_genus < 0 || twice_genus % 2 != 0 || twice_genus > most {
            faults.push(TrimAuditFault::Euler { euler, loops: loops.len(), parts });
        }
    }

    /// The pieces of the source that are kept, cut and removed make up each of its faces once.
    fn judge_cover(&self, faults: &mut Vec<TrimAuditFault>) {
        let mut shares = vec![0.0; self.ground.surface.mesh.face_count()];
        for &(level, code, _) in &self.remeshed.fates {
            shares[code.root_face(level).index()] += 0.25_f64.powi(level as i32);
        }
        for (face, &share) in (0_u32..).zip(&shares) {
            // A sum of quarters of quarters is exact.
            if share != 1.0 {
                faults.push(TrimAuditFault::Cover { face, share });
            }
        }
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

/// The limit position at a place of the root face of `nest`.
fn position(nest: &mut Nest<'_>, SurfacePoint { st, .. }: SurfacePoint) -> DVec3 {
    nest.position(nest.root(), [(1.0 - st.x - st.y).max(0.0), st.x, st.y])
}

/// The place of the border edge between `ends`, walked with the surface on the left, at `share` of
/// the way.
fn on_edge(mesh: &Connectivity, ends: [VertexId; 2], share: f64) -> Option<SurfacePoint> {
    let h: HalfedgeId = mesh.ring(ends[0]).find(|&h| mesh.to(h) == ends[1])?;
    let mut weights = [0.0; 3];
    let corner = h.corner();
    (weights[corner], weights[(corner + 1) % 3]) = (1.0 - share, share);
    Some(SurfacePoint::new(h.face(), weights[1], weights[2]))
}

/// How many connected parts a mesh has.
fn parts(mesh: &Connectivity) -> usize {
    let mut seen = vec![false; mesh.face_count()];
    let mut parts = 0;
    for f in 0..mesh.face_count() {
        if core::mem::replace(&mut seen[f], true) {
            continue;
        }
        parts += 1;
        let mut stack = vec![FaceId::new(f)];
        while let Some(face) = stack.pop() {
            for corner in 0..3 {
                if let Some(twin) = mesh.twin(HalfedgeId::of(face, corner))
                    && !core::mem::replace(&mut seen[twin.face().index()], true)
                {
                    stack.push(twin.face());
                }
            }
        }
    }
    parts
}

/// Random places, the same for the same seed and face.
struct Draw(u64);

impl Draw {
    fn new(seed: u64, face: u32) -> Self {
        Self(seed ^ u64::from(face).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Between 0 and 1, by splitmix64 (Steele et al. 2014).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Weights of the corners of a triangle, evenly spread over it.
    fn weights(&mut self) -> [f64; 3] {
        let (mut s, mut t) = (self.unit(), self.unit());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        [1.0 - s - t, s, t]
    }

    /// Other weights, a little aside: a place of the source that is no foot of the first.
    fn weights_near(&mut self, weights: [f64; 3]) -> [f64; 3] {
        let other = self.weights();
        [0, 1, 2].map(|c| 0.9 * weights[c] + 0.1 * other[c])
    }
}
