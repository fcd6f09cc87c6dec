//! The colour bar beside a pseudo-coloured picture.

use glam::DVec2;

use super::canvas::{Across, Canvas, Down, Ends, Stroke, TextStyle, text_width};
use super::colour::{Colour, palette};
use super::colourmap::{ColourScale, Spacing};
use super::error::DiagramError;
use super::units::{self, Unit};

/// A number beside a colour bar.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// The number, in the units of the scale's ends.
    pub value: f64,
    /// Where on the bar: 0 at its low end, 1 at its high end.
    pub along: f64,
    /// What is written there, in the unit of the bar.
    pub label: String,
}

/// The ticks of a bar of which at most `most` find room: both ends of the scale, and between them
/// round numbers (or decades) that stay clear of the ends.
pub fn ticks(scale: &ColourScale, most: usize) -> Vec<Tick> {
    let most = most.max(2);
    let (ends, between) = match scale.spacing {
        Spacing::Linear => linear_ticks(scale, most - 1),
        Spacing::Logarithmic => decade_ticks(scale, most - 1),
    };
    let tick = |(value, label)| Tick { value, along: scale.along(value), label };
    let [first, last] = ends.map(tick);
    // Closer to an end than most of a tick's share, two labels would touch.
    let clear = 0.7 / most as f64;
    let kept = between.into_iter().map(tick).filter(|tick| tick.along > clear && tick.along < 1.0 - clear);
    core::iter::once(first).chain(kept).chain([last]).collect()
}

/// A number and what is written for it.
type Labelled = (f64, String);

/// The ends with as many places as give the larger three digits, and round numbers between them.
fn linear_ticks(scale: &ColourScale, most: usize) -> ([Labelled; 2], Vec<Labelled>) {
    let unit = bar_unit(scale);
    let (low, high) = (scale.low() / unit.worth, scale.high() / unit.worth);
    // Two more digits than the span needs tell a narrow range's ends apart.
    let digits = |size: f64, count: i32| (count - 1 - size.log10().floor() as i32).clamp(0, 15) as usize;
    let mut places = digits(low.abs().max(high.abs()), 3).max(digits(high - low, 2));
    while places > 0 && [low, high].iter().all(|end| units::fixed(*end, places).ends_with('0')) {
        places -= 1;
    }
    let (steps, step_places) = units::round_steps(low, high, most);
    // Whole but for the rounding of the unit.
    let whole = |value: f64| (value - value.round()).abs() <= 4.0 * f64::EPSILON * value.abs();
    let written = |value: f64| units::fixed(value, if whole(value) { 0 } else { places });
    let step_places = if steps.iter().copied().all(whole) { 0 } else { step_places };
    let between = steps.into_iter().map(|step| (step * unit.worth, units::fixed(step, step_places)));
    ([(scale.low(), written(low)), (scale.high(), written(high))], between.collect())
}

/// The ends and powers of ten between them, each with its own unit, for they lie far apart.
fn decade_ticks(scale: &ColourScale, most: usize) -> ([Labelled; 2], Vec<Labelled>) {
    let label = |value: f64, digits: usize| {
        let unit = scale.quantity.unit(value);
        format!("{} {}", units::brief(value / unit.worth, digits), unit.symbol).trim_end().to_owned()
    };
    let (first, last) = (scale.low().log10().ceil() as i32, scale.high().log10().floor() as i32);
    // Every decade, or every second, third and so on.
    let stride = ((last - first).max(0) as usize / most) + 1;
    let powers = (first..=last).step_by(stride).map(|power| 10.0_f64.powi(power));
    let between = powers.map(|value| (value, label(value, 1))).collect();
    ([scale.low(), scale.high()].map(|end| (end, label(end, 3))), between)
}

/// One unit for the whole bar: that of its larger end. A logarithmic bar has one at each tick.
fn bar_unit(scale: &ColourScale) -> Unit {
    match scale.spacing {
        Spacing::Linear => scale.quantity.unit(scale.low().abs().max(scale.high().abs())),
        Spacing::Logarithmic => Unit { worth: 1.0, symbol: "" },
    }
}

/// What stands above the bar: its title and its unit.
fn heading(scale: &ColourScale) -> String {
    let symbol = bar_unit(scale).symbol;
    match (scale.title.is_empty(), symbol.is_empty()) {
        (true, _) => symbol.to_owned(),
        (false, true) => scale.title.clone(),
        (false, false) => format!("{} [{symbol}]", scale.title),
    }
}

/// The picture with the colour bar of `scale` to its right, `text` pixels an em.
///
/// # Errors
/// [`DiagramError::Size`] if the picture grows too wide.
pub fn with_colour_bar(picture: &Canvas, scale: &ColourScale, text: f64) -> Result<Canvas, DiagramError> {
    let text = if text.is_finite() { text.clamp(4.0, 200.0) } else { 20.0 };
    let (width, height) = (f64::from(picture.width()), f64::from(picture.height()));
    let length = (height - 6.0 * text).min(0.72 * height).max(0.25 * height);
    // A tick each three ems leaves the eye room between labels.
    let ticks = ticks(scale, (length / (3.2 * text)) as usize);
    let heading = heading(scale);
    // Bars with labels of usual lengths are equally wide, so that pictures in a column stay in line.
    let usual = text_width("100 nm", text);
    let widest = ticks.iter().map(|tick| text_width(&tick.label, text)).fold(usual, f64::max);
    let needed = (1.7 * text + widest).max(text_width(&heading, text)) + 1.2 * text;
    let mut page = Canvas::new(picture.width() + needed.ceil() as u32, picture.height(), ground(picture))?;
    page.paste(picture, 0, 0);
    let low = DVec2::new(width + 0.5 * text, 0.5 * (height - length)).round();
    let bar = Bar { low, high: (low + DVec2::new(0.9 * text, length)).round(), text };
    bar.draw_colours(scale, &mut page);
    bar.draw_ticks(&ticks, &mut page);
    page.text(&heading, DVec2::new(bar.low.x, bar.low.y - 1.2 * text), &TextStyle::new(text, palette::INK));
    Ok(page)
}

/// The bar itself, in pixels.
struct Bar {
    /// Its upper left corner.
    low: DVec2,
    /// Its lower right corner.
    high: DVec2,
    /// Pixels an em.
    text: f64,
}

impl Bar {
    fn draw_colours(&self, scale: &ColourScale, page: &mut Canvas) {
        let (low, high) = (self.low, self.high);
        for y in low.y as i64..high.y as i64 {
            let y = y as f64;
            let along = 1.0 - (y + 0.5 - low.y) / (high.y - low.y);
            let colour = Colour::from_linear(scale.map.at(along));
            page.rectangle(DVec2::new(low.x, y), DVec2::new(high.x, y + 1.0), colour);
        }
        let frame = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        page.polyline(&frame, Ends::Closed, &self.hair());
    }

    fn draw_ticks(&self, ticks: &[Tick], page: &mut Canvas) {
        let style = TextStyle::new(self.text, palette::INK).anchored(Across::Left, Down::Middle);
        for tick in ticks {
            let from = DVec2::new(self.high.x, self.high.y - tick.along * (self.high.y - self.low.y));
            let to = from + DVec2::new(0.35 * self.text, 0.0);
            page.line(from, to, &self.hair());
            page.text(&tick.label, to + DVec2::new(0.3 * self.text, 0.0), &style);
        }
    }

    fn hair(&self) -> Stroke {
        Stroke::new(palette::INK, (self.text / 14.0).max(1.0))
    }
}

/// The ground of a picture: the colour of its upper left corner.
fn ground(picture: &Canvas) -> Colour {
    let [red, green, blue] = picture.pixel(0, 0).unwrap_or(palette::PAPER.rgb);
    Colour { rgb: [red, green, blue], alpha: 255 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(low: f64, high: f64) -> ColourScale {
        ColourScale::new(low, high).expect("an ascending range")
    }

    #[test]
    fn both_extremes_are_ticks_and_labelled_in_the_unit_of_the_bar() {
        let bar = ticks(&scale(0.0, 1.85e-5), 6);
        let (first, last) = (&bar[0], &bar[bar.len() - 1]);
        assert_eq!((first.value, first.along, first.label.as_str()), (0.0, 0.0, "0"));
        assert_eq!((last.value, last.along, last.label.as_str()), (1.85e-5, 1.0, "18.5"));
        assert_eq!(heading(&scale(0.0, 1.85e-5).titled("distance")), "distance [µm]");
    }

    /// An end that is next to nothing beside the other does not flaunt digits.
    #[test]
    fn both_ends_are_written_to_the_same_place() {
        let labels = |low, high| ticks(&scale(low, high), 2).into_iter().map(|tick| tick.label).collect::<Vec<_>>();
        assert_eq!(labels(8.39e-9, 2.54e-5), ["0.0", "25.4"]);
        assert_eq!(labels(0.0, 2.5e-5), ["0", "25"]);
        assert_eq!(labels(-3.2e-3, 3.2e-3), ["−3.2", "0", "3.2"]);
        assert_eq!(labels(0.013, 0.0131), ["13", "13.1"]);
    }

    #[test]
    fn ticks_ascend_and_stay_apart() {
        for (low, high) in [(0.0, 1.0), (-2e-6, 2e-6), (0.013, 0.0131), (1e-12, 9.7e-12), (-7.0, 300.0)] {
            for most in 2..12 {
                let bar = ticks(&scale(low, high), most);
                assert!(bar.len() <= most + 1);
                let apart = 0.7 / most as f64;
                assert!(
                    bar.windows(2).all(|pair| pair[1].along - pair[0].along > apart),
                    "{low} {high} {most}: {bar:?}"
                );
            }
        }
    }

    #[test]
    fn decades_are_ticks_of_a_logarithmic_bar() {
        let log = scale(2e-9, 5e-4).logarithmic().expect("positive ends");
        let labels: Vec<String> = ticks(&log, 8).into_iter().map(|tick| tick.label).collect();
        assert_eq!(labels, ["2 nm", "10 nm", "100 nm", "1 µm", "10 µm", "100 µm", "500 µm"]);
    }
}
