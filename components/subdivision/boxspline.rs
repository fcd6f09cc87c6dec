//! The quartic box spline: what the Loop scheme converges to where every vertex is regular.
//!
//! In the lattice whose steps are `s`, `t` and `s - t` a face is the triangle A = (0, 0), B = (1, 0),
//! C = (0, 1). Twelve control points shape it, the face's own and all that share a face with one:
//!
//! ```text
//!           11 --- 10                 (-1,2)  (0,2)
//!          /  \   /  \
//!         5 --- 2 --- 4          (-1,1)   C    (1,1)
//!        / \   / \   /  \
//!       6 --- 0 --- 1 --- 9    (-1,0)   A    B    (2,0)
//!        \   / \   / \   /
//!          7 --- 3 --- 8           (0,-1) (1,-1) (2,-1)
//! ```
//!
//! So [`Net`] lists the corners, then the far corner of the neighbour across edge `i` (from corner
//! `i` to `i + 1`), then for each corner the two points left in its ring, counter-clockwise: the
//! list of the net turned by one corner is the list with each group turned by one.

use core::ops::{Add, Mul, Sub};

use glam::DVec3;

use crate::evaluate::Jet;

/// What control points are made of: vectors of any width that can be added and scaled.
///
/// [`DVec3`] in general; a SIMD vector where many patches are made at once.
pub trait Vector: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl Vector for DVec3 {}

/// The twelve control points of a regular face, in the order of the module's picture.
pub type Net<V = DVec3> = [V; 12];

/// The exponents `(a, b)` of the monomials `s^a t^b` that a [`Quartic`] stores, in its order.
/// `s^2 t^2` is missing: no box spline on this lattice has it.
pub const EXPONENTS: [(i32, i32); 14] =
    [(0, 0), (1, 0), (2, 0), (3, 0), (4, 0), (0, 1), (1, 1), (2, 1), (3, 1), (0, 2), (1, 2), (0, 3), (1, 3), (0, 4)];

/// One regular face of a Loop surface as a polynomial of degree four in (s, t).
///
/// Power coefficients, in the order of [`EXPONENTS`]. On the unit triangle they lose nothing that
/// matters: all are sums of second differences of neighbouring control points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quartic<V = DVec3> {
    /// The coefficient of each monomial of [`EXPONENTS`], in model units.
    pub coefficients: [V; 14],
}

impl<V: Vector> Quartic<V> {
    /// The polynomial of the face with these control points.
    ///
    /// Twelve times the surface is written in second differences along `s` (`x`), `t` (`y`) and
    /// `s - t` (`z`): expanding the box spline's twelve basis functions [Stam 1998, Appendix] and
    /// collecting them by powers leaves only these.
    #[inline(always)]
    pub fn new(net: &Net<V>) -> Self {
        let [a, b, c, ab, bc, ca, a1, a2, b1, b2, c1, c2] = *net;
        let (xa, xb, xc, xd) = (second(a1, a, b), second(a, b, b2), second(ca, c, bc), second(a2, ab, b1));
        let (ya, yb, yc, yd) = (second(a2, a, c), second(ab, b, bc), second(a, c, c1), second(a1, ca, c2));
        let za = second(ab, a, ca);
        let (u, v, w) = (b - a1, c - a2, ab - ca);
        let s4 = ((xa + xb) - (xc + xd)) * (1.0 / 12.0);
        let t4 = ((ya + yc) - (yb + yd)) * (1.0 / 12.0);
        Self {
            coefficients: [
                a + (xa + ya + za) * (1.0 / 12.0),
                (u + u + v + w) * (1.0 / 6.0),
                xa * 0.5,
                (xc + xd - (xa + xa)) * (1.0 / 6.0),
                s4,
                (u + v + v - w) * (1.0 / 6.0),
                (xa + ya - za) * 0.5,
                (xc - xa) * 0.5,
                s4 + s4,
                ya * 0.5,
                (yb - ya) * 0.5,
                (yb + yd - (ya + ya)) * (1.0 / 6.0),
                t4 + t4,
                t4,
            ],
        }
    }

    /// The point at `(s, t)`.
    #[inline(always)]
    pub fn position(&self, s: f64, t: f64) -> V {
        horner_position(&self.coefficients, s, t)
    }

    /// The point and its derivatives by `s` and `t` at `(s, t)`.
    #[inline(always)]
    pub fn with_derivatives(&self, s: f64, t: f64) -> [V; 3] {
        horner_jet(&self.coefficients, s, t)
    }
}

impl Quartic {
    /// The point and its first derivatives at `(s, t)`.
    #[inline(always)]
    pub fn jet(&self, s: f64, t: f64) -> Jet {
        let [position, ds, dt] = self.with_derivatives(s, t);
        Jet { position, ds, dt }
    }

    /// The second derivatives at `(s, t)`: by `s s`, `s t` and `t t`.
    pub fn second_derivatives(&self, s: f64, t: f64) -> [DVec3; 3] {
        let mut second = [DVec3::ZERO; 3];
        for (&(a, b), &c) in EXPONENTS.iter().zip(&self.coefficients) {
            let (fa, fb) = (f64::from(a), f64::from(b));
            // A negative exponent comes with a factor of zero; raised to 0 it is no infinity at 0.
            let power = |x: f64, n: i32| x.powi(n.max(0));
            second[0] += c * (fa * (fa - 1.0) * power(s, a - 2) * power(t, b));
            second[1] += c * (fa * fb * power(s, a - 1) * power(t, b - 1));
            second[2] += c * (fb * (fb - 1.0) * power(s, a) * power(t, b - 2));
        }
        second
    }
}

/// The second difference of three points in a row.
#[inline(always)]
fn second<V: Vector>(p: V, q: V, r: V) -> V {
    (p + r) - (q + q)
}

/// What each control point of a [`Net`] weighs at `(s, t)`, and in the derivatives by `s` and `t`.
pub fn basis(s: f64, t: f64) -> [[f64; 12]; 3] {
    // Three basis functions at a time, one for each coordinate.
    let mut weights = [[0.0; 12]; 3];
    for group in 0..4 {
        let mut net = [DVec3::ZERO; 12];
        net[3 * group..3 * group + 3].copy_from_slice(&[DVec3::X, DVec3::Y, DVec3::Z]);
        let jet = Quartic::new(&net).with_derivatives(s, t);
        for (row, value) in weights.iter_mut().zip(jet) {
            row[3 * group..3 * group + 3].copy_from_slice(&value.to_array());
        }
    }
    weights
}

/// Horner's scheme for [`Quartic::position`]: one vector at one place, or one coordinate at as many
/// places as `N` is wide. The operations and their order, hence the bits, are the same.
#[inline(always)]
pub fn horner_position<T, N>(c: &[T; 14], s: N, t: N) -> T
where
    T: Copy + Add<Output = T> + Mul<N, Output = T>,
    N: Copy,
{
    let q0 = (((c[4] * s + c[3]) * s + c[2]) * s + c[1]) * s + c[0];
    let q1 = ((c[8] * s + c[7]) * s + c[6]) * s + c[5];
    let (q2, q3) = (c[10] * s + c[9], c[12] * s + c[11]);
    (((c[13] * t + q3) * t + q2) * t + q1) * t + q0
}

/// Horner's scheme for [`Quartic::jet`], as [`horner_position`]: position, derivative by `s`,
/// derivative by `t`. Each sum is differentiated as it grows: `(p s + c)' = p' s + p`.
#[inline(always)]
pub fn horner_jet<T, N>(c: &[T; 14], s: N, t: N) -> [T; 3]
where
    T: Copy + Add<Output = T> + Mul<N, Output = T>,
    N: Copy,
{
    let p3 = c[4] * s + c[3];
    let d2 = c[4] * s + p3;
    let p2 = p3 * s + c[2];
    let d1 = d2 * s + p2;
    let p1 = p2 * s + c[1];
    let (q0, d0) = (p1 * s + c[0], d1 * s + p1);

    let p2 = c[8] * s + c[7];
    let d1 = c[8] * s + p2;
    let p1 = p2 * s + c[6];
    let (q1, e0) = (p1 * s + c[5], d1 * s + p1);

    let (q2, q3, q4) = (c[10] * s + c[9], c[12] * s + c[11], c[13]);
    let ds = ((c[12] * t + c[10]) * t + e0) * t + d0;

    let p3 = q4 * t + q3;
    let d2 = q4 * t + p3;
    let p2 = p3 * t + q2;
    let d1 = d2 * t + p2;
    let p1 = p2 * t + q1;
    [p1 * t + q0, ds, d1 * t + p1]
}
