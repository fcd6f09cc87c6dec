//! Where pre-images cross: themselves, which is refused, or each other.

use glam::DVec2;
use selvedge_components::subdivision::remesh::PreImageError;

use super::super::relax::curve_parameter;
use super::Cut;
use super::path::Leg;
use super::track::{Near, Track};
use super::winding::{Way, Ways, is_left};

/// A place where the tracks of two curves cross.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// The place on the older curve and on the younger one.
    pub at: [Near; 2],
}

/// All crossings of different curves, in the order of the faces they lie in.
///
/// # Errors
/// [`PreImageError::Crossing`] where a curve crosses itself, with the curve's index in it.
pub fn find(track: &Track, cuts: &[Cut], ways: &Ways) -> Result<Vec<Crossing>, PreImageError> {
    let mut crossings = Vec::new();
    for face in ways.faces() {
        let ways = ways.of(face);
        // By the left end, so that only legs whose spans meet are compared.
        let mut order: Vec<usize> = (0..ways.len()).collect();
        order.sort_by(|&a, &b| span(&ways[a].leg).0.total_cmp(&span(&ways[b].leg).0).then(a.cmp(&b)));
        for (k, &a) in order.iter().enumerate() {
            let end = span(&ways[a].leg).1;
            for &b in order[k + 1..].iter().take_while(|&&b| span(&ways[b].leg).0 <= end) {
                // The older curve first, and of one curve the earlier place.
                let (a, b) = (&ways[a.min(b)], &ways[a.max(b)]);
                let others = track.points[a.segment as usize].cut != track.points[b.segment as usize].cut;
                let meet = cross(&a.leg, &b.leg) || (others && run_together(&a.leg, &b.leg));
                if !are_neighbours(track, a.segment, b.segment) && meet {
                    crossings.push(crossing(track, cuts, a, b)?);
                }
            }
        }
    }
    Ok(crossings)
}

fn span(leg: &Leg) -> (f64, f64) {
    (leg.from.x.min(leg.to.x), leg.from.x.max(leg.to.x))
}

/// Neighbouring segments share a point, and one segment may have several legs.
fn are_neighbours(track: &Track, a: u32, b: u32) -> bool {
    a == b || track.points[a as usize].next == b || track.points[b as usize].next == a
}

/// Do two legs cross? Each has its beginning and not its end, so that ways that cross at a joint
/// do so once.
fn cross(a: &Leg, b: &Leg) -> bool {
    is_left(b.from, b.to, a.from) != is_left(b.from, b.to, a.to)
        && is_left(a.from, a.to, b.from) != is_left(a.from, a.to, b.to)
}

/// Legs that are as near as this, in parts of the face, are one line: above what keeps the ways of
/// different curves aside of edges (a thousand times `2^-33`), below all that cages tell apart.
const ONE_LINE: f64 = 1.0 / (1_u64 << 22) as f64;

/// Over at least this part of the face: then the angle between them is below a thousandth of a degree.
const FOR_A_WHILE: f64 = 1.0 / (1_u64 << 8) as f64;

/// Do two legs run along each other for a while? Then two of their four ends lie on the other leg.
fn run_together(a: &Leg, b: &Leg) -> bool {
    let on = |x: DVec2, leg: &Leg| {
        let way = leg.to - leg.from;
        let along = ((x - leg.from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        x.distance(leg.from + way * along) < ONE_LINE
    };
    let ends = [(a.from, b), (a.to, b), (b.from, a), (b.to, a)];
    let mut shared = ends.into_iter().filter(|(x, leg)| on(*x, leg)).map(|(x, _)| x);
    let Some(first) = shared.next() else { return false };
    shared.any(|x| x.distance(first) > FOR_A_WHILE)
}

fn crossing(track: &Track, cuts: &[Cut], a: &Way, b: &Way) -> Result<Crossing, PreImageError> {
    // How far along a leg the line of the other is met.
    let part = |leg: &Leg, other: &Leg| {
        let off = |x| (other.to - other.from).perp_dot(x - other.from);
        let (from, to) = (off(leg.from), off(leg.to));
        let f = if from == to { 0.5 } else { (from / (from - to)).clamp(0.0, 1.0) };
        leg.part[0] + (leg.part[1] - leg.part[0]) * f
    };
    let at = [(a, part(&a.leg, &b.leg)), (b, part(&b.leg, &a.leg))];
    let at = at.map(|(way, part)| Near { segment: way.segment, part, distance: 0.0 });
    let curves = at.map(|near| track.points[near.segment as usize].curve as usize);
    if track.points[a.segment as usize].cut == track.points[b.segment as usize].cut {
        let Cut { curve, heading, .. } = &cuts[curves[0]];
        let u = at.map(|near| curve_parameter(&**curve, *heading, track.parameter(near)));
        return Err(PreImageError::Crossing { curves, u, at: curve.position(u[0]) });
    }
    Ok(Crossing { at })
}
