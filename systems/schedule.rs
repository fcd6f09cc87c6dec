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
    /// Every job whose turn it is takes one step.
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
    /// Where more jobs are at work than a pass may move, it is said whose turn it is.
    Turn,
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
    pub const ALL: [Self; 8] = [
        Self::Admit,
        Self::Turn,
        Self::Remesh,
        Self::Relax,
        Self::Correspond,
        Self::Modify,
        Self::Refine,
        Self::Advance,
    ];
}

/// What one system of the engine does: what whoever replaces it must keep to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageContract {
    /// The set that the system is in, and by which it is replaced.
    pub set: &'static str,
    /// The name of the system's function.
    pub system: &'static str,
    /// What it does, in a sentence.
    pub does: &'static str,
    /// Components and resources that it reads, or that decide which entities it looks at.
    pub reads: &'static [&'static str],
    /// Components and resources whose values it writes.
    pub writes: &'static [&'static str],
    /// Components that it inserts, and entities (by their components) that it spawns.
    pub inserts: &'static [&'static str],
    /// Components that it removes, and entities that it despawns.
    pub removes: &'static [&'static str],
}

/// Every system, in the order in which they run; a set of several is listed system by system.
pub const STAGES: &[StageContract] = &[
    StageContract {
        set: "SelvedgeSystems::Gather",
        system: "enroll",
        does: "numbers surfaces, curves and jobs that are new",
        reads: &["Cage", "Fit", "Serial", "SpaceCurve", "Trim"],
        writes: &["GroundDiagnostics", "Serials"],
        inserts: &["Serial"],
        removes: &[],
    },
    StageContract {
        set: "SelvedgeSystems::Gather",
        system: "gather_surfaces",
        does: "brings snapshots up to date with their entities, where a value has changed",
        reads: &[
            "Address",
            "Budgets",
            "Cage",
            "ControlPointIndex",
            "ControlPointOf",
            "ControlPoints",
            "Detail",
            "DetailLevel",
            "DetailOf",
            "Disabled",
            "Position",
            "Serial",
            "Sides",
            "SurfaceFailed",
        ],
        writes: &["GroundDiagnostics", "Serials", "Snapshot"],
        inserts: &["Snapshot", "SurfaceFailed"],
        removes: &["Snapshot"],
    },
    StageContract {
        set: "SelvedgeSystems::Check",
        system: "check_curves",
        does: "refuses curves that have a fault",
        reads: &["CurveFailed", "CurveUnchecked", "SpaceCurve"],
        writes: &["GroundDiagnostics"],
        inserts: &["CurveFailed", "CurveUnchecked"],
        removes: &["CurveFailed", "CurveUnchecked"],
    },
    StageContract {
        set: "SelvedgeSystems::Check",
        system: "check_surfaces",
        does: "refuses surfaces that have a fault",
        reads: &["Budgets", "Snapshot", "SurfaceFailed"],
        writes: &["GroundDiagnostics"],
        inserts: &["SurfaceFailed"],
        removes: &["Snapshot", "SurfaceFailed"],
    },
    StageContract {
        set: "SubdivisionStage::Admit",
        system: "admit_fits",
        does: "begins jobs, begins again those whose inputs have changed, takes back what was cancelled",
        reads: &[
            "Budgets",
            "Cage",
            "Cancelled",
            "DetailOf",
            "Fit",
            "FitJob",
            "FitOptions",
            "FitTarget",
            "FitWork",
            "Serial",
            "Snapshot",
            "SurfaceFailed",
            "Tolerance",
        ],
        writes: &["SubdivisionDiagnostics"],
        inserts: &["AtCorrespond", "AtModify", "AtRefine", "FitFailed", "FitJob", "FitWork"],
        removes: &[
            "AtCorrespond",
            "AtModify",
            "AtRefine",
            "FitFailed",
            "FitJob",
            "FitWork",
            "entities with DetailOf(job)",
        ],
    },
    StageContract {
        set: "SubdivisionStage::Admit",
        system: "admit_trims",
        does: "begins trims, begins again those whose inputs have changed, groups those that are located",
        reads: &[
            "Budgets",
            "Cage",
            "Cancelled",
            "CurveFailed",
            "CurveUnchecked",
            "DetailOf",
            "Ground",
            "LocateWork",
            "PreImages",
            "Serial",
            "Snapshot",
            "Solved",
            "SpaceCurve",
            "SurfaceFailed",
            "Tolerance",
            "Trim",
            "TrimJob",
            "TrimOptions",
            "TrimWork",
        ],
        writes: &["SubdivisionDiagnostics"],
        inserts: &["AtLocate", "AtRemesh", "Ground", "LocateWork", "Stale", "TrimFailed", "TrimJob", "TrimWork"],
        removes: &[
            "AtAudit",
            "AtCorrespond",
            "AtLocate",
            "AtModify",
            "AtRefine",
            "AtRelax",
            "AtRemesh",
            "FitJob",
            "FitWork",
            "Ground",
            "LocateWork",
            "Solved",
            "TrimFailed",
            "TrimJob",
            "TrimWork",
            "TrimmedTo",
            "entities with DetailOf(trim)",
            "entities with ResultOf(source)",
        ],
    },
    StageContract {
        set: "SubdivisionStage::Turn",
        system: "give_turns",
        does: "says which jobs take a work quantum in this pass, where there are more than it may do",
        reads: &[
            "AtAudit",
            "AtCorrespond",
            "AtLocate",
            "AtModify",
            "AtRefine",
            "AtRelax",
            "AtRemesh",
            "PassAllowance",
            "Serial",
        ],
        writes: &["SubdivisionDiagnostics", "Turns"],
        inserts: &[],
        removes: &[],
    },
    StageContract {
        set: "SubdivisionStage::Remesh",
        system: "locate_trims",
        does: "lets trims AtLocate find where a curve runs on their source, and sets their step",
        reads: &["AtLocate", "Turns"],
        writes: &["LocateWork", "SubdivisionDiagnostics", "TrimJob"],
        inserts: &[],
        removes: &[],
    },
    StageContract {
        set: "SubdivisionStage::Remesh",
        system: "remesh_trims",
        does: "lets trims AtRemesh work their curves into the cage, and sets their step",
        reads: &["AtRemesh", "Turns"],
        writes: &["SubdivisionDiagnostics", "TrimJob", "TrimWork"],
        inserts: &[],
        removes: &[],
    },
    StageContract {
        set: "SubdivisionStage::Relax",
        system: "relax_trims",
        does: "lets new vertices of trims AtRelax settle along the curves, begins a fit, and sets their step",
        reads: &["AtRelax", "Turns"],
        writes: &["SubdivisionDiagnostics", "TrimJob", "TrimWork"],
        inserts: &[],
        removes: &[],
    },
    StageContract {
        set: "SubdivisionStage::Correspond",
        system: "correspond_fits",
        does: "lets jobs AtCorrespond do one quantum and sets their step",
        reads: &["AtCorrespond", "Turns"],
        writes: &["FitJob", "FitWork", "SubdivisionDiagnostics"],
        inserts: &[],
        removes: &[],
    },
    StageContract {
        set: "SubdivisionStage::Modify",
        system: "modify_fits",
        does: "lets jobs AtModify do one quantum and sets their step; writes the details of those that leave",
        reads: &["Address", "AtModify", "DetailLevel", "DetailOf", "Turns"],
        writes: &["Detail", "FitJob", "FitWork", "SubdivisionDiagnostics"],
        inserts: &[],
        removes: &[],
    },
    StageContract {
        set: "SubdivisionStage::Refine",
        system: "refine_fits",
        does: "lets jobs AtRefine do one quantum and sets their step; spawns what the next level may move",
        reads: &["AtRefine", "Detail", "DetailOf", "Turns"],
        writes: &["FitJob", "FitWork", "SubdivisionDiagnostics"],
        inserts: &["entities with Detail, DetailLevel, Address, DetailOf(job)"],
        removes: &["entities with DetailOf(job) that are zero"],
    },
    StageContract {
        set: "SelvedgeSystems::Triangulate",
        system: "triangulate_surfaces",
        does: "goes on triangulating surfaces that ask for it, where surface or options have become other ones",
        reads: &["Budgets", "Snapshot", "Tolerance", "TriangulateOptions", "Triangulated"],
        writes: &["GroundDiagnostics", "Triangulating"],
        inserts: &["Triangles", "Triangulated", "Triangulating", "TriangulationFailed", "TriangulationReport"],
        removes: &["Triangulating", "TriangulationFailed"],
    },
    StageContract {
        set: "SelvedgeSystems::Audit",
        system: "audit_surfaces",
        does: "measures new triangles by other means than those that made them, where that is asked for",
        reads: &["AuditOptions", "Snapshot", "Triangles", "Triangulated", "TriangulationFailed"],
        writes: &["GroundDiagnostics"],
        inserts: &["AuditReport"],
        removes: &[],
    },
    StageContract {
        set: "SelvedgeSystems::Audit",
        system: "audit_trims",
        does: "lets trims AtAudit measure some faces of what they leave, and sets their step",
        reads: &["AtAudit", "FitWork", "Turns"],
        writes: &["SubdivisionDiagnostics", "TrimJob", "TrimWork"],
        inserts: &[],
        removes: &[],
    },
    StageContract {
        set: "SubdivisionStage::Advance",
        system: "advance_fits",
        does: "takes the step of every job: moves its marker, delivers its result, or tells its failure",
        reads: &["Address", "DetailLevel", "Fit", "FitWork"],
        writes: &["Detail", "DetailOf", "FitJob", "SubdivisionDiagnostics"],
        inserts: &[
            "AtCorrespond",
            "AtModify",
            "AtRefine",
            "FitFailed",
            "FitReport",
            "entities with Detail, DetailLevel, Address, DetailOf(surface)",
        ],
        removes: &["AtCorrespond", "AtModify", "AtRefine", "FitWork", "entities with DetailOf(job or surface)"],
    },
    StageContract {
        set: "SubdivisionStage::Advance",
        system: "advance_trims",
        does: "takes the step of every trim: moves its marker, keeps what it leaves, or tells its failure",
        reads: &["Address", "DetailLevel", "FitWork", "Trim"],
        writes: &[
            "Detail",
            "DetailOf",
            "FitJob",
            "LocateWork",
            "Serials",
            "SubdivisionDiagnostics",
            "TrimJob",
            "TrimWork",
        ],
        inserts: &[
            "AtAudit",
            "AtCorrespond",
            "AtModify",
            "AtRefine",
            "AtRelax",
            "AtRemesh",
            "FitJob",
            "FitWork",
            "Solved",
            "TrimFailed",
            "TrimReport",
            "entities with Detail, DetailLevel, Address, DetailOf(trim)",
        ],
        removes: &[
            "AtAudit",
            "AtCorrespond",
            "AtLocate",
            "AtModify",
            "AtRefine",
            "AtRelax",
            "AtRemesh",
            "FitJob",
            "FitWork",
            "LocateWork",
            "Solved",
            "TrimReport",
            "TrimWork",
            "entities with DetailOf(trim)",
        ],
    },
    StageContract {
        set: "SubdivisionStage::Advance",
        system: "compose_results",
        does: "puts together what is left of each source, once none of its trims is at work",
        reads: &[
            "ComposedOf",
            "DetailOf",
            "Ground",
            "OtherSide",
            "OtherSideOf",
            "ResultOf",
            "Serial",
            "Solved",
            "Stale",
            "Trim",
            "TrimmedTo",
        ],
        writes: &["Serials", "SubdivisionDiagnostics", "TrimJob"],
        inserts: &[
            "OtherSide",
            "Stale",
            "TrimFailed",
            "TrimmedTo",
            "entities with Snapshot, ComposedOf, ResultOf or OtherSideOf",
        ],
        removes: &[
            "LocateWork",
            "OtherSide",
            "Solved",
            "Stale",
            "TrimReport",
            "entities with DetailOf(trim)",
            "entities with OtherSideOf(trim)",
            "entities with ResultOf of a source that has gone",
        ],
    },
];
