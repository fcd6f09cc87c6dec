//! Where what a trim leaves and what it takes away meet: edge by edge, to the bit.

use std::sync::Arc;

use glam::DVec3;
use selvedge::curve::Curve;
use selvedge::subdivision::{Border, Ends, LoopSurface};
use selvedge::triangulation::{Density, TriangulateOptions};
use selvedge_systems::triangulate::triangulate;

/// What tells points apart.
pub type Bits = [u64; 3];

/// The two zeros are one.
pub fn bits(p: DVec3) -> Bits {
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Edges of triangles, where two surfaces should meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seam {
    /// How many the other side has along the curves, by its own account.
    pub expected: usize,
    /// How many of its border edges have an end that is a sample there.
    pub found: usize,
    /// Of how many of these none of the other way is a border of what is left.
    pub open: usize,
}

/// Compares the borders of `kept` and `other` along `curves`, as triangles of a level.
pub fn seam(kept: &LoopSurface, other: &LoopSurface, curves: &[Arc<dyn Curve>], level: u32) -> Result<Seam, String> {
    let options = TriangulateOptions { density: Density::Level(level), ..TriangulateOptions::default() };
    let borders = |surface: &LoopSurface| {
        let made = triangulate(surface, &options).map_err(|why| why.to_string())?.triangles;
        let corners = made.triangles.iter().map(|t| t.map(|v| bits(made.positions[v as usize])));
        let mut edges: Vec<[Bits; 2]> = corners.flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        let alone = |[a, b]: &&[Bits; 2]| edges.binary_search(&[*b, *a]).is_err();
        Ok::<_, String>(edges.iter().filter(alone).copied().collect::<Vec<_>>())
    };
    let (kept, beside) = (borders(kept)?, borders(other)?);
    let (mut samples, mut expected) = (Vec::new(), 0);
    for side in &other.sides {
        let Border::Given { curve, .. } = &side.border else { continue };
        if curves.iter().any(|own| Arc::ptr_eq(own, curve.curve())) {
            // Where a side begins or ends at another line, the older gives the point.
            let open = u64::from(side.ends == Ends::Corners);
            let count = (side.edge_count() as u64) << level;
            let at = |step| bits(curve.sample(level, side.curve_index(level, step).expect("a step of the side")));
            samples.extend((open..count).map(at));
            expected += count as usize;
        }
    }
    samples.sort_unstable();
    let is_seam = |[a, b]: &&[Bits; 2]| samples.binary_search(a).is_ok() || samples.binary_search(b).is_ok();
    let along: Vec<_> = beside.iter().filter(is_seam).collect();
    let open = along.iter().filter(|[a, b]| kept.binary_search(&[*b, *a]).is_err()).count();
    Ok(Seam { expected, found: along.len(), open })
}
