//! The forest of quartered faces, kept so that neighbouring leaves differ by one level at most.

use selvedge_components::mesh::{Connectivity, FaceId};
use selvedge_components::subdivision::{FaceCode, quartered};

use super::reach::union;
use crate::subdivision::region;

/// A point of a root face, in steps of the finest level towards its second and its third corner.
pub type Steps = (u32, u32);

/// A face of the forest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Its level.
    pub level: u32,
    /// Its code.
    pub code: FaceCode,
    /// Its corners.
    pub corners: [Steps; 3],
}

impl Tile {
    /// The middles of its edges; means nothing where it is not [coarse](Self::is_coarse).
    pub fn middles(&self) -> [Steps; 3] {
        let middle = |p: Steps, q: Steps| (u32::midpoint(p.0, q.0), u32::midpoint(p.1, q.1));
        let [a, b, c] = self.corners;
        [middle(a, b), middle(b, c), middle(c, a)]
    }

    /// Have its edges a step in their middle?
    pub fn is_coarse(&self) -> bool {
        let [a, b, _] = self.corners;
        a.0.abs_diff(b.0).max(a.1.abs_diff(b.1)) > 1
    }

    fn children(&self) -> [Self; 4] {
        let corners = quartered(self.corners, self.middles());
        core::array::from_fn(|i| Self { level: self.level + 1, code: self.code.child(i), corners: corners[i] })
    }
}

/// What a [walk](Forest::walk) comes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Node {
    /// A face that is quartered; its quarters follow.
    Split(Tile),
    /// One that is not.
    Leaf(Tile),
}

/// Root faces, some of them quartered, some of their quarters quartered, and so on.
///
/// Always true after [`Forest::split`]: where a face is quartered, its three neighbours of the same
/// level exist, quartered or not. So an edge of a leaf has at most one vertex inside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Forest {
    roots: usize,
    /// By level: the faces that are quartered, ascending.
    split: Vec<Vec<FaceCode>>,
}

impl Forest {
    /// `roots` faces, every one a leaf.
    pub fn new(roots: usize) -> Self {
        Self { roots, split: Vec::new() }
    }

    /// Every face quartered down to `level`.
    pub fn uniform(roots: usize, level: u32) -> Self {
        let all = |l| (0..(roots as u64) << (2 * l)).map(FaceCode).collect();
        Self { roots, split: (0..level).map(all).collect() }
    }

    /// The finest level that has a leaf.
    pub fn finest(&self) -> u32 {
        self.split.len() as u32
    }

    /// How many leaves there are.
    pub fn leaf_count(&self) -> usize {
        self.roots + 3 * self.split.iter().map(Vec::len).sum::<usize>()
    }

    /// Goes through all that stands on a root face, along the paths of quarters.
    pub fn walk(&self, root: FaceId, mut visit: impl FnMut(Node)) {
        let code = FaceCode::root(root);
        let begin = |(level, split): (usize, &Vec<FaceCode>)| split.partition_point(|f| f.0 >> (2 * level) < code.0);
        let mut next: Vec<usize> = self.split.iter().enumerate().map(begin).collect();
        let n = 1 << self.finest();
        self.walk_on(&mut next, Tile { level: 0, code, corners: [(0, 0), (n, 0), (0, n)] }, &mut visit);
    }

    /// `next` holds, by level, the place of the first split face that the walk has not come to.
    fn walk_on(&self, next: &mut [usize], tile: Tile, visit: &mut impl FnMut(Node)) {
        let level = tile.level as usize;
        if self.split.get(level).and_then(|split| split.get(next[level])) != Some(&tile.code) {
            return visit(Node::Leaf(tile));
        }
        next[level] += 1;
        visit(Node::Split(tile));
        for child in tile.children() {
            self.walk_on(next, child, visit);
        }
    }

    /// The faces of `level` that are quartered, ascending.
    pub fn split_faces(&self, level: u32) -> &[FaceCode] {
        self.split.get(level as usize).map_or(&[], Vec::as_slice)
    }

    /// Is this face of `level` quartered?
    pub fn is_split(&self, level: u32, face: FaceCode) -> bool {
        self.split_faces(level).binary_search(&face).is_ok()
    }

    /// The leaves of every level, ascending.
    pub fn leaves(&self) -> Vec<Vec<FaceCode>> {
        (0..=self.finest()).map(|level| self.unsplit(level, self.faces(level))).collect()
    }

    fn faces(&self, level: u32) -> Vec<FaceCode> {
        match level {
            0 => (0..self.roots).map(|f| FaceCode::root(FaceId::new(f))).collect(),
            l => region::children(&self.split[l as usize - 1]),
        }
    }

    /// Those of `faces`, which ascend, that are leaves.
    fn unsplit(&self, level: u32, mut faces: Vec<FaceCode>) -> Vec<FaceCode> {
        let Some(split) = self.split.get(level as usize) else { return faces };
        let mut split = split.iter().peekable();
        faces.retain(|f| {
            while split.next_if(|s| *s < f).is_some() {}
            split.peek() != Some(&f)
        });
        faces
    }

    /// Quarters the leaves that `failing` lists for every level, ascending, and those leaves that
    /// would otherwise have a neighbour two levels finer. Returns the new leaves of every level.
    pub fn split(&mut self, mesh: &Connectivity, failing: &[Vec<FaceCode>]) -> Vec<Vec<FaceCode>> {
        let mut new = failing.to_vec();
        while new.last().is_some_and(Vec::is_empty) {
            new.pop();
        }
        self.split.resize(self.split.len().max(new.len()), Vec::new());
        for level in (1..new.len()).rev() {
            let forced = self.missing_neighbours(mesh, level as u32, &new[level]);
            new[level - 1] = union(&new[level - 1], &forced);
        }
        for (split, new) in self.split.iter_mut().zip(&new) {
            *split = union(split, new);
        }
        let mut leaves = vec![Vec::new()];
        for (level, new) in new.iter().enumerate() {
            leaves.push(self.unsplit(level as u32 + 1, region::children(new)));
        }
        leaves
    }

    /// The leaves one level coarser that lie beside `faces` of `level`.
    fn missing_neighbours(&self, mesh: &Connectivity, level: u32, faces: &[FaceCode]) -> Vec<FaceCode> {
        let mut missing = Vec::new();
        for &face in faces {
            for (neighbour, _) in (0..3).filter_map(|corner| face.across(mesh, level, corner)) {
                let parent = neighbour.parent();
                if parent != face.parent() && !self.is_split(level - 1, parent) {
                    missing.push(parent);
                }
            }
        }
        region::ascending(missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share an edge.
    fn pair() -> Connectivity {
        Connectivity::new(4, &[[0, 1, 2], [2, 1, 3]]).expect("a valid mesh")
    }

    /// No face is quartered beside a leaf of a coarser level.
    fn balanced(mesh: &Connectivity, forest: &Forest) -> bool {
        forest.split.iter().enumerate().skip(1).all(|(level, split)| {
            split
                .iter()
                .flat_map(|f| (0..3).filter_map(move |c| f.across(mesh, level as u32, c)))
                .all(|(n, _)| forest.is_split(level as u32 - 1, n.parent()))
        })
    }

    /// Quartering again and again at one spot drags its surroundings along, one level apart.
    #[test]
    fn neighbouring_leaves_differ_by_one_level_at_most() {
        let mesh = pair();
        for path in 0..3_usize {
            let mut forest = Forest::new(2);
            let mut face = FaceCode(0);
            for level in 0..7 {
                let mut failing = vec![Vec::new(); level + 1];
                failing[level] = vec![face];
                let before = forest.leaf_count();
                let new = forest.split(&mesh, &failing);
                assert!(balanced(&mesh, &forest), "path {path}, level {level}");
                let leaves = forest.leaves();
                assert_eq!(leaves.iter().map(Vec::len).sum::<usize>(), forest.leaf_count());
                assert!(forest.leaf_count() > before);
                for (level, new) in new.iter().enumerate() {
                    assert!(region::contains_all(leaves.get(level).map_or(&[], Vec::as_slice), new));
                }
                // Towards the shared edge: at corner 1 or 2, or alternately.
                face = face.child(if path == 2 { 1 + level % 2 } else { 1 + path });
            }
        }
    }

    /// Children of one face, whatever the order in which they are asked for, are the same forest.
    #[test]
    fn the_order_of_splitting_does_not_matter() {
        let mesh = pair();
        let split = |steps: &[(usize, u64)]| {
            let mut forest = Forest::new(2);
            for &(level, code) in steps {
                let mut failing = vec![Vec::new(); level + 1];
                if !forest.is_split(level as u32, FaceCode(code)) {
                    failing[level] = vec![FaceCode(code)];
                }
                forest.split(&mesh, &failing);
            }
            forest
        };
        let one = split(&[(0, 0), (1, 3), (1, 1), (0, 1), (1, 6)]);
        let other = split(&[(0, 1), (1, 6), (0, 0), (1, 1), (1, 3)]);
        assert_eq!(one, other);
    }
}
