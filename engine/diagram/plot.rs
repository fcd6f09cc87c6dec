//! The error ladder: how a length falls from level to level, on a logarithmic axis.

use glam::DVec2;

use super::canvas::{Across, Canvas, Down, Ends, Stroke, TextStyle, text_width};
use super::clip::{self, Area};
use super::colour::{Colour, palette};
use super::error::DiagramError;
use super::labels::Labels;
use super::units::{self, Quantity};

/// A line of a ladder plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// (level, value). A value that is not positive and finite leaves a gap.
    pub points: Vec<(f64, f64)>,
}

impl Series {
    /// The values at levels 0, 1, 2 and so on.
    pub fn from_levels(name: impl Into<String>, values: impl IntoIterator<Item = f64>) -> Self {
        let points = values.into_iter().enumerate().map(|(level, value)| (level as f64, value)).collect();
        Self { name: name.into(), points }
    }
}

/// A straight line that shows what falling by a ratio at each level looks like.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    /// By what the value falls from one level to the next.
    pub ratio: f64,
    /// Where it begins: a level and the value there.
    pub from: (f64, f64),
    /// The level where it ends.
    pub to: f64,
    /// What stands beside it; `ratio 4.87` if empty.
    pub label: String,
}

impl Guide {
    /// From `from` (a level and the value there) to level `to`.
    pub const fn new(ratio: f64, from: (f64, f64), to: f64) -> Self {
        Self { ratio, from, to, label: String::new() }
    }
}

/// A plot of errors over levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    /// Above the plot; may be empty.
    pub title: String,
    /// What the levels are called.
    pub level_label: String,
    /// What the values are called.
    pub value_label: String,
    /// What the values are.
    pub quantity: Quantity,
    /// Its lines.
    pub series: Vec<Series>,
    /// Straight lines to compare with.
    pub guides: Vec<Guide>,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
}

impl Default for Ladder {
    fn default() -> Self {
        Self {
            title: String::new(),
            level_label: "level".into(),
            value_label: "maximal error".into(),
            quantity: Quantity::Length,
            series: Vec::new(),
            guides: Vec::new(),
            width: 1200,
            height: 900,
        }
    }
}

impl Ladder {
    /// The picture.
    ///
    /// # Errors
    /// [`DiagramError::Nothing`] if no series has a positive finite value at a finite level,
    /// [`DiagramError::Size`].
    pub fn draw(&self) -> Result<Canvas, DiagramError> {
        let mut canvas = Canvas::new(self.width, self.height, palette::PAPER)?;
        let (axes, legend) = self.make_room()?;
        self.draw_grid(&axes, &mut canvas);
        if let Some(corner) = legend {
            self.draw_legend(corner, &axes, &mut canvas);
        }
        self.draw_guides(&axes, legend, &mut canvas);
        for (i, series) in self.series.iter().enumerate() {
            draw_series(series, Look::of(i), &axes, &mut canvas);
        }
        Ok(canvas)
    }

    /// Axes, and the corner where the legend covers nothing: decades are added above the highest
    /// value until there is one. A ladder leaves it the upper right.
    fn make_room(&self) -> Result<(Axes, Option<DVec2>), DiagramError> {
        const MOST_ADDED: i32 = 6;
        let mut first = None;
        for added in 0..=MOST_ADDED {
            let axes = Axes::new(self, added)?;
            let (crowd, corner) = self.legend_corner(&axes);
            if crowd == 0 {
                return Ok((axes, corner));
            }
            first.get_or_insert((axes, corner));
        }
        first.ok_or(DiagramError::Nothing { what: "no room for axes" })
    }

    /// The corner with the fewest points, and how many these are; none without names.
    fn legend_corner(&self, axes: &Axes) -> (usize, Option<DVec2>) {
        if self.named().next().is_none() {
            return (0, None);
        }
        let labels = self.lines(axes);
        let size = self.legend_size(axes.text);
        let inset = DVec2::splat(0.7 * axes.text);
        let (left, top) = (axes.low + inset, axes.high - inset - size);
        let corners = [DVec2::new(top.x, left.y), DVec2::new(left.x, top.y), left, top];
        let around = DVec2::splat(0.5 * axes.text);
        let area = |corner: DVec2| Area { low: corner - around, high: corner + size + around };
        let crowd = |corner: DVec2| labels.crowd(&area(corner), None);
        let best = corners.into_iter().map(|corner| (crowd(corner), corner)).min_by_key(|(crowd, _)| *crowd);
        best.map_or((0, None), |(crowd, corner)| (crowd, Some(corner)))
    }

    /// All lines, guides first, that labels should not stand on.
    fn lines(&self, axes: &Axes) -> Labels {
        let mut labels = Labels::default();
        for (i, guide) in self.guides.iter().enumerate() {
            axes.guide(guide).into_iter().for_each(|(a, b)| labels.keep_clear(i, &[a, b]));
        }
        for (i, series) in self.series.iter().enumerate() {
            labels.keep_clear(self.guides.len() + i, &axes.place_all(&series.points));
        }
        labels
    }

    fn named(&self) -> impl Iterator<Item = (usize, &Series)> {
        self.series.iter().enumerate().filter(|(_, series)| !series.name.is_empty())
    }

    fn legend_size(&self, text: f64) -> DVec2 {
        let widest = self.named().map(|(_, series)| text_width(&series.name, text)).fold(0.0, f64::max);
        DVec2::new(4.1 * text + widest, text * (1.55 * self.named().count() as f64 + 0.9))
    }

    fn draw_grid(&self, axes: &Axes, canvas: &mut Canvas) {
        let (low, high, text) = (axes.low, axes.high, axes.text);
        let small = TextStyle::new(text, palette::INK);
        let fine = Stroke::new(palette::MIST, axes.pixel);
        for power in axes.powers.0..=axes.powers.1 {
            let y = axes.y(f64::from(power)).round() + 0.5 * axes.pixel;
            canvas.line(DVec2::new(low.x, y), DVec2::new(high.x, y), &fine);
            if (power - axes.powers.1) % axes.stride == 0 {
                let label = self.quantity.decade(power);
                let at = DVec2::new(low.x - 0.6 * text, y);
                canvas.text(&label, at, &small.anchored(Across::Right, Down::Middle));
            }
        }
        for &level in &axes.ticks {
            let x = axes.x(level).round() + 0.5 * axes.pixel;
            canvas.line(DVec2::new(x, low.y), DVec2::new(x, high.y), &fine);
            let at = DVec2::new(x, high.y + 0.6 * text);
            canvas.text(&units::fixed(level, axes.places), at, &small.anchored(Across::Middle, Down::Top));
        }
        let axis = Stroke::new(palette::SLATE, 1.5 * axes.pixel);
        canvas.polyline(&[low, DVec2::new(low.x, high.y), high], Ends::Open, &axis);
        let middle = 0.5 * (low + high);
        let below = DVec2::new(middle.x, high.y + 2.6 * text);
        canvas.text(&self.level_label, below, &small.anchored(Across::Middle, Down::Middle));
        let left = DVec2::new(1.1 * text, middle.y);
        canvas.text(&self.value_label, left, &small.anchored(Across::Middle, Down::Middle).rotated(90.0));
        let above = DVec2::new(low.x, low.y - 1.3 * text);
        canvas.text(&self.title, above, &TextStyle::new(1.12 * text, palette::INK));
    }

    fn draw_legend(&self, corner: DVec2, axes: &Axes, canvas: &mut Canvas) {
        let text = axes.text;
        canvas.round_rectangle(corner, corner + self.legend_size(text), 0.3 * text, palette::PAPER);
        for (row, (i, series)) in self.named().enumerate() {
            let y = corner.y + text * (0.45 + 1.55 * (row as f64 + 0.5));
            let [from, to, name] = [0.6, 2.8, 3.5].map(|across| DVec2::new(corner.x + across * text, y));
            let look = Look::of(i);
            canvas.line(from, to, &look.stroke(axes.pixel));
            look.mark(0.5 * (from + to), axes.pixel, canvas);
            let style = TextStyle::new(text, palette::INK).anchored(Across::Left, Down::Middle);
            canvas.text(&series.name, name, &style);
        }
    }

    fn draw_guides(&self, axes: &Axes, legend: Option<DVec2>, canvas: &mut Canvas) {
        let mut labels = self.lines(axes);
        if let Some(low) = legend {
            labels.take(Area { low, high: low + self.legend_size(axes.text) });
        }
        let dash = Stroke::new(palette::SLATE, 2.0 * axes.pixel).dashed(8.0 * axes.pixel, 6.0 * axes.pixel);
        let lines: Vec<_> = self.guides.iter().map(|guide| axes.guide(guide)).collect();
        lines.iter().flatten().for_each(|&(a, b)| canvas.line(a, b, &dash));
        for (i, (guide, line)) in self.guides.iter().zip(lines).enumerate() {
            let Some((a, b)) = line else { continue };
            let ratio = || format!("ratio {}", units::brief(guide.ratio, 3));
            let label = if guide.label.is_empty() { ratio() } else { guide.label.clone() };
            labels.write_beside((i, a, b), &label, 0.92 * axes.text, &axes.area(), canvas);
        }
    }
}

fn draw_series(series: &Series, look: Look, axes: &Axes, canvas: &mut Canvas) {
    let shown = |&(level, value): &(f64, f64)| level.is_finite() && value.is_finite() && value > 0.0;
    for run in series.points.split(|point| !shown(point)) {
        let places = axes.place_all(run);
        canvas.polyline(&places, Ends::Open, &look.stroke(axes.pixel));
        for place in places {
            look.mark(place, axes.pixel, canvas);
        }
    }
}

/// Where levels and values lie on the picture.
struct Axes {
    /// The upper left corner of the plot itself.
    low: DVec2,
    /// The lower right corner.
    high: DVec2,
    levels: (f64, f64),
    /// Powers of ten at the bottom and at the top.
    powers: (i32, i32),
    /// Each how many decades there is a label.
    stride: i32,
    /// Levels with a label, and places after their points.
    ticks: Vec<f64>,
    places: usize,
    /// Pixels an em.
    text: f64,
    /// The width of a fine line.
    pixel: f64,
}

impl Axes {
    /// Axes that hold everything shown, and so many decades more above it.
    fn new(ladder: &Ladder, added: i32) -> Result<Self, DiagramError> {
        let ((left, right), (least, most)) = shown(ladder)?;
        let (width, height) = (f64::from(ladder.width), f64::from(ladder.height));
        let text = (width.min(1.35 * height) / 46.0).max(1.0);
        let bottom = least.log10().floor() as i32;
        let top = (most.log10().ceil() as i32).max(bottom + 1) + added;
        let widest = (bottom..=top).map(|power| text_width(&ladder.quantity.decade(power), text)).fold(0.0, f64::max);
        let head = if ladder.title.is_empty() { 1.5 } else { 3.4 };
        let low = DVec2::new(widest + 3.4 * text, head * text);
        let high = DVec2::new(width - 1.6 * text, height - 4.0 * text).max(low + 1.0);
        // Room on both sides; a single level lies in the middle.
        let room = if left < right { 0.035 * (right - left) } else { 0.5 };
        let fit = ((high.y - low.y) / (1.5 * text)).max(1.0) as i32;
        let (ticks, places) = level_ticks(left, right);
        Ok(Self {
            low,
            high,
            levels: (left - room, right + room),
            powers: (bottom, top),
            stride: (top - bottom) / fit + 1,
            ticks,
            places,
            text,
            pixel: (text / 24.0).max(1.0),
        })
    }

    /// The part of a guide inside the plot, from left to right.
    fn guide(&self, guide: &Guide) -> Option<(DVec2, DVec2)> {
        let (level, value) = guide.from;
        let end = value.log10() - (guide.to - level) * guide.ratio.log10();
        let ends = [(level, value.log10()), (guide.to, end)].map(|(x, y)| DVec2::new(self.x(x), self.y(y)));
        clip::segment(ends[0], ends[1], &self.area()).map(|(a, b)| if a.x <= b.x { (a, b) } else { (b, a) })
    }

    fn area(&self) -> Area {
        Area { low: self.low, high: self.high }
    }

    fn x(&self, level: f64) -> f64 {
        self.low.x + (level - self.levels.0) / (self.levels.1 - self.levels.0) * (self.high.x - self.low.x)
    }

    fn y(&self, log: f64) -> f64 {
        let (bottom, top) = (f64::from(self.powers.0), f64::from(self.powers.1));
        self.high.y - (log - bottom) / (top - bottom) * (self.high.y - self.low.y)
    }

    fn place_all(&self, points: &[(f64, f64)]) -> Vec<DVec2> {
        let places = points.iter().map(|&(level, value)| DVec2::new(self.x(level), self.y(value.log10())));
        places.filter(|place| place.is_finite()).collect()
    }
}

/// The least and the greatest level, and value, of what can be shown.
type Extent = ((f64, f64), (f64, f64));

fn shown(ladder: &Ladder) -> Result<Extent, DiagramError> {
    // Beyond a thousand million, levels could not be told apart.
    let can_be = |&&(level, value): &&(f64, f64)| level.abs() < 1e9 && value.is_finite() && value > 0.0;
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    let wider = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
    let points = ladder.series.iter().flat_map(|series| &series.points).filter(can_be);
    let extent = points.fold((start, start), |(l, v), &(level, value)| (wider(l, level), wider(v, value)));
    if extent.0.0 > extent.0.1 {
        return Err(DiagramError::Nothing { what: "no series has a positive value" });
    }
    Ok(extent)
}

/// Levels with a label, and places after their points: each whole level, where there are few.
fn level_ticks(left: f64, right: f64) -> (Vec<f64>, usize) {
    const MOST: f64 = 20.0;
    if left.fract() == 0.0 && right.fract() == 0.0 && right - left <= MOST {
        return ((left as i64..=right as i64).map(|level| level as f64).collect(), 0);
    }
    match units::round_steps(left, right, MOST as usize) {
        (ticks, _) if ticks.is_empty() => (vec![left], 2),
        ticks => ticks,
    }
}

/// The colour and mark of a series.
#[derive(Clone, Copy)]
struct Look {
    colour: Colour,
    mark: usize,
}

impl Look {
    fn of(series: usize) -> Self {
        Self { colour: palette::SERIES[series % palette::SERIES.len()], mark: series }
    }

    fn stroke(self, pixel: f64) -> Stroke {
        Stroke::new(self.colour, 3.0 * pixel)
    }

    /// A disc, square, triangle, diamond or ring: series differ without their colours, too.
    fn mark(self, at: DVec2, pixel: f64, canvas: &mut Canvas) {
        let radius = 6.5 * pixel;
        let rim = radius + 2.0 * pixel;
        let turned = |count: u32, turn: f64, radius: f64| -> Vec<DVec2> {
            let corner = |i| DVec2::from_angle(turn + core::f64::consts::TAU * f64::from(i) / f64::from(count));
            (0..count).map(|i| at + radius * corner(i)).collect()
        };
        let quarter = core::f64::consts::FRAC_PI_4;
        // Corners reach farther than a disc of the same look.
        let (corners, turn, grow) = match self.mark % 5 {
            1 => (4, quarter, 1.2),
            2 => (3, -2.0 * quarter, 1.35),
            3 => (4, 0.0, 1.3),
            _ => (0, 0.0, 1.0),
        };
        if corners == 0 {
            canvas.disc(at, rim, palette::PAPER);
            canvas.disc(at, radius, self.colour);
            if self.mark % 5 == 4 {
                canvas.disc(at, 0.5 * radius, palette::PAPER);
            }
        } else {
            canvas.polygon(&turned(corners, turn, rim * grow), palette::PAPER);
            canvas.polygon(&turned(corners, turn, radius * grow), self.colour);
        }
    }
}
