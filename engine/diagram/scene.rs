//! Surfaces and lines, seen together.

use glam::DVec3;

use super::camera::{Camera, Frame, View};
use super::canvas::Canvas;
use super::colour::{Colour, palette};
use super::error::DiagramError;
use super::overlay::{self, Overlay};
use super::raster::DepthBuffer;
use super::shade::{self, Layer, Surface};

/// What a picture shows: surfaces hide each other and the lines behind them.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// Surfaces, in any order.
    pub surfaces: Vec<Surface<'a>>,
    /// Lines and dots; later ones are drawn over earlier ones.
    pub overlays: Vec<Overlay>,
    /// The colour behind everything.
    pub background: Colour,
}

impl Default for Scene<'_> {
    fn default() -> Self {
        Self { surfaces: Vec::new(), overlays: Vec::new(), background: palette::PAPER }
    }
}

impl<'a> Scene<'a> {
    /// A scene with one surface.
    pub fn of(surface: Surface<'a>) -> Self {
        Self { surfaces: vec![surface], ..Self::default() }
    }

    /// The same scene with one more surface.
    #[must_use]
    pub fn and(mut self, surface: Surface<'a>) -> Self {
        self.surfaces.push(surface);
        self
    }

    /// The same scene with lines over it.
    #[must_use]
    pub fn with(mut self, overlays: impl IntoIterator<Item = Overlay>) -> Self {
        self.overlays.extend(overlays);
        self
    }

    /// A camera that sees all of the scene.
    ///
    /// # Errors
    /// As [`Camera::fit`].
    pub fn camera(&self, view: &View, frame: Frame) -> Result<Camera, DiagramError> {
        Camera::fit(self.points(), view, frame)
    }

    /// All vertices and points.
    fn points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        let surfaces = self.surfaces.iter().flat_map(|surface| surface.mesh.positions.iter().copied());
        surfaces.chain(self.overlays.iter().flat_map(Overlay::points))
    }

    /// The picture of all of the scene from a view.
    ///
    /// # Errors
    /// As [`Camera::fit`] and [`Scene::draw`].
    pub fn picture(&self, view: &View, frame: Frame) -> Result<Canvas, DiagramError> {
        self.draw(&self.camera(view, frame)?)
    }

    /// The picture that a camera takes.
    ///
    /// # Errors
    /// [`DiagramError::NotFinite`], [`DiagramError::IndexOutOfRange`] or [`DiagramError::Count`] for
    /// a surface or lines that cannot be drawn, [`DiagramError::TooManyTriangles`], and
    /// [`DiagramError::Size`].
    pub fn draw(&self, camera: &Camera) -> Result<Canvas, DiagramError> {
        self.check()?;
        let frame = camera.frame();
        let mut canvas = Canvas::new(frame.width, frame.height, self.background)?;
        let mut buffer = DepthBuffer::new(frame)?;
        let mut layers: Vec<Layer<'_>> = Vec::with_capacity(self.surfaces.len());
        for surface in &self.surfaces {
            let first = layers.last().map_or(0, Layer::end);
            let layer = Layer::new(*surface, camera, first);
            layer.rasterise(&mut buffer, camera);
            layers.push(layer);
        }
        shade::develop(&buffer, &layers, camera, &mut canvas);
        overlay::draw(&self.overlays, &buffer, camera, &mut canvas);
        Ok(canvas)
    }

    fn check(&self) -> Result<(), DiagramError> {
        self.surfaces.iter().try_for_each(Surface::check)?;
        self.overlays.iter().try_for_each(Overlay::check)?;
        let found = self.surfaces.iter().map(|surface| surface.mesh.triangles.len() as u64).sum();
        // The last number says that nothing is seen.
        let most = u64::from(u32::MAX);
        if found > most { Err(DiagramError::TooManyTriangles { found, most }) } else { Ok(()) }
    }
}
