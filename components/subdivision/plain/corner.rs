//! The pieces of a face around one of its corners, level by level.

use super::block::Ring;
use super::patch::Load;
use super::topology::{InteriorMask, VertexRule};
use crate::subdivision::boxspline::{Net, Quartic, Vector};

/// A corner of a face, and what subdivision towards it has left behind.
///
/// From the first level on every vertex but the corner itself is regular. In the lattice of a level,
/// with the corner at (0, 0) and the face at (1, 0) and (0, 1), the control points that matter are
/// the corner, four of its ring, and five more: `(2,-1) (2,0) (1,1) (0,2) (-1,2)`. Those beyond a
/// border are the phantoms of `reflect`.
///
/// Points are relative to the corner's limit: so rounding shrinks with the neighbourhood, and
/// differences of its points stay exact however fine it gets.
#[derive(Clone, Debug)]
pub struct CornerPieces<'a, L: Load> {
    load: L,
    pub(super) corner: Corner<'a, L::Vector>,
    /// The corner's neighbours at the finest level so far; of no meaning where no level but the first two was
    /// needed.
    ring: Neighbours<L::Vector>,
    /// What each depth leaves behind; the first `depths` count.
    lattices: Vec<Lattice<L::Vector>>,
    depths: usize,
}

/// What is known of a corner at the first level.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner<'a, V> {
    pub rule: VertexRule,
    pub valence: usize,
    /// Of an interior corner.
    pub mask: InteriorMask,
    /// The place in the ring of the point at (1, 0).
    pub first: usize,
    pub limit: V,
    /// The corner at the first level and the second.
    pub centres: [V; 2],
    pub ring: Ring<'a>,
    pub outer: [V; 5],
}

/// The first level around an interior corner, and what of the ring is near the face: `N` points in a row, the
/// two on the face's edges in their middle.
#[derive(Clone, Copy)]
pub(super) struct Around<V, const N: usize> {
    pub limit: V,
    /// The corner at the first level and the second, and what says where it goes from there ([`next`]).
    pub centres: [V; 2],
    pub eigenvalue: f64,
    pub ring: [V; N],
    pub outer: [V; 5],
}

/// Control points of one level around a corner, by their place in it; `m` is -1.
///
/// ```text
///    0    1    2    3    4    5    6    7    8    9   10   11   12   13   14   15
///   00   1m   10   01   m1   2m   20   11   02   m2   21   12   3m   30   03   m3
/// ```
type Lattice<V> = [V; 16];

/// The places in a [`Lattice`] of the control points of each quarter.
const NETS: [[usize; 12]; 3] = [
    [2, 6, 7, 5, 10, 3, 0, 1, 12, 13, 11, 8],
    [3, 7, 8, 2, 11, 9, 4, 0, 6, 10, 14, 15],
    [7, 3, 2, 8, 0, 6, 10, 11, 9, 4, 1, 5],
];

impl<V: Vector> Corner<'_, V> {
    /// No corner yet.
    pub fn none(load: impl Load<Vector = V>) -> Self {
        let zero = load.zero();
        Self {
            rule: VertexRule::Interior,
            valence: 0,
            mask: InteriorMask::default(),
            first: 0,
            limit: zero,
            centres: [zero; 2],
            ring: Ring::default(),
            outer: [zero; 5],
        }
    }

    /// What is near the face of an interior corner.
    #[inline(always)]
    pub fn around<const N: usize>(&self, load: impl Load<Vector = V>) -> Around<V, N> {
        let &Corner { mask: InteriorMask { eigenvalue, .. }, valence, first, limit, centres, ring, outer, .. } = self;
        Around { limit, centres, eigenvalue, ring: ring.window(load, valence, first, N / 2 - 1), outer }
    }
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
pub(super) fn regular_vertex<V: Vector>(v: V, [a, b, c, d, e, f]: [V; 6]) -> V {
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

/// Where a step takes a vertex; `weight` is that of each neighbour of an interior one.
#[inline(always)]
pub(super) fn step_centre<V: Vector>(rule: VertexRule, weight: f64, v: V, ring: &[V]) -> V {
    match rule {
        VertexRule::Interior => weigh(v, ring, weight),
        VertexRule::Border => (ring[0] + ring[ring.len() - 1]) * 0.125 + v * 0.75,
        VertexRule::Corner => v,
    }
}

/// Where a vertex is one step after the second of two successive places.
#[inline(always)]
pub(super) fn next<V: Vector>([before, v]: [V; 2], eigenvalue: f64) -> V {
    v + (v - before) * eigenvalue
}

/// The four points of a ring around (1, 0) and (0, 1), of which `first` is the place of the first;
/// beyond a border they are phantoms.
#[inline(always)]
pub(super) fn near<V: Vector>(rule: VertexRule, centre: V, ring: &[V], first: usize) -> [V; 4] {
    let k = ring.len();
    let open = rule != VertexRule::Interior;
    let r0 = ring[first];
    let r1 = ring[if first + 1 < k { first + 1 } else { 0 }];
    let before = match first {
        0 if open => reflect(centre, r0, r1),
        0 => ring[k - 1],
        _ => ring[first - 1],
    };
    let after = match first + 2 {
        after if after < k => ring[after],
        _ if open => reflect(centre, r1, r0),
        after => ring[after - k],
    };
    [before, r0, r1, after]
}

/// The points that a step makes of the inner four of six in a row of the ring around `v`.
#[inline(always)]
fn between<V: Vector>(v: V, [a, b, c, d, e, f]: [V; 6]) -> [V; 4] {
    [edge_point(v, b, a, c), edge_point(v, c, b, d), edge_point(v, d, c, e), edge_point(v, e, d, f)]
}

/// Writes what a step leaves behind of the points around `corner`, which are `near` and `outer` before
/// it and `to` and `to_near` after it.
#[inline(always)]
fn leave<V: Vector>(lattice: &mut Lattice<V>, corner: V, near: [V; 4], outer: [V; 5], to: V, to_near: [V; 4]) {
    let ([before, r0, r1, after], [z, y, x, w, u], v) = (near, outer, corner);
    lattice[0] = to;
    [lattice[1], lattice[2], lattice[3], lattice[4]] = to_near;
    lattice[5] = edge_point(before, r0, v, z);
    lattice[6] = regular_vertex(r0, [v, r1, x, y, z, before]);
    lattice[7] = edge_point(r0, r1, v, x);
    lattice[8] = regular_vertex(r1, [v, after, u, w, x, r0]);
    lattice[9] = edge_point(r1, after, v, u);
    lattice[10] = edge_point(r0, x, r1, y);
    lattice[11] = edge_point(r1, x, r0, w);
    lattice[12] = edge_point(r0, z, before, y);
    lattice[13] = edge_point(r0, y, z, x);
    lattice[14] = edge_point(r1, w, x, u);
    lattice[15] = edge_point(r1, u, w, after);
}

/// Writes what the first step leaves behind around an interior corner.
#[inline(always)]
fn leave_first<L: Load>(load: L, corner: &Corner<'_, L::Vector>, lattice: &mut Lattice<L::Vector>) {
    let Around { centres: [v, to], ring: r, outer, .. } = corner.around::<6>(load);
    leave(lattice, v, [r[1], r[2], r[3], r[4]], outer, to, between(v, r));
}

/// Writes what the second step leaves behind there; `before` is what the first has. So far most of the
/// ring is of no use.
#[inline(always)]
fn leave_second<L: Load>(
    load: L,
    corner: &Corner<'_, L::Vector>,
    before: &Lattice<L::Vector>,
    lattice: &mut Lattice<L::Vector>,
) {
    let [v, n0, n1, n2, n3, z, y, x, w, u, ..] = *before;
    let Around { centres, eigenvalue, ring: r, .. } = corner.around::<8>(load);
    let before = edge_point(centres[0], r[1], r[0], r[2]);
    let after = edge_point(centres[0], r[6], r[5], r[7]);
    let to_near = between(v, [before, n0, n1, n2, n3, after]);
    leave(lattice, v, [n0, n1, n2, n3], [z, y, x, w, u], next(centres, eigenvalue), to_near);
}

/// The neighbours of a corner at one level, counter-clockwise; around a border from the next border vertex to
/// the previous one.
#[derive(Clone, Debug)]
pub(super) struct Neighbours<V> {
    /// The first are those of the corner, as many as its valence says.
    ring: Vec<V>,
    /// As long as `ring`.
    spare: Vec<V>,
}

impl<V: Vector> Neighbours<V> {
    /// Of no corner.
    pub const fn none() -> Self {
        Self { ring: Vec::new(), spare: Vec::new() }
    }

    /// Reads the first level's.
    #[inline(always)]
    pub fn read(&mut self, load: impl Load<Vector = V>, corner: &Corner<'_, V>) {
        let k = corner.valence;
        if self.ring.len() < k {
            self.ring.resize(k, load.zero());
            self.spare.resize(k, load.zero());
        }
        for (i, point) in self.ring[..k].iter_mut().enumerate() {
            *point = corner.ring.point(load, i);
        }
    }

    /// Goes from a level at which the corner is at `v` to the next.
    #[inline(always)]
    pub fn step(&mut self, corner: &Corner<'_, V>, v: V) {
        let k = corner.valence;
        step_ring(corner.rule, v, &self.ring[..k], &mut self.spare[..k]);
        core::mem::swap(&mut self.ring, &mut self.spare);
    }

    /// Those of `corner`, which they were read of.
    #[inline(always)]
    pub fn of(&self, corner: &Corner<'_, V>) -> &[V] {
        &self.ring[..corner.valence]
    }
}

/// Writes the ring around `v` one step finer.
#[inline(always)]
fn step_ring<V: Vector>(rule: VertexRule, v: V, ring: &[V], finer: &mut [V]) {
    let last = ring.len() - 1;
    let (head, tail) = (ring[0], ring[last]);
    for (r, finer) in ring.windows(3).zip(&mut finer[1..]) {
        *finer = edge_point(v, r[1], r[0], r[2]);
    }
    if rule == VertexRule::Interior {
        finer[0] = edge_point(v, head, tail, ring[1]);
        finer[last] = edge_point(v, tail, ring[last - 1], head);
    } else {
        finer[0] = (v + head) * 0.5;
        finer[last] = (v + tail) * 0.5;
    }
}

impl<'a, L: Load> CornerPieces<'a, L> {
    /// No corner yet.
    pub(super) fn new(load: L) -> Self {
        let corner = Corner::none(load);
        Self { load, corner, ring: Neighbours::none(), lattices: Vec::new(), depths: 0 }
    }

    /// How many depths are known; 0 of no corner.
    #[inline(always)]
    pub fn depths(&self) -> usize {
        self.depths
    }

    /// Makes the pieces of the first depth those around `corner`.
    #[inline(always)]
    pub(super) fn begin(&mut self, corner: Corner<'a, L::Vector>) {
        self.corner = corner;
        self.depths = 0;
        if self.lattices.is_empty() {
            self.grow();
        }
        let Corner { rule, first, centres: [v, to], outer, .. } = corner;
        if rule == VertexRule::Interior {
            leave_first(self.load, &corner, &mut self.lattices[0]);
        } else {
            self.ring.read(self.load, &corner);
            let before = near(rule, v, self.ring.of(&corner), first);
            self.ring.step(&corner, v);
            let to_near = near(rule, to, self.ring.of(&corner), first);
            leave(&mut self.lattices[0], v, before, outer, to, to_near);
        }
        self.depths = 1;
    }

    #[cold]
    fn grow(&mut self) {
        self.lattices.push([self.load.zero(); 16]);
    }

    /// Goes one level finer, towards the corner: one more depth is known.
    #[inline(always)]
    pub fn descend(&mut self) {
        if self.lattices.len() == self.depths {
            self.grow();
        }
        let Corner { rule, mask, first, centres, .. } = self.corner;
        let [v, n0, n1, n2, n3, z, y, x, w, u, ..] = self.lattices[self.depths - 1];
        if rule == VertexRule::Interior && self.depths == 1 {
            let (first, second) = self.lattices.split_at_mut(1);
            leave_second(self.load, &self.corner, &first[0], &mut second[0]);
            self.depths = 2;
            return;
        }
        if rule == VertexRule::Interior && self.depths == 2 {
            self.ring.read(self.load, &self.corner);
            self.ring.step(&self.corner, centres[0]);
            self.ring.step(&self.corner, centres[1]);
        }
        let to = step_centre(rule, mask.step, v, self.ring.of(&self.corner));
        self.ring.step(&self.corner, v);
        let to_near = near(rule, to, self.ring.of(&self.corner), first);
        leave(&mut self.lattices[self.depths], v, [n0, n1, n2, n3], [z, y, x, w, u], to, to_near);
        self.depths += 1;
    }

    /// The polynomial of a quarter of the face that the step to `depth` left behind. Quarters 0 and 1
    /// are those next to the two edges, in the corner's directions; 2 is the one between, turned by half
    /// a turn: its origin is the middle of the far edge. The coordinates are the quarter's own, along the
    /// corner's directions.
    #[inline(always)]
    pub fn quarter(&self, depth: u8, quarter: u8) -> Quartic<L::Vector> {
        let lattice = &self.lattices[usize::from(depth)];
        let mut net: Net<L::Vector> = [lattice[0]; 12];
        for (point, place) in net.iter_mut().zip(NETS[usize::from(quarter)]) {
            *point = lattice[place & 15];
        }
        let mut quartic = Quartic::new(&net);
        quartic.coefficients[0] = quartic.coefficients[0] + self.corner.limit;
        quartic
    }
}
