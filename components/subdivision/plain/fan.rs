//! The faces around one vertex, subdivided towards it.

use glam::DVec3;

use super::topology::VertexRule;
use crate::subdivision::boxspline::Net;

/// The control points that shape one face around a vertex, at any level from the first on: there
/// every vertex but the centre is regular.
///
/// In the lattice of the face, with the centre at (0, 0) and the face's spokes ending at (1, 0) and
/// (0, 1), `outer` holds the points at (2,-1) (2,0) (1,1) (0,2) (-1,2). Points beyond a border are
/// the phantoms of [`reflect`].
#[derive(Clone, Debug)]
pub(super) struct Fan {
    pub rule: VertexRule,
    /// What each neighbour of an interior centre weighs under one step.
    pub weight: f64,
    pub centre: DVec3,
    /// The centre's neighbours, counter-clockwise; around a border from the next border vertex to
    /// the previous one.
    pub spokes: Vec<DVec3>,
    /// The spoke that ends at (1, 0).
    pub first: usize,
    pub outer: [DVec3; 5],
}

impl Default for Fan {
    fn default() -> Self {
        let (centre, outer) = (DVec3::ZERO, [DVec3::ZERO; 5]);
        Self { rule: VertexRule::Interior, weight: 0.0, centre, spokes: Vec::new(), first: 0, outer }
    }
}

/// Which quarter of a fan's face, one level finer, holds a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Quarter {
    /// At the spoke that ends at (1, 0), in the same directions.
    First,
    /// At the spoke that ends at (0, 1), in the same directions.
    Second,
    /// Between them, turned by half a turn: its origin is the middle of the far edge.
    Middle,
}

/// The point beyond a regular border that makes the border's rules those of the interior: the
/// fourth corner of the parallelogram over the border edge `a b` and the vertex `inside` across it.
#[inline(always)]
pub(super) fn reflect(a: DVec3, b: DVec3, inside: DVec3) -> DVec3 {
    a + b - inside
}

/// The vertex that an interior edge `a b` gains between the vertices `c` and `d` across it.
#[inline(always)]
pub(super) fn edge_point(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> DVec3 {
    (a + b) * 0.375 + (c + d) * 0.125
}

/// Where a vertex of valence 6 goes.
#[inline(always)]
fn regular_vertex(v: DVec3, ring: [DVec3; 6]) -> DVec3 {
    let [a, b, c, d, e, f] = ring;
    v * 0.625 + ((a + d) + (b + e) + (c + f)) * 0.0625
}

impl Fan {
    fn is_open(&self) -> bool {
        self.rule != VertexRule::Interior
    }

    /// The index of the spoke `by` places after the face's first one; `None` beyond a border.
    #[inline(always)]
    fn spoke(&self, by: isize) -> Option<usize> {
        let (k, i) = (self.spokes.len() as isize, self.first as isize + by);
        if self.is_open() { (0..k).contains(&i).then_some(i as usize) } else { Some(i.rem_euclid(k) as usize) }
    }

    /// The ends of the face's spokes and of the ones beside them: (1,-1) (1,0) (0,1) (-1,1).
    #[inline(always)]
    fn spokes_near(&self) -> [DVec3; 4] {
        let at = |by| self.spoke(by).map(|i| self.spokes[i]);
        let (r0, r1) = (at(0).unwrap_or_default(), at(1).unwrap_or_default());
        let before = at(-1).unwrap_or_else(|| reflect(self.centre, r0, r1));
        [before, r0, r1, at(2).unwrap_or_else(|| reflect(self.centre, r1, r0))]
    }

    /// Where the centre goes.
    #[inline(always)]
    fn stepped_centre(&self) -> DVec3 {
        let spokes = self.spokes.as_slice();
        match self.rule {
            VertexRule::Interior => {
                let sum = spokes.iter().fold(DVec3::ZERO, |sum, &p| sum + p);
                self.centre * (1.0 - spokes.len() as f64 * self.weight) + sum * self.weight
            }
            VertexRule::Border => (spokes[0] + spokes[spokes.len() - 1]) * 0.125 + self.centre * 0.75,
            VertexRule::Corner => self.centre,
        }
    }

    /// Where spoke `i` ends one level finer.
    #[inline(always)]
    fn stepped_spoke(&self, i: usize) -> DVec3 {
        let (v, end, last) = (self.centre, self.spokes[i], self.spokes.len() - 1);
        if self.is_open() && (i == 0 || i == last) {
            return (v + end) * 0.5;
        }
        let before = self.spokes[if i == 0 { last } else { i - 1 }];
        edge_point(v, end, before, self.spokes[if i == last { 0 } else { i + 1 }])
    }

    /// Goes one level finer, towards the centre. `spare` is scratch.
    pub fn step(&mut self, spare: &mut Vec<DVec3>) {
        let [before, r0, r1, after] = self.spokes_near();
        let [z, y, x, w, u] = self.outer;
        let v = self.centre;
        let outer = [
            edge_point(before, r0, v, z),
            regular_vertex(r0, [v, r1, x, y, z, before]),
            edge_point(r0, r1, v, x),
            regular_vertex(r1, [v, after, u, w, x, r0]),
            edge_point(r1, after, v, u),
        ];
        spare.clear();
        spare.extend((0..self.spokes.len()).map(|i| self.stepped_spoke(i)));
        self.centre = self.stepped_centre();
        self.outer = outer;
        core::mem::swap(&mut self.spokes, spare);
    }

    /// The control points of a quarter of the face, one level finer; it is regular.
    #[inline(always)]
    pub fn quarter(&self, quarter: Quarter) -> Net {
        let [before, r0, r1, after] = self.spokes_near();
        let [z, y, x, w, u] = self.outer;
        let v = self.centre;
        let stepped = |by| self.spoke(by).map(|i| self.stepped_spoke(i));
        // Named by their place in the finer lattice; `m` is -1.
        let c00 = self.stepped_centre();
        let (c10, c01) = (stepped(0).unwrap_or_default(), stepped(1).unwrap_or_default());
        let c1m = || stepped(-1).unwrap_or_else(|| reflect(c00, c10, c01));
        let cm1 = || stepped(2).unwrap_or_else(|| reflect(c00, c01, c10));
        let c11 = edge_point(r0, r1, v, x);
        let c20 = regular_vertex(r0, [v, r1, x, y, z, before]);
        let c02 = regular_vertex(r1, [v, after, u, w, x, r0]);
        let (c21, c12) = (edge_point(r0, x, r1, y), edge_point(r1, x, r0, w));
        let (c2m, cm2) = (edge_point(before, r0, v, z), edge_point(r1, after, v, u));
        match quarter {
            Quarter::First => {
                let (c3m, c30) = (edge_point(r0, z, before, y), edge_point(r0, y, z, x));
                [c10, c20, c11, c2m, c21, c01, c00, c1m(), c3m, c30, c12, c02]
            }
            Quarter::Second => {
                let (c03, cm3) = (edge_point(r1, w, x, u), edge_point(r1, u, w, after));
                [c01, c11, c02, c10, c12, cm2, cm1(), c00, c20, c21, c03, cm3]
            }
            Quarter::Middle => [c11, c01, c10, c02, c00, c20, c21, c12, cm2, cm1(), c1m(), c2m],
        }
    }
}
