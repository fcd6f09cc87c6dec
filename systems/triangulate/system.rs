//! The system that triangulates.

use bevy_ecs::prelude::*;
use selvedge_components::budget::Budgets;
use selvedge_components::guard::caught;
use selvedge_components::subdivision::{LoopSurface, Snapshot};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::triangulation::Triangulated;

use super::{
    TriangulateError, TriangulateOptions, TriangulationFailed, TriangulationState, TriangulationWork, effective,
};
use crate::diagnostics::{Counters, GroundDiagnostics};
use crate::parallel::for_each;

/// Triangles of a surface that are being made: there while the surface waits for them.
///
/// What it holds is derived: removing it makes the stage begin again.
#[derive(Component, Debug)]
pub struct Triangulating {
    /// Taken while a pass works on it.
    work: Option<TriangulationWork>,
    from: Triangulated,
    passes: u64,
}

impl Triangulating {
    /// What they are being made of.
    pub fn from(&self) -> Triangulated {
        self.from
    }

    /// How many passes have worked on them.
    pub fn passes(&self) -> u64 {
        self.passes
    }
}

type Asked = (
    Entity,
    &'static Snapshot,
    &'static TriangulateOptions,
    Option<&'static Tolerance>,
    Option<&'static Triangulated>,
    Option<&'static mut Triangulating>,
);
type NotAsked = (With<Triangulating>, Or<(Without<TriangulateOptions>, Without<Snapshot>)>);

/// One surface in a pass.
struct Turn<'a> {
    surface: &'a LoopSurface,
    /// What has been begun, if anything.
    begun: Option<TriangulationWork>,
    from: Triangulated,
    passes: u64,
    outcome: Option<Result<TriangulationState, TriangulateError>>,
}

impl Turn<'_> {
    fn run(&mut self) {
        let (begun, options) = (self.begun.take(), &self.from.options);
        let run = || begun.map_or_else(|| TriangulationWork::new(self.surface, options), Ok)?.pass();
        let done = caught(run);
        self.outcome = Some(done.unwrap_or_else(|message| Err(TriangulateError::Panicked { message })));
    }
}

/// Goes on triangulating every surface that asks for it and is not what its triangles were made of.
///
/// What has been begun of a surface is finished when that is edited meanwhile, and then the surface is
/// triangulated again: who edits it pass by pass sees it change. With other options it begins again.
pub fn triangulate_surfaces(
    mut commands: Commands,
    mut surfaces: Query<Asked>,
    not_asked: Query<Entity, NotAsked>,
    budgets: Option<Res<Budgets>>,
    diagnostics: Option<ResMut<GroundDiagnostics>>,
) {
    let mut run = Counters::start();
    let budgets = budgets.map_or_else(Budgets::default, |b| *b);
    let mut due = Vec::new();
    for (entity, snapshot, options, tolerance, before, doing) in &mut surfaces {
        let from = Triangulated { revision: snapshot.revision, options: effective(options, tolerance, &budgets) };
        let is_doing = doing.is_some();
        let begun = doing.filter(|doing| doing.from.options.same_as(&from.options));
        let is_made = |before: &Triangulated| before.revision == from.revision && before.options.same_as(&from.options);
        if begun.is_none() && before.is_some_and(is_made) {
            run.counted.skipped += 1;
            if is_doing {
                // Begun with options that were taken back.
                commands.entity(entity).try_remove::<Triangulating>();
            }
            continue;
        }
        let mut turn = Turn { surface: &snapshot.surface, begun: None, from, passes: 0, outcome: None };
        if let Some(mut begun) = begun
            && let Some(work) = begun.work.take()
        {
            turn = Turn { begun: Some(work), from: begun.from, passes: begun.passes, ..turn };
        }
        due.push((entity, turn));
    }
    for_each(due.iter_mut().collect(), |(_, turn)| turn.run());
    run.counted.items = due.len() as u64;
    for (entity, turn) in due {
        let mut entity = commands.entity(entity);
        match turn.outcome {
            Some(Ok(TriangulationState::Busy(work))) => {
                entity.try_insert(Triangulating { work: Some(*work), from: turn.from, passes: turn.passes + 1 });
            }
            Some(Ok(TriangulationState::Done(made))) => {
                entity.try_remove::<(TriangulationFailed, Triangulating)>();
                entity.try_insert((made.triangles, made.report, turn.from));
                run.counted.written += 1;
            }
            Some(Err(why)) => {
                entity.try_remove::<Triangulating>().try_insert((TriangulationFailed(why), turn.from));
                run.counted.written += 1;
            }
            None => {}
        }
    }
    for entity in &not_asked {
        commands.entity(entity).try_remove::<Triangulating>();
    }
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.triangulate += run.finish();
    }
}
