//! Which faces of which levels are kept.

use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::{CornerTable, FaceCode, LoopSurface};

use crate::subdivision::region;

/// Which faces to keep, level by level.
#[derive(Debug, Default)]
pub(super) struct Plan {
    next: Part,
    /// For each level, the faces that are evaluated through their children, ascending.
    pub split: Vec<Vec<FaceCode>>,
    /// Those of them that must be, for something happens below.
    pub unsettled: Vec<Vec<FaceCode>>,
    /// The faces whose children are kept: those of `split` and what their children's rings reach.
    pub refined: Vec<Vec<FaceCode>>,
}

/// What is found next.
#[derive(Clone, Copy, Debug, Default)]
enum Part {
    #[default]
    Unsettled,
    Split,
    /// Of the level before this one.
    Refined(usize),
    Ready,
}

/// Faces next to irregular vertices and borders are kept this many levels deep even if nothing but
/// subdivision happens there: five sixths of an irregular face are then one polynomial or another,
/// found and not made anew for each point.
const EXTRA_LEVELS: usize = 4;

/// ... and of a level the children of the first faces alone, no more than this for it: some 30 MB.
///
/// Both ways of evaluation agree to rounding, not to the bit, so which one a face has must not depend on
/// how many faces there are elsewhere. What a trim leaves alone comes first in its result, in the order that
/// it had.
const MOST_EXTRA: usize = 1 << 17;

impl Plan {
    /// Finds the next part; `None` once there is nothing more to find.
    pub fn advance(&mut self, surface: &LoopSurface, corners: &CornerTable) -> Option<()> {
        self.next = match self.next {
            Part::Unsettled => {
                self.unsettled = unsettled_faces(surface, corners);
                Part::Split
            }
            Part::Split => {
                self.split(&surface.mesh);
                Part::Refined(self.split.len())
            }
            Part::Refined(0) => Part::Ready,
            Part::Refined(l) => {
                self.refined[l - 1] = self.refined_of(&surface.mesh, l - 1);
                Part::Refined(l - 1)
            }
            Part::Ready => return None,
        };
        Some(())
    }

    fn split(&mut self, mesh: &Connectivity) {
        let finest = FaceCode::finest(mesh.face_count()) as usize;
        let split = &mut self.split;
        split.clone_from(&self.unsettled);
        for (l, irregular) in irregular_faces(mesh).into_iter().enumerate().take(finest) {
            if l == split.len() {
                split.push(Vec::new());
            }
            split[l].extend(irregular);
            split[l] = region::ascending(core::mem::take(&mut split[l]));
        }
        self.unsettled.resize(split.len(), Vec::new());
        self.refined.resize(split.len(), Vec::new());
    }

    /// Whose children are kept of level `l`, where that is known of finer levels.
    fn refined_of(&self, mesh: &Connectivity, l: usize) -> Vec<FaceCode> {
        let mut needed = region::children(&self.split[l]);
        if let Some(finer) = self.refined.get(l + 1) {
            needed.extend(finer);
            needed = region::ascending(needed);
        }
        region::parents(&region::neighbourhood(mesh, l as u32 + 1, &needed))
    }
}

/// The faces of each level whose children a detail of a finer level influences, or the rules at special
/// corners, which want one level between corners.
fn unsettled_faces(surface: &LoopSurface, corners: &CornerTable) -> Vec<Vec<FaceCode>> {
    let mesh = &surface.mesh;
    let detailed = region::detailed(mesh, &surface.details);
    let mut unsettled: Vec<Vec<FaceCode>> = detailed.iter().map(|faces| region::parents(faces)).collect();
    let special = corners.corners.iter().flat_map(|c| mesh.ring(c.vertex)).map(|h| FaceCode::root(h.face()));
    let special = region::neighbourhood(mesh, 0, &region::ascending(special.collect()));
    if !special.is_empty() && unsettled.is_empty() {
        unsettled.push(Vec::new());
    }
    if let Some(roots) = unsettled.first_mut() {
        roots.extend(special);
        *roots = region::ascending(core::mem::take(roots));
    }
    unsettled
}

/// A face on its way down to what makes it irregular.
#[derive(Clone, Copy)]
struct Irregular {
    code: FaceCode,
    /// Is each corner an irregular vertex or on a border?
    corners: [bool; 3],
    /// Does each edge, from a corner to the next, run along a border?
    edges: [bool; 3],
}

/// The faces of each level that one polynomial does not cover, as far as they are worth keeping.
fn irregular_faces(mesh: &Connectivity) -> Vec<Vec<FaceCode>> {
    let irregular = |v: VertexId| mesh.is_border(v) || mesh.valence(v) != 6;
    let root = (0..mesh.face_count()).map(FaceId::new).map(|f| Irregular {
        code: FaceCode::root(f),
        corners: mesh.face(f).map(irregular),
        edges: [0, 1, 2].map(|c| mesh.twin(HalfedgeId::of(f, c)).is_none()),
    });
    let mut faces: Vec<Irregular> = root.filter(Irregular::is_one).collect();
    let mut levels = Vec::new();
    while levels.len() < EXTRA_LEVELS && !faces.is_empty() {
        faces.truncate(MOST_EXTRA / 4);
        levels.push(faces.iter().map(|f| f.code).collect());
        faces = faces.iter().flat_map(|f| (0..4).map(|c| f.child(c))).filter(Irregular::is_one).collect();
    }
    levels
}

impl Irregular {
    fn is_one(&self) -> bool {
        self.corners.contains(&true)
    }

    /// Halves of edges are as the edges; what an edge's middle is, the edge tells.
    fn child(&self, child: usize) -> Self {
        let (mut corners, mut edges) = (self.edges, [false; 3]);
        if child < 3 {
            let (next, after) = ((child + 1) % 3, (child + 2) % 3);
            corners[child] = self.corners[child];
            corners[next] = self.edges[child];
            corners[after] = self.edges[after];
            (edges[child], edges[after]) = (self.edges[child], self.edges[after]);
        }
        Self { code: self.code.child(child), corners, edges }
    }
}
