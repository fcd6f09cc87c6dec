//! What can be wrong with triangles.

use glam::DVec3;
use selvedge_components::mesh::{FaceId, Fault, VertexId};
use thiserror::Error;

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
