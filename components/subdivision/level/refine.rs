//! The next level: faces quartered, vertices placed, curves sampled.

use glam::DVec3;

use super::{BorderEdge, GivenVertex, Kind, LevelMesh, LevelVertex, NONE, Origin, RingState, SideEnd, sample};
use crate::subdivision::address::quartered;
use crate::subdivision::surface::LoopSurface;

impl LevelMesh {
    /// The next level over the children of `faces`, which ascend and must be
    /// [refinable](Self::refinable).
    pub fn refine(&self, surface: &LoopSurface, faces: &[u32]) -> Self {
        let along = |&(side, step): &BorderStep| sample(&surface.sides[side as usize], self.level + 1, step);
        self.quarter(faces).settle(self, |steps| steps.iter().map(along).collect())
    }

    /// The faces and vertices of [`Self::refine`], and nothing yet that takes looking at all of them.
    pub fn quarter(&self, faces: &[u32]) -> Quartered {
        self.quarter_with(faces, |links, vertices| {
            links();
            vertices();
        })
    }

    /// As [`Self::quarter`], in two halves that do not touch: `both` does both, at once if it can.
    pub fn quarter_with(
        &self,
        faces: &[u32],
        both: impl FnOnce(&mut (dyn FnMut() + Send), &mut (dyn FnMut() + Send)),
    ) -> Quartered {
        let mut family = vec![NONE; self.corners.len()];
        for (g, &f) in faces.iter().enumerate() {
            family[f as usize] = g as u32;
        }
        let (mut links, mut placed) = (Links::default(), Placed::default());
        both(&mut || links = self.link(&family, faces), &mut || placed = self.place_vertices(&family, faces));
        let level = Self {
            level: self.level + 1,
            codes: faces.iter().flat_map(|&f| (0..4).map(move |c| self.codes[f as usize].child(c))).collect(),
            corners: placed.corners,
            vertices: placed.vertices,
            given: Vec::new(),
            special: placed.special,
            beside: Vec::new(),
            twins: links.twins,
            borders: links.borders,
            border_edges: links.border_edges,
            parents: faces.to_vec(),
        };
        Quartered { level, halved: placed.halved }
    }

    /// Twins and borders of the children, from those of the parents.
    fn link(&self, family: &[u32], faces: &[u32]) -> Links {
        let mut finer = Links {
            twins: vec![NONE; 12 * faces.len()],
            borders: vec![NONE; 12 * faces.len()],
            border_edges: Vec::new(),
        };
        for (g, &parent) in (0_u32..).zip(faces) {
            let child = |c: u32, i: u32| 3 * (4 * g + c) + i;
            for i in 0..3 {
                let (inner, outer) = (child(3, i), child((i + 1) % 3, (i + 2) % 3));
                finer.twins[inner as usize] = outer;
                finer.twins[outer as usize] = inner;
                let h = 3 * parent + i;
                let (first, second) = (child(i, i), child((i + 1) % 3, i));
                if let Some(twin) = self.twin(h) {
                    let other = family[twin as usize / 3];
                    if other != NONE {
                        let k = twin % 3;
                        finer.twins[first as usize] = 3 * (4 * other + (k + 1) % 3) + k;
                        finer.twins[second as usize] = 3 * (4 * other + k) + k;
                    }
                } else if let Some((side, step)) = self.border(h) {
                    for (half, step) in [(first, 2 * step), (second, 2 * step + 1)] {
                        finer.borders[half as usize] = finer.border_edges.len() as u32;
                        finer.border_edges.push(BorderEdge { side, step });
                    }
                }
            }
        }
        finer
    }

    /// Vertices of the children: first those that stand for a vertex, in its order, then those that
    /// halve an edge, in the order of the smaller half-edge.
    fn place_vertices(&self, family: &[u32], faces: &[u32]) -> Placed {
        let mut finer = Placed { corners: Vec::with_capacity(4 * faces.len()), ..Placed::default() };
        let mut of_vertex = vec![NONE; self.vertices.len()];
        for &f in faces {
            for v in self.corners[f as usize] {
                of_vertex[v as usize] = 0;
            }
        }
        for (v, name) in of_vertex.iter_mut().enumerate().filter(|(_, name)| **name == 0) {
            *name = finer.vertices.len() as u32;
            let h = self.vertices[v].start;
            // A cut vertex may start in a face that is not subdivided: any child corner will do.
            let g = family[h as usize / 3];
            let start = if g == NONE { NONE } else { 3 * (4 * g + h % 3) + h % 3 };
            let origin = Origin::Vertex(v as u32);
            finer.special.extend((self.vertices[v].corner != NONE).then_some(*name));
            finer.vertices.push(LevelVertex { start, origin, ring: RingState::Whole, ..self.vertices[v] });
        }
        let mut of_edge = vec![NONE; self.twins.len()];
        for (g, &f) in faces.iter().enumerate() {
            for i in 0..3 {
                let h = 3 * f + i;
                if of_edge[h as usize] != NONE {
                    continue;
                }
                let name = finer.vertices.len() as u32;
                of_edge[h as usize] = name;
                let twin = self.twin(h).filter(|&t| family[t as usize / 3] != NONE);
                if let Some(twin) = twin {
                    of_edge[twin as usize] = name;
                }
                let on_border = self.border(h).is_some();
                finer.halved.extend(on_border.then_some(name));
                finer.vertices.push(LevelVertex {
                    start: 3 * (4 * g as u32 + (i + 1) % 3) + i,
                    valence: if on_border { 4 } else { 6 },
                    kind: Kind::Interior,
                    ring: RingState::Whole,
                    origin: Origin::Edge(h.min(self.twin(h).unwrap_or(h))),
                    corner: NONE,
                });
            }
        }
        for &f in faces {
            let corners = self.corners[f as usize].map(|v| of_vertex[v as usize]);
            let middles = [0, 1, 2].map(|i| of_edge[3 * f as usize + i]);
            finer.corners.extend(quartered(corners, middles));
        }
        finer
    }

    /// Marks the vertices where faces are missing, and gives those without a start one.
    fn mark_cuts(&mut self) {
        for h in 0..self.twins.len() as u32 {
            let from = self.from(h) as usize;
            if self.vertices[from].start == NONE {
                self.vertices[from].start = h;
            }
            if self.twins[h as usize] == NONE && self.borders[h as usize] == NONE {
                self.vertices[from].ring = RingState::Cut;
                let to = self.to(h) as usize;
                self.vertices[to].ring = RingState::Cut;
            }
        }
    }

    /// Numbers the vertices on given borders, which come first among those of the level before, anew.
    fn keep_samples(&mut self, coarser: &Self) {
        let ones = self.vertices.iter_mut().enumerate().take_while(|(_, v)| matches!(v.origin, Origin::Vertex(_)));
        for (v, vertex) in ones {
            let Kind::Given(old) = vertex.kind else { continue };
            vertex.kind = Kind::Given(self.given.len() as u32);
            self.given.push(GivenVertex { vertex: v as u32, ..coarser.given[old as usize] });
        }
    }

    /// The kinds of the vertices that halve border edges, of which the samples are given, and these.
    fn place_samples(&mut self, halved: &[u32], samples: Vec<Option<DVec3>>) {
        for (&v, sample) in halved.iter().zip(samples) {
            self.vertices[v as usize].kind = match sample {
                Some(sample) => {
                    self.given.push(GivenVertex { vertex: v, sample, end: SideEnd::Smooth });
                    Kind::Given(self.given.len() as u32 - 1)
                }
                None => Kind::Plain,
            };
        }
    }
}

/// How the half-edges of a finer level hang together.
#[derive(Default)]
struct Links {
    twins: Vec<u32>,
    borders: Vec<u32>,
    border_edges: Vec<BorderEdge>,
}

/// The vertices of a finer level.
#[derive(Default)]
struct Placed {
    corners: Vec<[u32; 3]>,
    vertices: Vec<LevelVertex>,
    special: Vec<u32>,
    /// Those that halve border edges, ascending.
    halved: Vec<u32>,
}

/// A place of a border: a side, and how many steps of the level from its beginning.
pub type BorderStep = (u32, u64);

/// A level on its way: see [`LevelMesh::quarter`].
#[derive(Debug)]
pub struct Quartered {
    level: LevelMesh,
    /// The vertices that halve border edges, ascending.
    halved: Vec<u32>,
}

impl Quartered {
    /// The level, which was made of `coarser`; `samples` gives [`sample`] at places of the level's borders, in
    /// their order. Curves may be what costs most: whoever has several threads divides the places among them.
    pub fn settle(self, coarser: &LevelMesh, samples: impl FnOnce(&[BorderStep]) -> Vec<Option<DVec3>>) -> LevelMesh {
        let Self { level: mut finer, halved } = self;
        finer.mark_cuts();
        finer.note_beside();
        finer.keep_samples(coarser);
        // Edges were linked and halved in one order, the second half of each after its first.
        let steps: Vec<BorderStep> =
            finer.border_edges.chunks_exact(2).map(|halves| (halves[1].side, halves[1].step)).collect();
        let samples = samples(&steps);
        finer.place_samples(&halved, samples);
        finer
    }
}
