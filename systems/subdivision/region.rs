//! Sets of faces of one level, as ascending codes.

use selvedge_components::mesh::{Connectivity, HalfedgeId};
use selvedge_components::subdivision::{Address, FaceCode};

/// All faces of `level`.
pub fn whole(mesh: &Connectivity, level: u32) -> Vec<FaceCode> {
    (0..(mesh.face_count() as u64) << (2 * level)).map(FaceCode).collect()
}

/// `N(T)` of [Litke et al. 2001, Section 3.3]: all faces that share a vertex with one of `faces`.
pub fn neighbourhood(mesh: &Connectivity, level: u32, faces: &[FaceCode]) -> Vec<FaceCode> {
    if faces.len() as u64 == (mesh.face_count() as u64) << (2 * level) {
        return faces.to_vec();
    }
    let mut grown = Vec::with_capacity(13 * faces.len());
    for &face in faces {
        grown.push(face);
        for corner in 0..3 {
            fan(mesh, level, face, corner, &mut grown);
        }
    }
    ascending(grown)
}

/// The parents of `faces`.
pub fn parents(faces: &[FaceCode]) -> Vec<FaceCode> {
    let mut parents: Vec<_> = faces.iter().map(|f| f.parent()).collect();
    parents.dedup();
    parents
}

/// The children of `faces`.
pub fn children(faces: &[FaceCode]) -> Vec<FaceCode> {
    faces.iter().flat_map(|f| (0..4).map(move |c| f.child(c))).collect()
}

/// Is every face of `some` in `all`? Both ascend.
pub fn contains_all(all: &[FaceCode], some: &[FaceCode]) -> bool {
    some.iter().all(|f| all.binary_search(f).is_ok())
}

/// Sorted, each once.
pub fn ascending(mut faces: Vec<FaceCode>) -> Vec<FaceCode> {
    faces.sort_unstable();
    faces.dedup();
    faces
}

/// Adds the other faces around one corner of `face`.
pub fn fan(mesh: &Connectivity, level: u32, face: FaceCode, corner: usize, out: &mut Vec<FaceCode>) {
    let mut at = (face, corner);
    while let Some(next) = at.0.across(mesh, level, (at.1 + 2) % 3) {
        if next.0 == face {
            return;
        }
        out.push(next.0);
        at = next;
    }
    // A border was met: the rest of the fan lies the other way round.
    at = (face, corner);
    while let Some((next, twin)) = at.0.across(mesh, level, at.1) {
        if next == face {
            return;
        }
        out.push(next);
        at = (next, (twin + 1) % 3);
    }
}

/// A face of `level` with the vertex at `address`, and which of its corners that is; `None` if the level
/// has no such vertex.
pub fn corner_at(mesh: &Connectivity, level: u32, address: Address) -> Option<(FaceCode, usize)> {
    let n = 1_u32 << level;
    let along = |h: HalfedgeId, steps: u32| {
        let mut weights = [0; 3];
        weights[h.corner()] = n - steps;
        weights[h.next().corner()] = steps;
        (h.face(), weights)
    };
    let (face, weights) = match address {
        Address::Corner(v) if v.index() < mesh.vertex_count() => along(mesh.outgoing(v), 0),
        Address::Edge(e, steps) if e.index() < mesh.edge_count() && (1..n).contains(&steps) => {
            let h = mesh.halfedge(e);
            along(h, if mesh.from(h) < mesh.to(h) { steps } else { n - steps })
        }
        Address::Face(face, i, j) if face.index() < mesh.face_count() && 0 < i && i < n && 0 < j && j < n - i => {
            (face, [n - i - j, i, j])
        }
        _ => return None,
    };
    Some(descend(level, FaceCode::root(face), weights))
}

/// A face of `level` below the root face `face`, and its corner, that stands where the root's corners
/// weigh `weights`, which add up to `2^level`.
fn descend(level: u32, mut face: FaceCode, mut weights: [u32; 3]) -> (FaceCode, usize) {
    for l in (0..level).rev() {
        let half = 1_u32 << l;
        let child = weights.iter().position(|&w| w >= half);
        match child {
            Some(corner) => weights[corner] -= half,
            // The middle child's corner `i` halves edge `i`, across from corner `i + 2`.
            None => weights = [half - weights[2], half - weights[0], half - weights[1]],
        }
        face = face.child(child.unwrap_or(3));
    }
    (face, weights.iter().position(|&w| w == 1).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use selvedge_components::mesh::FaceId;

    use super::*;

    /// Descending to a lattice point ends at a face that has it as the corner named.
    #[test]
    fn a_lattice_point_is_the_corner_it_is_found_at() {
        for level in 0..5 {
            let n = 1_u32 << level;
            for i in 0..=n {
                for j in 0..=n - i {
                    let (face, corner) = descend(level, FaceCode::root(FaceId(5)), [n - i - j, i, j]);
                    assert_eq!(face.root_face(level), FaceId(5));
                    assert_eq!(face.corners(level)[corner], (i, j), "level {level}");
                }
            }
        }
    }
}
