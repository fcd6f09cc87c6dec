//! What every remeshed cage must be.

use std::collections::HashMap;

use glam::DVec3;
use selvedge_components::mesh::{FaceId, VertexId};
use selvedge_components::subdivision::{Border, CornerTable, Ends, FaceCode, LevelMesh, LimitRows, LoopSurface};
use selvedge_components::trim::BorderLine;

use super::super::assemble::omega;
use super::super::*;
use super::draw;
use crate::subdivision::{chain, region, relax::shape};

/// What a sound cage is like.
#[derive(Clone, Copy, Debug)]
pub struct Verdict {
    pub most_valence: u32,
    pub worst_shape: f64,
    /// Where that triangle is.
    pub worst_at: DVec3,
    /// Faces whose limit patch was found to have the source's bits.
    pub same: usize,
}

/// Asserts all that holds for any cage, and measures what may vary.
pub fn judge(source: &LoopSurface, cuts: &[Cut], result: &Remeshed) -> Verdict {
    let verdict = judge_union(source, cuts, result);
    for curve in 0..cuts.len() {
        rim_is_one_loop(cuts, result, curve as u32);
    }
    verdict
}

/// The same for curves that may cross.
pub fn judge_union(source: &LoopSurface, cuts: &[Cut], result: &Remeshed) -> Verdict {
    let mesh = &result.surface.mesh;
    fates_tile_the_source(source, result);
    order_and_bits_are_kept(source, result);
    sides_are_their_lines(cuts, result);
    junctions_are_where_lines_meet(cuts, result);
    let inside = (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| !mesh.is_border(v));
    let (worst_shape, worst_at) = worst_shape(result);
    Verdict {
        worst_at,
        most_valence: inside.map(|v| mesh.valence(v)).max().unwrap_or(0),
        worst_shape,
        same: limit_patches_outside_are_the_same(source, result),
    }
}

/// The worst shape of a triangle, and where that is.
pub fn worst_shape(result: &Remeshed) -> (f64, DVec3) {
    let at = |v: VertexId| result.limit[v.index()];
    let faces = result.surface.mesh.faces().iter();
    let shapes = faces.map(|f| (shape(f.map(at)), f.map(at).iter().sum::<DVec3>() / 3.0));
    shapes.min_by(|a, b| a.0.total_cmp(&b.0)).expect("a face")
}

fn fates_tile_the_source(source: &LoopSurface, result: &Remeshed) {
    let mut area = vec![0_u64; source.mesh.face_count()];
    for &(level, code, _) in &result.fates {
        area[code.root_face(level).index()] += 1 << (2 * (15 - level));
    }
    assert!(area.iter().all(|&a| a == 1 << 30), "kept, cut and removed leaves tile every face");
}

fn order_and_bits_are_kept(source: &LoopSurface, result: &Remeshed) {
    let mut last = None;
    for (v, origin) in result.vertex_origin.iter().enumerate() {
        if let VertexOrigin::Root(root) = *origin {
            assert!(last.is_none_or(|last| last < root), "root vertices keep their order");
            last = Some(root);
            let bits = |p: DVec3| p.to_array().map(f64::to_bits);
            assert_eq!(bits(result.surface.points[v]), bits(source.points[root.index()]));
        }
    }
    let roots: Vec<FaceCode> = result
        .face_origin
        .iter()
        .filter_map(|o| if let FaceOrigin::Leaf { level: 0, code } = o { Some(*code) } else { None })
        .collect();
    assert!(roots.is_sorted(), "root faces keep their order");
}

/// One loop, each knot once, valences by kind, parameters that rise in [0, 1).
fn rim_is_one_loop(cuts: &[Cut], result: &Remeshed, curve: u32) {
    let mesh = &result.surface.mesh;
    let on =
        |v: VertexId| matches!(result.vertex_origin[v.index()], VertexOrigin::OnCurve { curve: c, .. } if c == curve);
    let loops: Vec<Vec<VertexId>> = mesh.border_loops().into_iter().filter(|l| on(l[0])).collect();
    assert_eq!(loops.len(), 1, "curve {curve} has one loop");
    let count = result
        .vertex_origin
        .iter()
        .filter(|o| matches!(o, VertexOrigin::OnCurve { curve: c, .. } if *c == curve))
        .count();
    assert!(loops[0].len() == count && loops[0].iter().all(|&v| on(v)), "the loop is all of the curve's knots");
    let sides: Vec<_> = result.surface.sides.iter().filter(|s| on(s.vertices[0])).collect();
    let corners = cuts[curve as usize].curve.corners().len();
    assert_eq!(sides.len(), corners.max(1));
    for side in sides {
        assert_eq!(side.ends == Ends::Closed, corners == 0);
        let Border::Given { curve: parameters, .. } = &side.border else { panic!("a cut side is given") };
        let u = parameters.base();
        assert!(u.windows(2).all(|w| w[0] < w[1]) && u[0] >= 0.0 && u[u.len() - 1] < 1.0, "{u:?}");
        let inner = if corners == 0 { &side.vertices[..] } else { &side.vertices[1..side.vertices.len() - 1] };
        assert!(inner.iter().all(|&v| mesh.valence(v) == 4), "smooth knots have four edges");
        if corners > 0 {
            let k = mesh.valence(side.vertices[0]);
            assert!(k == 3 || k == 5, "a corner has three edges or five, not {k}");
        }
        // The side's own samples are where the vertices are meant to be, near enough to tell that
        // indices and direction are right.
        for (step, v) in side.vertices.iter().enumerate() {
            let index = side.curve_index(0, step as u64).expect("given");
            let gap = result.limit[v.index()].distance(parameters.sample(0, index));
            let edge = result.limit[mesh.to(mesh.outgoing(*v)).index()].distance(result.limit[v.index()]);
            assert!(gap < 0.5 * edge, "curve {curve} step {step}: {gap} of {edge}");
        }
    }
}

/// Every border edge has one side; a side along a cut is the cut's own points, to the bit, with four
/// edges at each vertex, and three or five at its corners.
fn sides_are_their_lines(cuts: &[Cut], result: &Remeshed) {
    let surface = &result.surface;
    let mesh = &surface.mesh;
    let edges: usize = mesh.border_loops().iter().map(Vec::len).sum();
    assert_eq!(surface.sides.iter().map(|s| s.edge_count()).sum::<usize>(), edges);
    assert_eq!(surface.sides.len(), result.side_origin.len());
    assert!(result.side_origin.windows(2).all(|o| o[0].line <= o[1].line), "the older lines first");
    let corners = CornerTable::new(surface);
    let root = LevelMesh::root(surface, &corners);
    for (side, origin) in surface.sides.iter().zip(&result.side_origin) {
        let ends = [side.vertices[0], side.vertices[side.vertices.len() - 1]];
        for (step, &v) in side.vertices.iter().enumerate() {
            let is_end = side.ends == Ends::Corners && ends.contains(&v);
            let BorderLine::Cut(cut) = origin.line else { continue };
            let index = side.curve_index(0, step as u64).expect("a cut side is given");
            let Border::Given { curve, heading, .. } = &side.border else { panic!("a cut side is given") };
            assert_eq!(*heading, cuts[cut].heading);
            let k = mesh.valence(v);
            assert!(k == 4 && !is_end || is_end && (k == 3 || k == 5), "valence {k} on cut {cut}");
            let on_curve = cuts[cut].curve.position(curve.parameter(0, index));
            if !is_end {
                assert_eq!(root.sample(v.0).to_array().map(f64::to_bits), on_curve.to_array().map(f64::to_bits));
            }
        }
    }
}

/// Each is a corner with three edges, whose point is the older line's to the bit and lies on the younger.
fn junctions_are_where_lines_meet(cuts: &[Cut], result: &Remeshed) {
    let surface = &result.surface;
    let corners = CornerTable::new(surface);
    let root = LevelMesh::root(surface, &corners);
    for (j, junction) in result.junctions.iter().enumerate() {
        let is_there = |o: &VertexOrigin| *o == VertexOrigin::Junction(j as u32);
        let places: Vec<usize> =
            (0..result.vertex_origin.len()).filter(|&v| is_there(&result.vertex_origin[v])).collect();
        assert_eq!(places.len(), 1, "junction {j} is one vertex");
        let v = VertexId::new(places[0]);
        assert_eq!(surface.mesh.valence(v), 3);
        let bits = |p: DVec3| p.to_array().map(f64::to_bits);
        assert_eq!(bits(root.sample(v.0)), bits(junction.point));
        let [(older, u), (younger, w)] = junction.ends;
        assert!(older < younger);
        let at = |line, u| match line {
            BorderLine::Cut(c) => cuts[c].curve.position(u),
            BorderLine::Side(_) => junction.point,
        };
        assert_eq!(bits(at(older, u)), bits(junction.point));
        assert!((at(younger, w).distance(junction.point) - junction.gap).abs() < 1e-15);
        let meeting = surface.sides.iter().zip(&result.side_origin);
        let meeting = meeting.filter(|(s, _)| s.vertices[0] == v || s.vertices[s.vertices.len() - 1] == v);
        let lines: Vec<BorderLine> = meeting.map(|(_, origin)| origin.line).collect();
        assert_eq!(lines, [older, younger]);
    }
}

/// Compares limit points two levels down over faces beyond those around changed vertices, to the bit (up
/// to rounding where the whole cage was refined first); returns how many those are.
fn limit_patches_outside_are_the_same(source: &LoopSurface, result: &Remeshed) -> usize {
    let omega = omega(&result.surface.mesh, &result.changed, Omega::Changed);
    assert!(omega.iter().all(|face| result.omega.binary_search(face).is_ok()), "Omega is less than what has changed");
    let faces = result.face_origin.iter().enumerate().map(|(f, origin)| (FaceCode::root(FaceId::new(f)), origin));
    let outside: Vec<(FaceCode, u32, FaceCode)> = faces
        .filter(|(f, _)| omega.binary_search(f).is_err())
        .map(|(f, origin)| match origin {
            FaceOrigin::Leaf { level, code } => (f, *level, *code),
            _ => panic!("only whole faces lie outside Omega"),
        })
        .collect();
    let Some(base) = outside.first().map(|o| o.1) else { return 0 };
    let now = limits(&result.surface, 0, outside.iter().map(|p| p.0).collect());
    let then = limits(source, base, outside.iter().map(|p| p.2).collect());
    let size = source.points.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    for (a, level, b) in &outside {
        assert_eq!(*level, base);
        for path in 0..16 {
            let child = |f: &FaceCode| FaceCode(f.0 << 4 | path);
            let bits = |x: &[DVec3; 3]| x.map(|p| p.to_array().map(f64::to_bits));
            let (x, y) = (&now[&child(a)], &then[&child(b)]);
            let near = x.iter().zip(y).all(|(x, y)| x.distance(*y) < 1e-14 * size);
            assert!(bits(x) == bits(y) || (base > 0 && near), "face {a:?} was {b:?}");
        }
    }
    outside.len()
}

/// The limit points at the corners of the faces two levels below `faces`.
fn limits(surface: &LoopSurface, level: u32, faces: Vec<FaceCode>) -> HashMap<FaceCode, [DVec3; 3]> {
    let corners = CornerTable::new(surface);
    let faces = region::children(&region::children(&region::ascending(faces)));
    let held = region::children(&region::parents(&region::neighbourhood(&surface.mesh, level + 2, &faces)));
    let level = chain::build(surface, &corners, &surface.details, level + 2, &held);
    let rows = LimitRows::new(surface, &corners, &level.mesh, |_| true);
    let mut at = vec![DVec3::NAN; level.mesh.vertices.len()];
    for (&v, x) in rows.vertices.iter().zip(rows.apply(&level.state)) {
        at[v as usize] = x;
    }
    for given in &level.mesh.given {
        at[given.vertex as usize] = given.sample;
    }
    level.mesh.codes.iter().zip(&level.mesh.corners).map(|(&c, f)| (c, f.map(|v| at[v as usize]))).collect()
}

/// The new cage seen from above, by origin of its faces.
pub fn picture(name: &str, result: &Remeshed) {
    let faces: Vec<[u32; 3]> = result.surface.mesh.faces().iter().map(|f| f.map(|v| v.0)).collect();
    draw::triangles(name, &result.limit, &faces, |f| match result.face_origin[f] {
        FaceOrigin::Leaf { level: 0, .. } => "white",
        FaceOrigin::Leaf { .. } => "lightgrey",
        FaceOrigin::Closure { .. } => "khaki",
        FaceOrigin::Strip { .. } => "salmon",
    });
}
