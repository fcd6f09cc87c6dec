//! Names for the vertices: root vertices, then those inside root edges, then those inside root faces.

use std::sync::Arc;

use selvedge_components::mesh::{Connectivity, EdgeId, FaceId, HalfedgeId};

use super::forest::{Forest, Node, Steps, Tile};

/// What stands on one root face.
#[derive(Debug, Default)]
pub struct Plot {
    /// Its leaves, along the paths of quarters.
    pub leaves: Vec<Tile>,
    /// The vertices that it makes inside each of its edges: steps from the end with the smaller vertex
    /// id, ascending.
    edges: [Vec<u32>; 3],
    /// The vertices inside it, ascending.
    inside: Vec<Steps>,
    /// By steps towards the second corner: where they begin in `inside`. Empty where there are few.
    rows: Vec<u32>,
}

impl Plot {
    /// What stands on `face`.
    pub fn new(mesh: &Connectivity, forest: &Forest, face: FaceId) -> Self {
        let n = 1 << forest.finest();
        let mut plot = Self::default();
        forest.walk(face, |node| match node {
            Node::Leaf(tile) => plot.leaves.push(tile),
            Node::Split(tile) => {
                for at in tile.middles() {
                    match edge_of(n, at) {
                        Some((edge, along)) => plot.edges[edge].push(from_smaller(mesh, face, edge, along, n)),
                        None => plot.inside.push(at),
                    }
                }
            }
        });
        plot.edges.iter_mut().for_each(|edge| edge.sort_unstable());
        plot.inside.sort_unstable();
        // Two quartered neighbours have the same middle.
        plot.inside.dedup();
        // For each vertex no more than a few rows.
        if n as usize <= 4 * plot.inside.len() {
            let begin = |i: u32| plot.inside.partition_point(|at| at.0 < i) as u32;
            plot.rows = (0..=n).map(begin).collect();
        }
        plot
    }

    /// The place of a vertex among those inside.
    fn place(&self, n: u32, at: Steps) -> Option<usize> {
        let Some(&[begin, end]) = self.rows.get(at.0 as usize..at.0 as usize + 2) else {
            return self.inside.binary_search(&at).ok();
        };
        let (begin, row) = (begin as usize, &self.inside[begin as usize..end as usize]);
        // Most rows are filled evenly, and this is the place in one that is.
        let likely = row.len() * at.1 as usize / (n - at.0) as usize;
        if row.get(likely) == Some(&at) {
            return Some(begin + likely);
        }
        row.binary_search(&at).ok().map(|place| begin + place)
    }
}

/// The edge that a point other than a corner lies on, and how far from its beginning.
fn edge_of(n: u32, (i, j): Steps) -> Option<(usize, u32)> {
    if j == 0 {
        Some((0, i))
    } else if i + j == n {
        Some((1, j))
    } else {
        (i == 0).then_some((2, n - j))
    }
}

fn from_smaller(mesh: &Connectivity, face: FaceId, edge: usize, along: u32, n: u32) -> u32 {
    let h = HalfedgeId::of(face, edge);
    if mesh.from(h) < mesh.to(h) { along } else { n - along }
}

/// The vertices of a forest and their names, in the order that the
/// [module](super) promises.
#[derive(Debug)]
pub struct Names {
    mesh: Arc<Connectivity>,
    plots: Vec<Plot>,
    /// Steps along an edge of a root face.
    pub n: u32,
    /// By edge: where its vertices begin in `on_edges`.
    edges: Vec<u32>,
    on_edges: Vec<u32>,
    /// By face: the name of its first vertex.
    inside: Vec<u32>,
}

impl Names {
    /// Names what stands on the faces of `mesh`; `n` is how many steps their edges have.
    pub fn new(mesh: Arc<Connectivity>, n: u32, plots: Vec<Plot>) -> Self {
        let mut names = Self { mesh, plots, n, edges: vec![0], on_edges: Vec::new(), inside: Vec::new() };
        for e in 0..names.mesh.edge_count() {
            names.push_edge(names.mesh.halfedge(EdgeId::new(e)));
        }
        let mut next = names.corner_count() + names.on_edges.len();
        for plot in &names.plots {
            names.inside.push(next as u32);
            next += plot.inside.len();
        }
        names.inside.push(next as u32);
        names
    }

    fn push_edge(&mut self, h: HalfedgeId) {
        let list = |h: HalfedgeId| &self.plots[h.face().index()].edges[h.corner()][..];
        let (ours, theirs) = (list(h), self.mesh.twin(h).map_or(&[][..], list));
        let begin = self.on_edges.len();
        self.on_edges.extend_from_slice(ours);
        if ours != theirs {
            self.on_edges.extend_from_slice(theirs);
            let mut both = self.on_edges.split_off(begin);
            both.sort_unstable();
            both.dedup();
            self.on_edges.extend(both);
        }
        self.edges.push(self.on_edges.len() as u32);
    }

    /// How many vertices there are.
    pub fn count(&self) -> usize {
        self.inside.last().map_or(0, |&n| n as usize)
    }

    /// How many of them are root vertices.
    pub fn corner_count(&self) -> usize {
        self.mesh.vertex_count()
    }

    /// What stands on a face.
    pub fn plot(&self, face: FaceId) -> &Plot {
        &self.plots[face.index()]
    }

    /// The vertices inside an edge: steps from the end with the smaller vertex id.
    pub fn on_edge(&self, edge: EdgeId) -> &[u32] {
        &self.on_edges[self.edges[edge.index()] as usize..self.edges[edge.index() + 1] as usize]
    }

    /// The vertices inside a face.
    pub fn inside(&self, face: FaceId) -> &[Steps] {
        &self.plots[face.index()].inside
    }

    /// The name of a corner of a tile of `face`.
    #[inline]
    pub fn of(&self, face: FaceId, at: Steps) -> u32 {
        let (i, j) = at;
        let weights = [self.n - i - j, i, j];
        match weights.iter().position(|&w| w == self.n) {
            Some(corner) => self.mesh.face(face)[corner].0,
            None => self.find(face, at).expect("the corners of a quarter are middles or corners of what it quarters"),
        }
    }

    /// The name of a point of `face` other than its corners, if a vertex is there.
    #[inline]
    pub fn find(&self, face: FaceId, at: Steps) -> Option<u32> {
        let Some((edge, along)) = edge_of(self.n, at) else {
            let place = self.plots[face.index()].place(self.n, at)?;
            return Some(self.inside[face.index()] + place as u32);
        };
        let e = self.mesh.edge(HalfedgeId::of(face, edge));
        let place = self.on_edge(e).binary_search(&from_smaller(&self.mesh, face, edge, along, self.n)).ok()?;
        Some(self.corner_count() as u32 + self.edges[e.index()] + place as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_components::subdivision::FaceCode;

    /// Vertices inside a face are found, and what is none is not, in rows that are filled evenly or not.
    #[test]
    fn every_vertex_inside_a_face_has_its_name_and_nothing_else_has_one() {
        let mesh = Arc::new(Connectivity::new(4, &[[0, 1, 2], [2, 1, 3]]).expect("a valid mesh"));
        let mut forest = Forest::uniform(2, 3);
        forest.split(&mesh, &[vec![], vec![], vec![], vec![FaceCode(5), FaceCode(6), FaceCode(40)]]);
        let n = 1 << forest.finest();
        let plots = [0, 1].map(|f| Plot::new(&mesh, &forest, FaceId::new(f)));
        assert!(plots.iter().all(|plot| !plot.rows.is_empty()));
        let names = Names::new(mesh, n, plots.into());
        for face in [0, 1].map(FaceId) {
            for (i, j) in (1..n).flat_map(|i| (1..n - i).map(move |j| (i, j))) {
                let place = names.inside(face).iter().position(|&at| at == (i, j));
                let name = place.map(|place| names.inside[face.index()] + place as u32);
                assert_eq!(names.find(face, (i, j)), name, "{face:?} {i} {j}");
            }
        }
    }
}
