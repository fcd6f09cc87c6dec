//! A surface as small flat triangles, each with a bound on how far the surface leaves it.

use std::ops::Range;

use glam::{DVec2, DVec3};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::FaceCode;

use super::walk::Walk;
use crate::parallel::map_in_order;
use crate::spatial::Bounds;

/// A part of a face, small enough to be nearly flat.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// The points of the surface at the corners.
    pub points: [DVec3; 3],
    /// No point of the surface over the cell is farther than this from the triangle.
    pub sag: f64,
    pub code: FaceCode,
    pub level: u8,
}

/// Cells are quartered until the surface leaves them by less than this part of their longest edge: a
/// thirtieth of a radian or so of turning from corner to corner. A search that starts in the triangle
/// then converges at once, and finer cells would cost more than they spare.
const FLAT: f64 = 0.02;

/// The levels at which quartering begins and ends at the latest, if there is nothing finer to be seen.
/// One level shows an irregular vertex's neighbourhood; below `2^-8` of a face a cell that still is
/// not flat is a crease, and its own bound tells how much.
const LEVELS: [u8; 2] = [1, 8];

/// The largest deviation at the samples times this bounds the deviation everywhere: the samples are
/// where a quadratic deviates most, and the factor leaves as much again for what differs from one.
const SAFETY: f64 = 2.0;

/// The cells of some faces of `surface`, in their order.
pub(super) fn cells(surface: &impl Walk, faces: Range<usize>) -> Vec<Cell> {
    map_in_order(faces.len(), |i| {
        let face = FaceId::new(faces.start + i);
        let corners = [DVec2::ZERO, DVec2::X, DVec2::Y];
        let points = corners.map(|st| surface.position(SurfacePoint { face, st }));
        let mut cells = Vec::new();
        let root = Part { face, code: FaceCode::root(face), level: 0, corners, points };
        root.cut(surface, &mut cells);
        cells
    })
    .into_iter()
    .flatten()
    .collect()
}

/// A cell in the making.
struct Part {
    face: FaceId,
    code: FaceCode,
    level: u8,
    corners: [DVec2; 3],
    points: [DVec3; 3],
}

impl Part {
    fn cut(&self, surface: &impl Walk, cells: &mut Vec<Cell>) {
        let position = |st: DVec2| surface.position(SurfacePoint { face: self.face, st });
        let [a, b, c] = self.corners;
        let middles = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
        let at_middles = middles.map(position);
        let centre = position((a + b + c) / 3.0);
        let deviation = |p: DVec3| nearest_in_triangle(p, &self.points).1.sqrt();
        let sag = at_middles.iter().fold(deviation(centre), |most, &p| most.max(deviation(p)));
        let [p, q, r] = self.points;
        let longest = (q - p).length().max((r - q).length()).max((p - r).length());
        let settled = surface.is_settled(u32::from(self.level), self.code);
        let flat = self.level >= LEVELS[0] && sag <= FLAT * longest;
        // Below the finest level that codes can name there is nothing more to see.
        if (settled && (flat || self.level >= LEVELS[1])) || self.level >= 28 {
            cells.push(Cell { points: self.points, sag: SAFETY * sag, code: self.code, level: self.level });
            return;
        }
        let ([u, v, w], [x, y, z]) = (middles, at_middles);
        let quarters = [([a, u, w], [p, x, z]), ([u, b, v], [x, q, y]), ([w, v, c], [z, y, r]), ([u, v, w], [x, y, z])];
        for (i, (corners, points)) in quarters.into_iter().enumerate() {
            let part = Self { face: self.face, code: self.code.child(i), level: self.level + 1, corners, points };
            part.cut(surface, cells);
        }
    }
}

impl Cell {
    pub fn face(&self) -> FaceId {
        self.code.root_face(u32::from(self.level))
    }

    /// A box that holds the surface over the cell.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(self.points).grown(self.sag)
    }

    /// The longest edge.
    pub fn size(&self) -> f64 {
        let [a, b, c] = self.points;
        a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)).sqrt()
    }

    /// Where the cell's own weights lead.
    pub fn place(&self, weights: [f64; 3]) -> SurfacePoint {
        let step = 0.5_f64.powi(i32::from(self.level));
        let st = self
            .code
            .corners(u32::from(self.level))
            .iter()
            .zip(weights)
            .fold(DVec2::ZERO, |sum, (&(i, j), w)| sum + DVec2::new(f64::from(i), f64::from(j)) * (step * w));
        SurfacePoint { face: self.face(), st }
    }
}

/// The point of a triangle nearest to `p`, as weights of its corners, and its squared distance.
///
/// By the regions of the plane that are nearest to a corner, an edge or the inside. [Ericson 2005,
/// Section 5.1.5]
pub(super) fn nearest_in_triangle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> ([f64; 3], f64) {
    let weights = nearest_weights(p, a, b, c);
    let at = a * weights[0] + b * weights[1] + c * weights[2];
    (weights, at.distance_squared(p))
}

fn nearest_weights(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return [1.0, 0.0, 0.0];
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return [0.0, 1.0, 0.0];
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = share(d1, d1 - d3);
        return [1.0 - v, v, 0.0];
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return [0.0, 0.0, 1.0];
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = share(d2, d2 - d6);
        return [1.0 - w, 0.0, w];
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = share(d4 - d3, (d4 - d3) + (d5 - d6));
        return [0.0, 1.0 - w, w];
    }
    let total = va + vb + vc;
    let (v, w) = (share(vb, total), share(vc, total));
    [1.0 - v - w, v, w]
}

/// `part / whole`, and 0 where the triangle has shrunk to nothing.
fn share(part: f64, whole: f64) -> f64 {
    if whole > 0.0 { part / whole } else { 0.0 }
}
