use super::*;
use crate::subdivision::boxspline::Net;

/// Numbers in [-1, 1) that are the same on every run: the top bits of a linear congruence. [Knuth]
fn numbers(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Weights of the points that divide each edge of a triangle by `n`.
fn lattice(n: u32) -> impl Iterator<Item = [f64; 3]> {
    let part = move |i: u32| f64::from(i) / f64::from(n);
    (0..=n).flat_map(move |i| (0..=n - i).map(move |j| [part(n - i - j), part(i), part(j)]))
}

/// The greatest distance at the same weights between the quartic and its triangle over `corners`.
fn sampled(quartic: &Quartic, corners: [[f64; 2]; 3]) -> f64 {
    let positions = corners.map(|[s, t]| quartic.position(s, t));
    let off = |w: [f64; 3]| {
        let [s, t] = [0, 1].map(|k| (0..3).map(|c| w[c] * corners[c][k]).sum());
        quartic.position(s, t).distance((0..3).map(|c| positions[c] * w[c]).sum())
    };
    lattice(60).map(off).fold(0.0, f64::max)
}

fn corners([s, t]: [f64; 2], size: f64) -> [[f64; 2]; 3] {
    [[s, t], [s + size, t], [s, t + size]]
}

const PLACES: [([f64; 2], f64); 6] = [
    ([0.0, 0.0], 1.0),
    ([0.5, 0.0], 0.5),
    ([0.5, 0.5], -0.5),
    ([0.25, 0.5], 0.25),
    ([0.75, 0.25], -0.25),
    ([0.0, 0.875], 0.125),
];

fn rough(seed: u64) -> Quartic {
    let mut next = numbers(seed);
    let net: Net = core::array::from_fn(|_| DVec3::new(next(), next(), next()));
    Quartic::new(&net)
}

/// However rough the net, wherever the face: no sample lies beyond the bound.
#[test]
fn no_sample_exceeds_the_bound() {
    for seed in 0..40 {
        let quartic = rough(seed);
        for (at, size) in PLACES {
            let deviation = Deviation::new(&quartic, at, size);
            let (bound, found) = (deviation.greatest(), sampled(&quartic, corners(at, size)));
            assert!(found <= bound * (1.0 + 1e-12), "{seed} {at:?}: {found} beyond {bound}");
            assert!(found > 0.125 * bound, "{seed} {at:?}: {found} is far below {bound}");
        }
    }
}

/// The same for the triangles that closures cut a face into.
#[test]
fn no_sample_of_a_piece_exceeds_its_bound() {
    let [a, b, c] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let [ab, bc] = [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5]];
    for seed in 0..40 {
        let quartic = rough(seed);
        for (at, size) in PLACES {
            let (deviation, face) = (Deviation::new(&quartic, at, size), corners(at, size));
            for piece in [[a, ab, c], [ab, b, c], [ab, b, bc], [a, ab, bc], [a, bc, c]] {
                let place = |w: [f64; 3]| [0, 1].map(|k| (0..3).map(|c| w[c] * face[c][k]).sum());
                let (bound, found) = (deviation.of_piece(piece).greatest(), sampled(&quartic, piece.map(place)));
                assert!(found <= bound * (1.0 + 1e-12), "{seed} {at:?} {piece:?}: {found} beyond {bound}");
            }
        }
    }
}

/// Whatever the direction, no sample stands off farther along it, and none is needed that is much farther.
#[test]
fn no_sample_exceeds_the_bound_along_a_direction() {
    for seed in 0..40 {
        let quartic = rough(seed);
        let mut next = numbers(seed + 100);
        for (at, size) in PLACES {
            let direction = DVec3::new(next(), next(), next()).normalize();
            let mut flat = quartic;
            flat.coefficients.iter_mut().for_each(|c| *c = direction * c.dot(direction));
            let bound = Deviation::new(&quartic, at, size).along(direction);
            let found = sampled(&flat, corners(at, size));
            assert!(found <= bound * (1.0 + 1e-12), "{seed} {at:?}: {found} beyond {bound}");
            assert!(found > 0.125 * bound, "{seed} {at:?}: {found} is far below {bound}");
        }
    }
}

/// On a quadratic height field there is no rest, and all that is left points one way: the bound is
/// the greatest value itself, up to how near a sample comes.
#[test]
fn the_bound_is_sharp_on_quadratics() {
    let mut next = numbers(7);
    for _ in 0..100 {
        let mut quartic = Quartic { coefficients: [DVec3::ZERO; 14] };
        for k in [2, 6, 9] {
            quartic.coefficients[k] = DVec3::Z * next();
        }
        for (at, size) in PLACES {
            let bound = Deviation::new(&quartic, at, size).greatest();
            let found = sampled(&quartic, corners(at, size));
            assert!((0.998 * bound..=bound * (1.0 + 1e-12)).contains(&found), "{found} of {bound}");
        }
    }
}

/// What is not quadratic loses its share as faces get smaller: the bound becomes sharp.
#[test]
fn the_bound_gets_sharp_on_small_faces() {
    for seed in 0..20 {
        let mut quartic = rough(seed);
        quartic.coefficients.iter_mut().for_each(|c| *c *= DVec3::Z);
        for (size, share) in [(1.0 / 64.0, 0.9), (1.0 / 1024.0, 0.99)] {
            let bound = Deviation::new(&quartic, [0.25, 0.25], size).greatest();
            let found = sampled(&quartic, corners([0.25, 0.25], size));
            assert!(found > share * bound && found <= bound * (1.0 + 1e-9), "{seed}: {found} of {bound}");
        }
    }
}
