//! The error ladder: how a length falls from level to level, on a logarithmic axis.

use glam::DVec2;

use super::canvas::{Across, Canvas, Down, Ends, Stroke, TextStyle, text_width};
use super::colour::{Colour, palette};
use super::error::DiagramError;
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
        let axes = Axes::new(self)?;
        self.draw_grid(&axes, &mut canvas);
        let mut labels = Labels::default();
        self.series.iter().for_each(|series| labels.keep_clear(&axes.place_all(&series.points)));
        self.draw_legend(&axes, &mut labels, &mut canvas);
        self.draw_guides(&axes, &mut labels, &mut canvas);
        for (i, series) in self.series.iter().enumerate() {
            draw_series(series, Look::of(i), &axes, &mut canvas);
        }
        Ok(canvas)
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

    /// The legend stands in the corner that has the fewest points; a ladder leaves it the upper right.
    fn draw_legend(&self, axes: &Axes, labels: &mut Labels, canvas: &mut Canvas) {
        let text = axes.text;
        let named: Vec<(usize, &Series)> = self.series.iter().enumerate().filter(|(_, s)| !s.name.is_empty()).collect();
        if named.is_empty() {
            return;
        }
        let (sample, line) = (2.2 * text, 1.55 * text);
        let widest = named.iter().map(|(_, series)| text_width(&series.name, text)).fold(0.0, f64::max);
        let size = DVec2::new(sample + 0.7 * text + widest + 1.2 * text, line * named.len() as f64 + 0.9 * text);
        let inset = DVec2::splat(0.7 * text);
        let (left, top) = (axes.low + inset, axes.high - inset - size);
        let corners = [DVec2::new(top.x, left.y), DVec2::new(left.x, top.y), left, top];
        let crowd = |corner: &DVec2| labels.crowd(*corner, *corner + size);
        let Some(corner) = corners.into_iter().min_by_key(crowd) else { return };
        canvas.round_rectangle(corner, corner + size, 0.3 * text, palette::PAPER);
        labels.taken.push((corner, corner + size));
        for (row, (i, series)) in named.into_iter().enumerate() {
            let y = corner.y + 0.45 * text + line * (row as f64 + 0.5);
            let (from, to) = (DVec2::new(corner.x + 0.6 * text, y), DVec2::new(corner.x + 0.6 * text + sample, y));
            let look = Look::of(i);
            canvas.line(from, to, &look.stroke(axes.pixel));
            look.mark(0.5 * (from + to), axes.pixel, canvas);
            let at = DVec2::new(to.x + 0.7 * text, y);
            let style = TextStyle::new(text, palette::INK).anchored(Across::Left, Down::Middle);
            canvas.text(&series.name, at, &style);
        }
    }

    fn draw_guides(&self, axes: &Axes, labels: &mut Labels, canvas: &mut Canvas) {
        for guide in &self.guides {
            let (from_level, value) = guide.from;
            let end = value.log10() - (guide.to - from_level) * guide.ratio.log10();
            let line = [(from_level, value.log10()), (guide.to, end)].map(|(x, y)| DVec2::new(axes.x(x), axes.y(y)));
            let Some((a, b)) = axes.clip(line[0], line[1]) else { continue };
            let (a, b) = if a.x <= b.x { (a, b) } else { (b, a) };
            let dash = Stroke::new(palette::SLATE, 2.0 * axes.pixel).dashed(8.0 * axes.pixel, 6.0 * axes.pixel);
            canvas.line(a, b, &dash);
            let ratio = || format!("ratio {}", units::brief(guide.ratio, 3));
            let label = if guide.label.is_empty() { ratio() } else { guide.label.clone() };
            labels.beside(a, b, &label, axes, canvas);
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
    fn new(ladder: &Ladder) -> Result<Self, DiagramError> {
        let shown = ladder
            .series
            .iter()
            .flat_map(|series| &series.points)
            .filter(|(level, value)| level.is_finite() && level.abs() < 1e9 && value.is_finite() && *value > 0.0);
        let start = (f64::INFINITY, f64::NEG_INFINITY);
        let ((left, right), (least, most)) = shown.fold((start, start), |(l, v), &(level, value)| {
            ((l.0.min(level), l.1.max(level)), (v.0.min(value), v.1.max(value)))
        });
        if left > right {
            return Err(DiagramError::Nothing { what: "no series has a positive value" });
        }
        let (width, height) = (f64::from(ladder.width), f64::from(ladder.height));
        let text = (width.min(1.35 * height) / 46.0).max(1.0);
        let (bottom, mut top) = (least.log10().floor() as i32, most.log10().ceil() as i32);
        top = top.max(bottom + 1);
        let widest = (bottom..=top).map(|power| text_width(&ladder.quantity.decade(power), text)).fold(0.0, f64::max);
        let head = if ladder.title.is_empty() { 1.5 } else { 3.4 };
        let low = DVec2::new(widest + 3.4 * text, head * text);
        let high = DVec2::new(width - 1.6 * text, height - 4.0 * text).max(low + 1.0);
        // Half a level of room on both sides; a single level lies in the middle.
        let levels = if left < right {
            let room = 0.035 * (right - left);
            (left - room, right + room)
        } else {
            (left - 0.5, right + 0.5)
        };
        let fit = ((high.y - low.y) / (1.5 * text)).max(1.0) as i32;
        let stride = (top - bottom) / fit + 1;
        let (ticks, places) = units::round_steps(left, right, 20);
        let whole = left.fract() == 0.0 && right.fract() == 0.0 && right - left <= 20.0;
        let (ticks, places) = match whole {
            true => ((left as i64..=right as i64).map(|level| level as f64).collect(), 0),
            false if ticks.is_empty() => (vec![left], 2),
            false => (ticks, places),
        };
        Ok(Self {
            low,
            high,
            levels,
            powers: (bottom, top),
            stride,
            ticks,
            places,
            text,
            pixel: (text / 24.0).max(1.0),
        })
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

    /// The part of a line inside the plot.
    fn clip(&self, a: DVec2, b: DVec2) -> Option<(DVec2, DVec2)> {
        super::clip::segment(a, b, &super::clip::Area { low: self.low, high: self.high })
    }
}

/// Where labels could not stand: on points, and on other labels.
#[derive(Default)]
struct Labels {
    /// Places along the lines of all series, a few pixels apart.
    points: Vec<DVec2>,
    /// Boxes of labels: upper left and lower right corners.
    taken: Vec<(DVec2, DVec2)>,
}

impl Labels {
    fn keep_clear(&mut self, line: &[DVec2]) {
        const STEPS: u32 = 48;
        for pair in line.windows(2) {
            self.points.extend((0..STEPS).map(|i| pair[0].lerp(pair[1], f64::from(i) / f64::from(STEPS))));
        }
        self.points.extend(line.last());
    }

    /// How many places and labels lie in a box.
    fn crowd(&self, low: DVec2, high: DVec2) -> usize {
        let inside = |point: &&DVec2| point.cmpge(low).all() && point.cmple(high).all();
        let overlapping = |taken: &&(DVec2, DVec2)| taken.0.cmple(high).all() && taken.1.cmpge(low).all();
        self.points.iter().filter(inside).count() + 1000 * self.taken.iter().filter(overlapping).count()
    }

    /// Writes along a line, on the side and at the place where there is most room.
    fn beside(&mut self, a: DVec2, b: DVec2, label: &str, axes: &Axes, canvas: &mut Canvas) {
        let along = (b - a).normalize_or(DVec2::X);
        // Up on the page.
        let aside = DVec2::new(along.y, -along.x);
        let half = DVec2::new(0.5 * text_width(label, axes.text), 0.5 * axes.text);
        let reach = DVec2::new(
            half.x * along.x.abs() + half.y * along.y.abs(),
            half.x * along.y.abs() + half.y * along.x.abs(),
        );
        let mut best = None;
        for part in [0.5, 0.35, 0.65, 0.2, 0.8] {
            for side in [1.0, -1.0] {
                let at = a.lerp(b, part) + 0.85 * axes.text * side * aside;
                let (low, high) = (at - reach, at + reach);
                let off_plot = !(low.cmpge(axes.low).all() && high.cmple(axes.high).all());
                let crowd = self.crowd(low, high) + 5000 * usize::from(off_plot);
                if best.is_none_or(|(least, _)| crowd < least) {
                    best = Some((crowd, at));
                }
            }
        }
        let Some((_, at)) = best else { return };
        self.taken.push((at - reach, at + reach));
        let style = TextStyle::new(0.92 * axes.text, palette::SLATE)
            .anchored(Across::Middle, Down::Middle)
            .rotated(-along.y.atan2(along.x).to_degrees())
            .with_halo(palette::PAPER, 0.15 * axes.text);
        canvas.text(label, at, &style);
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
