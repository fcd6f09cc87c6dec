//! What can be wrong with a surface that has all its parts.

use glam::DVec3;
use selvedge_components::budget::{Budget, Budgets};
use selvedge_components::curve::{Extent, evaluate};
use selvedge_components::error::SurfaceFault;
use selvedge_components::mesh::{Connectivity, VertexId, position_faults};
use selvedge_components::subdivision::{Address, Border, Details, Ends, Heading, LoopSurface, Side};

/// Every fault of `surface`: of its control points, its sides, its details, in that order, each by
/// index. The mesh itself has none, for it could not have been built.
///
/// Costs O(control points + details), and one call of each given curve per border edge.
pub fn surface_faults(surface: &LoopSurface, budgets: &Budgets) -> Vec<SurfaceFault> {
    let mut faults = point_faults(&surface.points);
    let sides = side_faults(&surface.mesh, &surface.sides);
    if sides.is_empty() {
        faults.extend(curve_faults(&surface.sides));
    }
    faults.extend(sides);
    faults.extend(place_faults(&surface.mesh, &surface.details));
    faults.extend(detail_faults(&surface.details));
    let count = budgets.check(Budget::Details, surface.details.count() as u64);
    faults.extend(count.err().map(SurfaceFault::Budget));
    faults
}

/// The faults that may come in when only control points and details of a sound surface move.
pub fn value_faults(surface: &LoopSurface) -> Vec<SurfaceFault> {
    let mut faults = point_faults(&surface.points);
    faults.extend(detail_faults(&surface.details));
    faults
}

fn point_faults(points: &[DVec3]) -> Vec<SurfaceFault> {
    // Zero times a number is zero, and NaN times one that is not finite: a sum without branches
    // tells at once that all is well, as it mostly is.
    let all = points.iter().fold(DVec3::ZERO, |sum, &p| sum + p * 0.0);
    if all == DVec3::ZERO {
        return Vec::new();
    }
    position_faults(points).into_iter().map(SurfaceFault::Mesh).collect()
}

/// Faults of how the sides lie on the borders of the mesh.
fn side_faults(mesh: &Connectivity, sides: &[Side]) -> Vec<SurfaceFault> {
    let mut faults = Vec::new();
    // A border vertex has one border edge that leaves it with the surface on the left, so the side
    // of an edge can be kept at the vertex where it begins.
    let begins: Vec<_> = (0..mesh.vertex_count()).map(VertexId::new).filter(|&v| mesh.is_border(v)).collect();
    let mut side_of = vec![None; begins.len()];
    for (side, Side { vertices, ends, .. }) in sides.iter().enumerate() {
        let (least, edges) = match ends {
            // A border is a loop of three edges or more.
            Ends::Closed => (3, vertices.len()),
            Ends::Corners => (2, vertices.len().saturating_sub(1)),
        };
        if vertices.len() < least {
            faults.push(SurfaceFault::SideTooShort { side, vertices: vertices.len(), least });
            continue;
        }
        for i in 0..edges {
            let ends = [vertices[i], vertices[(i + 1) % vertices.len()]];
            let edge = begins.binary_search(&ends[0]).ok().filter(|_| border_edge(mesh, ends[0]) == ends[1]);
            match edge.map(|edge| &mut side_of[edge]) {
                None => faults.push(SurfaceFault::SideOffBorder { side, ends }),
                Some(&mut Some(first)) => faults.push(SurfaceFault::SideOverlap { ends, first, second: side }),
                Some(free) => *free = Some(side),
            }
        }
    }
    let bare = begins.iter().zip(&side_of).filter(|(_, side)| side.is_none()).map(|(&v, _)| v);
    faults.extend(bare.map(|v| SurfaceFault::SideMissing { ends: [v, border_edge(mesh, v)] }));
    faults
}

/// Where the border edge that leaves the border vertex `v` goes.
fn border_edge(mesh: &Connectivity, v: VertexId) -> VertexId {
    mesh.to(mesh.outgoing(v))
}

/// Faults of given sides along their curves: of each side the first.
fn curve_faults(sides: &[Side]) -> Vec<SurfaceFault> {
    sides.iter().enumerate().filter_map(|(side, given)| curve_fault(side, given)).collect()
}

fn curve_fault(side: usize, given: &Side) -> Option<SurfaceFault> {
    let Border::Given { curve, first, heading } = &given.border else { return None };
    let (edges, all) = (given.edge_count(), curve.edge_count(0));
    let available = match (curve.extent(), given.ends, heading) {
        (Extent::Open, Ends::Closed, _) => 0,
        (Extent::Open, _, Heading::Along) => all.saturating_sub(*first),
        (Extent::Open, _, Heading::Against) => (*first).min(all),
        (Extent::Closed, ..) => all,
    };
    let round = given.ends == Ends::Closed && edges as u64 != available;
    if round || edges as u64 > available {
        return Some(SurfaceFault::SideParameters { side, edges, available });
    }
    (0..).zip(&given.vertices).find_map(|(step, &vertex)| {
        let index = given.curve_index(0, step)?;
        let why = evaluate(&**curve.curve(), curve.parameter(0, index)).err()?;
        Some(SurfaceFault::SideCurve { side, vertex, why })
    })
}

/// Details where there is no vertex.
fn place_faults(mesh: &Connectivity, details: &Details) -> Vec<SurfaceFault> {
    let levels = (0_u32..).zip(&details.levels);
    let places = levels.flat_map(|(level, stored)| stored.iter().map(move |d| (level, d.0)));
    let nowhere = places.filter(|&(level, address)| !has_vertex(mesh, level, address));
    nowhere.map(|(level, address)| SurfaceFault::DetailNowhere { level, address }).collect()
}

/// Details that are not finite.
fn detail_faults(details: &Details) -> Vec<SurfaceFault> {
    let levels = (0_u32..).zip(&details.levels);
    let all = levels.flat_map(|(level, stored)| stored.iter().map(move |&(address, value)| (level, address, value)));
    let bad = all.filter(|(.., value)| !value.is_finite());
    bad.map(|(level, address, value)| SurfaceFault::DetailNotFinite { level, address, value }).collect()
}

/// Does the `level`-th subdivision of `mesh` have a vertex at `address`, and is that its name?
/// `level` is at most [`FINEST_LEVEL`](selvedge_components::subdivision::FINEST_LEVEL).
fn has_vertex(mesh: &Connectivity, level: u32, address: Address) -> bool {
    let n = 1_u64 << level;
    match address {
        Address::Corner(v) => v.index() < mesh.vertex_count(),
        Address::Edge(e, steps) => e.index() < mesh.edge_count() && steps > 0 && u64::from(steps) < n,
        Address::Face(f, i, j) => f.index() < mesh.face_count() && i > 0 && j > 0 && u64::from(i) + u64::from(j) < n,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use selvedge_components::mesh::{EdgeId, FaceId, Fault};
    use selvedge_components::subdivision::{CornerRule, Sides};

    use super::*;

    /// Two triangles; the border runs 0 1 2 3.
    fn square() -> LoopSurface {
        let mesh = Arc::new(Connectivity::new(4, &[[0, 1, 2], [0, 2, 3]]).unwrap());
        let points = vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
        let Sides { sides, corner_rule } = Sides::plain(&mesh, &[]);
        LoopSurface { mesh, points, sides, corner_rule, details: Details::default() }
    }

    fn side(vertices: &[u32], ends: Ends) -> Side {
        Side { vertices: vertices.iter().copied().map(VertexId).collect(), ends, border: Border::Plain }
    }

    fn faults(surface: &LoopSurface) -> Vec<SurfaceFault> {
        surface_faults(surface, &Budgets::default())
    }

    #[test]
    fn a_border_may_be_one_closed_side_or_any_chain_of_sides() {
        let mut surface = square();
        assert_eq!(faults(&surface), []);
        surface.sides = vec![side(&[1, 2, 3], Ends::Corners), side(&[3, 0, 1], Ends::Corners)];
        assert_eq!(faults(&surface), []);
        surface.sides = vec![side(&[2, 3, 0, 1, 2], Ends::Corners)];
        assert_eq!(faults(&surface), []);
        surface.corner_rule = CornerRule::Seed;
        assert_eq!(faults(&surface), []);
    }

    #[test]
    fn every_defect_of_the_sides_is_named_and_placed() {
        let edge = |a, b| [VertexId(a), VertexId(b)];
        let mut surface = square();
        surface.sides.clear();
        let missing = [(0, 1), (1, 2), (2, 3), (3, 0)].map(|(a, b)| SurfaceFault::SideMissing { ends: edge(a, b) });
        assert_eq!(faults(&surface), missing);
        surface.sides = vec![side(&[0, 1, 2, 3], Ends::Closed), side(&[2, 3], Ends::Corners)];
        assert_eq!(faults(&surface), [SurfaceFault::SideOverlap { ends: edge(2, 3), first: 0, second: 1 }]);
        // The diagonal, the wrong way round, a vertex that is not there, a side without an edge.
        surface.sides = vec![
            side(&[0, 1, 2, 3], Ends::Closed),
            side(&[0, 2], Ends::Corners),
            side(&[1, 0], Ends::Corners),
            side(&[9, 0], Ends::Corners),
            side(&[3], Ends::Corners),
        ];
        assert_eq!(
            faults(&surface),
            [
                SurfaceFault::SideOffBorder { side: 1, ends: edge(0, 2) },
                SurfaceFault::SideOffBorder { side: 2, ends: edge(1, 0) },
                SurfaceFault::SideOffBorder { side: 3, ends: edge(9, 0) },
                SurfaceFault::SideTooShort { side: 4, vertices: 1, least: 2 },
            ]
        );
    }

    #[test]
    fn points_and_details_that_are_not_finite_are_placed() {
        let mut surface = square();
        surface.points[2].y = f64::INFINITY;
        let (address, value) = (Address::Corner(VertexId(1)), DVec3::new(0.0, 0.0, f64::NEG_INFINITY));
        surface.details.levels = vec![vec![], vec![(address, value)]];
        let at = surface.points[2];
        assert_eq!(
            faults(&surface),
            [
                SurfaceFault::Mesh(Fault::NotFinite { vertex: VertexId(2), at }),
                SurfaceFault::DetailNotFinite { level: 1, address, value },
            ]
        );
    }

    /// The addresses that are accepted are exactly those that lattice points have.
    #[test]
    fn a_level_has_the_vertices_that_its_lattice_points_name() {
        let surface = square();
        for level in 0..=3 {
            let n = 1 << level;
            let lattice = |f| (0..=n).flat_map(move |i| (0..=n - i).map(move |j| (f, i, j)));
            let mut named: Vec<_> = (0..2)
                .flat_map(|f| lattice(FaceId(f)))
                .map(|(f, i, j)| Address::of(&surface.mesh, level, f, i, j))
                .collect();
            named.sort_unstable();
            named.dedup();
            let mut tried = Vec::new();
            tried.extend((0..6).map(|v| Address::Corner(VertexId(v))));
            tried.extend((0..7).flat_map(|e| (0..=n + 1).map(move |s| Address::Edge(EdgeId(e), s))));
            tried.extend((0..4).flat_map(|f| lattice(FaceId(f))).map(|(f, i, j)| Address::Face(f, i, j)));
            tried.retain(|&address| has_vertex(&surface.mesh, level, address));
            tried.sort_unstable();
            assert_eq!(tried, named, "level {level}");
        }
    }

    #[test]
    fn more_details_than_allowed_are_over_budget() {
        let mut surface = square();
        surface.details.levels = vec![(0..3).map(|v| (Address::Corner(VertexId(v)), DVec3::X)).collect()];
        let budgets = Budgets { details: 2, ..Budgets::default() };
        let exceeded = budgets.check(Budget::Details, 3).unwrap_err();
        assert_eq!(surface_faults(&surface, &budgets), [SurfaceFault::Budget(exceeded)]);
    }
}
