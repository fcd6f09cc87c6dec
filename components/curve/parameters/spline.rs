//! One span of a uniform cubic B-spline of numbers: the parameters between two neighbours.

/// The span from coefficient `b` to the next, `c`, given by the differences of its four
/// coefficients `a, b, c, d`.
///
/// In differences the span keeps its digits however small they are, and an end is fixed by
/// repeating the difference inside: then the value there is the coefficient, to the bit, and the
/// second derivative vanishes. That is what an unchanged corner means to the refinement rules.
///
/// The same span from the other end (`c, b` and the differences negated and swapped) has the same
/// bits: the first half of it is evaluated from `b`, the other from `c`, the middle by a sum that
/// does not change when its terms are swapped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) b: f64,
    pub(super) c: f64,
    /// `b - a`.
    pub(super) before: f64,
    /// `c - b`.
    pub(super) gap: f64,
    /// `d - c`.
    pub(super) after: f64,
}

impl Span {
    /// The spline at the share `s` of the way, `step = 0`; or the coefficient that stands there
    /// once the coefficients are `step` apart, `step = 2^-level`.
    ///
    /// The coefficients of a cubic spline at distance `h` are its blossom `(s - h, s, s + h)`,
    /// which is `u(s) - h^2 u''(s) / 6`. [Ramshaw 1989]
    pub(super) fn value(&self, s: f64, step: f64) -> f64 {
        let third = (self.after - self.gap) + (self.before - self.gap);
        if s == 0.5 {
            let (mean, bend) = (0.5 * (self.b + self.c), self.after - self.before);
            return mean + bend * (1.0 - 4.0 * step * step) / 48.0;
        }
        // The same polynomial seen from the nearer end: `bend` is the second difference there.
        let (origin, bend, s, direction) = if s < 0.5 {
            (self.b, self.gap - self.before, s, 1.0)
        } else {
            (self.c, self.gap - self.after, 1.0 - s, -1.0)
        };
        let slope = self.gap - 0.5 * bend;
        let square = step * step;
        let rise = bend * (1.0 - square) / 6.0 + s * (slope + s * (0.5 * bend)) + s * third * (s * s - square) / 6.0;
        origin + direction * rise
    }

    /// The derivative of the spline by the share `s`.
    pub(super) fn rate(&self, s: f64) -> f64 {
        let (bend, third) = (self.gap - self.before, (self.after - self.gap) + (self.before - self.gap));
        (self.gap - 0.5 * bend) + s * (bend + s * (0.5 * third))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::curve::testing::config;

    fn span([a, b, c, d]: [f64; 4]) -> Span {
        Span { b, c, before: b - a, gap: c - b, after: d - c }
    }

    /// The basis of a uniform cubic B-spline, as every textbook has it.
    fn by_basis([a, b, c, d]: [f64; 4], s: f64) -> f64 {
        let t = 1.0 - s;
        (t * t * t * a
            + (3.0 * s * s * s - 6.0 * s * s + 4.0) * b
            + (3.0 * t * t * t - 6.0 * t * t + 4.0) * c
            + s * s * s * d)
            / 6.0
    }

    fn four() -> impl Strategy<Value = [f64; 4]> {
        prop::array::uniform4(0.0..1.0)
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn it_is_the_cubic_spline(u in four(), s in 0.0..=1.0) {
            prop_assert!((span(u).value(s, 0.0) - by_basis(u, s)).abs() < 1e-15);
        }

        #[test]
        fn the_rate_is_the_derivative(u in four(), s in 0.01..0.99) {
            // A central difference of a cubic is off by h^2 / 6 of its third derivative.
            let h = 1e-4;
            let central = (span(u).value(s + h, 0.0) - span(u).value(s - h, 0.0)) / (2.0 * h);
            let third = (u[3] - u[0]) - 3.0 * (u[2] - u[1]);
            prop_assert!((span(u).rate(s) - central + third * h * h / 6.0).abs() < 1e-11);
        }

        #[test]
        fn both_directions_have_the_same_bits(u in four(), k in 0_u32..=4096, level in 0_i32..24) {
            let s = f64::from(k) / 4096.0;
            let step = 0.5_f64.powi(level);
            let [a, b, c, d] = u;
            for step in [0.0, step] {
                let (there, back) = (span(u).value(s, step), span([d, c, b, a]).value(1.0 - s, step));
                prop_assert_eq!(there.to_bits(), back.to_bits());
            }
        }

        /// `u' = ((u_{i-1} + u_{i+1}) + 6 u_i) / 8` at a vertex, `(u_i + u_{i+1}) / 2` on an edge,
        /// and the limit `((u_{i-1} + u_{i+1}) + 4 u_i) / 6`: the closed form is the rules.
        #[test]
        fn one_step_is_the_refinement_rule(u in four()) {
            let [a, b, c, d] = u;
            prop_assert_eq!(span(u).value(0.0, 1.0).to_bits(), b.to_bits());
            prop_assert_eq!(span(u).value(1.0, 1.0).to_bits(), c.to_bits());
            prop_assert!((span(u).value(0.0, 0.5) - ((a + c) + 6.0 * b) / 8.0).abs() < 4e-16);
            prop_assert_eq!(span(u).value(0.5, 0.5), (b + c) / 2.0);
            prop_assert!((span(u).value(0.0, 0.0) - ((a + c) + 4.0 * b) / 6.0).abs() < 4e-16);
            prop_assert!((span(u).value(1.0, 0.0) - ((b + d) + 4.0 * c) / 6.0).abs() < 4e-16);
        }
    }
}
