//! When things happen: the sets that a host orders its own systems against, and replaces ours in.
//!
//! Two levels. The phases, [`SelvedgeSystems`], are the same for every kind of surface, and run one
//! after the other once a pass. The stages of a method, such as [`SubdivisionStage`], run one after
//! the other inside [`SelvedgeSystems::Solve`].

use bevy_ecs::prelude::SystemSet;

/// The phases of a pass, in their order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SelvedgeSystems {
    /// Entities become dense snapshots, where a value has changed. Edit sources before it.
    Gather,
    /// Faults are named; what has one goes no further. Jobs begin here, and begin again.
    Check,
    /// Every job takes one step.
    Solve,
    /// Results become triangles.
    Triangulate,
    /// Results are measured anew, by other means than those that made them.
    Audit,
    /// Transitions, reports and failures are written. Read results after it.
    Finish,
}

impl SelvedgeSystems {
    /// All phases, in their order.
    pub const ALL: [Self; 6] = [Self::Gather, Self::Check, Self::Solve, Self::Triangulate, Self::Audit, Self::Finish];
}

/// The stages of subdivision surfaces, in their order: inside [`SelvedgeSystems::Solve`], but for
/// the last.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SubdivisionStage {
    /// Jobs begin, begin again, or are taken back.
    Admit,
    /// A trim's curve is worked into the control mesh.
    Remesh,
    /// Control points on a trim's curve settle along it.
    Relax,
    /// Points of a surface are paired with points of its target.
    Correspond,
    /// The details of the level in work are worked out.
    Modify,
    /// What is left is measured, and the next level is opened.
    Refine,
    /// Inside [`SelvedgeSystems::Finish`]: jobs move to their next stage, or end.
    Advance,
}

impl SubdivisionStage {
    /// All stages, in their order.
    pub const ALL: [Self; 7] =
        [Self::Admit, Self::Remesh, Self::Relax, Self::Correspond, Self::Modify, Self::Refine, Self::Advance];
}
