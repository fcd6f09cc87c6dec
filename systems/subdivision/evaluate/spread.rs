//! Evaluates a block of places on many faces: what they need is made kind by kind, then all are evaluated.
//!
//! With few places to a face nearly each needs a polynomial of its own, of a kind that cannot be foreseen.
//! So the kinds are brought together first, without a branch, and each is made in a loop of its own: what
//! the machine has to guess is then the end of a loop.

use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::plain::place::DEEPEST;
use selvedge_components::subdivision::plain::{CornerPieces, PatchReader, Piece, StepPieces};

use super::super::lanes::Store;
use super::worker::{Ahead, BLOCK, Block, Located};

/// How a piece is made.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Whole,
    Middle,
    RegularCorner,
    /// Of the first depth.
    First,
    /// Of the second.
    Second,
    Deeper,
    Vertex,
}

const KINDS: usize = 7;

/// Pieces in all.
const PIECES: usize = 16 * (DEEPEST as usize + 1);

/// The kind of each piece, by its index.
const KIND: [u8; PIECES] = {
    let mut kinds = [0; PIECES];
    let mut i = 0;
    while i < PIECES {
        let piece = Piece::from_index(i);
        let kind = if i == Piece::WHOLE.index() {
            Kind::Whole
        } else if i == Piece::MIDDLE.index() {
            Kind::Middle
        } else if piece.quarter() == 3 {
            Kind::RegularCorner
        } else if piece.depth() == DEEPEST {
            Kind::Vertex
        } else if piece.depth() == 0 {
            Kind::First
        } else if piece.depth() == 1 {
            Kind::Second
        } else {
            Kind::Deeper
        };
        kinds[i] = kind as u8;
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

/// The corners that the pieces in `slots` lie at: quarters of one corner share what they are made of.
/// Returns for each corner a slot that is at it, and by slot its corner.
#[inline(always)]
fn find_corners(block: &Block, owners: &[u8; BLOCK], slots: impl Iterator<Item = usize>) -> (List, [u8; BLOCK]) {
    let (mut corners, mut corner_of) = (List::EMPTY, [0_u8; BLOCK]);
    // By face and corner, counted from one.
    let mut seen = [0_u8; 4 * BLOCK];
    for slot in slots {
        let place = usize::from(owners[slot]);
        let corner = Piece::from_index(block.piece[place] as usize).corner();
        let before = &mut seen[(4 * usize::from(block.run[place]) + usize::from(corner & 3)) % (4 * BLOCK)];
        let is_new = *before == 0;
        *before = if is_new { corners.count as u8 + 1 } else { *before };
        corner_of[slot] = *before - 1;
        // Written over until the next one is new.
        corners.numbers[corners.count % BLOCK] = slot as u8;
        corners.count += usize::from(is_new);
    }
    (corners, corner_of)
}

/// Scratch for blocks of places on many faces.
pub(super) struct Spread<'a, L: Store> {
    reader: PatchReader<'a, L>,
    /// By the index of a piece, the polynomial that was made for it last.
    pieces: Vec<Seen>,
    /// By slot.
    quartics: Vec<Quartic<L::Vector>>,
    corners: Vec<StepPieces<L::Vector>>,
    second: StepPieces<L::Vector>,
    /// By place, the slot of its polynomial.
    slots: [u8; BLOCK],
    scratch: CornerPieces<'a, L>,
    /// Beyond all stamps so far.
    stamp: u64,
}

impl<'a, L: Store> Spread<'a, L> {
    pub fn new(reader: PatchReader<'a, L>, store: L) -> Self {
        Self {
            reader,
            pieces: vec![Seen::default(); PIECES],
            quartics: vec![Quartic { coefficients: [store.zero(); 14] }; BLOCK],
            corners: vec![reader.no_step_pieces(); BLOCK],
            second: reader.no_step_pieces(),
            slots: [0; BLOCK],
            scratch: reader.scratch(),
            stamp: 1,
        }
    }

    /// The polynomial in which the `i`-th place of the block lies that was made last.
    #[inline(always)]
    pub fn quartic(&self, i: usize) -> &Quartic<L::Vector> {
        &self.quartics[usize::from(self.slots[i % BLOCK]) % BLOCK]
    }

    /// Makes the polynomials of all pieces in which places of the block lie, each once.
    #[inline(always)]
    pub fn make<P: Located>(&mut self, block: &Block, places: &[P], mut ahead: Ahead<'_, P>) {
        let (owners, count) = self.find(block, places.len());
        let mut kinds = [List::EMPTY; KINDS];
        for (slot, &owner) in owners.iter().enumerate().take(count) {
            let piece = block.piece[usize::from(owner)] as usize;
            kinds[usize::from(KIND[piece % PIECES])].push(slot);
        }
        let of = |slot: usize| {
            let place = usize::from(owners[slot]);
            (places[place].face(), Piece::from_index(block.piece[place] as usize))
        };
        for slot in kinds[Kind::Whole as usize].iter() {
            ahead.step(&self.reader);
            self.quartics[slot] = self.reader.whole(of(slot).0);
        }
        for slot in kinds[Kind::Middle as usize].iter() {
            ahead.step(&self.reader);
            self.quartics[slot] = self.reader.middle(of(slot).0);
        }
        for slot in kinds[Kind::RegularCorner as usize].iter() {
            ahead.step(&self.reader);
            let (face, piece) = of(slot);
            self.quartics[slot] = self.reader.regular_corner(face, piece.corner());
        }
        for slot in kinds[Kind::Vertex as usize].iter() {
            ahead.step(&self.reader);
            let (face, piece) = of(slot);
            self.quartics[slot] = self.reader.tangent_plane(face, piece.corner());
        }
        for slot in kinds[Kind::Deeper as usize].iter() {
            ahead.step(&self.reader);
            let (face, piece) = of(slot);
            self.reader.corner(face, piece.corner(), &mut self.scratch);
            for _ in 0..piece.depth() {
                self.scratch.descend();
            }
            self.quartics[slot] = self.scratch.quarter(piece.depth(), piece.quarter(), piece.corner());
        }

        let (first, second) = (&kinds[Kind::First as usize], &kinds[Kind::Second as usize]);
        let (corners, corner_of) = find_corners(block, &owners, first.iter().chain(second.iter()));
        for (i, slot) in corners.iter().enumerate() {
            ahead.step(&self.reader);
            let (face, piece) = of(slot);
            self.reader.first_pieces(face, piece.corner(), &mut self.corners[i], &mut self.scratch);
        }
        for slot in first.iter() {
            ahead.step(&self.reader);
            let piece = of(slot).1;
            let pieces = &self.corners[usize::from(corner_of[slot])];
            self.quartics[slot] = pieces.quarter(piece.quarter(), piece.corner());
        }
        for slot in second.iter() {
            ahead.step(&self.reader);
            let (face, piece) = of(slot);
            let before = &self.corners[usize::from(corner_of[slot])];
            self.reader.second_pieces(face, piece.corner(), before, &mut self.second, &mut self.scratch);
            self.quartics[slot] = self.second.quarter(piece.quarter(), piece.corner());
        }
        ahead.finish(&self.reader);
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
