//! What a mesh file holds, before anything is judged or changed.

use std::fmt;

use glam::DVec3;
use selvedge_components::mesh::{FaceId, VertexId};
use thiserror::Error;

use super::tags::Tags;

/// Polygons over shared vertices, as a file or a program lists them: nothing is promised yet.
/// [`Cage::from_polygons`](super::Cage::from_polygons) judges them.
///
/// ```
/// # use glam::DVec3;
/// # use selvedge::io::{Cage, Polygons};
/// let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
/// let mut polygons = Polygons::new(square.to_vec());
/// polygons.push(&[0, 1, 2, 3]).unwrap();
/// assert_eq!(Cage::from_polygons(polygons).unwrap().triangles.len(), 2);
/// ```
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Polygons {
    /// Vertex positions, in model units.
    pub positions: Vec<DVec3>,
    /// Corners, creases and the like.
    pub tags: Tags,
    /// What the reader did.
    pub reading: Reading,
    corners: Vec<u32>,
    /// Where each face's corners end; they begin where those of the face before end.
    ends: Vec<usize>,
    origin: Origin,
}

/// What a reader did besides reading.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Reading {
    /// Vertices that were merged with another at the same place.
    pub welded: usize,
    /// Vertices left out because no triangle of their primitive names them. A GLB file may let
    /// primitives share one list of vertices, so this is no defect there.
    pub unreferenced: usize,
    /// What the file holds that was not taken over, and how often.
    pub skipped: Vec<(String, usize)>,
}

/// A face of fewer than three sides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("a face has {sides} sides, which is fewer than three")]
pub struct TooFewSides {
    /// How many sides it has.
    pub sides: usize,
}

impl Polygons {
    /// Vertices and no face yet.
    pub fn new(positions: Vec<DVec3>) -> Self {
        Self { positions, ..Self::default() }
    }

    /// Triangles over vertices.
    pub fn from_triangles(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Self {
        let ends = (1..=triangles.len()).map(|end| 3 * end).collect();
        Self { positions, corners: triangles.as_flattened().to_vec(), ends, ..Self::default() }
    }

    /// Adds a face by its corners, counter-clockwise seen from outside.
    ///
    /// # Errors
    /// [`TooFewSides`] when there are fewer than three.
    pub fn push(&mut self, corners: &[u32]) -> Result<(), TooFewSides> {
        if corners.len() < 3 {
            return Err(TooFewSides { sides: corners.len() });
        }
        self.corners.extend_from_slice(corners);
        self.ends.push(self.corners.len());
        Ok(())
    }

    /// How many faces there are.
    pub fn face_count(&self) -> usize {
        self.ends.len()
    }

    /// The corners of one face.
    pub fn face(&self, face: usize) -> &[u32] {
        let begin = if face == 0 { 0 } else { self.ends[face - 1] };
        &self.corners[begin..self.ends[face]]
    }

    /// The faces in order.
    pub fn faces(&self) -> impl Iterator<Item = &[u32]> {
        (0..self.face_count()).map(|face| self.face(face))
    }

    /// Where in its file a face stands, if it came from one.
    pub fn place_of_face(&self, face: FaceId) -> Option<Place> {
        match &self.origin {
            Origin::Code => None,
            Origin::Lines { faces, .. } => faces.get(face.index()).map(|&line| Place::Line(line)),
            Origin::Primitives(first) => {
                let after = first.partition_point(|&(begin, _)| begin <= face.index());
                first[..after].last().map(|&(_, primitive)| Place::Primitive(primitive))
            }
        }
    }

    /// Where in its file a vertex stands, if it came from a file that says so.
    pub fn place_of_vertex(&self, vertex: VertexId) -> Option<Place> {
        match &self.origin {
            Origin::Lines { vertices, .. } => vertices.get(vertex.index()).map(|&line| Place::Line(line)),
            Origin::Code | Origin::Primitives(_) => None,
        }
    }

    /// Notes the lines of a text file on which vertices and faces stand.
    pub(super) fn set_lines(&mut self, vertices: Vec<usize>, faces: Vec<usize>) {
        self.origin = Origin::Lines { vertices, faces };
    }

    /// Notes that the faces that follow come from `primitive`.
    #[cfg(feature = "gltf")]
    pub(super) fn begin_primitive(&mut self, primitive: PrimitivePlace) {
        let entry = (self.face_count(), primitive);
        match &mut self.origin {
            Origin::Primitives(first) => first.push(entry),
            other => *other = Origin::Primitives(vec![entry]),
        }
    }
}

/// Where the faces came from.
#[derive(Clone, Debug, PartialEq, Default)]
enum Origin {
    /// From a program.
    #[default]
    Code,
    /// From a text file: the line of each vertex and face.
    Lines { vertices: Vec<usize>, faces: Vec<usize> },
    /// From primitives, each with its first face, ascending.
    #[cfg_attr(not(feature = "gltf"), expect(dead_code, reason = "only GLB files have primitives"))]
    Primitives(Vec<(usize, PrimitivePlace)>),
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, counted from 1.
    Line(usize),
    /// A primitive of a GLB file.
    Primitive(PrimitivePlace),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Primitive(primitive) => primitive.fmt(f),
        }
    }
}

/// A primitive of a GLB file, by the indices that the file gives them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PrimitivePlace {
    /// The node that places the mesh.
    pub node: usize,
    /// The mesh.
    pub mesh: usize,
    /// The primitive of that mesh.
    pub primitive: usize,
}

impl fmt::Display for PrimitivePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "node {}, mesh {}, primitive {}", self.node, self.mesh, self.primitive)
    }
}
