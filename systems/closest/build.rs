//! A surface index in the making, some faces at a time.

use std::sync::Arc;

use super::cells::{Cell, cells};
use super::{IndexError, SurfaceIndex, Walk};
use crate::spatial::Bvh;

/// Faces that are sampled in one step: some milliseconds.
const FACES: usize = 1 << 12;

/// A [`SurfaceIndex`] that is being made.
#[derive(Debug)]
pub struct IndexBuild<S> {
    surface: Arc<S>,
    cells: Vec<Cell>,
    /// How many faces are sampled.
    sampled: usize,
}

impl<S: Walk> IndexBuild<S> {
    /// Begins to make the index of `surface`.
    pub const fn new(surface: Arc<S>) -> Self {
        Self { surface, cells: Vec::new(), sampled: 0 }
    }

    /// Takes the next step; the index, once it is made.
    ///
    /// # Errors
    /// [`IndexError::Empty`], [`IndexError::NotFinite`].
    pub fn advance(&mut self) -> Result<Option<SurfaceIndex<S>>, IndexError> {
        let faces = self.surface.face_count();
        if self.sampled < faces {
            let end = faces.min(self.sampled + FACES);
            let cells = cells(&*self.surface, self.sampled..end);
            if let Some(cell) = cells.iter().find(|c| !c.is_finite()) {
                return Err(IndexError::NotFinite { at: cell.place([1.0 / 3.0; 3]) });
            }
            self.cells.extend(cells);
            self.sampled = end;
            return Ok(None);
        }
        if self.cells.is_empty() {
            return Err(IndexError::Empty);
        }
        let cells = core::mem::take(&mut self.cells);
        let size = cells.iter().flat_map(|c| c.points).map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let boxes: Vec<_> = cells.iter().map(Cell::bounds).collect();
        // The rounding of a position; a shorter step cannot be told from none.
        let fine = 4.0 * f64::EPSILON * size;
        Ok(Some(SurfaceIndex { surface: Arc::clone(&self.surface), cells, tree: Bvh::new(&boxes), fine }))
    }

    /// Takes all steps that are left.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn finish(mut self) -> Result<SurfaceIndex<S>, IndexError> {
        loop {
            if let Some(index) = self.advance()? {
                return Ok(index);
            }
        }
    }
}
