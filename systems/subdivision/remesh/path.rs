//! Paths on a mesh: straight pieces within root faces, and the faces of any level that they cross.

use glam::DVec2;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId};
use selvedge_components::subdivision::FaceCode;

/// A straight piece of a path within one root face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// The root face.
    pub face: FaceId,
    /// Where it begins, as [`SurfacePoint::st`].
    pub from: DVec2,
    /// Where it ends.
    pub to: DVec2,
    /// Which part of the way between two path points it is, in [0, 1].
    pub part: [f64; 2],
}

/// How well two path points were joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// Straight, in one face or through the edge between two.
    Straight,
    /// By way of a vertex, because the straight line leaves the two faces.
    Bent,
}

/// The way from `a` to `b`, which passes the vertices on it at `clearance` (a part of the edge);
/// `None` if their faces do not meet.
pub fn connect(mesh: &Connectivity, a: SurfacePoint, b: SurfacePoint, clearance: f64) -> Option<(Vec<Leg>, Join)> {
    if a.face == b.face {
        return Some((vec![Leg { face: a.face, from: a.st, to: b.st, part: [0.0, 1.0] }], Join::Straight));
    }
    let mut bent = None;
    for i in 0..3 {
        let h = HalfedgeId::of(a.face, i);
        let Some(twin) = mesh.twin(h).filter(|t| t.face() == b.face) else { continue };
        let (legs, join) = through_edge(a, b, [i, twin.corner()], clearance);
        if join == Join::Straight {
            return Some((legs, join));
        }
        bent = bent.or(Some((legs, join)));
    }
    bent.or_else(|| around_vertex(mesh, a, b, clearance))
}

/// Weights of the three corners.
pub fn weights(st: DVec2) -> [f64; 3] {
    [1.0 - st.x - st.y, st.x, st.y]
}

/// The point that weighs corner `i + 1` with `w` and corner `i` with the rest.
fn on_edge(i: usize, w: f64) -> DVec2 {
    corner(i) * (1.0 - w) + corner((i + 1) % 3) * w
}

/// Corner `i` as (s, t).
pub fn corner(i: usize) -> DVec2 {
    [DVec2::ZERO, DVec2::X, DVec2::Y][i]
}

/// Through half-edge `i` of the face of `a`, whose twin leaves corner `k` of the face of `b`: the
/// two faces are unfolded into a parallelogram, where the way is straight.
fn through_edge(a: SurfacePoint, b: SurfacePoint, [i, k]: [usize; 2], clearance: f64) -> (Vec<Leg>, Join) {
    let (wa, wb) = (weights(a.st), weights(b.st));
    let unfolded = corner((i + 1) % 3) * wb[k]
        + corner(i) * wb[(k + 1) % 3]
        + (corner(i) + corner((i + 1) % 3) - corner((i + 2) % 3)) * wb[(k + 2) % 3];
    let (off_a, off_b) = (wa[(i + 2) % 3].max(0.0), wb[(k + 2) % 3].max(0.0));
    let part = if off_a + off_b > 0.0 { off_a / (off_a + off_b) } else { 0.5 };
    let cross = a.st.lerp(unfolded, part);
    let along = weights(cross)[(i + 1) % 3];
    let inside = along.clamp(clearance, 1.0 - clearance);
    let legs = vec![
        Leg { face: a.face, from: a.st, to: on_edge(i, inside), part: [0.0, part] },
        Leg { face: b.face, from: on_edge(k, 1.0 - inside), to: b.st, part: [part, 1.0] },
    ];
    // Rounding may put the crossing a few units beyond the end of the edge.
    let slack = clearance + 16.0 * f64::EPSILON;
    (legs, if (along - inside).abs() <= slack { Join::Straight } else { Join::Bent })
}

/// Through the faces between those of `a` and `b` around a vertex that both have, the shorter way.
fn around_vertex(mesh: &Connectivity, a: SurfacePoint, b: SurfacePoint, clearance: f64) -> Option<(Vec<Leg>, Join)> {
    let (fa, fb) = (mesh.face(a.face), mesh.face(b.face));
    let v = *fa.iter().find(|v| fb.contains(v))?;
    let ring: Vec<HalfedgeId> = mesh.ring(v).collect();
    let of = |face: FaceId| ring.iter().position(|h| h.face() == face);
    let (from, to, n) = (of(a.face)?, of(b.face)?, ring.len());
    let forth = (to + n - from) % n;
    let (steps, forward) = match mesh.is_border(v) {
        true => (from.abs_diff(to), to > from),
        false => (forth.min(n - forth), forth <= n - forth),
    };
    // Where the way leaves the face of `h`, and enters it: near the vertex on the two edges there.
    let near = |h: HalfedgeId, next: usize| corner(h.corner()).lerp(corner((h.corner() + next) % 3), clearance);
    let (leave, enter) = if forward { (2, 1) } else { (1, 2) };
    let (off_a, off_b) = (a.st.distance(corner(ring[from].corner())), b.st.distance(corner(ring[to].corner())));
    let part = if off_a + off_b > 0.0 { off_a / (off_a + off_b) } else { 0.5 };
    let legs = (0..=steps).map(|k| {
        let h = ring[if forward { from + k } else { from + n - k } % n];
        Leg {
            face: h.face(),
            from: if k == 0 { a.st } else { near(h, enter) },
            to: if k == steps { b.st } else { near(h, leave) },
            part: [if k == 0 { 0.0 } else { part }, if k == steps { 1.0 } else { part }],
        }
    });
    Some((legs.collect(), Join::Bent))
}

/// The face of `level` that holds the point `st` of root face `face`.
pub fn locate(face: FaceId, st: DVec2, level: u32) -> FaceCode {
    let (mut code, mut p) = (FaceCode::root(face), st);
    for _ in 0..level {
        let child = if p.x + p.y < 0.5 {
            0
        } else if p.x > 0.5 {
            1
        } else if p.y > 0.5 {
            2
        } else {
            3
        };
        p = match child {
            0 => 2.0 * p,
            1 => DVec2::new(2.0 * p.x - 1.0, 2.0 * p.y),
            2 => DVec2::new(2.0 * p.x, 2.0 * p.y - 1.0),
            // The middle child has the corners (1/2, 0), (1/2, 1/2) and (0, 1/2).
            _ => DVec2::new(2.0 * (p.x + p.y) - 1.0, 1.0 - 2.0 * p.x),
        };
        code = code.child(child);
    }
    code
}

/// The faces of `level` that `leg` crosses, in order, each with the part of the leg inside it.
///
/// The edges of a level lie on the lines where `s`, `t` or `s + t` is a multiple of `2^-level`, so
/// the leg is cut at those lines and each piece belongs to the face that holds its middle.
pub fn crossed(leg: &Leg, level: u32) -> Vec<(FaceCode, [f64; 2])> {
    let n = (1_u64 << level) as f64;
    let mut cuts = vec![0.0, 1.0];
    for (a, b) in [(leg.from.x, leg.to.x), (leg.from.y, leg.to.y), (leg.from.x + leg.from.y, leg.to.x + leg.to.y)] {
        let (a, b) = (a * n, b * n);
        let (low, high) = (a.min(b).ceil(), a.max(b).floor());
        let mut line = low;
        while line <= high && b != a {
            cuts.push(((line - a) / (b - a)).clamp(0.0, 1.0));
            line += 1.0;
        }
    }
    cuts.sort_unstable_by(f64::total_cmp);
    cuts.dedup();
    let mut faces: Vec<(FaceCode, [f64; 2])> = Vec::with_capacity(cuts.len());
    for pair in cuts.windows(2) {
        let middle = leg.from.lerp(leg.to, 0.5 * (pair[0] + pair[1]));
        let code = locate(leg.face, middle, level);
        match faces.last_mut() {
            Some(last) if last.0 == code => last.1[1] = pair[1],
            _ => faces.push((code, [pair[0], pair[1]])),
        }
    }
    faces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_located_face_holds_the_point() {
        for level in 0..6 {
            for k in 0..500 {
                let (a, b) = (f64::from(k) * 0.618 % 1.0, f64::from(k) * 0.414 % 1.0);
                let st = if a + b > 1.0 { DVec2::new(1.0 - a, 1.0 - b) } else { DVec2::new(a, b) };
                let corners = locate(FaceId(3), st, level).corners(level);
                let n = f64::from(1_u32 << level);
                let [p, q, r] = corners.map(|(i, j)| DVec2::new(f64::from(i), f64::from(j)) / n);
                let area = (q - p).perp_dot(r - p);
                for (x, y) in [(p, q), (q, r), (r, p)] {
                    assert!((y - x).perp_dot(st - x) / area > -1e-12, "level {level} {st}");
                }
            }
        }
    }

    #[test]
    fn the_faces_crossed_follow_each_other_through_edges_or_vertices() {
        let leg = Leg { face: FaceId(0), from: DVec2::new(0.03, 0.11), to: DVec2::new(0.71, 0.22), part: [0.0, 1.0] };
        for level in 0..7 {
            let faces = crossed(&leg, level);
            assert_eq!(faces[0].1[0], 0.0);
            assert_eq!(faces[faces.len() - 1].1[1], 1.0);
            for pair in faces.windows(2) {
                assert_eq!(pair[0].1[1], pair[1].1[0]);
                let (a, b) = (pair[0].0.corners(level), pair[1].0.corners(level));
                assert!(a.iter().filter(|p| b.contains(p)).count() >= 1);
            }
        }
    }

    #[test]
    fn a_way_through_an_edge_is_straight_in_the_unfolded_faces() {
        let mesh = Connectivity::new(4, &[[0, 1, 2], [2, 1, 3]]).expect("two faces");
        // Face 1 is (2, 1, 3): the parallelogram's far corner is its corner 2.
        let (a, b) = (SurfacePoint::new(FaceId(0), 0.2, 0.3), SurfacePoint::new(FaceId(1), 0.5, 0.3));
        let (legs, join) = connect(&mesh, a, b, 0.0).expect("they meet");
        assert_eq!(join, Join::Straight);
        let plane = |p: &Leg, st: DVec2| {
            let corners =
                if p.face == FaceId(0) { [DVec2::ZERO, DVec2::X, DVec2::Y] } else { [DVec2::Y, DVec2::X, DVec2::ONE] };
            let w = weights(st);
            corners[0] * w[0] + corners[1] * w[1] + corners[2] * w[2]
        };
        let (x, y) = (plane(&legs[0], legs[0].to), plane(&legs[1], legs[1].from));
        assert!(x.distance(y) < 1e-15);
        let (start, end) = (plane(&legs[0], legs[0].from), plane(&legs[1], legs[1].to));
        assert!((x - start).perp_dot(end - start).abs() < 1e-15);
    }
}
