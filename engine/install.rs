//! The engine moves into a host's world and schedule.

use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildSettings};
use selvedge_components::budget::{Budgets, PassAllowance};
use selvedge_components::identity::Serials;
use selvedge_systems::audit::audit_surfaces;
use selvedge_systems::check::{check_curves, check_surfaces};
use selvedge_systems::diagnostics::{GroundDiagnostics, SubdivisionDiagnostics};
use selvedge_systems::enroll::enroll;
use selvedge_systems::gather::gather_surfaces;
use selvedge_systems::schedule::{SelvedgeSystems, SubdivisionStage};
use selvedge_systems::subdivision::job::{admit_fits, advance_fits};
use selvedge_systems::subdivision::trim::{
    admit_trims, advance_trims, audit_trims, compose_results, locate_trims, relax_trims, remesh_trims,
};
use selvedge_systems::subdivision::turns::{Turns, give_turns};
use selvedge_systems::subdivision::{correspond_fits, modify_fits, refine_fits};
use selvedge_systems::triangulate::triangulate_surfaces;

/// Puts the engine into `schedule`, once.
///
/// The schedule stays the host's: its label, its executor, when and how often it runs, and what
/// else runs in it. The engine adds resources of its own to `world` and keeps those that are there
/// already ([`Budgets`] or [`PassAllowance`], say); it reads and writes entities that bear its components, and no others.
///
/// Every stage is in a public set, and can be replaced: take its systems out with
/// [`Schedule::remove_systems_in_set`] and add your own to the same set. What a stage must do is
/// written at its set, and listed by [`STAGES`](selvedge_systems::schedule::STAGES).
///
/// ```
/// use bevy_ecs::prelude::*;
/// use selvedge::schedule::SelvedgeSystems;
///
/// let (mut world, mut schedule) = (World::new(), Schedule::default());
/// selvedge::install(&mut world, &mut schedule);
/// schedule.add_systems((|| { /* edit sources */ }).before(SelvedgeSystems::Gather));
/// schedule.add_systems((|| { /* read results */ }).after(SelvedgeSystems::Finish));
/// schedule.run(&mut world);
/// ```
pub fn install(world: &mut World, schedule: &mut Schedule) {
    world.init_resource::<Serials>();
    world.init_resource::<Budgets>();
    world.init_resource::<PassAllowance>();
    world.init_resource::<Turns>();
    world.init_resource::<GroundDiagnostics>();
    world.init_resource::<SubdivisionDiagnostics>();

    use SelvedgeSystems::{Audit, Check, Finish, Gather, Solve, Triangulate};
    schedule.configure_sets((Gather, Check, Solve, Triangulate, Audit, Finish).chain());
    schedule.add_systems((enroll, gather_surfaces).chain().in_set(Gather));
    schedule.add_systems((check_curves, check_surfaces).chain().in_set(Check));

    schedule.add_systems(triangulate_surfaces.in_set(Triangulate));
    schedule.add_systems((audit_surfaces, audit_trims).chain().in_set(Audit));

    use SubdivisionStage::{Admit, Advance, Correspond, Modify, Refine, Relax, Remesh, Turn};
    schedule.configure_sets((Admit, Turn, Remesh, Relax, Correspond, Modify, Refine).chain().in_set(Solve));
    schedule.configure_sets(Advance.in_set(Finish));
    schedule.add_systems((admit_fits, admit_trims).chain().in_set(Admit));
    schedule.add_systems(give_turns.in_set(Turn));
    schedule.add_systems((locate_trims, remesh_trims).chain().in_set(Remesh));
    schedule.add_systems(relax_trims.in_set(Relax));
    schedule.add_systems(correspond_fits.in_set(Correspond));
    schedule.add_systems(modify_fits.in_set(Modify));
    schedule.add_systems(refine_fits.in_set(Refine));
    schedule.add_systems((advance_fits, advance_trims, compose_results).chain().in_set(Advance));
}

/// Settings under which two systems that touch the same data without an order between them are an
/// error. The engine alone passes; a host that uses them is told where its own systems do not.
pub fn strict() -> ScheduleBuildSettings {
    ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        hierarchy_detection: LogLevel::Error,
        ..ScheduleBuildSettings::new()
    }
}
