//! Where a scene is seen from.

use glam::{DVec2, DVec3};

use super::error::DiagramError;

/// How depth shortens lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Not at all: parallels stay parallel.
    Orthographic,
    /// As in an eye.
    Perspective {
        /// The full angle over the shorter side of the picture, in degrees, in (0, 180).
        field: f64,
    },
}

/// The size of a picture, and how finely it is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Samples along each side of a pixel, 1 to 4: their square is the number of samples a pixel.
    pub samples: u32,
}

impl Frame {
    /// A picture of this size with nine samples a pixel.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height, samples: 3 }
    }
}

/// From where to look; how far away follows from what is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// From the object towards the eye, of any length.
    pub from: DVec3,
    /// What points up on the picture, of any length, not necessarily at a right angle to `from`.
    pub up: DVec3,
    /// How depth shortens lengths.
    pub lens: Lens,
    /// The part of each side of the picture that stays empty, at either end, in [0, 0.45].
    pub margin: f64,
}

impl View {
    /// From an azimuth (degrees from x towards y) and an elevation (degrees above the plane of x
    /// and y), z up, through a long lens.
    pub fn from_angles(azimuth: f64, elevation: f64) -> Self {
        let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation.to_radians().sin_cos();
        let from = DVec3::new(cos_e * cos_a, cos_e * sin_a, sin_e);
        Self { from, up: DVec3::Z, lens: Lens::Perspective { field: 24.0 }, margin: 0.06 }
    }

    /// The same view with parallel lines of sight.
    #[must_use]
    pub const fn orthographic(self) -> Self {
        Self { lens: Lens::Orthographic, ..self }
    }

    /// The same view with another axis up.
    #[must_use]
    pub const fn with_up(self, up: DVec3) -> Self {
        Self { up, ..self }
    }

    /// The same view with another margin.
    #[must_use]
    pub const fn with_margin(self, margin: f64) -> Self {
        Self { margin, ..self }
    }
}

/// A point on the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projected {
    /// In pixels from the upper left corner, y down.
    pub pixel: DVec2,
    /// How far in front of the eye, along the line of sight through the middle, in model units.
    pub depth: f64,
}

/// An eye, its axes and its frame.
///
/// On the picture a point is `(x, y, w)`, homogeneous: in perspective `w` is the depth, else 1.
/// Everything projective stays linear in this form, whatever lies behind the eye [Olano, Greer 1997].
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    eye: DVec3,
    right: DVec3,
    up: DVec3,
    /// Away from the object, towards the eye.
    back: DVec3,
    perspective: bool,
    /// Pixels a model unit, in perspective at depth one.
    zoom: f64,
    frame: Frame,
    /// Half the diagonal of what it was fitted to: the length that thresholds in depth refer to.
    reach: f64,
}

impl Camera {
    /// The nearest eye in the given direction that sees all `points` inside the margins of `frame`.
    /// In perspective the fit is exact: each side of the pyramid of sight touches a point, or the
    /// opposite pair is nearer to do so.
    ///
    /// # Errors
    /// [`DiagramError::Direction`] for a view from nowhere, [`DiagramError::FieldOfView`],
    /// [`DiagramError::NotFinite`] for a point, and [`DiagramError::Nothing`] without points.
    pub fn fit(
        points: impl IntoIterator<Item = DVec3> + Clone,
        view: &View,
        frame: Frame,
    ) -> Result<Self, DiagramError> {
        let (low, high) = bounds(points.clone())?;
        let [right, up, back] = axes(view)?;
        let centre = 0.5 * low + 0.5 * high;
        let reach = (0.5 * high - 0.5 * low).length();
        // A single point is looked at as if it were a unit ball, for the sake of a finite zoom.
        let reach = if reach > 0.0 { reach } else { 1.0 };
        let inside = 1.0 - 2.0 * if view.margin.is_finite() { view.margin.clamp(0.0, 0.45) } else { 0.0 };
        let size = DVec2::new(f64::from(frame.width.max(1)), f64::from(frame.height.max(1)));
        let local = points.into_iter().map(move |p| (p - centre).mul_axes(right, up, back));
        let mut camera = Self { eye: centre, right, up, back, perspective: false, zoom: 1.0, frame, reach };
        match view.lens {
            Lens::Orthographic => camera.fit_orthographic(local, inside * size),
            Lens::Perspective { field } => {
                if !(field > 0.0 && field < 180.0) {
                    return Err(DiagramError::FieldOfView { degrees: field });
                }
                let slope = (0.5 * field).to_radians().tan();
                camera.zoom = 0.5 * size.min_element() / slope;
                camera.fit_perspective(local, inside * 0.5 * size / camera.zoom);
            }
        }
        Ok(camera)
    }

    /// Moves the eye far back along the direction, and zooms until the points fill `inside` pixels.
    fn fit_orthographic(&mut self, local: impl Iterator<Item = DVec3>, inside: DVec2) {
        let (low, high) = local.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let (middle, span) = (0.5 * low + 0.5 * high, (high - low).truncate());
        // A line or a point has no extent in one or two directions: the other decides, or the reach.
        let fill = inside / span;
        let zoom = fill.min_element();
        self.zoom = if zoom.is_finite() { zoom } else { inside.min_element() / (2.0 * self.reach) };
        self.eye += middle.x * self.right + middle.y * self.up + (high.z + self.reach) * self.back;
    }

    /// For the side of the pyramid with slope s, x - s (e - z) <= 0 must hold for the eye at e in the
    /// coordinates of the picture: the greatest x + s z over the points bounds it. Two opposite
    /// sides fix the eye across and how far it is back; the farther of both pairs is taken.
    fn fit_perspective(&mut self, local: impl Iterator<Item = DVec3>, slope: DVec2) {
        let start = [DVec2::NEG_INFINITY; 2];
        let (ahead, [plus, minus]) = local.fold((f64::NEG_INFINITY, start), |(z, [plus, minus]), p| {
            let (across, leaning) = (p.truncate(), slope * p.z);
            (z.max(p.z), [plus.max(across + leaning), minus.max(leaning - across)])
        });
        let back = ((plus + minus) / (2.0 * slope)).max_element();
        // The eye stays clear of the nearest point even of a flat or tiny object.
        let back = back.max(ahead + 1e-3 * self.reach);
        let across = 0.5 * (plus - minus);
        self.perspective = true;
        self.eye += across.x * self.right + across.y * self.up + back * self.back;
    }

    /// The size of the picture.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// The direction from the object towards the eye, in the middle of the picture.
    pub fn back(&self) -> DVec3 {
        self.back
    }

    /// Where a point appears; `None` if it lies at the eye's depth or behind it, or is not finite.
    pub fn project(&self, point: DVec3) -> Option<Projected> {
        let h = self.homogeneous(point);
        let depth = self.depth(point);
        let pixel = h.truncate() / h.z;
        (h.z > 0.0 && pixel.is_finite() && depth.is_finite()).then_some(Projected { pixel, depth })
    }

    /// The point on the picture as `(x w, y w, w)`.
    pub(super) fn homogeneous(&self, point: DVec3) -> DVec3 {
        let p = (point - self.eye).mul_axes(self.right, self.up, self.back);
        let w = if self.perspective { -p.z } else { 1.0 };
        let (middle_x, middle_y) = (0.5 * f64::from(self.frame.width), 0.5 * f64::from(self.frame.height));
        DVec3::new(self.zoom * p.x + middle_x * w, middle_y * w - self.zoom * p.y, w)
    }

    /// How far a point lies in front of the eye.
    pub(super) fn depth(&self, point: DVec3) -> f64 {
        (self.eye - point).dot(self.back)
    }

    /// A number that is larger the nearer a point is, and linear over the picture along a line or
    /// across a triangle: the reciprocal of the depth in perspective, else the depth, negative.
    pub(super) fn nearness(&self, depth: f64) -> f64 {
        if self.perspective { 1.0 / depth } else { -depth }
    }

    /// The depth that has this nearness.
    pub(super) fn depth_of(&self, nearness: f64) -> f64 {
        if self.perspective { 1.0 / nearness } else { -nearness }
    }

    pub(super) fn is_perspective(&self) -> bool {
        self.perspective
    }

    /// Half the diagonal of what the camera was fitted to.
    pub(super) fn reach(&self) -> f64 {
        self.reach
    }

    /// A direction along the picture's axes: right, up, towards the eye.
    pub(super) fn turn(&self, direction: DVec3) -> DVec3 {
        direction.mul_axes(self.right, self.up, self.back)
    }

    /// The unit vector from the surface towards the eye at a pixel, along the picture's axes.
    pub(super) fn towards_eye(&self, pixel: DVec2) -> DVec3 {
        if !self.perspective {
            return DVec3::Z;
        }
        let from_middle = pixel - 0.5 * DVec2::new(f64::from(self.frame.width), f64::from(self.frame.height));
        DVec3::new(-from_middle.x, from_middle.y, self.zoom).normalize()
    }
}

/// Components along three axes.
trait MulAxes {
    fn mul_axes(self, right: DVec3, up: DVec3, back: DVec3) -> DVec3;
}

impl MulAxes for DVec3 {
    fn mul_axes(self, right: DVec3, up: DVec3, back: DVec3) -> DVec3 {
        DVec3::new(self.dot(right), self.dot(up), self.dot(back))
    }
}

fn bounds(points: impl IntoIterator<Item = DVec3>) -> Result<(DVec3, DVec3), DiagramError> {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for (vertex, at) in points.into_iter().enumerate() {
        if !at.is_finite() {
            return Err(DiagramError::NotFinite { what: "what is looked at", vertex, at });
        }
        (low, high) = (low.min(at), high.max(at));
    }
    if low.x > high.x {
        return Err(DiagramError::Nothing { what: "no point to look at" });
    }
    Ok((low, high))
}

/// Right, up and back, at right angles. Where `up` is along the line of sight, the axis that is
/// least so takes its place.
fn axes(view: &View) -> Result<[DVec3; 3], DiagramError> {
    let back = view.from.try_normalize().ok_or(DiagramError::Direction { direction: view.from })?;
    let wanted = view.up.try_normalize().map(|up| up.cross(back));
    // Within a thousandth of a radian of the line of sight, "up" would be noise.
    let right = match wanted.filter(|right| right.length() > 1e-3) {
        Some(right) => right,
        None if back.y.abs() < 0.9 => DVec3::Y.cross(back),
        None => DVec3::X.cross(back),
    };
    let right = right.normalize();
    Ok([right, back.cross(right), back])
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame::new(400, 300);

    fn cloud() -> Vec<DVec3> {
        (0..200)
            .map(|i| {
                let t = f64::from(i);
                DVec3::new((1.3 * t).sin() * 3.0, (0.7 * t).cos() + 5.0, (2.1 * t).sin() * (0.3 * t).cos())
            })
            .collect()
    }

    fn views() -> impl Iterator<Item = View> {
        [(0.0, 0.0), (30.0, 25.0), (200.0, -60.0), (77.0, 90.0)].into_iter().flat_map(|(azimuth, elevation)| {
            let view = View::from_angles(azimuth, elevation);
            [view, view.orthographic(), View { lens: Lens::Perspective { field: 100.0 }, ..view }]
        })
    }

    #[test]
    fn every_point_lies_inside_the_margins_and_some_point_on_them() {
        for view in views() {
            let camera = Camera::fit(cloud(), &view, FRAME).expect("finite points");
            let margin = DVec2::new(400.0, 300.0) * view.margin;
            let mut gap = f64::INFINITY;
            for point in cloud() {
                let pixel = camera.project(point).expect("in front of the eye").pixel;
                let inside = (pixel - margin).min(DVec2::new(400.0, 300.0) - margin - pixel).min_element();
                gap = gap.min(inside);
            }
            assert!((-1e-9..1e-9).contains(&gap), "{view:?}: {gap}");
        }
    }

    #[test]
    fn what_is_nearer_has_the_greater_nearness() {
        for view in views() {
            let camera = Camera::fit(cloud(), &view, FRAME).expect("finite points");
            let mut depths: Vec<f64> = cloud().into_iter().map(|p| camera.depth(p)).collect();
            depths.sort_by(f64::total_cmp);
            assert!(depths[0] > 0.0);
            for pair in depths.windows(2).filter(|pair| pair[0] < pair[1]) {
                assert!(camera.nearness(pair[0]) > camera.nearness(pair[1]));
                assert!((camera.depth_of(camera.nearness(pair[0])) - pair[0]).abs() < 1e-12 * pair[0].abs());
            }
        }
    }

    /// The midpoint of a segment's picture has the mean of the nearness of its ends.
    #[test]
    fn nearness_is_linear_over_the_picture() {
        let camera = Camera::fit(cloud(), &View::from_angles(30.0, 20.0), FRAME).expect("finite points");
        let [a, b] = [cloud()[3], cloud()[90]];
        let [from, to] = [a, b].map(|p| camera.project(p).expect("in front").pixel);
        let mean = [a, b].map(|p| camera.nearness(camera.depth(p))).iter().sum::<f64>() / 2.0;
        // The point of the segment that appears half way.
        let (da, db) = (camera.depth(a), camera.depth(b));
        let middle = a.lerp(b, da / (da + db));
        let seen = camera.project(middle).expect("in front");
        assert!(seen.pixel.distance(0.5 * (from + to)) < 1e-9);
        assert!((camera.nearness(seen.depth) - mean).abs() < 1e-12);
    }

    #[test]
    fn right_is_right_and_up_is_up() {
        // From the front, with z up, x goes right.
        let view = View::from_angles(-90.0, 0.0);
        let camera = Camera::fit([DVec3::ZERO, DVec3::ONE], &view, FRAME).expect("finite points");
        let at = |p: DVec3| camera.project(p).expect("in front").pixel;
        assert!(at(DVec3::X).x > at(DVec3::ZERO).x && at(DVec3::Z).y < at(DVec3::ZERO).y);
    }

    #[test]
    fn what_cannot_be_looked_at_is_refused_by_name() {
        let view = View::from_angles(0.0, 0.0);
        let from = |from| Camera::fit(cloud(), &View { from, ..view }, FRAME);
        for direction in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
            assert!(matches!(from(direction), Err(DiagramError::Direction { .. })));
        }
        let bad = Camera::fit([DVec3::ZERO, DVec3::new(0.0, f64::NAN, 0.0)], &view, FRAME);
        assert!(matches!(bad, Err(DiagramError::NotFinite { vertex: 1, .. })));
        assert!(matches!(Camera::fit([], &view, FRAME), Err(DiagramError::Nothing { .. })));
        for field in [0.0, 180.0, f64::NAN] {
            let wide = View { lens: Lens::Perspective { field }, ..view };
            assert!(matches!(Camera::fit(cloud(), &wide, FRAME), Err(DiagramError::FieldOfView { .. })));
        }
    }

    #[test]
    fn a_single_point_and_a_flat_line_are_seen_in_the_middle() {
        for view in views() {
            for points in [vec![DVec3::ONE], vec![DVec3::ZERO, DVec3::X]] {
                let camera = Camera::fit(points.clone(), &view, FRAME).expect("finite points");
                let centre = points.iter().sum::<DVec3>() / points.len() as f64;
                let seen = camera.project(centre).expect("in front").pixel;
                assert!(seen.is_finite() && (0.0..400.0).contains(&seen.x) && (0.0..300.0).contains(&seen.y));
            }
        }
    }
}
