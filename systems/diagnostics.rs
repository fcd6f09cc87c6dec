//! What each stage did, and how long it took. Stages count; nobody prints.

use core::ops::AddAssign;
use std::time::{Duration, Instant};

use bevy_ecs::prelude::Resource;

/// What one stage did since the world began.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Time spent in the stage's system.
    pub time: Duration,
    /// How often the system ran.
    pub runs: u64,
    /// Entities read or worked on, one by one.
    pub items: u64,
    /// Tables that were gone through row by row: one per archetype that holds such entities.
    pub tables: u64,
    /// Tables and jobs passed over because nothing about them had changed.
    pub skipped: u64,
    /// Results written: snapshots, failures, values, transitions. A pass over a world in which no
    /// value has changed writes none.
    pub written: u64,
}

impl Counters {
    /// Begins to time one run of a system.
    pub fn start() -> Run {
        Run { start: Instant::now(), counted: Self::default() }
    }
}

impl AddAssign for Counters {
    fn add_assign(&mut self, other: Self) {
        self.time += other.time;
        self.runs += other.runs;
        self.items += other.items;
        self.tables += other.tables;
        self.skipped += other.skipped;
        self.written += other.written;
    }
}

/// One run of a system, being counted.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    start: Instant,
    /// What has been counted so far.
    pub counted: Counters,
}

impl Run {
    /// The run as counters: once more, and as long as since the start.
    pub fn finish(self) -> Counters {
        Counters { time: self.start.elapsed(), runs: 1, ..self.counted }
    }
}

/// Counters of the stages that every kind of surface goes through.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct GroundDiagnostics {
    /// Numbers given to new entities.
    pub enroll: Counters,
    /// Snapshots gathered from entities. Its items are control points and details.
    pub gather: Counters,
    /// Surfaces and curves checked.
    pub check: Counters,
    /// Surfaces triangulated.
    pub triangulate: Counters,
    /// Triangles audited.
    pub audit: Counters,
}

/// Counters of the stages of subdivision surfaces.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct SubdivisionDiagnostics {
    /// Jobs begun, begun again and taken back.
    pub admit: Counters,
    /// Jobs that take a quantum, and how many of them wait for a later pass (skipped).
    pub turns: Counters,
    /// Curves located on sources.
    pub locate: Counters,
    /// Quanta of curves worked into cages.
    pub remesh: Counters,
    /// Quanta of new vertices that settle.
    pub relax: Counters,
    /// Quanta of correspondence.
    pub correspond: Counters,
    /// Quanta of modification.
    pub modify: Counters,
    /// Quanta of refinement.
    pub refine: Counters,
    /// Quanta of the audits of trims.
    pub audit: Counters,
    /// Results put together of what trims have left.
    pub compose: Counters,
    /// Transitions written at the end of a pass.
    pub advance: Counters,
}
