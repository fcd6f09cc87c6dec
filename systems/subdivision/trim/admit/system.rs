//! The system that begins trims.

use std::sync::Arc;

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use selvedge_components::budget::{Budget, Budgets};
use selvedge_components::curve::SpaceCurve;
use selvedge_components::error::{CurveFailed, CurveUnchecked, SurfaceFailed};
use selvedge_components::guard::caught;
use selvedge_components::identity::Serial;
use selvedge_components::job::Cancelled;
use selvedge_components::subdivision::{Cage, DetailOf, Snapshot};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{
    AtLocate, PreImages, Trim, TrimFailed, TrimFault, TrimInputs, TrimJob, TrimOptions, TrimStage, TrimState, TrimmedTo,
};

use super::together::{begin_groups, mark_others, mark_stale, part};
use super::{Candidate, Source, Verdict, anything_changed, verdict};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::subdivision::job::discard;
use crate::subdivision::remesh::Cut;
use crate::subdivision::trim::compose::Solved;
use crate::subdivision::trim::traces::Traces;
use crate::subdivision::trim::{Ground, GroundBuild, LocateWork, TrimWork};

pub(super) type Job = (
    Entity,
    Option<&'static Serial>,
    &'static Trim,
    &'static TrimOptions,
    Option<&'static Tolerance>,
    Option<&'static TrimJob>,
    Option<&'static LocateWork>,
    Has<TrimWork>,
    Option<&'static Solved>,
    Has<Cancelled>,
    Option<&'static PreImages>,
);
type Surface = (Option<&'static Snapshot>, Option<&'static SurfaceFailed>, Option<&'static Ground>);

/// What trims read besides themselves.
#[derive(SystemParam)]
pub struct Reads<'w, 's> {
    surfaces: Query<'w, 's, Surface, With<Cage>>,
    curves: Query<'w, 's, (&'static SpaceCurve, Option<&'static CurveFailed>, Has<CurveUnchecked>)>,
    details: Query<'w, 's, (Entity, &'static DetailOf)>,
    budgets: Option<Res<'w, Budgets>>,
}

/// What is known from the pass before.
#[derive(Debug, Default)]
pub struct Known {
    /// The trims of each source, in their order.
    trims: EntityHashMap<Vec<Entity>>,
    /// The sources that are being prepared.
    grounds: EntityHashMap<GroundBuild>,
}

impl core::fmt::Debug for Reads<'_, '_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Reads")
    }
}

/// Begins trims, begins again those whose inputs have changed, takes back what was cancelled, and
/// sends those that are located on their way, together where they touch.
pub fn admit_trims(
    mut commands: Commands,
    trims: Query<Job>,
    reads: Reads,
    mut known: Local<Known>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut freed = EntityHashSet::default();
    let sources = by_source(&mut commands, &trims, &mut freed);
    // Trims that are gone leave details behind.
    let gone: Vec<Entity> = known.trims.values().flatten().copied().filter(|&trim| !trims.contains(trim)).collect();
    for &trim in &gone {
        // It is a trim no longer, and may not even be an entity.
        commands.entity(trim).try_remove::<Traces>();
    }
    freed.extend(gone);
    let before = core::mem::take(&mut known.trims);
    for source in before.keys().filter(|&&source| sources.iter().all(|(other, _)| *other != source)) {
        commands.entity(*source).queue_silenced(drop_result);
    }
    let mut starts = Vec::new();
    for (source, trims) in &sources {
        known.trims.insert(*source, trims.iter().map(|trim| trim.0).collect());
        run.counted.items += trims.len() as u64;
        let before = before.get(source).map_or(&[][..], Vec::as_slice);
        let admitted = admit_source(&mut commands, (*source, trims), before, &reads, &mut run.counted);
        if !admitted.starts.is_empty() {
            // What one removes depends on what the others leave.
            mark_others(&mut commands, trims);
        }
        freed.extend(part(&mut commands, (*source, trims), &admitted));
        freed.extend(admitted.refused.iter().copied().chain(admitted.starts.iter().map(|start| start.trim)));
        starts.extend(admitted.starts);
        // Only then can the groups be other ones.
        let located = trims.iter().any(|t| t.5.is_some_and(|job| job.state == TrimState::Located));
        if admitted.settled && (admitted.changed || located) {
            freed.extend(begin_groups(&mut commands, trims, &mut run.counted));
        }
    }
    begin_locating(&mut commands, starts, &reads.surfaces, &mut known.grounds);
    discard(&mut commands, &freed, reads.details.iter().map(|(detail, of)| (detail, of.0)));
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.admit += run.finish();
    }
}

/// The trims of each source that are to be made, in their order; those that are cancelled are taken
/// back, and are `freed`.
fn by_source<'w, 's>(
    commands: &mut Commands,
    trims: &'w Query<Job>,
    freed: &mut EntityHashSet,
) -> Vec<(Entity, Vec<<Job as QueryData>::Item<'w, 's>>)>
where
    'w: 's,
{
    let mut found: Vec<_> = trims.iter().collect();
    found.sort_unstable_by_key(|trim| (trim.2.source, trim.1, trim.0));
    let mut sources: Vec<(Entity, Vec<_>)> = Vec::new();
    for trim in found {
        let (entity, job, cancelled) = (trim.0, trim.5, trim.9);
        match sources.last_mut() {
            _ if cancelled => {
                if job.is_some() {
                    freed.insert(entity);
                    commands.entity(entity).try_remove::<Traces>();
                }
            }
            Some((source, of_source)) if *source == trim.2.source => of_source.push(trim),
            _ => sources.push((trim.2.source, vec![trim])),
        }
    }
    sources
}

/// A trim whose curves are to be located.
pub(super) struct Start {
    source: Entity,
    pub(super) trim: Entity,
    /// What it reads.
    inputs: TrimInputs,
    /// How many quanta it has waited.
    quanta: u64,
    /// Does it wait for its curves to be checked?
    unchecked: bool,
}

/// What has come of the trims of one source.
pub(super) struct Admitted {
    /// Those whose curves are to be located.
    pub(super) starts: Vec<Start>,
    pub(super) refused: Vec<Entity>,
    /// Is every one that can be made located?
    settled: bool,
    /// Has anything about the trims changed?
    changed: bool,
}

fn admit_source(
    commands: &mut Commands,
    (source, trims): (Entity, &[<Job as QueryData>::Item<'_, '_>]),
    before: &[Entity],
    reads: &Reads,
    counted: &mut Counters,
) -> Admitted {
    let surface = reads.surfaces.get(source).ok();
    let candidates: Vec<_> = trims.iter().map(|trim| candidate(trim, surface.as_ref(), reads)).collect();
    let changed = anything_changed(&candidates, before);
    let gathered = if matches!(surface, Some((None, None, _))) { Source::Ungathered } else { Source::Known };
    let mut admitted = Admitted { starts: Vec::new(), refused: Vec::new(), settled: true, changed };
    for candidate in candidates {
        let verdict = verdict(&candidate, gathered, changed);
        counted.skipped += u64::from(verdict == Verdict::Keep);
        counted.written += u64::from(!matches!(verdict, Verdict::Keep | Verdict::Wait));
        match verdict {
            Verdict::Keep => {
                let locating = |job: &TrimJob| job.state == TrimState::Running(TrimStage::Locate);
                admitted.settled &= !candidate.job.is_some_and(locating);
            }
            Verdict::Wait => admitted.settled = false,
            Verdict::Locate => {
                admitted.settled = false;
                let waited = trims.iter().find(|trim| trim.0 == candidate.trim).and_then(|trim| trim.5);
                let quanta = waited.map_or(0, |job| job.quanta);
                let Candidate { trim, now: inputs, unchecked, .. } = candidate;
                admitted.starts.push(Start { source, trim, inputs, quanta, unchecked });
            }
            Verdict::Refuse => {
                admitted.refused.push(candidate.trim);
                let why = candidate.refusal.unwrap_or(TrimFault::NoSource { source_entity: source });
                fail(commands, candidate.trim, candidate.now, why);
            }
        }
    }
    admitted
}

/// What is left of a source that has no trims any more is the source.
fn drop_result(mut source: EntityWorldMut) {
    let result = source.get::<TrimmedTo>().map(|result| result.0);
    source.remove::<(TrimmedTo, Ground)>();
    if let Some(result) = result {
        source.world_scope(|world| world.despawn(result));
    }
}

fn candidate<'w>(
    trim: &<Job as QueryData>::Item<'w, '_>,
    surface: Option<&<Surface as QueryData>::Item<'_, '_>>,
    reads: &Reads,
) -> Candidate<'w> {
    let budgets = reads.budgets.as_deref().map_or_else(Budgets::default, |b| *b);
    let &(entity, _, asked, options, tolerance, job, locating, has_work, solved, _, given) = trim;
    let (mut refusal, mut unchecked) = (None, false);
    let cuts = asked.cuts.iter().map(|cut| {
        let Ok((space, failed, waits)) = reads.curves.get(cut.curve) else {
            refusal = refusal.take().or(Some(TrimFault::NoCurve { curve: cut.curve }));
            return None;
        };
        unchecked |= waits;
        // What it was refused for may be mended.
        if let Some(CurveFailed(faults)) = failed.filter(|_| !waits)
            && let Some(first) = faults.first()
        {
            let first = Box::new(first.clone());
            let why = TrimFault::CurveFailed { curve: cut.curve, faults: faults.len(), first };
            refusal = refusal.take().or(Some(why));
        }
        let revision = caught(|| space.curve.revision()).unwrap_or_default();
        Some((Arc::clone(&space.curve), revision, cut.heading))
    });
    let now = TrimInputs {
        source: asked.source,
        revision: surface.and_then(|s| s.0).map(|snapshot| snapshot.revision),
        cuts: cuts.collect(),
        given: given.cloned().unwrap_or_default(),
        options: options.clone(),
        tolerance: tolerance.copied(),
        budgets,
    };
    match surface {
        None => refusal = Some(TrimFault::NoSource { source_entity: asked.source }),
        Some((None, Some(SurfaceFailed(faults)), _)) => {
            refusal = Some(TrimFault::SourceFailed { source_entity: asked.source, faults: faults.len() });
        }
        _ => {}
    }
    if let Err(over) = budgets.check(Budget::Levels, u64::from(options.last_level)) {
        refusal = refusal.or(Some(over.into()));
    }
    // One that has lost its work, which is derived, begins again.
    let whole = job.filter(|job| match job.state {
        TrimState::Running(TrimStage::Locate) | TrimState::Located | TrimState::With(_) => locating.is_some(),
        TrimState::Running(_) => has_work && locating.is_some(),
        TrimState::Finished => locating.is_some() && (solved.is_some() || job.is_led_by(entity)),
        TrimState::Failed => true,
    });
    Candidate { trim: entity, now, refusal, unchecked, job: whole }
}

/// Puts trims on their way, on what their sources are now; those whose sources are yet being prepared wait
/// for that, one step of it in a pass, and others for their curves to be checked.
fn begin_locating(
    commands: &mut Commands,
    starts: Vec<Start>,
    surfaces: &Query<Surface, With<Cage>>,
    grounds: &mut EntityHashMap<GroundBuild>,
) {
    // Those of others are not wanted any more.
    grounds.retain(|source, _| starts.iter().any(|start| start.source == *source));
    let mut made: EntityHashMap<Result<Option<Arc<Ground>>, TrimFault>> = EntityHashMap::default();
    for Start { source, trim, inputs, quanta, unchecked } in starts {
        let ground = made.entry(source).or_insert_with(|| ground(source, surfaces, grounds));
        if let (Ok(Some(ground)), Ok((_, _, before))) = (&*ground, surfaces.get(source))
            && before.is_none_or(|before| before.revision != ground.revision)
        {
            commands.entity(source).try_insert(Ground::clone(ground));
        }
        let cuts = inputs.cuts.iter().flatten();
        let cuts = cuts.map(|(curve, _, heading)| Cut::new(Arc::clone(curve), *heading)).collect();
        let begun = ground.clone().and_then(|ground| {
            let work = ground
                .filter(|_| !unchecked)
                .map(|ground| LocateWork::new(ground, cuts, inputs.options.clone(), inputs.tolerance));
            Ok(work.transpose()?.map(|work| work.with_given(&inputs.given)))
        });
        match begun {
            Ok(work) => {
                let job = TrimJob::new(TrimState::Running(TrimStage::Locate), inputs);
                let mut trim = commands.entity(trim);
                trim.try_remove::<Traces>();
                match work {
                    Some(work) => trim.try_insert((job, work, AtLocate)),
                    None => trim.try_insert(TrimJob { quanta: quanta + 1, ..job }),
                };
            }
            Err(why) => fail(commands, trim, inputs, why),
        }
        commands.entity(source).queue_silenced(mark_stale);
    }
}

/// A source, ready to be trimmed; `None` while it is yet being prepared, which takes one step more.
fn ground(
    source: Entity,
    surfaces: &Query<Surface, With<Cage>>,
    grounds: &mut EntityHashMap<GroundBuild>,
) -> Result<Option<Arc<Ground>>, TrimFault> {
    let Ok((Some(snapshot), _, before)) = surfaces.get(source) else {
        return Err(TrimFault::NoSource { source_entity: source });
    };
    let revision = snapshot.revision;
    if let Some(before) = before.filter(|before| before.revision == revision) {
        return Ok(Some(Arc::new(before.clone())));
    }
    let begun = grounds.remove(&source).filter(|build| build.revision() == revision);
    let step = caught(|| match begun {
        None => Ok((GroundBuild::new(Arc::clone(&snapshot.surface), revision)?, None)),
        Some(mut build) => build.advance().map(|ground| (build, ground)),
    });
    let panicked = |message| Err(TrimFault::Panicked { stage: TrimStage::Locate, message });
    let (build, ground) = step.unwrap_or_else(panicked)?;
    if ground.is_none() {
        grounds.insert(source, build);
    }
    Ok(ground.map(Arc::new))
}

/// Tells why a trim could not be made.
fn fail(commands: &mut Commands, trim: Entity, inputs: TrimInputs, why: TrimFault) {
    let failed = TrimFailed { why, with: None, ladder: Vec::new() };
    commands.entity(trim).try_remove::<Traces>().try_insert((TrimJob::new(TrimState::Failed, inputs), failed));
}
