//! Surfaces along one curve meet there bit for bit, whichever way they walk it.

mod support;

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{CurveParameters, Extent, FnCurve, Heading};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::{Border, CornerRule, CornerTable, Details, Ends, Kind, LoopSurface, Side};
use selvedge_systems::subdivision::chain;

/// A band of triangles between a closed curve of `n` parameters and a plain inner rim, on the left of
/// the curve or on its right.
fn band(curve: &Arc<CurveParameters>, n: u32, first: u64, heading: Heading, inner: f64) -> LoopSurface {
    let mut faces = Vec::new();
    for i in 0..n {
        let (a, b) = (i, (i + 1) % n);
        let (p, q) = (n + a, n + b);
        faces.extend([[a, b, q], [a, q, p]]);
    }
    let mesh = Arc::new(Connectivity::new(2 * n as usize, &faces).expect("a band is a manifold"));
    let side = Side {
        vertices: (0..n).map(VertexId).collect(),
        ends: Ends::Closed,
        border: Border::Given { curve: curve.clone(), first, heading },
    };
    let rim = mesh.border_loops().into_iter().find(|walk| walk[0].0 >= n).expect("the inner rim");
    let sides = vec![side.clone(), Side { vertices: rim, ends: Ends::Closed, border: Border::Plain }];
    let outer = |i: u32| curve.sample(0, side.curve_index(0, u64::from(i)).expect("the side is given"));
    let points = (0..2 * n).map(|v| if v < n { outer(v) } else { outer(v - n) * inner }).collect();
    LoopSurface { mesh, points, sides, corner_rule: CornerRule::Lattice, details: Details::default() }
}

/// All samples on the given border after `level` subdivisions, as bits, sorted.
fn border_bits(surface: &LoopSurface, level: u32) -> Vec<[u64; 3]> {
    let corners = CornerTable::new(surface);
    let mut at = chain::root(surface, &corners, &surface.details);
    for _ in 0..level {
        at = chain::refine(surface, &corners, &surface.details, &at, &at.mesh.all_refinable()).0;
    }
    let given = at.mesh.vertices.iter().filter_map(|v| match v.kind {
        Kind::Given(g) => Some(at.mesh.given[g as usize].sample.to_array().map(f64::to_bits)),
        _ => None,
    });
    let mut bits: Vec<_> = given.collect();
    bits.sort_unstable();
    bits
}

/// Parameters of very uneven gaps, 1 to 10.
fn uneven(n: u32) -> Arc<CurveParameters> {
    let curve = FnCurve::new(|u: f64| {
        let angle = std::f64::consts::TAU * u;
        DVec3::new(angle.cos(), angle.sin(), 0.2 * (3.0 * angle).sin())
    });
    let gaps: Vec<f64> = (0..n).map(|i| if i % 3 == 0 { 10.0 } else { 1.0 }).collect();
    let whole: f64 = gaps.iter().sum();
    let list = gaps.iter().scan(0.005, |u, gap| {
        let here = *u;
        *u += gap / whole;
        Some(here)
    });
    let list: Vec<f64> = list.collect();
    Arc::new(CurveParameters::new(Arc::new(curve.closed()), Extent::Closed, list, &[]).expect("the list ascends"))
}

#[test]
fn two_surfaces_share_the_bits_of_their_curve_from_both_sides_and_from_anywhere() {
    const N: u32 = 12;
    let curve = uneven(N);
    let inside = band(&curve, N, 0, Heading::Along, 0.5);
    for first in [0, 5, 11] {
        let outside = band(&curve, N, first, Heading::Against, 1.5);
        for level in 0..=5 {
            let (a, b) = (border_bits(&inside, level), border_bits(&outside, level));
            assert_eq!(a.len(), (N << level) as usize);
            assert_eq!(a, b, "first {first}, level {level}");
        }
    }
}

/// Gaps of 1 and 10 side by side: the limit border runs along the curve with a speed that changes
/// continuously, so one subdivision halves the greatest jump between neighbouring steps.
#[test]
fn uneven_parameters_keep_the_border_tangent_continuous() {
    const N: u32 = 12;
    let curve = uneven(N);
    let jump = |level: u32| {
        let samples: Vec<DVec3> = curve.samples(level).collect();
        let count = samples.len();
        let step = |i: usize| (samples[(i + 1) % count] - samples[i]) * f64::from(1 << level);
        (0..count).map(|i| step((i + 1) % count).distance(step(i))).fold(0.0, f64::max)
    };
    for level in 3..8 {
        let ratio = jump(level) / jump(level + 1);
        assert!((1.8..2.2).contains(&ratio), "level {level}: {ratio}");
    }
}
