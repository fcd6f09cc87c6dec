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
    Cut { curve: Arc::new(curve.expect("a direction")), heading: Heading::Against }
}

#[test]
fn a_bore_meets_its_tolerance_and_passes_its_audit() {
    let ground = Arc::new(Ground::new(Arc::new(plate8()), 0).expect("sound"));
    let cut = bore(&ground, DVec2::new(0.013, -0.007), 0.06);
    for fit in [13e-6, 1e-6, 1e-8] {
        let tolerance = Tolerance { fit, chord: fit, curve: fit };
        let clock = std::time::Instant::now();
        let located = LocateWork::new(Arc::clone(&ground), vec![cut.clone()], TrimOptions::default(), Some(tolerance));
        let located = located.expect("a trim").run().expect("a curve");
        let mut work = TrimWork::new(Arc::clone(&ground), vec![located]);
        let fit = work.run(&Budgets::default()).expect("a bore");
        println!("{:?} {:#?}", clock.elapsed(), work.report(&fit).expect("a report"));
    }
}
