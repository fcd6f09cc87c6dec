//! Which rule acts at each vertex, and which faces one polynomial covers.

use std::sync::Arc;

use thiserror::Error;

use crate::mesh::{Connectivity, FaceId, VertexId};
use crate::subdivision::masks;

/// What subdivision does with a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VertexRule {
    /// Loop's mask of its valence.
    Interior,
    /// `1/8, 6/8, 1/8` along the border: the border is a cubic B-spline.
    Border,
    /// It stays where it is: the border has a corner there.
    Corner,
}

/// Why a mesh and what is declared about it make no plain surface.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PlainError {
    /// A vertex is declared a corner that the mesh does not have.
    #[error("corner {vertex} does not exist: the mesh has {vertices} vertices")]
    NoSuchCorner {
        /// The declared corner.
        vertex: VertexId,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A vertex is declared a corner but no border runs through it.
    #[error("corner {vertex} is not on a border")]
    CornerInside {
        /// The declared corner.
        vertex: VertexId,
    },
    /// There is not exactly one control point for each vertex.
    #[error("{points} control points for {vertices} vertices")]
    PointCount {
        /// How many control points were given.
        points: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A control point is NaN or infinite.
    #[error("the control point of {vertex} is not finite: {at}")]
    NotFinite {
        /// Its vertex.
        vertex: VertexId,
        /// The control point.
        at: glam::DVec3,
    },
}

/// The connectivity of a Loop surface with plain borders, and what follows from it alone: nothing
/// here changes when control points move.
#[derive(Clone, Debug)]
pub struct PlainTopology {
    mesh: Arc<Connectivity>,
    rules: Vec<VertexRule>,
    /// For each face: does one [`Quartic`](super::super::boxspline::Quartic) cover it?
    regular: Vec<bool>,
    /// For each vertex: is it a corner of a face that is not regular? Around these the surface
    /// keeps the points of one subdivision step.
    stepped: Vec<bool>,
    /// For each valence up to the largest: the masks of an interior vertex.
    masks: Vec<InteriorMask>,
}

/// Weights of each neighbour of an interior vertex, under one step and in the limit.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct InteriorMask {
    pub step: f64,
    pub limit: f64,
}

impl PlainTopology {
    /// Classifies the vertices and faces of `mesh`. Border vertices are smooth but for `corners`.
    ///
    /// # Errors
    /// [`PlainError::NoSuchCorner`] and [`PlainError::CornerInside`].
    pub fn new(mesh: Arc<Connectivity>, corners: &[VertexId]) -> Result<Self, PlainError> {
        let rules = vertex_rules(&mesh, corners)?;
        let is_regular = |v: VertexId| match rules[v.index()] {
            VertexRule::Interior => mesh.valence(v) == 6,
            VertexRule::Border => mesh.valence(v) == 4,
            VertexRule::Corner => mesh.valence(v) == 2,
        };
        let regular: Vec<bool> = mesh.faces().iter().map(|f| f.iter().all(|&v| is_regular(v))).collect();
        let mut stepped = vec![false; mesh.vertex_count()];
        for (corners, _) in mesh.faces().iter().zip(&regular).filter(|(_, r)| !**r) {
            for v in corners {
                stepped[v.index()] = true;
            }
        }
        let masks = interior_masks(&mesh);
        Ok(Self { mesh, rules, regular, stepped, masks })
    }

    /// The faces.
    pub fn mesh(&self) -> &Arc<Connectivity> {
        &self.mesh
    }

    /// The rule that acts at `v`.
    #[inline]
    pub fn rule(&self, v: VertexId) -> VertexRule {
        self.rules[v.index()]
    }

    /// Is the surface one polynomial over `face`? It is where every corner is an interior vertex of
    /// valence 6, a smooth border vertex of valence 4 or a declared corner of valence 2.
    #[inline]
    pub fn is_regular(&self, face: FaceId) -> bool {
        self.regular[face.index()]
    }

    /// Does a face that is not regular touch `v`?
    #[inline]
    pub(super) fn is_stepped(&self, v: VertexId) -> bool {
        self.stepped[v.index()]
    }

    /// The masks of an interior vertex of `valence`, which must occur in the mesh.
    #[inline]
    pub(super) fn mask(&self, valence: usize) -> InteriorMask {
        self.masks[valence]
    }
}

fn vertex_rules(mesh: &Connectivity, corners: &[VertexId]) -> Result<Vec<VertexRule>, PlainError> {
    let rule = |v| if mesh.is_border(v) { VertexRule::Border } else { VertexRule::Interior };
    let mut rules: Vec<_> = (0..mesh.vertex_count()).map(|v| rule(VertexId::new(v))).collect();
    for &vertex in corners {
        match rules.get_mut(vertex.index()) {
            None => return Err(PlainError::NoSuchCorner { vertex, vertices: mesh.vertex_count() }),
            Some(VertexRule::Interior) => return Err(PlainError::CornerInside { vertex }),
            Some(rule) => *rule = VertexRule::Corner,
        }
    }
    Ok(rules)
}

/// Computed once for each valence that occurs: a cosine costs more than the sum it weighs.
fn interior_masks(mesh: &Connectivity) -> Vec<InteriorMask> {
    let mut masks = Vec::new();
    for v in (0..mesh.vertex_count()).map(VertexId::new) {
        let k = mesh.valence(v);
        if masks.len() <= k as usize {
            masks.resize(k as usize + 1, InteriorMask::default());
        }
        let mask = &mut masks[k as usize];
        if mask.step == 0.0 {
            *mask = InteriorMask { step: masks::neighbour_weight(k), limit: masks::limit_weight(k) };
        }
    }
    masks
}
