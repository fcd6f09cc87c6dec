//! The limit surface of a combined Loop surface, ready to be evaluated anywhere.
//!
//! Kept are the levels that details reach, each over no more faces than they influence there, and a
//! few more around irregular vertices and borders. Below them nothing but the rules acts, and
//! [`Patch`] evaluates a face from the rings of its corners alone. Derived from the surface and
//! dropped at will.

mod build;
mod nest;
mod plan;

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::evaluate::{Evaluate, Jet, SurfacePoint};
use selvedge_components::mesh::{FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::{
    CornerTable, Descent, FaceCode, Kind, LevelMesh, LimitFrame, LoopSurface, NONE, Patch, RingState, Scheme,
    limit_frame, next,
};
use thiserror::Error;

use super::chain::Level;
use crate::parallel::map_in_order;
pub use build::LimitBuild;
pub use nest::{Nest, Spot};

/// Why a surface cannot be evaluated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LimitError {
    /// There is not one control point for each vertex.
    #[error("{points} control points for {vertices} vertices")]
    PointCount {
        /// How many control points there are.
        points: usize,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A control point or curve sample is not finite.
    #[error("the surface is not finite at {vertex:?}: {at}")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        at: DVec3,
    },
    /// Details lie on a level that is finer than faces of this mesh can be addressed.
    #[error("details on level {level}, finer than the finest that {faces} root faces allow, {finest}")]
    TooFine {
        /// The finest level that has details.
        level: u32,
        /// Root faces.
        faces: usize,
        /// The finest possible.
        finest: u32,
    },
}

/// The limit position and tangents at every vertex of a level mesh that `wanted` selects, `None` at
/// the others and where a ring is cut. See [`limit_frame`].
pub fn limit_frames(
    scheme: Scheme<'_>,
    level: &Level,
    wanted: impl Fn(u32) -> bool + Sync + Send,
) -> Vec<Option<LimitFrame>> {
    map_in_order(level.mesh.vertices.len(), |v| {
        let v = v as u32;
        wanted(v).then(|| limit_frame(scheme, &level.mesh, &level.state, v)).flatten()
    })
}

/// The limit surface of a [`LoopSurface`], details, given borders and all.
#[derive(Clone, Debug)]
pub struct LimitSurface {
    surface: Arc<LoopSurface>,
    corners: CornerTable,
    levels: Vec<KeptLevel>,
}

#[derive(Clone, Debug)]
struct KeptLevel {
    level: Level,
    /// What each face is.
    faces: Vec<Face>,
    /// The control points of the faces that one polynomial covers.
    nets: Vec<[u32; 12]>,
    /// Those with children of their own that something happens to, ascending.
    unsettled: Vec<FaceCode>,
}

/// What evaluates a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Face {
    /// Its children: the index of the first on the next level.
    Children(u32),
    /// One polynomial: its entry in the nets.
    Regular(u32),
    /// The rings of its corners.
    Patch,
}

impl LimitSurface {
    /// Prepares `surface`. Costs what the faces that details influence cost on every level, and one
    /// pass over the root mesh.
    ///
    /// # Errors
    /// Every variant of [`LimitError`].
    pub fn new(surface: Arc<LoopSurface>) -> Result<Self, LimitError> {
        LimitBuild::new(surface)?.finish()
    }

    /// The surface that is evaluated.
    pub fn surface(&self) -> &Arc<LoopSurface> {
        &self.surface
    }

    /// The finest level that is kept.
    pub fn depth(&self) -> u32 {
        self.levels.len() as u32 - 1
    }

    /// Is nothing but subdivision left to come within `code` of `level`: no details, and no rules
    /// that need the surface's own levels?
    pub fn is_settled(&self, level: u32, code: FaceCode) -> bool {
        // Ancestors of unsettled faces are unsettled.
        let kept = self.levels.get(level as usize);
        kept.is_none_or(|kept| kept.unsettled.binary_search(&code).is_err())
    }

    /// A root face, as one that is kept.
    pub fn root(&self, face: FaceId) -> Kept {
        Kept { level: 0, face: face.0 }
    }

    /// Is the surface over a root face one polynomial?
    pub fn is_polynomial(&self, face: FaceId) -> bool {
        let root = self.levels.first().and_then(|kept| kept.faces.get(face.index()));
        matches!(root, Some(Face::Regular(_)))
    }

    /// What evaluates a face that is kept; `None` for a root face that does not exist.
    pub fn piece(&self, Kept { level, face }: Kept) -> Option<Piece<'_>> {
        let kept = self.levels.get(level as usize)?;
        Some(match *kept.faces.get(face as usize)? {
            Face::Children(first) => Piece::Children([0, 1, 2, 3].map(|k| Kept { level: level + 1, face: first + k })),
            Face::Regular(net) => Piece::Quartic(kept.quartic(net)),
            Face::Patch => {
                let scheme = Scheme { surface: &self.surface, corners: &self.corners };
                Piece::Patch(Patch::of(scheme, &kept.level.mesh, &kept.level.state, face))
            }
        })
    }

    /// The rings of the corners of a kept face in which nothing but subdivision is left to come, whatever
    /// else evaluates it; `None` of another.
    pub fn patch(&self, Kept { level, face }: Kept) -> Option<Patch<'_>> {
        let kept = self.levels.get(level as usize)?;
        let Level { mesh, state } = &kept.level;
        let is_whole = |v: &u32| mesh.vertices[*v as usize].ring != RingState::Cut;
        let is_settled = kept.unsettled.binary_search(mesh.codes.get(face as usize)?).is_err();
        let scheme = Scheme { surface: &self.surface, corners: &self.corners };
        let whole = is_settled && mesh.corners[face as usize].iter().all(is_whole);
        whole.then(|| Patch::of(scheme, mesh, state, face))
    }

    /// The unit normal at the root vertex that `h` leaves, whatever angle its faces span; zero where there
    /// is none.
    ///
    /// A smooth border vertex of one face has both of the face's derivatives along the border: their
    /// product is no normal.
    pub fn normal_at(&self, h: HalfedgeId) -> DVec3 {
        let scheme = Scheme { surface: &self.surface, corners: &self.corners };
        let (mut face, corner) = (h.face().0, h.corner());
        for kept in &self.levels {
            let Level { mesh, state } = &kept.level;
            match kept.faces.get(face as usize) {
                // The quarter of that number, and there the same corner again.
                Some(Face::Children(first)) => face = first + corner as u32,
                Some(_) => {
                    let frame = limit_frame(scheme, mesh, state, mesh.corners[face as usize][corner]);
                    return frame.map_or(DVec3::ZERO, |frame| frame.normal());
                }
                None => break,
            }
        }
        DVec3::ZERO
    }

    /// The point of a given border at one of its root vertices, to the bit: where two lines meet, that of
    /// the older. `None` anywhere else.
    pub fn on_border(&self, v: VertexId) -> Option<DVec3> {
        let mesh = &self.levels.first()?.level.mesh;
        let vertex = mesh.vertices.get(v.index())?;
        matches!(vertex.kind, Kind::Given(_)).then(|| mesh.sample(v.0))
    }

    /// The finest kept face at a place, and the way there.
    #[inline]
    fn find(&self, at: SurfacePoint) -> Option<(Found<'_>, Descent)> {
        let mut face = at.face.0;
        let mut way = Descent::new(at.st.x, at.st.y);
        for kept in &self.levels {
            match *kept.faces.get(face as usize)? {
                Face::Children(first) => face = first + way.enter() as u32,
                Face::Regular(net) => return Some((Found::Quartic(kept, net), way)),
                Face::Patch => {
                    let scheme = Scheme { surface: &self.surface, corners: &self.corners };
                    let patch = Patch::of(scheme, &kept.level.mesh, &kept.level.state, face);
                    return Some((Found::Patch(patch), way));
                }
            }
        }
        None
    }
}

/// A face of the levels that are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kept {
    level: u32,
    face: u32,
}

/// What evaluates a face that is kept.
#[expect(clippy::large_enum_variant, reason = "made once per face, on the stack")]
#[derive(Clone, Debug)]
pub enum Piece<'a> {
    /// Its quarters.
    Children([Kept; 4]),
    /// One polynomial.
    Quartic(Quartic),
    /// The rings of its corners.
    Patch(Patch<'a>),
}

/// What evaluates a place. It lives for one evaluation on the stack: a box would cost more than the
/// copy.
#[expect(clippy::large_enum_variant, reason = "made and used once, on the stack")]
enum Found<'a> {
    Quartic(&'a KeptLevel, u32),
    Patch(Patch<'a>),
}

impl KeptLevel {
    #[inline(always)]
    fn quartic(&self, net: u32) -> Quartic {
        let mut points = [DVec3::ZERO; 12];
        for (point, &v) in points.iter_mut().zip(&self.nets[net as usize]) {
            *point = self.level.state.effective[v as usize];
        }
        Quartic::new(&points)
    }
}

impl Evaluate for LimitSurface {
    fn face_count(&self) -> usize {
        self.surface.mesh.face_count()
    }

    /// Exact to rounding in the position; on a given border the curve's own point. A face that does
    /// not exist gives NaN.
    ///
    /// Derivatives are exact to rounding as well, but within `2^-16` of a root face from a given border,
    /// where they are interpolated (third derivatives over `2^35`). At an irregular vertex they are
    /// [`Tangents`](selvedge_components::subdivision::Tangents).
    fn jet(&self, at: SurfacePoint) -> Jet {
        match self.find(at) {
            Some((Found::Quartic(kept, net), way)) => way.back(kept.quartic(net).jet(way.weights[1], way.weights[2])),
            Some((Found::Patch(patch), way)) => way.back(patch.jet(way.weights)),
            None => Jet { position: DVec3::NAN, ds: DVec3::NAN, dt: DVec3::NAN },
        }
    }

    fn position(&self, at: SurfacePoint) -> DVec3 {
        match self.find(at) {
            Some((Found::Quartic(kept, net), way)) => kept.quartic(net).position(way.weights[1], way.weights[2]),
            Some((Found::Patch(patch), way)) => patch.position(way.weights),
            None => DVec3::NAN,
        }
    }
}

impl KeptLevel {
    /// The level, of which `reached` are the faces that evaluation may come to.
    fn new(
        level: Level,
        reached: &[FaceCode],
        split: &[FaceCode],
        refined: &[FaceCode],
        unsettled: Vec<FaceCode>,
    ) -> Self {
        let mesh = &level.mesh;
        let local = mesh.find_all(reached);
        let found = map_in_order(local.len(), |i| {
            let code = mesh.codes[local[i] as usize];
            if split.binary_search(&code).is_ok() {
                let family = refined.partition_point(|&r| r < code);
                (Face::Children(4 * family as u32), None)
            } else {
                (Face::Patch, regular_net(mesh, local[i]))
            }
        });
        let mut faces = vec![Face::Patch; mesh.corners.len()];
        let mut nets = Vec::new();
        for (&face, (kind, net)) in local.iter().zip(found) {
            faces[face as usize] = if net.is_some() { Face::Regular(nets.len() as u32) } else { kind };
            nets.extend(net);
        }
        Self { level, faces, nets, unsettled }
    }
}

/// The control points of `face`, in the order of a
/// [`Net`](selvedge_components::subdivision::boxspline::Net), where its corners are interior, of
/// valence 6 and away from special corners: it is one polynomial then.
pub fn regular_net(mesh: &LevelMesh, face: u32) -> Option<[u32; 12]> {
    let corners = mesh.corners[face as usize];
    let is_regular = |&v: &u32| {
        let vertex = mesh.vertices[v as usize];
        vertex.valence == 6 && vertex.kind == Kind::Interior && vertex.ring != RingState::Cut
    };
    if !corners.iter().all(is_regular) {
        return None;
    }
    let mut net = [0; 12];
    for c in 0..3 {
        // Clockwise around the corner, from the edge of the face.
        let mut spoke = 3 * face + c as u32;
        let mut turn = || {
            spoke = next(mesh.twin(spoke)?);
            Some(mesh.to(spoke))
        };
        (net[c], net[3 + c]) = (corners[c], turn()?);
        (net[7 + 2 * c], net[6 + 2 * c]) = (turn()?, turn()?);
    }
    net.iter().all(|&v| mesh.vertices[v as usize].corner == NONE).then_some(net)
}
