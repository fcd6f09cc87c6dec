//! Steps over a surface, from face to face.

use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId};
use selvedge_components::subdivision::{FaceCode, PlainLoop};

use crate::subdivision::limit::LimitSurface;

/// A surface on which a search can walk from one face into the next.
pub trait Walk: Evaluate {
    /// The face across the edge from `corner` to the next one, and the corner that the edge leaves
    /// there, which is the same vertex as the one the edge reaches here. `None` on a border.
    fn across(&self, face: FaceId, corner: usize) -> Option<(FaceId, usize)>;

    /// Has the surface no features smaller than `code` of `level` within it, so that some samples
    /// tell its shape? Irregular vertices and borders at its rim are none.
    fn is_settled(&self, _level: u32, _code: FaceCode) -> bool {
        true
    }
}

fn twin(mesh: &Connectivity, face: FaceId, corner: usize) -> Option<(FaceId, usize)> {
    mesh.twin(HalfedgeId::of(face, corner)).map(|h| (h.face(), h.corner()))
}

impl Walk for LimitSurface {
    fn across(&self, face: FaceId, corner: usize) -> Option<(FaceId, usize)> {
        twin(&self.surface().mesh, face, corner)
    }

    fn is_settled(&self, level: u32, code: FaceCode) -> bool {
        Self::is_settled(self, level, code)
    }
}

impl Walk for PlainLoop {
    fn across(&self, face: FaceId, corner: usize) -> Option<(FaceId, usize)> {
        twin(self.topology().mesh(), face, corner)
    }
}

/// A place as a face and the weights of its corners, which sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spot {
    pub face: FaceId,
    pub weights: [f64; 3],
}

/// How many edges one step may cross. A step across more has left the part of the surface that its
/// derivatives know of; it ends where it is, and the next one begins there.
const MOST_CROSSINGS: usize = 32;

impl Spot {
    pub fn new(at: SurfacePoint) -> Self {
        let inside = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
        let (s, t) = (inside(at.st.x), inside(at.st.y));
        let sum = s + t;
        // The sum may round to 1 where the difference is below 0, and a weight below 0 would keep every step from
        // leaving.
        let weights = if sum > 1.0 { [0.0, s / sum, t / sum] } else { [(1.0 - s - t).max(0.0), s, t] };
        Self { face: at.face, weights }
    }

    pub fn point(&self) -> SurfacePoint {
        SurfacePoint::new(self.face, self.weights[1], self.weights[2])
    }

    /// The corner that the place is.
    pub fn corner(&self) -> Option<usize> {
        (0..3).find(|&c| self.weights[(c + 1) % 3] == 0.0 && self.weights[(c + 2) % 3] == 0.0)
    }

    /// The edge, named by the corner it leaves, that the place lies on; the first where it is a
    /// corner.
    pub fn edges(&self) -> impl Iterator<Item = usize> + '_ {
        (0..3).filter(|c| self.weights[(c + 2) % 3] == 0.0)
    }

    /// The place that differs by `(ds, dt)`, on a straight line over the faces as if they lay flat:
    /// two faces that share an edge make a parallelogram, which is how their coordinates run on into
    /// each other smoothly where the surface is regular.
    pub fn moved(self, surface: &(impl Walk + ?Sized), (ds, dt): (f64, f64)) -> Self {
        let mut from = self;
        let [a, b, c] = self.weights;
        let mut to = [a - ds - dt, b + ds, c + dt];
        for _ in 0..MOST_CROSSINGS {
            let Some((corner, share)) = first_exit(from.weights, to) else {
                let sum: f64 = to.iter().sum();
                return Self { face: from.face, weights: to.map(|w| w / sum) };
            };
            // The edge opposite to the corner whose weight runs out.
            let (e, f) = ((corner + 1) % 3, (corner + 2) % 3);
            let mix = |i: usize| (from.weights[i] + share * (to[i] - from.weights[i])).clamp(0.0, 1.0);
            let (x, y) = (mix(e), mix(f));
            let mut rim = [0.0; 3];
            (rim[e], rim[f]) = (x / (x + y), y / (x + y));
            if !(rim[e].is_finite() && rim[f].is_finite()) {
                return from;
            }
            let Some((face, twin)) = surface.across(from.face, e) else {
                return Self { face: from.face, weights: rim };
            };
            let (end, over) = ((twin + 1) % 3, (twin + 2) % 3);
            let mut weights = [0.0; 3];
            (weights[twin], weights[end]) = (rim[f], rim[e]);
            let beyond = to[corner];
            let mut ahead = [0.0; 3];
            (ahead[twin], ahead[end], ahead[over]) = (to[f] + beyond, to[e] + beyond, -beyond);
            (from, to) = (Self { face, weights }, ahead);
        }
        from
    }

    /// The place moved by `by` along the edge from `corner` to the next one, not past its ends.
    pub fn along_edge(self, corner: usize, by: f64) -> Self {
        let (e, f) = (corner, (corner + 1) % 3);
        let at = (self.weights[f] + by).clamp(0.0, 1.0);
        let mut weights = [0.0; 3];
        (weights[e], weights[f]) = (1.0 - at, at);
        Self { face: self.face, weights }
    }
}

/// The corner whose weight first falls below zero on the way, and after which share of it.
fn first_exit(from: [f64; 3], to: [f64; 3]) -> Option<(usize, f64)> {
    let exits = (0..3).filter(|&c| to[c] < 0.0).map(|c| (c, from[c] / (from[c] - to[c])));
    exits.fold(None, |first: Option<(usize, f64)>, exit| match first {
        Some(f) if f.1 <= exit.1 => Some(f),
        _ => Some(exit),
    })
}

/// The faces around a corner of a face, each with its corner there: counter-clockwise from the face,
/// then, if a border was met, clockwise.
pub(super) fn faces_around(surface: &(impl Walk + ?Sized), face: FaceId, corner: usize) -> Vec<(FaceId, usize)> {
    // No vertex of a sound mesh has more faces than this; a table that contradicts itself ends too.
    const MOST: usize = 1 << 16;
    let mut fan = vec![(face, corner)];
    let mut at = (face, corner);
    while let Some(next) = surface.across(at.0, (at.1 + 2) % 3) {
        if next == (face, corner) || fan.len() >= MOST {
            return fan;
        }
        fan.push(next);
        at = next;
    }
    at = (face, corner);
    while let Some((next, twin)) = surface.across(at.0, at.1) {
        at = (next, (twin + 1) % 3);
        if at == (face, corner) || fan.len() >= MOST {
            return fan;
        }
        fan.push(at);
    }
    fan
}
