//! A contoured disc, like the cover of a wheel, whose rim is a circle to the bit.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{Circle, CurveParameters, Heading};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::{Border, CornerRule, Details, Ends, LoopSurface, Side};

use super::TrimSceneError;
use super::shapes::direction;

/// Radius of the rim, in metres.
pub const RADIUS: f64 = 0.2;

/// Rings of vertices around the middle one, the rim not counted.
const RINGS: u32 = 5;

/// The disc: a triangle lattice of five rings about the middle, of 6, 12 to 30 vertices, and the rim, of
/// 30. Rim vertices have four edges; the last ring has six vertices of five, all others have six. 210
/// triangles.
///
/// # Errors
/// None, as long as the disc is what it should be.
pub fn surface() -> Result<LoopSurface, TrimSceneError> {
    let rim = Circle::from_axes(DVec3::ZERO, DVec3::X, DVec3::Y, RADIUS)?;
    let even = CurveParameters::even(Arc::new(rim), count(RINGS))?;
    let mut points: Vec<DVec3> = (0..=RINGS).flat_map(ring).map(|p| p.extend(height(p))).collect();
    let first = points.len() as u32;
    points.extend(even.samples(0));
    let mesh = Connectivity::new(points.len(), &faces(first)).map_err(TrimSceneError::Mesh)?;
    let vertices = (first..points.len() as u32).map(VertexId).collect();
    let border = Border::Given { curve: Arc::new(even), first: 0, heading: Heading::Along };
    let sides = vec![Side { vertices, ends: Ends::Closed, border }];
    Ok(LoopSurface {
        mesh: Arc::new(mesh),
        points,
        sides,
        corner_rule: CornerRule::Lattice,
        details: Details::default(),
    })
}

/// The height of the control points over a place of the plane, in metres: a cap, a groove about it, a
/// raised ring with five soft lobes, and a fall to the rim.
fn height(p: DVec2) -> f64 {
    let r = p.length() / RADIUS;
    let bump = |middle: f64, width: f64| (-((r - middle) / width).powi(2)).exp();
    // cos(5 angle) by the fifth power of the direction, which needs no angle.
    let unit = p.normalize_or_zero();
    let square = unit.rotate(unit);
    let lobes = square.rotate(square).rotate(unit).x;
    let fall = (1.0 - r * r).max(0.0);
    0.001 * (13.0 * bump(0.0, 0.36) + (14.0 + 2.5 * lobes) * bump(0.70, 0.24) + 4.0 * fall)
}

/// How many vertices ring `k` has.
const fn count(k: u32) -> u32 {
    if k == 0 { 1 } else { 6 * k }
}

/// The index of the first vertex of ring `k`.
const fn first(k: u32) -> u32 {
    if k == 0 { 0 } else { 1 + 3 * k * (k - 1) }
}

/// The vertices of ring `k`, in the plane.
fn ring(k: u32) -> impl Iterator<Item = DVec2> {
    let n = count(k);
    let radius = RADIUS * f64::from(k) / f64::from(RINGS + 1);
    // The rim's vertices stand between those of the last ring.
    let turn = -0.5 / f64::from(count(RINGS));
    (0..n).map(move |i| radius * direction(turn + f64::from(i) / f64::from(n)))
}

fn faces(rim: u32) -> Vec<[u32; 3]> {
    let mut faces = Vec::new();
    for k in 1..=RINGS {
        let (inner, outer) = (count(k - 1), count(k));
        let a = |i: u32| first(k - 1) + i % inner;
        let b = |i: u32| first(k) + i % outer;
        for sector in 0..6 {
            for i in 0..k {
                faces.push([a(sector * (k - 1) + i), b(sector * k + i), b(sector * k + i + 1)]);
                if i + 1 < k {
                    faces.push([a(sector * (k - 1) + i), b(sector * k + i + 1), a(sector * (k - 1) + i + 1)]);
                }
            }
        }
    }
    let n = count(RINGS);
    for i in 0..n {
        let (a, b) = (first(RINGS) + i, first(RINGS) + (i + 1) % n);
        let (c, d) = (rim + i, rim + (i + 1) % n);
        faces.extend([[a, c, b], [c, d, b]]);
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_disc_is_as_regular_as_a_disc_can_be() {
        let disc = surface().expect("a disc");
        let mesh = &disc.mesh;
        assert_eq!((mesh.face_count(), mesh.euler(), mesh.border_loops().len()), (210, 1, 1));
        let (mut fives, mut sixes) = (0, 0);
        for v in (0..mesh.vertex_count()).map(VertexId::new) {
            match (mesh.is_border(v), mesh.valence(v)) {
                (true, k) => assert_eq!(k, 4, "{v} on the rim"),
                (false, 5) => fives += 1,
                (false, 6) => sixes += 1,
                (false, k) => panic!("{v} has valence {k}"),
            }
        }
        assert_eq!((fives, sixes), (6, 85));
    }

    #[test]
    fn triangles_are_well_shaped_and_face_up() {
        let disc = surface().expect("a disc");
        for face in disc.mesh.faces() {
            let [a, b, c] = face.map(|v| disc.points[v.index()]);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let normal = (b - a).cross(c - a);
            assert!(normal.z > 0.5 * longest * longest, "{face:?}: {normal} over {longest}");
        }
    }
}
