//! Trims: what is asked for, where it stands, and what came of it.
//!
//! A trim is an entity. What is left of a source after all of its trims is one more entity, its
//! [result](ResultOf), derived and read-only; the source itself is never changed.
//!
//! ```text
//! Trim -> AtLocate -> AtRemesh -> AtRelax -> AtRefine -> AtCorrespond -> AtModify -+-> AtAudit -> TrimReport
//!            |           |  ^         |          ^                                 |       |
//!            |           |  +-finer---+          +---- next level, next round -----+       |
//!            +-----------+------------+-----------------------+-----------------------+--> TrimFailed
//! ```

use core::fmt;
use std::sync::Arc;

use bevy_ecs::prelude::{Component, Entity};
use glam::DVec3;
use thiserror::Error;

use crate::budget::{BudgetExceeded, Budgets};
use crate::curve::{Curve, CurveFault, Heading};
use crate::evaluate::SurfacePoint;
use crate::identity::{same_number, same_option};
use crate::subdivision::fit::{FitError, Outcome, Rule, Rung, Storage};
use crate::subdivision::remesh::RemeshError;
use crate::tolerance::Tolerance;

/// A trim: directed curves that cut a source. What lies on their left stays.
///
/// Spawn an entity with it, with [`TrimOptions`] and a [`Tolerance`] if you like, and it begins in
/// the next pass. Each trim by itself leaves what lies on the left of its curves, which together are
/// one border, and all trims of one source leave its result: what each of them leaves. Their order,
/// where it shows, is that of their serials. A trim begins again when
/// anything that it reads has become another: source, curves, tolerance, options, budgets.
#[derive(Component, Clone, Debug, PartialEq, Eq)]
#[require(TrimOptions)]
pub struct Trim {
    /// The surface that is trimmed.
    pub source: Entity,
    /// The curves. Those of one trim may lie apart, or one within the other.
    pub cuts: Vec<TrimCurve>,
}

/// A directed curve of a trim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrimCurve {
    /// An entity with a [`SpaceCurve`](crate::curve::SpaceCurve).
    pub curve: Entity,
    /// Which way it is walked.
    pub heading: Heading,
}

/// On a trim: where its curves run on the source, roughly, as far as the host knows it. By cut; cuts
/// beyond the list have none.
///
/// The engine finds that by itself, as the closest points. Where the closest point is not the one that
/// is meant, since a curve runs between two sheets that are near to each other, a few places say which
/// sheet it is. They are where the search begins, and no more: each must lie near the curve, and the
/// place that is found from it is used in its stead.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct PreImages(pub Vec<Arc<[PreImagePoint]>>);

/// A place of the source at which a curve is said to run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreImagePoint {
    /// The curve's parameter, in [0, 1], rising from point to point.
    pub u: f64,
    /// The place, no farther from the curve's point than a mean edge of the cage.
    pub at: SurfacePoint,
}

impl PreImages {
    /// Is this what was said before? See [`same_number`].
    fn same_as(&self, other: &Self) -> bool {
        let same_place = |a: &PreImagePoint, b: &PreImagePoint| {
            let numbers = |p: &PreImagePoint| [p.u, p.at.st.x, p.at.st.y];
            a.at.face == b.at.face && numbers(a).into_iter().zip(numbers(b)).all(|(a, b)| same_number(a, b))
        };
        let same_cut = |a: &[PreImagePoint], b: &[PreImagePoint]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same_place(a, b))
        };
        self.0.len() == other.0.len() && self.0.iter().zip(&other.0).all(|(a, b)| same_cut(a, b))
    }
}

/// What a stretch of a trimmed border runs along.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BorderLine {
    /// A side of the source, by its index there.
    Side(usize),
    /// A cut, by its index among the cuts.
    Cut(usize),
}

/// A corner of a trimmed border where one line ends on another: where two cuts cross, or a cut
/// leaves the source across its border.
///
/// Of the two lines the older gives the point, to the bit: a side of the source is older than a cut,
/// and a cut older than those after it. Everywhere else a border is its own line's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Junction {
    /// The point, in model units.
    pub point: DVec3,
    /// The lines, the older first, each with its parameter there: of a curve the curve's own, of a
    /// plain side the share of it, from its first vertex on.
    pub ends: [(BorderLine, f64); 2],
    /// How far apart the lines are there, in model units.
    pub gap: f64,
}

/// The faces that a trim may fit, `Omega` in [Litke et al. 2001, Section 3.3], by what they add to `T`,
/// the faces around vertices whose ring is not what it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Omega {
    /// Nothing: the least change and the fewest details for a tolerance. Where the tolerance is not met so,
    /// the neighbours are taken after all.
    #[default]
    Changed,
    /// The neighbours of `T`, as in the paper: the least error for a level, above all for level 0.
    Neighbourhood,
}

/// How a trim is made: settings, each with a default.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct TrimOptions {
    /// The finest level that may have details.
    pub last_level: u32,
    /// How details are found.
    pub rule: Rule,
    /// What each detail coefficient is rounded to when it is stored.
    pub storage: Storage,
    /// Which faces are fitted around those that the remeshing changes.
    pub omega: Omega,
    /// How far from the curves anything may change, in model units. The whole cage is refined first as
    /// often as that takes, to four times the faces each time.
    pub reach: Option<f64>,
    /// How many samples the audit takes of each patch, both ways.
    pub samples: u32,
    /// Chooses the samples.
    pub seed: u64,
    /// Whether what the trim removes is wanted, too.
    pub sides: Sides,
}

impl TrimOptions {
    /// Are these the settings that a trim was made with? See [`same_number`].
    pub fn same_as(&self, other: &Self) -> bool {
        let rest = |options: &Self| Self { reach: None, ..options.clone() };
        same_option(self.reach, other.reach) && rest(self) == rest(other)
    }
}

/// Which sides of its curves a trim makes surfaces of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sides {
    /// What stays.
    #[default]
    Left,
    /// What stays, and what the trim removes of that which all other trims of its source leave: a
    /// result of its own, named by [`OtherSide`]. The two make up what would be left without the
    /// trim. Where they meet, both have the same samples of the curves, bit for bit on every level.
    Both,
}

impl Default for TrimOptions {
    /// Level 12 is deep enough for a millionth of the size at valence 12; trims end at their
    /// tolerance long before.
    fn default() -> Self {
        Self {
            last_level: 12,
            rule: Rule::LeastSquares,
            storage: Storage::F64,
            omega: Omega::Changed,
            reach: None,
            samples: 45,
            seed: 0x5e1_7ed6e,
            sides: Sides::Left,
        }
    }
}

/// On a source: its result.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrimmedTo(pub Entity);

/// On a result: what it is the rest of. A result bears a
/// [`Snapshot`](crate::subdivision::Snapshot) of what is left, and is triangulated and audited like
/// any surface.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResultOf(pub Entity);

/// On a trim whose options ask for it: the result that is what it removes.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherSide(pub Entity);

/// On a result: the trim that removes it. It bears a snapshot, as any result does.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct OtherSideOf(pub Entity);

/// On a result: it is the last good one, and its trims or its source have changed since.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stale;

/// Marks a trim whose curves are being found on its source.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtLocate;

/// Marks a trim whose curves are being worked into the cage.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtRemesh;

/// Marks a trim whose new vertices settle along its curves.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtRelax;

/// Marks a trim that is fitted and is being measured.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct AtAudit;

/// The stages that are a trim's own; before the last, it is fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TrimStage {
    /// Curves are found on the source.
    Locate,
    /// Curves are worked into the cage.
    Remesh,
    /// New vertices settle along the curves, and the new cage is made; or a finer one is asked for.
    Relax,
    /// Details are fitted.
    Fit,
    /// The result is measured.
    Audit,
}

impl fmt::Display for TrimStage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Locate => "locate",
            Self::Remesh => "remesh",
            Self::Relax => "relax",
            Self::Fit => "fit",
            Self::Audit => "audit",
        })
    }
}

/// What a work quantum of a trim's own stages led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrimQuantum {
    /// The stage has more to do.
    More,
    /// The stage is done; this one is next.
    Next(TrimStage),
    /// The trim changes more of its source than was thought, and may touch others.
    Widen,
    /// The trim is made.
    Finished,
}

/// Whether a trim runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrimState {
    /// It is at this stage; its marker says the same.
    Running(TrimStage),
    /// Its curves are located, and it waits for the other trims of its source to be, too.
    Located,
    /// It touches others, and is made together with them: this one carries the work.
    With(Entity),
    /// It is done, and its report is there.
    Finished,
    /// It failed, and its failure is there.
    Failed,
}

impl TrimState {
    /// Is the trim being worked on?
    pub const fn is_running(self) -> bool {
        !matches!(self, Self::Finished | Self::Failed)
    }
}

/// A directed curve as a trim reads it: the curve, the revision that it had, and its heading.
pub type CutInput = (Arc<dyn Curve>, u64, Heading);

/// All that a trim reads, as it was when it began.
#[derive(Clone, Debug)]
pub struct TrimInputs {
    /// The source.
    pub source: Entity,
    /// The revision of its snapshot; `None` while it has none.
    pub revision: Option<u64>,
    /// The curves; `None` where the entity named has no curve.
    pub cuts: Vec<Option<CutInput>>,
    /// Where they are said to run.
    pub given: PreImages,
    /// How the trim is made.
    pub options: TrimOptions,
    /// The trim's tolerance, if it has one.
    pub tolerance: Option<Tolerance>,
    /// What may be spent.
    pub budgets: Budgets,
}

impl PartialEq for TrimInputs {
    /// Curves are the same when they are one and the same object, of one revision; numbers as
    /// [`same_number`] says.
    fn eq(&self, other: &Self) -> bool {
        let same = |a: &Option<CutInput>, b: &Option<CutInput>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(&a.0, &b.0) && (a.1, a.2) == (b.1, b.2),
            (None, None) => true,
            _ => false,
        };
        let rest = |inputs: &Self| (inputs.source, inputs.revision, inputs.budgets);
        rest(self) == rest(other)
            && Tolerance::same_option(self.tolerance, other.tolerance)
            && self.options.same_as(&other.options)
            && self.given.same_as(&other.given)
            && self.cuts.len() == other.cuts.len()
            && self.cuts.iter().zip(&other.cuts).all(|(a, b)| same(a, b))
    }
}

/// Where a trim stands. Written by the engine; remove it to have the trim made again.
#[derive(Component, Clone, Debug)]
pub struct TrimJob {
    /// Whether it runs.
    pub state: TrimState,
    /// What it read when it began.
    pub inputs: TrimInputs,
    /// What the stage that ran in this pass has to say. The system of a stage sets it, once a pass,
    /// on each trim that bears the stage's marker; the end of the pass takes it.
    pub step: Option<Result<TrimQuantum, TrimFault>>,
    /// Which of the trims made together a failed [`Self::step`] is about, if that can be told.
    pub blamed: Option<Entity>,
    /// Where it is about curves of two trims, the older of them.
    pub with: Option<Entity>,
    /// The trims that it is made together with, itself included, in their order; none before it is
    /// known which they are. The first carries the work.
    pub together: Vec<Entity>,
    /// How many work quanta it has taken, those of the fit included.
    pub quanta: u64,
}

impl TrimJob {
    /// A trim that begins with these inputs.
    pub const fn new(state: TrimState, inputs: TrimInputs) -> Self {
        Self { state, inputs, step: None, blamed: None, with: None, together: Vec::new(), quanta: 0 }
    }

    /// Does another trim, made together with this one, carry the work?
    pub fn is_led_by(&self, trim: Entity) -> bool {
        self.together.first().is_some_and(|&lead| lead != trim)
    }

    /// Is it being worked on?
    pub const fn is_running(&self) -> bool {
        self.state.is_running()
    }
}

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

/// Why a trim has no result.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TrimFault {
    /// The entity to be trimmed is no surface, or no longer.
    #[error("{source_entity} is not a surface")]
    NoSource {
        /// The entity.
        source_entity: Entity,
    },
    /// The source is refused.
    #[error("source {source_entity} has {faults} faults")]
    SourceFailed {
        /// The source.
        source_entity: Entity,
        /// How many faults it has.
        faults: usize,
    },
    /// The source cannot be evaluated.
    #[error("the source cannot be evaluated: {why}")]
    Unevaluated {
        /// What its evaluation said.
        why: String,
    },
    /// An entity named as a curve has none.
    #[error("{curve} is not a curve")]
    NoCurve {
        /// The entity.
        curve: Entity,
    },
    /// A curve is refused.
    #[error("curve {curve} has {faults} faults, the first: {first}")]
    CurveFailed {
        /// The curve.
        curve: Entity,
        /// How many faults it has.
        faults: usize,
        /// The first of them.
        first: Box<CurveFault>,
    },
    /// A number of the options or the tolerance is not a positive distance.
    #[error("{what} is {value}, not a positive distance")]
    BadNumber {
        /// Which.
        what: &'static str,
        /// What it is.
        value: f64,
    },
    /// The tolerance is so small that rounding of the source's coordinates alone is above it.
    #[error("{what} is {value:e}, but coordinates of the source are rounded by up to {limit:e}")]
    BelowRounding {
        /// Which.
        what: &'static str,
        /// What it is, in model units.
        value: f64,
        /// The least that it may be.
        limit: f64,
    },
    /// A curve misses the source.
    #[error("curve {curve} does not meet the source within {limit}: at u = {u}, {at}, it is {distance} off")]
    Misses {
        /// The curve, by index.
        curve: usize,
        /// The parameter where it is nearest, of those looked at.
        u: f64,
        /// The curve's point.
        at: DVec3,
        /// How far off that is.
        distance: f64,
        /// How far off it may be.
        limit: f64,
    },
    /// A curve is smaller than the tolerance: nothing could be told apart along it.
    #[error("curve {curve} lies within {size} of {at}, the tolerance is {tolerance}")]
    TooSmall {
        /// The curve, by index.
        curve: usize,
        /// The diagonal of its box.
        size: f64,
        /// A point of it.
        at: DVec3,
        /// The tolerance.
        tolerance: f64,
    },
    /// The curves could not be worked into the cage.
    #[error(transparent)]
    Remesh(#[from] RemeshError),
    /// The details could not be fitted.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// The fit went to its end, and the error that is left is above the tolerance.
    #[error("the fit ended above its tolerance: {outcome}")]
    NotReached {
        /// How it ended: what is left, and where.
        outcome: Outcome,
    },
    /// The audit found something wrong.
    #[error("the audit found {} faults, the first: {}", .faults.len(), .faults.first().map_or_else(String::new, ToString::to_string))]
    Audit {
        /// Everything that is wrong.
        faults: Vec<TrimAuditFault>,
    },
    /// What stays could be made, but not the other side, which was asked for, too.
    #[error("the other side: {why}")]
    OtherSide {
        /// What happened there.
        why: Box<TrimFault>,
    },
    /// A budget is spent.
    #[error(transparent)]
    Budget(#[from] BudgetExceeded),
    /// User code, or a stage, panicked where no place can be told.
    #[error("{stage} panicked: {message}")]
    Panicked {
        /// The stage.
        stage: TrimStage,
        /// What the panic said.
        message: String,
    },
}

/// One thing that an audit finds wrong with a trim, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TrimAuditFault {
    /// The result leaves the source, or the source what is left of it.
    #[error("{what} at {at} is {distance:e} off, more than {limit:e}")]
    Distance {
        /// From what to what.
        what: &'static str,
        /// The distance, in model units.
        distance: f64,
        /// What is allowed.
        limit: f64,
        /// Where.
        at: DVec3,
    },
    /// A face next to those that may change is not as it was.
    #[error("face {face} of the result has changed by {distance:e} at {at}, where nothing may change")]
    Outside {
        /// The face of the result.
        face: u32,
        /// How far its limit point has moved, in model units; 0 where only its origin is not what it
        /// should be.
        distance: f64,
        /// Where.
        at: DVec3,
    },
    /// Put together with what other trims have left, a face is not what its own trim made of it.
    #[error("face {face} of what all trims have left is {distance:e} off at {at} from what its own trim left")]
    Composed {
        /// The face of the result.
        face: u32,
        /// How far its limit point is off, in model units; NaN where it has none.
        distance: f64,
        /// Where.
        at: DVec3,
    },
    /// A border sample is not the curve's own.
    #[error("the border is at {at}, its curve at {sample} (u = {u}, side {side})")]
    OffCurve {
        /// The side, by index.
        side: usize,
        /// The curve's parameter.
        u: f64,
        /// The border's point.
        at: DVec3,
        /// The curve's value.
        sample: DVec3,
    },
    /// A border loop has other vertices than the sides that make it up.
    #[error("{edges} border edges, of which sides name {named}")]
    Border {
        /// Border edges of the result.
        edges: usize,
        /// Edges that sides name.
        named: usize,
    },
    /// Vertices, edges and faces do not add up to a surface of the source's kind.
    #[error("the Euler number is {euler} with {loops} border loops in {parts} parts")]
    Euler {
        /// Vertices - edges + faces.
        euler: i64,
        /// Border loops.
        loops: usize,
        /// Connected parts.
        parts: usize,
    },
    /// What is kept and what is removed do not make up the source.
    #[error("kept, cut and removed pieces cover face {face} of the source {share} times, not once")]
    Cover {
        /// The root face of the source.
        face: u32,
        /// The sum of their shares.
        share: f64,
    },
}

/// This trim failed; the source and the last good result are as they were. Removed when the trim
/// begins again, which it does once something that it reads has changed.
#[derive(Component, Clone, Debug, PartialEq, Error)]
#[error("{why}")]
pub struct TrimFailed {
    /// What happened.
    pub why: TrimFault,
    /// The other trim, where it is about curves of two: of [`Self::why`]'s two curves the first is
    /// that one's, the second this one's.
    pub with: Option<Entity>,
    /// The ladder as far as it went.
    pub ladder: Vec<Rung>,
}
