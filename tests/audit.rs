//! An audit finds what is wrong, names it and places it; and finds nothing wrong where nothing is.

#[path = "support/draw.rs"]
mod draw;
mod support;

use std::sync::Arc;

use draw::disc;
use glam::DVec3;
use selvedge_components::curve::Heading;
use selvedge_components::mesh::{FaceId, Fault, VertexId};
use selvedge_components::subdivision::LoopSurface;
use selvedge_components::triangles::Triangles;
use selvedge_systems::audit::{Audit, AuditFault, audit};
use selvedge_systems::subdivision::limit::LimitSurface;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};
use support::octant;

fn triangles(surface: &LoopSurface, chord: f64) -> Triangles {
    let options = TriangulateOptions { density: Density::Chord(chord), ..TriangulateOptions::default() };
    triangulate(surface, &options).expect("the chord can be kept").triangles
}

/// The octant's triangles after `change`, and what an audit says of them.
fn found(change: impl FnOnce(&mut Triangles)) -> Vec<AuditFault> {
    let surface = octant("cone(1,2)");
    let mut changed = triangles(&surface, 2e-3);
    change(&mut changed);
    audit(&changed, &Audit::of(&surface)).faults
}

/// A vertex of the octant's border, by its place on the border: none of the three corners.
fn on_border(triangles: &Triangles) -> usize {
    let flat = |p: DVec3| p.to_array().iter().filter(|&&x| x == 0.0).count() == 1;
    triangles.positions.iter().position(|&p| flat(p)).expect("arcs lie in the planes of the axes")
}

#[test]
fn what_is_sound_has_no_fault() {
    assert_eq!(found(|_| ()), []);
    for heading in [Heading::Along, Heading::Against] {
        let surface = disc(6, 2, 9, heading);
        let report = audit(&triangles(&surface, 1e-2), &Audit::of(&surface));
        assert_eq!(report.faults, []);
        assert_eq!((report.euler, report.border_loops.len()), (1, 1));
    }
}

/// A border vertex that is one rounding off its curve is a gap to the next surface.
#[test]
fn a_border_vertex_off_its_curve_by_one_rounding_is_found() {
    let mut moved = 0;
    let faults = found(|t| {
        moved = on_border(t);
        let x = &mut t.positions[moved];
        let largest = if x.x.abs() > x.y.abs() { &mut x.x } else { &mut x.y };
        *largest = f64::from_bits(largest.to_bits() + 1);
    });
    assert!(matches!(&faults[..], [AuditFault::OffCurve { vertex, .. }] if vertex.index() == moved), "{faults:?}");
}

#[test]
fn a_missing_triangle_is_an_open_edge_and_a_gap_in_its_face() {
    let faults = found(|t| {
        let inside = |v: &u32| t.positions[*v as usize].to_array().iter().all(|&x| x > 0.02);
        let i = t.triangles.iter().position(|t| t.iter().all(inside)).expect("a triangle inside");
        t.triangles.remove(i);
    });
    assert!(faults.iter().any(|f| matches!(f, AuditFault::Loops { found: 2, expected: 1 })), "{faults:?}");
    assert!(faults.iter().any(|f| matches!(f, AuditFault::Cover { share, .. } if *share < 1.0)), "{faults:?}");
    assert_eq!(faults.iter().filter(|f| matches!(f, AuditFault::OpenEdge { .. })).count(), 3, "{faults:?}");
}

/// The very thing that closures are for: a coarse triangle beside two finer ones.
#[test]
fn a_vertex_inside_an_edge_is_found() {
    let faults = found(|t| {
        // Two triangles that halve a leaf are made one: they share two vertices that lie straight.
        let st = |v: u32| t.origins[v as usize];
        let pair = (1..t.triangles.len()).find(|&i| {
            let ([a, m, c], [n, b, d]) = (t.triangles[i - 1], t.triangles[i]);
            let level = [a, m, b].map(st);
            m == n
                && c == d
                && level.iter().all(|o| o.face == level[0].face)
                && (level[0].st + level[2].st) * 0.5 == level[1].st
        });
        let i = pair.expect("a leaf beside a finer one");
        t.triangles[i - 1][1] = t.triangles[i][1];
        t.triangles.remove(i);
    });
    assert_eq!(faults.iter().filter(|f| matches!(f, AuditFault::OpenEdge { .. })).count(), 3, "{faults:?}");
    assert!(!faults.iter().any(|f| matches!(f, AuditFault::Cover { .. })), "it still covers its face: {faults:?}");
}

#[test]
fn faults_of_the_mesh_are_told_as_such() {
    let faults = found(|t| t.triangles[3].swap(1, 2));
    assert!(matches!(faults[0], AuditFault::Mesh(Fault::InconsistentWinding { .. })), "{faults:?}");
    let faults = found(|t| t.triangles.push(t.triangles[5]));
    assert!(faults.iter().any(|f| matches!(f, AuditFault::Mesh(Fault::DuplicateFace { .. }))), "{faults:?}");
    let faults = found(|t| t.triangles[0][0] = 1 << 30);
    assert!(matches!(faults[0], AuditFault::Mesh(Fault::IndexOutOfRange { .. })), "{faults:?}");
    let faults = found(|t| t.positions[7].y = f64::NAN);
    assert!(matches!(faults[0], AuditFault::Mesh(Fault::NotFinite { vertex: VertexId(7), .. })), "{faults:?}");
    let faults = found(|t| {
        t.origins.pop();
    });
    assert!(matches!(faults[0], AuditFault::Length { what: "origins", .. }), "{faults:?}");
}

#[test]
fn everything_turned_over_is_found() {
    let faults = found(|t| t.triangles.iter_mut().for_each(|t| t.swap(1, 2)));
    assert!(faults.iter().any(|f| matches!(f, AuditFault::Reversed { .. })), "{:?}", faults.first());
}

#[test]
fn a_place_that_is_not_there_is_found() {
    let faults = found(|t| t.origins[4].face = FaceId(77));
    assert!(matches!(&faults[..], [AuditFault::NoPlace { vertex: VertexId(4), .. }, ..]), "{faults:?}");
    let faults = found(|t| t.origins[4].st.x = 1.5);
    assert!(matches!(&faults[..], [AuditFault::NoPlace { vertex: VertexId(4), .. }, ..]), "{faults:?}");
    let faults = found(|t| {
        let last = t.origins.len() - 1;
        t.origins[last].face = FaceId((t.origins[last].face.0 + 7) % 13);
    });
    assert!(faults.iter().any(|f| matches!(f, AuditFault::Torn { .. })), "{faults:?}");
}

#[test]
fn two_vertices_in_one_place_are_found() {
    let faults = found(|t| {
        let [a, b, _] = t.triangles.iter().copied().find(|t| t.iter().all(|&v| v > 60)).expect("a triangle inside");
        t.positions[a as usize] = t.positions[b as usize];
    });
    assert!(faults.iter().any(|f| matches!(f, AuditFault::Coincident { .. })), "{faults:?}");
    assert!(faults.iter().any(|f| matches!(f, AuditFault::Degenerate { .. })), "{faults:?}");
}

/// A vertex off the surface shows as a distance, on every triangle around it and nowhere else.
#[test]
fn a_vertex_off_the_surface_is_measured() {
    let surface = octant("cone(1,2)");
    let limit = LimitSurface::new(Arc::new(surface.clone())).expect("the surface is sound");
    let mut triangles = triangles(&surface, 2e-3);
    let centre = DVec3::ONE.normalize();
    let nearest = |a: &usize, b: &usize| {
        let off = |v: usize| triangles.positions[v].normalize().distance(centre);
        off(*a).total_cmp(&off(*b))
    };
    let moved = (0..triangles.positions.len()).min_by(nearest).expect("vertices");
    triangles.positions[moved] += 0.01 * centre;
    let report = audit(&triangles, &Audit { points: 40, seed: 3, ..Audit::of(&surface).within(&limit, 4e-3) });
    let measured = report.measured.expect("the limit was given");
    // The surface is straight below, so the height is what it was moved by; random places come close
    // to the vertex, not to it.
    assert!((0.008..0.0105).contains(&measured.to_surface), "{measured:?}");
    assert!(!report.faults.is_empty());
    for fault in &report.faults {
        let AuditFault::Chord { triangle, .. } = fault else { panic!("{fault}") };
        assert!(triangles.triangles[*triangle].contains(&(moved as u32)), "{fault}");
    }
}

/// The places are drawn from the seed: the same seed measures the same, another one other points.
#[test]
fn a_seed_chooses_the_places() {
    let surface = octant("cone(1,1)");
    let limit = LimitSurface::new(Arc::new(surface.clone())).expect("the surface is sound");
    let triangles = triangles(&surface, 5e-3);
    let with = |seed| audit(&triangles, &Audit { seed, ..Audit::of(&surface).within(&limit, 5e-3) }).measured;
    assert_eq!(with(1), with(1));
    assert_ne!(with(1), with(2));
}
