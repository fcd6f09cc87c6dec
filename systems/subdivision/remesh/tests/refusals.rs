//! What cannot be cut is refused, with the place.

use std::sync::Arc;

use core::f64::consts::TAU;
use glam::{DVec2, DVec3};
use selvedge_components::curve::{Curve, Heading};
use selvedge_components::subdivision::LoopSurface;

use super::super::*;
use super::judge::judge;
use super::support::{OnPlate, Walker, circle, lattice};

fn plate() -> (LoopSurface, Arc<Walker>) {
    let plate = lattice(12, 0.05, |x, y| 0.006 * (17.0 * x).cos() * (14.0 * y).cos());
    let walker = Arc::new(Walker::new(&plate));
    (plate, walker)
}

const TRACE: TraceOptions = TraceOptions { curve: 1e-6, step: 0.05 / 8.0 };

fn on(walker: &Arc<Walker>, plane: impl Fn(f64) -> DVec2 + Send + Sync + 'static) -> Cut {
    Cut::new(Arc::new(OnPlate { walker: Arc::clone(walker), plane, corners: Vec::new() }), Heading::Along)
}

fn run(plate: &LoopSurface, walker: &Walker, cuts: &[Cut], options: &RemeshOptions) -> Result<Remeshed, RemeshError> {
    let images = cuts.iter().map(|c| trace(&plate.mesh, walker, &*c.curve, TRACE).expect("a pre-image"));
    remesh(plate.clone(), cuts, &images.collect::<Vec<_>>(), options)
}

/// A closed curve that is any function.
struct Free<F>(F);

impl<F> core::fmt::Debug for Free<F> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Free")
    }
}

impl<F: Fn(f64) -> DVec3 + Send + Sync> Curve for Free<F> {
    fn position(&self, u: f64) -> DVec3 {
        (self.0)(u)
    }

    fn closed(&self) -> bool {
        true
    }
}

#[test]
fn a_curve_that_is_not_finite_is_named_by_its_parameter() {
    let plate = lattice(12, 0.05, |_, _| 0.0);
    let walker = Walker::new(&plate);
    let found = trace(&plate.mesh, &walker, &Free(|u| if u > 0.4 { DVec3::NAN } else { DVec3::ZERO }), TRACE);
    assert!(matches!(found, Err(PreImageError::NotFinite { u, .. }) if u > 0.4));
}

#[test]
fn a_curve_off_the_surface_is_refused_by_its_distance() {
    let (plate, walker) = plate();
    let above = Free(|u: f64| circle(DVec2::ZERO, 0.1)(u).extend(0.05));
    match trace(&plate.mesh, &*walker, &above, TRACE) {
        Err(PreImageError::TooFarOff { distance, limit, .. }) => assert!(distance > 0.04 && limit == 1e-6),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_curve_across_the_border_is_refused_there() {
    let flat = lattice(12, 0.05, |_, _| 0.0);
    let over = Free(|u: f64| (circle(DVec2::new(0.3, 0.0), 0.1)(u)).extend(0.0));
    let found = trace(&flat.mesh, &Walker::new(&flat), &over, TRACE);
    assert!(matches!(found, Err(PreImageError::LeavesSurface { at, .. }) if at.x > 0.3), "{found:?}");
}

#[test]
fn a_curve_without_length_is_refused() {
    let flat = lattice(12, 0.05, |_, _| 0.0);
    let found = trace(&flat.mesh, &Walker::new(&flat), &Free(|_| DVec3::new(0.01, 0.02, 0.0)), TRACE);
    assert!(matches!(found, Err(PreImageError::NoLength { .. })), "{found:?}");
}

#[test]
fn a_figure_of_eight_crosses_itself_in_its_middle() {
    let (plate, walker) = plate();
    let eight = |u: f64| DVec2::new(0.013 + 0.12 * (TAU * u).sin(), 0.007 + 0.06 * (2.0 * TAU * u).sin());
    match run(&plate, &walker, &[on(&walker, eight)], &RemeshOptions::default()) {
        Err(RemeshError::PreImage { source: PreImageError::Crossing { curves: [0, 0], at, .. }, .. }) => {
            assert!(at.truncate().distance(DVec2::new(0.013, 0.007)) < 1e-3, "{at}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_open_curve_is_refused() {
    #[derive(Debug)]
    struct Open;
    impl Curve for Open {
        fn position(&self, u: f64) -> DVec3 {
            DVec3::new(u, 0.0, 0.0)
        }
    }
    let (plate, _) = plate();
    let cut = Cut::new(Arc::new(Open), Heading::Along);
    let found = remesh(plate.clone(), &[cut], &[PreImage::default()], &RemeshOptions::default());
    assert!(matches!(found, Err(RemeshError::Open { curve: 0, gap }) if gap == 1.0));
}

#[test]
fn a_smaller_reach_changes_less() {
    let (plate, walker) = plate();
    let cuts = [on(&walker, circle(DVec2::new(0.01, 0.0), 0.06))];
    let mut last = f64::INFINITY;
    for reach in [0.2, 0.1, 0.05, 0.025] {
        let options = RemeshOptions { reach: Some(reach), ..RemeshOptions::default() };
        let result = run(&plate, &walker, &cuts, &options).expect("a cage");
        let farthest =
            result.changed.iter().map(|v| (result.limit[v.index()].truncate() - DVec2::new(0.01, 0.0)).length() - 0.06);
        let farthest = farthest.fold(0.0, f64::max);
        assert!(farthest <= reach && farthest <= last, "{farthest} of {reach}");
        last = farthest;
        judge(&plate, &cuts, &result);
    }
}

/// A ring between two circles, as wide as told.
fn ring(walker: &Arc<Walker>, width: f64) -> Vec<Cut> {
    let centre = DVec2::new(0.013, 0.007);
    let outer = circle(centre, 0.08);
    vec![on(walker, circle(centre, 0.08 - width)), on(walker, move |u| outer(1.0 - u))]
}

/// Where boundaries do not come apart each try doubles the faces along them: the work is bounded by how many
/// are split over all, well before tries or levels have come to an end.
#[test]
fn boundaries_that_do_not_come_apart_are_given_up_after_work_that_is_bounded() {
    let (plate, walker) = plate();
    for width in [1e-4, 1e-6] {
        let cuts = ring(&walker, width);
        let images = cuts.iter().map(|c| trace(&plate.mesh, &*walker, &*c.curve, TRACE).expect("a pre-image"));
        let (images, options) = (images.collect(), RemeshOptions::default());
        let mut work = RemeshWork::new(Arc::new(plate.clone()), cuts, images, options).expect("closed curves");
        let why = loop {
            let step = work
                .advance()
                .and_then(|step| if step == RemeshQuantum::Laid { work.relax().map(drop) } else { Ok(()) });
            if let Err(why) = step {
                break why;
            }
            assert!(work.faces_split() < 1 << 17, "{} faces split", work.faces_split());
        };
        let RemeshError::Unresolved { tries, level, .. } = why else { panic!("{why}") };
        assert!(work.faces_split() > 1 << 16 && tries < options.tries && level < options.adapt.finest, "{why}");
    }
}
