//! Triangles asked for, what came of it, and why nothing did.

use bevy_ecs::prelude::Component;
use glam::DVec3;
use thiserror::Error;

use crate::identity::same_number;
use crate::mesh::{FaceId, VertexId};

/// How a surface is triangulated.
///
/// On a surface it asks for triangles: the surface then bears
/// [`Triangles`](crate::triangles::Triangles) and a [`TriangulationReport`], made anew whenever the
/// surface or these options become other ones, or a [`TriangulationFailed`]. A large surface takes several
/// passes: until then it bears the triangles that it had, and [`Triangulated`] says of which revision they
/// are. Where the surface bears a [`Tolerance`](crate::tolerance::Tolerance), its `chord` is the density.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct TriangulateOptions {
    /// How fine.
    pub density: Density,
    /// The finest level of leaves when the density is a chord; or the finest that addresses allow, if
    /// that is coarser.
    pub last_level: u32,
    /// The most triangles that may come out.
    pub most_triangles: usize,
    /// Whether vertices get the normals of the limit surface.
    pub normals: Normals,
}

impl TriangulateOptions {
    /// Are these the options that triangles were made with? See [`same_number`].
    pub fn same_as(&self, other: &Self) -> bool {
        let same_density = match (self.density, other.density) {
            (Density::Chord(a), Density::Chord(b)) => same_number(a, b),
            (a, b) => a == b,
        };
        let rest = |options: &Self| Self { density: Density::Level(0), ..*options };
        same_density && rest(self) == rest(other)
    }
}

impl Default for TriangulateOptions {
    /// Level 3, with normals.
    fn default() -> Self {
        Self { density: Density::Level(3), last_level: 16, most_triangles: 16_000_000, normals: Normals::OfLimit }
    }
}

/// How fine a triangulation is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Every root face is quartered this many times.
    Level(u32),
    /// Every root face is quartered where it takes that to keep this distance, in model units,
    /// between the triangles and the limit surface.
    Chord(f64),
}

/// Whether vertices get normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normals {
    /// Unit normals of the limit surface.
    OfLimit,
    /// None.
    Without,
}

/// What a triangulation has come to. Written beside the triangles by the triangulate stage; replaced
/// whole.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct TriangulationReport {
    /// Leaves of each level; those of the coarsest first.
    pub leaves: Vec<usize>,
    /// The least `2 area / longest^2` over all triangles: 0.866 is equilateral, 0 degenerate.
    pub worst_shape: f64,
    /// The chord, where one was asked for.
    pub chord: Option<ChordReport>,
}

/// How far the triangles stand off the limit surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChordReport {
    /// What was asked for, in model units.
    pub asked: f64,
    /// The greatest distance found between the finished triangles and the limit surface, both ways, at
    /// other points than those that decided where to refine.
    pub achieved: f64,
    /// The point, of the limit surface or of a triangle, where it was found.
    pub at: DVec3,
    /// How many points were measured.
    pub samples: usize,
    /// Leaves of the last level that stand off further than asked; 0 unless `achieved > asked`.
    pub failing: usize,
}

impl ChordReport {
    /// Is the distance that was asked for kept everywhere?
    pub fn kept(&self) -> bool {
        self.failing == 0
    }
}

/// Why a surface was not triangulated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum TriangulateError {
    /// The chord is not a positive number.
    #[error("the chord {chord} is not a positive distance")]
    BadChord {
        /// What was asked for.
        chord: f64,
    },
    /// The chord is below what the coordinates can hold.
    #[error("the chord {chord} is below {least}, the rounding of coordinates of this size")]
    ChordBelowRounding {
        /// What was asked for.
        chord: f64,
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
    /// There is not exactly one control point for each vertex.
    #[error("{points} control points for {vertices} vertices")]
    PointCount {
        /// How many control points there are.
        points: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A control point or a curve's sample is NaN or infinite.
    #[error("the surface is not finite at {vertex}: {at}")]
    PointNotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        at: DVec3,
    },
    /// A curve of the border panicked.
    #[error("a curve of the surface panicked: {message}")]
    Panicked {
        /// What the panic said.
        message: String,
    },
    /// A point of the limit surface is NaN or infinite: a curve or a detail is.
    #[error("the limit surface is not finite on {face}: {at}")]
    LimitNotFinite {
        /// The root face.
        face: FaceId,
        /// The point.
        at: DVec3,
    },
    /// There would be more triangles than allowed.
    #[error("there would be {triangles} triangles or more, and {limit} are allowed")]
    TooManyTriangles {
        /// How many there would be at least.
        triangles: usize,
        /// How many there may be.
        limit: usize,
    },
}

/// There are no new triangles, and why: on a surface with [`TriangulateOptions`]. Triangles made
/// before stay. Written by the triangulate stage; gone as soon as it succeeds.
#[derive(Component, Clone, Debug, PartialEq, Error)]
#[error(transparent)]
pub struct TriangulationFailed(#[from] pub TriangulateError);

/// What the triangles of a surface, or the failure to make them, came from. Written by the triangulate
/// stage; remove it to have the surface triangulated again.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
pub struct Triangulated {
    /// The revision of the surface's snapshot.
    pub revision: u64,
    /// The options, tolerance and budgets taken into account.
    pub options: TriangulateOptions,
}
