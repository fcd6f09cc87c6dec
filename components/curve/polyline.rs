//! Straight segments end to end.

use glam::DVec3;

use super::error::finite;
use super::{Curve, Extent, ShapeError, angle, canonical, mix};

/// A polyline, parametrized by its arc length: `u` is the share of the whole length.
///
/// Arc length, not the number of the segment: the speed is the same all along, so that
/// parameters spread evenly are points spread evenly, however long the segments are. The vertices
/// are hit to the bit at [`Polyline::parameters`]. Every vertex where the direction turns is a
/// corner; [`Polyline::smooth_below`] keeps the sharper ones only.
///
/// ```
/// use glam::DVec3;
/// use selvedge_components::curve::{Curve, Polyline};
///
/// let bent = Polyline::open(vec![DVec3::ZERO, 3.0 * DVec3::X, DVec3::new(3.0, 1.0, 0.0)])?;
/// assert_eq!(bent.corners(), [0.75]);
/// assert_eq!(bent.position(0.75), 3.0 * DVec3::X);
/// # Ok::<(), selvedge_components::curve::ShapeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    /// A closed polyline repeats its first point at the end.
    points: Vec<DVec3>,
    /// The parameter of each point: 0 first, 1 last, strictly ascending.
    parameters: Vec<f64>,
    length: f64,
    corners: Vec<f64>,
    extent: Extent,
}

impl Polyline {
    /// The polyline from the first of at least two points to the last.
    ///
    /// # Errors
    /// [`ShapeError::TooFew`], [`ShapeError::PointNotFinite`], or [`ShapeError::ShortSegment`]
    /// where a point repeats the one before.
    pub fn open(points: Vec<DVec3>) -> Result<Self, ShapeError> {
        Self::build(points, Extent::Open)
    }

    /// The closed polyline through at least three points; the first is not repeated.
    ///
    /// # Errors
    /// As [`Polyline::open`].
    pub fn closed(points: Vec<DVec3>) -> Result<Self, ShapeError> {
        Self::build(points, Extent::Closed)
    }

    /// The same, but only where the direction turns by at least `turn` radians is a corner.
    #[must_use]
    pub fn smooth_below(mut self, turn: f64) -> Self {
        self.corners = self.turns().filter(|&(_, by)| by >= turn).map(|(u, _)| u).collect();
        self
    }

    /// The vertices; a closed polyline ends with its first again.
    pub fn points(&self) -> &[DVec3] {
        &self.points
    }

    /// The parameter of each of [`Polyline::points`]: 0 first, 1 last, strictly ascending.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    fn build(mut points: Vec<DVec3>, extent: Extent) -> Result<Self, ShapeError> {
        let needed = if extent == Extent::Closed { 3 } else { 2 };
        if points.len() < needed {
            return Err(ShapeError::TooFew { what: "points of a polyline", count: points.len(), needed });
        }
        finite(&points)?;
        if extent == Extent::Closed {
            points.push(points[0]);
        }
        let (parameters, length) = parameters(&points)?;
        let built = Self { points, parameters, length, corners: Vec::new(), extent };
        // A straight vertex turns by the rounding of its coordinates, eps, and no more; any turn
        // above the square root of it is meant.
        Ok(built.smooth_below(f64::EPSILON.sqrt()))
    }

    /// Every inner vertex, and the first of a closed polyline: its parameter and its turn.
    fn turns(&self) -> impl Iterator<Item = (f64, f64)> {
        let last = self.points.len() - 1;
        let seam = (self.extent == Extent::Closed).then_some((0, last - 1));
        let inner = (1..last).map(|i| (i, i - 1));
        seam.into_iter().chain(inner).map(move |(i, before)| {
            let (to, from) = (self.points[i + 1] - self.points[i], self.points[before + 1] - self.points[before]);
            (self.parameters[i], angle::between(from, to))
        })
    }

    /// The segment that `u` in [0, 1] lies on; at a vertex, the one on the given side.
    fn segment(&self, u: f64, is_before: impl Fn(f64, f64) -> bool) -> usize {
        self.parameters.partition_point(|&p| is_before(p, u)).clamp(1, self.points.len() - 1) - 1
    }

    fn direction(&self, segment: usize) -> DVec3 {
        (self.points[segment + 1] - self.points[segment]).normalize_or_zero() * self.length
    }
}

/// The share of the length up to each point, and the length.
fn parameters(points: &[DVec3]) -> Result<(Vec<f64>, f64), ShapeError> {
    let mut run = Vec::with_capacity(points.len());
    let mut length = 0.0;
    run.push(0.0);
    for (i, pair) in points.windows(2).enumerate() {
        length += pair[0].distance(pair[1]);
        if length == f64::INFINITY {
            return Err(ShapeError::PointNotFinite { index: i + 1, at: pair[1] });
        }
        run.push(length);
    }
    for u in &mut run {
        *u /= length;
    }
    // A segment that does not move the parameter could not be told from a point.
    match run.windows(2).position(|pair| pair[0] >= pair[1] || pair[1].is_nan()) {
        Some(index) => {
            let length_of = points[index].distance(points[index + 1]);
            Err(ShapeError::ShortSegment { index, length: length_of, total: length })
        }
        None => Ok((run, length)),
    }
}

impl Curve for Polyline {
    fn position(&self, u: f64) -> DVec3 {
        let u = canonical(u, self.extent);
        let i = self.segment(u, |p, u| p <= u);
        let (from, to) = (self.parameters[i], self.parameters[i + 1]);
        mix(self.points[i], self.points[i + 1], (u - from) / (to - from))
    }

    fn derivative(&self, u: f64) -> DVec3 {
        self.direction(self.segment(u, |p, u| p <= u))
    }

    fn derivative_before(&self, u: f64) -> DVec3 {
        if u <= 0.0 && self.closed() {
            return self.derivative(1.0);
        }
        self.direction(self.segment(u, |p, u| p < u))
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        self.extent == Extent::Closed
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::curve::testing::{bits, config, point};

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn vertices_are_hit_to_the_bit(points in prop::collection::vec(point(), 3..40)) {
            for line in [Polyline::open(points.clone()), Polyline::closed(points)] {
                let line = line.expect("random points are distinct");
                for (&u, &p) in line.parameters().iter().zip(line.points()) {
                    prop_assert_eq!(bits(line.position(u)), bits(p));
                }
            }
        }

        #[test]
        fn equal_steps_within_a_segment_are_equal_lengths(points in prop::collection::vec(point(), 3..10), s in 0.0..1.0) {
            let line = Polyline::open(points).expect("random points are distinct");
            let total: f64 = line.points().windows(2).map(|p| p[0].distance(p[1])).sum();
            for (u, p) in line.parameters().windows(2).zip(line.points()) {
                let v = u[0] + s * (u[1] - u[0]);
                let run = line.position(v).distance(*p);
                prop_assert!((run - (v - u[0]) * total).abs() < 1e-13 * total);
                prop_assert!((line.derivative(v).length() - total).abs() < 1e-13 * total);
            }
        }
    }

    #[test]
    fn straight_vertices_are_no_corners() -> Result<(), ShapeError> {
        let points = (0..=10).map(|k| DVec3::new(0.1, 0.3, -0.7) * f64::from(k)).collect();
        assert_eq!(Polyline::open(points)?.corners(), [0.0; 0]);
        let square = [DVec3::ZERO, DVec3::X, DVec3::new(2.0, 0.0, 0.0), DVec3::new(2.0, 2.0, 0.0), 2.0 * DVec3::Y];
        let square = Polyline::closed(square.to_vec())?;
        assert_eq!(square.corners(), [0.0, 0.25, 0.5, 0.75]);
        assert_eq!(square.smooth_below(1.6).corners(), [0.0; 0]);
        Ok(())
    }

    #[test]
    fn derivatives_at_a_vertex_are_one_sided() -> Result<(), ShapeError> {
        let line = Polyline::closed(vec![DVec3::ZERO, DVec3::X, DVec3::Y])?;
        let (after, before) = (line.derivative(0.0), line.derivative_before(0.0));
        assert!(after.normalize().distance(DVec3::X) < 1e-15 && before.normalize().distance(-DVec3::Y) < 1e-15);
        assert_eq!(bits(before), bits(line.derivative(1.0)));
        let vertex = line.parameters()[1];
        assert!(line.derivative_before(vertex).normalize().distance(DVec3::X) < 1e-15);
        assert!(line.derivative(vertex).normalize().distance(DVec3::new(-1.0, 1.0, 0.0).normalize()) < 1e-15);
        Ok(())
    }

    #[test]
    fn what_makes_no_polyline_is_refused_and_placed() {
        use ShapeError::{PointNotFinite, ShortSegment, TooFew};
        assert!(matches!(Polyline::open(vec![DVec3::X]), Err(TooFew { count: 1, needed: 2, .. })));
        assert!(matches!(Polyline::closed(vec![DVec3::X, DVec3::Y]), Err(TooFew { needed: 3, .. })));
        let repeated = vec![DVec3::ZERO, DVec3::X, DVec3::X, DVec3::Y];
        assert!(matches!(Polyline::open(repeated), Err(ShortSegment { index: 1, .. })));
        let repeated_end = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ZERO];
        assert!(matches!(Polyline::closed(repeated_end), Err(ShortSegment { index: 3, .. })));
        assert!(matches!(Polyline::open(vec![DVec3::ZERO; 3]), Err(ShortSegment { index: 0, .. })));
        let tiny = vec![DVec3::ZERO, 1e9 * DVec3::Y, DVec3::new(1e-9, 1e9, 0.0)];
        assert!(matches!(Polyline::open(tiny), Err(ShortSegment { index: 1, .. })));
        assert!(matches!(Polyline::open(vec![DVec3::X, DVec3::NAN]), Err(PointNotFinite { index: 1, .. })));
        let far = vec![DVec3::splat(-1e308), DVec3::splat(1e308)];
        assert!(matches!(Polyline::open(far), Err(PointNotFinite { index: 1, .. })));
    }
}
