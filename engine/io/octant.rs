//! Meshes of the octant of a sphere: connectivity only, as JSON.
//!
//! ```json
//! { "meshes": { "name": { "vertices": 8, "triangles": [[0, 1, 2]], "sides": [[1, 2, 4]], "irregular": 0 } } }
//! ```

use std::collections::BTreeMap;

use selvedge_components::mesh::{Connectivity, Fault, VertexId};
use serde::Deserialize;
use thiserror::Error;

/// A triangle mesh with three sides, to be laid over an octant of a sphere.
#[derive(Clone, Debug, PartialEq)]
pub struct Octant {
    /// Its name, such as `cone(1,2)`.
    pub name: String,
    /// Its triangles.
    pub mesh: Connectivity,
    /// Three chains of border vertices, each from one corner of the octant to the next.
    pub sides: [Vec<VertexId>; 3],
    /// The one interior vertex whose valence is not six.
    pub irregular: VertexId,
}

/// Why a file of octant meshes is refused.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum OctantError {
    /// It is not JSON of the right form.
    #[error("line {line}, column {column}: {reason}")]
    Json {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What the JSON reader says.
        reason: String,
    },
    /// A mesh has defects.
    #[error("mesh {mesh:?}: {}", .faults[0])]
    Faulty {
        /// The mesh.
        mesh: String,
        /// All of them, at least one.
        faults: Vec<Fault>,
    },
    /// A vertex does not exist.
    #[error("mesh {mesh:?} names vertex {vertex}, but there are {vertex_count} vertices")]
    NoSuchVertex {
        /// The mesh.
        mesh: String,
        /// The vertex.
        vertex: VertexId,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// The sides, end to end, are not the border of the mesh walked once round.
    #[error("mesh {mesh:?}: its sides do not walk once round its border")]
    Sides {
        /// The mesh.
        mesh: String,
    },
}

#[derive(Deserialize)]
struct File {
    meshes: BTreeMap<String, Entry>,
}

#[derive(Deserialize)]
struct Entry {
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    sides: [Vec<u32>; 3],
    irregular: u32,
}

/// Reads all meshes of a file, by name.
///
/// # Errors
/// [`OctantError`] when the file is no such file or one of its meshes is none.
pub fn read(bytes: &[u8]) -> Result<Vec<Octant>, OctantError> {
    let file: File = serde_json::from_slice(bytes).map_err(|why| OctantError::Json {
        line: why.line(),
        column: why.column(),
        reason: why.to_string(),
    })?;
    file.meshes.into_iter().map(|(name, entry)| octant(name, entry)).collect()
}

fn octant(name: String, entry: Entry) -> Result<Octant, OctantError> {
    // A vertex that no triangle names is a fault, so more vertices than corners need not be counted.
    let vertex_count = entry.vertices.min(3 * entry.triangles.len() + 1);
    let mesh = Connectivity::new(vertex_count, &entry.triangles)
        .map_err(|faults| OctantError::Faulty { mesh: name.clone(), faults })?;
    let irregular = VertexId(entry.irregular);
    if irregular.index() >= vertex_count {
        return Err(OctantError::NoSuchVertex { mesh: name, vertex: irregular, vertex_count });
    }
    let sides = entry.sides.map(|side| side.into_iter().map(VertexId).collect());
    if !walk_round(&mesh, &sides) {
        return Err(OctantError::Sides { mesh: name });
    }
    Ok(Octant { name, mesh, sides, irregular })
}

/// Do the sides, each beginning where the one before ends, walk the only border once round?
fn walk_round(mesh: &Connectivity, sides: &[Vec<VertexId>; 3]) -> bool {
    let mut walk = Vec::new();
    for (i, side) in sides.iter().enumerate() {
        let [steps @ .., last] = &side[..] else { return false };
        if sides[(i + 1) % 3].first() != Some(last) {
            return false;
        }
        walk.extend_from_slice(steps);
    }
    let Some(smallest) = (0..walk.len()).min_by_key(|&i| walk[i]) else { return false };
    walk.rotate_left(smallest);
    mesh.border_loops() == [walk]
}
