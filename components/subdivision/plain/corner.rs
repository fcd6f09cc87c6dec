//! The pieces of a face around one of its corners, level by level.

use super::topology::VertexRule;
use crate::subdivision::boxspline::{Net, Quartic, Vector};

/// A corner of a face, and what subdivision towards it has reached.
///
/// From the first level on every vertex but the corner itself is regular. In the lattice of the
/// level, with the corner at (0, 0) and the face at (1, 0) and (0, 1), the control points are the
/// corner, its ring, and five more: `(2,-1) (2,0) (1,1) (0,2) (-1,2)`. Those beyond a border are the
/// phantoms of `reflect`.
///
/// Points are relative to the corner's limit: so rounding shrinks with the neighbourhood, and
/// differences of its points stay exact however fine it gets.
#[derive(Clone, Debug)]
pub struct CornerPieces<V> {
    pub(super) rule: VertexRule,
    /// What each neighbour of an interior corner weighs under one step.
    pub(super) weight: f64,
    pub(super) limit: V,
    pub(super) centre: V,
    /// The corner's neighbours, counter-clockwise; around a border from the next border vertex to
    /// the previous one. The first `valence` count, the rest is scratch.
    pub(super) ring: Vec<V>,
    pub(super) valence: usize,
    /// The place in the ring of the point at (1, 0).
    pub(super) first: usize,
    pub(super) outer: [V; 5],
    /// The points at (1,-1) (1,0) (0,1) (-1,1).
    near: [V; 4],
    /// `near` and `outer` of the level before.
    coarser: ([V; 4], [V; 5]),
    /// As long as `ring`.
    spare: Vec<V>,
}

/// The point beyond a regular border that makes the border's rules those of the interior: the
/// fourth corner of the parallelogram over the border edge `a b` and the vertex `inside` across it.
#[inline(always)]
pub(super) fn reflect<V: Vector>(a: V, b: V, inside: V) -> V {
    a + b - inside
}

/// The vertex that an interior edge `a b` gains between the vertices `c` and `d` across it.
#[inline(always)]
pub(super) fn edge_point<V: Vector>(a: V, b: V, c: V, d: V) -> V {
    (a + b) * 0.375 + (c + d) * 0.125
}

/// Where a vertex of valence 6 goes.
#[inline(always)]
fn regular_vertex<V: Vector>(v: V, [a, b, c, d, e, f]: [V; 6]) -> V {
    v * 0.625 + ((a + d) + (b + e) + (c + f)) * 0.0625
}

/// `weight` of each of `ring` and the rest of 1 of `centre`.
#[inline(always)]
pub(super) fn weigh<V: Vector>(centre: V, ring: &[V], weight: f64) -> V {
    let mut sum = ring[0];
    for &p in &ring[1..] {
        sum = sum + p;
    }
    centre * (1.0 - ring.len() as f64 * weight) + sum * weight
}

impl<V: Vector> CornerPieces<V> {
    /// No corner yet: all points `zero`.
    pub fn new(zero: V) -> Self {
        let (near, outer) = ([zero; 4], [zero; 5]);
        Self {
            rule: VertexRule::Interior,
            weight: 0.0,
            limit: zero,
            centre: zero,
            ring: Vec::new(),
            valence: 0,
            first: 0,
            outer,
            near,
            coarser: (near, outer),
            spare: Vec::new(),
        }
    }

    /// The ring of a corner of valence `valence`, to be filled with the points of the first level.
    #[inline(always)]
    pub(super) fn begin(&mut self, valence: usize, zero: V) -> &mut [V] {
        if self.ring.len() < valence {
            self.ring.resize(valence, zero);
            self.spare.resize(valence, zero);
        }
        self.valence = valence;
        &mut self.ring[..valence]
    }

    /// Reads `near` from the ring; beyond a border it is a phantom.
    #[inline(always)]
    pub(super) fn find_near(&mut self) {
        let (ring, first, k) = (&self.ring[..self.valence], self.first, self.valence);
        let open = self.rule != VertexRule::Interior;
        let r0 = ring[first];
        let r1 = ring[if first + 1 < k { first + 1 } else { 0 }];
        let before = match first {
            0 if open => reflect(self.centre, r0, r1),
            0 => ring[k - 1],
            _ => ring[first - 1],
        };
        let after = match first + 2 {
            after if after < k => ring[after],
            _ if open => reflect(self.centre, r1, r0),
            after => ring[after - k],
        };
        self.near = [before, r0, r1, after];
    }

    /// Goes one level finer, towards the corner: now [`Self::quarter`] gives the pieces that this
    /// step leaves behind.
    #[inline(always)]
    pub fn descend(&mut self) {
        let ([before, r0, r1, after], [z, y, x, w, u], v) = (self.near, self.outer, self.centre);
        self.coarser = (self.near, self.outer);
        self.outer = [
            edge_point(before, r0, v, z),
            regular_vertex(r0, [v, r1, x, y, z, before]),
            edge_point(r0, r1, v, x),
            regular_vertex(r1, [v, after, u, w, x, r0]),
            edge_point(r1, after, v, u),
        ];
        self.step();
        self.find_near();
    }

    /// The corner and its ring one level finer.
    #[inline(always)]
    fn step(&mut self) {
        let (v, last) = (self.centre, self.valence - 1);
        let (ring, finer) = (&self.ring[..=last], &mut self.spare[..=last]);
        let (head, tail) = (ring[0], ring[last]);
        for (r, finer) in ring.windows(3).zip(&mut finer[1..]) {
            *finer = edge_point(v, r[1], r[0], r[2]);
        }
        if self.rule == VertexRule::Interior {
            self.centre = weigh(v, ring, self.weight);
            finer[0] = edge_point(v, head, tail, ring[1]);
            finer[last] = edge_point(v, tail, ring[last - 1], head);
        } else {
            if self.rule == VertexRule::Border {
                self.centre = (head + tail) * 0.125 + v * 0.75;
            }
            finer[0] = (v + head) * 0.5;
            finer[last] = (v + tail) * 0.5;
        }
        core::mem::swap(&mut self.ring, &mut self.spare);
    }

    /// The polynomial of a quarter of the face that the last step left behind, in the quarter's own
    /// coordinates. Quarters 0 and 1 are those next to the two edges, in the corner's directions; 2 is
    /// the one between, turned by half a turn: its origin is the middle of the far edge.
    #[inline(always)]
    pub fn quarter(&self, quarter: u8) -> Quartic<V> {
        let ([before, r0, r1, after], [z, y, x, w, u]) = self.coarser;
        // Named by their place in the finer lattice; `m` is -1.
        let ([c1m, c10, c01, cm1], [c2m, c20, c11, c02, cm2], c00) = (self.near, self.outer, self.centre);
        let (c21, c12) = (edge_point(r0, x, r1, y), edge_point(r1, x, r0, w));
        match quarter {
            0 => {
                let (c3m, c30) = (edge_point(r0, z, before, y), edge_point(r0, y, z, x));
                self.place(&[c10, c20, c11, c2m, c21, c01, c00, c1m, c3m, c30, c12, c02])
            }
            1 => {
                let (c03, cm3) = (edge_point(r1, w, x, u), edge_point(r1, u, w, after));
                self.place(&[c01, c11, c02, c10, c12, cm2, cm1, c00, c20, c21, c03, cm3])
            }
            _ => self.place(&[c11, c01, c10, c02, c00, c20, c21, c12, cm2, cm1, c1m, c2m]),
        }
    }

    /// The polynomial of a net that is relative to the limit.
    #[inline(always)]
    fn place(&self, net: &Net<V>) -> Quartic<V> {
        let mut quartic = Quartic::new(net);
        quartic.coefficients[0] = quartic.coefficients[0] + self.limit;
        quartic
    }
}
