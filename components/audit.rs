//! Triangles measured by someone else than who made them: what was asked, what was found.

use bevy_ecs::prelude::Component;
use glam::DVec3;
use thiserror::Error;

use crate::mesh::{FaceId, Fault, VertexId};

/// How triangles are audited. On a surface that bears
/// [`Triangles`](crate::triangles::Triangles) it asks for an [`AuditReport`].
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub struct AuditOptions {
    /// Random places inside each triangle at which distances are measured; each edge gets a quarter as
    /// many. With none, no distance is measured.
    pub points: u32,
    /// Chooses the places.
    pub seed: u64,
}

impl Default for AuditOptions {
    /// 45 points: three times as many as decide where a triangle is quartered.
    fn default() -> Self {
        Self { points: 45, seed: 0 }
    }
}

/// What an audit found. Written by the audit stage on a surface with [`AuditOptions`]; replaced whole
/// whenever the triangles are.
#[derive(Component, Clone, Debug, Default, PartialEq)]
pub struct AuditReport {
    /// How many vertices there are.
    pub vertices: usize,
    /// How many triangles there are.
    pub triangles: usize,
    /// Vertices of each border loop.
    pub border_loops: Vec<usize>,
    /// Vertices - edges + triangles.
    pub euler: i64,
    /// The least `2 area / longest^2`.
    pub worst_shape: f64,
    /// The greatest distances, where they were measured.
    pub measured: Option<Measured>,
    /// Everything that is wrong.
    pub faults: Vec<AuditFault>,
}

impl AuditReport {
    /// Is nothing wrong?
    pub fn is_sound(&self) -> bool {
        self.faults.is_empty()
    }
}

/// The greatest distances found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// From a point of the limit surface to the triangle that stands for it.
    pub to_triangles: f64,
    /// Where.
    pub to_triangles_at: DVec3,
    /// From a point of a triangle to the limit surface.
    pub to_surface: f64,
    /// Where.
    pub to_surface_at: DVec3,
    /// Points measured, both ways together.
    pub samples: usize,
}

impl Measured {
    /// The greater of both.
    pub fn greatest(&self) -> (f64, DVec3) {
        if self.to_surface > self.to_triangles {
            (self.to_surface, self.to_surface_at)
        } else {
            (self.to_triangles, self.to_triangles_at)
        }
    }
}

/// One thing that is wrong with triangles, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum AuditFault {
    /// The indices are no oriented manifold, or a position is not finite.
    #[error(transparent)]
    Mesh(#[from] Fault),
    /// An array has another length than there are vertices.
    #[error("{given} {what} for {expected} vertices")]
    Length {
        /// Which array.
        what: &'static str,
        /// Its length.
        given: usize,
        /// How many vertices there are.
        expected: usize,
    },
    /// No distance could be measured.
    #[error("the limit surface cannot be evaluated: {why}")]
    Unmeasured {
        /// What its evaluation said.
        why: String,
    },
    /// Vertices, edges and faces do not add up as on the root mesh.
    #[error("the Euler number is {found}, that of the root mesh {expected}")]
    Euler {
        /// Of the triangles.
        found: i64,
        /// Of the root mesh.
        expected: i64,
    },
    /// There are more or fewer borders than the root mesh has.
    #[error("there are {found} border loops, on the root mesh {expected}")]
    Loops {
        /// Of the triangles.
        found: usize,
        /// Of the root mesh.
        expected: usize,
    },
    /// A triangle has no area.
    #[error("triangle {triangle} is degenerate: 2 area / longest^2 is {shape:e}")]
    Degenerate {
        /// Its index.
        triangle: usize,
        /// `2 area / longest^2`.
        shape: f64,
    },
    /// Two vertices have the same position.
    #[error("vertices {first} and {second} are both at {at}")]
    Coincident {
        /// One of them.
        first: VertexId,
        /// The other.
        second: VertexId,
        /// Where.
        at: DVec3,
    },
    /// A vertex claims to lie on a face that does not exist, or outside its face.
    #[error("vertex {vertex} has no place on the root mesh: face {face}, weights {weights:?}")]
    NoPlace {
        /// The vertex.
        vertex: VertexId,
        /// The face that it names.
        face: FaceId,
        /// The weights of the corners.
        weights: [f64; 3],
    },
    /// The corners of a triangle share no root face.
    #[error("the corners of triangle {triangle} lie on no common root face")]
    Torn {
        /// Its index.
        triangle: usize,
    },
    /// A triangle is turned over, or has no area, on its root face.
    #[error("triangle {triangle} covers {area} of its root face")]
    Reversed {
        /// Its index.
        triangle: usize,
        /// Twice its signed area in (s, t).
        area: f64,
    },
    /// The triangles on a root face cover less, or more, than all of it.
    #[error("face {face} is covered {share} times, not once")]
    Cover {
        /// The root face.
        face: FaceId,
        /// The sum of the areas in (s, t), divided by the area of the face.
        share: f64,
    },
    /// An edge of one triangle alone lies inside the surface, or runs along a border the wrong way.
    #[error("the edge {}-{} of triangle {triangle} is open inside the surface, near {at}", .ends[0], .ends[1])]
    OpenEdge {
        /// From where to where its triangle runs through it.
        ends: [VertexId; 2],
        /// The triangle.
        triangle: usize,
        /// One end.
        at: DVec3,
    },
    /// A vertex on a given border is not the curve's own sample.
    #[error("border vertex {vertex} is at {at}, its curve at {sample}")]
    OffCurve {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        at: DVec3,
        /// The curve's value.
        sample: DVec3,
    },
    /// The triangle and the limit surface are further apart than allowed.
    #[error("triangle {triangle} and the limit surface are {distance:e} apart at {at}: more than {limit:e}")]
    Chord {
        /// Its index.
        triangle: usize,
        /// The greatest distance found.
        distance: f64,
        /// What is allowed.
        limit: f64,
        /// Where: a point of the limit surface or of the triangle.
        at: DVec3,
    },
}
