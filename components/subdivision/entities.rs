//! A combined Loop surface as entities: what a host spawns, reads and edits.
//!
//! ```text
//! surface        Cage, Sides, ControlPoints            few
//! control point  Position, ControlPointOf, its index   up to 1e6
//! detail         Detail, DetailLevel, Address, DetailOf
//! ```
//!
//! These are the truth. The gather stage derives the dense [`LoopSurface`] from them, as a
//! [`Snapshot`] on the surface. Control points and details are many and carry plain fields, not
//! relationships, so that they spawn, move and iterate as slices of tables; the summary tick of
//! each lets a whole table be passed over when nothing in it was touched.

use std::sync::Arc;

use bevy_ecs::prelude::{Component, Entity};
use glam::DVec3;

use super::surface::{Border, CornerRule, LoopSurface, Side, plain_sides};
use crate::guard::caught;
use crate::mesh::{Connectivity, VertexId};

/// The connectivity of a subdivision surface. What makes an entity a surface of this kind.
///
/// Written by the host; replace the whole to remesh. What else a surface needs comes with it, empty:
/// missing sides and control points are then faults with a name.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Sides, ControlPoints)]
pub struct Cage {
    /// Vertex `v` is control point `v` of [`ControlPoints`].
    pub mesh: Arc<Connectivity>,
}

/// What the borders of a surface are. A closed surface has none, and an empty value.
#[derive(Component, Clone, Debug, Default)]
pub struct Sides {
    /// Every border edge belongs to exactly one side.
    pub sides: Vec<Side>,
    /// What acts at a corner between two sides.
    pub corner_rule: CornerRule,
}

impl Sides {
    /// Every border of `mesh` plain, cut at the `corners`.
    pub fn plain(mesh: &Connectivity, corners: &[VertexId]) -> Self {
        Self { sides: plain_sides(mesh, corners), corner_rule: CornerRule::default() }
    }

    /// The revision of each side's curve; `None` for a plain side, and where the curve panics when
    /// asked.
    pub fn revisions(&self) -> Vec<Option<u64>> {
        let revision = |side: &Side| match &side.border {
            Border::Plain => None,
            Border::Given { curve, .. } => caught(|| curve.curve().revision()).ok(),
        };
        self.sides.iter().map(revision).collect()
    }

    /// Are these the borders that `surface` was gathered with? Curves are the same when they are
    /// one and the same object; whether that has changed inside, its revision tells.
    pub fn same_as(&self, surface: &LoopSurface) -> bool {
        self.corner_rule == surface.corner_rule
            && self.sides.len() == surface.sides.len()
            && self.sides.iter().zip(&surface.sides).all(|(a, b)| same_side(a, b))
    }
}

fn same_side(a: &Side, b: &Side) -> bool {
    let borders = match (&a.border, &b.border) {
        (Border::Plain, Border::Plain) => true,
        (
            Border::Given { curve: c, first: i, heading: h },
            Border::Given { curve: other_c, first: other_i, heading: other_h },
        ) => Arc::ptr_eq(c, other_c) && (i, h) == (other_i, other_h),
        _ => false,
    };
    borders && a.ends == b.ends && a.vertices == b.vertices
}

/// The control points of a surface, in the order of the vertices of its [`Cage`].
///
/// Always as long as the cage has vertices, and entry `i` is the entity that says it is control
/// point `i` of this surface: what disagrees is a fault, found by the gather stage.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub struct ControlPoints(pub Vec<Entity>);

/// Where a control point is, in model units. Edited by the host at will.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(summary_tick)]
pub struct Position(pub DVec3);

/// The surface that a control point belongs to.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(summary_tick)]
pub struct ControlPointOf(pub Entity);

/// Which control point of its surface this is: the vertex of the [`Cage`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(summary_tick)]
pub struct ControlPointIndex(pub u32);

/// A detail coefficient, in model units. With it go its level, its
/// [`Address`](super::Address) and its owner.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
#[component(summary_tick)]
pub struct Detail(pub DVec3);

/// The subdivision level that a detail coefficient acts at; 0 is the control mesh.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[component(summary_tick)]
pub struct DetailLevel(pub u32);

/// What a detail coefficient belongs to: a surface; or, while it is being worked out, the job that
/// does so. The surface is as it was until the job has finished.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[component(summary_tick)]
pub struct DetailOf(pub Entity);

/// The dense form of a surface: what every stage after the check reads.
///
/// Written by the gather stage; it is absent while the surface has a fault. Whoever holds the `Arc`
/// keeps the surface as it was; the next edit then makes another one.
#[derive(Component, Clone, Debug)]
pub struct Snapshot {
    /// The surface.
    pub surface: Arc<LoopSurface>,
    /// Rises whenever the surface has become another one, and only then; no two different surfaces
    /// of one world ever have the same.
    pub revision: u64,
    /// The revision at which anything but values changed last: the mesh, the sides, the curves, where
    /// details sit. Tables made from these are good as long as it stays.
    pub structure: u64,
    /// The revision of each side's curve when it was gathered; `None` for a plain side, and where
    /// the curve panicked when asked.
    pub curves: Vec<Option<u64>>,
}
