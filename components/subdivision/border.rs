//! A side between its vertices: its point and velocity anywhere.

use glam::DVec3;

use super::surface::{Border, Side};
use crate::curve::{CurveParameters, Heading, Traversal};

/// A place on an edge of level 0 of a curve's parameters.
struct CurvePlace<'a> {
    curve: &'a CurveParameters,
    edge: u64,
    share: f64,
    /// -1 where the side walks against the curve.
    sign: f64,
}

impl Side {
    /// The border's point at `share` in [0, 1] of the edge that begins `step` steps of `level` from
    /// the side's first vertex: the curve's own value. `None` on a plain side.
    pub fn point_on(&self, level: u32, step: u64, share: f64) -> Option<DVec3> {
        let at = self.curve_place(level, step, share)?;
        Some(at.curve.point_on(at.edge, at.share))
    }

    /// The derivative of [`Side::point_on`] along the side, in model units per edge of `level`; at
    /// both ends of the edge from inside the edge. `None` on a plain side.
    pub fn velocity_on(&self, level: u32, step: u64, share: f64) -> Option<DVec3> {
        let at = self.curve_place(level, step, share)?;
        Some(at.curve.velocity_on(at.edge, at.share) * (at.sign * half_to(level)))
    }

    fn curve_place(&self, level: u32, step: u64, share: f64) -> Option<CurvePlace<'_>> {
        let Border::Given { curve, first, heading } = &self.border else { return None };
        let edge = step >> level;
        let along = ((step - (edge << level)) as f64 + share) * half_to(level);
        let edge = Traversal { first: *first, heading: *heading }.edge(curve, 0, edge);
        Some(match heading {
            Heading::Along => CurvePlace { curve, edge, share: along, sign: 1.0 },
            Heading::Against => CurvePlace { curve, edge, share: 1.0 - along, sign: -1.0 },
        })
    }
}

/// `2^-level`, exactly.
pub(super) fn half_to(level: u32) -> f64 {
    0.5_f64.powi(level.min(1022) as i32)
}
