//! The scenes of trims keep what they promise, and are drawn.

use std::sync::Arc;

use glam::DVec3;
use selvedge::scenes::trims::measure;
use selvedge::scenes::trims::row::{Broken, TrimRow};
use selvedge::scenes::trims::shared;
use selvedge::scenes::trims::{Scene, Settings, TrimSceneError, Trimmed, run, subjects};
use selvedge_components::curve::{CurveParameters, FnCurve, Heading};
use selvedge_components::subdivision::fit::Outcome;
use selvedge_components::subdivision::{Border, LoopSurface};
use selvedge_components::trim::{TrimFault, TrimOptions};
use selvedge_systems::subdivision::remesh::Cut;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

/// The ladder is no worse than `most` from level to level, in micrometres.
fn assert_ladder(trimmed: &Trimmed, most: &[f64]) {
    for (rung, most) in trimmed.ladder.iter().zip(most) {
        assert!(rung.max <= 1e-6 * most, "{} level {}: {:e}", trimmed.name, rung.level, rung.max);
    }
}

/// No open edge but on borders, borders on their curves, and nothing changed beyond the region.
fn assert_sound(trimmed: &Trimmed) {
    const LEVEL: u32 = 2;
    let options = TriangulateOptions { density: Density::Level(LEVEL), ..TriangulateOptions::default() };
    let triangles = triangulate(&trimmed.surface, &options).expect("a finite surface").triangles;
    assert_eq!(measure::open_edges(&triangles, &trimmed.surface.mesh), 0, "{}", trimmed.name);
    assert!(measure::curve_samples_exact(&trimmed.surface, &triangles, LEVEL), "{}", trimmed.name);
    assert!(measure::outside_is_identical(trimmed).expect("finite surfaces"), "{}", trimmed.name);
}

#[test]
fn the_bore_keeps_its_ladder_and_all_beyond_it_its_bits() {
    let small = run(&subjects::bore8().expect("a scene"), &Settings::levels(3)).expect("a trim");
    assert_eq!(small.ladder.len(), 4);
    assert_ladder(&small, &[80.0, 10.5, 1.8, 0.5]);
    assert_sound(&small);
    let large = run(&subjects::bore32().expect("a scene"), &Settings::within(13e-6)).expect("a trim");
    assert_sound(&large);
    let faces = large.ground.surface.mesh.face_count();
    assert!(large.untouched().count() > faces * 17 / 20, "{} of {faces}", large.untouched().count());
}

#[test]
fn the_hubcap_has_twelve_borders_and_keeps_its_ladder() {
    let hubcap = run(&subjects::hubcap().expect("a scene"), &Settings::within(3e-6)).expect("a trim");
    assert_ladder(&hubcap, &[205.0, 47.0, 9.9, 2.7]);
    assert_sound(&hubcap);
    assert_eq!(hubcap.surface.mesh.border_loops().len(), 12);
    assert!(measure::most_valence(&hubcap.surface.mesh) <= 8);
    assert!(measure::achieved(&hubcap).expect("a finite surface") <= 3e-6);
}

#[test]
fn a_bore_through_the_rim_leaves_one_border_with_two_corners() {
    let settings = Settings::within(1e-5);
    for wall in subjects::THROUGH {
        let cut = run(&subjects::thin_wall(wall).expect("a scene"), &settings).expect("a trim");
        TrimRow::of(&cut, &settings).expect("what is promised");
        assert_eq!(cut.surface.mesh.border_loops().len(), 1);
        assert_eq!(cut.surface.sides.len(), 2, "the bore and the rest of the rim");
    }
}

#[test]
fn a_row_that_does_not_keep_its_promise_is_refused() {
    let bore = subjects::bore8().expect("a scene");
    let trimmed = run(&bore, &Settings::within(1e-4)).expect("a trim");
    let broken = TrimRow::of(&trimmed, &Settings::within(1e-5)).expect_err("it was fitted to ten times as much");
    assert!(matches!(broken, TrimSceneError::Broken { what: Broken::Tolerance { asked: 1e-5, .. }, .. }), "{broken}");
    let short = Settings { options: TrimOptions { last_level: 0, ..TrimOptions::default() }, ..Settings::within(1e-6) };
    let why = run(&bore, &short).expect_err("one level is not enough");
    assert!(matches!(why, TrimFault::NotReached { outcome: Outcome::LevelsSpent { .. } }), "{why}");
}

#[test]
fn a_plate_and_the_wall_of_its_bore_meet_on_every_level() {
    let plate = run(&subjects::bore8().expect("a scene"), &Settings::levels(0)).expect("a trim");
    let wall = shared::wall(&plate).expect("a round bore");
    for level in 0..=3 {
        assert_eq!(shared::open_seam_edges(&plate, &wall, level).expect("finite surfaces"), 0, "level {level}");
    }
    // A wall with parameters of its own along the same curve does not meet it.
    let stranger = other_parameters(&wall);
    assert!(shared::open_seam_edges(&plate, &stranger, 2).expect("finite surfaces") > 0);
}

/// The same wall with even parameters along its curve.
fn other_parameters(wall: &LoopSurface) -> LoopSurface {
    let mut other = wall.clone();
    for side in &mut other.sides {
        if let Border::Given { curve, .. } = &mut side.border {
            let edges = curve.edge_count(0) as u32;
            *curve = Arc::new(CurveParameters::even(Arc::clone(curve.curve()), edges).expect("even parameters"));
        }
    }
    other
}

/// A figure of eight.
fn crossing() -> Scene {
    let scene = subjects::bore8().expect("a scene");
    let eight = FnCurve::new(|u: f64| {
        let (s, c) = (core::f64::consts::TAU * u).sin_cos();
        DVec3::new(0.1 * s, 0.08 * s * c, 0.0)
    });
    let curve = selvedge::scenes::trims::ground::lay(&scene.ground, Arc::new(eight.closed())).expect("a direction");
    Scene { name: "eight".into(), trims: vec![vec![Cut::new(curve, Heading::Along)]], ..scene }
}

#[cfg(feature = "diagram")]
#[test]
fn a_failed_trim_is_drawn_with_the_place_of_its_failure() {
    use selvedge::scenes::trim_pictures::failed;
    let scene = crossing();
    let why: TrimFault = run(&scene, &Settings::levels(0)).expect_err("the curve crosses itself");
    let places = failed::places(&why);
    assert!(places.iter().any(|p| p.truncate().length() < 1e-3), "{why}: {places:?}");
    let picture = failed::picture(&scene, &why).expect("a picture");
    // The mark is in the middle of the plate and of the picture: some of its red is there.
    let (x, y) = (picture.width() / 2, picture.width() / 2);
    let red = |(x, y): (u32, u32)| picture.pixel(x, y).is_some_and(|[r, g, b]| r > 150 && g < 120 && b < 120);
    let near = (x - 60..x + 60).flat_map(|x| (y - 60..y + 60).map(move |y| (x, y)));
    assert!(near.filter(|&at| red(at)).count() > 20);
}

#[cfg(feature = "diagram")]
#[test]
fn every_stage_of_a_trim_is_drawn() {
    use selvedge::diagram::camera::{Frame, View};
    use selvedge::scenes::trim_pictures::{errors, regions, stages, views};
    let trimmed = run(&subjects::bore8().expect("a scene"), &Settings::levels(1)).expect("a trim");
    let sizes = [
        stages::figure(&trimmed),
        stages::resampled(&trimmed),
        stages::cages(&[&trimmed], 0.05),
        regions::figure(&trimmed),
        errors::maps(&trimmed, &errors::MapStyle::above(1)),
        errors::ladder("bore", &[("levels", &trimmed)]),
        views::figure(&trimmed, &View::from_angles(-70.0, 30.0), Frame::new(160, 120)),
        views::portrait(&trimmed, &View::from_angles(-70.0, 30.0), Frame::new(160, 120)),
    ]
    .map(|picture| picture.expect("a picture").width());
    assert!(sizes.iter().all(|&width| width >= 160), "{sizes:?}");
}
