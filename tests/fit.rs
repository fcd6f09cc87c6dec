//! Fits reach what the method promises, on every rule, corner and storage.

mod support;

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{CircularArc, Curve, FnCurve};
use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::{CornerRule, CornerTable, Kind, LimitRows, LoopSurface, Rows};
use selvedge_systems::subdivision::chain;
use selvedge_systems::subdivision::fit::{FitError, FitOptions, FitWork, Outcome, Region, Rule, Storage};
use selvedge_systems::subdivision::modify::response;
use selvedge_systems::subdivision::quasi::{BoundaryStencil, CornerStencil};
use selvedge_systems::target::{Projection, Target};
use support::{octant, octant_along, spherical_fan};

fn sphere() -> Arc<dyn Target> {
    Arc::new(Projection(|p: DVec3| p.normalize() * 0.5))
}

fn fit(surface: &LoopSurface, options: FitOptions) -> FitWork {
    let mut work = FitWork::new(Arc::new(surface.clone()), sphere(), options).expect("the options can be met");
    work.run().expect("a sphere has a closest point everywhere");
    work
}

fn maxima(work: &FitWork) -> Vec<f64> {
    work.ladder().iter().map(|rung| rung.max).collect()
}

#[test]
fn least_squares_reach_the_ladder_of_the_octant() {
    let work = fit(&octant("cone(1,2)"), FitOptions::default());
    let bounds = [1.3e-3, 170e-6, 19e-6, 3.5e-6, 0.72e-6, 0.15e-6];
    for (level, (max, bound)) in maxima(&work).iter().zip(bounds).enumerate() {
        assert!(*max <= bound, "level {level}: {max:e} > {bound:e}");
    }
    assert_eq!(work.ladder().len(), bounds.len());
    assert!(work.ladder()[5].mean < 1e-9);
}

/// A curve of which nothing but positions is known, a closure, costs no accuracy: the ladder of the same
/// arc with all its derivatives.
#[test]
fn a_closure_of_positions_reaches_the_same_ladder() {
    let arc = |from: DVec3, to: DVec3| {
        CircularArc::from_axes(DVec3::ZERO, from, to, 0.5, 0.0, FRAC_PI_2).expect("a quarter of a circle")
    };
    let known = octant_along("cone(1,2)", |from, to| Arc::new(arc(from, to)));
    let opaque = octant_along("cone(1,2)", |from, to| {
        let arc = arc(from, to);
        Arc::new(FnCurve::new(move |u| arc.position(u)))
    });
    let ladders = [known, opaque].map(|surface| maxima(&fit(&surface, FitOptions::default())));
    assert_eq!(ladders[0], ladders[1]);
    assert!(ladders[1][5] < 0.15e-6, "{ladders:?}");
}

#[test]
fn the_seeds_stencils_reach_the_ladder_of_the_octant() {
    let mut surface = octant("cone(1,2)");
    surface.corner_rule = CornerRule::Seed;
    let rule = Rule::Quasi { boundary: BoundaryStencil::Cubic, corner: CornerStencil::Mean };
    let work = fit(&surface, FitOptions { rule, ..FitOptions::default() });
    let bounds = [13e-3, 2.45e-3, 367e-6, 54e-6, 7.9e-6, 1.34e-6];
    for (level, (max, bound)) in maxima(&work).iter().zip(bounds).enumerate() {
        assert!(*max <= bound, "level {level}: {max:e} > {bound:e}");
    }
}

/// The error at an irregular vertex shrinks by `1 / lambda^2` a level, 4.89 at valence 5, down to
/// the rounding of the coordinates.
#[test]
fn the_error_at_an_irregular_vertex_falls_by_its_eigenvalue_down_to_rounding() {
    let region = Region::Around { vertex: VertexId(0), rings: 8, from_level: 6 };
    let work = fit(&octant("cone(1,2)"), FitOptions { last_level: 16, region, ..FitOptions::default() });
    let here: Vec<f64> = work.ladder().iter().map(|rung| rung.max_here).collect();
    let ratio = (here[5] / here[15]).powf(0.1);
    assert!((4.6..5.2).contains(&ratio), "ratio {ratio}");
    assert!(here[16] < 1e-14, "floor {:e}", here[16]);
}

#[test]
fn storage_in_single_precision_keeps_a_hundred_thousandth_of_the_size() {
    let options = FitOptions { storage: Storage::F32, ..FitOptions::default() };
    let work = fit(&octant("cone(1,2)"), options);
    let last = work.ladder()[5];
    assert!(last.max < 1e-5 * 0.5, "{:e}", last.max);
    for (_, d) in work.details().levels.iter().flatten() {
        assert_eq!(*d, d.as_vec3().as_dvec3());
    }
}

#[test]
fn an_asked_tolerance_is_met_when_measured_by_denser_samples() {
    for tolerance in [1e-4, 1.3e-5, 1e-6, 1e-7] {
        let options = FitOptions { tolerance: Some(tolerance), last_level: 12, ..FitOptions::default() };
        let surface = octant("cone(1,2)");
        let work = fit(&surface, options);
        assert_eq!(work.outcome(), Some(Outcome::Within));
        // The same surface, subdivided evenly to more than 45 points per patch of the last level.
        let fitted = LoopSurface { details: work.details().clone(), ..surface };
        let corners = CornerTable::new(&fitted);
        let mut at = chain::root(&fitted, &corners, &fitted.details);
        for _ in 0..(work.level() + 3).min(7) {
            at = chain::refine(&fitted, &corners, &fitted.details, &at, &at.mesh.all_refinable()).0;
        }
        let rows = LimitRows::new(&fitted, &corners, &at.mesh, |_| true);
        let worst = rows.apply(&at.state).iter().map(|p| (p.length() - 0.5).abs()).fold(0.0, f64::max);
        assert!(worst <= tolerance, "{worst:e} > {tolerance:e}");
    }
}

/// Corners of every valence, at angles that suit them. Convex lattice corners (2, 3) and concave ones
/// (5, 6) lose at least a factor of five a level from level 1 on; the others, weighted by gamma alone,
/// lose at least three.
#[test]
fn corners_of_every_valence_converge() {
    for (valence, degrees, ratio, last) in [
        (2, 50.0, 5.0, 1e-7),
        (2, 90.0, 5.0, 1e-7),
        (3, 90.0, 5.0, 1e-7),
        (3, 150.0, 5.0, 1e-7),
        (4, 150.0, 3.0, 1e-6),
        (5, 240.0, 5.0, 1e-7),
        (5, 270.0, 5.0, 1e-7),
        (6, 300.0, 5.0, 1e-7),
        (7, 300.0, 3.0, 2e-6),
        (8, 330.0, 3.0, 2e-6),
    ] {
        let surface = spherical_fan(valence - 1, 2, f64::to_radians(degrees));
        let work = fit(&surface, FitOptions { last_level: 4, ..FitOptions::default() });
        let ladder = maxima(&work);
        let observed = (ladder[1] / ladder[4]).cbrt();
        assert!(observed > ratio && ladder[4] < last, "valence {valence}, {degrees} degrees: {ladder:?}");
    }
}

/// The response matrix is the derivative of the limit points: moving the effective points moves them
/// by `K x`, exactly, for the scheme is linear. On a border the detail takes the move.
#[test]
fn the_response_is_the_derivative_of_the_limit() {
    for surface in [octant("cone(1,2)"), spherical_fan(4, 2, f64::to_radians(270.0)), spherical_fan(5, 2, 5.2)] {
        let corners = CornerTable::new(&surface);
        let all = |at: &chain::Level| at.mesh.all_refinable();
        let base = chain::root(&surface, &corners, &surface.details);
        let (finer, step) = chain::refine(&surface, &corners, &surface.details, &base, &all(&base));
        let rows =
            LimitRows::new(&surface, &corners, &finer.mesh, |v| finer.mesh.vertices[v as usize].kind == Kind::Interior);
        let movable: Vec<u32> = (0..base.mesh.vertices.len() as u32).collect();
        let matrix = response(&rows, &step, &movable, movable.len());
        let x: Vec<DVec3> = movable
            .iter()
            .map(|&v| DVec3::new((1.7 * f64::from(v)).sin(), (0.3 * f64::from(v)).cos(), f64::from(v).sin()))
            .collect();
        let mut moved = base.clone();
        movable.iter().for_each(|&v| chain::shift(&base.mesh, &mut moved.state, v, x[v as usize]));
        let after = chain::advance(&surface, &corners, &surface.details, &step, &moved, &finer.mesh);
        let (before, after) = (rows.apply(&finer.state), rows.apply(&after));
        for (r, (before, after)) in before.iter().zip(&after).enumerate() {
            let off = (*after - *before - matrix.dot(r, &x)).length();
            assert!(off < 2e-15 * 8.0, "row {r}: {off:e}");
        }
    }
}

/// Scaled by its column norms the response is well conditioned on every level, which is why a fixed
/// number of steps of conjugate gradients is enough.
#[test]
fn the_scaled_response_is_well_conditioned_on_every_level() {
    let surface = octant("cone(1,2)");
    let corners = CornerTable::new(&surface);
    let mut base = chain::root(&surface, &corners, &surface.details);
    for level in 0..3 {
        let (finer, step) = chain::refine(&surface, &corners, &surface.details, &base, &base.mesh.all_refinable());
        let interior = |v: u32| finer.mesh.vertices[v as usize].kind == Kind::Interior;
        let rows = LimitRows::new(&surface, &corners, &finer.mesh, interior);
        let movable: Vec<u32> = (0..base.mesh.vertices.len() as u32).collect();
        let (least, most) = singular_range(&response(&rows, &step, &movable, movable.len()), movable.len());
        assert!(least > 0.15 && most < 2.1, "level {level}: [{least}, {most}]");
        base = finer;
    }
}

/// The least and greatest singular value of `matrix` with columns scaled to unit norm, by power
/// iteration on the normal matrix and on its complement.
fn singular_range(matrix: &Rows, columns: usize) -> (f64, f64) {
    let mut normal = vec![vec![0.0; columns]; columns];
    for r in 0..matrix.len() {
        let (cs, ws) = matrix.row(r);
        for (&a, &wa) in cs.iter().zip(ws) {
            for (&b, &wb) in cs.iter().zip(ws) {
                normal[a as usize][b as usize] += wa * wb;
            }
        }
    }
    let norms: Vec<f64> = (0..columns).map(|c| normal[c][c].sqrt()).collect();
    let scaled = |a: usize, b: usize| normal[a][b] / (norms[a] * norms[b]);
    let largest = |shift: f64| {
        let mut x: Vec<f64> = (0..columns).map(|i| 1.0 + (i as f64).sin()).collect();
        let mut value = 0.0;
        for _ in 0..3000 {
            let y: Vec<f64> = (0..columns)
                .map(|a| {
                    let product: f64 = (0..columns).map(|b| scaled(a, b) * x[b]).sum();
                    if shift > 0.0 { shift * x[a] - product } else { product }
                })
                .collect();
            value = y.iter().map(|v| v * v).sum::<f64>().sqrt();
            x = y.iter().map(|v| v / value).collect();
        }
        value
    };
    let most = largest(0.0);
    let least = most - largest(most);
    (least.max(0.0).sqrt(), most.sqrt())
}

/// Details stored for a surface are the surface: opened anew, it has the limit that was measured.
#[test]
fn details_rebuild_the_surface_that_was_measured() {
    let surface = octant("cone(1,2)");
    let work = fit(&surface, FitOptions { last_level: 4, ..FitOptions::default() });
    let fitted = LoopSurface { details: work.details().clone(), ..surface };
    let mut again = FitWork::new(Arc::new(fitted), sphere(), FitOptions::default()).expect("it can be opened");
    while again.initial().is_none() {
        again.advance().expect("a sphere has a closest point everywhere");
    }
    // Opened at level 2, measured at level 4; those points are among the ones measured at level 6.
    let (fine, coarse) = (work.error_map(), again.error_map());
    for p in &coarse.positions {
        let nearest = fine.positions.iter().map(|q| p.distance(*q)).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-14, "{p} is {nearest:e} from any point measured before");
    }
}

#[test]
fn what_cannot_be_asked_is_refused_by_name() {
    let ask = |tolerance, last_level| {
        let options = FitOptions { tolerance, last_level, ..FitOptions::default() };
        FitWork::new(Arc::new(octant("cone(1,1)")), sphere(), options).err()
    };
    assert!(matches!(ask(Some(0.0), 3), Some(FitError::BadTolerance { .. })));
    assert!(matches!(ask(Some(f64::NAN), 3), Some(FitError::BadTolerance { .. })));
    assert!(matches!(ask(Some(1e-17), 3), Some(FitError::ToleranceBelowRounding { .. })));
    assert!(matches!(ask(None, 60), Some(FitError::TooFine { .. })));
    assert_eq!(ask(Some(1e-6), 3), None);
}

#[test]
fn a_target_without_an_answer_stops_the_fit_with_the_place() {
    for target in [
        Arc::new(Projection(|_: DVec3| DVec3::NAN)) as Arc<dyn Target>,
        Arc::new(Projection(|_: DVec3| panic!("a host's own mistake"))),
    ] {
        let mut work = FitWork::new(Arc::new(octant("cone(1,1)")), target, FitOptions::default()).expect("begins");
        assert!(matches!(work.run(), Err(FitError::Target(_))));
    }
}
