//! The page: lines, polygons, circles and text on pixels, and PNG out.
//!
//! Points are in pixels from the upper left corner, y down; the centre of the first pixel is
//! (0.5, 0.5). Nothing panics: what is not finite, or lies off the page, leaves no mark.

use std::path::Path as FilePath;

use glam::DVec2;
use tiny_skia::{Color, FillRule, LineCap, LineJoin, Paint, PathBuilder, Pixmap, PixmapPaint, StrokeDash, Transform};

use super::clip::{self, Area};
use super::colour::{Colour, palette};
use super::error::DiagramError;
use super::font;

/// The longest side of a picture. Coordinates this large keep 9 binary places in `f32`, more than
/// the rasteriser's own grid.
pub const MOST_SIDE: u32 = 1 << 14;

/// The most pixels of a picture: 256 MiB.
pub const MOST_PIXELS: u64 = 1 << 26;

/// What lies farther off than this, or is larger, is no part of any picture here.
const FARTHEST: f64 = 2.0 * MOST_SIDE as f64;

/// Neither NaN nor far off the page.
fn near(point: DVec2) -> bool {
    point.abs().cmple(DVec2::splat(FARTHEST)).all()
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Its colour.
    pub colour: Colour,
    /// Its width in pixels.
    pub width: f64,
    /// Length of dashes and of the gaps between them, in pixels.
    pub dash: Option<[f64; 2]>,
}

impl Stroke {
    /// A solid line.
    pub const fn new(colour: Colour, width: f64) -> Self {
        Self { colour, width, dash: None }
    }

    /// The same line with dashes of `on` pixels and gaps of `off`.
    #[must_use]
    pub const fn dashed(self, on: f64, off: f64) -> Self {
        Self { dash: Some([on, off]), ..self }
    }
}

/// Does a chain of points return to its first one?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ends {
    /// It ends at its last point.
    Open,
    /// A line joins the last point to the first.
    Closed,
}

/// Which point of a line of text lies at the place given, from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Its left end.
    Left,
    /// Its middle.
    Middle,
    /// Its right end.
    Right,
}

/// Which height of a line of text lies at the place given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Down {
    /// The top of capitals.
    Top,
    /// Half the height of capitals: what the eye takes for the middle.
    Middle,
    /// The line that letters stand on.
    Baseline,
}

/// How a line of text is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextStyle {
    /// Pixels an em.
    pub size: f64,
    /// Its colour.
    pub colour: Colour,
    /// What lies at the place given, from left to right.
    pub across: Across,
    /// What lies at the place given, from top to bottom.
    pub down: Down,
    /// Degrees counter-clockwise about the place given.
    pub rotation: f64,
    /// A rim of this colour and width in pixels, so that the text reads on any ground.
    pub halo: Option<(Colour, f64)>,
}

impl TextStyle {
    /// Text that begins at the place given and stands on it.
    pub const fn new(size: f64, colour: Colour) -> Self {
        Self { size, colour, across: Across::Left, down: Down::Baseline, rotation: 0.0, halo: None }
    }

    /// The same text, anchored elsewhere.
    #[must_use]
    pub const fn anchored(self, across: Across, down: Down) -> Self {
        Self { across, down, ..self }
    }

    /// The same text, turned by `degrees` counter-clockwise.
    #[must_use]
    pub const fn rotated(self, degrees: f64) -> Self {
        Self { rotation: degrees, ..self }
    }

    /// The same text with a rim.
    #[must_use]
    pub const fn with_halo(self, colour: Colour, width: f64) -> Self {
        Self { halo: Some((colour, width)), ..self }
    }
}

/// The width in pixels of a line of text of `size` pixels an em.
pub fn text_width(text: &str, size: f64) -> f64 {
    font::width(text) * size
}

/// Rows of pixels, opaque, with what was drawn on them.
#[derive(Clone, Debug, PartialEq)]
pub struct Canvas {
    pixels: Pixmap,
}

impl Canvas {
    /// A blank page.
    ///
    /// # Errors
    /// [`DiagramError::Size`] if a side is zero or beyond [`MOST_SIDE`], or there would be more
    /// than [`MOST_PIXELS`].
    pub fn new(width: u32, height: u32, background: Colour) -> Result<Self, DiagramError> {
        let refused = || DiagramError::Size { width, height, most_side: MOST_SIDE, most_pixels: MOST_PIXELS };
        if width.max(height) > MOST_SIDE || u64::from(width) * u64::from(height) > MOST_PIXELS {
            return Err(refused());
        }
        let mut pixels = Pixmap::new(width, height).ok_or_else(refused)?;
        pixels.fill(skia_colour(background.with_alpha(255)));
        Ok(Self { pixels })
    }

    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.pixels.width()
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.pixels.height()
    }

    /// The colour of a pixel, sRGB-encoded; `None` off the page.
    pub fn pixel(&self, x: u32, y: u32) -> Option<[u8; 3]> {
        self.pixels.pixel(x, y).map(|p| [p.red(), p.green(), p.blue()])
    }

    /// The pixels, row by row from the top, four bytes each: red, green, blue (sRGB-encoded), 255.
    pub fn bytes(&self) -> &[u8] {
        self.pixels.data()
    }

    /// The pixels of one row, to be written over: red, green, blue, 255.
    pub(super) fn row_mut(&mut self, y: u32) -> &mut [[u8; 4]] {
        let width = self.width() as usize;
        let (rows, _) = self.pixels.data_mut().as_chunks_mut::<4>();
        &mut rows[y as usize * width..][..width]
    }

    /// One straight line with round ends.
    pub fn line(&mut self, from: DVec2, to: DVec2, stroke: &Stroke) {
        self.polyline(&[from, to], Ends::Open, stroke);
    }

    /// A chain of straight lines, rounded at its ends and corners. A point that is not finite
    /// breaks it.
    pub fn polyline(&mut self, points: &[DVec2], ends: Ends, stroke: &Stroke) {
        self.polylines(&[points], ends, stroke);
    }

    /// Many chains drawn as one shape: where they cross, a translucent colour is laid on once.
    pub fn polylines(&mut self, chains: &[&[DVec2]], ends: Ends, stroke: &Stroke) {
        let longest = f64::from(self.width().max(self.height()));
        if !(stroke.width > 0.0 && stroke.width <= longest) {
            return;
        }
        let area = Area::of_picture(self.width(), self.height(), 2.0 * stroke.width + 2.0);
        let mut path = PathBuilder::new();
        for chain in chains {
            push_chain(&mut path, chain, ends, &area);
        }
        let Some(path) = path.finish() else { return };
        // Dashes under half a pixel are not seen as such, and could be too many to cut.
        let dash = stroke.dash.filter(|dash| dash.iter().all(|length| *length >= 0.5));
        let style = tiny_skia::Stroke {
            width: stroke.width as f32,
            line_cap: if dash.is_some() { LineCap::Butt } else { LineCap::Round },
            line_join: LineJoin::Round,
            dash: dash.and_then(|[on, off]| StrokeDash::new(vec![on as f32, off as f32], 0.0)),
            ..Default::default()
        };
        self.pixels.stroke_path(&path, &paint(stroke.colour), &style, Transform::identity(), None);
    }

    /// A filled polygon; where it overlaps itself it is filled, too.
    pub fn polygon(&mut self, corners: &[DVec2], fill: Colour) {
        let area = Area::of_picture(self.width(), self.height(), 2.0);
        let corners = clip::polygon(corners, &area);
        let mut path = PathBuilder::new();
        for (i, corner) in corners.iter().enumerate() {
            let (x, y) = (corner.x as f32, corner.y as f32);
            if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
        }
        path.close();
        self.fill(path, fill);
    }

    /// A filled rectangle with two sides along the page's.
    pub fn rectangle(&mut self, low: DVec2, high: DVec2, fill: Colour) {
        self.polygon(&[low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)], fill);
    }

    /// A filled rectangle with round corners; the radius is cut to half the shorter side.
    pub fn round_rectangle(&mut self, low: DVec2, high: DVec2, radius: f64, fill: Colour) {
        if !(near(low) && near(high) && low.cmplt(high).all()) {
            return;
        }
        let radius = radius.max(0.0).min(0.5 * (high - low).min_element());
        self.fill(round_rectangle(low, high, radius), fill);
    }

    /// A filled circle.
    pub fn disc(&mut self, centre: DVec2, radius: f64, fill: Colour) {
        if !(radius > 0.0 && radius <= FARTHEST && near(centre)) {
            return;
        }
        let mut path = PathBuilder::new();
        path.push_circle(centre.x as f32, centre.y as f32, radius as f32);
        self.fill(path, fill);
    }

    /// One line of text.
    pub fn text(&mut self, text: &str, at: DVec2, style: &TextStyle) {
        if !(style.size > 0.0 && style.size <= FARTHEST && style.rotation.is_finite() && near(at)) {
            return;
        }
        let Some(path) = font::outline(text, style.size) else { return };
        let (across, down) = offset(text, style);
        let turned = Transform::from_rotate(-style.rotation as f32).pre_translate(across as f32, down as f32);
        // A baseline on a whole pixel keeps the feet of upright letters sharp.
        let y = if style.rotation == 0.0 { (at.y + down).round() - down } else { at.y };
        let place = turned.post_translate(at.x as f32, y as f32);
        if let Some((colour, width)) = style.halo.filter(|(_, width)| *width > 0.0 && *width <= FARTHEST) {
            let rim = tiny_skia::Stroke { width: 2.0 * width as f32, line_join: LineJoin::Round, ..Default::default() };
            self.pixels.stroke_path(&path, &paint(colour), &rim, place, None);
        }
        self.pixels.fill_path(&path, &paint(style.colour), FillRule::Winding, place, None);
    }

    /// Lays another picture on this one, its upper left corner at pixel (x, y).
    pub fn paste(&mut self, picture: &Self, x: i32, y: i32) {
        let how = PixmapPaint::default();
        self.pixels.draw_pixmap(x, y, picture.pixels.as_ref(), &how, Transform::identity(), None);
    }

    /// The picture without the rows and columns around it that have the colour of its upper left
    /// corner throughout, but for `margin` pixels of them (fewer where there were fewer). A blank
    /// picture stays as it is.
    ///
    /// # Errors
    /// None but those of [`Canvas::new`], and it is no larger than it was.
    pub fn trimmed(&self, margin: u32) -> Result<Self, DiagramError> {
        let (width, height) = (self.width(), self.height());
        let blank = self.pixels.pixel(0, 0);
        let inked = |x: u32, y: u32| self.pixels.pixel(x, y) != blank;
        let row = |y: &u32| (0..width).any(|x| inked(x, *y));
        let (Some(top), Some(bottom)) = ((0..height).find(row), (0..height).rfind(row)) else {
            return Ok(self.clone());
        };
        let column = |x: &u32| (top..=bottom).any(|y| inked(*x, y));
        let (Some(left), Some(right)) = ((0..width).find(column), (0..width).rfind(column)) else {
            return Ok(self.clone());
        };
        let (left, top) = (left.saturating_sub(margin), top.saturating_sub(margin));
        let (right, bottom) =
            (right.saturating_add(margin).min(width - 1), bottom.saturating_add(margin).min(height - 1));
        let mut page = Self::new(right - left + 1, bottom - top + 1, palette::PAPER)?;
        page.paste(self, -(left as i32), -(top as i32));
        Ok(page)
    }

    /// The picture as a PNG file.
    ///
    /// # Errors
    /// [`DiagramError::Encode`] with what the encoder says.
    pub fn png(&self) -> Result<Vec<u8>, DiagramError> {
        self.pixels.encode_png().map_err(|why| DiagramError::Encode { reason: why.to_string() })
    }

    /// Writes the picture as a PNG file.
    ///
    /// # Errors
    /// [`DiagramError::Encode`] or [`DiagramError::Write`] with the path.
    pub fn save(&self, path: impl AsRef<FilePath>) -> Result<(), DiagramError> {
        let path = path.as_ref();
        std::fs::write(path, self.png()?).map_err(|source| DiagramError::Write { path: path.to_owned(), source })
    }

    fn fill(&mut self, path: PathBuilder, colour: Colour) {
        if let Some(path) = path.finish() {
            self.pixels.fill_path(&path, &paint(colour), FillRule::Winding, Transform::identity(), None);
        }
    }
}

/// The parts of a chain inside `area`; a part that runs on is not begun anew, so that it is joined.
fn push_chain(path: &mut PathBuilder, chain: &[DVec2], ends: Ends, area: &Area) {
    let whole = chain.iter().all(|p| p.is_finite() && p.cmpge(area.low).all() && p.cmple(area.high).all());
    let closed = ends == Ends::Closed && chain.len() > 2;
    let count = if closed { chain.len() } else { chain.len().saturating_sub(1) };
    let mut last = None;
    for i in 0..count {
        let Some((from, to)) = clip::segment(chain[i], chain[(i + 1) % chain.len()], area) else {
            last = None;
            continue;
        };
        if last != Some(from) {
            path.move_to(from.x as f32, from.y as f32);
        }
        path.line_to(to.x as f32, to.y as f32);
        last = Some(to);
    }
    if closed && whole {
        path.close();
    }
}

/// Where a line of text begins, seen from its anchor, before it is turned.
fn offset(text: &str, style: &TextStyle) -> (f64, f64) {
    let across = match style.across {
        Across::Left => 0.0,
        Across::Middle => -0.5,
        Across::Right => -1.0,
    };
    let down = match style.down {
        Down::Top => 1.0,
        Down::Middle => 0.5,
        Down::Baseline => 0.0,
    };
    (across * text_width(text, style.size), down * font::cap_height() * style.size)
}

fn round_rectangle(low: DVec2, high: DVec2, radius: f64) -> PathBuilder {
    // The control point that brings a cubic within 0.03% of a quarter circle.
    const QUARTER: f64 = 0.552_284_749_8;
    let mut path = PathBuilder::new();
    // Clockwise on the page: each corner, and the directions towards and away from it.
    let sides = [
        (DVec2::new(high.x, low.y), DVec2::X, DVec2::Y),
        (high, DVec2::Y, -DVec2::X),
        (DVec2::new(low.x, high.y), -DVec2::X, -DVec2::Y),
        (low, -DVec2::Y, DVec2::X),
    ];
    path.move_to((low.x + radius) as f32, low.y as f32);
    for (corner, towards, away) in sides {
        let (start, end) = (corner - radius * towards, corner + radius * away);
        let (a, b) = (start + QUARTER * radius * towards, end - QUARTER * radius * away);
        path.line_to(start.x as f32, start.y as f32);
        path.cubic_to(a.x as f32, a.y as f32, b.x as f32, b.y as f32, end.x as f32, end.y as f32);
    }
    path.close();
    path
}

fn skia_colour(colour: Colour) -> Color {
    let [red, green, blue] = colour.rgb;
    Color::from_rgba8(red, green, blue, colour.alpha)
}

fn paint(colour: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(skia_colour(colour));
    paint.anti_alias = true;
    paint
}
