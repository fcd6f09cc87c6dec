//! Where the points of one subdivision step are kept, in blocks: one for each vertex of a face that is
//! not regular.
//!
//! A block holds the limit of its vertex; then, relative to that limit, the vertex after one step and
//! after two, and the ring after one step. The ring's last two points stand before it again, and its
//! first three after it: any six that follow each other stand in a row, wherever in the ring they
//! begin. So much is read for nearly every place beside the vertex, and from one stretch of memory.

use glam::DVec3;
use prefetch_index::prefetch_index;

use super::corner::{edge_point, step_centre, weigh};
use super::limit::border_limit;
use super::patch::Load;
use super::topology::{InteriorMask, VertexRule};

/// The places in a block: of the limit, of the vertex after one step and two, of the ring.
pub(super) const LIMIT: u32 = 0;
pub(super) const FIRST: u32 = 1;
pub(super) const SECOND: u32 = 2;
pub(super) const RING: u32 = 3 + BEFORE as u32;

/// How many points of a closed ring are repeated before and after it.
const BEFORE: usize = 2;
const AFTER: usize = 3;

/// How many points the block of a vertex of `valence` has.
pub(super) const fn size(valence: u32) -> u32 {
    RING + valence + AFTER as u32
}

/// The points of all blocks, one after the other: three numbers each, and one more at the end so that
/// four can be read anywhere.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks(Vec<f64>);

impl Blocks {
    /// Room for `points` points.
    pub fn new(points: usize) -> Self {
        Self(vec![0.0; 3 * points + 1])
    }

    /// The point at `place`.
    #[inline(always)]
    pub fn point<L: Load>(&self, load: L, place: u32) -> L::Vector {
        let start = 3 * place as usize;
        point(load, &self.0[start..start + 4])
    }

    /// The ring of `valence` points of the block that begins at `block`.
    #[inline(always)]
    pub fn ring(&self, block: u32, valence: usize) -> Ring<'_> {
        let start = 3 * (block + RING) as usize - 3 * BEFORE;
        Ring(&self.0[start..start + 3 * (BEFORE + valence + AFTER) + 1])
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
        let (limit, centre) = step_around(mask, rule, q, ring, finer);
        finer.iter_mut().for_each(|p| *p -= limit);
        let first = centre - limit;
        let start = 3 * place as usize;
        let (block, _) = self.0[start..start + 3 * size(ring.len() as u32) as usize].as_chunks_mut::<3>();
        block[LIMIT as usize] = limit.to_array();
        block[FIRST as usize] = first.to_array();
        block[SECOND as usize] = step_centre(rule, mask.step, first, finer).to_array();
        let from = finer.len() - BEFORE % finer.len();
        let around = finer.iter().cycle().skip(from);
        for (place, p) in block[RING as usize - BEFORE..].iter_mut().zip(around) {
            *place = p.to_array();
        }
    }

    /// Asks memory for the block at `place` of a vertex of `valence`, without waiting for it.
    #[inline(always)]
    pub fn prefetch(&self, place: u32, valence: u32) {
        let start = 3 * place as usize;
        for line in 0..USUAL_LINES {
            prefetch_index(&self.0, start + line * LINE);
        }
        // Beyond what nearly all need; how many fewer some do is not worth a branch that cannot be foreseen.
        for line in USUAL_LINES..(3 * size(valence) as usize).div_ceil(LINE) {
            prefetch_index(&self.0, start + line * LINE);
        }
    }
}

/// How many numbers a line of the cache holds on most machines.
const LINE: usize = 8;
/// How many lines the block of a vertex of valence 6 takes.
const USUAL_LINES: usize = (3 * size(6) as usize).div_ceil(LINE);

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
        let start = 3 * (BEFORE + i);
        point(load, &self.0[start..start + 4])
    }

    /// Points `first - 2` to `first + 3` of a closed ring.
    #[inline(always)]
    pub fn window<L: Load>(self, load: L, first: usize) -> [L::Vector; 6] {
        let window: &[f64; 19] =
            self.0[3 * first..3 * first + 19].first_chunk().expect("a ring is repeated at its ends");
        let mut points = [load.zero(); 6];
        for (i, place) in points.iter_mut().enumerate() {
            *place = point(load, &window[3 * i..]);
        }
        points
    }
}

/// Writes the ring around a vertex one step finer; the limit, and the vertex one step finer.
fn step_around(
    mask: InteriorMask,
    rule: VertexRule,
    q: DVec3,
    ring: &[DVec3],
    finer: &mut Vec<DVec3>,
) -> (DVec3, DVec3) {
    let last = ring.len() - 1;
    finer.clear();
    finer.extend(ring.iter().enumerate().map(|(i, &p)| {
        let (before, after) = (if i == 0 { last } else { i - 1 }, if i == last { 0 } else { i + 1 });
        let on_border = rule != VertexRule::Interior && (i == 0 || i == last);
        if on_border { (q + p) * 0.5 } else { edge_point(q, p, ring[before], ring[after]) }
    }));
    let limit = match rule {
        VertexRule::Interior => weigh(q, ring, mask.limit),
        VertexRule::Border => border_limit(q, ring[0], ring[last]),
        VertexRule::Corner => q,
    };
    (limit, step_centre(rule, mask.step, q, ring))
}
