//! What is asked for, and what bears the answer.

use std::sync::Arc;

use bevy_ecs::prelude::{Component, Entity};
use glam::DVec3;

use crate::curve::Heading;
use crate::evaluate::SurfacePoint;
use crate::identity::{same_number, same_option};
use crate::subdivision::fit::{Rule, Storage};

/// A trim: directed curves that cut a source. What lies on their left stays.
///
/// Spawn an entity with it, with [`TrimOptions`] and a [`Tolerance`](crate::tolerance::Tolerance) if you
/// like, and it begins in the next pass. Each trim by itself leaves what lies on the left of its curves,
/// which together are one border, and all trims of one source leave its result: what each of them leaves.
/// Their order, where it shows, is that of their serials. A trim begins again when anything that it reads
/// has become another: source, curves, tolerance, options, budgets.
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
    pub fn same_as(&self, other: &Self) -> bool {
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
