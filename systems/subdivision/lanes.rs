//! Many places of one polynomial at once, as wide as the machine allows.
//!
//! Widths differ between machines, results do not: every lane does the operations of
//! [`Quartic`]'s own functions in their order, and nothing is fused.

use bytemuck::{cast_slice, cast_slice_mut};
use glam::DVec3;
use pulp::{Simd, WithSimd};
use selvedge_components::subdivision::boxspline::{Quartic, horner_jet, horner_position};

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
        let coefficients = splat(simd, self.quartic);
        let mul_add = |a, b, c| simd.add_f64s(simd.mul_f64s(a, b), c);
        let at = |s, t| {
            let [x, y, z] = &coefficients;
            simd.interleave_shfl_f64s([x, y, z].map(|c| horner_position(c, s, t, mul_add)))
        };
        let ((s, s_rest), (t, t_rest)) = (S::as_simd_f64s(self.s), S::as_simd_f64s(self.t));
        let (points, points_rest) = self.points.split_at_mut(s.len() * S::F64_LANES);
        let (points, _) = S::as_mut_simd_f64s(cast_slice_mut(points));
        for ((&s, &t), out) in s.iter().zip(t).zip(points.as_chunks_mut::<3>().0) {
            *out = at(s, t);
        }
        if !s_rest.is_empty() {
            let last = at(simd.partial_load_f64s(s_rest), simd.partial_load_f64s(t_rest));
            let numbers: &[f64] = cast_slice(&last);
            cast_slice_mut(points_rest).copy_from_slice(&numbers[..3 * s_rest.len()]);
        }
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
        let coefficients = splat(simd, self.quartic);
        let mul_add = |a, b, c| simd.add_f64s(simd.mul_f64s(a, b), c);
        let at = |s, t| {
            let [x, y, z] = &coefficients;
            let [dx, dy, dz] = [x, y, z].map(|c| horner_jet(c, s, t, mul_add));
            simd.interleave_shfl_f64s(unit(simd, cross(simd, [dx[1], dy[1], dz[1]], [dx[2], dy[2], dz[2]])))
        };
        let ((s, s_rest), (t, t_rest)) = (S::as_simd_f64s(self.s), S::as_simd_f64s(self.t));
        let (normals, normals_rest) = self.normals.split_at_mut(s.len() * S::F64_LANES);
        let (normals, _) = S::as_mut_simd_f64s(cast_slice_mut(normals));
        for ((&s, &t), out) in s.iter().zip(t).zip(normals.as_chunks_mut::<3>().0) {
            *out = at(s, t);
        }
        if !s_rest.is_empty() {
            let last = at(simd.partial_load_f64s(s_rest), simd.partial_load_f64s(t_rest));
            let numbers: &[f64] = cast_slice(&last);
            cast_slice_mut(normals_rest).copy_from_slice(&numbers[..3 * s_rest.len()]);
        }
    }
}

#[inline(always)]
fn cross<S: Simd>(simd: S, [a, b, c]: [S::f64s; 3], [d, e, f]: [S::f64s; 3]) -> [S::f64s; 3] {
    let minor = |p, q, r, s| simd.sub_f64s(simd.mul_f64s(p, q), simd.mul_f64s(r, s));
    [minor(b, f, c, e), minor(c, d, a, f), minor(a, e, b, d)]
}

/// `v` over its length; zero where that vanishes.
#[inline(always)]
fn unit<S: Simd>(simd: S, v: [S::f64s; 3]) -> [S::f64s; 3] {
    let [x, y, z] = v.map(|c| simd.mul_f64s(c, c));
    let square = simd.add_f64s(simd.add_f64s(x, y), z);
    let zero = simd.splat_f64s(0.0);
    let length = simd.sqrt_f64s(square);
    let some = simd.greater_than_f64s(length, zero);
    v.map(|c| simd.select_f64s(some, simd.div_f64s(c, length), zero))
}

/// The coefficients of each coordinate, in every lane.
#[inline(always)]
fn splat<S: Simd>(simd: S, quartic: &Quartic) -> [[S::f64s; 14]; 3] {
    [0, 1, 2].map(|axis| quartic.coefficients.map(|c| simd.splat_f64s(c[axis])))
}
