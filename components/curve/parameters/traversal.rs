//! How a surface walks along parameters that the curve owns.

use super::CurveParameters;
use crate::curve::Extent;

/// Which way a surface walks along a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Heading {
    /// Parameters rise along the walk.
    Along,
    /// Parameters fall along the walk.
    Against,
}

/// A surface's own count of the vertices along [`CurveParameters`]: where it begins and which way
/// it goes.
///
/// The parameters have one order, the curve's; a surface maps its indices and computes nothing
/// again. So two surfaces that walk the same curve in opposite directions, from wherever, share the
/// bits of every sample.
///
/// ```
/// use std::sync::Arc;
/// use glam::DVec3;
/// use selvedge_components::curve::{Circle, CurveParameters, Heading, Traversal};
///
/// let circle = Circle::new(DVec3::ZERO, DVec3::Z, 1.0)?;
/// let border = CurveParameters::even(Arc::new(circle), 6)?;
/// let other_side = Traversal { first: 2, heading: Heading::Against };
/// let walked: Vec<_> = (0..6).map(|k| other_side.vertex(&border, 0, k)).collect();
/// assert_eq!(walked, [2, 1, 0, 5, 4, 3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Traversal {
    /// The vertex of level 0 that the walk begins at.
    pub first: u64,
    /// Which way it goes.
    pub heading: Heading,
}

impl Traversal {
    /// The walk over all of `of`: along it from its first vertex or, against it, from its last; a
    /// closed list is walked from its first vertex either way.
    pub fn all(of: &CurveParameters, heading: Heading) -> Self {
        let first = match (heading, of.extent()) {
            (Heading::Against, Extent::Open) => of.edge_count(0),
            _ => 0,
        };
        Self { first, heading }
    }

    /// The index, on the curve, of vertex `k` of the walk at `level`. Closed walks go round; open
    /// ones end at the last vertex.
    pub fn vertex(&self, of: &CurveParameters, level: u32, k: u64) -> u64 {
        let count = of.vertex_count(level);
        match of.extent() {
            Extent::Open => {
                let first = shifted(self.first.min(of.edge_count(0)), level).min(count - 1);
                match self.heading {
                    Heading::Along => first.saturating_add(k).min(count - 1),
                    Heading::Against => first.saturating_sub(k),
                }
            }
            Extent::Closed => {
                let first = shifted(self.first % of.edge_count(0), level) % count;
                match self.heading {
                    Heading::Along => add(first, k % count, count),
                    Heading::Against => add(first, (count - k % count) % count, count),
                }
            }
        }
    }

    /// The index, on the curve, of edge `k` of the walk at `level`: from its vertex `k` to the next.
    pub fn edge(&self, of: &CurveParameters, level: u32, k: u64) -> u64 {
        // The edge of the curve has the index of that of its two vertices which comes first on it.
        let vertex = match self.heading {
            Heading::Along => self.vertex(of, level, k),
            Heading::Against => self.vertex(of, level, k.saturating_add(1)),
        };
        vertex.min(of.edge_count(level) - 1)
    }
}

/// The index, at `level`, of a vertex of level 0.
fn shifted(vertex: u64, level: u32) -> u64 {
    vertex.saturating_mul(1_u64.checked_shl(level).unwrap_or(u64::MAX))
}

/// `a + b` counted round, for `a` and `b` below `count`, without overflow.
fn add(a: u64, b: u64, count: u64) -> u64 {
    if b < count - a { a + b } else { b - (count - a) }
}
