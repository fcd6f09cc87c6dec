//! Where pre-images cross: themselves, or each other.

use glam::DVec2;
use selvedge_components::mesh::FaceId;

use super::error::PreImageError;
use super::path::Leg;
use super::track::{Near, Track};

/// Finds the first place, in the order of faces and segments, at which the track meets itself.
///
/// # Errors
/// [`PreImageError::Crossing`].
pub fn check(track: &Track) -> Result<(), PreImageError> {
    let mut legs: Vec<(FaceId, u32, Leg)> = Vec::new();
    for (segment, point) in track.points.iter().enumerate() {
        legs.extend(point.legs.iter().filter(|l| l.from != l.to).map(|&l| (l.face, segment as u32, l)));
    }
    legs.sort_by_key(|l| (l.0, l.1));
    for face in legs.chunk_by(|a, b| a.0 == b.0) {
        // By the left end, so that only legs whose spans meet are compared.
        let mut order: Vec<usize> = (0..face.len()).collect();
        order.sort_by(|&a, &b| span(&face[a].2).0.total_cmp(&span(&face[b].2).0).then(a.cmp(&b)));
        for (k, &a) in order.iter().enumerate() {
            let end = span(&face[a].2).1;
            for &b in order[k + 1..].iter().take_while(|&&b| span(&face[b].2).0 <= end) {
                if are_neighbours(track, face[a].1, face[b].1) {
                    continue;
                }
                if let Some((f, g)) = meet(&face[a].2, &face[b].2) {
                    return Err(crossing(track, (face[a].1, f), (face[b].1, g)));
                }
            }
        }
    }
    Ok(())
}

fn span(leg: &Leg) -> (f64, f64) {
    (leg.from.x.min(leg.to.x), leg.from.x.max(leg.to.x))
}

/// Neighbouring segments share a point, and one segment may have two legs.
fn are_neighbours(track: &Track, a: u32, b: u32) -> bool {
    a == b || track.points[a as usize].next == b || track.points[b as usize].next == a
}

/// The parts of two legs at which they meet.
fn meet(a: &Leg, b: &Leg) -> Option<(f64, f64)> {
    let side = |p: DVec2, q: DVec2, x: DVec2| (q - p).perp_dot(x - p);
    let (a1, a2) = (side(b.from, b.to, a.from), side(b.from, b.to, a.to));
    let (b1, b2) = (side(a.from, a.to, b.from), side(a.from, a.to, b.to));
    // Legs on one line have no single place in common; if they overlap, their neighbours meet them.
    if a1 * a2 > 0.0 || b1 * b2 > 0.0 || (a1 == a2) || (b1 == b2) {
        return None;
    }
    let part = |leg: &Leg, f: f64| leg.part[0] + (leg.part[1] - leg.part[0]) * f;
    Some((part(a, a1 / (a1 - a2)), part(b, b1 / (b1 - b2))))
}

fn crossing(track: &Track, a: (u32, f64), b: (u32, f64)) -> PreImageError {
    let near = |(segment, part): (u32, f64)| Near { segment, part, distance: 0.0 };
    let cut = |s: u32| track.points[s as usize].cut as usize;
    let u = |p| {
        let t = track.parameter(near(p)).abs();
        if t > 1.0 { t - 1.0 } else { t }
    };
    PreImageError::Crossing { curves: [cut(a.0), cut(b.0)], u: [u(a), u(b)], at: track.position(near(a)) }
}
