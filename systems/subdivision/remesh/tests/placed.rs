//! What is refused is refused at a place: the parameter told is the curve's own, and the point told is
//! the curve's point there, whatever stretch of the curve it lies on.

use core::f64::consts::TAU;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{Curve, CurveParameters, Extent, Heading, ParameterError};
use selvedge_components::subdivision::{Border, LoopSurface, Side};

use super::super::*;
use super::support::{Walker, circle, lattice};

/// A curve over a flat plate.
struct Over<F> {
    place: F,
    corners: Vec<f64>,
}

impl<F> core::fmt::Debug for Over<F> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Over")
    }
}

impl<F: Fn(f64) -> DVec3 + Send + Sync> Curve for Over<F> {
    fn position(&self, u: f64) -> DVec3 {
        assert!((0.0..=1.0).contains(&u), "a curve has no place at {u}");
        (self.place)(u)
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        true
    }
}

/// A closed plane curve from `from` on.
fn flat(plane: impl Fn(f64) -> DVec2 + Send + Sync + 'static, from: f64, heading: Heading) -> Cut {
    let place = move |u: f64| plane((u + from).rem_euclid(1.0)).extend(0.0);
    Cut::new(Arc::new(Over { place, corners: Vec::new() }), heading)
}

struct Plate {
    surface: LoopSurface,
    walker: Walker,
}

impl Plate {
    fn new() -> Self {
        let surface = lattice(12, 0.05, |_, _| 0.0);
        let walker = Walker::new(&surface);
        Self { surface, walker }
    }

    fn cut(&self, whole: &[Cut], options: &RemeshOptions) -> (Vec<Cut>, Result<Remeshed, RemeshError>) {
        let trace = TraceOptions { curve: 1e-6, step: 0.05 / 8.0 };
        let (mut cuts, mut images) = (Vec::new(), Vec::new());
        for (curve, cut) in whole.iter().enumerate() {
            match trace_parts(&self.surface.mesh, &self.walker, &*cut.curve, trace) {
                Ok(parts) => parts.into_iter().for_each(|part| {
                    cuts.push(cut.clone());
                    images.push(part);
                }),
                Err(source) => return (whole.to_vec(), Err(RemeshError::PreImage { curve, source })),
            }
        }
        let made = remesh(self.surface.clone(), &cuts, &images, options);
        (cuts, made)
    }
}

/// What kind an error is, and where it says to be: curves, parameters, and one point for all.
type Told = (&'static str, Vec<(usize, f64)>, DVec3);

fn told(why: &RemeshError) -> Option<Told> {
    Some(match why {
        RemeshError::TooFine { curve, u, at, .. } => ("too fine", vec![(*curve, *u)], *at),
        RemeshError::Unresolved { curve, u, at, .. } => ("unresolved", vec![(*curve, *u)], *at),
        RemeshError::Tangled { curve, u, at } => ("tangled", vec![(*curve, *u)], *at),
        RemeshError::Cusp { curve, u, at, .. } => ("cusp", vec![(*curve, *u)], *at),
        RemeshError::PreImage { curve, source } => match source {
            PreImageError::TooFarOff { u, at, .. } => ("too far off", vec![(*curve, *u)], *at),
            PreImageError::NotFinite { u, .. } => ("not finite", vec![(*curve, *u)], DVec3::NAN),
            PreImageError::Crossing { curves, u, at } => ("crossing", vec![(curves[0], u[0]), (curves[1], u[1])], *at),
            _ => return None,
        },
        _ => return None,
    })
}

/// Chords of an eighth of an edge stand off a curve by less than this, and so do places found on them.
const CHORD: f64 = 5e-4;

/// The kind of an error, whose curves are where it says that they are.
fn placed(name: &str, cuts: &[Cut], why: &RemeshError) -> Option<&'static str> {
    let (kind, places, at) = told(why)?;
    for (k, &(curve, u)) in places.iter().enumerate() {
        let on = cuts[curve].curve.position(u);
        // The second of two places is found by the same chords as the first.
        let allowed = if k > 0 { CHORD } else { 1e-12 };
        let agrees = if at.is_nan() { on.is_nan() } else { on.distance(at) <= allowed };
        assert!(agrees, "{name}: {why}: but curve {curve} is at {on} there");
    }
    Some(kind)
}

/// Cuts whose curves cross each other and the border, each from many parameters on and both ways.
fn crossing_cuts(from: f64, heading: Heading) -> Vec<Cut> {
    let island = if heading == Heading::Along { Heading::Against } else { Heading::Along };
    vec![
        flat(circle(DVec2::new(-0.04, 0.003), 0.07), from, heading),
        flat(circle(DVec2::new(0.05, 0.0), 0.06), 0.37 * from, heading),
        flat(|u| circle(DVec2::new(0.01, 0.0), 0.09)(1.0 - u), 0.71 * from, island),
        flat(circle(DVec2::new(0.01, 0.31), 0.08), from, heading),
        flat(circle(DVec2::new(0.1, 0.3), 0.07), from, heading),
    ]
}

#[test]
fn a_refusal_names_the_parameter_of_the_point_that_it_names() {
    let plate = Plate::new();
    let mut kinds = BTreeMap::new();
    let coarse = AdaptOptions { finest: 0, ..AdaptOptions::default() };
    let limits = [
        ("coarse", RemeshOptions { adapt: coarse, ..RemeshOptions::default() }),
        (
            "one try",
            RemeshOptions {
                tries: 0,
                adapt: AdaptOptions { bend: 10.0, near: 0.1, pieces: 0.1, ..AdaptOptions::default() },
                ..RemeshOptions::default()
            },
        ),
    ];
    for k in 0..8 {
        let from = f64::from(k) / 8.0 + 0.0137;
        for heading in [Heading::Along, Heading::Against] {
            let all = crossing_cuts(from, heading);
            for (name, options) in &limits {
                for chosen in [&all[..1], &all[..2], &all[..3], &all[3..4], &all[3..], &all] {
                    let (cuts, made) = plate.cut(chosen, options);
                    let Err(why) = made else { continue };
                    let name = format!("{name} {from} {heading:?} {}", chosen.len());
                    *kinds.entry(placed(&name, &cuts, &why)).or_insert(0) += 1;
                }
            }
        }
    }
    assert!(kinds[&Some("too fine")] > 30 && kinds[&Some("unresolved")] > 30, "{kinds:?}");
}

#[test]
fn a_curve_that_crosses_itself_is_told_by_both_parameters() {
    let plate = Plate::new();
    let eight = |u: f64| DVec2::new(0.013 + 0.12 * (TAU * u).sin(), 0.007 + 0.06 * (2.0 * TAU * u).sin());
    for k in 0..10 {
        let from = f64::from(k) / 10.0 + 0.003;
        for heading in [Heading::Along, Heading::Against] {
            let (cuts, made) = plate.cut(&[flat(eight, from, heading)], &RemeshOptions::default());
            let why = made.map(drop).expect_err("it crosses itself");
            assert_eq!(placed(&format!("{from} {heading:?}"), &cuts, &why), Some("crossing"), "{why}");
        }
    }
}

/// A part of a closed curve that begins before the curve's end is followed beyond it, and told by the
/// curve's own parameter all the same.
#[test]
fn what_is_wrong_beyond_the_end_of_a_closed_curve_is_told_by_its_own_parameter() {
    let plate = Plate::new();
    // Over an edge of the plate: inside to both sides of its first point, outside in its middle.
    for (height, kind) in [(0.01, "too far off"), (f64::NAN, "not finite")] {
        // Between two looks at the curve, of which there are 64.
        let bump = move |u: f64| if (7.2..7.8).contains(&(64.0 * u)) { height } else { 0.0 };
        let place = {
            let bite = circle(DVec2::new(0.0, -0.3), 0.1);
            move |u: f64| bite((u + 0.75).rem_euclid(1.0)).extend(bump(u))
        };
        let cut = Cut::new(Arc::new(Over { place, corners: Vec::new() }), Heading::Along);
        let (cuts, made) = plate.cut(&[cut], &RemeshOptions::default());
        let why = made.map(drop).expect_err("it is not on the plate");
        assert_eq!(placed(kind, &cuts, &why), Some(kind), "{why}");
    }
}

/// Three curves that nearly meet in one point: whatever is said of it is said of a place there.
#[test]
fn curves_that_all_but_meet_in_one_point_are_told_where_they_do() {
    let plate = Plate::new();
    let mut kinds = BTreeMap::new();
    for k in 0..20 {
        let turn = 0.1 + 0.09 * f64::from(k);
        let aside = 10_f64.powi(-3 - k % 8);
        let through = |angle: f64, off: f64| {
            let centre = DVec2::new(0.011, 0.007) + DVec2::from_angle(turn + angle) * (0.08 + off);
            flat(circle(centre, 0.08), 0.31 * turn, Heading::Along)
        };
        let (cuts, made) =
            plate.cut(&[through(0.0, 0.0), through(1.9, aside), through(4.0, -0.5 * aside)], &RemeshOptions::default());
        let Err(why) = made else { continue };
        *kinds.entry(placed(&format!("{k}"), &cuts, &why)).or_insert(0) += 1;
    }
    assert!(!kinds.is_empty(), "what is too small for any cage is told");
}

/// A border of the plate whose middle the curve passes within some last digits of its parameter: there are
/// none between those of neighbouring vertices once edges are halved a few times.
#[derive(Debug)]
struct Hurried {
    vertices: Vec<(f64, DVec3)>,
}

impl Hurried {
    fn new(points: Vec<DVec3>, digits: f64) -> Self {
        let n = points.len() - 1;
        let u = |i: usize| match i {
            0..=2 => 0.1 * i as f64,
            i if i + 2 >= n => 1.0 - 0.1 * (n - i) as f64,
            i => 0.5 + (i as f64 - 0.5 * n as f64) * digits * f64::EPSILON,
        };
        Self { vertices: points.into_iter().enumerate().map(|(i, at)| (u(i), at)).collect() }
    }
}

impl Curve for Hurried {
    fn position(&self, u: f64) -> DVec3 {
        let k = self.vertices.partition_point(|v| v.0 <= u).clamp(1, self.vertices.len() - 1);
        let [(u0, a), (u1, b)] = [self.vertices[k - 1], self.vertices[k]];
        a.lerp(b, (u - u0) / (u1 - u0))
    }
}

/// The plate, whose lower side is given by a curve that hurries.
fn hurried_plate() -> (Plate, usize) {
    let mut plate = Plate::new();
    let LoopSurface { points, sides, .. } = &mut plate.surface;
    let is_low = |side: &Side| side.vertices.iter().all(|v| points[v.index()].y < -0.29);
    let s = sides.iter().position(is_low).expect("a lower side");
    let hurried = Hurried::new(sides[s].vertices.iter().map(|v| points[v.index()]).collect(), 2.0);
    let u = hurried.vertices.iter().map(|v| v.0).collect();
    let curve = CurveParameters::new(Arc::new(hurried), Extent::Open, u, &[]).expect("they ascend");
    for (v, at) in sides[s].vertices.iter().zip(curve.samples(0)) {
        points[v.index()] = at;
    }
    sides[s].border = Border::Given { curve: Arc::new(curve), first: 0, heading: Heading::Along };
    (plate, s)
}

/// A bore beside such a border halves its edges until two vertices have one parameter. Where nothing else is
/// cut that is told of the source's side; where a curve ends on the side, a finer cage may be what is
/// wanted there, and what is told is that none has helped.
#[test]
fn sides_whose_parameters_come_to_an_end_are_told_by_the_side_or_by_the_curve_that_ends_there() {
    let (plate, s) = hurried_plate();
    let bore = || flat(circle(DVec2::new(0.004, -0.27), 0.02), 0.123, Heading::Along);
    let notch = flat(circle(DVec2::new(-0.251, -0.301), 0.02), 0.123, Heading::Along);
    for tries in [0, RemeshOptions::default().tries] {
        let options = RemeshOptions { tries, ..RemeshOptions::default() };
        match plate.cut(&[bore()], &options).1.map(drop) {
            Err(RemeshError::Parameters { side, u, at, source: ParameterError::NotAscending { .. } }) => {
                assert!(side == s && (u - 0.5).abs() < 1e-15 && (at.y + 0.3).abs() < 1e-15, "u = {u}, {at}");
            }
            other => panic!("{tries}: {other:?}"),
        }
        let (cuts, made) = plate.cut(&[notch.clone(), bore()], &options);
        let why = made.map(drop).expect_err("the side is as it was");
        let RemeshError::Unresolved { what, curve: 0, at, .. } = why else { panic!("{tries}: {why}") };
        assert_eq!(what, "too coarse to tell places along it apart");
        assert!((at.y + 0.3).abs() < 1e-3, "the notch ends on the side, not at {at}");
        assert_eq!(placed("a notch", &cuts, &why), Some("unresolved"));
    }
}
