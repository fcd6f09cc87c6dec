//! A control cage: triangles that every later stage can rely on.

use std::fmt;

use glam::DVec3;
use selvedge_components::mesh::{Connectivity, FaceId, Fault, Oriented, VertexId, faults, orient, position_faults};
use selvedge_components::triangles::Triangles;
use thiserror::Error;

use super::polygons::{Place, Polygons};
use super::tags::{TagError, Unkept};
use super::triangulate::{Triangulation, triangulate};

/// An oriented 2-manifold of triangles with a finite control point at every vertex.
///
/// Always true, when made by one of the functions here: [`Connectivity::new`] accepts `triangles`;
/// `corners` lie on a border and are ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Cage {
    /// Control points, in model units.
    pub positions: Vec<DVec3>,
    /// Counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Border vertices at which the border has a corner.
    pub corners: Vec<VertexId>,
    /// What was done to get here.
    pub import: Import,
}

/// What the import of a cage changed, and what it left out.
///
/// Faces are numbered as in the source, polygons not yet cut.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Import {
    /// The face of the source from which each triangle was cut.
    pub sources: Vec<FaceId>,
    /// How many faces of more than three sides were cut into triangles.
    pub polygons: usize,
    /// Faces that wound against most of their component and were turned round, ascending.
    pub turned: Vec<FaceId>,
    /// Vertices merged with another at the same place.
    pub welded: usize,
    /// Vertices left out because no triangle of their primitive names them.
    pub unreferenced: usize,
    /// What was asked for and is not there.
    pub unkept: Vec<Unkept>,
}

/// Why there is no cage.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CageError {
    /// The mesh has defects: all of them, each with its place in the file.
    #[error("the mesh cannot be used: {}", Listed(.faults))]
    Faulty {
        /// At least one. Faces are numbered as in the source, polygons not yet cut.
        faults: Vec<PlacedFault>,
    },
    /// A tag does not fit the mesh.
    #[error(transparent)]
    Tag(#[from] TagError),
}

/// A defect and where to look for it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedFault {
    /// The defect.
    pub fault: Fault,
    /// The place in the file of the face or vertex that it names last.
    pub place: Option<Place>,
}

impl fmt::Display for PlacedFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.place {
            Some(place) => write!(f, "{} ({place})", self.fault),
            None => self.fault.fmt(f),
        }
    }
}

/// Prints the first few faults and how many more there are: a broken file has thousands.
struct Listed<'a>(&'a [PlacedFault]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const SHOWN: usize = 5;
        for (i, fault) in self.0.iter().take(SHOWN).enumerate() {
            write!(f, "{}{fault}", if i == 0 { "" } else { "; " })?;
        }
        match self.0.len().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => write!(f, "; and {more} more"),
        }
    }
}

impl Cage {
    /// A cage from triangles, with a smooth border.
    ///
    /// # Errors
    /// As [`Self::from_polygons`].
    pub fn from_triangles(positions: Vec<DVec3>, triangles: &[[u32; 3]]) -> Result<Self, CageError> {
        Self::from_polygons(Polygons::from_triangles(positions, triangles))
    }

    /// Judges polygons, cuts them into triangles as [`triangulate`] does, and turns round the faces
    /// that wind against the rest of their component.
    ///
    /// # Errors
    /// [`CageError::Faulty`] with every defect, and then [`CageError::Tag`].
    pub fn from_polygons(polygons: Polygons) -> Result<Self, CageError> {
        let vertex_count = polygons.positions.len();
        let mut found = uncuttable(&polygons);
        let mut cut = Triangulation::default();
        let mut settled = Oriented::default();
        if found.is_empty() {
            cut = triangulate(&polygons);
            match settle(vertex_count, &cut.triangles) {
                Ok(oriented) => settled = oriented,
                Err(more) => found.extend(more.into_iter().map(|f| f.rename_faces(|t| cut.sources[t.index()]))),
            }
        }
        found.extend(position_faults(&polygons.positions));
        if !found.is_empty() {
            return Err(placed(found, &polygons));
        }
        let Oriented { faces: triangles, flipped } = settled;
        let mesh = Connectivity::new(vertex_count, &triangles).map_err(|found| placed(found, &polygons))?;
        let (corners, mut unkept) = polygons.tags.resolve(&mesh)?;
        unkept.extend(polygons.reading.skipped.into_iter().map(|(what, count)| Unkept::Skipped(what, count)));
        let mut turned: Vec<FaceId> = flipped.into_iter().map(|triangle| cut.sources[triangle.index()]).collect();
        turned.dedup();
        let import = Import {
            sources: cut.sources,
            polygons: cut.polygons,
            turned,
            welded: polygons.reading.welded,
            unreferenced: polygons.reading.unreferenced,
            unkept,
        };
        Ok(Self { positions: polygons.positions, triangles, corners, import })
    }

    /// The cage as triangles to be drawn or written.
    pub fn to_triangles(&self) -> Triangles {
        Triangles { positions: self.positions.clone(), triangles: self.triangles.clone(), ..Triangles::default() }
    }
}

/// Faults with which a face cannot be cut into triangles that mean anything: corners that name no
/// vertex, and polygons of more than three sides that name one twice.
fn uncuttable(polygons: &Polygons) -> Vec<Fault> {
    let vertex_count = polygons.positions.len();
    let mut found = Vec::new();
    let mut pinched = Vec::new();
    let mut sorted = Vec::new();
    for (f, corners) in polygons.faces().enumerate() {
        let face = FaceId::new(f);
        let beyond = corners.iter().filter(|&&index| index as usize >= vertex_count);
        found.extend(beyond.map(|&index| Fault::IndexOutOfRange { face, index, vertex_count }));
        if corners.len() > 3 {
            sorted.clear();
            sorted.extend_from_slice(corners);
            sorted.sort_unstable();
            let twice = sorted.windows(2).find(|pair| pair[0] == pair[1]);
            pinched.extend(twice.map(|pair| Fault::DegenerateFace { face, vertex: VertexId(pair[0]) }));
        }
    }
    found.append(&mut pinched);
    found
}

/// The triangles with windings that agree, or every fault.
fn settle(vertex_count: usize, triangles: &[[u32; 3]]) -> Result<Oriented, Vec<Fault>> {
    let mut found = faults(vertex_count, triangles);
    // Windings are about to be made to agree; where they cannot be, `orient` says so.
    found.retain(|fault| !matches!(fault, Fault::InconsistentWinding { .. }));
    match orient(vertex_count, triangles) {
        Ok(oriented) if found.is_empty() => return Ok(oriented),
        Ok(_) => {}
        Err(more) => found.extend(more.into_iter().filter(|fault| matches!(fault, Fault::NonOrientable { .. }))),
    }
    Err(found)
}

fn placed(found: impl IntoIterator<Item = Fault>, polygons: &Polygons) -> CageError {
    let place = |fault: Fault| PlacedFault { place: place(&fault, polygons), fault };
    CageError::Faulty { faults: found.into_iter().map(place).collect() }
}

fn place(fault: &Fault, polygons: &Polygons) -> Option<Place> {
    match fault {
        Fault::IndexOutOfRange { face, .. }
        | Fault::DegenerateFace { face, .. }
        | Fault::NonOrientable { face, .. } => polygons.place_of_face(*face),
        Fault::DuplicateFace { second, .. } => polygons.place_of_face(*second),
        Fault::NonManifoldEdge { faces, .. } => faces.last().and_then(|&face| polygons.place_of_face(face)),
        Fault::InconsistentWinding { faces, .. } => polygons.place_of_face(faces[1]),
        Fault::NonManifoldVertex { vertex, .. } | Fault::UnusedVertex { vertex } | Fault::NotFinite { vertex, .. } => {
            polygons.place_of_vertex(*vertex)
        }
        _ => None,
    }
}
