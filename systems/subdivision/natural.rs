//! Which place of a target stands for a place of the surface that is fitted to it.

use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::LevelMesh;

/// A correspondence that is known beforehand: where to look first for closest points.
#[derive(Clone, Debug, Default)]
pub struct Natural {
    /// By root vertex of the surface, the place that stands for it.
    vertices: Vec<SurfacePoint>,
    /// By root face whose corners stand for places of one face of the target, those.
    faces: Vec<Option<[SurfacePoint; 3]>>,
}

impl Natural {
    /// Takes, by root vertex, the place that stands for it, and by root face of `mesh` those that stand for
    /// its corners, where they are known on one face of the target.
    pub fn new(
        mesh: &Connectivity,
        vertices: Vec<SurfacePoint>,
        on_one_face: impl Fn(usize) -> Option<[SurfacePoint; 3]>,
    ) -> Self {
        let of_corners = |f: usize| {
            let corners = mesh.faces()[f].map(|v| vertices[v.index()]);
            corners.iter().all(|at| at.face == corners[0].face).then_some(corners)
        };
        let faces = (0..mesh.face_count()).map(|f| on_one_face(f).or_else(|| of_corners(f))).collect();
        Self { vertices, faces }
    }

    /// The place that stands for vertex `v` of a level of the surface with the root mesh `root`; that of the
    /// nearest root vertex where its faces tell no better. `None` where nothing is known.
    pub fn place(&self, root: &Connectivity, mesh: &LevelMesh, v: u32) -> Option<SurfacePoint> {
        if self.vertices.is_empty() {
            return None;
        }
        let steps = 1_u32 << mesh.level;
        let weights = |h: u32| {
            let code = mesh.codes[h as usize / 3];
            let (i, j) = code.corners(mesh.level)[h as usize % 3];
            (code.root_face(mesh.level), [steps - i - j, i, j])
        };
        let on_face = |h: u32| {
            let (face, weights) = weights(h);
            let corners = self.faces.get(face.index()).copied().flatten()?;
            let shares = weights.map(|w| f64::from(w) / f64::from(steps));
            let st = corners.iter().zip(shares).map(|(at, share)| at.st * share).sum();
            Some(SurfacePoint { face: corners[0].face, st })
        };
        mesh.ring(v).find_map(on_face).or_else(|| {
            let (face, weights) = weights(mesh.vertices[v as usize].start);
            let heaviest = (1..3).fold(0, |best, c| if weights[c] > weights[best] { c } else { best });
            self.vertices.get(root.face(face)[heaviest].index()).copied()
        })
    }
}
