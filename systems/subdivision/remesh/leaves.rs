//! Which faces of which level make up the adapted cage: quarters of quarters of root faces.

use std::collections::HashSet;

use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::FaceCode;

/// The faces that have been split into quarters, by level; what exists and is not split is a leaf.
///
/// Always true: leaves that share an edge differ by one level at most.
#[derive(Clone, Debug, Default)]
pub struct Leaves {
    split: Vec<HashSet<FaceCode>>,
}

/// Which edges of a leaf have a vertex in the middle: bit `i` for the edge after corner `i`.
pub type Hanging = u8;

impl Leaves {
    /// All faces of `level`.
    pub fn uniform(mesh: &Connectivity, level: u32) -> Self {
        let split = (0..level).map(|l| super::super::region::whole(mesh, l).into_iter().collect()).collect();
        Self { split }
    }

    /// One more than the finest level that is split: the finest level of a leaf.
    pub fn finest(&self) -> u32 {
        self.split.iter().rposition(|s| !s.is_empty()).map_or(0, |l| l as u32 + 1)
    }

    /// Is `code` of `level` a leaf or split?
    pub fn exists(&self, level: u32, code: FaceCode) -> bool {
        level == 0 || self.is_split(level - 1, code.parent())
    }

    /// Is `code` of `level` split?
    pub fn is_split(&self, level: u32, code: FaceCode) -> bool {
        self.split.get(level as usize).is_some_and(|s| s.contains(&code))
    }

    /// Is `code` of `level` a leaf?
    pub fn is_leaf(&self, level: u32, code: FaceCode) -> bool {
        self.exists(level, code) && !self.is_split(level, code)
    }

    /// How many faces are split, over all levels.
    pub fn split_count(&self) -> usize {
        self.split.iter().map(HashSet::len).sum()
    }

    /// The split faces of `level`, ascending.
    pub fn split_at(&self, level: u32) -> Vec<FaceCode> {
        let mut codes: Vec<_> = self.split.get(level as usize).map_or_else(Vec::new, |s| s.iter().copied().collect());
        codes.sort_unstable();
        codes
    }

    /// The faces of `level` that exist, ascending.
    pub fn existing(&self, mesh: &Connectivity, level: u32) -> Vec<FaceCode> {
        match level {
            0 => super::super::region::whole(mesh, 0),
            _ => super::super::region::children(&self.split_at(level - 1)),
        }
    }

    /// Splits `code` of `level`, and coarser neighbours as the balance asks for.
    pub fn split(&mut self, mesh: &Connectivity, level: u32, code: FaceCode) {
        let mut todo = vec![(level, code)];
        while let Some((level, code)) = todo.pop() {
            if self.is_split(level, code) {
                continue;
            }
            if self.split.len() <= level as usize {
                self.split.resize(level as usize + 1, HashSet::new());
            }
            if level > 0 && !self.exists(level, code) {
                todo.push((level, code));
                todo.push((level - 1, code.parent()));
                continue;
            }
            self.split[level as usize].insert(code);
            if level > 0 {
                let neighbours = (0..3).filter_map(|i| code.across(mesh, level, i));
                let missing = neighbours.map(|(n, _)| n).filter(|&n| !self.exists(level, n));
                todo.extend(missing.map(|n| (level - 1, n.parent())));
            }
        }
    }

    /// The edges of a leaf beyond which the neighbour is split.
    pub fn hanging(&self, mesh: &Connectivity, level: u32, code: FaceCode) -> Hanging {
        (0..3)
            .filter(|&i| code.across(mesh, level, i).is_some_and(|(n, _)| self.is_split(level, n)))
            .fold(0, |bits, i| bits | 1 << i)
    }

    /// Splits every leaf all of whose neighbours are split: it has four parts anyway.
    pub fn fill(&mut self, mesh: &Connectivity) {
        for level in (0..self.split.len() as u32).rev() {
            let mut todo = self.split_at(level);
            while let Some(code) = todo.pop() {
                for (n, _) in (0..3).filter_map(|i| code.across(mesh, level, i)) {
                    if self.is_leaf(level, n) && self.hanging(mesh, level, n) == 0b111 {
                        self.split(mesh, level, n);
                        todo.push(n);
                    }
                }
            }
        }
    }

    /// All leaves as `(level, code)`, by root face, then along the paths.
    pub fn all(&self, mesh: &Connectivity) -> Vec<(u32, FaceCode)> {
        let mut leaves = Vec::with_capacity(mesh.face_count());
        for root in super::super::region::whole(mesh, 0) {
            let mut stack = vec![(0, root)];
            while let Some((level, code)) = stack.pop() {
                if self.is_split(level, code) {
                    stack.extend((0..4).rev().map(|c| (level + 1, code.child(c))));
                } else {
                    leaves.push((level, code));
                }
            }
        }
        leaves
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use selvedge_components::mesh::FaceId;

    fn octahedron() -> Connectivity {
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1], [5, 2, 1], [5, 3, 2], [5, 4, 3], [5, 1, 4]];
        Connectivity::new(6, &faces).expect("an octahedron")
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn neighbours_differ_by_one_level_and_leaves_tile_every_face(
            paths in proptest::collection::vec((0_u64..8, 0_u64..1024, 1_u32..6), 1..6),
        ) {
            let mesh = octahedron();
            let mut leaves = Leaves::default();
            for (face, path, level) in paths {
                leaves.split(&mesh, level, FaceCode(face << (2 * level) | path & ((1 << (2 * level)) - 1)));
            }
            leaves.fill(&mesh);
            let mut area = [0_u64; 8];
            for (level, code) in leaves.all(&mesh) {
                area[code.root_face(level).index()] += 1 << (2 * (10 - level));
                prop_assert!(leaves.hanging(&mesh, level, code) != 0b111);
                for i in 0..3 {
                    let Some((n, twin)) = code.across(&mesh, level, i) else { continue };
                    let coarser = level > 0 && leaves.is_leaf(level - 1, n.parent());
                    let same = leaves.is_leaf(level, n);
                    // The two quarters along the shared edge hold its ends.
                    let finer = leaves.is_split(level, n)
                        && [twin, (twin + 1) % 3].iter().all(|&c| leaves.is_leaf(level + 1, n.child(c)));
                    prop_assert!(coarser || same || finer, "level {} {:?}", level, code);
                }
            }
            prop_assert_eq!(area, [1 << 20; 8]);
            prop_assert_eq!(FaceId(0), FaceCode(0).root_face(0));
        }
    }
}
