//! Tessellate: a uniform lattice of limit points on every face, and the triangles between them.
//!
//! Every point is numbered by arithmetic ([`Lattice`]) and computed once, on the polynomial of the
//! first face that has it. Nothing but the result grows with the level. What follows from the
//! connectivity alone is in [`Tessellator`] and in the triangles: when only control points move,
//! only the points are computed again.

mod fill;
mod grid;
mod sample;
mod triangles;

use glam::DVec3;
use pulp::Arch;
use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::{Lattice, PlainLoop, TooFine};
use thiserror::Error;

use super::lanes;

pub use fill::Faces;
use fill::{Grids, Pass};
use sample::{Normal, Position, Sample};
pub use triangles::{origins, triangles};

/// Why a surface was not tessellated.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TessellateError {
    /// The level has too many vertices.
    #[error(transparent)]
    TooFine(#[from] TooFine),
    /// The array for the result has another length than there are vertices.
    #[error("{given} places for the {needed} vertices of level {level}")]
    Length {
        /// The level.
        level: u32,
        /// The array's length.
        given: usize,
        /// How many vertices there are.
        needed: usize,
    },
    /// The surface is not the one that the lattice was made for.
    #[error("a surface of {given} faces on a lattice of {expected}")]
    Surface {
        /// Faces of the surface, or entries of the list of wanted faces.
        given: usize,
        /// Faces of the lattice.
        expected: usize,
    },
}

/// Samples plain Loop surfaces of one connectivity at one level.
#[derive(Clone, Debug)]
pub struct Tessellator {
    lattice: Lattice,
    faces: usize,
    grids: Grids,
    arch: Arch,
}

impl Tessellator {
    /// For the surfaces of `mesh`, with `2^level` steps along every edge.
    ///
    /// # Errors
    /// [`TessellateError::TooFine`].
    pub fn new(mesh: &Connectivity, level: u32) -> Result<Self, TessellateError> {
        let lattice = Lattice::new(mesh, level)?;
        Ok(Self { lattice, faces: mesh.face_count(), grids: Grids::new(&lattice), arch: lanes::four() })
    }

    /// How the vertices are numbered.
    pub const fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// The limit points of all vertices.
    ///
    /// # Errors
    /// [`TessellateError::Surface`].
    pub fn positions(&self, surface: &PlainLoop) -> Result<Vec<DVec3>, TessellateError> {
        let mut positions = bytemuck::zeroed_vec(self.lattice.vertex_count());
        self.write_positions(surface, Faces::All, &mut positions)?;
        Ok(positions)
    }

    /// Writes the limit points of the vertices of `faces`, corners and edges included, to their
    /// places in `out`; the rest of `out` stays.
    ///
    /// # Errors
    /// [`TessellateError::Length`], [`TessellateError::Surface`]; `out` is unchanged then.
    pub fn write_positions(
        &self,
        surface: &PlainLoop,
        faces: Faces<'_>,
        out: &mut [DVec3],
    ) -> Result<(), TessellateError> {
        self.write(surface, faces, Position(self.arch), out)
    }

    /// The unit normals of all vertices.
    ///
    /// # Errors
    /// [`TessellateError::Surface`].
    pub fn normals(&self, surface: &PlainLoop) -> Result<Vec<DVec3>, TessellateError> {
        let mut normals = bytemuck::zeroed_vec(self.lattice.vertex_count());
        self.write_normals(surface, Faces::All, &mut normals)?;
        Ok(normals)
    }

    /// Writes unit normals as [`Self::write_positions`] writes points; zero where there is none.
    ///
    /// # Errors
    /// As [`Self::write_positions`].
    pub fn write_normals(
        &self,
        surface: &PlainLoop,
        faces: Faces<'_>,
        out: &mut [DVec3],
    ) -> Result<(), TessellateError> {
        self.write(surface, faces, Normal(self.arch), out)
    }

    fn write(
        &self,
        surface: &PlainLoop,
        faces: Faces<'_>,
        sample: impl Sample,
        out: &mut [DVec3],
    ) -> Result<(), TessellateError> {
        let listed = if let Faces::Only(wanted) = faces { wanted.len() } else { self.faces };
        for given in [surface.topology().mesh().face_count(), listed] {
            if given != self.faces {
                return Err(TessellateError::Surface { given, expected: self.faces });
            }
        }
        let needed = self.lattice.vertex_count();
        if out.len() != needed {
            return Err(TessellateError::Length { level: self.lattice.level(), given: out.len(), needed });
        }
        Pass { surface, lattice: &self.lattice, grids: &self.grids, faces, sample }.fill(out);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
