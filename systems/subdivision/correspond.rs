//! # Correspond: which point of the target stands for which limit point
//!
//! | reads | writes | after | before |
//! | --- | --- | --- | --- |
//! | the level's state, the target | the residuals of the fitted rows | refine, or modify of the round before | modify |
//!
//! The natural correspondence is the limit point itself; a limited search from there finds the
//! closest point of the target. It is found anew in every round, because the surface has moved.

use super::fit::{FitError, FitWork, Quantum, Rule, Stage};
use super::open::keep;
use crate::parallel::map_in_order;

/// Closest points per work quantum.
const QUANTUM: usize = 4096;

impl FitWork {
    /// Finds the next closest points; all of them found, [`Stage::Modify`] is next.
    ///
    /// # Errors
    /// When the target has no answer.
    pub fn correspond(&mut self) -> Result<Quantum, FitError> {
        let open = &mut self.open;
        let begin = open.residuals.len();
        let end = open.fit_rows.vertices.len().min(begin + QUANTUM);
        let (rows, state, target, hints) = (&open.fit_rows, &open.levels[1].state, &self.target, &open.hints);
        let quasi = matches!(self.options.rule, Rule::Quasi { .. });
        let (surface, natural, mesh) = (&self.remembering, &self.natural, &open.levels[1].mesh);
        let all = rows.apply_range(state, begin..end);
        let found = map_in_order(end - begin, |i| {
            // The stencils of the quasi rule read the residuals at the level's own vertices only.
            if quasi && !super::quasi::is_read(mesh, rows.vertices[begin + i]) {
                return Ok((glam::DVec3::ZERO, None));
            }
            let natural = || natural.place(&surface.mesh, mesh, rows.vertices[begin + i]);
            let hint = hints.get(begin + i).copied().unwrap_or_else(natural);
            let foot = target.closest(all[i], hint)?;
            Ok((foot.position - all[i], foot.at))
        });
        for found in found {
            let (residual, at) = found.map_err(FitError::Target)?;
            keep(&mut open.hints, open.residuals.len(), at);
            open.residuals.push(residual);
        }
        Ok(if end < open.fit_rows.vertices.len() { Quantum::More } else { self.go_to(Stage::Modify) })
    }
}
