//! Distances, both ways, at random places.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId};
use selvedge_components::trim::TrimAudit;

use super::{Measuring, farther};
use crate::closest::SurfaceIndex;
use crate::foot;
use crate::subdivision::limit::{LimitSurface, Nest};
use crate::subdivision::remesh::FaceOrigin;

/// Steps that end within this part of what is taken for near have most likely found the foot.
const LIKELY: f64 = 0.5;

impl Measuring {
    /// Samples one face of the result, and the piece of the source that it stands for. What is no farther
    /// than the farthest so far is not measured to the end.
    pub(super) fn measure(&self, face: FaceId) -> TrimAudit {
        let mut draw = Draw::new(self.seed, face.0);
        let mut found = TrimAudit { samples: 0, ..self.found };
        let origin = self.remeshed.face_origin[face.index()];
        let mut result = Nest::new(&self.limit, face);
        let mut source = match origin {
            FaceOrigin::Leaf { level, code } => {
                Some((level, code, Nest::new(self.ground.limit(), code.root_face(level))))
            }
            _ => None,
        };
        for _ in 0..self.samples {
            let weights = draw.weights();
            let x = result.position(result.root(), weights);
            // The place with the same weights is no nearer than the foot, either way.
            let y = source.as_mut().map(|(level, code, source)| position(source, code.place(*level, weights)));
            let apart = y.map_or(f64::INFINITY, |y| x.distance(y));
            let mut off = apart;
            if !is_within(off, found.to_source) {
                off = self.to_source(self.start(face, origin, weights), x, found.to_source);
            }
            farther(&mut found, &TrimAudit { to_source: off, to_source_at: x, samples: 1, ..TrimAudit::default() });
            if let Some(y) = y {
                let mut off = apart;
                if !is_within(off, found.to_result) {
                    off = self.to_result(SurfacePoint::new(face, weights[1], weights[2]), y, found.to_result);
                }
                farther(&mut found, &TrimAudit { to_result: off, to_result_at: y, samples: 1, ..TrimAudit::default() });
            }
        }
        found
    }

    /// A place of the source near the foot of the place of the result where the corners of `face` weigh
    /// `weights`: the same of the piece that it stands for, or between the places that its corners stand
    /// for, or that of the nearest corner.
    fn start(&self, face: FaceId, origin: FaceOrigin, weights: [f64; 3]) -> SurfacePoint {
        if let FaceOrigin::Leaf { level, code } = origin {
            return code.place(level, weights);
        }
        let natural = self.surface.mesh.face(face).map(|v| self.remeshed.natural[v.index()]);
        if natural.iter().all(|at| at.face == natural[0].face) {
            let st = (0..3).fold(DVec2::ZERO, |sum, c| sum + natural[c].st * weights[c]);
            return SurfacePoint::new(natural[0].face, st.x, st.y);
        }
        let heaviest = (1..3).fold(0, |best, c| if weights[c] > weights[best] { c } else { best });
        natural[heaviest]
    }

    /// The distance of a point of the result to the source, from above, or something within `enough`: by
    /// steps from `start`, or if those lead to no near foot, from all over its face, or by a search
    /// everywhere.
    fn to_source(&self, start: SurfacePoint, x: DVec3, enough: f64) -> f64 {
        let (source, mesh) = (&**self.ground.limit(), &self.ground.surface.mesh);
        let off = self.steps(source, mesh, start, x, enough);
        if off <= self.near.max(enough) {
            return off;
        }
        self.ground.index.closest(x).map_or(off, |found| off.min(found.distance))
    }

    /// The distance of a point of the source to the result, likewise.
    fn to_result(&self, start: SurfacePoint, y: DVec3, enough: f64) -> f64 {
        let off = self.steps(&self.limit, &self.surface.mesh, start, y, enough);
        if off <= self.near.max(enough) {
            return off;
        }
        let index = self.searched.get_or_init(|| SurfaceIndex::new(Arc::clone(&self.limit)).ok());
        let found = index.as_ref().and_then(|index| index.closest(y).ok());
        found.map_or(off, |found| off.min(found.distance))
    }

    fn steps(&self, surface: &LimitSurface, mesh: &Connectivity, start: SurfacePoint, x: DVec3, enough: f64) -> f64 {
        let off = foot::distance(surface, mesh, [start], x, enough);
        if off <= enough.max(LIKELY * self.near) {
            return off;
        }
        let around = foot::AROUND.map(|w| SurfacePoint::new(start.face, w[1], w[2]));
        off.min(foot::distance(surface, mesh, around, x, enough))
    }
}

/// Is a distance within another? One that is no number is not within any.
fn is_within(distance: f64, other: f64) -> bool {
    distance <= other
}

/// The limit position at a place of the root face of `nest`.
fn position(nest: &mut Nest<'_>, SurfacePoint { st, .. }: SurfacePoint) -> DVec3 {
    nest.position(nest.root(), [(1.0 - st.x - st.y).max(0.0), st.x, st.y])
}

/// Random places, the same for the same seed and face.
struct Draw(u64);

impl Draw {
    fn new(seed: u64, face: u32) -> Self {
        Self(seed ^ u64::from(face).wrapping_mul(0x9e37_79b9_7f4a_7c15))
    }

    /// Between 0 and 1, by splitmix64 (Steele et al. 2014).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Weights of the corners of a triangle, evenly spread over it.
    fn weights(&mut self) -> [f64; 3] {
        let (mut s, mut t) = (self.unit(), self.unit());
        if s + t > 1.0 {
            (s, t) = (1.0 - s, 1.0 - t);
        }
        [1.0 - s - t, s, t]
    }
}
