//! Evaluates a block of places on many faces: what they need is made kind by kind, then all are evaluated.
//!
//! With few places to a face nearly each needs a polynomial of its own, of a kind that cannot be foreseen.
//! So the kinds are brought together first, without a branch, and each is made in a loop of its own: what
//! the machine has to guess is then the end of a loop.

use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::plain::place::DEEPEST;
use selvedge_components::subdivision::plain::{Band, Bands, PatchReader, Piece};

use super::super::lanes::Store;
use super::worker::{Ahead, BLOCK, Block, Located};

/// How a piece is made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Whole,
    Middle,
    /// The first band around corner 0, 1 or 2: each has a loop of its own, in which nothing depends on it.
    First,
    /// The second, and the third.
    Second = Kind::First as isize + 3,
    Third = Kind::Second as isize + 3,
    /// All others.
    Rest = Kind::Third as isize + 3,
}

const KINDS: usize = Kind::Rest as usize + 1;

/// Pieces in all, and some more: a number below a power of two is known to be one of them.
const PIECES: usize = (4 * (DEEPEST as usize + 1)).next_power_of_two();

/// The kind of each piece, by its index.
static KIND: [u8; PIECES] = {
    let mut kinds = [Kind::Rest as u8; PIECES];
    kinds[Piece::WHOLE.index()] = Kind::Whole as u8;
    kinds[Piece::MIDDLE.index()] = Kind::Middle as u8;
    let mut corner = 0;
    while corner < 3 {
        kinds[Piece::new(corner, 0).index()] = Kind::First as u8 + corner;
        kinds[Piece::new(corner, 1).index()] = Kind::Second as u8 + corner;
        kinds[Piece::new(corner, 2).index()] = Kind::Third as u8 + corner;
        corner += 1;
    }
    kinds
};

/// Up to [`BLOCK`] places of a block.
#[derive(Clone, Copy)]
struct List {
    places: [u8; BLOCK],
    count: usize,
}

impl List {
    const EMPTY: Self = Self { places: [0; BLOCK], count: 0 };

    /// Adds a place; written over by the next one unless it `counts`.
    #[inline(always)]
    fn push(&mut self, place: usize, counts: bool) {
        self.places[self.count % BLOCK] = place as u8;
        self.count += usize::from(counts);
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.places[..self.count].iter().map(|&place| usize::from(place) % BLOCK)
    }
}

/// Scratch for blocks of places on many faces.
pub(super) struct Spread<'a, L: Store> {
    reader: PatchReader<'a, L>,
    /// By the index of a piece, the stamp of the run of places in which it was seen last, and the first place
    /// there.
    seen: Vec<u64>,
    /// By the first place of a run that lies in it.
    bands: Vec<Band<L::Vector>>,
    /// By place, the first one that lies in the same piece.
    firsts: [u8; BLOCK],
    kinds: [List; KINDS],
    scratch: Bands<'a, L>,
    /// Beyond all stamps so far.
    stamp: u64,
}

impl<'a, L: Store> Spread<'a, L> {
    pub fn new(reader: PatchReader<'a, L>, store: L) -> Self {
        let none = reader.plain(Quartic { coefficients: [store.zero(); 14] });
        Self {
            reader,
            seen: vec![0; PIECES],
            bands: vec![none; BLOCK],
            firsts: [0; BLOCK],
            kinds: [List::EMPTY; KINDS],
            scratch: reader.no_bands(),
            stamp: 1,
        }
    }

    /// The piece in which the `i`-th place of the block lies that was made last.
    #[inline(always)]
    pub fn band(&self, i: usize) -> &Band<L::Vector> {
        &self.bands[usize::from(self.firsts[i % BLOCK]) % BLOCK]
    }

    /// Makes all pieces in which places of the block lie, each once.
    #[inline(always)]
    pub fn make<P: Located>(&mut self, block: &Block<'a, L>, places: &[P], mut ahead: Ahead<'_, P>) {
        self.find(block, places.len());
        let Self { reader, bands, kinds, scratch, .. } = self;
        let bands: &mut [Band<L::Vector>; BLOCK] = bands.first_chunk_mut().expect("there are so many");
        let [kinds @ .., rest] = kinds;
        for i in kinds[Kind::Whole as usize].iter() {
            ahead.step(reader);
            bands[i] = reader.plain(reader.whole(places[i].face()));
        }
        for i in kinds[Kind::Middle as usize].iter() {
            ahead.step(reader);
            match block.around(i) {
                Some(face) => bands[i] = reader.plain(face.middle()),
                None => rest.push(i, true),
            }
        }
        // No functions with a piece's name as an argument: closures are not compiled for the machine's lanes.
        macro_rules! make {
            ($kind:expr, $band:ident, $corner:literal) => {
                for i in kinds[$kind as usize + $corner].iter() {
                    ahead.step(reader);
                    match block.around(i) {
                        Some(face) => bands[i] = face.$band($corner),
                        None => rest.push(i, true),
                    }
                }
            };
        }
        macro_rules! around {
            ($corner:literal) => {
                make!(Kind::First, first_band, $corner);
                make!(Kind::Second, second_band, $corner);
                make!(Kind::Third, third_band, $corner);
            };
        }
        around!(0);
        around!(1);
        around!(2);
        for i in rest.iter() {
            ahead.step(reader);
            bands[i] = reader.band(places[i].face(), Piece::from_index(block.piece[i] as usize), scratch);
        }
        while ahead.step(reader) {}
    }

    /// Finds the first place in each piece of each run, and brings these together by kinds.
    #[inline(always)]
    fn find(&mut self, block: &Block<'a, L>, places: usize) {
        for kind in &mut self.kinds {
            kind.count = 0;
        }
        let seen: &mut [u64; PIECES] = self.seen.first_chunk_mut().expect("there are so many");
        for i in 0..places.min(BLOCK) {
            let stamp = (self.stamp + u64::from(block.run[i])) * BLOCK as u64;
            let piece = block.piece[i] as usize % PIECES;
            let before = seen[piece];
            let is_new = before < stamp;
            let now = if is_new { stamp + i as u64 } else { before };
            seen[piece] = now;
            self.firsts[i] = (now % BLOCK as u64) as u8;
            self.kinds[usize::from(KIND[piece])].push(i, is_new);
        }
        self.stamp += BLOCK as u64;
    }
}
