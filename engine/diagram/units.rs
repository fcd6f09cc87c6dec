//! Numbers on axes and in captions: round steps, SI prefixes, powers of ten.

/// What a number on an axis stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A length in metres, shown in nm, µm, mm, m or whichever prefix fits.
    Length,
    /// A number with its own unit, or an empty label for none.
    Plain(&'static str),
}

/// A unit chosen for a range of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What one of it is worth.
    pub worth: f64,
    /// Its symbol, such as `µm`; empty for a bare number.
    pub symbol: &'static str,
}

/// Units of length by the power of a thousand, from the femtometre on.
const LENGTHS: [(i32, &str); 7] = [(-15, "fm"), (-12, "pm"), (-9, "nm"), (-6, "µm"), (-3, "mm"), (0, "m"), (3, "km")];

impl Quantity {
    /// The unit in which `largest` (an absolute value) has one to three digits before the point.
    pub fn unit(self, largest: f64) -> Unit {
        match self {
            Self::Length => {
                let largest = largest.abs();
                // A number that would be rounded to 1000 takes the next unit.
                let fits = |&&(power, _): &&(i32, &str)| largest < 999.5 * 10.0_f64.powi(power);
                let (power, symbol) = match LENGTHS.iter().find(fits) {
                    Some(found) if largest > 0.0 => *found,
                    _ if largest > 0.0 => LENGTHS[LENGTHS.len() - 1],
                    _ => (0, "m"),
                };
                Unit { worth: 10.0_f64.powi(power), symbol }
            }
            Self::Plain(symbol) => Unit { worth: 1.0, symbol },
        }
    }

    /// `value` with `digits` significant digits and its unit: `18.5 µm`.
    pub fn label(self, value: f64, digits: usize) -> String {
        let unit = self.unit(value);
        let number = significant(value / unit.worth, digits);
        if unit.symbol.is_empty() { number } else { format!("{number} {}", unit.symbol) }
    }

    /// A power of ten as it stands at a decade of an axis: `10 µm`, or `10⁻⁵` for a bare number.
    pub fn decade(self, power: i32) -> String {
        let value = 10.0_f64.powi(power);
        match self {
            Self::Length if (-15..6).contains(&power) => self.label(value, 1),
            Self::Length => format!("{} m", power_of_ten(power)),
            Self::Plain("") => power_of_ten(power),
            Self::Plain(symbol) => format!("{} {symbol}", power_of_ten(power)),
        }
    }
}

/// `10` with a superscript.
pub fn power_of_ten(power: i32) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |character: char| character.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    "10".chars().chain(power.to_string().chars().map(raise)).collect()
}

/// A number with so many significant digits: without an exponent where at most five zeros are
/// needed, with a true minus sign.
pub fn significant(value: f64, digits: usize) -> String {
    if value == 0.0 {
        return "0".into();
    }
    if !value.is_finite() {
        return if value.is_nan() { "–".into() } else { signed(value, "∞".into()) };
    }
    let digits = digits.clamp(1, 17);
    // Rounded first, for rounding may carry: 9.996 with three digits is 10.0.
    let rounded = format!("{:.*e}", digits - 1, value.abs());
    let (mantissa, power) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let power: i32 = power.parse().unwrap_or(0);
    let plain = if (-5..=5).contains(&power) {
        let places = (digits as i32 - 1 - power).max(0) as usize;
        format!("{:.places$}", value.abs())
    } else {
        format!("{mantissa}×{}", power_of_ten(power))
    };
    signed(value, plain)
}

/// As [`significant`], without the zeros that end a number after its point: `4`, not `4.00`.
pub fn brief(value: f64, digits: usize) -> String {
    let full = significant(value, digits);
    match full.split_once('×') {
        Some((mantissa, power)) => format!("{}×{power}", without_zeros(mantissa)),
        None => without_zeros(&full).to_owned(),
    }
}

fn without_zeros(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// A number with so many places after the point, with a true minus sign.
pub fn fixed(value: f64, places: usize) -> String {
    let plain = format!("{:.places$}", value.abs());
    // What is rounded to zero has no sign.
    if plain.bytes().all(|byte| matches!(byte, b'0' | b'.')) { plain } else { signed(value, plain) }
}

fn signed(value: f64, plain: String) -> String {
    if value < 0.0 { format!("−{plain}") } else { plain }
}

/// A fraction of small whole numbers, such as `3/8`, where `value` is one to the last digits of an
/// `f64`; otherwise four places.
pub fn fraction(value: f64) -> String {
    // Masks have denominators up to 32, and 6 and 12 times such, and powers of two where a cosine
    // is rational; sums of them stay within a few units in the last place of 1.
    const MOST: u32 = 96;
    const POWERS: [u32; 4] = [128, 256, 512, 1024];
    const ROUNDING: f64 = 8.0 * f64::EPSILON;
    for below in (1..=MOST).chain(POWERS) {
        let above = value * f64::from(below);
        if (above - above.round()).abs() <= ROUNDING * f64::from(below) {
            let whole = fixed(above, 0);
            return if below == 1 { whole } else { format!("{whole}/{below}") };
        }
    }
    fixed(value, 4)
}

/// At most `most` round numbers (1, 2 or 5 times a power of ten apart) inside [low, high], ascending
/// [Heckbert 1990, "Nice numbers for graph labels"], and the places they need after the point.
pub fn round_steps(low: f64, high: f64, most: usize) -> (Vec<f64>, usize) {
    let span = high - low;
    if !(span > 0.0 && span.is_finite()) || most == 0 {
        return (Vec::new(), 0);
    }
    let mut power = (span / most as f64).log10().floor() as i32;
    let mut factors = [1, 2, 5].into_iter().cycle();
    loop {
        let factor = factors.next().unwrap_or(1);
        let step = f64::from(factor) * 10.0_f64.powi(power);
        // An end that is a step but for its rounding counts as one.
        let slack = 1e-9;
        let (first, last) = ((low / step - slack).ceil(), (high / step + slack).floor());
        if !(first.is_finite() && last.is_finite()) {
            return (Vec::new(), 0);
        }
        if last - first < most as f64 {
            let count = (last - first + 1.0).max(0.0) as usize;
            let places = (-power).clamp(0, 17) as usize;
            return ((0..count).map(|i| (first + i as f64) * step).collect(), places);
        }
        if factor == 5 {
            power += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_length_takes_the_unit_with_one_to_three_digits() {
        let cases = [
            (1.23e-3, "1.23 mm"),
            (1.65e-4, "165 µm"),
            (1.85e-5, "18.5 µm"),
            (1.5e-7, "150 nm"),
            (2.1e-14, "21.0 fm"),
            (0.5, "500 mm"),
            (0.0, "0 m"),
            (-0.002, "−2.00 mm"),
            (9.9996e-4, "1.00 mm"),
            (1234.0, "1.23 km"),
        ];
        for (metres, label) in cases {
            assert_eq!(Quantity::Length.label(metres, 3), label);
        }
    }

    #[test]
    fn decades_read_as_lengths_or_as_powers() {
        assert_eq!(Quantity::Length.decade(-5), "10 µm");
        assert_eq!(Quantity::Length.decade(-13), "100 fm");
        assert_eq!(Quantity::Length.decade(-16), "10⁻¹⁶ m");
        assert_eq!(Quantity::Plain("").decade(-12), "10⁻¹²");
        assert_eq!(Quantity::Plain("rad").decade(3), "10³ rad");
    }

    #[test]
    fn weights_of_the_regular_lattice_read_as_fractions() {
        let cases = [
            (0.375, "3/8"),
            (0.125, "1/8"),
            (0.625, "5/8"),
            (1.0 / 16.0, "1/16"),
            (31.0 / 256.0, "31/256"),
            (-1.0 / 12.0, "−1/12"),
            (1.5, "3/2"),
            (1.0, "1"),
            (0.0, "0"),
            (0.052_47, "0.0525"),
        ];
        for (weight, label) in cases {
            assert_eq!(fraction(weight), label);
        }
    }

    #[test]
    fn significant_digits_are_kept_through_a_carry() {
        assert_eq!(significant(9.996, 3), "10.0");
        assert_eq!(significant(0.000_012_345, 3), "0.0000123");
        assert_eq!(significant(-1.5e-9, 2), "−1.5×10⁻⁹");
        assert_eq!((brief(4.0, 3).as_str(), brief(4.87, 3).as_str(), brief(400.0, 2).as_str()), ("4", "4.87", "400"));
        assert_eq!(brief(-1.5e-9, 3), "−1.5×10⁻⁹");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(significant(f64::NEG_INFINITY, 3), "−∞");
    }

    #[test]
    fn round_steps_lie_inside_are_even_and_few() {
        for (low, high) in [(0.0, 1.0), (-3.2, 17.9), (1e-9, 7e-9), (1e6, 1.000_001e6), (-5.0, -4.0)] {
            for most in 2..12 {
                let (steps, _) = round_steps(low, high, most);
                assert!(steps.len() <= most && steps.iter().all(|s| *s >= low - 1e-9 && *s <= high + 1e-9));
                // 1, 2, 5 grow by 2.5 at most, so at least a third of the steps asked for are there.
                assert!(steps.len() * 3 >= most, "{low} {high} {most}: {steps:?}");
            }
        }
    }

    #[test]
    fn no_steps_without_a_range() {
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY), (-1e308, 1e308)] {
            assert_eq!(round_steps(low, high, 5).0, Vec::<f64>::new());
        }
    }
}
