//! Evaluates places in turn; what one face is made of is made once, as far as its places need it.

use selvedge_components::evaluate::Jet;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::PlainLoop;
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::plain::place::{self, DEEPEST, Found};
use selvedge_components::subdivision::plain::{Band, Bands, PatchReader, Piece};

use super::super::lanes::Store;
use super::spread::Spread;

/// A place and where its result belongs.
pub(super) trait Located {
    fn face(&self) -> FaceId;
    fn st(&self) -> (f64, f64);
}

/// Where results go.
pub(super) trait Put {
    /// From as many places to a face on it is faster to make polynomials as places come.
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
pub(super) struct Block {
    s: [f64; BLOCK],
    t: [f64; BLOCK],
    /// Which run of places with one face each is in.
    pub run: [u8; BLOCK],
    /// The first place of each run; the first `runs` count.
    starts: [u8; BLOCK],
    runs: usize,
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

/// What is to be asked for while something else is in work: corner by corner, so that memory is never asked
/// for more than it can bring.
pub(super) struct Ahead<'a, P> {
    block: &'a Block,
    places: &'a [P],
    run: usize,
    corner: usize,
}

impl<P: Located> Ahead<'_, P> {
    /// Asks for the next corner.
    #[inline(always)]
    pub fn step<L: Store>(&mut self, reader: &PatchReader<'_, L>) {
        if self.run < self.block.runs {
            let place = usize::from(self.block.starts[self.run % BLOCK]);
            reader.prefetch(self.places[place].face(), self.corner);
            (self.run, self.corner) = if self.corner < 2 { (self.run, self.corner + 1) } else { (self.run + 1, 0) };
        }
    }

    /// Asks for all that is left.
    #[inline(always)]
    pub fn finish<L: Store>(&mut self, reader: &PatchReader<'_, L>) {
        while self.run < self.block.runs {
            self.step(reader);
        }
    }
}

impl Block {
    const EMPTY: Self = Self {
        s: [0.0; BLOCK],
        t: [0.0; BLOCK],
        run: [0; BLOCK],
        starts: [0; BLOCK],
        runs: 0,
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
            let (s, t) = place.st();
            (self.s[i], self.t[i]) = place::clamp(s, t);
            run += usize::from(place.face() != last);
            last = place.face();
            self.run[i] = run as u8;
            // Where the next run would begin, written over until it does.
            self.starts[(run + 1) % BLOCK] = i as u8 + 1;
        }
        // A run of its own for each place: the last has written beyond the end, to the front.
        self.starts[0] = 0;
        self.runs = run + 1;
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

/// A piece of the `face`-th face.
#[derive(Clone, Copy)]
struct Made<V> {
    face: u64,
    band: Band<V>,
}

const MIDDLE: usize = Piece::MIDDLE.index();
const WHOLE: usize = Piece::WHOLE.index();
const FIRST_0: usize = Piece::new(0, 0).index();
const FIRST_1: usize = Piece::new(1, 0).index();
const FIRST_2: usize = Piece::new(2, 0).index();
const SECOND_0: usize = Piece::new(0, 1).index();
const SECOND_1: usize = Piece::new(1, 1).index();
const SECOND_2: usize = Piece::new(2, 1).index();

/// Puts a band, if there is one, where it belongs; says whether there is.
#[inline(always)]
fn fill<V>(band: Option<Band<V>>, place: &mut Band<V>) -> bool {
    let Some(band) = band else { return false };
    *place = band;
    true
}

/// Evaluates places in turn; scratch is kept between faces.
pub(super) struct Worker<'a, L: Store> {
    store: L,
    surface: &'a PlainLoop,
    reader: PatchReader<'a, L>,
    /// The places in work and those after them, in turn.
    blocks: [Block; 2],
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
        for (number, places) in places.chunks(BLOCK).enumerate() {
            let next = ahead.next().unwrap_or(&[]);
            self.blocks[(number + 1) % 2].read(next);
            if irregular && self.find_pieces(number, places) {
                if places.len() < Q::CROWDED * self.blocks[number % 2].runs {
                    self.spread(number, places, next, put);
                } else {
                    self.crowded(number, places, next, put);
                }
            } else {
                self.regular(number, places, next, put);
            }
            let goes_on = places.last().map(Located::face) == next.first().map(Located::face);
            self.face += self.blocks[number % 2].runs as u64 - u64::from(goes_on);
        }
    }

    /// Asks for what the `run`-th face of a block is made of.
    #[inline(always)]
    fn prefetch(&self, run: usize, number: usize, places: &[impl Located]) {
        let block = &self.blocks[number % 2];
        if run < block.runs {
            for corner in 0..3 {
                self.reader.prefetch(places[usize::from(block.starts[run])].face(), corner);
            }
        }
    }

    /// Finds the pieces in which the places of a block lie, unless all its faces are regular.
    #[inline(always)]
    fn find_pieces(&mut self, number: usize, places: &[impl Located]) -> bool {
        let topology = self.surface.topology();
        let block = &mut self.blocks[number % 2];
        let mut irregular = false;
        for (corners, &start) in block.corners.iter_mut().zip(&block.starts[..block.runs]) {
            let of_face = topology.regular_corners(places[usize::from(start)].face());
            *corners = of_face.unwrap_or(place::WHOLE);
            irregular |= of_face.is_some();
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
        let ahead = Ahead { block: &self.blocks[(number + 1) % 2], places: next, run: 0, corner: 0 };
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
                self.make(place.face(), face, piece);
            }
            put.put(first + i, self.in_band(&self.pieces[piece].band, &self.blocks[number % 2], i));
        }
    }

    /// Makes a piece of `face`, which is the `number`-th.
    ///
    /// Which comes next cannot be foreseen: one jump leads to code in which nothing depends on it any more.
    #[inline(always)]
    fn make(&mut self, face: FaceId, number: u64, index: usize) {
        if self.pieces.len() <= index {
            self.grow(index);
        }
        let (reader, made) = (self.reader, &mut self.pieces[index]);
        made.face = number;
        // Each where it is made: a polynomial is too large to be handed around.
        let is_made = match index {
            MIDDLE => fill(Some(reader.plain(reader.middle(face))), &mut made.band),
            WHOLE => fill(Some(reader.plain(reader.whole(face))), &mut made.band),
            FIRST_0 => fill(reader.first_band(face, 0), &mut made.band),
            FIRST_1 => fill(reader.first_band(face, 1), &mut made.band),
            FIRST_2 => fill(reader.first_band(face, 2), &mut made.band),
            SECOND_0 => fill(reader.second_band(face, 0), &mut made.band),
            SECOND_1 => fill(reader.second_band(face, 1), &mut made.band),
            SECOND_2 => fill(reader.second_band(face, 2), &mut made.band),
            _ => false,
        };
        if !is_made {
            self.make_around(face, number, index);
        }
    }

    /// Makes any band around a corner, or its vertex.
    #[inline(always)]
    fn make_around(&mut self, face: FaceId, number: u64, index: usize) {
        let piece = Piece::from_index(index);
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
    fn in_band(&self, band: &Band<L::Vector>, block: &Block, i: usize) -> Jet {
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
