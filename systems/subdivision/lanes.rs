//! SIMD vectors as numbers: the same coordinate of many places, or all coordinates of one.
//!
//! Widths differ between machines, results do not: every lane does the operations of
//! [`Quartic`]'s own functions in their order, and nothing is fused.
//!
//! What runs in lanes is `#[inline(always)]` down to the last operator and passes no closures: code
//! that is not inlined into the dispatched function is compiled for the least machine instead.

use core::ops::{Add, Div, Mul, Sub};

use bytemuck::{cast, cast_slice, cast_slice_mut};
use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};
use selvedge_components::subdivision::boxspline::{Quartic, Vector, horner_jet, horner_position};
use selvedge_components::subdivision::plain::{AsStored, Load};

/// What this machine has of up to four lanes. For a grid of points eight gain nothing over four: its rows are
/// short, and a point has three coordinates.
pub(super) fn four() -> Arch {
    match Arch::new() {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(eight) => Arch::V3(*eight),
        arch => arch,
    }
}

/// One number in every lane.
#[derive(Clone, Copy)]
pub(super) struct Lanes<S: Simd> {
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

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self * Self::splat(self.simd, other)
    }
}

impl<S: Simd> Vector for Lanes<S> {}

/// Calculates with the coordinates of a point side by side, on machines with four lanes. What is in
/// the last is never stored.
#[derive(Clone, Copy)]
pub(super) struct AsLanes<S>(pub S);

impl<S: Simd> Load for AsLanes<S> {
    type Vector = Lanes<S>;

    #[inline(always)]
    fn load(self, point: DVec3) -> Lanes<S> {
        self.load_padded(&[point.x, point.y, point.z, 0.0])
    }

    #[inline(always)]
    fn load_padded(self, point: &[f64; 4]) -> Lanes<S> {
        Lanes { simd: self.0, numbers: cast(*point) }
    }
}

/// The way back from what [`Load`] makes.
pub(super) trait Store: Load {
    /// The point that `vector` stands for.
    fn store(self, vector: Self::Vector) -> DVec3;
}

impl Store for AsStored {
    #[inline(always)]
    fn store(self, vector: DVec3) -> DVec3 {
        vector
    }
}

impl<S: Simd> Store for AsLanes<S> {
    #[inline(always)]
    fn store(self, vector: Lanes<S>) -> DVec3 {
        let lanes: &[f64] = cast_slice(core::slice::from_ref(&vector.numbers));
        DVec3::new(lanes[0], lanes[1], lanes[2])
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

/// What is computed at each place: three numbers.
trait Kernel {
    fn at<S: Simd>(&self, c: &Coefficients<S>, s: Lanes<S>, t: Lanes<S>) -> [Lanes<S>; 3];
}

/// Three numbers at each `(s, t)`, written as a vector each.
#[inline(always)]
fn write_vectors<S: Simd>(
    simd: S,
    kernel: &impl Kernel,
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

impl Kernel for AtPosition {
    #[inline(always)]
    fn at<S: Simd>(&self, [x, y, z]: &Coefficients<S>, s: Lanes<S>, t: Lanes<S>) -> [Lanes<S>; 3] {
        [horner_position(x, s, t), horner_position(y, s, t), horner_position(z, s, t)]
    }
}

struct AtNormal;

impl Kernel for AtNormal {
    #[inline(always)]
    fn at<S: Simd>(&self, [x, y, z]: &Coefficients<S>, s: Lanes<S>, t: Lanes<S>) -> [Lanes<S>; 3] {
        let ([_, a, d], [_, b, e], [_, c, f]) = (horner_jet(x, s, t), horner_jet(y, s, t), horner_jet(z, s, t));
        let (x, y, z) = (b * f - c * e, c * d - a * f, a * e - b * d);
        let square = x * x + y * y + z * z;
        let length = Lanes { simd: s.simd, numbers: s.simd.sqrt_f64s(square.numbers) };
        [x.over_or_zero(length), y.over_or_zero(length), z.over_or_zero(length)]
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
