//! Control points, plain or weighted, and the repeated mixing that de Casteljau's and de Boor's
//! algorithms share.

use glam::DVec3;

use super::error::finite;
use super::{ShapeError, mix};

/// The greatest degree of a [`Bezier`](super::Bezier) or [`BSpline`](super::BSpline): evaluation
/// mixes in an array of fixed size, so that it allocates nothing. In f64 the control points of
/// degrees beyond stand for the curve no better: their influence, `C(63, 31) 2^-63`, spreads thin.
pub const MAX_DEGREE: usize = 63;

/// Control points.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Net {
    Plain(Vec<DVec3>),
    Rational(Vec<Weighted>),
}

/// A control point and its weight.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Weighted {
    point: DVec3,
    weight: f64,
}

/// A point of a curve and the derivative there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub(super) position: DVec3,
    pub(super) derivative: DVec3,
}

/// The last step of an evaluation: `share` of the way between the last two points, whose
/// difference is the derivative over `speed`.
#[derive(Clone, Copy, Debug)]
pub(super) struct LastStep {
    pub(super) share: f64,
    pub(super) speed: f64,
}

impl Net {
    /// Plain control points, all finite.
    pub(super) fn plain(points: Vec<DVec3>) -> Result<Self, ShapeError> {
        finite(&points)?;
        Ok(Self::Plain(points))
    }

    /// The same points with other weights, all positive.
    pub(super) fn with_weights(&self, weights: &[f64]) -> Result<Self, ShapeError> {
        let (count, needed) = (weights.len(), self.len());
        if count != needed {
            return Err(ShapeError::WrongCount { what: "weights", count, needed });
        }
        if let Some(index) = weights.iter().position(|w| !(*w > 0.0 && w.is_finite())) {
            return Err(ShapeError::Weight { index, weight: weights[index] });
        }
        let weighted = weights.iter().enumerate().map(|(i, &weight)| Weighted { point: self.point(i), weight });
        Ok(Self::Rational(weighted.collect()))
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Plain(points) => points.len(),
            Self::Rational(points) => points.len(),
        }
    }

    pub(super) fn point(&self, i: usize) -> DVec3 {
        match self {
            Self::Plain(points) => points[i],
            Self::Rational(points) => points[i].point,
        }
    }

    /// Mixes `count` points from `first` on, again and again until two are left, and these by the
    /// last step. Step `r` from 1 puts at `i` the mix of points `i` and `i + 1` with `share(r, i)`.
    pub(super) fn evaluate(
        &self,
        first: usize,
        count: usize,
        share: impl Fn(usize, usize) -> f64,
        last: LastStep,
    ) -> Jet {
        let range = first..first + count;
        match self {
            Self::Plain(points) => {
                let [a, b] = last_pair(&points[range], share);
                Jet { position: mix(a, b, last.share), derivative: (b - a) * last.speed }
            }
            Self::Rational(points) => {
                let [a, b] = last_pair(&points[range], share);
                let end = Weighted::mix(a, b, last.share);
                // [Floater 1992]: the derivative from the last two projected points alone.
                let speed = last.speed * (a.weight / end.weight) * (b.weight / end.weight);
                Jet { position: end.point, derivative: (b.point - a.point) * speed }
            }
        }
    }
}

/// What can be mixed.
trait Mix: Copy + Default {
    fn mix(a: Self, b: Self, t: f64) -> Self;
}

impl Mix for DVec3 {
    fn mix(a: Self, b: Self, t: f64) -> Self {
        mix(a, b, t)
    }
}

impl Mix for Weighted {
    /// The rational de Casteljau step between projected points, which stays in their hull and is
    /// exact at both ends. [Farin 2002, Chapter 13]
    fn mix(a: Self, b: Self, t: f64) -> Self {
        let weight = mix(a.weight, b.weight, t);
        Self { point: mix(a.point, b.point, t * (b.weight / weight)), weight }
    }
}

fn last_pair<T: Mix>(points: &[T], share: impl Fn(usize, usize) -> f64) -> [T; 2] {
    // Nearly all curves are of degree up to 5: with the number of points known, loops unroll and
    // nothing is cleared.
    match points.len() {
        2 => few::<T, 2>(points, share),
        3 => few::<T, 3>(points, share),
        4 => few::<T, 4>(points, share),
        5 => few::<T, 5>(points, share),
        6 => few::<T, 6>(points, share),
        count => {
            let mut buffer = [T::default(); MAX_DEGREE + 1];
            buffer[..count].copy_from_slice(points);
            reduce(&mut buffer[..count], share)
        }
    }
}

fn few<T: Mix, const N: usize>(points: &[T], share: impl Fn(usize, usize) -> f64) -> [T; 2] {
    let mut rest: [T; N] = core::array::from_fn(|i| points[i]);
    reduce(&mut rest, share)
}

#[inline(always)]
fn reduce<T: Mix>(rest: &mut [T], share: impl Fn(usize, usize) -> f64) -> [T; 2] {
    let count = rest.len();
    for step in 1..count - 1 {
        for i in 0..count - step {
            rest[i] = T::mix(rest[i], rest[i + 1], share(step, i));
        }
    }
    [rest[0], rest[1]]
}
