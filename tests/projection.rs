//! Lines meet surfaces where they must, and curves are carried there.

#[path = "support/draw.rs"]
mod draw;
mod support;

use std::sync::Arc;

use draw::{Draw, ball, disc};
use glam::DVec3;
use selvedge_components::curve::{Circle, Curve, Heading, Segment};
use selvedge_components::evaluate::Evaluate;
use selvedge_components::subdivision::LoopSurface;
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::projected_curve::{Pick, ProjectError, ProjectedCurve};
use selvedge_systems::subdivision::limit::LimitSurface;
use support::{graph, parallelogram};

fn index(surface: LoopSurface) -> Arc<SurfaceIndex<LimitSurface>> {
    let limit = LimitSurface::new(Arc::new(surface)).expect("a sound surface");
    Arc::new(SurfaceIndex::new(Arc::new(limit)).expect("a finite surface"))
}

fn segment(start: DVec3, end: DVec3) -> Segment {
    Segment { start, end }
}

fn bumpy_ball() -> Arc<SurfaceIndex<LimitSurface>> {
    let (points, triangles) = ball(10, 3);
    index(support::plain(points, &triangles))
}

fn wavy_plate() -> Arc<SurfaceIndex<LimitSurface>> {
    index(graph(&parallelogram(6), |p| 0.3 * (1.1 * p.x).sin() * (0.9 * p.y).cos()))
}

/// A line through a closed surface leaves it as often as it enters.
#[test]
fn lines_pass_through_a_closed_surface_an_even_number_of_times() {
    let index = bumpy_ball();
    let mut draw = Draw(31);
    let mut met = 0;
    for k in 0..500 {
        let (origin, direction) = (draw.vector() * 0.8, draw.vector());
        let hits = index.hits(origin, direction, [f64::NEG_INFINITY, f64::INFINITY]);
        assert_eq!(hits.len() % 2, 0, "{k}: {hits:?}");
        met += hits.len();
        for hit in &hits {
            assert!(hit.position.distance(origin + direction * hit.t) < 1e-13);
            assert!(index.surface().position(hit.at).distance(hit.position) < 1e-15);
        }
        let ahead = index.first_hit(origin, direction, [0.0, f64::INFINITY]);
        let expected = hits.iter().find(|h| h.t >= 0.0);
        assert_eq!(ahead.is_some(), expected.is_some(), "{k}");
        if let (Some(a), Some(b)) = (ahead, expected) {
            assert!((a.t - b.t).abs() < 1e-12, "{k}: {} instead of {}", a.t, b.t);
        }
    }
    assert!(met > 500, "only {met} hits");
}

/// Over a graph each vertical line has one place, which keeps x and y.
#[test]
fn a_curve_over_a_graph_keeps_its_plan() {
    let index = wavy_plate();
    let circle = Circle::new(DVec3::new(4.0, 2.5, 3.0), DVec3::Z, 1.2).expect("a circle");
    let curve = ProjectedCurve::new(Arc::new(circle), -DVec3::Z, Arc::clone(&index), Pick::First).expect("a direction");
    assert!(curve.closed());
    for k in 0..400 {
        let u = f64::from(k) / 400.0;
        let (p, q) = (curve.position(u), circle.position(u));
        assert!((p - q).truncate().length() < 1e-14, "{u}: {p} over {q}");
        let foot = index.closest(p).expect("finite");
        assert!(foot.distance < 1e-14, "{u}: {} off the surface", foot.distance);
        assert_eq!(p, curve.position(u), "the same question has the same answer");
    }
}

#[test]
fn derivatives_agree_with_differences() {
    let circle = Circle::new(DVec3::new(4.0, 2.5, 3.0), DVec3::new(0.2, 0.1, 1.0), 1.2).expect("a circle");
    let along = DVec3::new(0.1, -0.2, -1.0);
    let curve = ProjectedCurve::new(Arc::new(circle), along, wavy_plate(), Pick::First).expect("a direction");
    let h = 1e-4;
    let mut steep = 0;
    for k in 0..200 {
        let u = 0.01 + 0.98 * f64::from(k) / 200.0;
        let at = |i: f64| curve.position(u + i * h);
        let difference = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * h);
        // Third derivatives jump where faces meet: 7e-9 is h^2 of that.
        steep += usize::from(difference.distance(curve.derivative(u)) > 1e-9);
        assert!(difference.distance(curve.derivative(u)) < 1e-6, "{u}");
    }
    assert!(steep < 10, "{steep} of 200 are off by more than 1e-9");
}

#[test]
fn the_pick_decides_between_sheets() {
    let index = bumpy_ball();
    let line = |z: f64| segment(DVec3::new(-0.2, 0.1, z), DVec3::new(0.2, -0.1, z));
    let project = |z: f64, pick| {
        ProjectedCurve::new(Arc::new(line(z)), DVec3::Z, Arc::clone(&index), pick).expect("a direction").position(0.4)
    };
    let (low, high) = (project(-3.0, Pick::First), project(-3.0, Pick::Last));
    assert!(low.z < -0.5 && high.z > 0.5, "{low} and {high}");
    assert_eq!(project(-3.0, Pick::Nearest), low);
    assert_eq!(project(0.1, Pick::First), project(0.1, Pick::Last));
    assert!((project(0.1, Pick::Nearest) - high).length() < 1e-13);
    assert!((project(-0.1, Pick::Nearest) - low).length() < 1e-13);
    assert!((project(3.0, Pick::Nearest) - high).length() < 1e-13);
    assert!(project(3.0, Pick::First).is_nan(), "there is nothing above");
}

#[test]
fn a_miss_is_not_a_number() {
    let index = index(disc(6, 2, 3, Heading::Along));
    let beside = segment(DVec3::new(0.0, 0.0, 1.0), DVec3::new(2.0, 0.0, 1.0));
    let curve = ProjectedCurve::new(Arc::new(beside), -DVec3::Z, index, Pick::First).expect("a direction");
    assert!(curve.position(0.2).is_finite());
    assert!(curve.position(0.499).is_finite(), "just inside the border");
    assert!(curve.position(0.501).is_nan(), "just outside");
    assert!(curve.derivative(0.8).is_nan());
    assert!(curve.position(f64::NAN).is_nan());
}

#[test]
fn a_curve_on_the_surface_stays_where_it_is() {
    let index = wavy_plate();
    let circle = Circle::new(DVec3::new(4.0, 2.5, 3.0), DVec3::Z, 1.0).expect("a circle");
    let on = Arc::new(ProjectedCurve::new(Arc::new(circle), -DVec3::Z, Arc::clone(&index), Pick::First).expect("one"));
    for pick in [Pick::First, Pick::Last, Pick::Nearest] {
        let again = ProjectedCurve::new(on.clone(), -DVec3::Z, Arc::clone(&index), pick).expect("one");
        for k in 0..50 {
            let u = f64::from(k) / 50.0;
            assert!(again.position(u).distance(on.position(u)) < 1e-14, "{pick:?}, {u}");
        }
    }
}

#[test]
fn no_direction_is_refused() {
    let index = wavy_plate();
    let line: Arc<dyn Curve> = Arc::new(segment(DVec3::ZERO, DVec3::X));
    for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY] {
        let refused = ProjectedCurve::new(Arc::clone(&line), bad, Arc::clone(&index), Pick::First);
        assert!(matches!(refused, Err(ProjectError::NoDirection { .. })));
    }
}
