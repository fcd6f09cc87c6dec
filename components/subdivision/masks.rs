//! The weights of the Loop scheme. Rules know no storage.
//!
//! Letters as in [Loop 1987] and [Litke, Levin, Schroeder 2001]: `k` is the valence, the number of
//! edges that meet at a vertex.

use core::f64::consts::PI;
use std::sync::LazyLock;

/// `alpha(k) = 5 - (3 + 2 cos(2 pi / k))^2 / 8`: one subdivision step keeps `1 - alpha / 8` of a
/// vertex of valence `k`. [Litke et al. 2001, Fig. 2]
pub fn alpha(k: u32) -> f64 {
    let c = 3.0 + 2.0 * cos_turn(1, k);
    5.0 - c * c / 8.0
}

/// The weights of valences that occur, computed once: rules ask for them at every vertex.
static WEIGHTS: LazyLock<[[f64; 2]; 32]> = LazyLock::new(|| core::array::from_fn(|k| weights(k as u32)));

/// `alpha / (8 k)` and `alpha / (k (3 + alpha))`.
fn weights(k: u32) -> [f64; 2] {
    let a = alpha(k);
    [a / (8.0 * f64::from(k)), a / (f64::from(k) * (3.0 + a))]
}

fn weight(k: u32, which: usize) -> f64 {
    WEIGHTS.get(k as usize).map_or_else(|| weights(k)[which], |both| both[which])
}

/// Weight of each of the `k` neighbours of an interior vertex under one Loop step; the vertex
/// itself keeps `1 - k * weight`. `alpha / (8 k)`: 1/16 for `k = 6`.
pub fn neighbour_weight(k: u32) -> f64 {
    weight(k, 0)
}

/// Weight of each of the `k` neighbours in the limit position of an interior vertex; the vertex
/// itself weighs `1 - k * weight`. `alpha / (k (3 + alpha))`: 1/12 for `k = 6`.
pub fn limit_weight(k: u32) -> f64 {
    weight(k, 1)
}

/// Subdominant eigenvalue at an interior vertex of valence `k`: how much a ring shrinks per step.
/// `3/8 + cos(2 pi / k) / 4`; at `k = 3` the eigenvalue 1/4 of the tangents is meant, as there.
pub fn subdominant(k: u32) -> f64 {
    0.375 + 0.25 * cos_turn(1, k)
}

/// Weights of neighbour `i` of `k` in the two limit tangents of an interior vertex, up to a common
/// factor: `(cos, sin)` of `2 pi i / k`.
pub fn tangent_weights(i: u32, k: u32) -> (f64, f64) {
    (cos_turn(i, k), sin_turn(i, k))
}

/// `gamma = 1/2 - cos(theta) / 4`, the weight of the end of an interior edge that is not the
/// corner it starts at, where `theta = angle / (k - 1)` and `angle` is the interior angle of the
/// corner. The corner weighs `3/4 - gamma`. [Litke et al. 2001, Section 2.1]
pub fn corner_weight(angle: f64, k: u32) -> f64 {
    0.5 - 0.25 * (angle / f64::from(k - 1)).cos()
}

/// `cos(2 pi i / k)`.
fn cos_turn(i: u32, k: u32) -> f64 {
    (2.0 * PI * f64::from(i) / f64::from(k)).cos()
}

/// `sin(2 pi i / k)`.
fn sin_turn(i: u32, k: u32) -> f64 {
    (2.0 * PI * f64::from(i) / f64::from(k)).sin()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One more step moves the vertices but not the limit point they stand for.
    #[test]
    fn a_limit_point_survives_refinement() {
        for k in 3..=64 {
            let (beta, gamma, n) = (neighbour_weight(k), limit_weight(k), f64::from(k));
            let limit = |centre: f64, ring: f64| (1.0 - n * gamma) * centre + gamma * ring;
            let (centre, ring) = (0.3, 1.7);
            let finer = limit((1.0 - n * beta) * centre + beta * ring, 0.375 * n * centre + 0.625 * ring);
            assert!((finer - limit(centre, ring)).abs() < 1e-15, "valence {k}");
        }
    }

    /// The masks of a regular vertex are the box spline's own.
    #[test]
    fn regular_masks_are_sixteenths_and_twelfths() {
        assert!((neighbour_weight(6) - 1.0 / 16.0).abs() < 1e-17);
        assert!((limit_weight(6) - 1.0 / 12.0).abs() < 1e-17);
    }
}
