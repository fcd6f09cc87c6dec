//! The scheme reproduces what its theory says it must, to rounding.

mod support;

use glam::{DVec2, DVec3};
use selvedge_components::mesh::VertexId;
use selvedge_components::subdivision::{
    Address, CornerTable, Details, Kind, LevelMesh, LevelState, LimitRows, LoopSurface, Step,
};
use selvedge_systems::subdivision::chain;
use support::{detail, fan, graph, parallelogram};

fn quadratic(at: DVec2) -> f64 {
    0.3 * at.x * at.x - 0.2 * at.x * at.y + 0.5 * at.y * at.y + at.x
}

fn cubic(at: DVec2) -> f64 {
    let (x, y) = (at.x, at.y);
    0.1 * x * x * x - 0.2 * x * x * y + 0.15 * x * y * y - 0.05 * y * y * y + 0.2 * x * x
}

/// The surface whose limit is the graph: interior points lowered by the detail, borders with it.
fn reproducing(patch: &support::Patch, height: fn(DVec2) -> f64) -> LoopSurface {
    let mut surface = graph(patch, height);
    let mut border = Vec::new();
    for (v, &at) in patch.places.iter().enumerate() {
        let d = DVec3::new(0.0, 0.0, detail(height, at));
        if surface.mesh.is_border(VertexId::new(v)) {
            border.push((Address::Corner(VertexId::new(v)), d));
        } else {
            surface.points[v] -= d;
        }
    }
    surface.details = Details { levels: vec![border] };
    surface
}

/// Greatest distance in z between the limit points after `levels` subdivisions and the graph.
fn deviation(surface: &LoopSurface, height: fn(DVec2) -> f64, levels: u32) -> f64 {
    let corners = CornerTable::new(surface);
    let mut at = chain::root(surface, &corners, &surface.details);
    for _ in 0..levels {
        at = chain::refine(surface, &corners, &surface.details, &at, &at.mesh.all_refinable()).0;
    }
    let rows = LimitRows::new(surface, &corners, &at.mesh, |_| true);
    assert!(!rows.vertices.is_empty());
    rows.apply(&at.state).iter().map(|p| (p.z - height(p.truncate())).abs()).fold(0.0, f64::max)
}

#[test]
fn cubics_over_a_parallelogram_are_reproduced_at_every_level() {
    for height in [quadratic, cubic] {
        let surface = reproducing(&parallelogram(6), height);
        for levels in 0..=3 {
            let off = deviation(&surface, height, levels);
            assert!(off < 1e-13, "level {levels}: {off:e}");
        }
    }
}

/// Valence 5 spans 240 degrees, valence 6 spans 300: the quadratic that concave corners are drawn
/// to is exact.
#[test]
fn quadratics_at_concave_lattice_corners_are_reproduced() {
    for sectors in [4, 5] {
        let surface = reproducing(&fan(sectors, 3), quadratic);
        let corners = CornerTable::new(&surface);
        assert_eq!(corners.corners.len(), 1, "the concave corner is the one special vertex");
        for levels in 0..=3 {
            let off = deviation(&surface, quadratic, levels);
            assert!(off < 1e-13, "{sectors} sectors, level {levels}: {off:e}");
        }
    }
}

/// Convex lattice corners need no rule of their own: 60 degrees (valence 2) and 120 (valence 3).
#[test]
fn cubics_at_convex_lattice_corners_are_reproduced() {
    for sectors in [1, 2] {
        let surface = reproducing(&fan(sectors, 5), cubic);
        assert!(deviation(&surface, cubic, 3) < 1e-13, "{sectors} sectors");
    }
}

/// `Q = 2 I - L` inverts the limit operator on cubics. [Litke et al. 2001, Section 2.3]
#[test]
fn quasi_interpolation_inverts_the_limit_on_cubics() {
    let patch = parallelogram(8);
    let surface = graph(&patch, cubic);
    let corners = CornerTable::new(&surface);
    let mesh = LevelMesh::root(&surface, &corners);
    let interior = |v: u32| mesh.vertices[v as usize].kind == Kind::Interior;
    let quasi = |x: &[DVec3], v: u32| mesh.neighbours(v).fold(1.5 * x[v as usize], |sum, n| sum - x[n as usize] / 12.0);
    let samples: Vec<DVec3> = patch.places.iter().map(|&at| at.extend(cubic(at))).collect();
    let effective = (0..mesh.vertices.len() as u32)
        .map(|v| if interior(v) { quasi(&samples, v) } else { samples[v as usize] })
        .collect();
    let state = LevelState { effective, details: Vec::new() };
    // Only where the whole ring has been quasi-interpolated.
    let inner = |v: u32| interior(v) && mesh.neighbours(v).all(interior);
    let rows = LimitRows::new(&surface, &corners, &mesh, inner);
    assert!(rows.vertices.len() > 20);
    for (&v, limit) in rows.vertices.iter().zip(rows.apply(&state)) {
        assert!((limit - samples[v as usize]).length() < 1e-13, "vertex {v}");
    }
}

/// Rows of interior vertices sum to one, for the step and for the limit.
#[test]
fn every_interior_stencil_is_a_partition_of_unity() {
    for sectors in 1..=5 {
        let surface = graph(&fan(sectors, 3), quadratic);
        let corners = CornerTable::new(&surface);
        let mut at = chain::root(&surface, &corners, &surface.details);
        for _ in 0..2 {
            let (finer, step) = chain::refine(&surface, &corners, &surface.details, &at, &at.mesh.all_refinable());
            assert_rows_sum_to_one(&step, &finer.mesh, &corners);
            at = finer;
        }
        let rows = LimitRows::new(&surface, &corners, &at.mesh, |_| true);
        for r in 0..rows.rows.len() {
            let (columns, weights) = rows.rows.row(r);
            if columns.iter().all(|&c| at.mesh.vertices[c as usize].corner == selvedge_components::subdivision::NONE) {
                assert!((weights.iter().sum::<f64>() - 1.0).abs() < 4e-16);
            }
        }
    }
}

fn assert_rows_sum_to_one(step: &Step, finer: &LevelMesh, corners: &CornerTable) {
    let pulled: Vec<u32> = step.offsets.iter().map(|o| o.0).collect();
    assert!(pulled.is_empty() || !corners.corners.is_empty());
    for (v, vertex) in finer.vertices.iter().enumerate() {
        if vertex.kind == Kind::Interior && !pulled.contains(&(v as u32)) {
            let sum: f64 = step.rows.row(v).1.iter().sum();
            assert!((sum - 1.0).abs() < 4e-16, "row {v} sums to {sum}");
        }
    }
}

/// The scheme is affine: a surface moved and stretched has the moved and stretched limit. This is
/// what the offsets of concave corners owe to the curve.
#[test]
fn constants_are_reproduced_beside_concave_corners() {
    fn flat(_: DVec2) -> f64 {
        7.0
    }
    let surface = graph(&fan(4, 2), flat);
    assert!(deviation(&surface, flat, 3) < 1e-14);
}

/// The limit points of the level's own vertices do not move when the level is subdivided.
#[test]
fn limit_points_survive_refinement_at_every_valence() {
    for valence in 3..=64_u32 {
        let rim: Vec<u32> = (0..2 * valence).map(|i| valence + 1 + i).collect();
        let mut triangles = Vec::new();
        for i in 0..valence {
            let (a, b) = (1 + i, 1 + (i + 1) % valence);
            let (p, q, r) = (rim[2 * i as usize], rim[2 * i as usize + 1], rim[(2 * i as usize + 2) % rim.len()]);
            triangles.extend([[0, a, b], [a, p, q], [a, q, b], [b, q, r]]);
        }
        let count = 3 * valence as usize + 1;
        let points: Vec<DVec3> = (0..count)
            .map(|i| {
                let x = i as f64;
                DVec3::new((1.3 * x).sin(), (0.7 * x).cos(), (0.31 * x * x).sin())
            })
            .collect();
        let surface = support::plain(points, &triangles);
        let corners = CornerTable::new(&surface);
        let coarse = chain::root(&surface, &corners, &surface.details);
        let limit = |at: &chain::Level| {
            let rows = LimitRows::new(&surface, &corners, &at.mesh, |v| v == 0);
            rows.apply(&at.state)[0]
        };
        let (finer, _) = chain::refine(&surface, &corners, &surface.details, &coarse, &coarse.mesh.all_refinable());
        let moved = (limit(&coarse) - limit(&finer)).length();
        assert!(moved < 4e-15, "valence {valence}: {moved:e}");
    }
}
