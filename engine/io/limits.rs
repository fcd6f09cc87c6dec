//! How much a file may ask for.

use thiserror::Error;

/// Bounds on what a reader takes in. A file that passes one is refused before memory is set aside
/// for it, so what a file claims costs nothing until it is believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Length of a file.
    pub bytes: usize,
    /// Vertices, over all objects of a file.
    pub vertices: usize,
    /// Faces, over all objects of a file.
    pub faces: usize,
    /// Sides of one face. Cutting a face into triangles takes time that grows with their square.
    pub sides: usize,
}

impl Default for Limits {
    /// 256 MiB, 8 Mi vertices, 16 Mi faces of at most 256 sides: several times the largest control
    /// cages in use, and little enough that a file which fills them is read within seconds.
    fn default() -> Self {
        Self { bytes: 256 << 20, vertices: 8 << 20, faces: 16 << 20, sides: 256 }
    }
}

/// A file asks for more than [`Limits`] grants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("{count} {what} are more than the limit of {limit}")]
pub struct TooLarge {
    /// What there is too much of.
    pub what: &'static str,
    /// How much there is, or is claimed to be.
    pub count: u64,
    /// How much there may be.
    pub limit: u64,
}

/// Refuses a count above its limit.
pub(super) fn check(what: &'static str, count: usize, limit: usize) -> Result<(), TooLarge> {
    if count > limit { Err(TooLarge { what, count: count as u64, limit: limit as u64 }) } else { Ok(()) }
}
