//! Meshes to test with, and plain ways of looking at them that share no code with the library.

use std::collections::{BTreeMap, BTreeSet};

pub type Faces = Vec<[u32; 3]>;

pub const TETRAHEDRON: [[u32; 3]; 4] = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];

pub fn octahedron() -> Faces {
    vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [5, 2, 1], [5, 3, 2], [5, 4, 3], [5, 1, 4]]
}

/// Does the far side of a grid join its near side?
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Ends {
    Free,
    Joined,
}

/// `columns` by `rows` squares of two triangles each; either direction may be closed to a ring.
/// Returns the number of vertices too.
pub fn grid(columns: u32, rows: u32, across: Ends, along: Ends) -> (usize, Faces) {
    let width = if across == Ends::Joined { columns } else { columns + 1 };
    let height = if along == Ends::Joined { rows } else { rows + 1 };
    let at = |x: u32, y: u32| (y % height) * width + x % width;
    let mut faces = Vec::new();
    for (y, x) in (0..rows).flat_map(|y| (0..columns).map(move |x| (y, x))) {
        faces.push([at(x, y), at(x + 1, y), at(x + 1, y + 1)]);
        faces.push([at(x, y), at(x + 1, y + 1), at(x, y + 1)]);
    }
    ((width * height) as usize, faces)
}

/// A strip of `length` squares whose end is joined to its beginning upside down.
pub fn moebius(length: u32) -> (usize, Faces) {
    let at = |x: u32, y: u32| if x < length { 2 * x + y } else { 1 - y };
    let squares =
        (0..length).flat_map(|x| [[at(x, 0), at(x + 1, 0), at(x + 1, 1)], [at(x, 0), at(x + 1, 1), at(x, 1)]]);
    (2 * length as usize, squares.collect())
}

/// The vertices that share an edge with each vertex.
pub fn neighbours(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<BTreeSet<u32>> {
    let mut around = vec![BTreeSet::new(); vertex_count];
    for (a, b) in directed_edges(faces) {
        around[a as usize].insert(b);
        around[b as usize].insert(a);
    }
    around
}

pub fn directed_edges(faces: &[[u32; 3]]) -> impl Iterator<Item = (u32, u32)> + '_ {
    faces.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
}

/// How many faces there are along each undirected edge, smaller end first.
pub fn undirected_edges(faces: &[[u32; 3]]) -> BTreeMap<(u32, u32), usize> {
    let mut edges = BTreeMap::new();
    for (a, b) in directed_edges(faces) {
        *edges.entry((a.min(b), a.max(b))).or_default() += 1;
    }
    edges
}

/// Is this an oriented 2-manifold? Judged from the definition: no edge is walked twice in one
/// direction, and the edges opposite each vertex form one path or one ring.
pub fn is_sound(vertex_count: usize, faces: &[[u32; 3]]) -> bool {
    let distinct: BTreeSet<[u32; 3]> = faces.iter().map(|&f| sorted(f)).collect();
    let edges: BTreeSet<(u32, u32)> = directed_edges(faces).collect();
    !faces.is_empty()
        && faces.iter().all(|&[a, b, c]| a != b && b != c && c != a)
        && distinct.len() == faces.len()
        && edges.len() == 3 * faces.len()
        && (0..vertex_count as u32).all(|v| link_is_connected(v, faces))
}

/// Is there a way from each edge opposite `v` to each other one? False when there are none.
fn link_is_connected(v: u32, faces: &[[u32; 3]]) -> bool {
    let mut links: Vec<[u32; 2]> = Vec::new();
    for face in faces.iter().filter(|face| face.contains(&v)) {
        let i = face.iter().position(|&c| c == v).unwrap();
        links.push([face[(i + 1) % 3], face[(i + 2) % 3]]);
    }
    let Some(mut reached) = links.pop().map(BTreeSet::from) else { return false };
    while let Some(next) = links.iter().position(|l| l.iter().any(|v| reached.contains(v))) {
        reached.extend(links.swap_remove(next));
    }
    links.is_empty()
}

pub fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}
