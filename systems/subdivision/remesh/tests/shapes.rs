//! Curves with corners, many curves, islands, curves walked backwards.

use core::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use selvedge_components::curve::Heading;
use selvedge_components::subdivision::LoopSurface;

use super::super::*;
use super::judge::{Verdict, judge, picture};
use super::support::{Laid, Numbers, OnPlate, Walker, circle, lattice, polygon};
use super::sweep::SLIVER;
use selvedge_components::target::Target;

fn wave(x: f64, y: f64) -> f64 {
    0.006 * (17.0 * x).cos() * (14.0 * y).cos()
}

fn plate(n: u32) -> (LoopSurface, Arc<Walker>) {
    let plate = lattice(n, 0.05, wave);
    let walker = Arc::new(Walker::new(&plate));
    (plate, walker)
}

fn cut_with(
    walker: &Arc<Walker>,
    plane: impl Fn(f64) -> DVec2 + Send + Sync + 'static,
    corners: Vec<f64>,
    heading: Heading,
) -> Cut {
    Cut::new(Arc::new(OnPlate { walker: Arc::clone(walker), plane, corners }), heading)
}

fn cut_out(plate: &LoopSurface, walker: &Walker, cuts: &[Cut]) -> Result<Remeshed, RemeshError> {
    let options = TraceOptions { curve: 1e-6, step: 0.05 / 8.0 };
    let images = cuts.iter().enumerate().map(|(curve, cut)| {
        trace(&plate.mesh, walker, &*cut.curve, options).map_err(|source| RemeshError::PreImage { curve, source })
    });
    remesh(plate.clone(), cuts, &images.collect::<Result<Vec<_>, _>>()?, &RemeshOptions::default())
}

fn sound(name: &str, plate: &LoopSurface, walker: &Walker, cuts: &[Cut]) -> (Remeshed, Verdict) {
    let result = cut_out(plate, walker, cuts).unwrap_or_else(|e| panic!("{name}: {e}"));
    picture(&format!("{name}.svg"), &result);
    let verdict = judge(plate, cuts, &result);
    (result, verdict)
}

/// A star of `n` tips, clockwise.
fn star(n: usize, inner: f64, outer: f64, turn: f64) -> Vec<DVec2> {
    let at = |k: usize| {
        let (s, c) = (turn - TAU * k as f64 / (2 * n) as f64).sin_cos();
        if k.is_multiple_of(2) { outer * DVec2::new(c, s) } else { inner * DVec2::new(c, s) }
    };
    (0..2 * n).map(at).collect()
}

#[test]
fn a_bore_walked_backwards_leaves_the_same_rim() {
    let (plate, walker) = plate(12);
    let along = cut_with(&walker, circle(DVec2::new(0.01, 0.02), 0.08), Vec::new(), Heading::Along);
    let mirrored = |u: f64| circle(DVec2::new(0.01, 0.02), 0.08)(1.0 - u);
    let against = cut_with(&walker, mirrored, Vec::new(), Heading::Against);
    let (a, _) = sound("along", &plate, &walker, &[along]);
    let (b, _) = sound("against", &plate, &walker, &[against]);
    assert_eq!(a.surface.mesh.face_count(), b.surface.mesh.face_count());
}

#[test]
fn the_disc_that_a_bore_takes_away_is_the_other_side() {
    let (plate, walker) = plate(12);
    let disc = cut_with(&walker, circle(DVec2::new(0.01, 0.02), 0.13), Vec::new(), Heading::Against);
    let (result, _) = sound("disc", &plate, &walker, &[disc]);
    assert_eq!(result.surface.mesh.euler(), 1);
    assert_eq!(result.surface.mesh.border_loops().len(), 1);
}

#[test]
fn corners_are_regular_in_the_lattice() {
    let (plate, walker) = plate(12);
    for (name, points) in [
        (
            "square",
            vec![DVec2::new(0.08, 0.07), DVec2::new(0.09, -0.06), DVec2::new(-0.07, -0.08), DVec2::new(-0.08, 0.09)],
        ),
        (
            "small",
            vec![DVec2::new(0.02, 0.01), DVec2::new(0.02, -0.01), DVec2::new(-0.01, -0.01), DVec2::new(-0.01, 0.01)],
        ),
        ("star", star(5, 0.05, 0.12, 0.3)),
        ("sharp", star(5, 0.03, 0.13, 0.3)),
        ("needle", vec![DVec2::new(0.13, 0.0), DVec2::new(-0.1, -0.02), DVec2::new(-0.1, 0.02)]),
    ] {
        let (plane, corners) = polygon(points);
        let count = corners.len();
        let (result, _) = sound(name, &plate, &walker, &[cut_with(&walker, plane, corners, Heading::Along)]);
        assert_eq!(result.surface.mesh.euler(), plate.mesh.euler() - 1);
        assert!(count > 2);
    }
}

#[test]
fn many_bores_are_cut_at_once_and_far_faces_keep_their_bits() {
    let (plate, walker) = plate(40);
    let mut cuts = Vec::new();
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        let centre = DVec2::new(0.6 * (f64::from(i) - 1.0) + 0.011, 0.6 * (f64::from(j) - 1.0) - 0.007);
        cuts.push(cut_with(&walker, circle(centre, 0.03 + 0.01 * f64::from(i)), Vec::new(), Heading::Along));
    }
    let (result, verdict) = sound("many", &plate, &walker, &cuts);
    assert_eq!(result.surface.mesh.euler(), plate.mesh.euler() - 9);
    assert!(verdict.same > plate.mesh.face_count() / 3, "{} of {}", verdict.same, plate.mesh.face_count());
}

#[test]
fn thin_walls_between_bores_are_resolved() {
    let (plate, walker) = plate(12);
    for gap in [0.03, 0.01, 0.003, 0.001] {
        let offset = 0.5 * gap + 0.06;
        let left = cut_with(&walker, circle(DVec2::new(-offset, 0.003), 0.06), Vec::new(), Heading::Along);
        let right = cut_with(&walker, circle(DVec2::new(offset, 0.003), 0.06), Vec::new(), Heading::Along);
        let (result, _) = sound(&format!("wall{gap}"), &plate, &walker, &[left, right]);
        assert_eq!(result.surface.mesh.euler(), plate.mesh.euler() - 2);
    }
}

#[test]
fn an_island_stays_in_a_hole() {
    let (plate, walker) = plate(16);
    let hole = cut_with(&walker, circle(DVec2::ZERO, 0.2), Vec::new(), Heading::Along);
    let island = cut_with(&walker, circle(DVec2::new(0.01, 0.0), 0.1), Vec::new(), Heading::Against);
    let (result, _) = sound("island", &plate, &walker, &[hole, island]);
    assert_eq!(result.surface.mesh.border_loops().len(), 3);
    assert_eq!(result.surface.mesh.euler(), 1);
}

#[test]
fn random_polygons_leave_a_sound_cage() {
    let (plate, walker) = plate(12);
    let mut numbers = Numbers(11);
    let count = std::env::var("SELVEDGE_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    let mut failed = Vec::new();
    for case in 0..count {
        let tips = 3 + (numbers.next() * 5.0) as usize;
        let outer = numbers.between(0.02, 0.15);
        let inner = outer * numbers.between(0.3, 0.95);
        let centre = DVec2::new(numbers.between(-0.05, 0.05), numbers.between(-0.05, 0.05));
        let points = star(tips, inner, outer, numbers.between(0.0, TAU)).into_iter().map(|p| p + centre).collect();
        let (plane, corners) = polygon(points);
        let cuts = [cut_with(&walker, plane, corners, Heading::Along)];
        match cut_out(&plate, &walker, &cuts) {
            Ok(result) => {
                let verdict = judge(&plate, &cuts, &result);
                if verdict.worst_shape < SLIVER || verdict.most_valence > 10 {
                    picture(&format!("polygon{case}.svg"), &result);
                    failed.push(format!("{case}: {tips} tips, {inner}, {outer}: {verdict:?}"));
                }
            }
            Err(why) => failed.push(format!("{case}: {tips} tips, {inner}, {outer}: {why}")),
        }
    }
    assert!(failed.is_empty(), "{} of {count} failed\n{}", failed.len(), failed.join("\n"));
}

#[test]
fn a_curved_border_that_is_refined_keeps_its_shape() {
    use selvedge_components::subdivision::Border;
    // A globe without its south pole has one round border.
    let globe = super::support::globe(9, 7);
    let faces: Vec<[u32; 3]> = globe.mesh.faces().iter().map(|f| f.map(|v| v.0)).collect();
    let kept: Vec<[u32; 3]> = faces.into_iter().filter(|f| !f.contains(&1)).collect();
    let renamed: Vec<[u32; 3]> = kept.iter().map(|f| f.map(|v| if v > 1 { v - 1 } else { v })).collect();
    let mut points = globe.points.clone();
    points.remove(1);
    let bowl = super::support::surface(points, &renamed, &[]);
    let walker = Arc::new(Walker::new(&bowl));
    let centre = walker.closest(DVec3::new(0.4, 0.1, -0.6), None).expect("a foot").position;
    let normal = centre.normalize();
    let x = normal.any_orthonormal_vector();
    let y = normal.cross(x);
    let curve =
        Laid { walker: Arc::clone(&walker), plane: circle(DVec2::ZERO, 0.08), centre, x, y, corners: Vec::new() };
    let cuts = [Cut::new(Arc::new(curve), Heading::Along)];
    let options = TraceOptions { curve: 1e-6, step: 0.05 };
    let image = trace(&bowl.mesh, &*walker, &*cuts[0].curve, options).expect("a pre-image");
    let result = remesh(bowl.clone(), &cuts, &[image], &RemeshOptions::default()).expect("a cage");
    judge(&bowl, &cuts, &result);
    let side = &result.surface.sides[0];
    let Border::Given { curve, .. } = &side.border else { panic!("the border is given now") };
    assert!(side.vertices.len() > bowl.sides[0].vertices.len());
    for i in 0..curve.vertex_count(3) {
        let x = curve.sample(3, i);
        // The walk may stop at a corner between two border edges: it is begun on each of them.
        let starts = bowl.sides[0].vertices.iter().map(|&v| {
            let h = bowl.mesh.outgoing(v);
            path::corner(h.corner()).midpoint(path::corner(h.next().corner())).extend(f64::from(h.face().0))
        });
        let feet = starts.map(|s| {
            let hint = selvedge_components::evaluate::SurfacePoint::new(
                selvedge_components::mesh::FaceId(s.z as u32),
                s.x,
                s.y,
            );
            walker.closest(x, Some(hint)).expect("a foot").position.distance(x)
        });
        assert!(feet.fold(f64::INFINITY, f64::min) < 1e-14);
    }
    // The effective points are the source's.
    for (v, origin) in result.vertex_origin.iter().enumerate() {
        if let VertexOrigin::Root(root) = origin {
            let address =
                selvedge_components::subdivision::Address::Corner(selvedge_components::mesh::VertexId::new(v));
            let d = result.surface.details.at(0, address);
            let index = side.vertices.iter().position(|w| w.index() == v);
            let Some(sample) = index.and_then(|i| side.curve_index(0, i as u64)).map(|i| curve.sample(0, i)) else {
                continue;
            };
            assert!((sample - d).distance(bowl.points[root.index()]) < 1e-14);
        }
    }
}
