//! The systems that make trims.

use std::sync::Arc;

use bevy_ecs::entity::{EntityHashMap, EntityHashSet};
use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_ecs::system::SystemParam;
use selvedge_components::budget::{Budget, Budgets};
use selvedge_components::curve::SpaceCurve;
use selvedge_components::error::{CurveFailed, FitFault, SurfaceFailed};
use selvedge_components::guard::caught;
use selvedge_components::identity::{Serial, Serials};
use selvedge_components::job::{AtCorrespond, AtModify, AtRefine, Cancelled, FitInputs, FitJob, JobState};
use selvedge_components::subdivision::fit::FitOptions;
use selvedge_components::subdivision::remesh::RemeshError;
use selvedge_components::subdivision::{Border, Cage, DetailOf, LoopSurface, Snapshot};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{
    AtAudit, AtLocate, AtRemesh, ResultOf, Stale, Trim, TrimFailed, TrimFault, TrimInputs, TrimJob, TrimOptions,
    TrimQuantum, TrimReport, TrimStage, TrimState, TrimmedTo,
};

use super::admit::{Candidate, Source, Verdict, anything_changed, verdict};
use super::compose::{ComposedOf, Misfit, Solved, compose};
use super::group::groups;
use super::{Blamed, Ground, LocateWork, TrimWork};
use crate::diagnostics::{Counters, SubdivisionDiagnostics};
use crate::parallel::for_each;
use crate::subdivision::fit::FitWork;
use crate::subdivision::job::{Coefficient, Move, deliver, discard, mark, next_move};
use crate::subdivision::region;
use crate::subdivision::remesh::Cut;

type Job = (
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
);
type Surface = (Option<&'static Snapshot>, Option<&'static SurfaceFailed>, Option<&'static Ground>);

/// What trims read besides themselves.
#[derive(SystemParam)]
pub struct Reads<'w, 's> {
    surfaces: Query<'w, 's, Surface, With<Cage>>,
    curves: Query<'w, 's, (&'static SpaceCurve, Option<&'static CurveFailed>)>,
    details: Query<'w, 's, (Entity, &'static DetailOf)>,
    budgets: Option<Res<'w, Budgets>>,
}

/// What the engine adds to the first of some trims from remeshing on.
type WorkTraces = (TrimWork, Solved, FitJob, FitWork, AtRemesh, AtAudit, AtCorrespond, AtModify, AtRefine);
/// All that the engine adds to a trim but for its report, which stays until there is another.
type Traces = (TrimJob, LocateWork, AtLocate, TrimFailed, WorkTraces);

/// The trims of each source in the pass before, in their order.
pub type Known = EntityHashMap<Vec<Entity>>;

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
    freed.extend(known.values().flatten().filter(|&&trim| !trims.contains(trim)));
    let before = core::mem::take(&mut *known);
    for source in before.keys().filter(|&&source| sources.iter().all(|(other, _)| *other != source)) {
        commands.entity(*source).queue_silenced(drop_result);
    }
    let mut starts = Vec::new();
    for (source, trims) in &sources {
        known.insert(*source, trims.iter().map(|trim| trim.0).collect());
        run.counted.items += trims.len() as u64;
        let before = before.get(source).map_or(&[][..], Vec::as_slice);
        let admitted = admit_source(&mut commands, (*source, trims), before, &reads, &mut run.counted);
        freed.extend(admitted.refused.iter().chain(admitted.starts.iter().map(|(trim, _)| trim)));
        starts.extend(admitted.starts.into_iter().map(|(trim, inputs)| (*source, trim, inputs)));
        // Only then can the groups be other ones.
        let regroup = admitted.changed || trims.iter().any(|t| t.5.is_some_and(|job| job.state == TrimState::Located));
        if admitted.settled && regroup {
            freed.extend(begin_groups(&mut commands, trims, &mut run.counted));
        }
    }
    begin_locating(&mut commands, starts, &reads.surfaces);
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

/// What has come of the trims of one source.
struct Admitted {
    /// Those whose curves are to be located, and what they read.
    starts: Vec<(Entity, TrimInputs)>,
    refused: Vec<Entity>,
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
                admitted.starts.push((candidate.trim, candidate.now));
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
    let &(entity, _, asked, options, tolerance, job, locating, has_work, solved, _) = trim;
    let mut refusal = None;
    let cuts = asked.cuts.iter().map(|cut| {
        let Ok((space, failed)) = reads.curves.get(cut.curve) else {
            refusal = refusal.take().or(Some(TrimFault::NoCurve { curve: cut.curve }));
            return None;
        };
        if let Some(CurveFailed(faults)) = failed {
            let first = faults.first().map_or_else(String::new, ToString::to_string);
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
    Candidate { trim: entity, now, refusal, job: whole }
}

/// Sends located trims on their way, in groups; those whose group is what it was go on as they are.
/// Returns those that have begun.
fn begin_groups(
    commands: &mut Commands,
    trims: &[<Job as QueryData>::Item<'_, '_>],
    counted: &mut Counters,
) -> Vec<Entity> {
    let mut begun = Vec::new();
    let standing: Vec<_> = trims
        .iter()
        .filter_map(|trim| Some((trim.0, trim.5?, trim.6?)).filter(|t| t.1.state != TrimState::Failed))
        .collect();
    let reserved: Vec<_> = standing.iter().map(|(trim, _, located)| (*trim, located.reserved())).collect();
    for group in groups(&reserved) {
        let members: Vec<_> = standing.iter().filter(|trim| group.contains(&trim.0)).collect();
        let as_before = members.iter().all(|(_, job, _)| job.together == group && job.state != TrimState::Located);
        if as_before {
            continue;
        }
        counted.written += 1;
        begun.extend(group.iter().copied());
        commands.entity(trims[0].2.source).queue_silenced(mark_stale);
        let (lead, _, first) = members[0];
        let located = members.iter().map(|(.., located)| Arc::clone(located.found())).collect();
        let reserved = members.iter().flat_map(|(.., located)| located.reserved()).copied().collect();
        let work = TrimWork::new(Arc::clone(first.ground()), located, region::ascending(reserved));
        for &&(trim, job, _) in &members {
            let led = trim != *lead;
            let state = if led { TrimState::With(*lead) } else { TrimState::Running(TrimStage::Remesh) };
            let job = TrimJob { together: group.clone(), ..TrimJob::new(state, job.inputs.clone()) };
            commands.entity(trim).try_remove::<WorkTraces>().try_insert(job);
        }
        commands.entity(*lead).try_insert((work, AtRemesh));
    }
    begun
}

/// Puts trims on their way, on what their sources are now.
fn begin_locating(
    commands: &mut Commands,
    starts: Vec<(Entity, Entity, TrimInputs)>,
    surfaces: &Query<Surface, With<Cage>>,
) {
    let mut made: EntityHashMap<Result<Arc<Ground>, TrimFault>> = EntityHashMap::default();
    for (source, trim, inputs) in starts {
        let ground = made.entry(source).or_insert_with(|| ground(source, surfaces));
        if let (Ok(ground), Ok((_, _, before))) = (&*ground, surfaces.get(source))
            && before.is_none_or(|before| before.revision != ground.revision)
        {
            commands.entity(source).try_insert(Ground::clone(ground));
        }
        let cuts = inputs.cuts.iter().flatten();
        let cuts = cuts.map(|(curve, _, heading)| Cut { curve: Arc::clone(curve), heading: *heading }).collect();
        let begun =
            ground.clone().and_then(|ground| LocateWork::new(ground, cuts, inputs.options.clone(), inputs.tolerance));
        match begun {
            Ok(work) => {
                let job = TrimJob::new(TrimState::Running(TrimStage::Locate), inputs);
                commands.entity(trim).try_remove::<Traces>().try_insert((job, work, AtLocate));
            }
            Err(why) => fail(commands, trim, inputs, why),
        }
        commands.entity(source).queue_silenced(mark_stale);
    }
}

/// The last good result stays, and says that it is not the present one.
fn mark_stale(mut source: EntityWorldMut) {
    if let Some(&TrimmedTo(result)) = source.get() {
        source.world_scope(|world| {
            if let Ok(mut result) = world.get_entity_mut(result) {
                result.insert(Stale);
            }
        });
    }
}

fn ground(source: Entity, surfaces: &Query<Surface, With<Cage>>) -> Result<Arc<Ground>, TrimFault> {
    let Ok((Some(snapshot), _, before)) = surfaces.get(source) else {
        return Err(TrimFault::NoSource { source_entity: source });
    };
    if let Some(before) = before.filter(|before| before.revision == snapshot.revision) {
        return Ok(Arc::new(before.clone()));
    }
    let surface = Arc::clone(&snapshot.surface);
    caught(|| Ground::new(surface, snapshot.revision))
        .unwrap_or_else(|message| Err(TrimFault::Panicked { stage: TrimStage::Locate, message }))
        .map(Arc::new)
}

/// Tells why a trim could not be made.
fn fail(commands: &mut Commands, trim: Entity, inputs: TrimInputs, why: TrimFault) {
    let failed = TrimFailed { why, ladder: Vec::new() };
    commands.entity(trim).try_remove::<Traces>().try_insert((TrimJob::new(TrimState::Failed, inputs), failed));
}

/// Finds where the curves of trims run on their sources.
pub fn locate_trims(
    mut trims: Query<(&mut TrimJob, &mut LocateWork), With<AtLocate>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut trims: Vec<_> = trims.iter_mut().map(|(job, work)| (job.into_inner(), work.into_inner())).collect();
    run.counted.items = trims.len() as u64;
    for_each(trims.iter_mut().collect(), |(job, work)| {
        let step = caught(|| work.advance());
        job.quanta += 1;
        job.step = Some(step.unwrap_or_else(|message| Err(TrimFault::Panicked { stage: TrimStage::Locate, message })));
    });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.locate += run.finish();
    }
}

/// Works the curves of trims into the cages of their sources, and begins to fit the new cages.
pub fn remesh_trims(
    mut trims: Query<(&mut TrimJob, &mut TrimWork), With<AtRemesh>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut trims: Vec<_> = trims.iter_mut().map(|(job, work)| (job.into_inner(), work.into_inner())).collect();
    run.counted.items = trims.len() as u64;
    for_each(trims.iter_mut().collect(), |(job, work)| {
        let budgets = job.inputs.budgets;
        let step = caught(|| work.remesh(&budgets));
        set_step(job, work, TrimStage::Remesh, step);
    });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.remesh += run.finish();
    }
}

/// Measures trims whose fit is done.
pub fn audit_trims(
    mut trims: Query<(&mut TrimJob, &mut TrimWork, &FitWork), With<AtAudit>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut trims: Vec<_> =
        trims.iter_mut().map(|(job, work, fit)| (job.into_inner(), work.into_inner(), fit)).collect();
    run.counted.items = trims.len() as u64;
    for_each(trims.iter_mut().collect(), |(job, work, fit)| {
        let step = caught(|| work.audit(fit));
        set_step(job, work, TrimStage::Audit, step);
    });
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.audit += run.finish();
    }
}

/// Notes what a quantum of trims made together has led to, and which of them is to blame.
fn set_step(job: &mut TrimJob, work: &TrimWork, stage: TrimStage, step: Result<Result<TrimQuantum, Blamed>, String>) {
    job.quanta += 1;
    let step = step.unwrap_or_else(|message| Err(work.newest(TrimFault::Panicked { stage, message })));
    job.step = Some(step.map_err(|Blamed { trim, why }| {
        job.blamed = job.together.get(trim).copied();
        why
    }));
}

type Made = (
    Entity,
    &'static mut TrimJob,
    Option<&'static mut TrimWork>,
    Option<&'static mut FitJob>,
    Option<&'static FitWork>,
    Option<&'static mut LocateWork>,
);

/// How the work of trims made together has ended.
enum End {
    /// They are done.
    Finished(Option<Box<TrimReport>>),
    /// They change more than was thought.
    Widen,
    /// This one has failed.
    Failed(Entity, TrimFailed),
}

/// Writes the transitions of all trims that took a step, and keeps what those that are done have
/// left.
pub fn advance_trims(
    mut commands: Commands,
    mut trims: Query<Made, With<Trim>>,
    mut details: Query<Coefficient>,
    mut serials: If<ResMut<Serials>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut ends = Vec::new();
    for (entity, mut job, work, fit_job, fit, _) in &mut trims {
        let step = next_step(&mut job, fit_job);
        let Some(step) = step else {
            run.counted.skipped += 1;
            continue;
        };
        run.counted.items += 1;
        run.counted.written += u64::from(step != Step::Stay);
        match step {
            Step::Stay => {}
            Step::Located => {
                job.state = TrimState::Located;
                commands.entity(entity).try_remove::<AtLocate>();
            }
            Step::Fit(stage) => mark(&mut commands.entity(entity), stage),
            Step::BeginFit => {
                let fit = work.and_then(|mut work| work.take_fit());
                begin_fit(&mut commands.entity(entity), &mut job, fit);
            }
            Step::Audit => {
                job.state = TrimState::Running(TrimStage::Audit);
                commands.entity(entity).try_remove::<(AtCorrespond, AtModify, AtRefine)>().try_insert(AtAudit);
            }
            Step::Widen => ends.push((job.together.clone(), End::Widen)),
            Step::Finish => {
                let Some((work, fit)) = work.zip(fit) else { continue };
                deliver(&mut commands, &mut details, entity, entity, fit);
                let solved = solved(&job, &work, serials.0.next_number());
                ends.push((job.together.clone(), End::Finished(work.report(fit).map(Box::new))));
                commands.entity(entity).try_remove::<WorkTraces>();
                if let Some(solved) = solved {
                    commands.entity(entity).try_insert(solved);
                }
            }
            Step::Fail(why) => {
                let ladder = fit.map_or_else(Vec::new, |fit| fit.ladder().to_vec());
                let together = if job.together.is_empty() { vec![entity] } else { job.together.clone() };
                let (nearest, why) = match work {
                    Some(work) => {
                        let Blamed { trim, why } = work.nearest(why);
                        (together.get(trim).copied(), why)
                    }
                    None => (None, why),
                };
                let blamed = job.blamed.take().or(nearest).filter(|trim| together.contains(trim));
                let blamed = blamed.or(together.last().copied()).unwrap_or(entity);
                ends.push((together, End::Failed(blamed, TrimFailed { why, ladder })));
            }
        }
    }
    let mut failed = EntityHashSet::default();
    for (together, end) in ends {
        match end {
            End::Finished(report) => finish(&mut commands, &mut trims, &together, report.as_deref()),
            End::Widen => {
                for &trim in &together {
                    if let Ok((.., Some(mut located))) = trims.get_mut(trim) {
                        located.widen();
                    }
                }
                break_off(&mut commands, &mut trims, &together, None);
            }
            End::Failed(blamed, why) => {
                failed.extend(together.iter().copied());
                break_off(&mut commands, &mut trims, &together, Some(blamed));
                commands.entity(blamed).try_remove::<FailedTraces>().try_insert(why);
            }
        }
    }
    discard(&mut commands, &failed, details.iter().map(|(detail, .., of)| (detail, of.0)));
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.advance += run.finish();
    }
}

/// What a trim's step leads to.
#[derive(Clone, Debug, PartialEq)]
enum Step {
    Stay,
    Located,
    BeginFit,
    Fit(selvedge_components::subdivision::fit::Stage),
    Audit,
    Widen,
    Finish,
    Fail(TrimFault),
}

/// Takes the step that a trim made in this pass, in a stage of its own or in its fit.
fn next_step(job: &mut TrimJob, fit: Option<Mut<'_, FitJob>>) -> Option<Step> {
    if let Some(step) = job.step.take() {
        return Some(match step {
            Err(why) => Step::Fail(why),
            Ok(TrimQuantum::More) => match job.inputs.budgets.check(Budget::Quanta, job.quanta + 1) {
                Ok(()) => Step::Stay,
                Err(over) => Step::Fail(over.into()),
            },
            Ok(TrimQuantum::Finished) => Step::Finish,
            Ok(TrimQuantum::Widen) => Step::Widen,
            Ok(TrimQuantum::Next(TrimStage::Fit)) => Step::BeginFit,
            Ok(TrimQuantum::Next(TrimStage::Audit)) => Step::Audit,
            Ok(TrimQuantum::Next(TrimStage::Locate | TrimStage::Remesh)) => Step::Located,
        });
    }
    let mut fit = fit?;
    fit.step.as_ref()?;
    job.quanta += 1;
    Some(match next_move(&mut fit, None) {
        Move::Stay => Step::Stay,
        Move::GoTo(stage) => {
            fit.state = JobState::Running(stage);
            Step::Fit(stage)
        }
        Move::Finish(_) => Step::Audit,
        Move::Fail(why) => Step::Fail(of_fit(why)),
    })
}

fn of_fit(why: FitFault) -> TrimFault {
    match why {
        FitFault::Fit(why) => why.into(),
        FitFault::Budget(over) => over.into(),
        FitFault::NotReached { outcome } => TrimFault::NotReached { outcome },
        FitFault::Panicked { message, .. } => TrimFault::Panicked { stage: TrimStage::Fit, message },
        other => TrimFault::Panicked { stage: TrimStage::Fit, message: other.to_string() },
    }
}

/// A trim's new cage becomes a fit like any other.
fn begin_fit(trim: &mut EntityCommands, job: &mut TrimJob, fit: Option<FitWork>) {
    let Some(work) = fit else { return };
    job.state = TrimState::Running(TrimStage::Fit);
    let TrimInputs { source, revision, tolerance, budgets, .. } = job.inputs.clone();
    let inputs = FitInputs {
        surface: source,
        revision,
        target: None,
        target_revision: Ok(0),
        options: FitOptions::default(),
        tolerance,
        budgets,
    };
    let stage = work.stage();
    let fit = FitJob::new(JobState::Running(stage), inputs);
    trim.try_remove::<AtRemesh>().try_insert((fit, work));
    mark(trim, stage);
}

fn solved(job: &TrimJob, work: &TrimWork, number: u64) -> Option<Solved> {
    let (remeshed, surface) = (Arc::clone(work.remeshed()?), Arc::clone(work.result()?));
    let zone = work.zone().map(Arc::clone);
    Some(Solved { together: job.together.clone(), number, zone, remeshed, surface })
}

/// All trims made together are done.
fn finish(
    commands: &mut Commands,
    trims: &mut Query<Made, With<Trim>>,
    together: &[Entity],
    report: Option<&TrimReport>,
) {
    for &trim in together {
        if let Ok((_, mut job, ..)) = trims.get_mut(trim) {
            job.state = TrimState::Finished;
        }
        if let Some(report) = report {
            let report = TrimReport { together: together.to_vec(), ..report.clone() };
            commands.entity(trim).try_insert(report);
        }
    }
}

/// What a trim that has failed does not keep.
type FailedTraces = (LocateWork, AtLocate, TrimReport);

/// Trims made together are to be made again, but for the one that has failed.
fn break_off(
    commands: &mut Commands,
    trims: &mut Query<Made, With<Trim>>,
    together: &[Entity],
    failed: Option<Entity>,
) {
    for &trim in together {
        commands.entity(trim).try_remove::<WorkTraces>();
        let Ok((_, mut job, ..)) = trims.get_mut(trim) else { continue };
        job.together.clear();
        job.state = if Some(trim) == failed { TrimState::Failed } else { TrimState::Located };
    }
}

/// Puts together what is left of each source, once none of its trims is at work any more.
pub fn compose_results(
    mut commands: Commands,
    mut trims: Query<(Entity, &Trim, &mut TrimJob, Option<&Solved>)>,
    sources: Query<(Entity, &Ground, Option<&TrimmedTo>)>,
    results: Query<(&ComposedOf, Has<Stale>), With<ResultOf>>,
    details: Query<(Entity, &DetailOf)>,
    mut serials: If<ResMut<Serials>>,
    diagnostics: Option<ResMut<SubdivisionDiagnostics>>,
) {
    let mut run = Counters::start();
    let mut misfits = Vec::new();
    for (source, ground, result) in &sources {
        let of_source = || trims.iter().filter(|(_, trim, ..)| trim.source == source);
        let mut pieces: Vec<&Solved> = of_source().filter_map(|(.., solved)| solved).collect();
        pieces.sort_unstable_by_key(|piece| piece.number);
        let made_of = ComposedOf(pieces.iter().map(|piece| piece.number).collect());
        let as_before = result.and_then(|result| results.get(result.0).ok()) == Some((&made_of, false));
        if as_before || of_source().any(|(_, _, job, _)| job.is_running()) {
            run.counted.skipped += 1;
            continue;
        }
        run.counted.items += 1;
        let surface = match compose(&ground.surface, &pieces) {
            Ok(Some(surface)) => surface,
            Ok(None) => continue,
            Err(Misfit { piece, why }) => {
                misfits.push((pieces[piece].together.clone(), why));
                continue;
            }
        };
        run.counted.written += 1;
        let revision = serials.0.next_number();
        let left = (snapshot(surface, revision), ResultOf(source), made_of);
        match result.filter(|result| results.contains(result.0)) {
            Some(&TrimmedTo(result)) => {
                commands.entity(result).try_insert(left).try_remove::<Stale>();
            }
            None => {
                let result = commands.spawn(left).id();
                commands.entity(source).try_insert(TrimmedTo(result));
            }
        }
    }
    let freed = misfits.iter().flat_map(|(together, _)| together).copied().collect();
    for (together, why) in misfits {
        run.counted.written += 1;
        misfit(&mut commands, &mut trims, &together, why);
    }
    discard(&mut commands, &freed, details.iter().map(|(detail, of)| (detail, of.0)));
    if let Some(mut diagnostics) = diagnostics {
        diagnostics.compose += run.finish();
    }
}

/// What trims made together have left does not fit the rest: the newest fails, and the others are
/// made again.
fn misfit(
    commands: &mut Commands,
    trims: &mut Query<(Entity, &Trim, &mut TrimJob, Option<&Solved>)>,
    together: &[Entity],
    why: RemeshError,
) {
    for &trim in together {
        commands.entity(trim).try_remove::<WorkTraces>();
        let Ok((_, _, mut job, _)) = trims.get_mut(trim) else { continue };
        job.together.clear();
        job.state = if Some(&trim) == together.last() { TrimState::Failed } else { TrimState::Located };
    }
    if let Some(&newest) = together.last() {
        let failed = TrimFailed { why: why.into(), ladder: Vec::new() };
        commands.entity(newest).try_remove::<FailedTraces>().try_insert(failed);
    }
}

fn snapshot(surface: Arc<LoopSurface>, revision: u64) -> Snapshot {
    let curves = surface.sides.iter().map(|side| match &side.border {
        Border::Plain => None,
        Border::Given { curve, .. } => caught(|| curve.curve().revision()).ok(),
    });
    let curves = curves.collect();
    Snapshot { surface, revision, structure: revision, curves }
}
