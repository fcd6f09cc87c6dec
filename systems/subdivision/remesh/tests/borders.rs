//! Curves that cross a border.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{Curve, Heading};
use selvedge_components::subdivision::{Border, LoopSurface};

use super::super::*;
use super::judge::picture;
use super::support::{Walker, circle, lattice, polygon};

/// A circle in the plane z = 0.
struct Flat<F>(F);

impl<F> core::fmt::Debug for Flat<F> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Flat")
    }
}

impl<F: Fn(f64) -> DVec2 + Send + Sync> Curve for Flat<F> {
    fn position(&self, u: f64) -> DVec3 {
        (self.0)(u).extend(0.0)
    }

    fn closed(&self) -> bool {
        true
    }
}

fn cut_across(
    plate: &LoopSurface,
    plane: impl Fn(f64) -> DVec2 + Send + Sync + 'static,
    heading: Heading,
) -> (Vec<Cut>, Result<Remeshed, RemeshError>) {
    let walker = Walker::new(plate);
    let cut = Cut::new(Arc::new(Flat(plane)), heading);
    let options = TraceOptions { curve: 1e-9, step: 0.05 / 8.0 };
    let images = trace_parts(&plate.mesh, &walker, &*cut.curve, options).expect("pre-images");
    let cuts = vec![cut; images.len()];
    let result = remesh(plate.clone(), &cuts, &images, &RemeshOptions::default());
    (cuts, result)
}

#[test]
fn a_bore_over_the_edge_of_a_plate_takes_a_bite() {
    let plate = lattice(12, 0.05, |_, _| 0.0);
    for (k, centre) in
        [DVec2::new(0.29, 0.013), DVec2::new(0.25, -0.04), DVec2::new(-0.02, 0.33), DVec2::new(0.35, 0.0)]
            .into_iter()
            .enumerate()
    {
        let (cuts, result) = cut_across(&plate, circle(centre, 0.1), Heading::Along);
        let result = result.unwrap_or_else(|e| panic!("{centre}: {e}"));
        picture(&format!("bite{k}.svg"), &result);
        assert_eq!(cuts.len(), 1);
        let mesh = &result.surface.mesh;
        assert_eq!(mesh.euler(), 1);
        assert_eq!(mesh.border_loops().len(), 1);
        // Four sides, one of them in two parts, and the bite.
        assert_eq!(result.surface.sides.len(), 6);
        let given: Vec<_> = result.surface.sides.iter().filter(|s| matches!(s.border, Border::Given { .. })).collect();
        assert_eq!(given.len(), 1);
        let ends = [given[0].vertices[0], given[0].vertices[given[0].vertices.len() - 1]];
        for v in ends {
            assert_eq!(mesh.valence(v), 3);
            let at = result.limit[v.index()];
            let on_edge = (at.x.abs() - 0.3).abs().min((at.y.abs() - 0.3).abs());
            assert!(on_edge < 1e-8 && ((at.truncate() - centre).length() - 0.1).abs() < 1e-12, "{at}");
        }
        for &v in &given[0].vertices[1..given[0].vertices.len() - 1] {
            assert_eq!(mesh.valence(v), 4);
        }
    }
}

#[test]
fn a_band_across_a_plate_leaves_two_parts() {
    let plate = lattice(12, 0.05, |_, _| 0.0);
    // A long ellipse over both edges.
    let ellipse = |u: f64| {
        let p = circle(DVec2::ZERO, 1.0)(u);
        DVec2::new(0.011 + 0.6 * p.x, 0.007 + 0.05 * p.y)
    };
    let (cuts, result) = cut_across(&plate, ellipse, Heading::Along);
    let result = result.unwrap_or_else(|e| panic!("{e}"));
    picture("band.svg", &result);
    assert_eq!(cuts.len(), 2);
    assert_eq!(result.surface.mesh.euler(), 2);
    assert_eq!(result.surface.mesh.border_loops().len(), 2);
}

#[test]
fn random_bites_leave_one_border() {
    use super::support::Numbers;
    let plate = lattice(12, 0.05, |_, _| 0.0);
    let mut numbers = Numbers(3);
    let count = std::env::var("SELVEDGE_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    let mut failed = Vec::new();
    for case in 0..count {
        let radius = numbers.between(0.02, 0.15);
        let depth = numbers.between(-0.8, 0.8) * radius;
        let along = numbers.between(-0.1, 0.1);
        let turned = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y][case % 4];
        let centre = turned * (0.3 - depth) + turned.perp() * along;
        let (_, result) = cut_across(&plate, circle(centre, radius), Heading::Along);
        match result {
            Ok(result) => {
                assert_eq!(result.surface.mesh.euler(), 1);
                assert_eq!(result.surface.mesh.border_loops().len(), 1);
                assert_eq!(result.surface.sides.len(), 6);
            }
            Err(why) => failed.push(format!("{case}: {centre} {radius}: {why}")),
        }
    }
    assert!(failed.is_empty(), "{} of {count} failed\n{}", failed.len(), failed.join("\n"));
}

/// A part of a closed curve that begins before the curve's end runs on over it, through a corner there.
#[test]
fn a_corner_at_which_a_curve_begins_is_one_for_a_part_that_runs_over_it() {
    let plate = lattice(12, 0.05, |_, _| 0.0);
    for heading in [Heading::Along, Heading::Against] {
        // The tip of a wedge over the edge of the plate, walked from the tip on.
        let (plane, corners) = polygon(vec![DVec2::new(0.011, 0.2), DVec2::new(0.1, 0.4), DVec2::new(-0.1, 0.41)]);
        let curve = Cornered { plane, corners };
        let cut = Cut::new(Arc::new(curve), heading);
        let options = TraceOptions { curve: 1e-9, step: 0.05 / 8.0 };
        let images = trace_parts(&plate.mesh, &Walker::new(&plate), &*cut.curve, options).expect("pre-images");
        assert_eq!(images.len(), 1);
        let result = remesh(plate.clone(), &[cut], &images, &RemeshOptions::default());
        let result = result.unwrap_or_else(|e| panic!("{heading:?}: {e}"));
        let border = |v: &selvedge_components::mesh::VertexId| result.surface.mesh.is_border(*v);
        let mut at = (0..result.surface.points.len()).map(selvedge_components::mesh::VertexId::new).filter(border);
        assert!(at.any(|v| result.limit[v.index()] == DVec3::new(0.011, 0.2, 0.0)), "{heading:?}");
    }
}

/// A closed curve in the plane z = 0 that has corners.
struct Cornered<F> {
    plane: F,
    corners: Vec<f64>,
}

impl<F> core::fmt::Debug for Cornered<F> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Cornered")
    }
}

impl<F: Fn(f64) -> DVec2 + Send + Sync> Curve for Cornered<F> {
    fn position(&self, u: f64) -> DVec3 {
        (self.plane)(u).extend(0.0)
    }

    fn corners(&self) -> &[f64] {
        &self.corners
    }

    fn closed(&self) -> bool {
        true
    }
}
