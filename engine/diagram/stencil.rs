//! Stencils: a small piece of a mesh in the plane, with the weight that each vertex has.

use core::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec2;

use super::canvas::{Across, Canvas, Down, Ends, MOST_SIDE, Stroke, TextStyle, text_width};
use super::colour::{Colour, palette};
use super::error::DiagramError;
use super::grid::{Cell, Grid};

/// A vertex of a stencil.
#[derive(Clone, Debug, PartialEq)]
pub struct Knot {
    /// Where it lies: edges are about one long, y up.
    pub at: DVec2,
    /// Its weight, such as `3/8`; without one it is a plain vertex.
    pub label: String,
}

/// A piece of a mesh and the weights of its vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Stencil {
    /// Its vertices.
    pub knots: Vec<Knot>,
    /// Three vertices each, in any direction.
    pub triangles: Vec<[u32; 3]>,
    /// The edges that lie on the border of the surface, drawn thick.
    pub border: Vec<[u32; 2]>,
    /// Where the result lies; on a vertex, its label is set off.
    pub result: DVec2,
    /// What stands below it.
    pub caption: String,
}

impl Stencil {
    /// A vertex and the ring about it. `ring` has the labels of the neighbours, from the top
    /// counter-clockwise, three or more.
    pub fn ring(centre: impl Into<String>, ring: &[String], caption: impl Into<String>) -> Self {
        let count = ring.len();
        let angle = |i: usize| FRAC_PI_2 + TAU * i as f64 / count as f64;
        let mut stencil = Self::fan(centre.into(), ring, angle, caption.into());
        stencil.triangles.extend((count > 2).then_some([0, count as u32, 1]));
        stencil
    }

    /// The same weight for each of the neighbours of a vertex.
    pub fn even_ring(valence: usize, centre: &str, neighbour: &str, caption: impl Into<String>) -> Self {
        Self::ring(centre, &vec![neighbour.to_owned(); valence], caption)
    }

    /// A vertex of the border and its neighbours, from the right counter-clockwise over an `angle` in
    /// degrees: 180 at a smooth border, less or more at a corner. The first and the last neighbour
    /// lie on the border.
    pub fn half_ring(centre: impl Into<String>, neighbours: &[String], angle: f64, caption: impl Into<String>) -> Self {
        let last = neighbours.len().saturating_sub(1).max(1) as f64;
        // About the upward direction, so that corners of all angles stand upright.
        let start = FRAC_PI_2 - 0.5 * angle.to_radians();
        let place = |i: usize| start + angle.to_radians() * i as f64 / last;
        let mut stencil = Self::fan(centre.into(), neighbours, place, caption.into());
        if let Ok(count @ 1..) = u32::try_from(neighbours.len()) {
            stencil.border = vec![[0, 1], [0, count]];
        }
        stencil
    }

    /// The two triangles at an edge: its ends left and right, the vertices across it below and above.
    pub fn edge(ends: [&str; 2], across: [&str; 2], caption: impl Into<String>) -> Self {
        let high = 0.75_f64.sqrt();
        let places = [DVec2::new(-0.5, 0.0), DVec2::new(0.5, 0.0), DVec2::new(0.0, -high), DVec2::new(0.0, high)];
        let labels = [ends[0], ends[1], across[0], across[1]];
        let knot = |(at, label): (DVec2, &str)| Knot { at, label: label.to_owned() };
        Self {
            knots: places.into_iter().zip(labels).map(knot).collect(),
            triangles: vec![[0, 2, 1], [0, 1, 3]],
            border: Vec::new(),
            result: DVec2::ZERO,
            caption: caption.into(),
        }
    }

    /// Vertices of the regular lattice of triangles: each at `column` steps to the right and `row`
    /// steps to the upper right, with its label. Triangles with all three vertices present are drawn,
    /// and edges of row zero are the border if `border` says so.
    pub fn lattice(
        labels: &[(i32, i32, &str)],
        result: (i32, i32),
        border: LatticeBorder,
        caption: impl Into<String>,
    ) -> Self {
        let place = |column: i32, row: i32| {
            let (column, row) = (f64::from(column), f64::from(row));
            DVec2::new(column + 0.5 * row, 0.75_f64.sqrt() * row)
        };
        let find = |column: i32, row: i32| {
            labels.iter().position(|&(c, r, _)| (c, r) == (column, row)).map(|found| found as u32)
        };
        let mut triangles = Vec::new();
        let mut edges = Vec::new();
        for (here, &(c, r, _)) in (0_u32..).zip(labels) {
            let (right, left) = (find(c.saturating_add(1), r), find(c.saturating_sub(1), r.saturating_add(1)));
            let up = find(c, r.saturating_add(1));
            // The triangle that stands on the edge to the right, and the one that hangs from above.
            triangles.extend(right.zip(up).map(|(right, up)| [here, right, up]));
            triangles.extend(up.zip(left).map(|(up, left)| [here, up, left]));
            if border == LatticeBorder::RowZero && r == 0 {
                edges.extend(right.map(|right| [here, right]));
            }
        }
        let knots: Vec<Knot> =
            labels.iter().map(|&(c, r, label)| Knot { at: place(c, r), label: label.to_owned() }).collect();
        let result = place(result.0, result.1);
        Self { knots, triangles, border: edges, result, caption: caption.into() }
    }

    /// The centre is knot 0, its neighbours follow; triangles between each and the next.
    fn fan(centre: String, ring: &[String], angle: impl Fn(usize) -> f64, caption: String) -> Self {
        let around = ring.iter().enumerate();
        let neighbours = around.map(|(i, label)| Knot { at: DVec2::from_angle(angle(i)), label: label.clone() });
        Self {
            knots: core::iter::once(Knot { at: DVec2::ZERO, label: centre }).chain(neighbours).collect(),
            triangles: (1..ring.len() as u32).map(|i| [0, i, i + 1]).collect(),
            border: Vec::new(),
            result: DVec2::ZERO,
            caption,
        }
    }

    /// The picture, `width` pixels across and as high as it needs to be, with labels as large as they
    /// may be without touching. Where even small labels would touch, some are left out for a dot.
    ///
    /// # Errors
    /// [`DiagramError::IndexOutOfRange`], [`DiagramError::NotFinite`], [`DiagramError::Nothing`]
    /// without vertices, [`DiagramError::Size`].
    pub fn draw(&self, width: u32) -> Result<Canvas, DiagramError> {
        self.check()?;
        self.draw_with(width, self.text_that_fits(width))
    }

    /// Every index is in range and every place finite.
    fn check(&self) -> Result<(), DiagramError> {
        let count = self.knots.len();
        if count == 0 {
            return Err(DiagramError::Nothing { what: "a stencil without vertices" });
        }
        let places = self.knots.iter().map(|knot| knot.at).chain([self.result]);
        if let Some((vertex, at)) = places.enumerate().find(|(_, at)| !at.is_finite()) {
            return Err(DiagramError::NotFinite { what: "a stencil", vertex, at: at.extend(0.0) });
        }
        let corners =
            self.triangles.iter().map(<[u32; 3]>::as_slice).chain(self.border.iter().map(<[u32; 2]>::as_slice));
        for (triangle, corners) in corners.enumerate() {
            if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= count) {
                return Err(DiagramError::IndexOutOfRange { triangle, vertex, count });
            }
        }
        Ok(())
    }

    /// The largest text with which no two labels touch, down to where it would not be legible.
    fn text_that_fits(&self, width: u32) -> f64 {
        let width = f64::from(width.min(MOST_SIDE));
        let (mut text, least) = (width / 13.0, width / 36.0);
        while text > least && self.labels_that_fit(width, text).contains(&false) {
            text *= 0.96;
        }
        text
    }

    /// Which vertices have a label that touches none before it.
    fn labels_that_fit(&self, width: f64, text: f64) -> Vec<bool> {
        let page = Page::new(self, width, text);
        let mut placed: Vec<(DVec2, DVec2)> = Vec::new();
        let fits = |knot: &Knot| {
            let (at, half) = (page.at(knot.at), half_box(&knot.label, text));
            let touches =
                |&(other, other_half): &(DVec2, DVec2)| (at - other).abs().cmplt(half + other_half + 0.12 * text).all();
            let fits = knot.label.is_empty() || !placed.iter().any(touches);
            if fits && !knot.label.is_empty() {
                placed.push((at, half));
            }
            fits
        };
        self.knots.iter().map(fits).collect()
    }

    fn draw_with(&self, width: u32, text: f64) -> Result<Canvas, DiagramError> {
        let page = Page::new(self, f64::from(width), text);
        let mut canvas = Canvas::new(width, page.height, palette::PAPER)?;
        let pixel = (f64::from(width) / 400.0).max(0.5);
        self.draw_mesh(&page, pixel, &mut canvas);
        let on_knot = |knot: &Knot| knot.at.distance(self.result) < 1e-6 && !knot.label.is_empty();
        if !self.knots.iter().any(on_knot) {
            let result = page.at(self.result);
            canvas.disc(result, 9.0 * pixel, palette::PAPER);
            canvas.disc(result, 6.5 * pixel, palette::BLUE);
        }
        let fits = self.labels_that_fit(f64::from(width), text);
        for (knot, fits) in self.knots.iter().zip(fits) {
            let place = page.at(knot.at);
            if knot.label.is_empty() || !fits {
                canvas.disc(place, 3.5 * pixel, palette::SLATE);
            } else {
                let look = if on_knot(knot) { Badge::Result } else { Badge::Weight };
                look.draw(&knot.label, place, text, pixel, &mut canvas);
            }
        }
        Ok(canvas)
    }

    fn draw_mesh(&self, page: &Page, pixel: f64, canvas: &mut Canvas) {
        const GROUND: Colour = Colour::hex(0xee_f2_f6);
        let at = |vertex: u32| page.at(self.knots[vertex as usize].at);
        for triangle in &self.triangles {
            canvas.polygon(&triangle.map(at), GROUND);
        }
        let fine = Stroke::new(palette::SLATE, 1.5 * pixel);
        for triangle in &self.triangles {
            canvas.polyline(&triangle.map(at), Ends::Closed, &fine);
        }
        for edge in &self.border {
            canvas.line(at(edge[0]), at(edge[1]), &Stroke::new(palette::INK, 4.5 * pixel));
        }
    }
}

/// Is row zero of a lattice a border?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatticeBorder {
    /// The lattice goes on everywhere.
    None,
    /// Nothing lies below row zero.
    RowZero,
}

/// Several stencils as one figure, each `width` pixels across, with their captions and one size of text.
///
/// # Errors
/// As [`Stencil::draw`] and [`Grid::compose`].
pub fn draw_all(stencils: &[Stencil], columns: usize, width: u32) -> Result<Canvas, DiagramError> {
    stencils.iter().try_for_each(Stencil::check)?;
    let text = stencils.iter().map(|stencil| stencil.text_that_fits(width)).fold(f64::INFINITY, f64::min);
    let cell = |stencil: &Stencil| Ok(Cell::new(stencil.draw_with(width, text)?, stencil.caption.clone()));
    let cells = stencils.iter().map(cell).collect::<Result<Vec<_>, DiagramError>>()?;
    Grid::new(columns, f64::from(width) / 20.0).compose(&cells)
}

/// Where the plane of a stencil lies on the picture.
struct Page {
    scale: f64,
    /// Pixels down.
    height: u32,
    /// The middle of the picture, in pixels and in the plane.
    middle: DVec2,
    centre: DVec2,
}

impl Page {
    /// A ring of radius one fills the width but for room for labels; what is smaller keeps its scale,
    /// so that the edges of several stencils are alike, and what is larger is made to fit.
    fn new(stencil: &Stencil, width: f64, text: f64) -> Self {
        let widest = stencil.knots.iter().map(|knot| half_box(&knot.label, text)).fold(DVec2::ZERO, DVec2::max);
        let around = 2.0 * widest + 0.04 * width;
        let room = (width - around.x).max(0.2 * width);
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let places = stencil.knots.iter().map(|knot| knot.at).chain([stencil.result]);
        let [low, high] = places.fold(start, |[low, high], at| [low.min(at), high.max(at)]);
        let span = 0.5 * high - 0.5 * low;
        // What would be more than two pictures high is narrowed, too.
        let scale = (0.5 * room / span.x.max(1.0)).min(width / span.y.max(0.1));
        let height = (2.0 * scale * span.y + around.y).ceil().clamp(1.0, f64::from(MOST_SIDE));
        Self { scale, height: height as u32, middle: 0.5 * DVec2::new(width, height), centre: 0.5 * low + 0.5 * high }
    }

    fn at(&self, place: DVec2) -> DVec2 {
        let from_centre = self.scale * (place - self.centre);
        self.middle + DVec2::new(from_centre.x, -from_centre.y)
    }
}

/// Half the width and height of the box about a label.
fn half_box(label: &str, text: f64) -> DVec2 {
    let high = 0.72 * text;
    DVec2::new((0.5 * text_width(label, text) + 0.34 * text).max(high), high)
}

/// A label in its box.
#[derive(Clone, Copy)]
enum Badge {
    Weight,
    Result,
}

impl Badge {
    fn draw(self, label: &str, at: DVec2, text: f64, pixel: f64, canvas: &mut Canvas) {
        let (rim, fill, ink) = match self {
            Self::Weight => (palette::SLATE, palette::PAPER, palette::INK),
            Self::Result => (palette::BLUE, palette::BLUE, palette::PAPER),
        };
        let half = half_box(label, text);
        canvas.round_rectangle(at - half, at + half, half.y, rim);
        let inner = half - 1.5 * pixel;
        canvas.round_rectangle(at - inner, at + inner, inner.y, fill);
        canvas.text(label, at, &TextStyle::new(text, ink).anchored(Across::Middle, Down::Middle));
    }
}
