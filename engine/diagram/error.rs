//! What can be wrong with a picture.

use std::path::PathBuf;

use glam::DVec3;
use thiserror::Error;

/// Why a picture was not drawn. Nothing is drawn in part: on an error there is no picture.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DiagramError {
    /// A side is zero or too long, or there are too many pixels.
    #[error(
        "no picture of {width} by {height} pixels: a side is 1 to {most_side}, and {most_pixels} pixels are the most"
    )]
    Size {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// The longest side.
        most_side: u32,
        /// The most pixels of a picture; of a scene, the most samples.
        most_pixels: u64,
    },
    /// A position is NaN or infinite.
    #[error("vertex {vertex} of {what} is not finite: {at}")]
    NotFinite {
        /// What the vertex belongs to.
        what: &'static str,
        /// Its index there.
        vertex: usize,
        /// Its position.
        at: DVec3,
    },
    /// A triangle names a vertex that is not there.
    #[error("triangle {triangle} names vertex {vertex}, but there are {count}")]
    IndexOutOfRange {
        /// The index of the triangle.
        triangle: usize,
        /// The vertex it names.
        vertex: u32,
        /// How many vertices there are.
        count: usize,
    },
    /// An array that has one entry for each vertex has another length.
    #[error("{found} {what} for {expected} vertices")]
    Count {
        /// What there is one of for each vertex.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there should be.
        expected: usize,
    },
    /// More triangles than a sample can name.
    #[error("{found} triangles in one scene, {most} are the most")]
    TooManyTriangles {
        /// How many there are.
        found: u64,
        /// How many there may be.
        most: u64,
    },
    /// A direction of view is zero or not finite.
    #[error("cannot look along {direction}: a direction of view is finite and not zero")]
    Direction {
        /// The direction given.
        direction: DVec3,
    },
    /// A field of view is not an angle between 0 and 180 degrees.
    #[error("a field of view of {degrees} degrees: it lies strictly between 0 and 180")]
    FieldOfView {
        /// The angle given, in degrees.
        degrees: f64,
    },
    /// The ends of a range are not finite, not in order, or not positive where logarithms are taken.
    #[error("no scale from {low} to {high}: {rule}")]
    Range {
        /// Where it begins.
        low: f64,
        /// Where it ends.
        high: f64,
        /// What must hold.
        rule: &'static str,
    },
    /// There is nothing that could be drawn.
    #[error("nothing to draw: {what}")]
    Nothing {
        /// What is missing.
        what: &'static str,
    },
    /// The picture cannot be encoded.
    #[error("PNG encoding failed: {reason}")]
    Encode {
        /// What the encoder says.
        reason: String,
    },
    /// The file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}
