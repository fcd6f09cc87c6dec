//! How a trim went.

use bevy_ecs::prelude::{Component, Entity};
use glam::DVec3;

use crate::subdivision::fit::{Outcome, Rung};

/// What the relaxation did to the new vertices along one curve.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Relaxed {
    /// Sweeps made.
    pub sweeps: u32,
    /// The greatest distance of a knot from its isosceles place, along the rim edge and over its
    /// length: before and after.
    pub residual: [f64; 2],
    /// The worst shape of a triangle of the strip, `2 area / longest edge^2` (0.87 for an
    /// equilateral one): before and after.
    pub worst_shape: [f64; 2],
}

/// How a trim went. Written when it has finished; replaced whole when it has finished again. Trims
/// that touch are made together and have the same report.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct TrimReport {
    /// The trims made together, in their order; one that touches no other is alone.
    pub together: Vec<Entity>,
    /// How far the curves lie off the source, in model units.
    pub off: f64,
    /// The error of the cage alone, before any detail.
    pub initial: Option<Rung>,
    /// The error ladder, level by level.
    pub ladder: Vec<Rung>,
    /// How the fit ended.
    pub outcome: Outcome,
    /// Detail coefficients of the trims made together.
    pub details: usize,
    /// What relaxation did, by curve.
    pub relaxed: Vec<Relaxed>,
    /// What the new cage is like.
    pub cage: TrimmedCage,
    /// What the audit found.
    pub audit: TrimAudit,
    /// How the other side went, where it is wanted.
    pub other: Option<Box<OtherReport>>,
}

/// How the other side of a trim went: as the fields of [`TrimReport`] that have the same names.
#[derive(Clone, Debug, PartialEq)]
pub struct OtherReport {
    /// The error of the cage alone, before any detail.
    pub initial: Option<Rung>,
    /// The error ladder, level by level.
    pub ladder: Vec<Rung>,
    /// How the fit ended.
    pub outcome: Outcome,
    /// Its detail coefficients.
    pub details: usize,
    /// What its cage is like.
    pub cage: TrimmedCage,
    /// What the audit found.
    pub audit: TrimAudit,
}

/// What the cage is like that a trim leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrimmedCage {
    /// Its faces.
    pub faces: usize,
    /// Those of them over which the limit surface is still the source's, bit for bit.
    pub outside: usize,
    /// The farthest from a curve that a control point has changed, in model units.
    pub changed_radius: f64,
    /// The greatest valence among changed vertices.
    pub greatest_valence: u32,
    /// The worst `2 area / longest edge^2` of its changed faces, at their limit points.
    pub worst_shape: f64,
}

/// What an independent measurement of a trim found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrimAudit {
    /// The greatest distance from a point of the result to the source, in model units.
    pub to_source: f64,
    /// Where.
    pub to_source_at: DVec3,
    /// The greatest distance from a point of the source that stays to the result, in model units.
    pub to_result: f64,
    /// Where.
    pub to_result_at: DVec3,
    /// Points measured, both ways together.
    pub samples: usize,
    /// Border points compared with their curves, bit for bit.
    pub border_samples: usize,
    /// Border loops of the result.
    pub loops: usize,
    /// Vertices - edges + faces of the result.
    pub euler: i64,
}

impl TrimAudit {
    /// The greater of both distances, and where.
    pub fn greatest(&self) -> (f64, DVec3) {
        if self.to_result > self.to_source {
            (self.to_result, self.to_result_at)
        } else {
            (self.to_source, self.to_source_at)
        }
    }
}
