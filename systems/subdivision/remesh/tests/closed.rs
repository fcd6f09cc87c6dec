//! Closed surfaces, irregular vertices under the curve, cages of real shapes.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{Curve, Heading};
use selvedge_components::subdivision::LoopSurface;

use super::super::*;
use super::judge::{Verdict, judge};
use super::support::{Laid, Numbers, Walker, circle, globe, polygon, torus};
use selvedge_components::target::Target;

struct Stage {
    surface: LoopSurface,
    walker: Arc<Walker>,
    /// A typical edge.
    edge: f64,
}

impl Stage {
    fn new(surface: LoopSurface) -> Self {
        let walker = Arc::new(Walker::new(&surface));
        let mesh = &surface.mesh;
        let total: f64 =
            mesh.faces().iter().map(|f| surface.points[f[0].index()].distance(surface.points[f[1].index()])).sum();
        let edge = total / mesh.face_count() as f64;
        Self { surface, walker, edge }
    }

    /// A plane curve on the tangent plane at the point of the surface nearest to `at`, laid on it.
    fn lay(&self, at: DVec3, plane: impl Fn(f64) -> DVec2 + Send + Sync + 'static, corners: Vec<f64>) -> Cut {
        let foot = self.walker.closest(at, None).expect("a foot");
        let normal = self.walker.normal(foot.at.expect("a place"));
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        let curve = Laid { walker: Arc::clone(&self.walker), plane, centre: foot.position, x, y, corners };
        Cut::new(Arc::new(curve), Heading::Along)
    }

    fn cut(&self, cuts: &[Cut]) -> Result<Remeshed, RemeshError> {
        let options = TraceOptions { curve: 1e-6 * self.edge, step: self.edge / 8.0 };
        let images = cuts.iter().enumerate().map(|(curve, cut)| {
            trace(&self.surface.mesh, &*self.walker, &*cut.curve, options)
                .map_err(|source| RemeshError::PreImage { curve, source })
        });
        remesh(self.surface.clone(), cuts, &images.collect::<Result<Vec<_>, _>>()?, &RemeshOptions::default())
    }

    fn sound(&self, name: &str, cuts: &[Cut]) -> (Remeshed, Verdict) {
        let result = self.cut(cuts).unwrap_or_else(|e| panic!("{name}: {e}"));
        let verdict = judge(&self.surface, cuts, &result);
        (result, verdict)
    }
}

/// One curve that goes round the torus the short way, on one side of it.
#[derive(Debug)]
struct Meridian(Arc<Walker>, DVec2);

impl Curve for Meridian {
    fn position(&self, u: f64) -> DVec3 {
        let (s, c) = (core::f64::consts::TAU * u).sin_cos();
        let at = (self.1 * (1.0 + 0.4 * c)).extend(0.4 * s);
        self.0.closest(at, None).expect("a foot").position
    }

    fn closed(&self) -> bool {
        true
    }
}

#[test]
fn a_bore_over_a_pole_of_any_valence_leaves_a_disc_less() {
    for n in 3..=12 {
        let stage = Stage::new(globe(n, 7));
        // A globe of three sides is a narrow thing: a wider circle laid on it has kinks.
        let widest = if n == 3 { 0.45 } else { 0.7 };
        for (k, radius) in [0.15, 0.4, widest].into_iter().enumerate() {
            let cut = stage.lay(DVec3::new(0.03, 0.02, 1.0), circle(DVec2::ZERO, radius), Vec::new());
            let (result, _) = stage.sound(&format!("pole {n} {k}"), &[cut]);
            assert_eq!(result.surface.mesh.euler(), 1);
        }
    }
}

#[test]
fn a_curve_through_a_pole_is_cut_along() {
    for n in [3, 4, 5, 7, 9, 12] {
        let stage = Stage::new(globe(n, 7));
        // It runs through the very pole.
        let cut = stage.lay(DVec3::Z, circle(DVec2::new(0.3, 0.0), 0.3), Vec::new());
        let (result, _) = stage.sound(&format!("through {n}"), &[cut]);
        assert_eq!(result.surface.mesh.euler(), 1);
    }
}

#[test]
fn one_meridian_does_not_separate_a_torus_and_two_do() {
    let stage = Stage::new(torus(16, 10));
    let meridian = |x, y, heading| {
        let curve: Arc<dyn Curve> = Arc::new(Meridian(Arc::clone(&stage.walker), DVec2::new(x, y)));
        Cut::new(curve, heading)
    };
    let one = stage.cut(&[meridian(0.8, 0.6, Heading::Along)]);
    assert!(matches!(one, Err(RemeshError::DoesNotSeparate { curve: 0, .. })), "{one:?}");
    // Two that belong together leave a tube; the turned ones leave the rest of it.
    for turned in [false, true] {
        let [a, b] = if turned { [Heading::Against, Heading::Along] } else { [Heading::Along, Heading::Against] };
        let cuts = [meridian(0.8, 0.6, a), meridian(-0.8, 0.6, b)];
        let (result, _) = stage.sound(&format!("tube {turned}"), &cuts);
        assert_eq!((result.surface.mesh.euler(), result.surface.mesh.border_loops().len()), (0, 2));
        // Each as a set of its own has to separate the surface by itself.
        let alone = [cuts[0].clone().of_set(0), cuts[1].clone().of_set(1)];
        let refused = stage.cut(&alone);
        assert!(matches!(refused, Err(RemeshError::DoesNotSeparate { curve: 0, .. })), "{refused:?}");
    }
}

#[test]
fn bores_in_a_torus_keep_its_handle() {
    let stage = Stage::new(torus(16, 10));
    let mut cuts = vec![stage.lay(DVec3::new(1.4, 0.0, 0.1), circle(DVec2::ZERO, 0.15), Vec::new())];
    cuts.push(stage.lay(DVec3::new(-1.0, 0.3, 0.5), circle(DVec2::ZERO, 0.05), Vec::new()));
    let (result, _) = stage.sound("torus", &cuts);
    assert_eq!(result.surface.mesh.euler(), -2);
}

#[test]
fn random_trims_of_globes_leave_a_sound_cage() {
    let mut numbers = Numbers(23);
    let count = std::env::var("SELVEDGE_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    let mut failed = Vec::new();
    for case in 0..count {
        let stage = Stage::new(globe(3 + (numbers.next() * 10.0) as u32, 4 + (numbers.next() * 6.0) as u32));
        let at = DVec3::new(numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0), numbers.between(-1.0, 1.0));
        let radius = numbers.between(0.2, 1.5) * stage.edge;
        let radius = radius.min(0.6);
        let cut = if numbers.next() < 0.5 {
            stage.lay(at, circle(DVec2::ZERO, radius), Vec::new())
        } else {
            let sides = 3 + (numbers.next() * 4.0) as usize;
            let points = (0..sides).map(|k| circle(DVec2::ZERO, radius)(k as f64 / sides as f64)).collect();
            let (plane, corners) = polygon(points);
            stage.lay(at, plane, corners)
        };
        match stage.cut(std::slice::from_ref(&cut)) {
            Ok(result) => {
                judge(&stage.surface, &[cut], &result);
                assert_eq!(result.surface.mesh.euler(), 1);
            }
            Err(why) => failed.push(format!("{case}: {} {why}", radius / stage.edge)),
        }
    }
    assert!(failed.is_empty(), "{} of {count} failed\n{}", failed.len(), failed.join("\n"));
}
