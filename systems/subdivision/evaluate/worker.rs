//! Evaluates places in turn; what one face is made of is made once, as far as its places need it.

use core::ops::Range;

use glam::DVec3;
use selvedge_components::evaluate::Jet;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::PlainLoop;
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::plain::place::{self, DEEPEST};
use selvedge_components::subdivision::plain::{CornerPieces, PatchReader, Piece};

use super::super::lanes::Store;

/// A place and where its result belongs.
pub(super) trait Located {
    fn face(&self) -> FaceId;
    fn st(&self) -> (f64, f64);
}

/// Where results go.
pub(super) trait Put {
    /// Takes the result of the `index`-th place.
    fn put(&mut self, index: usize, jet: Jet);

    /// Says that the result of the `index`-th place will be put soon.
    fn prefetch(&self, index: usize);
}

/// Places that are looked at together: as many as that what their faces are made of fits into the
/// nearest cache.
const BLOCK: usize = 64;

/// Where in their faces the places of a block lie; lists, so that it is found out in lanes.
struct Block {
    s: [f64; BLOCK],
    t: [f64; BLOCK],
    /// Which corners of their faces are regular.
    regular: [u64; BLOCK],
    /// The pieces of faces that are not regular, and the places in them.
    piece: [u64; BLOCK],
    piece_s: [f64; BLOCK],
    piece_t: [f64; BLOCK],
    /// Which places begin where there is a new face; the first `runs` count.
    starts: [u8; BLOCK],
    runs: usize,
}

impl Block {
    const EMPTY: Self = Self {
        s: [0.0; BLOCK],
        t: [0.0; BLOCK],
        regular: [0; BLOCK],
        piece: [0; BLOCK],
        piece_s: [0.0; BLOCK],
        piece_t: [0.0; BLOCK],
        starts: [0; BLOCK],
        runs: 0,
    };

    /// Reads up to [`BLOCK`] places.
    #[inline(always)]
    fn read(&mut self, places: &[impl Located]) {
        self.runs = 0;
        let mut last = None;
        for (i, ((place, s), t)) in places.iter().zip(&mut self.s).zip(&mut self.t).enumerate() {
            let (at_s, at_t) = place.st();
            (*s, *t) = place::clamp(at_s, at_t);
            if last != Some(place.face()) {
                last = Some(place.face());
                self.starts[self.runs & (BLOCK - 1)] = i as u8;
                self.runs += 1;
            }
        }
    }

    /// The `run`-th run of places of `count` with one face.
    #[inline(always)]
    fn run(&self, run: usize, count: usize) -> Range<usize> {
        let end = if run + 1 < self.runs { usize::from(self.starts[run + 1]) } else { count };
        usize::from(self.starts[run])..end
    }

    #[inline(always)]
    fn find_pieces(&mut self) {
        for i in 0..BLOCK {
            (self.piece[i], self.piece_s[i], self.piece_t[i]) = place::in_piece(self.s[i], self.t[i], self.regular[i]);
        }
    }
}

/// The polynomial of a piece of the `face`-th face that is not regular.
#[derive(Clone, Copy)]
struct Made<V> {
    face: u32,
    scale: f64,
    quartic: Quartic<V>,
}

/// Evaluates places in turn; scratch is kept between faces.
pub(super) struct Worker<'a, L: Store> {
    store: L,
    surface: &'a PlainLoop,
    reader: PatchReader<'a, L>,
    /// The places in work and those after them, in turn.
    blocks: [Block; 2],
    corners: [CornerPieces<'a, L>; 3],
    /// By the index of a piece.
    pieces: Vec<Made<L::Vector>>,
    /// How many faces there have been.
    faces: u32,
}

impl<'a, L: Store> Worker<'a, L> {
    #[inline(always)]
    pub fn new(surface: &'a PlainLoop, store: L) -> Self {
        let reader = PatchReader::new(surface, store);
        let corners = [reader.scratch(), reader.scratch(), reader.scratch()];
        Self { store, surface, reader, blocks: [Block::EMPTY; 2], corners, pieces: Vec::new(), faces: 0 }
    }

    /// Evaluates `places`; what has the same face should stand together. While one block is in work,
    /// memory is asked for what the next one needs: what is far away is then waited for hardly at all.
    #[inline(always)]
    pub fn run(&mut self, places: &[impl Located], put: &mut impl Put) {
        let irregular = self.surface.topology().irregular_count() > 0;
        let mut last = None;
        let mut ahead = places.chunks(BLOCK);
        self.blocks[0].read(ahead.next().unwrap_or(&[]));
        for (number, places) in places.chunks(BLOCK).enumerate() {
            let next = ahead.next().unwrap_or(&[]);
            self.blocks[(number + 1) % 2].read(next);
            if irregular {
                self.find_pieces(number, places);
            }
            for run in 0..self.blocks[number % 2].runs {
                self.prefetch(run, number + 1, next, put);
                let run = self.blocks[number % 2].run(run, places.len());
                let face = places[run.start].face();
                if self.surface.topology().is_regular(face) {
                    self.regular(face, run, number, put);
                } else {
                    if last != Some(face) {
                        self.begin_face();
                    }
                    self.irregular(face, run, number, put);
                }
                last = Some(face);
            }
        }
    }

    /// Asks for what the `run`-th face of the next block is made of, and for where its results go.
    #[inline(always)]
    fn prefetch(&self, run: usize, number: usize, places: &[impl Located], put: &impl Put) {
        let block = &self.blocks[number % 2];
        if run < block.runs {
            let run = block.run(run, places.len());
            self.reader.prefetch(places[run.start].face());
            for i in run {
                put.prefetch(BLOCK * number + i);
            }
        }
    }

    /// Finds the pieces in which the places of a block lie.
    #[inline(always)]
    fn find_pieces(&mut self, number: usize, places: &[impl Located]) {
        let topology = self.surface.topology();
        let block = &mut self.blocks[number % 2];
        for run in 0..block.runs {
            let run = block.run(run, places.len());
            let face = places[run.start].face();
            let regular = if topology.is_regular(face) { 0 } else { topology.regular_corners(face) };
            block.regular[run].fill(regular);
        }
        block.find_pieces();
    }

    #[inline(always)]
    fn regular(&self, face: FaceId, run: Range<usize>, number: usize, put: &mut impl Put) {
        let (block, first) = (&self.blocks[number % 2], BLOCK * number);
        let quartic = self.reader.whole(face);
        let at = block.s[run.clone()].iter().zip(&block.t[run.clone()]);
        for (i, (&s, &t)) in (first + run.start..).zip(at) {
            put.put(i, self.jet(&quartic, s, t, 1.0));
        }
    }

    #[inline(always)]
    fn begin_face(&mut self) {
        self.faces += 1;
        for corner in &mut self.corners {
            corner.clear();
        }
    }

    #[inline(always)]
    fn irregular(&mut self, face: FaceId, run: Range<usize>, number: usize, put: &mut impl Put) {
        for i in run {
            let i = i & (BLOCK - 1);
            let piece = self.blocks[number % 2].piece[i] as usize;
            if self.pieces.get(piece).is_none_or(|made| made.face != self.faces) {
                self.make(face, piece);
            }
            let (Made { scale, quartic, .. }, block) = (&self.pieces[piece], &self.blocks[number % 2]);
            put.put(BLOCK * number + i, self.jet(quartic, block.piece_s[i], block.piece_t[i], *scale));
        }
    }

    /// Makes the polynomial of a piece.
    #[inline(always)]
    fn make(&mut self, face: FaceId, index: usize) {
        if self.pieces.len() <= index {
            self.grow(index);
        }
        let piece = Piece::from_index(index);
        let made = &mut self.pieces[index];
        (made.face, made.scale) = (self.faces, piece.scale());
        // Each where it is made: a polynomial is too large to be handed around.
        if piece == Piece::MIDDLE {
            made.quartic = self.reader.middle(face);
        } else if piece.quarter() == 3 {
            made.quartic = self.reader.regular_corner(face, piece.corner());
        } else if piece.depth() == DEEPEST {
            made.quartic = self.reader.tangent_plane(face, piece.corner());
        } else {
            let pieces = &mut self.corners[usize::from(piece.corner())];
            if pieces.depths() == 0 {
                self.reader.corner(face, piece.corner(), pieces);
            }
            while pieces.depths() <= usize::from(piece.depth()) {
                pieces.descend();
            }
            made.quartic = pieces.quarter(piece.depth(), piece.quarter(), piece.corner());
        }
    }

    #[cold]
    fn grow(&mut self, index: usize) {
        let none = Made { face: 0, scale: 0.0, quartic: Quartic { coefficients: [self.store.load(DVec3::ZERO); 14] } };
        self.pieces.resize(index + 1, none);
    }

    /// The value at `(s, t)` of a polynomial whose coordinates run `scale` times as fast as the face's.
    #[inline(always)]
    fn jet(&self, quartic: &Quartic<L::Vector>, s: f64, t: f64, scale: f64) -> Jet {
        let [position, ds, dt] = quartic.with_derivatives(s, t);
        let (ds, dt) = (ds * scale, dt * scale);
        Jet { position: self.store.store(position), ds: self.store.store(ds), dt: self.store.store(dt) }
    }
}
