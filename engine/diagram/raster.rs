//! Which triangle is seen at each sample, and how near it is.
//!
//! Triangles are homogeneous [Olano, Greer 1997, "Triangle scan conversion using 2D homogeneous
//! coordinates"], so that none needs clipping, whatever lies behind the eye: with corners
//! `a, b, c = (x w, y w, w)` the edge functions `b x c`, `c x a`, `a x b` dotted with `(x, y, 1)` are
//! the barycentric coordinates up to their sum, exact in perspective. Triangles that share an edge
//! compute the same numbers for it with opposite signs, bit for bit, so no sample falls between.

use glam::{DVec2, DVec3};

use super::camera::{Camera, Frame};
use super::canvas::{MOST_PIXELS, MOST_SIDE};
use super::error::DiagramError;

/// No triangle is seen there.
pub(super) const NOTHING: u32 = u32::MAX;

/// The most samples along a side of a pixel.
const MOST_PER_SIDE: usize = 4;

/// The most samples of a picture: with eight bytes each, 2 GiB.
const MOST_SAMPLES: u64 = 1 << 28;

/// A triangle seen by a camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    /// Edge functions; inside, none is negative.
    pub edges: [DVec3; 3],
    /// Dotted with (x, y, 1): the nearness there.
    pub nearness: DVec3,
    /// Do its corners turn counter-clockwise on the picture?
    pub front: bool,
}

impl Seen {
    /// The triangle with these homogeneous corners and depths; `None` if it is seen edge on.
    pub fn new(corners: [DVec3; 3], depths: [f64; 3], camera: &Camera) -> Option<Self> {
        let [a, b, c] = corners;
        let edges = [b.cross(c), c.cross(a), a.cross(b)];
        // y is down on the picture: what turns counter-clockwise for the viewer is negative.
        let volume = a.dot(edges[0]);
        if volume == 0.0 || !volume.is_finite() {
            return None;
        }
        let edges = edges.map(|edge| if volume < 0.0 { -edge } else { edge });
        let sum = if camera.is_perspective() {
            edges[0] + edges[1] + edges[2]
        } else {
            -(depths[0] * edges[0] + depths[1] * edges[1] + depths[2] * edges[2])
        };
        Some(Self { edges, nearness: sum / volume.abs(), front: volume < 0.0 })
    }

    /// Barycentric coordinates at a pixel; inside, they are in [0, 1].
    pub fn barycentric(&self, at: DVec2) -> [f64; 3] {
        let weights = self.edges.map(|edge| edge.dot(at.extend(1.0)));
        let sum = weights[0] + weights[1] + weights[2];
        // A sample at the edge of a sliver may have no weight to speak of.
        if sum > 0.0 { weights.map(|weight| weight / sum) } else { [1.0 / 3.0; 3] }
    }
}

/// The nearest triangle at each sample.
///
/// Sample (i, j) of the n by n of a pixel lies at `((i + (j + 1/2)/n) / n, (j + (i + 1/2)/n) / n)`: the
/// canonical arrangement of multi-jittered sampling [Chiu, Shirley, Wang 1994], in which no two
/// samples share a row or a column, so that edges along either axis get n^2 + 1 shades.
#[derive(Clone, Debug)]
pub(super) struct DepthBuffer {
    per_side: usize,
    /// Samples across, down.
    columns: usize,
    rows: usize,
    nearness: Vec<f32>,
    owner: Vec<u32>,
}

impl DepthBuffer {
    /// A buffer in which nothing is seen.
    pub fn new(frame: Frame) -> Result<Self, DiagramError> {
        let per_side = frame.samples.clamp(1, MOST_PER_SIDE as u32);
        let (width, height) = (frame.width, frame.height);
        let count = u64::from(width) * u64::from(height) * u64::from(per_side * per_side);
        let most_pixels = MOST_PIXELS.min(MOST_SAMPLES / u64::from(per_side * per_side));
        if width.max(height) > MOST_SIDE || count > MOST_SAMPLES || count == 0 {
            return Err(DiagramError::Size { width, height, most_side: MOST_SIDE, most_pixels });
        }
        let per_side = per_side as usize;
        Ok(Self {
            per_side,
            columns: width as usize * per_side,
            rows: height as usize * per_side,
            nearness: vec![f32::NEG_INFINITY; count as usize],
            owner: vec![NOTHING; count as usize],
        })
    }

    /// Samples along a side of a pixel.
    pub fn per_side(&self) -> usize {
        self.per_side
    }

    /// Where sample (i, j) of a pixel lies, seen from its upper left corner, in pixels.
    pub fn offset(&self, i: usize, j: usize) -> DVec2 {
        let n = self.per_side as f64;
        let shifted = |along: usize, across: usize| (along as f64 + (across as f64 + 0.5) / n) / n;
        DVec2::new(shifted(i, j), shifted(j, i))
    }

    /// The triangle seen at sample (column, row), or [`NOTHING`].
    #[cfg(test)]
    fn owner(&self, column: usize, row: usize) -> u32 {
        self.owner[row * self.columns + column]
    }

    /// The triangles seen at the samples of row `j` of a pixel, or [`NOTHING`].
    pub fn owners(&self, x: usize, y: usize, j: usize) -> &[u32] {
        let n = self.per_side;
        &self.owner[(y * n + j) * self.columns + x * n..][..n]
    }

    /// The nearness at the sample closest to a pixel's coordinates; `None` off the picture.
    pub fn nearness_at(&self, pixel: DVec2) -> Option<f32> {
        let at = (pixel * self.per_side as f64).floor();
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.columns as f64 && at.y < self.rows as f64;
        inside.then(|| self.nearness[at.y as usize * self.columns + at.x as usize])
    }

    /// Enters a triangle wherever it is nearer than what is there.
    pub fn draw(&mut self, id: u32, triangle: &Seen, corners: [DVec3; 3]) {
        let Some(area) = self.reach_of(corners) else { return };
        // A row is narrowed down to the triangle where the box around it is wide enough to pay.
        const WIDE: usize = 24;
        for row in area.top..=area.bottom {
            let (mut left, mut right) = (area.left, area.right);
            if right - left > WIDE {
                (left, right) = self.narrow(triangle, row, left, right);
            }
            if left <= right {
                self.draw_row(id, triangle, row, left, right);
            }
        }
    }

    /// The samples that a triangle can cover.
    fn reach_of(&self, corners: [DVec3; 3]) -> Option<Samples> {
        let all = Samples { left: 0, right: self.columns - 1, top: 0, bottom: self.rows - 1 };
        if corners.iter().any(|corner| corner.z <= 0.0) {
            return Some(all);
        }
        let n = self.per_side as f64;
        let on_page = corners.map(|corner| corner.truncate() / corner.z * n);
        let low = on_page[0].min(on_page[1]).min(on_page[2]);
        let high = on_page[0].max(on_page[1]).max(on_page[2]);
        // Sample c lies between c + 1/(2n) and c + 1 - 1/(2n); a thousandth is far above rounding.
        let edge = 0.5 / n - 1e-3;
        let (low, high) = (low + edge, high - edge);
        let most = DVec2::new(all.right as f64, all.bottom as f64);
        if !(low.cmple(most + 1.0).all() && high.cmpge(DVec2::ZERO).all()) {
            return None;
        }
        // Casts cut off what follows the point, which for what is not negative is `floor`.
        let (low, high) = (low.max(DVec2::ZERO), high.min(most));
        let area =
            Samples { left: low.x as usize, right: high.x as usize, top: low.y as usize, bottom: high.y as usize };
        // A triangle may slip between samples.
        (area.left <= area.right && area.top <= area.bottom).then_some(area)
    }

    /// The samples of a row between which the triangle lies, never too few.
    fn narrow(&self, triangle: &Seen, row: usize, left: usize, right: usize) -> (usize, usize) {
        let n = self.per_side as f64;
        let (top, bottom) = (row as f64 / n, (row + 1) as f64 / n);
        let (mut from, mut to) = (left as f64, right as f64);
        for edge in triangle.edges {
            let rest = (edge.y * top).max(edge.y * bottom) + edge.z;
            let crossing = -rest / edge.x * n;
            // Sample `column` lies up to one column to the right of its number.
            if edge.x > 0.0 {
                from = from.max((crossing - 1.0).floor());
            } else if edge.x < 0.0 {
                to = to.min(crossing.ceil());
            } else if rest < 0.0 {
                return (1, 0);
            }
        }
        if from <= to { (from as usize, to as usize) } else { (1, 0) }
    }

    fn draw_row(&mut self, id: u32, triangle: &Seen, row: usize, left: usize, right: usize) {
        let n = self.per_side;
        let part = 1.0 / n as f64;
        let shift = ((row % n) as f64 + 0.5) * part;
        let [e0, e1, e2] = triangle.edges;
        // What does not change along the row, for each of the heights that samples in it take in turn.
        let fixed: [[f64; 4]; MOST_PER_SIDE] = core::array::from_fn(|phase| {
            let y = (row as f64 + (phase as f64 + 0.5) * part) * part;
            [e0, e1, e2, triangle.nearness].map(|edge| edge.y * y + edge.z)
        });
        let start = row * self.columns;
        let seen = self.nearness[start + left..=start + right].iter_mut();
        let owners = self.owner[start + left..=start + right].iter_mut();
        let mut phase = left % n;
        for (column, (seen, owner)) in (left..).zip(seen.zip(owners)) {
            let x = (column as f64 + shift) * part;
            let [f0, f1, f2, near] = fixed[phase];
            phase = if phase + 1 == n { 0 } else { phase + 1 };
            if e0.x * x + f0 >= 0.0 && e1.x * x + f1 >= 0.0 && e2.x * x + f2 >= 0.0 {
                let nearness = (triangle.nearness.x * x + near) as f32;
                if nearness > *seen {
                    (*seen, *owner) = (nearness, id);
                }
            }
        }
    }
}

/// Samples from left to right and from top to bottom, both ends included.
#[derive(Clone, Copy, Debug)]
struct Samples {
    left: usize,
    right: usize,
    top: usize,
    bottom: usize,
}

#[cfg(test)]
mod tests {
    use super::super::camera::View;
    use super::*;

    const FRAME: Frame = Frame { width: 64, height: 48, samples: 3 };

    /// Where sample (column, row) lies, in pixels.
    fn place(buffer: &DepthBuffer, column: usize, row: usize) -> DVec2 {
        let n = buffer.per_side;
        DVec2::new((column / n) as f64, (row / n) as f64) + buffer.offset(column % n, row % n)
    }

    fn camera(points: &[DVec3], perspective: bool) -> Camera {
        let view = View::from_angles(-70.0, 35.0).with_margin(0.0);
        let view = if perspective { view } else { view.orthographic() };
        Camera::fit(points.to_vec(), &view, FRAME).expect("finite points")
    }

    fn seen(corners: [DVec3; 3], camera: &Camera) -> Option<(Seen, [DVec3; 3])> {
        let on_picture = corners.map(|p| camera.homogeneous(p));
        Seen::new(on_picture, corners.map(|p| camera.depth(p)), camera).map(|seen| (seen, on_picture))
    }

    /// A fan around a point covers each sample inside its outline: no sample falls between triangles.
    #[test]
    fn triangles_that_share_edges_leave_no_sample_between() {
        for perspective in [false, true] {
            let ring: Vec<DVec3> = (0..97)
                .map(|i| DVec3::new((f64::from(i) * 0.06478).cos(), (f64::from(i) * 0.06478).sin(), 0.0))
                .collect();
            let camera = camera(&ring, perspective);
            let mut buffer = DepthBuffer::new(FRAME).expect("a small picture");
            let middle = DVec3::new(0.0137, -0.0071, 0.0);
            for i in 0..97 {
                let (triangle, corners) = seen([middle, ring[i], ring[(i + 1) % 97]], &camera).expect("not edge on");
                buffer.draw(i as u32, &triangle, corners);
            }
            // The outline is convex: a sample is inside if it lies on the same side of all of it.
            let on_picture: Vec<DVec3> = ring.iter().map(|&p| camera.homogeneous(p)).collect();
            for (row, column) in (0..buffer.rows).flat_map(|row| (0..buffer.columns).map(move |column| (row, column))) {
                let at = place(&buffer, column, row).extend(1.0);
                let left_of = |i: usize| on_picture[i].cross(on_picture[(i + 1) % 97]).dot(at) > 0.0;
                let inside = (1..97).all(|i| left_of(i) == left_of(0));
                assert_eq!(buffer.owner(column, row) != NOTHING, inside, "column {column}, row {row}");
            }
        }
    }

    /// Covered samples of a triangle count its area, and what they own agrees with a test of each
    /// sample by itself.
    #[test]
    fn a_triangle_covers_exactly_the_samples_inside() {
        let corners = [DVec3::new(-1.0, 0.2, 0.4), DVec3::new(2.0, -0.5, -0.3), DVec3::new(0.3, 1.5, 1.0)];
        for perspective in [false, true] {
            let camera = camera(&corners, perspective);
            let (triangle, on_picture) = seen(corners, &camera).expect("not edge on");
            let mut buffer = DepthBuffer::new(FRAME).expect("a small picture");
            buffer.draw(7, &triangle, on_picture);
            let mut covered = 0;
            for row in 0..buffer.rows {
                for column in 0..buffer.columns {
                    let inside = triangle.edges.iter().all(|e| e.dot(place(&buffer, column, row).extend(1.0)) >= 0.0);
                    assert_eq!(buffer.owner(column, row) == 7, inside, "{column} {row}");
                    covered += usize::from(inside);
                }
            }
            let [a, b, c] = corners.map(|p| camera.project(p).expect("in front").pixel);
            let area = 0.5 * (b - a).perp_dot(c - a).abs();
            assert!((covered as f64 / 9.0 - area).abs() < 0.01 * area, "{covered} samples for {area} pixels");
        }
    }

    /// The part of a triangle in front of the eye is seen although a corner lies behind it, and no
    /// ghost of the other part is.
    #[test]
    fn a_triangle_through_the_eye_plane_is_seen_where_it_is_in_front() {
        let camera = camera(&[DVec3::NEG_ONE, DVec3::ONE], true);
        let ground = [DVec3::new(-1e3, -1e3, -1.0), DVec3::new(1e3, -1e3, -1.0), DVec3::new(0.0, 1e3, -1.0)];
        assert!(ground.iter().any(|&p| camera.project(p).is_none()), "a corner is behind the eye");
        let (triangle, corners) = seen(ground, &camera).expect("not edge on");
        let mut buffer = DepthBuffer::new(FRAME).expect("a small picture");
        buffer.draw(0, &triangle, corners);
        let target = camera.project(DVec3::new(0.0, 0.0, -1.0)).expect("in front");
        let found = buffer.nearness_at(target.pixel).expect("on the picture");
        assert!((camera.depth_of(f64::from(found)) - target.depth).abs() < 0.05 * target.depth);
        assert!(buffer.nearness.iter().all(|&nearness| nearness == f32::NEG_INFINITY || nearness > 0.0));
    }

    #[test]
    fn the_nearer_triangle_wins_whatever_the_order() {
        let square = |z: f64| [DVec3::new(-1.0, -1.0, z), DVec3::new(1.0, -1.0, z), DVec3::new(0.0, 1.0, z)];
        let points: Vec<DVec3> = square(0.0).into_iter().chain(square(0.5)).collect();
        for perspective in [false, true] {
            let camera = camera(&points, perspective);
            let middle = camera.project(DVec3::new(0.0, -0.3, 0.5)).expect("in front").pixel;
            for order in [[0, 1], [1, 0]] {
                let mut buffer = DepthBuffer::new(FRAME).expect("a small picture");
                for id in order {
                    let (triangle, corners) = seen(square(0.5 * f64::from(id)), &camera).expect("not edge on");
                    buffer.draw(id, &triangle, corners);
                }
                let at = (middle * 3.0).floor();
                assert_eq!(buffer.owner(at.x as usize, at.y as usize), 1);
            }
        }
    }

    #[test]
    fn what_has_no_area_or_is_not_finite_is_not_seen() {
        let camera = camera(&[DVec3::ZERO, DVec3::ONE], true);
        assert!(seen([DVec3::ZERO, DVec3::ONE, DVec3::ONE], &camera).is_none());
        assert!(seen([DVec3::ZERO, DVec3::X, DVec3::NAN], &camera).is_none());
    }

    #[test]
    fn too_many_samples_are_refused() {
        for (width, height) in [(0, 5), (5, 0), (MOST_SIDE, MOST_SIDE), (u32::MAX, 2)] {
            assert!(matches!(DepthBuffer::new(Frame::new(width, height)), Err(DiagramError::Size { .. })));
        }
    }
}
