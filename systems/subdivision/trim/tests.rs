//! Whole trims, without a world.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::budget::Budgets;
use selvedge_components::curve::{Circle, Heading};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::TrimOptions;

use super::{Ground, LocateWork, TrimWork};
use crate::projected_curve::{Pick, ProjectedCurve};
use crate::subdivision::remesh::Cut;
use crate::subdivision::remesh::tests::support::plate8;

fn bore(ground: &Ground, centre: DVec2, radius: f64) -> Cut {
    let circle = Circle::new(centre.extend(0.1), DVec3::Z, radius).expect("a circle");
    let curve = ProjectedCurve::new(Arc::new(circle), DVec3::NEG_Z, Arc::clone(&ground.index), Pick::First);
    Cut::new(Arc::new(curve.expect("a direction")), Heading::Against)
}

/// The bore of [Litke et al. 2001, Fig. 14], asked for as exactly as they measured it, and more.
#[test]
fn the_error_asked_for_is_the_error_delivered() {
    let ground = Arc::new(Ground::new(Arc::new(plate8()), 0).expect("sound"));
    let cut = bore(&ground, DVec2::new(0.013, -0.007), 0.06);
    for (eps, levels) in [(13e-6, 3), (1e-6, 4)] {
        let tolerance = Tolerance { fit: eps, chord: eps, curve: eps };
        let located = LocateWork::new(Arc::clone(&ground), vec![cut.clone()], TrimOptions::default(), Some(tolerance));
        let located = located.expect("a trim").run().expect("a curve");
        let mut work = TrimWork::on_all(Arc::clone(&ground), vec![located]);
        let fit = work.run(&Budgets::default()).expect("a bore");
        let report = work.report(&fit).expect("a report");
        assert!(report.ladder.len() <= levels, "{eps}: {} levels", report.ladder.len());
        let (found, at) = report.audit.greatest();
        assert!(found <= eps && found > 0.1 * eps, "{eps}: {found} at {at}");
        assert!(report.audit.border_samples >= 100 && report.audit.samples > 10_000);
        assert_eq!((report.audit.loops, report.audit.euler), (2, 0));
    }
}
