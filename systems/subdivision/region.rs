//! Sets of faces of one level, as ascending codes.

use selvedge_components::mesh::{Connectivity, HalfedgeId};
use selvedge_components::subdivision::{Address, Details, FaceCode};

use crate::parallel::map_dear_in_order;

/// All faces of `level`.
pub fn whole(mesh: &Connectivity, level: u32) -> Vec<FaceCode> {
    (0..(mesh.face_count() as u64) << (2 * level)).map(FaceCode).collect()
}

/// Faces whose neighbours are looked for by one thread at a time.
const FACES_AT_ONCE: usize = 256;

/// `N(T)` of [Litke et al. 2001, Section 3.3]: all faces that share a vertex with one of `faces`.
pub fn neighbourhood(mesh: &Connectivity, level: u32, faces: &[FaceCode]) -> Vec<FaceCode> {
    let all = (mesh.face_count() as u64) << (2 * level);
    if faces.len() as u64 == all {
        return faces.to_vec();
    }
    // A face has twelve around it. Marking them is cheaper than sorting them as long as the marks of
    // all faces of the level fit into about as many words.
    if all <= 1024 * faces.len() as u64 {
        let mut marks = Marks::new(all);
        faces.iter().for_each(|&f| marks.set(f));
        let found = map_dear_in_order(faces.len().div_ceil(FACES_AT_ONCE), |i| {
            let begin = i * FACES_AT_ONCE;
            let mut beyond = Vec::new();
            let chunk = &faces[begin..faces.len().min(begin + FACES_AT_ONCE)];
            around(mesh, level, chunk, |f| marks.has(f), |f| beyond.push(f));
            beyond
        });
        found.into_iter().flatten().for_each(|f| marks.set(f));
        return marks.ascending();
    }
    let mut grown = faces.to_vec();
    around(mesh, level, faces, |_| false, |f| grown.push(f));
    ascending(grown)
}

/// Calls `see` with every face that shares a vertex with one of `faces`, some of them more than once;
/// some that are `known` may be left out.
///
/// Where some of the faces around a vertex are known and others are not, two that share an edge differ:
/// a corner of which both edges lead to known faces need not be gone round from this face.
fn around(
    mesh: &Connectivity,
    level: u32,
    faces: &[FaceCode],
    known: impl Fn(FaceCode) -> bool,
    mut see: impl FnMut(FaceCode),
) {
    for &face in faces {
        let leads_on = [0, 1, 2].map(|edge| face.across(mesh, level, edge).is_some_and(|(f, _)| !known(f)));
        for corner in 0..3 {
            if leads_on[corner] || leads_on[(corner + 2) % 3] {
                around_corner(mesh, level, face, corner, &mut see);
            }
        }
    }
}

/// A bit for every face of a level.
struct Marks(Vec<u64>);

impl Marks {
    fn new(faces: u64) -> Self {
        Self(vec![0; faces.div_ceil(64) as usize])
    }

    fn set(&mut self, face: FaceCode) {
        self.0[(face.0 / 64) as usize] |= 1 << (face.0 % 64);
    }

    fn has(&self, face: FaceCode) -> bool {
        self.0[(face.0 / 64) as usize] >> (face.0 % 64) & 1 == 1
    }

    /// The faces that are marked.
    fn ascending(&self) -> Vec<FaceCode> {
        let count = self.0.iter().map(|word| word.count_ones() as usize).sum();
        let mut faces = Vec::with_capacity(count);
        for (base, &word) in (0_u64..).step_by(64).zip(&self.0) {
            let mut left = word;
            while left != 0 {
                faces.push(FaceCode(base + u64::from(left.trailing_zeros())));
                left &= left - 1;
            }
        }
        faces
    }
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

/// By level, that after the root's first: the faces that a detail of the level or of a finer one shapes.
///
/// That is the faces of two rings around a detail, and no others: what lies beyond keeps the way in which it
/// is evaluated, and so its bits. An address that its level does not have stands for nothing.
pub fn detailed(mesh: &Connectivity, details: &Details) -> Vec<Vec<FaceCode>> {
    let mut detailed = vec![Vec::new(); details.depth().saturating_sub(1) as usize];
    let mut finer = Vec::new();
    for (level, faces) in (1_u32..).zip(&mut detailed).collect::<Vec<_>>().into_iter().rev() {
        let stored = details.levels.get(level as usize).map_or(&[][..], Vec::as_slice);
        let mut around = Vec::new();
        for (face, corner) in stored.iter().filter_map(|&(address, _)| corner_at(mesh, level, address)) {
            around.push(face);
            fan(mesh, level, face, corner, &mut around);
        }
        let mut all = neighbourhood(mesh, level, &ascending(around));
        all.append(&mut finer);
        *faces = ascending(all);
        finer = parents(faces);
    }
    detailed
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
    around_corner(mesh, level, face, corner, &mut |f| out.push(f));
}

fn around_corner(mesh: &Connectivity, level: u32, face: FaceCode, corner: usize, see: &mut impl FnMut(FaceCode)) {
    let mut at = (face, corner);
    while let Some(next) = at.0.across(mesh, level, (at.1 + 2) % 3) {
        if next.0 == face {
            return;
        }
        see(next.0);
        at = next;
    }
    // A border was met: the rest of the fan lies the other way round.
    at = (face, corner);
    while let Some((next, twin)) = at.0.across(mesh, level, at.1) {
        if next == face {
            return;
        }
        see(next);
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

    /// However the faces around some are found, they are the same ones: around a whole, around a border,
    /// around vertices that few faces meet at.
    #[test]
    fn marks_and_sorting_find_the_same_neighbourhood() {
        let octahedron = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        for faces in [&octahedron[..], &octahedron[..6]] {
            let mesh = Connectivity::new(6, faces).expect("an octahedron, or a part of it");
            for level in 1..7 {
                let all = (faces.len() as u64) << (2 * level);
                let every = |step: u64, run: u64| (0..all).filter(|f| f % step < run).map(FaceCode).collect::<Vec<_>>();
                for some in [every(97, 1), every(97, 20), every(31, 30), every(all, 1 + all / 2)] {
                    let mut by_sorting = some.clone();
                    some.iter().for_each(|&f| (0..3).for_each(|c| fan(&mesh, level, f, c, &mut by_sorting)));
                    assert_eq!(neighbourhood(&mesh, level, &some), ascending(by_sorting), "{} at {level}", some.len());
                }
                assert!(neighbourhood(&mesh, level, &every(97, 1)[..1]).len() <= 13);
            }
        }
    }

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
