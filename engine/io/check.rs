//! What must hold before triangles are written.

use glam::DVec3;
use selvedge_components::triangles::Triangles;
use thiserror::Error;

/// Why triangles cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// There are as many of some vertex attribute as there are vertices, or none; not so here.
    #[error("there are {count} {what} for {vertex_count} vertices")]
    Mismatch {
        /// The attribute.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} names vertex {index}, but there are {vertex_count} vertices")]
    IndexOutOfRange {
        /// The triangle.
        triangle: usize,
        /// The index.
        index: u32,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// A number is NaN or infinite.
    #[error("the {what} of vertex {vertex} is not finite: {at}")]
    NotFinite {
        /// The attribute.
        what: &'static str,
        /// The vertex.
        vertex: usize,
        /// Its value.
        at: DVec3,
    },
    /// A position is too large for the numbers of the file.
    #[error("vertex {vertex} at {at} lies beyond what single precision can hold")]
    Beyond {
        /// The vertex.
        vertex: usize,
        /// Its position.
        at: DVec3,
    },
    /// The format has no way to say that there is nothing.
    #[error("there are no objects to write")]
    NoObjects,
    /// The format has no way to say that there are no triangles.
    #[error("object {object:?} has no triangles")]
    Empty {
        /// The name of the object.
        object: String,
    },
    /// The file would be longer than the format can say.
    #[error("{bytes} bytes are more than the {limit} that a GLB file can hold")]
    TooLong {
        /// How long it would be.
        bytes: u64,
        /// How long it can be.
        limit: u64,
    },
    /// What is to be kept as extras has no form in JSON.
    #[error("the extras of object {object:?} cannot be written: {reason}")]
    Extras {
        /// The name of the object.
        object: String,
        /// What the JSON writer says.
        reason: String,
    },
    /// Writing failed.
    #[error("writing failed: {0}")]
    Io(#[from] std::io::Error),
}

/// Checks what [`Triangles`] promises of its arrays.
pub(super) fn check(surface: &Triangles) -> Result<(), WriteError> {
    let vertex_count = surface.positions.len();
    for (what, count) in [("normals", surface.normals.len()), ("colours", surface.colours.len())] {
        if count != 0 && count != vertex_count {
            return Err(WriteError::Mismatch { what, count, vertex_count });
        }
    }
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertex_count) {
            return Err(WriteError::IndexOutOfRange { triangle, index, vertex_count });
        }
    }
    let colours = surface.colours.iter().map(|&[r, g, b]| DVec3::new(r.into(), g.into(), b.into()));
    all_finite("position", surface.positions.iter().copied())?;
    all_finite("normal", surface.normals.iter().copied())?;
    all_finite("colour", colours)
}

fn all_finite(what: &'static str, values: impl Iterator<Item = DVec3>) -> Result<(), WriteError> {
    let wrong = values.enumerate().find(|(_, value)| !value.is_finite());
    wrong.map_or(Ok(()), |(vertex, at)| Err(WriteError::NotFinite { what, vertex, at }))
}
