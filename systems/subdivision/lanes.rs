//! Many places of one polynomial at once, as wide as the machine allows.
//!
//! Widths differ between machines, results do not: every lane does the operations of
//! [`Quartic`]'s own functions in their order, and nothing is fused.
//!
//! What runs in lanes is `#[inline(always)]` down to the last operator and passes no closures: code
//! that is not inlined into the dispatched function is compiled for the least machine instead.

use core::ops::{Add, Div, Mul, Neg, Sub};

use bytemuck::{cast_slice, cast_slice_mut};
use glam::DVec3;
use pulp::{Simd, WithSimd};
use selvedge_components::evaluate::Jet;
use selvedge_components::subdivision::boxspline::{Quartic, horner_jet, horner_position};
use selvedge_components::subdivision::plain::Piece;

/// One number in every lane.
#[derive(Clone, Copy)]
struct Lanes<S: Simd> {
    simd: S,
    numbers: S::f64s,
}

macro_rules! operator {
    ($trait:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self { simd: self.simd, numbers: self.simd.$simd(self.numbers, other.numbers) }
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { simd: self.simd, numbers: self.simd.neg_f64s(self.numbers) }
    }
}

impl<S: Simd> Lanes<S> {
    #[inline(always)]
    fn splat(simd: S, number: f64) -> Self {
        Self { simd, numbers: simd.splat_f64s(number) }
    }

    /// `self` over `length` where that is above zero, else zero.
    #[inline(always)]
    fn over_or_zero(self, length: Self) -> Self {
        let (simd, zero) = (self.simd, self.simd.splat_f64s(0.0));
        let some = simd.greater_than_f64s(length.numbers, zero);
        Self { simd, numbers: simd.select_f64s(some, (self / length).numbers, zero) }
    }
}

/// The coefficients of each coordinate, in every lane.
type Coefficients<S> = [[Lanes<S>; 14]; 3];

#[inline(always)]
fn splat<S: Simd>(simd: S, quartic: &Quartic) -> Coefficients<S> {
    let mut lanes = [[Lanes::splat(simd, 0.0); 14]; 3];
    for (axis, lanes) in lanes.iter_mut().enumerate() {
        for (lanes, c) in lanes.iter_mut().zip(&quartic.coefficients) {
            *lanes = Lanes::splat(simd, c[axis]);
        }
    }
    lanes
}

/// What is computed at each place: `N` numbers.
trait Kernel<const N: usize> {
    fn at<S: Simd>(&self, c: &Coefficients<S>, s: Lanes<S>, t: Lanes<S>) -> [Lanes<S>; N];
}

/// Three numbers at each `(s, t)`, written as a vector each.
#[inline(always)]
fn write_vectors<S: Simd>(
    simd: S,
    kernel: &impl Kernel<3>,
    quartic: &Quartic,
    (s, t): (&[f64], &[f64]),
    out: &mut [DVec3],
) {
    let c = splat(simd, quartic);
    let ((s, s_rest), (t, t_rest)) = (S::as_simd_f64s(s), S::as_simd_f64s(t));
    let (out, out_rest) = out.split_at_mut(s.len() * S::F64_LANES);
    let (out, _) = S::as_mut_simd_f64s(cast_slice_mut(out));
    for ((&s, &t), out) in s.iter().zip(t).zip(out.as_chunks_mut::<3>().0) {
        let [x, y, z] = kernel.at(&c, Lanes { simd, numbers: s }, Lanes { simd, numbers: t });
        *out = simd.interleave_shfl_f64s([x.numbers, y.numbers, z.numbers]);
    }
    if !s_rest.is_empty() {
        let (s, t) = (simd.partial_load_f64s(s_rest), simd.partial_load_f64s(t_rest));
        let [x, y, z] = kernel.at(&c, Lanes { simd, numbers: s }, Lanes { simd, numbers: t });
        let last = simd.interleave_shfl_f64s([x.numbers, y.numbers, z.numbers]);
        let numbers: &[f64] = cast_slice(&last);
        cast_slice_mut(out_rest).copy_from_slice(&numbers[..3 * s_rest.len()]);
    }
}

struct AtPosition;

impl Kernel<3> for AtPosition {
    #[inline(always)]
    fn at<S: Simd>(&self, [x, y, z]: &Coefficients<S>, s: Lanes<S>, t: Lanes<S>) -> [Lanes<S>; 3] {
        [horner_position(x, s, t), horner_position(y, s, t), horner_position(z, s, t)]
    }
}

struct AtNormal;

impl Kernel<3> for AtNormal {
    #[inline(always)]
    fn at<S: Simd>(&self, [x, y, z]: &Coefficients<S>, s: Lanes<S>, t: Lanes<S>) -> [Lanes<S>; 3] {
        let ([_, a, d], [_, b, e], [_, c, f]) = (horner_jet(x, s, t), horner_jet(y, s, t), horner_jet(z, s, t));
        let (x, y, z) = (b * f - c * e, c * d - a * f, a * e - b * d);
        let square = x * x + y * y + z * z;
        let length = Lanes { simd: s.simd, numbers: s.simd.sqrt_f64s(square.numbers) };
        [x.over_or_zero(length), y.over_or_zero(length), z.over_or_zero(length)]
    }
}

/// Position and derivatives by the face's coordinates.
struct AtJet {
    piece: Piece,
}

impl Kernel<9> for AtJet {
    #[inline(always)]
    fn at<S: Simd>(&self, [x, y, z]: &Coefficients<S>, s: Lanes<S>, t: Lanes<S>) -> [Lanes<S>; 9] {
        let scale = Lanes::splat(s.simd, self.piece.scale());
        let [x, a, d] = horner_jet(x, s, t);
        let [y, b, e] = horner_jet(y, s, t);
        let [z, c, f] = horner_jet(z, s, t);
        let [a, b, c, d, e, f] = [a * scale, b * scale, c * scale, d * scale, e * scale, f * scale];
        match self.piece.corner() {
            0 => [x, y, z, a, b, c, d, e, f],
            1 => [x, y, z, -d, -e, -f, a - d, b - e, c - f],
            _ => [x, y, z, d - a, e - b, f - c, -a, -b, -c],
        }
    }
}

/// Writes the point of `quartic` at each `(s, t)` to `points`; all three are equally long.
pub(super) struct Positions<'a> {
    pub quartic: &'a Quartic,
    pub s: &'a [f64],
    pub t: &'a [f64],
    pub points: &'a mut [DVec3],
}

impl WithSimd for Positions<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        write_vectors(simd, &AtPosition, self.quartic, (self.s, self.t), self.points);
    }
}

/// Writes the unit normal of `quartic` at each `(s, t)` to `normals`, zero where there is none; all
/// three are equally long.
pub(super) struct Normals<'a> {
    pub quartic: &'a Quartic,
    pub s: &'a [f64],
    pub t: &'a [f64],
    pub normals: &'a mut [DVec3],
}

impl WithSimd for Normals<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        write_vectors(simd, &AtNormal, self.quartic, (self.s, self.t), self.normals);
    }
}

/// Where a result goes.
pub(super) trait Put {
    /// Takes the result of the `index`-th place.
    fn put(&mut self, index: usize, jet: Jet);
}

/// Evaluates `quartic` at each `(s, t)` and hands position and derivatives by the face's coordinates to
/// `put`.
pub(super) struct Jets<'a, P> {
    pub quartic: &'a Quartic,
    /// Which piece of the face `quartic` covers.
    pub piece: Piece,
    pub s: &'a [f64],
    pub t: &'a [f64],
    pub put: &'a mut P,
}

impl<P: Put> WithSimd for Jets<'_, P> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let c = splat(simd, self.quartic);
        let kernel = AtJet { piece: self.piece };
        let ((s, s_rest), (t, t_rest)) = (S::as_simd_f64s(self.s), S::as_simd_f64s(self.t));
        for (i, (&s, &t)) in s.iter().zip(t).enumerate() {
            let jets = kernel.at(&c, Lanes { simd, numbers: s }, Lanes { simd, numbers: t });
            put_lanes(self.put, i * S::F64_LANES, S::F64_LANES, &jets);
        }
        if !s_rest.is_empty() {
            let (s_last, t_last) = (simd.partial_load_f64s(s_rest), simd.partial_load_f64s(t_rest));
            let jets = kernel.at(&c, Lanes { simd, numbers: s_last }, Lanes { simd, numbers: t_last });
            put_lanes(self.put, s.len() * S::F64_LANES, s_rest.len(), &jets);
        }
    }
}

#[inline(always)]
fn put_lanes<S: Simd>(put: &mut impl Put, first: usize, count: usize, jets: &[Lanes<S>; 9]) {
    let mut numbers = [[0.0; MOST_LANES]; 9];
    for (row, lanes) in numbers.iter_mut().zip(jets) {
        row[..S::F64_LANES].copy_from_slice(cast_slice(core::slice::from_ref(&lanes.numbers)));
    }
    let [x, y, z, a, b, c, d, e, f] = &numbers;
    for i in 0..count {
        let (position, ds) = (DVec3::new(x[i], y[i], z[i]), DVec3::new(a[i], b[i], c[i]));
        put.put(first + i, Jet { position, ds, dt: DVec3::new(d[i], e[i], f[i]) });
    }
}

/// No machine has wider vectors of 64-bit numbers.
const MOST_LANES: usize = 8;
