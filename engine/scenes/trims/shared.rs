//! Two surfaces along one trim curve: a plate with a bore, and the wall of the bore.

use std::sync::Arc;

use glam::DVec3;
use selvedge_components::curve::{CurveParameters, Heading};
use selvedge_components::mesh::{Connectivity, VertexId};
use selvedge_components::subdivision::{Border, CornerRule, Details, Ends, LoopSurface, Side};
use selvedge_components::triangles::Triangles;
use selvedge_systems::triangulate::{Density, TriangulateOptions, triangulate};

use super::{TrimSceneError, Trimmed};

/// Depth of the wall below the plate, in metres.
const DEPTH: f64 = 0.05;
/// Rows of vertices below the curve.
const ROWS: u32 = 4;

/// The tube that hangs from the first round cut of `trimmed`: a swept cage whose upper border is given
/// by the very parameters that the plate's border has.
///
/// # Errors
/// None where the trim has left a side that runs round; then [`TrimSceneError::NoRim`].
pub fn wall(trimmed: &Trimmed) -> Result<LoopSurface, TrimSceneError> {
    let (curve, heading) = rim(&trimmed.surface).ok_or(TrimSceneError::NoRim)?;
    let n = curve.edge_count(0) as u32;
    // The plate's border runs with the plate on its left; the wall's the other way.
    let down = DEPTH / f64::from(ROWS);
    let row = |k: u32| curve.samples(0).map(move |p| p - DVec3::Z * (down * f64::from(k)));
    let points: Vec<DVec3> = (0..=ROWS).flat_map(row).collect();
    let name = |k: u32, i: u32| k * n + i % n;
    let quads = (0..ROWS).flat_map(|k| (0..n).map(move |i| (k, i)));
    let faces = quads.flat_map(|(k, i)| {
        let [a, b, c, d] = [name(k, i), name(k, i + 1), name(k + 1, i), name(k + 1, i + 1)];
        // A border walked along the curve's parameters has the face `[a, b, ..]` on its left.
        match heading {
            Heading::Along => [[b, a, c], [b, c, d]],
            Heading::Against => [[a, b, d], [a, d, c]],
        }
    });
    let faces: Vec<[u32; 3]> = faces.collect();
    let mesh = Arc::new(Connectivity::new(points.len(), &faces).map_err(TrimSceneError::Mesh)?);
    let other = if heading == Heading::Along { Heading::Against } else { Heading::Along };
    let sides = mesh.border_loops().into_iter().map(|vertices| side(vertices, n, &curve, other));
    Ok(LoopSurface {
        sides: sides.collect(),
        mesh: Arc::clone(&mesh),
        points,
        corner_rule: CornerRule::Lattice,
        details: Details::default(),
    })
}

/// The first given side that runs round, which a round cut has left.
fn rim(surface: &LoopSurface) -> Option<(Arc<CurveParameters>, Heading)> {
    surface.sides.iter().find_map(|side| match &side.border {
        Border::Given { curve, heading, .. } if side.ends == Ends::Closed => Some((Arc::clone(curve), *heading)),
        _ => None,
    })
}

/// A border of the tube: the upper one is given, the lower one its own.
fn side(vertices: Vec<VertexId>, n: u32, curve: &Arc<CurveParameters>, heading: Heading) -> Side {
    let upper = vertices[0].0 < n;
    // Vertex `i` of the upper row stands at parameter `i`.
    let given = Border::Given { curve: Arc::clone(curve), first: u64::from(vertices[0].0), heading };
    Side { vertices, ends: Ends::Closed, border: if upper { given } else { Border::Plain } }
}

/// Open edges of plate and wall together that lie on their seam: none if they meet to the bit. Both are
/// quartered `level` times.
///
/// # Errors
/// If one of them cannot be triangulated.
pub fn open_seam_edges(trimmed: &Trimmed, wall: &LoopSurface, level: u32) -> Result<usize, TrimSceneError> {
    let options = TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() };
    let both = [&trimmed.surface, wall].map(|surface| triangulate(surface, &options).map(|made| made.triangles));
    let [plate, wall] = both;
    let (plate, wall) = (plate?, wall?);
    let (curve, _) = rim(&trimmed.surface).ok_or(TrimSceneError::NoRim)?;
    let bits = |p: DVec3| (p + DVec3::ZERO).to_array().map(f64::to_bits);
    let seam: Vec<[u64; 3]> = {
        let mut seam: Vec<_> = curve.samples(level).map(bits).collect();
        seam.sort_unstable();
        seam
    };
    let directed = |made: &Triangles| -> Vec<[[u64; 3]; 2]> {
        let corners = made.triangles.iter().map(|t| t.map(|v| bits(made.positions[v as usize])));
        corners.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect()
    };
    let mut edges = directed(&plate);
    edges.extend(directed(&wall));
    edges.sort_unstable();
    let alone = |[a, b]: &&[[u64; 3]; 2]| edges.binary_search(&[*b, *a]).is_err();
    // An edge with either end on the seam's curve counts, so that one that misses a sample is found.
    let near = |[a, b]: &&[[u64; 3]; 2]| seam.binary_search(a).is_ok() || seam.binary_search(b).is_ok();
    Ok(edges.iter().filter(alone).filter(near).count() + seam_faults(&edges, &seam))
}

/// Samples of the seam at which not exactly one edge comes in and one goes out along the seam on each of
/// the two surfaces.
fn seam_faults(edges: &[[[u64; 3]; 2]], seam: &[[u64; 3]]) -> usize {
    let on = |p: &[u64; 3]| seam.binary_search(p).is_ok();
    let mut out: Vec<[u64; 3]> = edges.iter().filter(|[a, b]| on(a) && on(b)).map(|e| e[0]).collect();
    out.sort_unstable();
    let count = |p: &[u64; 3]| out.partition_point(|q| q <= p) - out.partition_point(|q| q < p);
    seam.iter().filter(|p| count(p) != 2).count()
}
