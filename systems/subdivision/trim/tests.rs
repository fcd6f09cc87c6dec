//! Whole trims, without a world.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::budget::Budgets;
use selvedge_components::curve::{Circle, Heading};
use selvedge_components::mesh::{FaceId, VertexId};
use selvedge_components::subdivision::{FaceCode, LoopSurface};
use selvedge_components::tolerance::Tolerance;
use selvedge_components::trim::{TrimAuditFault, TrimFault, TrimOptions, TrimQuantum};

use super::audit::TrimAuditWork;
use super::{Ground, LocateWork, TrimWork};
use crate::projected_curve::{Pick, ProjectedCurve};
use crate::subdivision::fit::FitWork;
use crate::subdivision::remesh::tests::support::plate8;
use crate::subdivision::remesh::{Cut, Remeshed};

fn bore(ground: &Ground, centre: DVec2, radius: f64) -> Cut {
    let circle = Circle::new(centre.extend(0.1), DVec3::Z, radius).expect("a circle");
    let curve = ProjectedCurve::new(Arc::new(circle), DVec3::NEG_Z, Arc::clone(&ground.index), Pick::First);
    Cut::new(Arc::new(curve.expect("a direction")), Heading::Against)
}

/// A bore that is done, with its fit.
fn done(ground: &Arc<Ground>, eps: f64) -> (TrimWork, FitWork) {
    let tolerance = Tolerance { fit: eps, chord: eps, curve: eps };
    let cut = bore(ground, DVec2::new(0.013, -0.007), 0.06);
    let located = LocateWork::new(Arc::clone(ground), vec![cut], TrimOptions::default(), Some(tolerance));
    let located = located.expect("a trim").run().expect("a curve");
    let mut work = TrimWork::on_all(Arc::clone(ground), vec![located]);
    let fit = work.run(&Budgets::default()).expect("a bore");
    (work, fit)
}

/// The bore of [Litke et al. 2001, Fig. 14], asked for as exactly as they measured it, and more.
#[test]
fn the_error_asked_for_is_the_error_delivered() {
    let ground = Arc::new(Ground::new(Arc::new(plate8()), 0).expect("sound"));
    for (eps, levels) in [(13e-6, 3), (1e-6, 4)] {
        let (work, fit) = done(&ground, eps);
        let report = work.report(&fit).expect("a report");
        assert!(report.ladder.len() <= levels, "{eps}: {} levels", report.ladder.len());
        let (found, at) = report.audit.greatest();
        assert!(found <= eps && found > 0.1 * eps, "{eps}: {found} at {at}");
        assert!(report.audit.border_samples >= 100 && report.audit.samples > 10_000);
        assert_eq!((report.audit.loops, report.audit.euler), (2, 0));
    }
}

/// What an audit says of a sound bore after `change`.
fn faults_after(change: impl FnOnce(&mut LoopSurface, &mut Remeshed)) -> Vec<TrimAuditFault> {
    const EPS: f64 = 13e-6;
    let ground = Arc::new(Ground::new(Arc::new(plate8()), 0).expect("sound"));
    let (work, _) = done(&ground, EPS);
    let mut surface = LoopSurface::clone(work.result().expect("a result"));
    let mut remeshed = Remeshed::clone(work.remeshed().expect("a cage"));
    change(&mut surface, &mut remeshed);
    let options = TrimOptions::default();
    let audit = TrimAuditWork::new(ground, Arc::new(remeshed), Arc::new(surface), Some(EPS), &options);
    let mut audit = audit.expect("a finite surface");
    loop {
        match audit.advance() {
            Ok(TrimQuantum::Finished) => return Vec::new(),
            Ok(_) => {}
            Err(TrimFault::Audit { faults }) => return faults,
            Err(other) => panic!("{other}"),
        }
    }
}

#[test]
fn an_audit_finds_what_was_tampered_with() {
    assert_eq!(faults_after(|_, _| {}), []);
    let off = faults_after(|surface, _| surface.details.levels[0].iter_mut().for_each(|d| d.1 *= 1.5));
    assert!(matches!(off[..], [TrimAuditFault::Distance { .. }, ..]), "{off:?}");
    let lost = faults_after(|_, remeshed| remeshed.fates.truncate(remeshed.fates.len() - 1));
    assert!(matches!(lost[..], [TrimAuditFault::Cover { .. }]), "{lost:?}");
    let twice = faults_after(|surface, _| surface.sides.extend(surface.sides.last().cloned()));
    assert!(matches!(twice[..], [TrimAuditFault::Border { .. }]), "{twice:?}");
}

#[test]
fn an_audit_finds_the_least_change_beyond_the_region() {
    // The last digit of a control point that no face of the region has.
    let nudged = faults_after(|surface, remeshed| {
        let inside = |f: FaceId| remeshed.omega.binary_search(&FaceCode::root(f)).is_ok();
        let beyond = |v: &VertexId| !surface.mesh.ring(*v).any(|h| inside(h.face()));
        let v = (0..surface.mesh.vertex_count()).map(VertexId::new).find(beyond).expect("a corner of the plate");
        surface.points[v.index()].z += 1e-16;
    });
    assert!(matches!(nudged[..], [TrimAuditFault::Outside { .. }, ..]), "{nudged:?}");
    // A region that leaves out a face around a vertex that has changed.
    let short = faults_after(|_, remeshed| remeshed.omega.truncate(remeshed.omega.len() / 2));
    assert!(short.iter().any(|fault| matches!(fault, TrimAuditFault::Outside { .. })), "{short:?}");
}
