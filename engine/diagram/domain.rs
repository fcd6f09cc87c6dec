//! Diagrams of a cage in the plane of its mean normal: filled faces, edges, curves and dots, without
//! light or depth.
//!
//! ```
//! use glam::DVec3;
//! use selvedge::diagram::colour::palette;
//! use selvedge::diagram::domain::Domain;
//! use selvedge::diagram::error::DiagramError;
//!
//! let faces = [[DVec3::ZERO, DVec3::X, DVec3::Y], [DVec3::X, DVec3::X + DVec3::Y, DVec3::Y]];
//! let mut page = Domain::new(&faces, 200)?;
//! page.fill(&faces, palette::MIST);
//! page.edges(&faces, palette::SLATE, 1.0);
//! assert_eq!(&page.canvas().png()?[1..4], b"PNG");
//! # Ok::<(), DiagramError>(())
//! ```

use glam::{DVec2, DVec3};

use super::camera::{Camera, Frame, View};
use super::canvas::{Across, Canvas, Down, Ends, Stroke, TextStyle};
use super::colour::{Colour, palette};
use super::error::DiagramError;

/// A triangle in space.
pub type Face = [DVec3; 3];

/// A diagram in the plane across the mean normal of some faces, seen from its tip.
#[derive(Clone, Debug)]
pub struct Domain {
    canvas: Canvas,
    camera: Camera,
}

impl Domain {
    /// A page `size` pixels wide that shows all of `faces`; as high as that takes.
    ///
    /// # Errors
    /// As [`Camera::fit`] and [`Canvas::new`]; [`DiagramError::Nothing`] without faces.
    pub fn new(faces: &[Face], size: u32) -> Result<Self, DiagramError> {
        Self::about(faces, faces, size)
    }

    /// A page in the plane of `faces` that shows all of `shown`.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn about(faces: &[Face], shown: &[Face], size: u32) -> Result<Self, DiagramError> {
        let view = view(faces)?;
        let points = shown.iter().flatten().copied();
        // Once as a square to learn the shape, once more as high as it is.
        let trial = Camera::fit(points.clone(), &view, Frame::new(size, size))?;
        let pixels = points.clone().filter_map(|p| trial.project(p)).map(|p| p.pixel);
        let (low, high) = pixels.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
        let (across, down) = ((high - low).x.max(1.0), (high - low).y.max(1.0));
        let height = (f64::from(size) * (down / across)).clamp(0.25 * f64::from(size), 1.5 * f64::from(size));
        let frame = Frame::new(size, height.round() as u32);
        let camera = Camera::fit(points, &view, frame)?;
        Ok(Self { canvas: Canvas::new(frame.width, frame.height, palette::PAPER)?, camera })
    }

    /// The picture so far.
    pub const fn canvas(&self) -> &Canvas {
        &self.canvas
    }

    /// The picture.
    pub fn into_canvas(self) -> Canvas {
        self.canvas
    }

    /// Where a point appears, in pixels.
    pub fn pixel(&self, point: DVec3) -> Option<DVec2> {
        self.camera.project(point).map(|p| p.pixel)
    }

    /// Fills faces.
    pub fn fill(&mut self, faces: &[Face], colour: Colour) {
        // A hairline of the same colour closes the seams that smoothed edges leave between neighbours.
        let seam = Stroke::new(colour, 0.8);
        for corners in self.projected(faces) {
            self.canvas.polygon(&corners, colour);
            self.canvas.polyline(&corners, Ends::Closed, &seam);
        }
    }

    /// Draws the edges of faces, `width` pixels wide.
    pub fn edges(&mut self, faces: &[Face], colour: Colour, width: f64) {
        let stroke = Stroke::new(colour, width);
        for corners in self.projected(faces) {
            self.canvas.polyline(&corners, Ends::Closed, &stroke);
        }
    }

    /// Draws a chain of lines.
    pub fn curve(&mut self, points: &[DVec3], ends: Ends, stroke: &Stroke) {
        let pixels: Vec<DVec2> = points.iter().filter_map(|&p| self.pixel(p)).collect();
        self.canvas.polyline(&pixels, ends, stroke);
    }

    /// Draws dots of `radius` pixels with a rim of paper.
    pub fn dots(&mut self, points: &[DVec3], radius: f64, colour: Colour) {
        for &point in points {
            let Some(at) = self.pixel(point) else { continue };
            self.canvas.disc(at, radius + 1.0, palette::PAPER);
            self.canvas.disc(at, radius, colour);
        }
    }

    /// Draws a cross in a ring at a place, and words beside it.
    pub fn mark(&mut self, point: DVec3, words: &str, colour: Colour) {
        let Some(at) = self.pixel(point) else { return };
        let size = f64::from(self.canvas.width()) / 60.0;
        let stroke = Stroke::new(colour, size / 4.0);
        for way in [DVec2::ONE, DVec2::new(1.0, -1.0)] {
            self.canvas.line(at - way * (0.6 * size), at + way * (0.6 * size), &stroke);
        }
        let ring: Vec<DVec2> = (0..48)
            .map(|k| at + 1.6 * size * DVec2::from_angle(f64::from(k) * core::f64::consts::TAU / 48.0))
            .collect();
        self.canvas.polyline(&ring, Ends::Closed, &stroke);
        // Towards the middle of the page, where there is room.
        let left = at.x > 0.5 * f64::from(self.canvas.width());
        let (across, shift) = if left { (Across::Right, -2.2 * size) } else { (Across::Left, 2.2 * size) };
        let style = TextStyle::new(1.3 * size, colour).anchored(across, Down::Middle).with_halo(palette::PAPER, 3.0);
        self.canvas.text(words, at + DVec2::new(shift, 0.0), &style);
    }

    fn projected(&self, faces: &[Face]) -> Vec<[DVec2; 3]> {
        let corners = |face: &Face| {
            let [a, b, c] = face.map(|p| self.pixel(p));
            Some([a?, b?, c?])
        };
        faces.iter().filter_map(corners).collect()
    }
}

/// From the tip of the mean normal, weighed by area; y up where that can be.
fn view(faces: &[Face]) -> Result<View, DiagramError> {
    let normal = faces.iter().fold(DVec3::ZERO, |sum, [a, b, c]| sum + (*b - *a).cross(*c - *a));
    let Some(from) = normal.try_normalize() else {
        return Err(DiagramError::Nothing { what: "faces without a mean normal" });
    };
    // Where y points at the eye, z is up.
    let up = if from.cross(DVec3::Y).length() > 0.1 { DVec3::Y } else { DVec3::Z };
    Ok(View { from, up, ..View::from_angles(0.0, 90.0) }.orthographic().with_margin(0.03))
}
