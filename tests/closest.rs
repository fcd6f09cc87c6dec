//! The closest point is the closest of all, wherever the search begins.

#[path = "support/draw.rs"]
mod draw;
mod support;

use std::sync::Arc;

use draw::{Draw, add_details, ball, disc};
use glam::{DVec2, DVec3};
use selvedge_components::curve::Heading;
use selvedge_components::evaluate::{Evaluate, Jet, SurfacePoint};
use selvedge_components::mesh::{FaceId, HalfedgeId};
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::target::Target;
use selvedge_systems::closest::{Closest, ClosestError, IndexError, Search, SurfaceIndex, SurfaceTarget, Walk};
use selvedge_systems::subdivision::fit::{FitOptions, FitWork};
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
            let base = samples[draw.remainder(samples.len())];
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

/// Beyond a border the foot lies on it, straight across, or at a corner.
#[test]
fn feet_of_points_beyond_a_border_lie_on_it() {
    let index = index(octant("cone(1,2)"));
    let limit = index.surface();
    let mut draw = Draw(19);
    let mut corners = 0;
    for k in 0..300 {
        // Below the octant and around it: the surface rises inward from its lower quarter circle, so
        // no inner point is nearer than the circle.
        let around = DVec2::new(draw.unit(), draw.unit()).normalize() * (0.5 + 0.3 * draw.unit());
        let point = around.extend(-draw.unit());
        let found = index.closest(point).expect("a finite point");
        let on_circle = DVec2::new(point.x, point.y).normalize() * 0.5;
        let expected = on_circle.extend(0.0);
        assert!(found.position.distance(expected) < 1e-12, "{k}: {} instead of {expected}", found.position);
        let jet = limit.jet(found.at);
        assert!((jet.position - found.position).length() < 1e-14);
        let corner = DVec3::new(-draw.unit(), -draw.unit(), 1.0 + draw.unit());
        corners += usize::from(index.closest(corner).expect("finite").position.distance(DVec3::Z * 0.5) < 1e-13);
    }
    assert_eq!(corners, 300, "points over a corner have their feet there");
}

fn flattened(height: f64) -> LoopSurface {
    let (points, triangles) = ball(0, 7);
    let flat = |p: &DVec3| DVec3::new(p.x, p.y, height * p.z);
    support::plain(points.iter().map(flat).collect(), &triangles)
}

/// Near one sheet of a thin body a search everywhere finds the nearer sheet, a search around a hint
/// the sheet that the hint lies on.
#[test]
fn a_hint_decides_between_the_sheets_of_a_thin_body() {
    let index = Arc::new(index(flattened(0.01)));
    let around = SurfaceTarget { search: Search::AroundHint, ..SurfaceTarget::new(Arc::clone(&index)) };
    let everywhere = SurfaceTarget::new(Arc::clone(&index));
    let mut draw = Draw(20);
    for k in 0..200 {
        let inside = DVec3::new(draw.unit() - 0.5, draw.unit() - 0.5, 0.0) * 0.8;
        let lower = index.first_hit(inside, -DVec3::Z, [0.0, 1.0]).expect("there is a sheet below");
        let upper = index.first_hit(inside, DVec3::Z, [0.0, 1.0]).expect("there is a sheet above");
        let point = inside.lerp(upper.position, 0.5);
        let hinted = around.closest(point, Some(lower.at)).expect("finite");
        assert!(hinted.position.z < 0.0, "{k}: {} is not on the lower sheet", hinted.position);
        let nearest = everywhere.closest(point, Some(lower.at)).expect("finite");
        assert!(nearest.position.z > 0.0, "{k}: {} is not on the nearer sheet", nearest.position);
        assert!(nearest.position.distance(point) < hinted.position.distance(point));
    }
}

#[test]
fn equally_near_places_are_told_apart() {
    let (points, triangles) = ball(0, 7);
    let round = points.iter().map(|p| p.normalize()).collect();
    let index = index(support::plain(round, &triangles));
    let Err(ClosestError::Ambiguous { point, places }) = index.closest_alone(DVec3::ZERO, 0.01) else {
        panic!("the centre of a ball is as near to its one side as to the other");
    };
    assert_eq!(point, DVec3::ZERO);
    assert!(places[0].position.dot(places[1].position) < 0.0, "{places:?}");
    let mut draw = Draw(21);
    for _ in 0..100 {
        let near = draw.vector().normalize() * (0.5 + draw.unit());
        let alone = index.closest_alone(near, 0.01).expect("there is one nearest place");
        assert_eq!(alone, index.closest(near).expect("finite"));
    }
}

#[test]
fn what_is_not_finite_is_an_error() {
    let index = Arc::new(index(octant("cone(1,1)")));
    for bad in [DVec3::NAN, DVec3::INFINITY, DVec3::new(0.0, f64::NEG_INFINITY, 1.0)] {
        assert!(matches!(index.closest(bad), Err(ClosestError::NotFinite { .. })));
        assert!(matches!(index.closest_alone(bad, 0.1), Err(ClosestError::NotFinite { .. })));
        assert!(SurfaceTarget::new(Arc::clone(&index)).closest(bad, None).is_err());
    }
    // Hints from elsewhere, and far away points, are merely slow.
    let nowhere = SurfacePoint::new(FaceId(1 << 20), 0.1, 0.1);
    let beyond = SurfacePoint::new(FaceId(0), f64::NAN, 17.0);
    for hint in [nowhere, beyond] {
        for point in [DVec3::ONE, DVec3::splat(1e100), DVec3::splat(1e-300), DVec3::splat(f64::MAX)] {
            let found = index.closest_from(point, hint).expect("a finite point");
            assert!(found.position.is_finite());
        }
    }
}

/// A surface without faces, or one that is NaN on its last face.
struct Broken(usize);

impl Evaluate for Broken {
    fn face_count(&self) -> usize {
        self.0
    }

    fn jet(&self, at: SurfacePoint) -> Jet {
        let z = if at.face.index() + 1 == self.0 { f64::NAN } else { 0.0 };
        Jet { position: at.st.extend(z), ds: DVec3::X, dt: DVec3::Y }
    }
}

impl Walk for Broken {
    fn across(&self, _: FaceId, _: usize) -> Option<(FaceId, usize)> {
        None
    }

    fn is_settled(&self, _: u32, _: FaceCode) -> bool {
        true
    }
}

#[test]
fn surfaces_that_cannot_be_searched_are_refused() {
    assert_eq!(SurfaceIndex::new(Arc::new(Broken(0))).err(), Some(IndexError::Empty));
    let Err(IndexError::NotFinite { at }) = SurfaceIndex::new(Arc::new(Broken(3))) else { panic!("it is NaN") };
    assert_eq!(at.face, FaceId(2));
}

#[test]
fn threads_do_not_change_the_bits() {
    let limit = Arc::new(LimitSurface::new(Arc::new(octant("cone(1,2)"))).expect("a sound surface"));
    let answers = |threads: usize| -> Vec<Closest> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let index = SurfaceIndex::new(Arc::clone(&limit)).expect("a finite surface");
            let mut draw = Draw(22);
            let points: Vec<DVec3> = (0..500).map(|_| draw.vector()).collect();
            selvedge_systems::parallel::map_in_order(points.len(), |i| index.closest(points[i]).expect("finite"))
        })
    };
    let one = answers(1);
    for threads in 2..=4 {
        assert_eq!(answers(threads), one, "{threads} threads");
    }
}

/// The distance from a surface to itself is rounding, at every level that a fit measures.
#[test]
fn a_surface_is_its_own_best_fit() {
    let mut surface = disc(6, 2, 4, Heading::Along);
    add_details(&mut surface, 2, 0.02, 6);
    let target = SurfaceTarget::new(Arc::new(index(surface.clone())));
    let options = FitOptions { last_level: 2, ..FitOptions::default() };
    let mut work = FitWork::new(Arc::new(surface), Arc::new(target), options).expect("the options can be met");
    work.run().expect("every point has a closest one");
    for rung in work.ladder() {
        assert!(rung.max < 1e-13, "level {}: {:e}", rung.level, rung.max);
    }
}

/// Where the coordinates of a place on a border sum to 1 and their differences do not, the search gets away
/// from where it begins all the same.
#[test]
fn points_of_a_border_are_found_on_it() {
    for (name, surface) in surfaces() {
        let mesh = Arc::clone(&surface.mesh);
        let index = index(surface);
        let on_border = |h: &HalfedgeId| mesh.twin(*h).is_none();
        let border = (0..3 * mesh.face_count()).map(HalfedgeId::new).filter(on_border);
        for h in border {
            for k in 0..=97 {
                let share = f64::from(k) / 97.0;
                let mut weights = [0.0; 3];
                (weights[h.corner()], weights[(h.corner() + 1) % 3]) = (1.0 - share, share);
                let on = index.surface().position(SurfacePoint::new(h.face(), weights[1], weights[2]));
                // A little aside, as a sum in another order would give it.
                for aside in [0.0, 1e-16, -1e-16] {
                    let sought = on + DVec3::splat(aside);
                    let found = index.closest(sought).expect("finite").distance;
                    assert!(found <= 1e-12, "{name}: {found:e} from {on}");
                }
            }
        }
    }
}
