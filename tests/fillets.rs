//! Rounded corners of any size.

mod support;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge::curve::{CircularArc, Concatenation, Curve, Extent, Heading, Segment};
use selvedge::mesh::VertexId;
use selvedge::spawn_curve;
use selvedge::subdivision::remesh::RemeshError;
use selvedge::trim::TrimFault;
use support::plate::{Plate, TOLERANCE, laid};

/// A rectangle of `size` about `centre` with corners rounded by `radius`, counter-clockwise.
fn rounded(centre: DVec2, size: DVec2, radius: f64) -> Concatenation {
    let half = 0.5 * size - DVec2::splat(radius);
    let mut pieces: Vec<Arc<dyn Curve>> = Vec::new();
    let corners = [DVec2::new(1.0, 1.0), DVec2::new(-1.0, 1.0), DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0)];
    for (k, corner) in corners.iter().enumerate() {
        let middle = (centre + half * *corner).extend(0.0);
        let out = DVec2::from_angle(std::f64::consts::FRAC_PI_2 * k as f64).extend(0.0);
        let start = middle + radius * out;
        let arc = CircularArc::about(middle, DVec3::Z, start, std::f64::consts::FRAC_PI_2).expect("an arc");
        let end = arc.position(1.0);
        let next = corners[(k + 1) % 4];
        let to = (centre + half * next).extend(0.0) + radius * DVec3::Z.cross(out);
        pieces.push(Arc::new(arc));
        pieces.push(Arc::new(Segment { start: end, end: to }));
    }
    Concatenation::new(pieces, Extent::Closed, 1e-12).expect("a rounded rectangle")
}

/// The corners are followed wherever they lie in the faces of the cage, which is fine near them alone.
#[test]
fn fillets_of_any_size_are_followed_and_cost_no_more_than_they_must() {
    let (centre, size) = (DVec2::new(0.013, -0.007), DVec2::new(0.06, 0.04));
    for (heading, radius) in [
        (Heading::Against, 1e-5),
        (Heading::Along, 2e-5),
        (Heading::Against, 1e-4),
        (Heading::Along, 2e-4),
        (Heading::Against, 1e-3),
        (Heading::Along, 1e-3),
        (Heading::Along, 8e-3),
    ] {
        let mut plate = Plate::new();
        let curve = laid(&plate.surface, rounded(centre, size, radius));
        let curve = spawn_curve(&mut plate.world, curve);
        let trim = plate.cut(curve, heading);
        plate.settle();
        let report = plate.report(trim);
        let told = format!("{heading:?}, {radius} m");
        assert!(report.audit.greatest().0 <= TOLERANCE, "{told}");
        assert!(report.cage.worst_shape > 0.02, "{told}: {}", report.cage.worst_shape);
        // Each halving of the fillets is another level around all four.
        let most = if radius < 1e-4 { 50_000 } else { 20_000 };
        assert!(report.cage.faces < most, "{told}: {} faces", report.cage.faces);
        let result = plate.result().expect("a result");
        let on_border = |v: &usize| result.mesh.is_border(VertexId::new(*v));
        let border: Vec<DVec2> =
            (0..result.points.len()).filter(on_border).map(|v| result.points[v].truncate() - centre).collect();
        let tip = 0.5 * size;
        for signs in [DVec2::ONE, DVec2::NEG_ONE, DVec2::new(1.0, -1.0), DVec2::new(-1.0, 1.0)] {
            let corner = tip * signs;
            let near = border.iter().filter(|p| (**p - corner).abs().max_element() < 1.6 * radius).count();
            assert!(near >= 2, "{told}: {near} vertices along the fillet at {corner}");
        }
    }
}

/// Corners that are sharper than any cage can follow are named, with how fine a cage can be there.
#[test]
fn a_fillet_below_the_finest_faces_is_told_with_their_size() {
    let mut plate = Plate::new();
    let curve = laid(&plate.surface, rounded(DVec2::new(0.013, -0.007), DVec2::new(0.06, 0.04), 1e-6));
    let (shape, curve) = (Arc::clone(&curve), spawn_curve(&mut plate.world, curve));
    let trim = plate.cut(curve, Heading::Against);
    plate.settle();
    let why = plate.failure(trim);
    let TrimFault::Remesh(RemeshError::TooFine { curve: 0, u, at, size, what, .. }) = *why else { panic!("{why}") };
    assert_eq!(shape.position(u), at);
    let corner = (at.truncate() - DVec2::new(0.013, -0.007)).abs() - DVec2::new(0.03, 0.02);
    assert!(corner.length() < 1e-5, "{why}");
    assert!((1e-6..1e-5).contains(&size) && what.contains("bends"), "{why}");
}
