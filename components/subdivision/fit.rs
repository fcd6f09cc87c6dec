//! A fit of a surface to a target, as data: what is asked for, how it goes, and what went wrong.

use core::fmt;

use bevy_ecs::prelude::Component;
use glam::DVec3;
use thiserror::Error;

use super::FaceCode;
use crate::identity::same_option;
use crate::mesh::VertexId;
use crate::target::TargetError;

/// How a fit is made: settings of a job, each with a default.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct FitOptions {
    /// How details are found.
    pub rule: Rule,
    /// The distance to the target, in model units, at which the fit ends; `None` refines every
    /// patch down to the last level.
    pub tolerance: Option<f64>,
    /// The finest level that may have details.
    pub last_level: u32,
    /// Where details may stand.
    pub region: Region,
    /// What each coefficient is rounded to when it is stored.
    pub storage: Storage,
    /// The most details that may be stored.
    pub most_details: usize,
    /// A level that leaves more than this share of the greatest distance that the one before it has left
    /// ends the fit as [`Outcome::Stalled`]; `None` goes on to the last level.
    pub stalled_at: Option<f64>,
}

impl FitOptions {
    /// Are these the settings that a fit was made with? See [`same_number`](crate::identity::same_number).
    pub fn same_as(&self, other: &Self) -> bool {
        let Self { rule, tolerance: _, last_level, ref region, storage, most_details, stalled_at: _ } = *self;
        same_option(self.tolerance, other.tolerance)
            && same_option(self.stalled_at, other.stalled_at)
            && (rule, last_level, region) == (other.rule, other.last_level, &other.region)
            && (storage, most_details) == (other.storage, other.most_details)
    }
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            rule: Rule::LeastSquares,
            tolerance: None,
            last_level: 5,
            region: Region::Whole,
            storage: Storage::F64,
            most_details: 4_000_000,
            stalled_at: None,
        }
    }
}

/// How details are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// A few steps of conjugate gradients on the least-squares problem of each level.
    LeastSquares,
    /// The seed's quasi-interpolation stencils. [Litke et al. 2001, Fig. 5]
    Quasi {
        /// What smooth border vertices use.
        boundary: BoundaryStencil,
        /// What corners use.
        corner: CornerStencil,
    },
}

/// What smooth border vertices of valence 4 use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoundaryStencil {
    /// `(apex - n1 - n2) / 6`: exact on quadratics.
    Quadratic,
    /// Three rows: exact on cubics; the quadratic one where the rows are not regular.
    Cubic,
}

/// What corners use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CornerStencil {
    /// The mean of the details just found at the two border neighbours, as printed.
    Mean,
    /// Extrapolation `2 d1 - d2` at valence 3 and the cubic stencil at valence 2: what contracts
    /// best of the stencils that are exact on polynomials.
    Mended,
}

/// Where details may stand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Region {
    /// Everywhere.
    Whole,
    /// Only where all patches they move descend from these root faces (ascending): the fixed Omega.
    Faces(Vec<FaceCode>),
    /// Everywhere down to a level; from there on only within some rings of one root vertex.
    Around {
        /// The vertex.
        vertex: VertexId,
        /// How many rings of faces of the level in work.
        rings: u32,
        /// The first level that is limited.
        from_level: u32,
    },
}

/// What each coefficient is rounded to when it is stored; all sums are in f64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// Not at all.
    F64,
    /// To the nearest f32.
    F32,
}

impl Storage {
    /// The coefficient as it is stored.
    pub fn round(self, x: DVec3) -> DVec3 {
        match self {
            Self::F64 => x,
            Self::F32 => x.as_vec3().as_dvec3(),
        }
    }
}

/// The stage that comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Closest points on the target.
    Correspond,
    /// New details.
    Modify,
    /// Measure, and open the next level.
    Refine,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Correspond => "correspond",
            Self::Modify => "modify",
            Self::Refine => "refine",
        })
    }
}

/// What one work quantum led to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantum {
    /// The stage has more to do.
    More,
    /// The stage is done; this one is next.
    Next(Stage),
    /// The fit is done: the kernel tells the [`Outcome`].
    Finished,
}

/// One row of the error ladder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rung {
    /// The level whose details are in.
    pub level: u32,
    /// Greatest distance to the target, over all patches, each sampled at the limit points two
    /// levels finer than its details.
    pub max: f64,
    /// Where.
    pub max_at: DVec3,
    /// Greatest distance over the patches that this level could influence.
    pub max_here: f64,
    /// Mean distance over the points sampled at this level.
    pub mean: f64,
    /// Details stored up to this level.
    pub details: usize,
    /// Coefficients that this level could move.
    pub active: usize,
    /// Points sampled.
    pub samples: usize,
}

/// How a fit ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Every patch is within the tolerance (or none was asked for, and the last level is in).
    Within,
    /// The last level is in and this is still too much.
    LevelsSpent {
        /// Greatest distance left.
        achieved: f64,
        /// Where.
        at: DVec3,
    },
    /// The last level has gained too little: see [`FitOptions::stalled_at`].
    Stalled {
        /// Greatest distance left.
        achieved: f64,
        /// Where.
        at: DVec3,
    },
    /// Patches that the region does not let move are too far off.
    OutOfReach {
        /// Greatest distance left.
        achieved: f64,
        /// Where.
        at: DVec3,
    },
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Within => write!(f, "within the tolerance"),
            Self::LevelsSpent { achieved, at } => write!(f, "the last level is in and {achieved} is left at {at}"),
            Self::Stalled { achieved, at } => write!(f, "levels gain little now and {achieved} is left at {at}"),
            Self::OutOfReach { achieved, at } => {
                write!(f, "{achieved} is left at {at}, where the region lets nothing move")
            }
        }
    }
}

/// Why a fit stopped.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// The tolerance is not a positive number.
    #[error("the tolerance {tolerance} is not a positive distance")]
    BadTolerance {
        /// What was asked for.
        tolerance: f64,
    },
    /// The tolerance is below what the coordinates can hold.
    #[error("the tolerance {tolerance} is below {least}, the rounding of coordinates of this size")]
    ToleranceBelowRounding {
        /// What was asked for.
        tolerance: f64,
        /// The least that can be asked for.
        least: f64,
    },
    /// The level is finer than faces of this mesh can be addressed.
    #[error("level {level} is finer than the finest that {faces} root faces allow, {finest}")]
    TooFine {
        /// What was asked for.
        level: u32,
        /// Root faces.
        faces: usize,
        /// The finest possible.
        finest: u32,
    },
    /// The source's own details are so deep that even its coarsest fit would have too many faces.
    #[error("the source has details on {depth} levels: fitting it anew begins with {faces} faces, more than {limit}")]
    SourceTooDeep {
        /// Levels of details.
        depth: u32,
        /// Faces to begin with.
        faces: u64,
        /// How many there may be.
        limit: u64,
    },
    /// A control point or curve sample is not finite.
    #[error("the surface is not finite at {vertex:?}: {at}")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        at: DVec3,
    },
    /// The target gave no answer.
    #[error(transparent)]
    Target(#[from] TargetError),
    /// There would be more details than allowed.
    #[error("level {level} would bring the details to {details}, more than the {limit} allowed")]
    TooManyDetails {
        /// The level.
        level: u32,
        /// How many there would be.
        details: usize,
        /// How many there may be.
        limit: usize,
    },
}
