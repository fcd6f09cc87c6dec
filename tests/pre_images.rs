//! Curves between two sheets: a host says which one is meant.

mod support;

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3};
use selvedge::curve::{FnCurve, Heading};
use selvedge::evaluate::SurfacePoint;
use selvedge::mesh::{Connectivity, FaceId};
use selvedge::subdivision::LoopSurface;
use selvedge::subdivision::remesh::{PreImageError, RemeshError};
use selvedge::tolerance::Tolerance;
use selvedge::trim::{PreImagePoint, TrimFault, TrimOptions};
use selvedge::{Engine, TrimProgress};
use selvedge_systems::closest::SurfaceIndex;
use selvedge_systems::subdivision::limit::LimitSurface;

const N: u32 = 12;
const EDGE: f64 = 0.05;
/// Half the thickness.
const HALF: f64 = 1e-3;
const RADIUS: f64 = 0.1;

/// A closed cage of two sheets of squares, joined along their rims.
fn pillow() -> LoopSurface {
    let name = |i: u32, j: u32| i * (N + 1) + j;
    let is_rim = |i: u32, j: u32| i == 0 || j == 0 || i == N || j == N;
    let at = |i: u32| (f64::from(i) - 0.5 * f64::from(N)) * EDGE;
    let places: Vec<(u32, u32)> = (0..=N).flat_map(|i| (0..=N).map(move |j| (i, j))).collect();
    let height = |i, j| if is_rim(i, j) { 0.0 } else { HALF };
    let mut points: Vec<DVec3> = places.iter().map(|&(i, j)| DVec3::new(at(i), at(j), height(i, j))).collect();
    // The lower sheet has the rim's vertices, and its own within.
    let mut below = vec![0; points.len()];
    for &(i, j) in &places {
        below[name(i, j) as usize] = if is_rim(i, j) { name(i, j) } else { points.len() as u32 };
        if !is_rim(i, j) {
            points.push(DVec3::new(at(i), at(j), -HALF));
        }
    }
    let mut faces = Vec::new();
    for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
        let [a, b, c, d] = [name(i, j), name(i + 1, j), name(i + 1, j + 1), name(i, j + 1)];
        // At every corner of the rim the diagonal ends on it, so that no face lies on the rim alone.
        let on_other_diagonal = (i == 0 && j == N - 1) || (i == N - 1 && j == 0);
        let triangles = if on_other_diagonal { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] };
        faces.extend(triangles);
        faces.extend(triangles.map(|[p, q, r]| [below[p as usize], below[r as usize], below[q as usize]]));
    }
    LoopSurface::plain(Arc::new(Connectivity::new(points.len(), &faces).expect("a pillow")), points, &[])
}

/// A circle between the sheets, now nearer to one, now to the other.
fn between(u: f64) -> DVec3 {
    let angle = core::f64::consts::TAU * u;
    (RADIUS * DVec2::from_angle(angle)).extend(0.3 * HALF * (3.0 * angle).cos())
}

struct Pillow {
    engine: Engine,
    source: Entity,
    surface: LoopSurface,
    trim: Entity,
}

impl Pillow {
    fn new() -> Self {
        let (mut engine, surface) = (Engine::new(), pillow());
        let source = engine.spawn_surface(&surface);
        let curve = engine.spawn_curve(Arc::new(FnCurve::new(between).closed()));
        // As far as the curve lies off either sheet, and the border with it.
        let wide = Tolerance { fit: 2.0 * HALF, chord: HALF, curve: 2.0 * HALF };
        let trim = engine.spawn_trim(source, &[(curve, Heading::Along)], Some(wide), TrimOptions::default());
        Self { engine, source, surface, trim }
    }

    /// Places on the upper sheet or the lower one, as seen from there.
    fn places(&self, side: f64, parameters: &[f64]) -> Vec<PreImagePoint> {
        let limit = LimitSurface::new(Arc::new(self.surface.clone())).expect("sound");
        let index = SurfaceIndex::new(Arc::new(limit)).expect("finite");
        let at = |u: f64| index.closest(between(u).with_z(side)).expect("a place").at;
        parameters.iter().map(|&u| PreImagePoint { u, at: at(u) }).collect()
    }

    fn why(&mut self) -> PreImageError {
        self.engine.settle().expect("trims end");
        match self.engine.trim_progress(self.trim) {
            Some(TrimProgress::Failed(failed)) => match failed.why {
                TrimFault::Remesh(RemeshError::PreImage { curve: 0, source }) => source,
                other => panic!("{other}"),
            },
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_curve_between_two_sheets_is_refused_until_one_of_them_is_named() {
    let mut pillow = Pillow::new();
    let why = pillow.why();
    assert!(matches!(why, PreImageError::Ambiguous { .. }), "{why}");
    // A single place will do, and many.
    for (side, parameters) in [(1.0, &[0.4][..]), (-1.0, &[0.0, 0.2, 0.55, 0.8, 0.9]), (1.0, &[0.0, 0.5, 1.0])] {
        let places = pillow.places(side, parameters);
        // Seen from above the curve runs counter-clockwise and keeps the disc; from below, the rest.
        pillow.engine.tell_pre_image(pillow.trim, 0, places);
        pillow.engine.settle().expect("trims end");
        let progress = pillow.engine.trim_progress(pillow.trim);
        let Some(TrimProgress::Finished(report)) = progress else { panic!("{progress:?}") };
        assert!(report.off > 0.5 * HALF && report.off < 1.5 * HALF, "{}", report.off);
        let result = pillow.engine.result(pillow.source).expect("a result");
        let left = pillow.engine.surface(result).expect("gathered").expect("sound");
        assert_eq!(left.mesh.euler(), 1);
        let within = |p: &&DVec3| p.truncate().length() < 0.5 * RADIUS;
        let upper = left.points.iter().filter(within).filter(|p| p.z > 0.0).count();
        let lower = left.points.iter().filter(within).filter(|p| p.z < 0.0).count();
        let beyond = left.points.iter().any(|p| p.truncate().length() > 1.5 * RADIUS);
        match side > 0.0 {
            true => assert!(upper > 0 && lower == 0 && !beyond, "the disc of the upper sheet"),
            false => assert!(upper > 0 && lower == 0 && beyond, "all but the disc of the lower sheet"),
        }
    }
    // What was told can be taken back.
    pillow.engine.tell_pre_image(pillow.trim, 0, Vec::new());
    assert!(matches!(pillow.why(), PreImageError::Ambiguous { .. }));
}

#[test]
fn places_that_are_not_near_the_curve_are_refused_by_parameter_and_distance() {
    let mut pillow = Pillow::new();
    let mut places = pillow.places(1.0, &[0.1, 0.3]);
    places[1].at = pillow.places(1.0, &[0.8])[0].at;
    pillow.engine.tell_pre_image(pillow.trim, 0, places);
    match pillow.why() {
        PreImageError::GivenOff { index: 1, u: 0.3, at, distance, limit } => {
            assert_eq!(at, between(0.3));
            assert!((distance - 2.0 * RADIUS).abs() < 1e-3 && limit > EDGE && limit < 1.5 * EDGE);
        }
        other => panic!("{other}"),
    }
}

#[test]
fn places_on_both_sheets_are_ambiguous_still() {
    let mut pillow = Pillow::new();
    let mut places = pillow.places(1.0, &[0.1, 0.6]);
    places[1] = pillow.places(-1.0, &[0.6])[0];
    pillow.engine.tell_pre_image(pillow.trim, 0, places);
    assert!(matches!(pillow.why(), PreImageError::Ambiguous { .. }));
}

#[test]
fn places_that_are_none_are_refused_by_their_number() {
    let place = |u: f64, face: u32, s: f64| PreImagePoint { u, at: SurfacePoint::new(FaceId(face), s, 0.2) };
    let bad = [
        (vec![place(-0.1, 0, 0.1)], 0),
        (vec![place(0.5, 100, 0.1), place(f64::NAN, 100, 0.1)], 1),
        (vec![place(0.5, 100, 0.1), place(0.5, 100, 0.1)], 1),
        (vec![place(0.5, 1_000_000, 0.1)], 0),
        (vec![place(0.5, 0, 0.9)], 0),
        (vec![place(0.5, 0, f64::NAN)], 0),
    ];
    for (points, wrong) in bad {
        let mut pillow = Pillow::new();
        pillow.engine.tell_pre_image(pillow.trim, 0, points);
        match pillow.why() {
            PreImageError::BadGiven { index, .. } => assert_eq!(index, wrong),
            other => panic!("{other}"),
        }
    }
}
