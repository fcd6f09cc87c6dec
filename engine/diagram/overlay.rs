//! Wireframes, control cages and curves over a scene, hidden where its surfaces hide them.

use glam::{DVec2, DVec3};
use selvedge_components::curve::Curve;
use selvedge_components::triangles::Triangles;

use super::camera::Camera;
use super::canvas::{Canvas, Ends, Stroke};
use super::colour::{Colour, palette};
use super::edges::{chain_up, edges};
use super::error::DiagramError;
use super::raster::DepthBuffer;

/// What is drawn of lines and dots behind a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hidden {
    /// Nothing.
    Omit,
    /// A thin trace.
    Faint,
    /// All, as if nothing were in front.
    Show,
}

/// Lines and dots in space, of one look.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// Chains of straight lines, in model units.
    pub chains: Vec<Vec<DVec3>>,
    /// Points shown as dots, in model units.
    pub dots: Vec<DVec3>,
    /// How the lines are drawn.
    pub stroke: Stroke,
    /// The radius of the dots in pixels; they have the colour of the lines and a rim of paper.
    pub dot_radius: f64,
    /// What is drawn of what is hidden.
    pub hidden: Hidden,
    /// How far behind a surface counts as on it, as a part of half the diagonal of what the camera
    /// was fitted to.
    pub slack: f64,
}

/// A line on a curved surface lies this far behind its triangles where they are fine enough to look
/// smooth: the sag of a chord over one fifteenth of the radius. More, and lines come through thin walls.
const ON_SURFACE: f64 = 2e-3;

/// Edges of the triangles themselves are behind them by rounding and by the slope within a pixel.
const ON_TRIANGLES: f64 = 1e-3;

impl Overlay {
    /// Chains of lines.
    pub fn lines(chains: Vec<Vec<DVec3>>, stroke: Stroke) -> Self {
        Self { chains, dots: Vec::new(), stroke, dot_radius: 0.0, hidden: Hidden::Omit, slack: ON_SURFACE }
    }

    /// Dots.
    pub fn dots(dots: Vec<DVec3>, radius: f64, colour: Colour) -> Self {
        let stroke = Stroke::new(colour, 1.0);
        Self { chains: Vec::new(), dots, stroke, dot_radius: radius, hidden: Hidden::Omit, slack: ON_SURFACE }
    }

    /// A curve in space, as `pieces` straight lines of equal steps of its parameter.
    pub fn curve(curve: &dyn Curve, pieces: u32, stroke: Stroke) -> Self {
        let pieces = pieces.max(1);
        let at = |i: u32| curve.position(f64::from(i) / f64::from(pieces));
        Self::lines(vec![(0..=pieces).map(at).collect()], stroke)
    }

    /// All edges of a mesh.
    ///
    /// # Errors
    /// [`DiagramError::IndexOutOfRange`].
    pub fn wireframe(mesh: &Triangles, stroke: Stroke) -> Result<Self, DiagramError> {
        let lines = Self::lines(segments(mesh, edges(mesh)?.iter().map(|edge| edge.ends)), stroke);
        Ok(lines.with_slack(ON_TRIANGLES))
    }

    /// The edges of a mesh that have one triangle only, chained up.
    ///
    /// # Errors
    /// [`DiagramError::IndexOutOfRange`].
    pub fn border(mesh: &Triangles, stroke: Stroke) -> Result<Self, DiagramError> {
        let border: Vec<[u32; 2]> =
            edges(mesh)?.iter().filter(|edge| edge.triangles == 1).map(|edge| edge.ends).collect();
        let points = |chain: Vec<u32>| chain.into_iter().map(|vertex| mesh.positions[vertex as usize]).collect();
        Ok(Self::lines(chain_up(&border).into_iter().map(points).collect(), stroke))
    }

    /// A control cage: thin edges, a thick border, a dot at each vertex. `size` is the width of the
    /// picture in pixels, to which widths are fitted.
    ///
    /// # Errors
    /// [`DiagramError::IndexOutOfRange`].
    pub fn cage(mesh: &Triangles, colour: Colour, size: u32) -> Result<[Self; 3], DiagramError> {
        let pixel = (f64::from(size) / 1000.0).max(0.5);
        let edges = Self::wireframe(mesh, Stroke::new(colour, 1.8 * pixel))?;
        let border = Self::border(mesh, Stroke::new(colour, 4.0 * pixel))?;
        let dots = Self::dots(mesh.positions.clone(), 5.0 * pixel, colour);
        Ok([edges, border, dots].map(|part| part.with_hidden(Hidden::Faint).with_slack(ON_SURFACE)))
    }

    /// The same lines, another way where they are hidden.
    #[must_use]
    pub fn with_hidden(self, hidden: Hidden) -> Self {
        Self { hidden, ..self }
    }

    /// The same lines, seen up to another depth below a surface: see [`Overlay::slack`].
    #[must_use]
    pub fn with_slack(self, slack: f64) -> Self {
        Self { slack, ..self }
    }

    /// Every point of it.
    pub fn points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.chains.iter().flatten().chain(&self.dots).copied()
    }

    /// All points are finite.
    pub(super) fn check(&self) -> Result<(), DiagramError> {
        match self.points().enumerate().find(|(_, point)| !point.is_finite()) {
            Some((vertex, at)) => Err(DiagramError::NotFinite { what: "an overlay", vertex, at }),
            None => Ok(()),
        }
    }
}

fn segments(mesh: &Triangles, edges: impl Iterator<Item = [u32; 2]>) -> Vec<Vec<DVec3>> {
    edges.map(|edge| edge.iter().map(|&vertex| mesh.positions[vertex as usize]).collect()).collect()
}

/// Draws overlays onto the picture of what the buffer holds: first what is hidden of all of them,
/// then what is seen, in order.
pub(super) fn draw(overlays: &[Overlay], buffer: &DepthBuffer, camera: &Camera, canvas: &mut Canvas) {
    let eye = Eye { buffer, camera };
    let parts: Vec<[Runs; 2]> = overlays.iter().map(|overlay| eye.split(overlay)).collect();
    for (overlay, [_, hidden]) in overlays.iter().zip(&parts) {
        if overlay.hidden == Hidden::Faint {
            hidden.draw(&faint(overlay), canvas, Rim::None);
        }
    }
    for (overlay, [seen, _]) in overlays.iter().zip(&parts) {
        seen.draw(overlay, canvas, Rim::Paper);
    }
}

/// The look of what is hidden.
fn faint(overlay: &Overlay) -> Overlay {
    const ALPHA: u8 = 56;
    let stroke =
        Stroke { colour: overlay.stroke.colour.with_alpha(ALPHA), width: 0.7 * overlay.stroke.width, dash: None };
    Overlay { dot_radius: 0.7 * overlay.dot_radius, ..Overlay::lines(Vec::new(), stroke) }
}

/// Do dots have a rim?
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rim {
    None,
    Paper,
}

/// The parts of an overlay that are all seen or all hidden, in pixels.
#[derive(Default)]
struct Runs {
    chains: Vec<Vec<DVec2>>,
    dots: Vec<DVec2>,
}

impl Runs {
    fn draw(&self, look: &Overlay, canvas: &mut Canvas, rim: Rim) {
        // One path for many chains keeps their crossings even; a path of all would be slow to scan.
        const TOGETHER: usize = 512;
        let chains: Vec<&[DVec2]> = self.chains.iter().map(Vec::as_slice).collect();
        for some in chains.chunks(TOGETHER) {
            canvas.polylines(some, Ends::Open, &look.stroke);
        }
        for &dot in &self.dots {
            if rim == Rim::Paper {
                canvas.disc(dot, look.dot_radius * 1.35, palette::PAPER);
            }
            canvas.disc(dot, look.dot_radius, look.stroke.colour);
        }
    }
}

/// What sees the scene: a camera, and what it saw of the surfaces.
struct Eye<'a> {
    buffer: &'a DepthBuffer,
    camera: &'a Camera,
}

impl Eye<'_> {
    /// The seen and the hidden parts of an overlay.
    fn split(&self, overlay: &Overlay) -> [Runs; 2] {
        let mut parts = [Runs::default(), Runs::default()];
        for chain in &overlay.chains {
            for stretch in self.trace(chain, overlay) {
                let part = &mut parts[usize::from(!stretch.seen)];
                part.chains.push(stretch.points);
            }
        }
        for &dot in &overlay.dots {
            let Some(at) = self.camera.project(dot) else { continue };
            let seen = self.sees(at.pixel, self.camera.nearness(at.depth), overlay);
            parts[usize::from(!seen)].dots.push(at.pixel);
        }
        parts
    }

    /// Cuts a chain where it goes behind a surface or comes out again.
    fn trace(&self, chain: &[DVec3], look: &Overlay) -> Vec<Stretch> {
        let mut stretches = Stretches::default();
        for pair in chain.windows(2) {
            let Some([from, to]) = self.in_front(pair[0], pair[1]) else {
                stretches.lift();
                continue;
            };
            // Half a pixel a step: finer than what a step decides on. More than twice the longest
            // side can only be a line that mostly lies off the picture.
            let steps = (2.0 * from.pixel.distance(to.pixel)).clamp(1.0, 65_536.0) as u32;
            for step in 0..=steps {
                let t = f64::from(step) / f64::from(steps);
                let (pixel, nearness) =
                    (from.pixel.lerp(to.pixel, t), from.nearness + t * (to.nearness - from.nearness));
                stretches.push(pixel, self.sees(pixel, nearness, look));
            }
        }
        stretches.finish()
    }

    /// The part of a segment in front of the eye.
    fn in_front(&self, from: DVec3, to: DVec3) -> Option<[OnPicture; 2]> {
        // Nearer than a thousandth of the scene, a line would fill the picture.
        let nearest = 1e-3 * self.camera.reach();
        let (first, last) = (self.camera.depth(from), self.camera.depth(to));
        if first.max(last) < nearest {
            return None;
        }
        let cut = |inside: DVec3, outside: DVec3, deep: f64, shallow: f64| {
            if shallow < nearest { inside.lerp(outside, (deep - nearest) / (deep - shallow)) } else { outside }
        };
        let on_picture = |point| {
            let at = self.camera.project(point)?;
            Some(OnPicture { pixel: at.pixel, nearness: self.camera.nearness(at.depth) })
        };
        Some([on_picture(cut(to, from, last, first))?, on_picture(cut(from, to, first, last))?])
    }

    /// Is a point not behind a surface? One free sample among those within half a pixel is enough, so
    /// that lines on a silhouette or on a steep slope are whole.
    fn sees(&self, pixel: DVec2, nearness: f64, look: &Overlay) -> bool {
        if look.hidden == Hidden::Show {
            return true;
        }
        let depth = self.camera.depth_of(nearness) - look.slack * self.camera.reach();
        if depth <= 0.0 {
            return true;
        }
        let in_front = self.camera.nearness(depth);
        let around = [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
        around.into_iter().any(|step| match self.buffer.nearness_at(pixel + 0.5 * step) {
            Some(surface) => in_front >= f64::from(surface),
            None => step == DVec2::ZERO,
        })
    }
}

#[derive(Clone, Copy)]
struct OnPicture {
    pixel: DVec2,
    nearness: f64,
}

/// A part of a chain that is all seen or all hidden.
struct Stretch {
    points: Vec<DVec2>,
    seen: bool,
}

impl Stretch {
    fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }
}

/// Collects stretches point by point.
#[derive(Default)]
struct Stretches {
    done: Vec<Vec<Stretch>>,
    current: Vec<Stretch>,
}

impl Stretches {
    fn push(&mut self, pixel: DVec2, seen: bool) {
        match self.current.last_mut() {
            Some(last) if last.seen == seen => last.points.push(pixel),
            Some(last) => {
                last.points.push(pixel);
                self.current.push(Stretch { points: vec![pixel], seen });
            }
            None => self.current.push(Stretch { points: vec![pixel], seen }),
        }
    }

    /// What follows does not join on to what came before.
    fn lift(&mut self) {
        self.done.push(core::mem::take(&mut self.current));
    }

    fn finish(mut self) -> Vec<Stretch> {
        self.lift();
        self.done.into_iter().flat_map(join_short).map(thin_out).collect()
    }
}

/// A stretch of a few pixels is the noise of a grazing surface, or a line that dives into one: it
/// joins the stretch before it, at the beginning the one after it.
fn join_short(stretches: Vec<Stretch>) -> Vec<Stretch> {
    const SHORT: f64 = 3.0;
    let mut joined: Vec<Stretch> = Vec::with_capacity(stretches.len());
    for mut stretch in stretches {
        let short = stretch.length() < SHORT;
        if let [before] = &mut joined[..]
            && before.length() < SHORT
        {
            before.seen = stretch.seen;
        }
        if let Some(before) = joined.last_mut() {
            if short {
                stretch.seen = before.seen;
            }
            if before.seen == stretch.seen {
                before.points.append(&mut stretch.points);
                continue;
            }
        }
        joined.push(stretch);
    }
    joined
}

/// Drops the points that lie on the straight line between their neighbours.
fn thin_out(mut stretch: Stretch) -> Stretch {
    let mut kept: Vec<DVec2> = Vec::new();
    for &point in &stretch.points {
        if let [.., before, last] = kept[..] {
            let (along, next) = (last - before, point - last);
            // A hundredth of a pixel aside is not seen.
            let straight = along.perp_dot(point - before).abs() <= 1e-2 * point.distance(before);
            if straight && along.dot(next) >= 0.0 {
                kept.pop();
            }
        }
        if kept.last() != Some(&point) {
            kept.push(point);
        }
    }
    // A single point is still a dot as wide as the line.
    if let [only] = kept[..] {
        kept.push(only + DVec2::new(1e-3, 0.0));
    }
    stretch.points = kept;
    stretch
}
