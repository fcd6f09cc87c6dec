//! Numbers to colours.

use super::colour::{Colour, decode, palette};
use super::error::DiagramError;
use super::units::Quantity;

/// A way from one colour to another along which equal steps look equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ColourMap {
    /// Dark violet over teal to yellow; lightness rises evenly. For magnitudes.
    /// [van der Walt, Smith 2015, "A better default colormap for Matplotlib"; CC0], every tenth.
    Viridis,
    /// Blue over grey to red; lightest in the middle. For what has a sign.
    /// [Moreland 2009, "Diverging color maps for scientific visualization"], every eighth.
    CoolWarm,
}

const VIRIDIS: [u32; 11] = [
    0x44_01_54, 0x48_24_75, 0x41_44_87, 0x35_5f_8d, 0x2a_78_8e, 0x21_91_8c, 0x22_a8_84, 0x44_bf_70, 0x7a_d1_51,
    0xbd_df_26, 0xfd_e7_25,
];

const COOL_WARM: [u32; 9] =
    [0x3b_4c_c0, 0x62_82_ea, 0x8d_b0_fe, 0xb8_d0_f9, 0xdd_dd_dd, 0xf5_c4_ad, 0xf4_9a_7b, 0xde_60_4d, 0xb4_04_26];

impl ColourMap {
    /// The colour at `t`, clamped to [0, 1], as linear light; NaN has the colour of what is missing.
    ///
    /// Between the entries of the table it is interpolated in sRGB code, in which the tables were
    /// made: code is close to what looks even, light is not.
    pub fn at(self, t: f64) -> [f32; 3] {
        if t.is_nan() {
            return palette::MISSING.to_linear();
        }
        let table: &[u32] = match self {
            Self::Viridis => &VIRIDIS,
            Self::CoolWarm => &COOL_WARM,
        };
        let along = t.clamp(0.0, 1.0) * (table.len() - 1) as f64;
        let before = (along as usize).min(table.len() - 2);
        let part = (along - before as f64) as f32;
        let [from, to] = [before, before + 1].map(|i| Colour::hex(table[i]).rgb.map(f32::from));
        // Eight bits of code are finer than the eye, and `decode` of them is a table for the caller.
        [0, 1, 2].map(|i| decode((from[i] + part * (to[i] - from[i])).round() as u8))
    }
}

/// How numbers are spread over a colour map or an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spacing {
    /// Equal differences are equally far apart.
    Linear,
    /// Equal ratios are equally far apart; the numbers are positive.
    Logarithmic,
}

/// What a colour stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourScale {
    low: f64,
    high: f64,
    /// The colours.
    pub map: ColourMap,
    /// How numbers are spread over them.
    pub spacing: Spacing,
    /// What the numbers stand for.
    pub quantity: Quantity,
    /// The words above the colour bar, before the unit; may be empty.
    pub title: String,
}

const ENDS: &str = "the ends are finite and ascend";
const POSITIVE: &str = "the ends of a logarithmic scale are positive";

impl ColourScale {
    /// Viridis from `low` to `high`, evenly spaced lengths.
    ///
    /// # Errors
    /// [`DiagramError::Range`] unless `low < high`, both and their difference finite.
    pub fn new(low: f64, high: f64) -> Result<Self, DiagramError> {
        if !(low < high && (high - low).is_finite()) {
            return Err(DiagramError::Range { low, high, rule: ENDS });
        }
        let (map, spacing) = (ColourMap::Viridis, Spacing::Linear);
        Ok(Self { low, high, map, spacing, quantity: Quantity::Length, title: String::new() })
    }

    /// The scale from the smallest to the largest of the finite `values`. Where they are all the
    /// same, it reaches from zero to them; where they are all zero, to one.
    ///
    /// # Errors
    /// [`DiagramError::Nothing`] if no value is finite; [`DiagramError::Range`] if they lie too far
    /// apart for an `f64`.
    pub fn of(values: &[f64]) -> Result<Self, DiagramError> {
        let finite = values.iter().copied().filter(|value| value.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return Err(DiagramError::Nothing { what: "no value is finite" });
        }
        match (low < high, low == 0.0) {
            (true, _) => Self::new(low, high),
            (false, true) => Self::new(0.0, 1.0),
            (false, false) => Self::new(low.min(0.0), high.max(0.0)),
        }
    }

    /// The diverging scale about zero that holds all finite `values`.
    ///
    /// # Errors
    /// As [`ColourScale::of`].
    pub fn about_zero(values: &[f64]) -> Result<Self, DiagramError> {
        let all = Self::of(values)?;
        let most = all.low.abs().max(all.high.abs());
        Ok(Self { map: ColourMap::CoolWarm, ..Self::new(-most, most)? })
    }

    /// The same scale, its numbers spread by their logarithms.
    ///
    /// # Errors
    /// [`DiagramError::Range`] if an end is not positive.
    pub fn logarithmic(self) -> Result<Self, DiagramError> {
        if self.low <= 0.0 {
            return Err(DiagramError::Range { low: self.low, high: self.high, rule: POSITIVE });
        }
        Ok(Self { spacing: Spacing::Logarithmic, ..self })
    }

    /// The same scale with words above its bar.
    #[must_use]
    pub fn titled(self, title: impl Into<String>) -> Self {
        Self { title: title.into(), ..self }
    }

    /// The same scale for numbers of another quantity.
    #[must_use]
    pub fn in_units(self, quantity: Quantity) -> Self {
        Self { quantity, ..self }
    }

    /// The number that has the first colour.
    pub fn low(&self) -> f64 {
        self.low
    }

    /// The number that has the last colour.
    pub fn high(&self) -> f64 {
        self.high
    }

    /// How far along the scale a number lies: 0 at its low end, 1 at its high end, beyond them
    /// outside; NaN stays NaN, and so does what has no logarithm.
    pub fn along(&self, value: f64) -> f64 {
        match self.spacing {
            Spacing::Linear => (value - self.low) / (self.high - self.low),
            // Spelt out, for the ends are then exactly 0 and 1.
            Spacing::Logarithmic if value > 0.0 => (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln()),
            Spacing::Logarithmic if value == 0.0 => f64::NEG_INFINITY,
            Spacing::Logarithmic => f64::NAN,
        }
    }

    /// The colour of a number, as linear light; ends hold beyond the range.
    pub fn colour(&self, value: f64) -> [f32; 3] {
        self.map.at(self.along(value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness over its range 0 to 100.
    fn lightness(linear: [f32; 3]) -> f32 {
        let y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2];
        116.0 * y.cbrt() - 16.0
    }

    #[test]
    fn viridis_grows_lighter_at_an_even_pace() {
        let steps: Vec<f32> = (0..=10).map(|i| lightness(ColourMap::Viridis.at(f64::from(i) / 10.0))).collect();
        for pair in steps.windows(2) {
            assert!((5.0..9.5).contains(&(pair[1] - pair[0])), "{steps:?}");
        }
    }

    #[test]
    fn cool_warm_is_lightest_in_the_middle_and_balanced() {
        let at = |t: f64| lightness(ColourMap::CoolWarm.at(t));
        for i in 1..=4 {
            let t = 0.125 * f64::from(i);
            assert!(at(0.5 - t) < at(0.5 - t + 0.125) && at(0.5 + t) < at(0.5 + t - 0.125));
            assert!((at(0.5 - t) - at(0.5 + t)).abs() < 8.0, "unbalanced at {t}");
        }
    }

    #[test]
    fn ends_hold_beyond_the_range_and_nan_is_grey() {
        let scale = ColourScale::new(1.0, 2.0).expect("an ascending range");
        assert_eq!(scale.colour(-5.0), scale.colour(1.0));
        assert_eq!(scale.colour(f64::INFINITY), scale.colour(2.0));
        assert_eq!(scale.colour(f64::NAN), palette::MISSING.to_linear());
    }

    #[test]
    fn a_scale_of_values_reaches_from_end_to_end_and_skips_what_is_not_finite() {
        let scale = ColourScale::of(&[3.0, f64::NAN, -1.0, f64::INFINITY]).expect("two are finite");
        assert_eq!((scale.low(), scale.high()), (-1.0, 3.0));
        assert_eq!((scale.along(-1.0), scale.along(3.0)), (0.0, 1.0));
        let log = ColourScale::new(1e-9, 1e-3).and_then(ColourScale::logarithmic).expect("positive ends");
        assert_eq!((log.along(1e-9), log.along(1e-3)), (0.0, 1.0));
        assert!((log.along(1e-6) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_range_that_is_none_is_refused() {
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (-f64::MAX, f64::MAX)] {
            assert!(matches!(ColourScale::new(low, high), Err(DiagramError::Range { .. })), "{low} {high}");
        }
        assert!(matches!(ColourScale::of(&[f64::NAN]), Err(DiagramError::Nothing { .. })));
        assert!(ColourScale::new(0.0, 1.0).expect("ascends").logarithmic().is_err());
        for flat in [0.0, 2.5, -2.5] {
            assert!(ColourScale::of(&[flat, flat]).is_ok());
        }
    }
}
