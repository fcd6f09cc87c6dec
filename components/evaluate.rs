//! What every surface can be asked: a point of it and its first derivatives.

use glam::{DVec2, DVec3};

use crate::mesh::FaceId;

/// A place on a surface of triangles: a face and barycentric coordinates in it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct SurfacePoint {
    /// The face of the root mesh.
    pub face: FaceId,
    /// `(s, t)`: the weights of the corners are `(1 - s - t, s, t)`, all in [0, 1].
    pub st: DVec2,
}

impl SurfacePoint {
    /// The point of `face` where the corners weigh `(1 - s - t, s, t)`.
    pub const fn new(face: FaceId, s: f64, t: f64) -> Self {
        Self { face, st: DVec2::new(s, t) }
    }
}

/// Position and first derivatives of a surface at one place.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Jet {
    /// The point, in model units.
    pub position: DVec3,
    /// Derivative by `s`, in model units per face.
    pub ds: DVec3,
    /// Derivative by `t`, in model units per face.
    pub dt: DVec3,
}

impl Jet {
    /// The unit normal, outward for counter-clockwise faces; zero where the derivatives are
    /// parallel or vanish.
    pub fn normal(&self) -> DVec3 {
        self.ds.cross(self.dt).normalize_or_zero()
    }
}

/// A surface that can be evaluated anywhere: `face_count` triangles, each with its own (s, t).
pub trait Evaluate: Send + Sync {
    /// How many root faces there are.
    fn face_count(&self) -> usize;

    /// Position and first derivatives at `at`. A place outside its face is clamped to it.
    fn jet(&self, at: SurfacePoint) -> Jet;

    /// The position at `at`.
    fn position(&self, at: SurfacePoint) -> DVec3 {
        self.jet(at).position
    }
}
