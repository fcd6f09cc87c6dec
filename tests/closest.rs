//! The closest point is the closest of all, wherever the search begins.

#[path = "support/draw.rs"]
mod draw;
mod support;

use std::sync::Arc;

use draw::{Draw, add_details, ball, disc};
use glam::{DVec2, DVec3};
use selvedge_components::curve::Heading;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::LoopSurface;
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::subdivision::limit::LimitSurface;
use support::{graph, octant, parallelogram, spherical_fan};

fn index(surface: LoopSurface) -> SurfaceIndex<LimitSurface> {
    let limit = LimitSurface::new(Arc::new(surface)).expect("a sound surface");
    SurfaceIndex::new(Arc::new(limit)).expect("a finite surface")
}

fn surfaces() -> Vec<(&'static str, LoopSurface)> {
    let (points, triangles) = ball(120, 7);
    let mut detailed = disc(6, 3, 4, Heading::Against);
    add_details(&mut detailed, 4, 0.1, 5);
    vec![
        ("ball", support::plain(points, &triangles)),
        ("octant", octant("cone(1,2)")),
        ("disc", disc(5, 2, 3, Heading::Along)),
        ("detailed disc", detailed),
        ("wavy parallelogram", graph(&parallelogram(5), |p| 0.5 * (2.0 * p.x).sin() * (1.5 * p.y).cos())),
        ("concave corner", spherical_fan(4, 2, 240_f64.to_radians())),
    ]
}

/// The least distance over a dense lattice of every face.
fn by_force(samples: &[DVec3], point: DVec3) -> f64 {
    samples.iter().map(|s| s.distance_squared(point)).fold(f64::INFINITY, f64::min).sqrt()
}

fn samples(limit: &LimitSurface, n: u32) -> Vec<DVec3> {
    let mut all = Vec::new();
    for f in 0..limit.face_count() {
        for i in 0..=n {
            for j in 0..=n - i {
                let st = DVec2::new(f64::from(i), f64::from(j)) / f64::from(n);
                all.push(limit.position(SurfacePoint { face: FaceId::new(f), st }));
            }
        }
    }
    all
}

#[test]
fn no_sample_is_closer_than_the_closest_point() {
    for (name, surface) in surfaces() {
        let index = index(surface);
        let samples = samples(index.surface(), 24);
        let mut draw = Draw(17);
        for k in 0..300 {
            let base = samples[draw.below(samples.len())];
            let point = base + draw.vector() * 10.0_f64.powf(-3.5 * draw.unit());
            let found = index.closest(point).expect("a finite point");
            let least = by_force(&samples, point);
            assert!(found.distance <= least * (1.0 + 1e-12), "{name}, {k}: {} is farther than {least}", found.distance);
            assert!((index.surface().position(found.at) - found.position).length() < 1e-14, "{name}");
            let hinted = index.closest_from(point, draw.place(index.surface().face_count())).expect("a finite point");
            assert!((hinted.distance - found.distance).abs() < 1e-13, "{name}, {k}: {hinted:?} but {found:?}");
        }
    }
}

/// The foot of a point above the surface is the point that it is above.
#[test]
fn the_closest_point_of_a_point_above_the_surface_is_below_it() {
    for (name, surface) in surfaces() {
        let index = index(surface);
        let limit = index.surface();
        let mut draw = Draw(18);
        let mut elsewhere = 0;
        for k in 0..500 {
            let at = draw.place(limit.face_count());
            let jet = limit.jet(at);
            let height = 1e-3 * (draw.unit() - 0.5);
            let point = jet.position + jet.normal() * height;
            let found = index.closest(point).expect("a finite point");
            let off = found.position.distance(jet.position);
            if found.distance < 0.99 * height.abs() {
                // The surface folds back on itself, and the other sheet is nearer.
                elsewhere += 1;
                continue;
            }
            assert!(off < 1e-12, "{name}, {k}: at {at:?}: off by {off:e}, {found:?} for {height:e}");
        }
        assert!(elsewhere < 25, "{name}: {elsewhere} points have another foot");
    }
}
