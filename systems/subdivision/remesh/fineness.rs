//! How fine a cage has to be along the curves, told from one remeshing to another.
//!
//! Knots that one side of a curve gives to the other are as far apart as its triangles are wide. So both
//! sides have to be as fine as either needs.

use super::Cut;
use super::arrange::Arrangement;
use super::track::Near;

/// A piece of a curve along which a cage has to be of some level at least.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// The curve, by index.
    pub cut: u32,
    /// The curve's own parameter in the middle of the piece.
    pub u: f64,
    /// How far the piece goes on to either side.
    pub half: f64,
    /// The level.
    pub level: u32,
}

/// A segment of a track as a piece of its curve.
fn piece(plan: &Arrangement, cuts: &[Cut], segment: u32, level: u32) -> Fineness {
    let contour = &plan.contours[plan.track.points[segment as usize].cut as usize];
    let spot = |part| contour.spot(cuts, plan.track.parameter(Near { segment, part, distance: 0.0 }));
    let middle = spot(0.5);
    // Its end may be the beginning of the next stretch, which is another curve's.
    let half = 2.0 * apart(spot(0.25).u, middle.u);
    Fineness { cut: contour.spans[middle.span as usize].cut, u: middle.u, half, level }
}

/// The distance of two parameters, the shorter way round.
fn apart(a: f64, b: f64) -> f64 {
    (a - b - (a - b).round()).abs()
}

/// What is asked for along the borders of `plan`: `least` levels by segment of its track.
pub(super) fn of(plan: &Arrangement, cuts: &[Cut], least: &[u32]) -> Vec<Fineness> {
    let segments = (0_u32..).zip(least).filter(|&(s, &level)| level > 0 && plan.track.is_segment(s));
    segments.map(|(s, &level)| piece(plan, cuts, s, level)).collect()
}

/// By segment of the track of `plan`, the least level that is `asked` for there.
pub(super) fn along(plan: &Arrangement, cuts: &[Cut], asked: &[Fineness]) -> Vec<u32> {
    let mut least = vec![0; plan.track.points.len()];
    let mut by_cut: Vec<Vec<&Fineness>> = vec![Vec::new(); cuts.len()];
    asked.iter().for_each(|piece| by_cut[piece.cut as usize].push(piece));
    for (segment, least) in (0_u32..).zip(&mut least).filter(|_| !asked.is_empty()) {
        if plan.track.is_segment(segment) {
            let own = piece(plan, cuts, segment, 0);
            let meets = |p: &&&Fineness| apart(p.u, own.u) <= p.half + own.half;
            *least = by_cut[own.cut as usize].iter().filter(meets).map(|p| p.level).max().unwrap_or(0);
        }
    }
    least
}
