//! Closed curves in the plane of x and y.

use core::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{BSpline, Bezier, Circle, Concatenation, Curve, Extent, Segment, ShapeError};

use super::ground::flat;

/// Ends of pieces meet up to rounding of coordinates of a few metres.
const GAP: f64 = 1e-12;

/// A circle.
///
/// # Errors
/// For a radius that is none.
pub fn circle(centre: DVec2, radius: f64) -> Result<Arc<dyn Curve>, ShapeError> {
    Ok(Arc::new(Circle::from_axes(flat(centre), DVec3::X, DVec3::Y, radius)?))
}

/// A polygon with sharp corners.
///
/// # Errors
/// For fewer than two corners, or two in one place.
pub fn polygon(corners: &[DVec2]) -> Result<Arc<dyn Curve>, ShapeError> {
    let sharp: Vec<(DVec2, f64)> = corners.iter().map(|&p| (p, 0.0)).collect();
    outline(&sharp)
}

/// A polygon whose corners are rounded: each with the length, in model units, that its rounding takes
/// of both of its sides; none leaves it sharp.
///
/// A rounding is a quintic whose curvature is zero where it meets the sides, so that the whole is as
/// smooth as trimming asks for, but at sharp corners. [Litke et al. 2001, Section 1.1.2: condition I]
///
/// # Errors
/// For fewer than two corners, or roundings that do not leave a piece of each side.
pub fn outline(corners: &[(DVec2, f64)]) -> Result<Arc<dyn Curve>, ShapeError> {
    let n = corners.len();
    let mut pieces: Vec<Arc<dyn Curve>> = Vec::new();
    // Where the outline leaves the rounding of each corner towards the next one.
    let leave = |k: usize| towards(corners[k % n], corners[(k + 1) % n].0);
    for k in 0..n {
        let here = corners[(k + 1) % n];
        let arrive = towards(here, corners[k].0);
        pieces.push(Arc::new(Segment { start: flat(leave(k)), end: flat(arrive) }));
        if here.1 > 0.0 {
            pieces.push(Arc::new(rounding(arrive, here.0, leave(k + 1))?));
        }
    }
    Ok(Arc::new(Concatenation::new(pieces, Extent::Closed, GAP)?))
}

/// The place on the way from a corner to another point at which its rounding ends.
fn towards((corner, length): (DVec2, f64), other: DVec2) -> DVec2 {
    corner + (other - corner).normalize_or_zero() * length
}

/// The quintic from `a` to `b` along the sides of the corner `c`: three points on each side in equal
/// steps have no curvature at the ends.
fn rounding(a: DVec2, c: DVec2, b: DVec2) -> Result<Bezier, ShapeError> {
    /// The third point's share of the way to the corner: about here the greatest curvature is least for
    /// the corners of a triangle, half of what it is at three quarters.
    const FULL: f64 = 0.54;
    let points = [a, a.lerp(c, 0.5 * FULL), a.lerp(c, FULL), b.lerp(c, FULL), b.lerp(c, 0.5 * FULL), b];
    Bezier::new(points.map(flat).to_vec())
}

/// A star of `tips` tips between two radii, its first tip towards `turn` (in full turns).
///
/// # Errors
/// For fewer than two tips, or radii that are none.
pub fn star(centre: DVec2, tips: u32, [inner, outer]: [f64; 2], turn: f64) -> Result<Arc<dyn Curve>, ShapeError> {
    let corner = |k: u32| {
        let radius = if k.is_multiple_of(2) { outer } else { inner };
        centre + radius * direction(turn + 0.5 * f64::from(k) / f64::from(tips))
    };
    polygon(&(0..2 * tips).map(corner).collect::<Vec<_>>())
}

/// A slot along the points of a centre line, `width` wide: a closed cubic B-spline, as smooth as its
/// kind all round.
///
/// # Errors
/// For fewer than three points.
pub fn slot(line: &[DVec2], width: f64) -> Result<Arc<dyn Curve>, ShapeError> {
    let last = line.len().saturating_sub(1);
    if last < 2 {
        return Err(ShapeError::TooFew { what: "points of a slot's centre line", count: line.len(), needed: 3 });
    }
    let along = |k: usize| (line[(k + 1).min(last)] - line[k.saturating_sub(1)]).normalize_or_zero();
    let side = |k: usize, sign: f64| line[k] + sign * 0.5 * width * along(k).perp();
    // Beyond each end two points make it round.
    let end =
        |k: usize, sign: f64, half: f64| line[k] + along(k) * sign * 0.42 * width + half * along(k).perp() * width;
    let mut points: Vec<DVec2> = (0..=last).map(|k| side(k, -1.0)).collect();
    points.extend([end(last, 1.0, -0.28), end(last, 1.0, 0.28)]);
    points.extend((0..=last).rev().map(|k| side(k, 1.0)));
    points.extend([end(0, -1.0, 0.28), end(0, -1.0, -0.28)]);
    Ok(Arc::new(BSpline::uniform_periodic(3, points.into_iter().map(flat).collect())?))
}

/// A plane curve bent round the origin: of a point `(x, y)`, `y` is the radius and `x` the way along the
/// circle of radius `reference`, from which angles are counted on; `twist` is by how many turns a
/// metre the angle grows with the radius.
#[derive(Clone, Debug)]
pub struct Bent {
    /// The curve.
    pub plane: Arc<dyn Curve>,
    /// Where arcs have their length, in model units.
    pub reference: f64,
    /// The angle of `x = 0` there, in turns.
    pub turn: f64,
    /// Turns a model unit.
    pub twist: f64,
}

impl Bent {
    fn turns(&self, p: DVec3) -> f64 {
        self.turn + p.x / (TAU * self.reference) + self.twist * (p.y - self.reference)
    }

    fn carried(&self, p: DVec3, velocity: DVec3) -> DVec3 {
        let out = direction(self.turns(p));
        let spin = velocity.x / self.reference + TAU * self.twist * velocity.y;
        flat(out * velocity.y + out.perp() * (p.y * spin))
    }
}

impl Curve for Bent {
    fn position(&self, u: f64) -> DVec3 {
        let p = self.plane.position(u);
        flat(direction(self.turns(p)) * p.y)
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.carried(self.plane.position(u), self.plane.derivative(u))
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        self.carried(self.plane.position(u), self.plane.derivative_before(u))
    }

    fn corners(&self) -> &[f64] {
        self.plane.corners()
    }

    fn closed(&self) -> bool {
        self.plane.closed()
    }
}

/// The unit vector at an angle in full turns, with the same bits on every machine.
pub(super) fn direction(turns: f64) -> DVec2 {
    // The circle of radius one knows.
    let unit = Circle::from_axes(DVec3::ZERO, DVec3::X, DVec3::Y, 1.0);
    unit.map_or(DVec2::X, |circle| circle.position(turns - turns.floor()).truncate())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The curvature of a plane curve by differences.
    fn curvature(curve: &dyn Curve, u: f64) -> f64 {
        let h = 1e-4;
        let [a, b, c] = [u - h, u, u + h].map(|u| curve.position(u).truncate());
        let (first, second) = ((c - a) / (2.0 * h), (a + c - 2.0 * b) / (h * h));
        first.perp_dot(second) / first.length().powi(3)
    }

    #[test]
    fn a_rounding_begins_and_ends_without_curvature() {
        let quintic = rounding(DVec2::new(-1.0, 0.0), DVec2::ZERO, DVec2::new(0.2, 0.9)).expect("six points");
        let most = (1..100).map(|k| curvature(&quintic, f64::from(k) / 100.0).abs()).fold(0.0, f64::max);
        for u in [2e-4, 1.0 - 2e-4] {
            assert!(curvature(&quintic, u).abs() < 0.01 * most, "{u}");
        }
    }

    #[test]
    fn only_sharp_corners_are_corners() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec2::new(x, y));
        let mixed = [(square[0], 0.2), (square[1], 0.0), (square[2], 0.3), (square[3], 0.0)];
        assert_eq!(outline(&mixed).expect("an outline").corners().len(), 2);
        assert_eq!(polygon(&square).expect("a polygon").corners().len(), 4);
        assert_eq!(star(DVec2::ZERO, 5, [0.4, 1.0], 0.1).expect("a star").corners().len(), 10);
    }

    #[test]
    fn bending_turns_lengths_into_arcs() {
        let plane = circle(DVec2::new(0.0, 2.0), 0.5).expect("a circle");
        let bent = Bent { plane, reference: 2.0, turn: 0.25, twist: 0.1 };
        for k in 0..50 {
            let (u, h) = (0.01 + 0.98 * f64::from(k) / 50.0, 1e-5);
            let slope = (bent.position(u + h) - bent.position(u - h)) / (2.0 * h);
            assert!(slope.distance(bent.derivative(u)) < 1e-7, "{u}");
        }
        let radius = bent.position(0.25).length();
        assert!((radius - 2.5).abs() < 1e-15, "{radius}");
    }
}
