//! Sets of faces of one level, as ascending codes.

use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::FaceCode;

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
