//! Where there is room for a label among lines and other labels.

use glam::DVec2;

use super::canvas::{Across, Canvas, Down, TextStyle, text_width};
use super::clip::Area;
use super::colour::palette;

/// Where labels cannot stand: on lines, and on other labels.
#[derive(Default)]
pub(super) struct Labels {
    /// Places along lines, a few pixels apart, and the number of their line.
    points: Vec<(usize, DVec2)>,
    /// Boxes of labels.
    taken: Vec<Area>,
}

impl Labels {
    /// Nothing stands on line number `line` but its own label.
    pub fn keep_clear(&mut self, line: usize, corners: &[DVec2]) {
        const STEPS: u32 = 48;
        for pair in corners.windows(2) {
            let between = (0..STEPS).map(|i| pair[0].lerp(pair[1], f64::from(i) / f64::from(STEPS)));
            self.points.extend(between.map(|point| (line, point)));
        }
        self.points.extend(corners.last().map(|&point| (line, point)));
    }

    /// Nothing else stands in this box.
    pub fn take(&mut self, area: Area) {
        self.taken.push(area);
    }

    /// How crowded a box is: places of lines other than `own` in it, and labels, which count for more.
    pub fn crowd(&self, area: &Area, own: Option<usize>) -> usize {
        const LABEL: usize = 1000;
        let inside = |point: DVec2| point.cmpge(area.low).all() && point.cmple(area.high).all();
        let points = self.points.iter().filter(|&&(line, point)| Some(line) != own && inside(point)).count();
        let overlaps = |other: &&Area| other.low.cmple(area.high).all() && other.high.cmpge(area.low).all();
        points + LABEL * self.taken.iter().filter(overlaps).count()
    }

    /// Writes along line number `line`, from `a` to `b`, on the side and at the place inside `plot`
    /// where there is most room; `text` pixels an em.
    pub fn write_beside(
        &mut self,
        (line, a, b): (usize, DVec2, DVec2),
        label: &str,
        text: f64,
        plot: &Area,
        canvas: &mut Canvas,
    ) {
        const OUTSIDE: usize = 5000;
        let along = (b - a).normalize_or(DVec2::X);
        // Up on the page.
        let aside = DVec2::new(along.y, -along.x);
        let half = DVec2::new(0.5 * text_width(label, text), 0.55 * text);
        // The box around the turned label.
        let reach = half.x * along.abs() + half.y * aside.abs();
        let places = [0.5, 0.35, 0.65, 0.2, 0.8].into_iter().flat_map(|part| [(part, 1.0), (part, -1.0)]);
        let around = |(part, side): (f64, f64)| {
            let at = a.lerp(b, part) + 0.9 * text * side * aside;
            Area { low: at - reach, high: at + reach }
        };
        let inside = |area: &Area| area.low.cmpge(plot.low).all() && area.high.cmple(plot.high).all();
        let crowd = |area: &Area| self.crowd(area, Some(line)) + if inside(area) { 0 } else { OUTSIDE };
        let Some(area) = places.map(around).min_by_key(crowd) else { return };
        self.take(area);
        let style = TextStyle::new(text, palette::SLATE)
            .anchored(Across::Middle, Down::Middle)
            .rotated(-along.y.atan2(along.x).to_degrees())
            .with_halo(palette::PAPER, 0.15 * text);
        canvas.text(label, 0.5 * (area.low + area.high), &style);
    }
}

#[cfg(test)]
mod tests {
    use super::super::colour::Colour;
    use super::*;

    const PLOT: Area = Area { low: DVec2::ZERO, high: DVec2::new(400.0, 300.0) };

    #[test]
    fn a_label_moves_to_the_side_where_nothing_stands() {
        let (a, b) = (DVec2::new(50.0, 150.0), DVec2::new(350.0, 150.0));
        for busy in [130.0, 170.0] {
            let mut labels = Labels::default();
            labels.keep_clear(0, &[a.with_y(busy), b.with_y(busy)]);
            let mut canvas = Canvas::new(400, 300, Colour::hex(0xff_ff_ff)).expect("a small page");
            labels.write_beside((1, a, b), "ratio 4.87", 20.0, &PLOT, &mut canvas);
            let middle = 0.5 * (labels.taken[0].low + labels.taken[0].high);
            assert_eq!(middle.y > 150.0, busy < 150.0, "at {middle}");
        }
    }

    #[test]
    fn two_labels_of_one_line_do_not_overlap() {
        let (a, b) = (DVec2::new(50.0, 150.0), DVec2::new(350.0, 150.0));
        let mut labels = Labels::default();
        let mut canvas = Canvas::new(400, 300, Colour::hex(0xff_ff_ff)).expect("a small page");
        labels.write_beside((0, a, b), "ratio 4", 20.0, &PLOT, &mut canvas);
        let first = labels.taken[0];
        assert_eq!(Labels { taken: vec![first], points: Vec::new() }.crowd(&first, None), 1000);
        labels.write_beside((0, a, b), "ratio 5", 20.0, &PLOT, &mut canvas);
        assert_eq!(Labels { taken: vec![first], points: Vec::new() }.crowd(&labels.taken[1], None), 0);
    }
}
