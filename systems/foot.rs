//! The foot of a point on a surface, from a place nearby.

use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::{Connectivity, HalfedgeId};

use glam::DVec3;

/// Other places on a triangle, as the weights of its corners, from which to look for a foot: its
/// corners, the middles of its edges, its centre.
pub const AROUND: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.5, 0.5, 0.0],
    [0.0, 0.5, 0.5],
    [0.5, 0.0, 0.5],
    [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
];

/// The distance of `y` to the surface, from above: the least that is met from any of `starts`, in
/// turn, before it is `enough`. `mesh` says how the faces of the surface hang together.
pub fn distance(
    surface: &dyn Evaluate,
    mesh: &Connectivity,
    starts: impl IntoIterator<Item = SurfacePoint>,
    y: DVec3,
    enough: f64,
) -> f64 {
    let mut least = f64::INFINITY;
    for start in starts {
        let found = distance_from(surface, mesh, start, y, enough);
        least = if found.is_nan() { found } else { least.min(found) };
        if least.is_nan() || least <= enough {
            break;
        }
    }
    least
}

/// A step that promises less than this part of the square of the distance is not taken: the distance is
/// from above, and by less than the fourth part of a millionth.
const WORTH: f64 = 0.5e-6;

/// The least distance that Gauss-Newton steps from `start` meet before it is `enough`.
///
/// From a start as close as a triangle that stands for the surface, each step squares the relative
/// error. A dozen in all is far more than that takes, walks over edges included.
fn distance_from(surface: &dyn Evaluate, mesh: &Connectivity, start: SurfacePoint, y: DVec3, enough: f64) -> f64 {
    let mut at = start;
    let mut least = f64::INFINITY;
    let mut misses = 0;
    for _ in 0..12 {
        let jet = surface.jet(at);
        let off = jet.position - y;
        let distance = off.length();
        if distance.is_nan() || distance <= enough {
            return distance;
        }
        // Over an edge the first step is none: the same point on another face.
        misses = if distance < least { 0 } else { misses + 1 };
        if misses > 1 {
            break;
        }
        least = least.min(distance);
        let (ss, st, tt) = (jet.ds.dot(jet.ds), jet.ds.dot(jet.dt), jet.dt.dot(jet.dt));
        let (s, t) = (jet.ds.dot(off), jet.dt.dot(off));
        let determinant = ss * tt - st * st;
        if determinant <= 0.0 {
            break;
        }
        let (ds, dt) = ((st * t - tt * s) / determinant, (st * s - ss * t) / determinant);
        // What the step promises to take off the square of the distance.
        if -(s * ds + t * dt) <= WORTH * distance * distance {
            break;
        }
        at = step(mesh, at, ds, dt);
    }
    least
}

/// The place reached by a step: where it leaves its face, on the neighbour across; at a border, at the
/// border.
fn step(mesh: &Connectivity, at: SurfacePoint, ds: f64, dt: f64) -> SurfacePoint {
    let (s, t) = (at.st.x + ds, at.st.y + dt);
    let weights = [1.0 - s - t, s, t];
    let out = (0..3).filter(|&c| weights[c] < 0.0).min_by(|&a, &b| weights[a].total_cmp(&weights[b]));
    let Some(out) = out else { return SurfacePoint::new(at.face, s, t) };
    let kept = weights.map(|w| w.max(0.0));
    let sum = kept[0] + kept[1] + kept[2];
    let kept = kept.map(|w| w / sum);
    let leaving = HalfedgeId::of(at.face, (out + 1) % 3);
    match mesh.twin(leaving) {
        Some(twin) => {
            let mut across = [0.0; 3];
            across[(twin.corner() + 1) % 3] = kept[leaving.corner()];
            across[twin.corner()] = kept[leaving.next().corner()];
            SurfacePoint::new(twin.face(), across[1], across[2])
        }
        None => SurfacePoint::new(at.face, kept[1], kept[2]),
    }
}
