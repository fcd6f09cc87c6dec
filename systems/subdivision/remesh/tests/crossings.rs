//! Curves that cross each other: what stays is on the left of all.

use core::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::Heading;
use selvedge_components::subdivision::LoopSurface;

use super::super::*;
use super::judge::{Verdict, judge_union, picture};
use super::support::{OnPlate, Walker, circle, lattice, polygon};

struct Plate {
    surface: LoopSurface,
    walker: Arc<Walker>,
}

impl Plate {
    fn new(n: u32) -> Self {
        let surface = lattice(n, 0.05, |x, y| 0.006 * (17.0 * x).cos() * (14.0 * y).cos());
        let walker = Arc::new(Walker::new(&surface));
        Self { surface, walker }
    }

    fn lay(&self, plane: impl Fn(f64) -> DVec2 + Send + Sync + 'static, corners: Vec<f64>, heading: Heading) -> Cut {
        Cut::new(Arc::new(OnPlate { walker: Arc::clone(&self.walker), plane, corners }), heading)
    }

    fn bore(&self, x: f64, y: f64, radius: f64) -> Cut {
        self.lay(circle(DVec2::new(x, y), radius), Vec::new(), Heading::Along)
    }

    fn polygon(&self, points: &[(f64, f64)]) -> Cut {
        let (plane, corners) = polygon(points.iter().map(|&(x, y)| DVec2::new(x, y)).collect());
        self.lay(plane, corners, Heading::Along)
    }

    fn cut(&self, cuts: &[Cut], options: &RemeshOptions) -> Result<Remeshed, RemeshError> {
        let trace_options = TraceOptions { curve: 1e-6, step: 0.05 / 8.0 };
        let images = cuts.iter().enumerate().map(|(curve, cut)| {
            trace(&self.surface.mesh, &*self.walker, &*cut.curve, trace_options)
                .map_err(|source| RemeshError::PreImage { curve, source })
        });
        remesh(self.surface.clone(), cuts, &images.collect::<Result<Vec<_>, _>>()?, options)
    }

    fn sound(&self, name: &str, cuts: &[Cut]) -> (Remeshed, Verdict) {
        let result = self.cut(cuts, &RemeshOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        picture(&format!("{name}.svg"), &result);
        let verdict = judge_union(&self.surface, cuts, &result);
        (result, verdict)
    }

    /// Loops of border without the plate's own, and handles and parts by the Euler number.
    fn holes(&self, result: &Remeshed) -> (usize, i64) {
        (result.surface.mesh.border_loops().len() - 1, result.surface.mesh.euler())
    }
}

/// A stadium about `centre`: two half circles and the straight lines between them, clockwise.
pub fn stadium(centre: DVec2, half: f64, radius: f64, turn: f64) -> impl Fn(f64) -> DVec2 + Send + Sync {
    let (arc, line) = (core::f64::consts::PI * radius, 2.0 * half);
    move |u| {
        let total = 2.0 * (arc + line);
        let s = u * total;
        let p = if s < line {
            DVec2::new(-half + s, radius)
        } else if s < line + arc {
            let a = (s - line) / radius;
            DVec2::new(half + radius * a.sin(), radius * a.cos())
        } else if s < 2.0 * line + arc {
            DVec2::new(half - (s - line - arc), -radius)
        } else {
            let a = (s - 2.0 * line - arc) / radius;
            DVec2::new(-half - radius * a.sin(), -radius * a.cos())
        };
        centre + DVec2::from_angle(turn).rotate(p)
    }
}

#[test]
fn two_bores_that_overlap_make_one_hole_with_two_junctions() {
    let plate = Plate::new(12);
    for (k, (x, y)) in [(0.03, 0.001), (0.05, 0.0), (0.035, -0.012), (0.058, 0.003)].into_iter().enumerate() {
        let cuts = [plate.bore(-x, y, 0.06), plate.bore(x, 0.0, 0.06)];
        let (result, _) = plate.sound(&format!("lens{k}"), &cuts);
        assert_eq!(plate.holes(&result), (1, 0));
        assert_eq!(result.junctions.len(), 2);
        assert_eq!(result.unused, []);
        for junction in &result.junctions {
            let p = junction.point.truncate();
            assert!((p.distance(DVec2::new(-x, y)) - 0.06).abs() < 1e-12);
            assert!((p.distance(DVec2::new(x, 0.0)) - 0.06).abs() < 1e-12, "{}", p.distance(DVec2::new(x, 0.0)) - 0.06);
            assert!(junction.gap < 1e-12);
        }
    }
}

#[test]
fn three_bores_that_overlap_each_other_make_one_hole_with_three_junctions() {
    let plate = Plate::new(12);
    let at = |k: u32| 0.04 * DVec2::from_angle(0.3 + TAU * f64::from(k) / 3.0);
    let cuts: Vec<Cut> = (0..3).map(|k| plate.bore(at(k).x, at(k).y, 0.055)).collect();
    let (result, _) = plate.sound("three", &cuts);
    assert_eq!(plate.holes(&result), (1, 0));
    assert_eq!(result.junctions.len(), 3);
}

#[test]
fn a_slot_through_a_bore_makes_four_junctions() {
    let plate = Plate::new(12);
    let slot = plate.lay(stadium(DVec2::new(0.004, 0.003), 0.13, 0.02, 0.2), Vec::new(), Heading::Along);
    let (result, _) = plate.sound("slot", &[plate.bore(0.0, 0.0, 0.06), slot]);
    assert_eq!(plate.holes(&result), (1, 0));
    assert_eq!(result.junctions.len(), 4);
}

#[test]
fn a_bore_across_the_corner_of_a_polygon_takes_the_corner() {
    let plate = Plate::new(12);
    let square = plate.polygon(&[(0.08, 0.07), (0.09, -0.06), (-0.07, -0.08), (-0.08, 0.09)]);
    let (result, _) = plate.sound("corner", &[square, plate.bore(0.08, 0.07, 0.04)]);
    assert_eq!(plate.holes(&result), (1, 0));
    assert_eq!(result.junctions.len(), 2);
    // Three corners of the square are left.
    let along = result.side_origin.iter().filter(|o| o.line == selvedge_components::trim::BorderLine::Cut(0));
    assert_eq!(along.count(), 4);
}

#[test]
fn a_chain_of_twenty_bores_is_one_hole() {
    let plate = Plate::new(24);
    let at = |k: u32| DVec2::new(0.05 * (f64::from(k) - 9.5), 0.06 * (0.9 * f64::from(k)).sin());
    let cuts: Vec<Cut> = (0..20).map(|k| plate.bore(at(k).x, at(k).y, 0.045)).collect();
    let (result, _) = plate.sound("chain", &cuts);
    assert_eq!(plate.holes(&result), (1, 0));
    assert_eq!(result.junctions.len(), 38);
}

#[test]
fn a_ring_of_bores_leaves_the_island_that_it_cuts_free() {
    let plate = Plate::new(16);
    let at = |k: u32| 0.15 * DVec2::from_angle(TAU * f64::from(k) / 12.0);
    let mut cuts: Vec<Cut> = (0..12).map(|k| plate.bore(at(k).x, at(k).y, 0.05)).collect();
    let (result, _) = plate.sound("ring", &cuts);
    assert_eq!((plate.holes(&result), result.junctions.len()), ((2, 1), 24));
    // Within a hole there is nothing to be cut free.
    cuts.insert(0, plate.bore(0.0, 0.0, 0.14));
    let (result, _) = plate.sound("ring filled", &cuts);
    assert_eq!((plate.holes(&result), result.junctions.len()), ((1, 0), 12));
    assert_eq!(result.unused, [0]);
}

#[test]
fn an_island_may_have_its_rim_cut() {
    let plate = Plate::new(16);
    let hole = plate.bore(0.0, 0.0, 0.25);
    let island = plate.lay(circle(DVec2::new(0.01, 0.0), 0.15), Vec::new(), Heading::Against);
    let (result, _) = plate.sound("island", &[hole, island, plate.bore(0.16, 0.02, 0.06)]);
    assert_eq!(plate.holes(&result), (2, 1));
    assert_eq!(result.junctions.len(), 2);
}

#[test]
fn a_curve_within_what_another_takes_away_is_reported_unused() {
    let plate = Plate::new(12);
    let cuts = [plate.bore(0.0, 0.0, 0.05), plate.bore(0.0, 0.0, 0.15), plate.bore(0.15, 0.0, 0.03)];
    let (result, _) = plate.sound("unused", &cuts);
    assert_eq!(plate.holes(&result), (1, 0));
    assert_eq!((result.unused, result.junctions.len()), (vec![0], 2));
}

#[test]
fn a_slot_through_the_whole_plate_leaves_two_parts() {
    let plate = lattice(12, 0.05, |_, _| 0.0);
    let walker = Arc::new(Walker::new(&plate));
    let on = |plane: Box<dyn Fn(f64) -> DVec2 + Send + Sync>| -> Arc<dyn Curve> { Arc::new(OnFlat { plane }) };
    let slot = on(Box::new(stadium(DVec2::new(0.011, 0.007), 0.5, 0.03, 0.1)));
    let bore = on(Box::new(circle(DVec2::new(0.02, 0.04), 0.05)));
    let options = TraceOptions { curve: 1e-9, step: 0.05 / 8.0 };
    let (mut cuts, mut images) = (Vec::new(), Vec::new());
    for curve in [bore, slot] {
        for part in trace_parts(&plate.mesh, &*walker, &*curve, options).expect("pre-images") {
            cuts.push(Cut::new(Arc::clone(&curve), Heading::Along));
            images.push(part);
        }
    }
    assert_eq!(cuts.len(), 3);
    let result = remesh(plate.clone(), &cuts, &images, &RemeshOptions::default()).unwrap_or_else(|e| panic!("{e}"));
    picture("split.svg", &result);
    judge_union(&plate, &cuts, &result);
    assert_eq!((result.surface.mesh.euler(), result.surface.mesh.border_loops().len()), (2, 2));
    // Two where the curves cross, and four on the border.
    assert_eq!(result.junctions.len(), 6);
}

/// A curve in the plane z = 0.
struct OnFlat {
    plane: Box<dyn Fn(f64) -> DVec2 + Send + Sync>,
}

impl core::fmt::Debug for OnFlat {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("OnFlat")
    }
}

impl Curve for OnFlat {
    fn position(&self, u: f64) -> DVec3 {
        (self.plane)(u).extend(0.0)
    }

    fn closed(&self) -> bool {
        true
    }
}

#[test]
fn curves_that_pass_each_other_in_space_are_refused_by_their_gap() {
    let plate = lattice(12, 0.05, |_, _| 0.0);
    let walker = Walker::new(&plate);
    let at = |x: f64, z: f64| -> Cut {
        let circle = selvedge_components::curve::Circle::new(DVec3::new(x, 0.0, z), -DVec3::Z, 0.06);
        Cut::new(Arc::new(circle.expect("a circle")), Heading::Along)
    };
    let cuts = [at(-0.03, 0.0), at(0.03, 1e-4)];
    let options = TraceOptions { curve: 1e-3, step: 0.05 / 8.0 };
    let images: Vec<_> = cuts.iter().map(|c| trace(&plate.mesh, &walker, &*c.curve, options).expect("a way")).collect();
    let within =
        |tolerance| RemeshOptions { junctions: JunctionOptions::within(tolerance), ..RemeshOptions::default() };
    match remesh(plate.clone(), &cuts, &images, &within(1e-4)) {
        Err(RemeshError::Gap { curves: [0, 1], gap, limit, .. }) => {
            assert!((gap - 1e-4).abs() < 1e-12 && limit == 1e-4 / 8.0);
        }
        other => panic!("{other:?}"),
    }
    let result = remesh(plate.clone(), &cuts, &images, &within(1e-3)).expect("a cage");
    assert!(result.junctions.iter().all(|j| (j.gap - 1e-4).abs() < 1e-12 && j.point.z == 0.0));
}

#[test]
fn curves_that_touch_or_run_along_each_other_are_refused_by_their_angle() {
    let plate = Plate::new(12);
    let options = RemeshOptions::default();
    let touching = plate.cut(&[plate.bore(-0.05999, 0.0, 0.06), plate.bore(0.05999, 0.0, 0.06)], &options).map(drop);
    assert!(
        matches!(touching, Err(RemeshError::Tangential { curves: [0, 1], angle, limit, .. }) if angle < limit),
        "{touching:?}"
    );
    // The same corner of two polygons: their upper sides lie on one line.
    let a = plate.polygon(&[(0.08, 0.07), (0.09, -0.06), (-0.07, -0.08), (-0.08, 0.07)]);
    let b = plate.polygon(&[(0.14, 0.07), (0.12, -0.02), (0.0, 0.0), (0.01, 0.07)]);
    for cuts in [[a.clone(), b], [a.clone(), a]] {
        let found = plate.cut(&cuts, &options);
        assert!(found.is_err(), "no cage with a wall of no width");
    }
}
