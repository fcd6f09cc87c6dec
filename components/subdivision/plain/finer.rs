//! The control points around a face that is not regular, one step finer.

use super::band::{Band, first_band, second_band, third_band};
use super::block::{Blocks, RING, Stretch, in_stretch};
use super::corner::{Around, Corner, reflect};
use super::patch::Load;
use super::topology::{FinerCorner, InteriorMask, PlainTopology, USUAL_MASKS};
use crate::subdivision::boxspline::{Net, Quartic, Vector};

/// The finer points around the three corners of a face, each relative to the limit of its corner.
pub(super) trait FinerPoints<V: Vector> {
    /// The limit of corner `i`; and the vertex there after one step and two.
    fn head(&self, i: usize) -> [V; RING as usize];

    /// The point of corner `i`'s ring that stands `after` places after the one on the edge to the next corner,
    /// from -1 on to 2; `None` beyond a border.
    fn ring(&self, i: usize, after: i32) -> Option<V>;

    /// The midpoint of the edge from corner `i` to the next.
    fn edge(&self, i: usize) -> V;

    /// The control points of the middle quarter. Its coordinates are turned by half a turn.
    #[inline(always)]
    fn middle_net(&self) -> Net<V> {
        let [[la, a, ..], [lb, b, ..], [lc, c, ..]] = [self.head(0), self.head(1), self.head(2)];
        let [a, b, c] = [a + la, b + lb, c + lc];
        let [ab, bc, ca] = [self.edge(0) + la, self.edge(1) + lb, self.edge(2) + lc];
        let [a3, b3] = self.beside(0, ab, (a, la, ca), (b, lb, bc));
        let [b1, c1] = self.beside(1, bc, (b, lb, ab), (c, lc, ca));
        let [c2, a2] = self.beside(2, ca, (c, lc, bc), (a, la, ab));
        [bc, ca, ab, c, a, b, b1, c1, c2, a2, a3, b3]
    }

    /// The midpoints of the two edges of the face across edge `i`, from its far corner to corner `i`
    /// and to the next. `mid` is the midpoint of edge `i`; `from` and `to` are its ends, each with
    /// its limit and the midpoint of the face's edge that goes on from there.
    #[inline(always)]
    fn beside(&self, i: usize, mid: V, from: (V, V, V), to: (V, V, V)) -> [V; 2] {
        match (self.ring(i, -1), self.ring((i + 1) % 3, 2)) {
            (Some(after), Some(before)) => [after + from.1, before + to.1],
            _ => [reflect(mid, from.0, from.2), reflect(mid, to.0, to.2)],
        }
    }

    /// The points around corner `i` that are not of its ring, as [`Around`] lists them.
    #[inline(always)]
    fn outer(&self, i: usize) -> [V; 5] {
        let (next, last) = ((i + 1) % 3, (i + 2) % 3);
        let [limit, ..] = self.head(i);
        let ([at_next, y, ..], [at_last, w, ..]) = (self.head(next), self.head(last));
        // From the other corners' limits to this one's.
        let (of_next, of_last) = (at_next - limit, at_last - limit);
        let (x, y, w) = (self.edge(next) + of_next, y + of_next, w + of_last);
        let z = match self.ring(next, 2) {
            Some(before) => before + of_next,
            None => reflect(self.edge(i), y, x),
        };
        let u = match self.ring(last, -1) {
            Some(after) => after + of_last,
            // The corner's second edge is the face's last.
            None => reflect(self.edge(last) + of_last, w, x),
        };
        [z, y, x, w, u]
    }
}

/// The points around any face.
pub(super) struct AnyFace<'a, L> {
    pub load: L,
    pub topology: &'a PlainTopology,
    pub blocks: &'a Blocks,
    pub corners: &'a [FinerCorner; 3],
}

impl<L: Load> FinerPoints<L::Vector> for AnyFace<'_, L> {
    #[inline(always)]
    fn head(&self, i: usize) -> [L::Vector; RING as usize] {
        self.blocks.head(self.load, self.corners[i].block)
    }

    #[inline(always)]
    fn ring(&self, i: usize, after: i32) -> Option<L::Vector> {
        Some(self.blocks.point(self.load, self.corners[i].ring_point(after)?))
    }

    #[inline(always)]
    fn edge(&self, i: usize) -> L::Vector {
        self.blocks.point(self.load, self.corners[i].block + RING + self.corners[i].first)
    }
}

impl<'a, L: Load> AnyFace<'a, L> {
    /// Corner `i`.
    #[inline(always)]
    pub fn corner(&self, i: usize) -> Corner<'a, L::Vector> {
        let of_corner = self.corners[i];
        let valence = of_corner.valence() as usize;
        let [limit, first, second] = self.head(i);
        Corner {
            rule: of_corner.rule(),
            valence,
            mask: self.topology.mask(valence),
            first: of_corner.first as usize,
            limit,
            centres: [first, second],
            ring: self.blocks.ring(of_corner.block, valence),
            outer: self.outer(i),
        }
    }
}

/// Usual valences are below: with the largest a block has 34 points.
const ROWS: usize = USUAL_MASKS;
/// Points of a ring that a face is made of, or may be, and the place among them of the one on the face's edge
/// to the next corner.
const NEAR: usize = 10;
const FIRST: usize = 4;

/// By valence and by the place in the ring of a face's first point: where in a block the numbers of the points
/// begin that are near the face.
static NEAR_IN_RING: [[[u8; NEAR]; ROWS]; ROWS] = {
    let mut table = [[[0; NEAR]; ROWS]; ROWS];
    let mut valence = 3;
    while valence < ROWS {
        let mut first = 0;
        while first < valence {
            let mut i = 0;
            while i < NEAR {
                let at = (first + 2 * valence + i - FIRST) % valence;
                table[valence][first][i] = 3 * (RING as usize + at) as u8;
                i += 1;
            }
            first += 1;
        }
        valence += 1;
    }
    table
};

/// The places of the points near a face, in a block of usual valence.
#[inline(always)]
fn near(corner: FinerCorner) -> &'static [u8; NEAR] {
    &NEAR_IN_RING[corner.valence() as usize % ROWS][corner.first as usize % ROWS]
}

/// The points around nearly every face: one whose corners are inside and of usual valence.
///
/// What is read stands in stretches of one length at places that a table says: no index has to be looked at.
#[derive(Clone, Copy, Debug)]
pub struct UsualFace<'a, L> {
    load: L,
    masks: &'a [InteriorMask; ROWS],
    corners: &'a [FinerCorner; 3],
    blocks: [&'a Stretch; 3],
    near: [&'static [u8; NEAR]; 3],
}

impl<'a, L: Load> UsualFace<'a, L> {
    /// The points around the face with these corners; `None` of one that is not usual.
    #[inline(always)]
    pub(super) fn new(
        load: L,
        topology: &'a PlainTopology,
        blocks: &'a Blocks,
        corners: &'a [FinerCorner; 3],
    ) -> Option<Self> {
        if !FinerCorner::are_interior_below(corners, ROWS as u32) {
            return None;
        }
        let [a, b, c] = *corners;
        let blocks = [blocks.stretch(a.block), blocks.stretch(b.block), blocks.stretch(c.block)];
        Some(Self { load, masks: topology.usual_masks(), corners, blocks, near: [near(a), near(b), near(c)] })
    }

    /// The point of block `i` whose numbers begin at `at`.
    #[inline(always)]
    fn point(&self, i: usize, at: u8) -> L::Vector {
        self.load.load_padded(in_stretch(self.blocks[i], at))
    }

    /// As [`PatchReader::middle`](super::PatchReader::middle).
    #[inline(always)]
    pub fn middle(&self) -> Quartic<L::Vector> {
        Quartic::new(&self.middle_net())
    }

    /// As [`PatchReader::first_band`](super::PatchReader::first_band).
    #[inline(always)]
    pub fn first_band(&self, corner: usize) -> Band<L::Vector> {
        first_band(self.around(corner), corner)
    }

    /// As [`PatchReader::second_band`](super::PatchReader::second_band).
    #[inline(always)]
    pub fn second_band(&self, corner: usize) -> Band<L::Vector> {
        second_band(self.around(corner), corner)
    }

    /// As [`PatchReader::third_band`](super::PatchReader::third_band).
    #[inline(always)]
    pub fn third_band(&self, corner: usize) -> Band<L::Vector> {
        third_band(self.around(corner), corner)
    }

    /// The points around corner `i`.
    #[inline(always)]
    fn around<const N: usize>(&self, i: usize) -> Around<L::Vector, N> {
        let [limit, first, second] = self.head(i);
        let mut ring = [limit; N];
        for (place, point) in ring.iter_mut().enumerate() {
            *point = self.point(i, self.near[i][FIRST + 1 - N / 2 + place]);
        }
        let eigenvalue = self.masks[self.corners[i].valence() as usize % ROWS].eigenvalue;
        Around { limit, centres: [first, second], eigenvalue, ring, outer: self.outer(i) }
    }
}

impl<L: Load> FinerPoints<L::Vector> for UsualFace<'_, L> {
    #[inline(always)]
    fn head(&self, i: usize) -> [L::Vector; RING as usize] {
        [self.point(i, 0), self.point(i, 3), self.point(i, 6)]
    }

    #[inline(always)]
    fn ring(&self, i: usize, after: i32) -> Option<L::Vector> {
        Some(self.point(i, self.near[i][(FIRST as i32 + after) as usize]))
    }

    #[inline(always)]
    fn edge(&self, i: usize) -> L::Vector {
        self.point(i, self.near[i][FIRST])
    }
}
