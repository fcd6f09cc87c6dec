//! The bands of a face around one of its corners, each a polynomial and a bend.
//!
//! Every step towards a corner leaves a band of the face behind: the three quarters that do not touch the
//! corner. Its control points are those that subdivision makes of a regular net of the level before, but
//! for one: the corner's own next point, which only a vertex of valence 6 has where such a net says. So
//! over the whole band the surface is the polynomial of that net, and the difference of the one point
//! times what the point weighs there ([`Found`](super::place::Found)).

use super::corner::{Around, Corner, Neighbours, edge_point, near, next, reflect, regular_vertex, step_centre};
use super::patch::Load;
use super::topology::VertexRule;
use crate::subdivision::boxspline::{Net, Quartic, Vector};

/// A piece of a face: a polynomial, and what its corner's point exceeds that of a regular vertex by.
///
/// Aligned so that few vectors in it, of four lanes each, lie across lines of the cache.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Band<V> {
    quartic: Quartic<V>,
    excess: V,
}

impl<V: Vector> Band<V> {
    /// A piece that is a polynomial alone. Nothing changes any number by being added to it but the zero
    /// below zero.
    #[inline(always)]
    pub fn plain(load: impl Load<Vector = V>, quartic: Quartic<V>) -> Self {
        Self { quartic, excess: load.load(glam::DVec3::splat(-0.0)) }
    }

    /// The point and its derivatives by `s` and `t` at `(s, t)`, where `weights` are those of the excess.
    #[inline(always)]
    pub fn with_derivatives(&self, s: f64, t: f64, weights: [f64; 3]) -> [V; 3] {
        let [position, ds, dt] = self.quartic.with_derivatives(s, t);
        [position + self.excess * weights[0], ds + self.excess * weights[1], dt + self.excess * weights[2]]
    }
}

impl Band<glam::DVec3> {
    /// The same for `load` to calculate with.
    #[inline(always)]
    pub(super) fn load<L: Load>(self, load: L) -> Band<L::Vector> {
        let coefficients = load.load_all(self.quartic.coefficients);
        Band { quartic: Quartic { coefficients }, excess: load.load(self.excess) }
    }
}

/// Control points of one level around a corner.
#[derive(Clone, Copy, Debug)]
struct Level<V> {
    /// Those of a regular face whose first corner is the corner.
    net: Net<V>,
    /// The corner at the next level.
    to: V,
}

/// The net of a face whose corner `corner` is the first of `net`.
#[inline(always)]
fn turned<V>([a, b, c, ab, bc, ca, a1, a2, b1, b2, c1, c2]: Net<V>, corner: usize) -> Net<V> {
    match corner {
        0 => [a, b, c, ab, bc, ca, a1, a2, b1, b2, c1, c2],
        1 => [c, a, b, ca, ab, bc, c1, c2, a1, a2, b1, b2],
        _ => [b, c, a, bc, ca, ab, b1, b2, c1, c2, a1, a2],
    }
}

impl<V: Vector> Level<V> {
    /// The level whose ring around the corner has `[fifth, before, r0, r1, after, fourth]` in a row.
    #[inline(always)]
    fn new([v, to]: [V; 2], [fifth, before, r0, r1, after, fourth]: [V; 6], [z, y, x, w, u]: [V; 5]) -> Self {
        Self { net: [v, r0, r1, before, x, after, fourth, fifth, z, y, w, u], to }
    }

    /// The first level around an interior corner.
    #[inline(always)]
    fn first(Around { centres: [v, to], ring, outer, .. }: Around<V, 6>) -> Self {
        Self::new([v, to], ring, outer)
    }

    /// The second level there, of which most of the ring is of no use.
    #[inline(always)]
    fn second(Around { centres, eigenvalue, ring: [a, r @ .., h], outer, .. }: Around<V, 8>) -> Self {
        let ends = outer_points(centres[0], [a, r[0], r[1]], [r[4], r[5], h]);
        Self::new(centres, r, outer).finer(ends, next(centres, eigenvalue))
    }

    /// The third.
    #[inline(always)]
    fn third(around: Around<V, 10>) -> Self {
        let Around { limit, centres: [v, to], eigenvalue, ring: [a, r @ .., j], outer } = around;
        let second = Self::second(Around { limit, centres: [v, to], eigenvalue, ring: r, outer });
        let [a, j] = outer_points(v, [a, r[0], r[1]], [r[6], r[7], j]);
        let [.., before, _, after, fourth, fifth, _, _, _, _] = second.net;
        let ends = outer_points(to, [a, fifth, before], [after, fourth, j]);
        second.finer(ends, next([to, second.to], eigenvalue))
    }

    /// The next level, in which the ring goes on to `ends` and the corner goes to `to`.
    #[inline(always)]
    fn finer(&self, [fifth, fourth]: [V; 2], to: V) -> Self {
        let around = self.finer_ring();
        let [v, r0, r1, before, x, after, .., z, y, w, u] = self.net;
        let outer = [
            edge_point(before, r0, v, z),
            regular_vertex(r0, [v, r1, x, y, z, before]),
            edge_point(r0, r1, v, x),
            regular_vertex(r1, [v, after, u, w, x, r0]),
            edge_point(r1, after, v, u),
        ];
        Self::new([self.to, to], [fifth, around[0], around[1], around[2], around[3], fourth], outer)
    }

    /// The points of the next level's ring around the face.
    #[inline(always)]
    fn finer_ring(&self) -> [V; 4] {
        let [v, r0, r1, before, _, after, fourth, fifth, ..] = self.net;
        [
            edge_point(v, before, fifth, r0),
            edge_point(v, r0, before, r1),
            edge_point(v, r1, r0, after),
            edge_point(v, after, r1, fourth),
        ]
    }

    /// The band that the step to the next level leaves behind, along the face whose corner `corner` this is.
    #[inline(always)]
    fn band(&self, limit: V, corner: usize) -> Band<V> {
        let [v, r0, r1, before, _, after, fourth, fifth, ..] = self.net;
        let excess = self.to - regular_vertex(v, [r0, r1, after, fourth, fifth, before]);
        let mut quartic = Quartic::new(&turned(self.net, corner));
        quartic.coefficients[0] = quartic.coefficients[0] + limit;
        Band { quartic, excess }
    }
}

/// What a step makes of the middle ones of three points in a row of the ring around `v`, and of three others.
#[inline(always)]
fn outer_points<V: Vector>(v: V, [a, b, c]: [V; 3], [d, e, f]: [V; 3]) -> [V; 2] {
    [edge_point(v, b, a, c), edge_point(v, e, d, f)]
}

/// The first band around an interior corner, which is the face's `i`-th.
#[inline(always)]
pub(super) fn first_band<V: Vector>(around: Around<V, 6>, i: usize) -> Band<V> {
    Level::first(around).band(around.limit, i)
}

/// The second band around an interior corner, which is the face's `i`-th.
#[inline(always)]
pub(super) fn second_band<V: Vector>(around: Around<V, 8>, i: usize) -> Band<V> {
    Level::second(around).band(around.limit, i)
}

/// The third band around an interior corner, which is the face's `i`-th.
#[inline(always)]
pub(super) fn third_band<V: Vector>(around: Around<V, 10>, i: usize) -> Band<V> {
    Level::third(around).band(around.limit, i)
}

/// The points of the ring before and after `near`, which are those around the face. Beyond a border they
/// are the phantoms that let the rule of an inner edge give its midpoint and those of the next level.
#[inline(always)]
fn ends<V: Vector>(
    rule: VertexRule,
    [v, to]: [V; 2],
    ring: &[V],
    first: usize,
    [before, r0, r1, after]: [V; 4],
) -> [V; 2] {
    let k = ring.len();
    if rule == VertexRule::Interior {
        return [
            ring[if first < 2 { first + k - 2 } else { first - 2 }],
            ring[if first + 3 < k { first + 3 } else { first + 3 - k }],
        ];
    }
    let fifth = match first {
        // Where the phantom beside the border is that of the next level again, whose corner is `to`.
        0 => to * 8.0 - v * 5.0 - r0 - after,
        1 => reflect(v, before, r0),
        _ => ring[first - 2],
    };
    let fourth = match k - first {
        2 => to * 8.0 - v * 5.0 - r1 - before,
        3 => reflect(v, after, r1),
        _ => ring[first + 3],
    };
    [fifth, fourth]
}

/// The bands of a face around one of its corners, as far as they are known.
#[derive(Clone, Debug)]
pub struct Bands<'a, L: Load> {
    load: L,
    corner: Corner<'a, L::Vector>,
    /// The corner's neighbours at the finest level so far; of no meaning where no level but the first three
    /// was needed.
    ring: Neighbours<L::Vector>,
    /// The first `depths` count.
    levels: Vec<Level<L::Vector>>,
    depths: usize,
}

impl<'a, L: Load> Bands<'a, L> {
    /// Of no corner yet.
    pub(super) fn new(load: L) -> Self {
        let corner = Corner::none(load);
        Self { load, corner, ring: Neighbours::none(), levels: Vec::new(), depths: 0 }
    }

    /// How many bands are known; 0 of no corner.
    #[inline(always)]
    pub fn depths(&self) -> usize {
        self.depths
    }

    /// Makes them those around `corner`, of which the first is known then.
    #[inline(always)]
    pub(super) fn begin(&mut self, corner: Corner<'a, L::Vector>) {
        self.corner = corner;
        let Corner { rule, first, centres: [v, to], outer, .. } = corner;
        let level = if rule == VertexRule::Interior {
            Level::first(corner.around(self.load))
        } else {
            self.ring.read(self.load, &corner);
            let ring = self.ring.of(&corner);
            let around = near(rule, v, ring, first);
            let [fifth, fourth] = ends(rule, [v, to], ring, first, around);
            Level::new([v, to], [fifth, around[0], around[1], around[2], around[3], fourth], outer)
        };
        self.depths = 0;
        self.push(level);
    }

    #[inline(always)]
    fn push(&mut self, level: Level<L::Vector>) {
        match self.levels.get_mut(self.depths) {
            Some(place) => *place = level,
            None => self.levels.push(level),
        }
        self.depths += 1;
    }

    /// Goes one level finer, towards the corner: one more band is known.
    #[inline(always)]
    pub fn descend(&mut self) {
        let Corner { rule, mask, first, centres, .. } = self.corner;
        if rule == VertexRule::Interior {
            match self.depths {
                1 => return self.push(Level::second(self.corner.around(self.load))),
                2 => return self.push(Level::third(self.corner.around(self.load))),
                3 => {
                    self.ring.read(self.load, &self.corner);
                    self.ring.step(&self.corner, centres[0]);
                    self.ring.step(&self.corner, centres[1]);
                }
                _ => {}
            }
        }
        let before = self.levels[self.depths - 1];
        self.ring.step(&self.corner, before.net[0]);
        let (v, ring) = (before.to, self.ring.of(&self.corner));
        let to = step_centre(rule, mask.step, v, ring);
        let ends = ends(rule, [v, to], ring, first, before.finer_ring());
        self.push(before.finer(ends, to));
    }

    /// The band that the step after `depth` others leaves behind, in coordinates of all that is left around
    /// the corner before it, which run along those of the face whose corner `corner` this is.
    #[inline(always)]
    pub fn band(&self, depth: u8, corner: u8) -> Band<L::Vector> {
        self.levels[usize::from(depth)].band(self.corner.limit, usize::from(corner))
    }
}
