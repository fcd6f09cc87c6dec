//! Sources with given and curved borders: thin walls beside them, and curves that leave across them.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::{Circle, Heading};
use selvedge_components::mesh::{FaceId, VertexId};
use selvedge_components::subdivision::{Address, Border, Details, LoopSurface};
use selvedge_components::trim::BorderLine;

use super::super::borders::PlainBorder;
use super::super::*;
use super::judge::{Verdict, judge_union, picture};
use super::support::{Walker, lattice};
use crate::closest::Search;
use crate::subdivision::trim::Ground;

const RADIUS: f64 = 0.2;

/// A flat disc whose rim is a circle.
fn disc() -> LoopSurface {
    let plate = lattice(10, 0.05, |_, _| 0.0);
    let rim = Cut::new(circle(0.0, 0.0, RADIUS), Heading::Along);
    let walker = Walker::new(&plate);
    let options = TraceOptions { curve: 1e-9, step: 0.05 / 8.0 };
    let image = trace(&plate.mesh, &walker, &*rim.curve, options).expect("a pre-image");
    remesh(plate.clone(), &[rim], &[image], &RemeshOptions::default()).expect("a disc").surface
}

/// A circle in the plane z = 0, counter-clockwise: what stays along it is inside.
fn circle(x: f64, y: f64, radius: f64) -> Arc<dyn Curve> {
    Arc::new(Circle::new(DVec3::new(x, y, 0.0), DVec3::Z, radius).expect("a circle"))
}

fn bore(x: f64, y: f64, radius: f64) -> Cut {
    Cut::new(circle(x, y, radius), Heading::Against)
}

/// Cuts with curves that may leave the source: one cut for each part of a curve.
fn cut(source: &LoopSurface, curves: &[Cut], off: f64) -> (Vec<Cut>, Result<Remeshed, RemeshError>) {
    let ground = Ground::new(Arc::new(source.clone()), 0).expect("a ground");
    let target = ground.target(Search::Everywhere);
    let options = TraceOptions { curve: off, step: ground.edge / 8.0 };
    let (mut cuts, mut images) = (Vec::new(), Vec::new());
    for (curve, cut) in curves.iter().enumerate() {
        match trace_parts(&source.mesh, &target, &*cut.curve, options) {
            Ok(parts) => {
                cuts.extend(parts.iter().map(|_| cut.clone()));
                images.extend(parts);
            }
            Err(source) => return (cuts, Err(RemeshError::PreImage { curve, source })),
        }
    }
    let result = remesh(source.clone(), &cuts, &images, &RemeshOptions::default());
    (cuts, result)
}

fn sound(name: &str, source: &LoopSurface, curves: &[Cut]) -> (Remeshed, Verdict) {
    let (cuts, result) = cut(source, curves, 1e-6);
    let result = result.unwrap_or_else(|e| panic!("{name}: {e}"));
    picture(&format!("{name}.svg"), &result);
    let verdict = judge_union(source, &cuts, &result);
    (result, verdict)
}

#[test]
fn walls_to_a_given_rim_are_resolved_down_to_a_tenth_of_a_millimetre() {
    let disc = disc();
    for wall in [0.02, 0.01, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4, 1e-4] {
        let cuts = [bore(RADIUS - 0.03 - wall, 0.003, 0.03)];
        let (result, verdict) = sound(&format!("rim{wall}"), &disc, &cuts);
        assert_eq!(result.surface.mesh.border_loops().len(), 2);
        assert_eq!(result.surface.mesh.euler(), 0);
        assert!(verdict.worst_shape > 0.01, "{wall}: {verdict:?} at {}", verdict.worst_at);
    }
}

#[test]
fn a_bore_through_a_given_rim_ends_on_it_at_two_junctions() {
    let disc = disc();
    for (k, beyond) in [1e-3, 5e-3, 0.02, 0.03, 0.045].into_iter().enumerate() {
        let centre = DVec2::new(RADIUS - 0.03 + beyond, 0.003);
        let (result, _) = sound(&format!("through{k}"), &disc, &[bore(centre.x, centre.y, 0.03)]);
        assert_eq!(result.surface.mesh.border_loops().len(), 1);
        assert_eq!(result.surface.mesh.euler(), 1);
        assert_eq!(result.junctions.len(), 2);
        for junction in &result.junctions {
            assert!((junction.point.length() - RADIUS).abs() < 1e-15 && junction.gap < 1e-15, "{junction:?}");
            assert!((junction.point.truncate().distance(centre) - 0.03).abs() < 1e-15);
        }
        assert_eq!(result.surface.sides.len(), 2);
        rest_of_the_rim_keeps_its_bits(&disc, &result);
    }
}

/// Samples of the rim at vertices that are the source's own and far from the junctions are the same.
fn rest_of_the_rim_keeps_its_bits(source: &LoopSurface, result: &Remeshed) {
    let (then, now) = (&source.sides[0], &result.surface.sides[0]);
    let (Border::Given { curve: before, .. }, Border::Given { curve: after, .. }) = (&then.border, &now.border) else {
        panic!("the rim is given");
    };
    assert_eq!(result.side_origin[0].line, BorderLine::Side(0));
    let mut same = 0;
    for (step, v) in now.vertices.iter().enumerate() {
        let VertexOrigin::Root(root) = result.vertex_origin[v.index()] else { continue };
        let Some(old) = then.vertices.iter().position(|&w| w == root) else { continue };
        let index = |side: &selvedge_components::subdivision::Side, step: usize| {
            side.curve_index(0, step as u64).expect("given")
        };
        let [a, b] = [before.sample(0, index(then, old)), after.sample(0, index(now, step))];
        same += usize::from(a.to_array().map(f64::to_bits) == b.to_array().map(f64::to_bits));
    }
    assert!(2 * same >= then.vertices.len(), "{same} of {}", then.vertices.len());
}

#[test]
fn a_bore_through_a_curved_plain_border_begins_at_its_limit_points() {
    // A flat plate with bent edges.
    let mut plate = lattice(12, 0.05, |_, _| 0.0);
    for p in &mut plate.points {
        let bend = DVec3::new(0.03 * (9.0 * p.y).cos(), 0.02 * (7.0 * p.x).sin(), 0.0);
        *p += bend;
    }
    let borders: Vec<_> = plate.sides.iter().map(|side| PlainBorder::new(&plate, side)).collect();
    for (k, (x, y, radius)) in
        [(0.33, 0.02, 0.06), (0.31, -0.03, 0.1), (-0.25, 0.1, 0.08), (0.05, 0.3, 0.05), (0.02, -0.31, 0.12)]
            .into_iter()
            .enumerate()
    {
        let (result, verdict) = sound(&format!("bent{k}"), &plate, &[bore(x, y, radius)]);
        assert_eq!(result.junctions.len(), 2);
        assert_eq!((result.surface.mesh.euler(), result.surface.mesh.border_loops().len()), (1, 1));
        assert!(verdict.worst_shape > 0.01);
        for junction in &result.junctions {
            let (BorderLine::Side(s), u) = junction.ends[0] else { panic!("the border is older") };
            assert_eq!(borders[s].position(u), junction.point);
            assert!(junction.gap < 1e-14 && (junction.point.distance(DVec3::new(x, y, 0.0)) - radius).abs() < 1e-14);
        }
    }
}

#[test]
fn details_of_the_source_are_in_the_new_cage() {
    // The disc's own fit has details; here are some by hand, down to three levels.
    let mut disc = disc();
    for depth in 1..=3_u32 {
        let levels = (0..depth).map(|level| {
            let n = 1_u32 << level;
            let faces = disc.mesh.face_count();
            let some = (0..faces).filter(|f| f % 3 == 0 && n > 2).map(|f| {
                let address = Address::Face(FaceId::new(f), 1, 1);
                (address, DVec3::new(0.0, 0.0, 1e-3 / f64::from(n * n)))
            });
            let corners =
                (0..disc.mesh.vertex_count()).map(VertexId::new).filter(|&v| level == 0 && !disc.mesh.is_border(v));
            let corners = corners.map(|v| (Address::Corner(v), DVec3::Z * 2e-3 * f64::from(v.0 % 3)));
            let mut all: Vec<_> = corners.chain(some).collect();
            all.sort_unstable_by_key(|d| d.0);
            all
        });
        let levels = levels.collect();
        disc.details = Details { levels };
        let (cuts, result) = cut(&disc, &[bore(0.06, 0.003, 0.05), bore(0.185, 0.01, 0.03)], 0.02);
        let result = result.unwrap_or_else(|e| panic!("{depth}: {e}"));
        judge_union(&disc, &cuts, &result);
        // Border to border, and round.
        assert_eq!((result.surface.mesh.euler(), result.surface.mesh.border_loops().len()), (0, 2));
    }
}
