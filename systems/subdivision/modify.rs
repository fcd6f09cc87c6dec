//! # Modify: the details of the level in work
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the residuals | the level's details and state | correspond | correspond (another round) or refine |
//!
//! The least-squares rule. The unknown `x` is the move of each effective control point: an interior
//! point takes it, on a given border the detail takes it with the other sign, for the point stays
//! on the curve. One linear map serves all: `K = L S`, where `S` holds the rules of one subdivision
//! and `L` the limit masks one level finer. `|K x - r|^2` is made small by conjugate gradients on
//! the normal equations (CGLS), scaled by `1 / diag(K^T K)`. The scaled singular values of `K` lie
//! in `[0.18, 2]` on every level, so a fixed number of steps converges and everything stays local.
//!
//! Where the surface is not regular, at corners and at borders, it needs no rule of its own.

use glam::DVec3;
use selvedge_components::subdivision::{LimitRows, Rows, Step};

use super::chain;
use super::fit::{FitError, FitWork, Quantum, Rule, Stage};
use super::open::OpenLevel;
use crate::parallel::{map_dear_in_order, map_in_order};

/// Steps of CGLS per round. With a condition of at most 11 the error after ten steps is below what
/// the next level changes; 20 or 40 steps change the ladders by less than 5 %.
pub const STEPS: u32 = 10;

/// Rounds at level 0, where the surface may start far from its target; later levels start close.
pub(super) const FIRST_ROUNDS: u32 = 3;

/// Rows of the matrix that are made together.
const ROWS: usize = 256;

/// One least-squares problem on its way.
#[derive(Debug)]
pub struct Solve {
    matrix: Rows,
    transposed: Rows,
    scale: Vec<f64>,
    /// The solution so far.
    x: Vec<DVec3>,
    residual: Vec<DVec3>,
    direction: Vec<DVec3>,
    /// Squared norms of the scaled gradient, by coordinate.
    gamma: DVec3,
    steps: u32,
}

impl FitWork {
    /// One step of the solve; after the last one, the moves are made and the level is measured or
    /// goes round again.
    ///
    /// # Errors
    /// None at present; kept for the stages' common shape.
    pub fn modify(&mut self) -> Result<Quantum, FitError> {
        if let Rule::Quasi { boundary, corner } = self.options.rule {
            return Ok(self.quasi(boundary, corner));
        }
        let open = &mut self.open;
        let Some(solve) = &mut open.solve else {
            // Two of the larger pieces of work, a quantum each.
            match open.response.take() {
                None => {
                    let vertices = open.levels[0].mesh.vertices.len();
                    open.response = Some(response(&open.fit_rows, &open.steps[0], &open.movable, vertices));
                }
                Some(matrix) => {
                    let residuals = core::mem::take(&mut open.residuals);
                    open.solve = Some(Solve::new(matrix, open.movable.len(), residuals));
                }
            }
            return Ok(Quantum::More);
        };
        if solve.step() {
            return Ok(Quantum::More);
        }
        let moves = open.solve.take().map_or(Vec::new(), |s| s.x);
        self.take_moves(&moves);
        self.open.round += 1;
        let again = self.open.level == 0 && self.open.round < FIRST_ROUNDS;
        Ok(self.go_to(if again { Stage::Correspond } else { Stage::Refine }))
    }

    /// Moves the effective points of the level in work and everything that follows from them.
    pub(super) fn take_moves(&mut self, moves: &[DVec3]) {
        let storage = self.options.storage;
        let open = &mut self.open;
        for (i, &x) in moves.iter().enumerate() {
            let total = storage.round(open.moves[i] + x);
            let change = total - open.moves[i];
            open.moves[i] = total;
            let base = &mut open.levels[0];
            chain::shift(&base.mesh, &mut base.state, open.movable[i], change);
        }
        store(open, &self.remembering.details, &mut self.details);
        let [base, finer, finest] = &mut open.levels;
        let own = &self.remembering.details;
        finer.state = chain::advance(&self.remembering, &self.corners, own, &open.steps[0], base, &finer.mesh);
        finest.state = chain::advance(&self.remembering, &self.corners, own, &open.steps[1], finer, &finest.mesh);
        open.residuals.clear();
        open.distances.clear();
        open.measured.clear();
    }
}

/// Writes the level's moves, on top of the source's own details, into `details`.
fn store(
    open: &OpenLevel,
    own: &selvedge_components::subdivision::Details,
    details: &mut selvedge_components::subdivision::Details,
) {
    let level = open.level as usize;
    if details.levels.len() <= level {
        details.levels.resize(level + 1, Vec::new());
    }
    let mesh = &open.levels[0].mesh;
    let mut stored: Vec<_> = own.levels.get(level).cloned().unwrap_or_default();
    let kept = stored.len();
    for (&v, &x) in open.movable.iter().zip(&open.moves) {
        let address = open.addresses[v as usize];
        let d = chain::interior_sign(mesh, v) * x;
        match stored[..kept].binary_search_by_key(&address, |d| d.0) {
            Ok(at) => stored[at].1 += d,
            Err(_) if d != DVec3::ZERO => stored.push((address, d)),
            Err(_) => {}
        }
    }
    stored.sort_unstable_by_key(|d| d.0);
    details.levels[level] = stored;
}

/// `K = L S` over the movable vertices: the response of the fitted limit points to their moves.
pub fn response(limit: &LimitRows, step: &Step, movable: &[u32], vertices: usize) -> Rows {
    const NONE: u32 = u32::MAX;
    let mut column = vec![NONE; vertices];
    for (i, &v) in movable.iter().enumerate() {
        column[v as usize] = i as u32;
    }
    let parts = map_dear_in_order(limit.rows.len().div_ceil(ROWS), |part| {
        let (mut rows, mut row) = (Rows::new(), Vec::<(u32, f64)>::with_capacity(32));
        for r in part * ROWS..limit.rows.len().min((part + 1) * ROWS) {
            let (finer, masks) = limit.rows.row(r);
            for (&f, &mask) in finer.iter().zip(masks) {
                let (columns, weights) = step.rows.row(f as usize);
                for (&c, &w) in columns.iter().zip(weights) {
                    let c = column[c as usize];
                    if c == NONE {
                        continue;
                    }
                    match row.iter_mut().find(|e| e.0 == c) {
                        Some(entry) => entry.1 += mask * w,
                        None => row.push((c, mask * w)),
                    }
                }
            }
            rows.push(row.drain(..));
        }
        rows
    });
    let mut matrix = Rows::new();
    parts.iter().for_each(|part| matrix.append(part));
    matrix
}

/// The transpose; entries of its rows ascend.
fn transpose(matrix: &Rows, columns: usize) -> Rows {
    let mut ends = vec![0_usize; columns + 1];
    for r in 0..matrix.len() {
        matrix.row(r).0.iter().for_each(|&c| ends[c as usize + 1] += 1);
    }
    (0..columns).for_each(|c| ends[c + 1] += ends[c]);
    // Filled from its beginning, each list ends where the next one began.
    let mut entries = vec![(0, 0.0); ends[columns]];
    for r in 0..matrix.len() {
        let (cs, ws) = matrix.row(r);
        for (&c, &w) in cs.iter().zip(ws) {
            entries[ends[c as usize]] = (r as u32, w);
            ends[c as usize] += 1;
        }
    }
    let mut out = Rows::new();
    let mut begin = 0;
    for &end in &ends[..columns] {
        out.push(entries[begin..end].iter().copied());
        begin = end;
    }
    out
}

impl Solve {
    /// Begins `min |matrix x - residual|^2` at `x = 0`.
    pub fn new(matrix: Rows, columns: usize, residual: Vec<DVec3>) -> Self {
        let transposed = transpose(&matrix, columns);
        let scale = (0..columns)
            .map(|c| {
                let norm: f64 = transposed.row(c).1.iter().map(|w| w * w).sum();
                // A vertex without influence does not move.
                if norm > 0.0 { 1.0 / norm } else { 0.0 }
            })
            .collect();
        let mut solve = Self {
            matrix,
            transposed,
            scale,
            x: vec![DVec3::ZERO; columns],
            residual,
            direction: Vec::new(),
            gamma: DVec3::ZERO,
            steps: 0,
        };
        let (direction, gamma) = solve.gradient();
        (solve.direction, solve.gamma) = (direction, gamma);
        solve
    }

    /// One step of CGLS; `false` when there are no more to take.
    pub fn step(&mut self) -> bool {
        if self.steps == STEPS || self.gamma == DVec3::ZERO {
            return false;
        }
        self.steps += 1;
        let image = map_in_order(self.matrix.len(), |r| self.matrix.dot(r, &self.direction));
        let squared = image.iter().fold(DVec3::ZERO, |sum, q| sum + *q * *q);
        let a = ratio(self.gamma, squared);
        self.x.iter_mut().zip(&self.direction).for_each(|(x, d)| *x += a * *d);
        self.residual.iter_mut().zip(&image).for_each(|(r, q)| *r -= a * *q);
        let (scaled, gamma) = self.gradient();
        let b = ratio(gamma, self.gamma);
        self.direction.iter_mut().zip(&scaled).for_each(|(d, z)| *d = *z + b * *d);
        self.gamma = gamma;
        true
    }

    /// The solution so far.
    pub fn solution(&self) -> &[DVec3] {
        &self.x
    }

    /// The scaled gradient and its squared norm in the scaling.
    fn gradient(&self) -> (Vec<DVec3>, DVec3) {
        let gradient = map_in_order(self.transposed.len(), |c| self.transposed.dot(c, &self.residual));
        let scaled: Vec<DVec3> = gradient.iter().zip(&self.scale).map(|(g, &s)| *g * s).collect();
        let gamma = gradient.iter().zip(&scaled).fold(DVec3::ZERO, |sum, (g, z)| sum + *g * *z);
        (scaled, gamma)
    }
}

/// By coordinate; a coordinate that has converged exactly stays where it is.
fn ratio(a: DVec3, b: DVec3) -> DVec3 {
    let divide = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    DVec3::new(divide(a.x, b.x), divide(a.y, b.y), divide(a.z, b.z))
}
