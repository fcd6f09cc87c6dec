//! Distances from points to triangles.

use glam::DVec3;

/// The squared distance from `x` to the segment from `a` to `b`.
pub fn squared_to_segment(x: DVec3, a: DVec3, b: DVec3) -> f64 {
    let (along, to) = (b - a, x - a);
    let length = along.length_squared();
    // Where both ends are one point, any place between them is it.
    let t = if length > 0.0 { (to.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    to.distance_squared(along * t)
}

/// The plane of a triangle, ready for many points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    origin: DVec3,
    normal: DVec3,
    /// What the second and the third corner weigh, as a product with the way from the first.
    duals: [DVec3; 2],
}

/// A point over a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Over {
    /// The square of its height.
    pub squared: f64,
    /// The weights of the triangle's corners at its foot; one is negative where the foot is outside.
    pub weights: [f64; 3],
}

impl Plane {
    /// The plane of a triangle; `None` if it has no area.
    pub fn new([a, b, c]: [DVec3; 3]) -> Option<Self> {
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac);
        let area = normal.length_squared();
        let duals = [ac.cross(normal) / area, normal.cross(ab) / area];
        let plane = Self { origin: a, normal: normal / area.sqrt(), duals };
        (area > 0.0 && duals[0].is_finite() && duals[1].is_finite()).then_some(plane)
    }

    /// The point `x` over the plane.
    #[inline]
    pub fn under(&self, x: DVec3) -> Over {
        let way = x - self.origin;
        let (b, c) = (way.dot(self.duals[0]), way.dot(self.duals[1]));
        let height = way.dot(self.normal);
        Over { squared: height * height, weights: [1.0 - b - c, b, c] }
    }
}

impl Over {
    /// Is the foot in the triangle?
    #[inline]
    pub fn inside(&self) -> bool {
        self.weights.iter().all(|&w| w >= 0.0)
    }
}

/// A triangle, ready for the distances of many points.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    corners: [DVec3; 3],
    plane: Option<Plane>,
}

impl Facet {
    /// The triangle with these corners, degenerate or not.
    pub fn new(corners: [DVec3; 3]) -> Self {
        Self { corners, plane: Plane::new(corners) }
    }

    /// Where `x` is over its plane; `None` if it has no area.
    #[inline]
    pub fn under(&self, x: DVec3) -> Option<Over> {
        Some(self.plane?.under(x))
    }

    /// The squared distance from `x`.
    #[inline]
    pub fn squared(&self, x: DVec3) -> f64 {
        match self.under(x) {
            Some(over) if over.inside() => over.squared,
            _ => self.squared_to_rim(x),
        }
    }

    /// The squared distance from `x` to the nearest edge.
    fn squared_to_rim(&self, x: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        squared_to_segment(x, a, b).min(squared_to_segment(x, b, c)).min(squared_to_segment(x, c, a))
    }
}

/// The squared distance from `x` to a triangle, degenerate or not.
pub fn squared_to_triangle(x: DVec3, corners: [DVec3; 3]) -> f64 {
    Facet::new(corners).squared(x)
}

/// `2 area / longest^2`: 0.866 for an equilateral triangle, 0 for a degenerate one.
pub fn shape([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::new(0.0, 0.0, 0.0), DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 3.0, 0.0)];

    /// Over the inside, the edges and the corners, where the answer is plain to see.
    #[test]
    fn distances_to_a_triangle_have_their_closed_forms() {
        for (x, distance) in [
            (DVec3::new(1.0, 1.0, 2.0), 2.0),
            (DVec3::new(1.0, -3.0, 4.0), 5.0),
            (DVec3::new(-3.0, -4.0, 0.0), 5.0),
            (DVec3::new(8.0, 0.0, 3.0), 5.0),
            // Across the long edge 3 x + 4 y = 12, unit normal (3, 4) / 5, from its point (2, 1.5).
            (DVec3::new(2.0 + 3.0, 1.5 + 4.0, 12.0), 13.0),
            (DVec3::new(1.0, 1.0, 0.0), 0.0),
        ] {
            let found = squared_to_triangle(x, TRIANGLE).sqrt();
            assert!((found - distance).abs() < 1e-14, "{x}: {found}, not {distance}");
        }
    }

    /// A triangle without area is the segment, or the point, that is left of it.
    #[test]
    fn a_degenerate_triangle_is_its_longest_edge() {
        let [a, b] = [DVec3::ZERO, DVec3::X];
        assert_eq!(squared_to_triangle(DVec3::new(0.5, 2.0, 0.0), [a, b, a]), 4.0);
        assert_eq!(squared_to_triangle(DVec3::new(0.0, 0.0, 3.0), [a, a, a]), 9.0);
        assert_eq!(shape([a, a, a]), 0.0);
    }

    /// The shape is that of the triangle, not of its size.
    #[test]
    fn an_equilateral_triangle_has_the_best_shape() {
        let third = core::f64::consts::TAU / 3.0;
        let corner = |i: f64| 7.0 * DVec3::new((third * i).cos(), (third * i).sin(), 1.0);
        let found = shape([corner(0.0), corner(1.0), corner(2.0)]);
        assert!((found - 0.75_f64.sqrt()).abs() < 1e-15, "{found}");
        assert!(shape(TRIANGLE) < found);
    }
}
