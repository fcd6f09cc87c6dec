//! Where the points of one subdivision step are kept, in blocks: one for each vertex of a face that is
//! not regular.
//!
//! A block holds the limit of its vertex; then, relative to that limit, the vertex after one step and two,
//! and the ring after one step. So much is read for nearly every place beside the vertex, and from one
//! stretch of memory. Where the vertex goes after that follows ([`InteriorMask::eigenvalue`]).

use glam::DVec3;
use prefetch_index::prefetch_index;

use super::corner::{edge_point, step_centre, weigh};
use super::limit::border_limit;
use super::patch::Load;
use super::topology::{InteriorMask, VertexRule};

/// The place in a block of the ring, behind the limit and the vertex after one step and two.
pub(super) const RING: u32 = 3;

/// How many points the block of a vertex of `valence` has.
pub(super) const fn size(valence: u32) -> u32 {
    RING + valence
}

/// So many numbers from a block's begin on hold all its points, unless its valence is uncommonly large, and
/// where a number below 128 says, there are always four.
pub(super) type Stretch = [f64; STRETCH];
const STRETCH: usize = 128 + 3;

/// The points of all blocks, one after the other: three numbers each, and more at the end so that four can be
/// read anywhere and a [`Stretch`] from every block's begin on.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks(Vec<f64>);

impl Blocks {
    /// Room for `points` points.
    pub fn new(points: usize) -> Self {
        Self(vec![0.0; 3 * points + STRETCH])
    }

    /// The point at `place`.
    #[inline(always)]
    pub fn point<L: Load>(&self, load: L, place: u32) -> L::Vector {
        let start = 3 * place as usize;
        point(load, &self.0[start..start + 4])
    }

    /// The numbers of the block that begins at `block` and those behind it.
    #[inline(always)]
    pub fn stretch(&self, block: u32) -> &Stretch {
        let start = 3 * block as usize;
        self.0[start..].first_chunk().expect("a stretch is behind the last block")
    }

    /// The ring of `valence` points of the block that begins at `block`.
    #[inline(always)]
    pub fn ring(&self, block: u32, valence: usize) -> Ring<'_> {
        let start = 3 * (block + RING) as usize;
        Ring(&self.0[start..start + 3 * valence + 1])
    }

    /// Writes the block at `place` of a vertex at `q` with neighbours `ring`; `finer` is scratch.
    pub fn write(
        &mut self,
        place: u32,
        mask: InteriorMask,
        rule: VertexRule,
        (q, ring): (DVec3, &[DVec3]),
        finer: &mut Vec<DVec3>,
    ) {
        let limit = match rule {
            VertexRule::Interior => weigh(q, ring, mask.limit),
            VertexRule::Border => border_limit(q, ring[0], ring[ring.len() - 1]),
            VertexRule::Corner => q,
        };
        step_ring(rule, q, ring, finer);
        finer.iter_mut().for_each(|p| *p -= limit);
        let first = step_centre(rule, mask.step, q, ring) - limit;
        let second = step_centre(rule, mask.step, first, finer);
        let start = 3 * place as usize;
        let (block, _) = self.0[start..start + 3 * size(ring.len() as u32) as usize].as_chunks_mut::<3>();
        let points = [limit, first, second].into_iter().chain(finer.iter().copied());
        for (place, p) in block.iter_mut().zip(points) {
            *place = p.to_array();
        }
    }

    /// The points at the head of the block at `place`: its limit, and the vertex after one step and two.
    #[inline(always)]
    pub fn head<L: Load>(&self, load: L, place: u32) -> [L::Vector; RING as usize] {
        let start = 3 * place as usize;
        let numbers = &self.0[start..start + 3 * RING as usize + 1];
        [point(load, &numbers[..4]), point(load, &numbers[3..7]), point(load, &numbers[6..])]
    }

    /// Asks memory for the block at `place`, without waiting for it. As much as nearly all have: how much
    /// more some do is not worth finding out.
    #[inline(always)]
    pub fn prefetch(&self, place: u32) {
        let start = 3 * place as usize;
        for line in 0..USUAL_LINES {
            prefetch_index(&self.0, start + line * LINE);
        }
    }
}

/// How many numbers a line of the cache holds on most machines.
const LINE: usize = 8;
/// How many lines the block of a vertex of valence 7 takes, which begins anywhere in a line.
const USUAL_LINES: usize = (3 * size(7) as usize).div_ceil(LINE);

/// The four numbers at `at` of a stretch.
#[inline(always)]
pub(super) fn in_stretch(stretch: &Stretch, at: u8) -> &[f64; 4] {
    // Nothing for places that there are; known here, it spares looking.
    let at = usize::from(at & 127);
    stretch[at..at + 4].first_chunk().expect("there are four numbers")
}

#[inline(always)]
fn point<L: Load>(load: L, numbers: &[f64]) -> L::Vector {
    load.load_padded(numbers.first_chunk().expect("there is a number after the last point"))
}

/// The ring in a block.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ring<'a>(&'a [f64]);

impl Ring<'_> {
    /// Point `i` of the ring.
    #[inline(always)]
    pub fn point<L: Load>(self, load: L, i: usize) -> L::Vector {
        point(load, &self.0[3 * i..3 * i + 4])
    }

    /// `N` points in a row of the closed ring of `valence`, from `before` before point `first` on; six at most,
    /// because a closed ring has at least three.
    #[inline(always)]
    pub fn window<L: Load, const N: usize>(
        self,
        load: L,
        valence: usize,
        first: usize,
        before: usize,
    ) -> [L::Vector; N] {
        // In 32 bits, of which four more numbers are known to be no more than there can be.
        let (end, mut at) = (3 * valence as u32, 3 * (first + 2 * valence - before) as u32);
        at = if at < 2 * end { at } else { at - end };
        at = if at < end { at } else { at - end };
        let mut points = [load.zero(); N];
        for place in &mut points {
            *place = point(load, &self.0[at as usize..at as usize + 4]);
            at = if at + 3 < end { at + 3 } else { 0 };
        }
        points
    }
}

/// Writes the ring around a vertex at `q` one step finer.
fn step_ring(rule: VertexRule, q: DVec3, ring: &[DVec3], finer: &mut Vec<DVec3>) {
    let last = ring.len() - 1;
    finer.clear();
    finer.extend(ring.iter().enumerate().map(|(i, &p)| {
        let (before, after) = (if i == 0 { last } else { i - 1 }, if i == last { 0 } else { i + 1 });
        let on_border = rule != VertexRule::Interior && (i == 0 || i == last);
        if on_border { (q + p) * 0.5 } else { edge_point(q, p, ring[before], ring[after]) }
    }));
}
