//! Evaluates a block of places on many faces: what they need is made kind by kind, then all are evaluated.
//!
//! With few places to a face nearly each needs a polynomial of its own, of a kind that cannot be foreseen.
//! So the kinds are brought together first, without a branch, and each is made in a loop of its own: what
//! the machine has to guess is then the end of a loop.

use selvedge_components::mesh::FaceId;
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
    Vertex,
    Deeper,
    /// The first band around corner 0, 1 or 2: each has a loop of its own, in which nothing depends on it.
    First,
    /// The second.
    Second = Kind::First as isize + 3,
}

const KINDS: usize = Kind::Second as usize + 3;

/// Pieces in all.
const PIECES: usize = 4 * (DEEPEST as usize + 1);

/// The kind of each piece, by its index.
const KIND: [u8; PIECES] = {
    let mut kinds = [0; PIECES];
    let mut i = 0;
    while i < PIECES {
        let piece = Piece::from_index(i);
        kinds[i] = if i == Piece::WHOLE.index() {
            Kind::Whole as u8
        } else if i == Piece::MIDDLE.index() {
            Kind::Middle as u8
        } else if piece.depth() == DEEPEST {
            Kind::Vertex as u8
        } else if piece.depth() == 0 {
            Kind::First as u8 + piece.corner()
        } else if piece.depth() == 1 {
            Kind::Second as u8 + piece.corner()
        } else {
            Kind::Deeper as u8
        };
        i += 1;
    }
    kinds
};

/// What was seen where, and when: stamps of earlier blocks are smaller.
#[derive(Clone, Copy, Default)]
struct Seen {
    stamp: u64,
    slot: u8,
}

/// Numbers of up to [`BLOCK`] things.
#[derive(Clone, Copy)]
struct List {
    numbers: [u8; BLOCK],
    count: usize,
}

impl List {
    const EMPTY: Self = Self { numbers: [0; BLOCK], count: 0 };

    #[inline(always)]
    fn push(&mut self, number: usize) {
        self.numbers[self.count % BLOCK] = number as u8;
        self.count += 1;
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.numbers[..self.count].iter().map(|&n| usize::from(n))
    }
}

/// Scratch for blocks of places on many faces.
pub(super) struct Spread<'a, L: Store> {
    reader: PatchReader<'a, L>,
    /// By the index of a piece, where it was made last.
    pieces: Vec<Seen>,
    /// By slot.
    bands: Vec<Band<L::Vector>>,
    /// By place, the slot of its piece.
    slots: [u8; BLOCK],
    scratch: Bands<'a, L>,
    /// Beyond all stamps so far.
    stamp: u64,
}

/// The pieces of a block, each with a place that lies there.
struct Wanted<'a, P> {
    block: &'a Block,
    places: &'a [P],
    owners: [u8; BLOCK],
}

impl<P: Located> Wanted<'_, P> {
    #[inline(always)]
    fn face(&self, slot: usize) -> FaceId {
        self.places[usize::from(self.owners[slot])].face()
    }

    #[inline(always)]
    fn piece(&self, slot: usize) -> Piece {
        Piece::from_index(self.block.piece[usize::from(self.owners[slot])] as usize)
    }
}

impl<'a, L: Store> Spread<'a, L> {
    pub fn new(reader: PatchReader<'a, L>, store: L) -> Self {
        let none = reader.plain(Quartic { coefficients: [store.zero(); 14] });
        Self {
            reader,
            pieces: vec![Seen::default(); PIECES],
            bands: vec![none; BLOCK],
            slots: [0; BLOCK],
            scratch: reader.no_bands(),
            stamp: 1,
        }
    }

    /// The piece in which the `i`-th place of the block lies that was made last.
    #[inline(always)]
    pub fn band(&self, i: usize) -> &Band<L::Vector> {
        &self.bands[usize::from(self.slots[i % BLOCK]) % BLOCK]
    }

    /// Makes all pieces in which places of the block lie, each once.
    #[inline(always)]
    pub fn make<P: Located>(&mut self, block: &Block, places: &[P], mut ahead: Ahead<'_, P>) {
        let (owners, count) = self.find(block, places.len());
        let wanted = Wanted { block, places, owners };
        let mut kinds = [List::EMPTY; KINDS];
        for slot in 0..count {
            kinds[usize::from(KIND[wanted.piece(slot).index() % PIECES])].push(slot);
        }
        for slot in kinds[Kind::Whole as usize].iter() {
            ahead.step(&self.reader);
            self.bands[slot] = self.reader.plain(self.reader.whole(wanted.face(slot)));
        }
        for slot in kinds[Kind::Middle as usize].iter() {
            ahead.step(&self.reader);
            self.bands[slot] = self.reader.plain(self.reader.middle(wanted.face(slot)));
        }
        for slot in kinds[Kind::Vertex as usize].iter() {
            ahead.step(&self.reader);
            let quartic = self.reader.tangent_plane(wanted.face(slot), wanted.piece(slot).corner());
            self.bands[slot] = self.reader.plain(quartic);
        }
        let (others, corners) = kinds.split_at_mut(Kind::First as usize);
        let deeper = &mut others[Kind::Deeper as usize];
        self.around::<P, 0>(&wanted, corners, deeper, &mut ahead);
        self.around::<P, 1>(&wanted, corners, deeper, &mut ahead);
        self.around::<P, 2>(&wanted, corners, deeper, &mut ahead);
        for slot in deeper.iter() {
            ahead.step(&self.reader);
            let piece = wanted.piece(slot);
            self.reader.begin(wanted.face(slot), piece.corner(), &mut self.scratch);
            for _ in 0..piece.depth() {
                self.scratch.descend();
            }
            self.bands[slot] = self.scratch.band(piece.depth(), piece.corner());
        }
        ahead.finish(&self.reader);
    }

    /// Makes the first two bands around the corners `CORNER`; those on borders are left to `deeper`.
    #[inline(always)]
    fn around<P: Located, const CORNER: usize>(
        &mut self,
        wanted: &Wanted<'_, P>,
        corners: &[List],
        deeper: &mut List,
        ahead: &mut Ahead<'_, P>,
    ) {
        for slot in corners[CORNER].iter() {
            ahead.step(&self.reader);
            match self.reader.first_band(wanted.face(slot), CORNER) {
                Some(band) => self.bands[slot] = band,
                None => deeper.push(slot),
            }
        }
        for slot in corners[3 + CORNER].iter() {
            ahead.step(&self.reader);
            match self.reader.second_band(wanted.face(slot), CORNER) {
                Some(band) => self.bands[slot] = band,
                None => deeper.push(slot),
            }
        }
    }

    /// Gives each piece of each face a slot, and each place its piece's; returns for each slot a place that
    /// lies there, and how many there are.
    #[inline(always)]
    fn find(&mut self, block: &Block, places: usize) -> ([u8; BLOCK], usize) {
        let (mut owners, mut count) = ([0; BLOCK], 0);
        for i in 0..places.min(BLOCK) {
            let stamp = self.stamp + u64::from(block.run[i]);
            let before = &mut self.pieces[block.piece[i] as usize];
            let is_new = before.stamp != stamp;
            let slot = if is_new { count as u8 } else { before.slot };
            *before = Seen { stamp, slot };
            self.slots[i] = slot;
            // Written over until the next one is new.
            owners[count % BLOCK] = i as u8;
            count += usize::from(is_new);
        }
        self.stamp += BLOCK as u64;
        (owners, count)
    }
}
