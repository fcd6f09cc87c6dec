//! Details carried from one mesh to another that shares faces with it.

use glam::DVec3;
use selvedge_components::mesh::{Connectivity, FaceId, VertexId};
use selvedge_components::subdivision::Address;

use super::zone::edge_of;

/// What vertices and faces of one mesh are called on another. Names keep their order, and faces
/// their first corner.
pub trait Names {
    /// The other name of a vertex.
    fn vertex(&self, v: VertexId) -> Option<VertexId>;
    /// The other name of a face.
    fn face(&self, f: FaceId) -> Option<FaceId>;
}

/// The details of a level with their addresses on `to`, ascending; those that have none are left out.
pub fn rename_details(
    level: &[(Address, DVec3)],
    from: &Connectivity,
    to: &Connectivity,
    names: &dyn Names,
) -> Vec<(Address, DVec3)> {
    let renamed = level.iter().filter_map(|&(address, value)| {
        let address = match address {
            Address::Corner(v) => Address::Corner(names.vertex(v)?),
            // Steps count from the end with the smaller name, and names keep their order.
            Address::Edge(e, steps) => Address::Edge(edge_of(from, to, names, e)?, steps),
            Address::Face(f, i, j) => Address::Face(names.face(f)?, i, j),
        };
        Some((address, value))
    });
    let mut renamed: Vec<_> = renamed.collect();
    renamed.sort_unstable_by_key(|detail| detail.0);
    renamed
}
