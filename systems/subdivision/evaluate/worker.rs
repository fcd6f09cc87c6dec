//! Evaluates places in turn; what one face is made of is made once, as far as its places need it.

use prefetch_index::prefetch_index;
use selvedge_components::evaluate::Jet;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::PlainLoop;
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::plain::place::{self, DEEPEST, Found};
use selvedge_components::subdivision::plain::{Band, Bands, PatchReader, Piece, UsualFace};

use super::super::lanes::Store;
use super::spread::Spread;

/// A place and where its result belongs.
pub(super) trait Located {
    fn face(&self) -> FaceId;
    fn st(&self) -> (f64, f64);
}

/// Where results go.
pub(super) trait Put {
    /// From as many places of a block to a face on it is faster to make polynomials as places come: what the
    /// block before has made serves again.
    const CROWDED: usize;

    /// Takes the result of the `index`-th place.
    fn put(&mut self, index: usize, jet: Jet);

    /// Says that the result of the `index`-th place will be put soon.
    fn prefetch(&self, index: usize);
}

/// Places that are looked at together: as many as that what their faces are made of fits into the
/// nearest cache.
pub(super) const BLOCK: usize = 64;

/// Where in their faces the places of a block lie; lists, so that it is found out in lanes.
///
/// How many places share a face, and which of its pieces each lies in, cannot be foreseen: nothing
/// branches on it but the making of a polynomial.
#[repr(align(64))]
pub(super) struct Block<'a, L> {
    s: [f64; BLOCK],
    t: [f64; BLOCK],
    /// Which run of places with one face each is in.
    pub run: [u8; BLOCK],
    /// The first place of each run; the first `runs` count.
    starts: [u8; BLOCK],
    runs: usize,
    /// By run, the points around the face, `None` of an unusual one; of no meaning of a regular one.
    usual: [Option<UsualFace<'a, L>>; BLOCK],
    /// By run, which corners of the face are regular; [`place::WHOLE`] if all of it is.
    corners: [u64; BLOCK],
    /// By place, the same.
    regular: [u64; BLOCK],
    /// The pieces, the places in them, and how much faster coordinates run there than in the faces.
    pub piece: [u64; BLOCK],
    piece_s: [f64; BLOCK],
    piece_t: [f64; BLOCK],
    scale: [f64; BLOCK],
    /// Of the excess, there and in the derivatives.
    weights: [[f64; BLOCK]; 3],
}

/// What is to be asked for while something else is in work: face by face, so that memory is never asked for
/// more than it can bring.
pub(super) struct Ahead<'a, P> {
    starts: &'a [u8],
    places: &'a [P],
}

impl<P: Located> Ahead<'_, P> {
    /// Asks for what the next face is made of; says whether there was one.
    #[inline(always)]
    pub fn step<L: Store>(&mut self, reader: &PatchReader<'_, L>) -> bool {
        let Some((&place, rest)) = self.starts.split_first() else { return false };
        reader.prefetch(self.places[usize::from(place)].face());
        self.starts = rest;
        true
    }
}

impl<'a, L: Store> Block<'a, L> {
    const EMPTY: Self = Self {
        s: [0.0; BLOCK],
        t: [0.0; BLOCK],
        run: [0; BLOCK],
        starts: [0; BLOCK],
        runs: 0,
        usual: [const { None }; BLOCK],
        corners: [0; BLOCK],
        regular: [0; BLOCK],
        piece: [0; BLOCK],
        piece_s: [0.0; BLOCK],
        piece_t: [0.0; BLOCK],
        scale: [0.0; BLOCK],
        weights: [[0.0; BLOCK]; 3],
    };

    /// Reads up to [`BLOCK`] places.
    #[inline(always)]
    fn read(&mut self, places: &[impl Located]) {
        let Some(mut last) = places.first().map(Located::face) else {
            self.runs = 0;
            return;
        };
        let mut run = 0_usize;
        self.starts[0] = 0;
        for (i, place) in places.iter().enumerate().take(BLOCK) {
            (self.s[i], self.t[i]) = place.st();
            run += usize::from(place.face() != last);
            last = place.face();
            self.run[i] = run as u8;
            // Where the next run would begin, written over until it does.
            self.starts[(run + 1) % BLOCK] = i as u8 + 1;
        }
        // A run of its own for each place: the last has written beyond the end, to the front.
        self.starts[0] = 0;
        self.runs = run + 1;
        self.clamp();
    }

    /// Puts all places into their faces. Whether any is outside is looked at first, in lanes.
    #[inline(always)]
    fn clamp(&mut self) {
        let mut outside = 0;
        for (&s, &t) in self.s.iter().zip(&self.t) {
            outside |= u64::from(!place::is_inside(s, t));
        }
        if outside != 0 {
            for (s, t) in self.s.iter_mut().zip(&mut self.t) {
                (*s, *t) = place::clamp(*s, *t);
            }
        }
    }

    /// The points around the face of place `i`, which is not regular; `None` of an unusual one.
    #[inline(always)]
    pub fn around(&self, i: usize) -> &Option<UsualFace<'a, L>> {
        &self.usual[usize::from(self.run[i % BLOCK]) % BLOCK]
    }

    #[inline(always)]
    fn find_pieces(&mut self) {
        for (regular, &run) in self.regular.iter_mut().zip(&self.run) {
            *regular = self.corners[usize::from(run) % BLOCK];
        }
        for i in 0..BLOCK {
            let Found { piece, s, t, scale, weights } = place::in_face(self.s[i], self.t[i], self.regular[i]);
            (self.piece[i], self.piece_s[i], self.piece_t[i], self.scale[i]) = (piece, s, t, scale);
            (self.weights[0][i], self.weights[1][i], self.weights[2][i]) = weights.into();
        }
    }
}

/// Asks for the places of the block from `first` on. The machine asks for what is read in a row by itself, but
/// stops at the end of a page, and a block is read at one go.
#[inline(always)]
fn prefetch_places<P>(places: &[P], first: usize) {
    let in_a_line = (64 / size_of::<P>()).max(1);
    for place in (first..first + BLOCK).step_by(in_a_line) {
        prefetch_index(places, place);
    }
}

/// A piece of the `face`-th face.
#[derive(Clone, Copy)]
struct Made<V> {
    face: u64,
    band: Band<V>,
}

const MIDDLE: usize = Piece::MIDDLE.index();
const FIRST_0: usize = Piece::new(0, 0).index();
const FIRST_1: usize = Piece::new(1, 0).index();
const FIRST_2: usize = Piece::new(2, 0).index();
const SECOND_0: usize = Piece::new(0, 1).index();
const SECOND_1: usize = Piece::new(1, 1).index();
const SECOND_2: usize = Piece::new(2, 1).index();

/// Evaluates places in turn; scratch is kept between faces.
pub(super) struct Worker<'a, L: Store> {
    store: L,
    surface: &'a PlainLoop,
    reader: PatchReader<'a, L>,
    /// The places in work and those after them, in turn.
    blocks: [Block<'a, L>; 2],
    /// Of the face of that number.
    corners: [(u64, Bands<'a, L>); 3],
    /// By the index of a piece.
    pieces: Vec<Made<L::Vector>>,
    spread: Spread<'a, L>,
    /// Faces are numbered as they come, from one: that of the first place in work.
    face: u64,
}

impl<'a, L: Store> Worker<'a, L> {
    #[inline(always)]
    pub fn new(surface: &'a PlainLoop, store: L) -> Self {
        let reader = PatchReader::new(surface, store);
        let corners = [(0, reader.no_bands()), (0, reader.no_bands()), (0, reader.no_bands())];
        let spread = Spread::new(reader, store);
        Self { store, surface, reader, blocks: [Block::EMPTY; 2], corners, pieces: Vec::new(), spread, face: 1 }
    }

    /// Evaluates `places`; what has the same face should stand together. While one block is in work,
    /// memory is asked for what the next one needs: what is far away is then waited for hardly at all.
    #[inline(always)]
    pub fn run<P: Located, Q: Put>(&mut self, places: &[P], put: &mut Q) {
        let irregular = self.surface.topology().irregular_count() > 0;
        let mut ahead = places.chunks(BLOCK);
        self.blocks[0].read(ahead.next().unwrap_or(&[]));
        for (number, block) in places.chunks(BLOCK).enumerate() {
            let next = ahead.next().unwrap_or(&[]);
            prefetch_places(places, BLOCK * (number + 3));
            self.blocks[(number + 1) % 2].read(next);
            if irregular && self.find_pieces(number, block) {
                if block.len() < Q::CROWDED * self.blocks[number % 2].runs {
                    self.spread(number, block, next, put);
                } else {
                    self.crowded(number, block, next, put);
                }
            } else {
                self.regular(number, block, next, put);
            }
            let goes_on = block.last().map(Located::face) == next.first().map(Located::face);
            self.face += self.blocks[number % 2].runs as u64 - u64::from(goes_on);
        }
    }

    /// Asks for what the `run`-th face of a block is made of.
    #[inline(always)]
    fn prefetch(&self, run: usize, number: usize, places: &[impl Located]) {
        let block = &self.blocks[number % 2];
        if run < block.runs {
            self.reader.prefetch(places[usize::from(block.starts[run])].face());
        }
    }

    /// Finds the pieces in which the places of a block lie, unless all its faces are regular.
    #[inline(always)]
    fn find_pieces(&mut self, number: usize, places: &[impl Located]) -> bool {
        let block = &mut self.blocks[number % 2];
        let mut irregular = false;
        for run in 0..block.runs.min(BLOCK) {
            let face = places[usize::from(block.starts[run])].face();
            block.corners[run] = place::WHOLE;
            if let Some((corners, usual)) = self.reader.irregular(face) {
                block.corners[run] = corners;
                block.usual[run] = usual;
                irregular = true;
            }
        }
        if irregular {
            block.find_pieces();
        }
        irregular
    }

    /// Evaluates a block whose faces are all regular.
    #[inline(always)]
    fn regular(&self, number: usize, places: &[impl Located], next: &[impl Located], put: &mut impl Put) {
        let (block, first) = (&self.blocks[number % 2], BLOCK * number);
        for run in 0..block.runs {
            self.prefetch(run, number + 1, next);
            let end = if run + 1 < block.runs { usize::from(block.starts[run + 1]) } else { places.len() };
            let start = usize::from(block.starts[run]);
            let quartic = self.reader.whole(places[start].face());
            for i in start..end {
                if i < next.len() {
                    put.prefetch(first + BLOCK + i);
                }
                put.put(first + i, self.jet(quartic.with_derivatives(block.s[i], block.t[i]), 1.0));
            }
        }
    }

    /// Evaluates a block of any faces, many of them, of which the pieces are found.
    #[inline(always)]
    fn spread<P: Located>(&mut self, number: usize, places: &[P], next: &[P], put: &mut impl Put) {
        let first = BLOCK * number;
        let after = &self.blocks[(number + 1) % 2];
        let ahead = Ahead { starts: &after.starts[..after.runs], places: next };
        self.spread.make(&self.blocks[number % 2], places, ahead);
        let block = &self.blocks[number % 2];
        for i in 0..places.len().min(BLOCK) {
            if i < next.len() {
                put.prefetch(first + BLOCK + i);
            }
            put.put(first + i, self.in_band(self.spread.band(i), block, i));
        }
    }

    /// Evaluates a block of any faces, few of them, of which the pieces are found. Polynomials serve the
    /// following blocks, too.
    #[inline(always)]
    fn crowded(&mut self, number: usize, places: &[impl Located], next: &[impl Located], put: &mut impl Put) {
        let first = BLOCK * number;
        for (i, place) in places.iter().enumerate().take(BLOCK) {
            self.prefetch(i, number + 1, next);
            if i < next.len() {
                put.prefetch(first + BLOCK + i);
            }
            let block = &self.blocks[number % 2];
            let (piece, face) = (block.piece[i] as usize, self.face + u64::from(block.run[i]));
            if self.pieces.get(piece).is_none_or(|made| made.face != face) {
                self.make(place.face(), *block.around(i), face, piece);
            }
            put.put(first + i, self.in_band(&self.pieces[piece].band, &self.blocks[number % 2], i));
        }
    }

    /// Makes a piece of `face`, which is the `number`-th, with the points `around` it if it is a usual one.
    ///
    /// Which comes next cannot be foreseen: one jump leads to code in which nothing depends on it any more.
    #[inline(always)]
    fn make(&mut self, face: FaceId, around: Option<UsualFace<'a, L>>, number: u64, index: usize) {
        if self.pieces.len() <= index {
            self.grow(index);
        }
        let made = &mut self.pieces[index];
        made.face = number;
        let Some(around) = around else { return self.make_any(face, number, index) };
        // Each where it is made: a polynomial is too large to be handed around.
        match index {
            MIDDLE => made.band = self.reader.plain(around.middle()),
            FIRST_0 => made.band = around.first_band(0),
            FIRST_1 => made.band = around.first_band(1),
            FIRST_2 => made.band = around.first_band(2),
            SECOND_0 => made.band = around.second_band(0),
            SECOND_1 => made.band = around.second_band(1),
            SECOND_2 => made.band = around.second_band(2),
            _ => self.make_any(face, number, index),
        }
    }

    /// As [`Self::make`] any piece of any face.
    #[inline(always)]
    fn make_any(&mut self, face: FaceId, number: u64, index: usize) {
        let piece = Piece::from_index(index);
        match piece {
            Piece::WHOLE => return self.pieces[index].band = self.reader.plain(self.reader.whole(face)),
            Piece::MIDDLE => return self.pieces[index].band = self.reader.plain(self.reader.middle(face)),
            _ => {}
        }
        if piece.depth() == DEEPEST {
            self.pieces[index].band = self.reader.plain(self.reader.tangent_plane(face, piece.corner()));
            return;
        }
        let (of_face, bands) = &mut self.corners[usize::from(piece.corner())];
        if *of_face != number {
            *of_face = number;
            self.reader.begin(face, piece.corner(), bands);
        }
        while bands.depths() <= usize::from(piece.depth()) {
            bands.descend();
        }
        self.pieces[index].band = bands.band(piece.depth(), piece.corner());
    }

    #[cold]
    fn grow(&mut self, index: usize) {
        let none = Quartic { coefficients: [self.store.zero(); 14] };
        let none = Made { face: 0, band: self.reader.plain(none) };
        self.pieces.resize(index + 1, none);
    }

    /// The value at the `i`-th place of `block`, which lies in `band`.
    #[inline(always)]
    fn in_band(&self, band: &Band<L::Vector>, block: &Block<'a, L>, i: usize) -> Jet {
        let weights = [block.weights[0][i], block.weights[1][i], block.weights[2][i]];
        self.jet(band.with_derivatives(block.piece_s[i], block.piece_t[i], weights), block.scale[i])
    }

    /// What is known along coordinates that run `scale` times as fast as the face's.
    #[inline(always)]
    fn jet(&self, [position, ds, dt]: [L::Vector; 3], scale: f64) -> Jet {
        let (ds, dt) = (ds * scale, dt * scale);
        Jet { position: self.store.store(position), ds: self.store.store(ds), dt: self.store.store(dt) }
    }
}
