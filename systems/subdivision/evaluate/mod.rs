//! Evaluate: many places of a plain Loop surface at once.
//!
//! Places are brought together by face, and by polynomial where a face has several; each polynomial
//! is made once and evaluated in as many lanes as the machine has. Which places come together changes
//! no bit of any result.

use core::hint::black_box;

use glam::DVec3;
use pulp::{Arch, Simd, WithSimd};
use selvedge_components::evaluate::{Jet, SurfacePoint};
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::PlainLoop;
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::plain::place;
use selvedge_components::subdivision::plain::{AsStored, CornerPieces, PatchReader};
use thiserror::Error;

use super::lanes::{AsLanes, Store};
use crate::parallel;

/// Why places were not evaluated.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EvaluateError {
    /// There is not one result for each place.
    #[error("{results} results for {places} places")]
    Length {
        /// How many places there are.
        places: usize,
        /// How many results there is room for.
        results: usize,
    },
    /// A place names a face that the surface does not have.
    #[error("place {place} is on {face}; there are {faces} faces")]
    NoSuchFace {
        /// The first such place.
        place: usize,
        /// The face it names.
        face: FaceId,
        /// How many faces there are.
        faces: usize,
    },
}

/// Position and first derivatives at `places`, in any order, as [`PlainLoop`] gives them one by one.
///
/// # Errors
/// [`EvaluateError`]; `jets` is unchanged then.
pub fn jets(surface: &PlainLoop, places: &[SurfacePoint], jets: &mut [Jet]) -> Result<(), EvaluateError> {
    check(surface, places, jets)?;
    over_chunks(chunk_size(surface, places.len()), places, jets, |places, jets| {
        let records = &sort_by_face(places, surface.topology().mesh().face_count());

        Arch::new().dispatch(Scatter { surface, records, jets });
    });
    Ok(())
}

/// As [`jets`] for places that stand together by face already; correct in any other order too, but
/// then each run of equal faces pays for its polynomials anew.
///
/// # Errors
/// As [`jets`].
pub fn jets_by_face(surface: &PlainLoop, places: &[SurfacePoint], jets: &mut [Jet]) -> Result<(), EvaluateError> {
    check(surface, places, jets)?;
    let size = places.len().div_ceil(parallel::threads()).max(FEWEST);
    over_chunks(size, places, jets, |places, jets| Arch::new().dispatch(Follow { surface, places, jets }));
    Ok(())
}

fn check(surface: &PlainLoop, places: &[SurfacePoint], jets: &[Jet]) -> Result<(), EvaluateError> {
    if places.len() != jets.len() {
        return Err(EvaluateError::Length { places: places.len(), results: jets.len() });
    }
    let faces = surface.topology().mesh().face_count();
    match places.iter().position(|p| p.face.index() >= faces) {
        Some(place) => Err(EvaluateError::NoSuchFace { place, face: places[place].face, faces }),
        None => Ok(()),
    }
}

/// Fewer places than this are not worked on alone: waking a thread takes about as long.
const FEWEST: usize = 4096;
/// More than this at once only pay where they share polynomials: their results, at 72 bytes each,
/// outgrow the caches and the pages that a processor keeps in reach, and each is written anywhere.
const NEAR: usize = 1 << 16;
/// As many places per face as that polynomials cost little beside them: a face that is not regular
/// has some 40 that matter.
const PER_REGULAR_FACE: usize = 64;
const PER_IRREGULAR_FACE: usize = 256;

/// How many places of `surface` to bring together by face at once, of `places` in any order.
fn chunk_size(surface: &PlainLoop, places: usize) -> usize {
    let faces = surface.topology().mesh().face_count();
    let irregular = surface.topology().irregular_count();
    let sharing = PER_REGULAR_FACE * (faces - irregular) + PER_IRREGULAR_FACE * irregular;
    places.div_ceil(parallel::threads()).min(sharing.max(NEAR)).max(FEWEST)
}

/// Runs `work` on runs of `size` places and their results.
fn over_chunks(
    size: usize,
    places: &[SurfacePoint],
    jets: &mut [Jet],
    work: impl Fn(&[SurfacePoint], &mut [Jet]) + Sync + Send,
) {
    // Indices within a run are kept in 32 bits.
    let size = size.min(1 << 31);
    let chunks: Vec<_> = places.chunks(size).zip(jets.chunks_mut(size)).collect();
    parallel::for_each(chunks, |(places, jets)| work(places, jets));
}

/// A place and where its result belongs.
#[derive(Clone, Copy, Default)]
struct Record {
    s: f64,
    t: f64,
    face: u32,
    index: u32,
}

/// The places with those of one face together.
fn sort_by_face(places: &[SurfacePoint], faces: usize) -> Vec<Record> {
    let record = |(i, p): (usize, &SurfacePoint)| Record { s: p.st.x, t: p.st.y, face: p.face.0, index: i as u32 };
    // Counting reads a table of all faces: worth it from about a place for every eighth face on.
    if places.len() < faces / 8 {
        let mut records: Vec<Record> = places.iter().enumerate().map(record).collect();
        records.sort_unstable_by_key(|r| (r.face, r.index));
        return records;
    }
    let mut start = vec![0_u32; faces + 1];
    for p in places {
        start[p.face.index() + 1] += 1;
    }
    for f in 0..faces {
        start[f + 1] += start[f];
    }
    let mut records = vec![Record::default(); places.len()];
    for (i, p) in places.iter().enumerate() {
        let at = &mut start[p.face.index()];
        records[*at as usize] = record((i, p));
        *at += 1;
    }
    records
}

/// Where results go.
trait Put {
    /// Takes the result of the `index`-th place.
    fn put(&mut self, index: usize, jet: Jet);
}

/// Results go where the records say.
struct Scattered<'a, 'b> {
    run: &'a [Record],
    jets: &'b mut [Jet],
}

impl Put for Scattered<'_, '_> {
    #[inline(always)]
    fn put(&mut self, index: usize, jet: Jet) {
        self.jets[self.run[index].index as usize] = jet;
    }
}

/// Results go one after the other.
struct InOrder<'a>(&'a mut [Jet]);

impl Put for InOrder<'_> {
    #[inline(always)]
    fn put(&mut self, index: usize, jet: Jet) {
        self.0[index] = jet;
    }
}

/// Evaluates sorted records and puts each result where it belongs.
struct Scatter<'a> {
    surface: &'a PlainLoop,
    records: &'a [Record],
    jets: &'a mut [Jet],
}

impl WithSimd for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        // Wide enough for the three coordinates of a point; decided when this is compiled.
        if S::F64_LANES == 4 { self.run(AsLanes(simd)) } else { self.run(AsStored) }
    }
}

impl Scatter<'_> {
    #[inline(always)]
    fn run(self, store: impl Store) {
        let mut worker = Worker::new(self.surface, store);
        let mut runs = self.records.chunk_by(|a, b| a.face == b.face).peekable();
        while let Some(run) = runs.next() {
            // Faces that neighbour in number seldom do in memory; their points come while this one's are
            // worked on.
            if let Some(next) = runs.peek() {
                black_box(worker.reader.touch(FaceId(next[0].face)));
            }
            worker.face(FaceId(run[0].face), run, &mut Scattered { run, jets: self.jets });
        }
    }
}

/// Evaluates places in their own order.
struct Follow<'a> {
    surface: &'a PlainLoop,
    places: &'a [SurfacePoint],
    jets: &'a mut [Jet],
}

impl WithSimd for Follow<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        if S::F64_LANES == 4 { self.run(AsLanes(simd)) } else { self.run(AsStored) }
    }
}

impl Follow<'_> {
    #[inline(always)]
    fn run(self, store: impl Store) {
        let mut worker = Worker::new(self.surface, store);
        let mut jets = self.jets;
        for run in self.places.chunk_by(|a, b| a.face == b.face) {
            let (own, rest) = jets.split_at_mut(run.len());
            jets = rest;
            worker.face(run[0].face, run, &mut InOrder(own));
        }
    }
}

/// What has a place in a face.
trait Located {
    fn st(&self) -> (f64, f64);
}

impl Located for Record {
    #[inline(always)]
    fn st(&self) -> (f64, f64) {
        (self.s, self.t)
    }
}

impl Located for SurfacePoint {
    #[inline(always)]
    fn st(&self) -> (f64, f64) {
        (self.st.x, self.st.y)
    }
}

/// A place on its way through the pieces of a face.
#[derive(Clone, Copy, Default)]
struct Waiting {
    /// The weights of the two corners after the corner that the place is nearest to; in the middle
    /// quarter the face's own coordinates.
    a: f64,
    b: f64,
    index: u32,
    quarter: u8,
}

/// A list that takes what it is offered only when told to: without a branch, because for random
/// places none could be foreseen.
#[derive(Clone, Default)]
struct Sieve {
    /// The first `count` are taken.
    places: Vec<Waiting>,
    count: usize,
}

impl Sieve {
    /// Empties the list and makes room for as many as `most`.
    #[inline(always)]
    fn clear(&mut self, most: usize) {
        self.count = 0;
        // One more, for what is offered and not taken when the list is full.
        if self.places.len() <= most {
            self.places.resize(most + 1, Waiting::default());
        }
    }

    #[inline(always)]
    fn offer(&mut self, place: Waiting, take: bool) {
        self.places[self.count] = place;
        self.count += usize::from(take);
    }

    #[inline(always)]
    fn taken(&self) -> &[Waiting] {
        &self.places[..self.count]
    }
}

/// Evaluates face by face; scratch is kept between faces.
struct Worker<'a, L: Store> {
    store: L,
    surface: &'a PlainLoop,
    reader: PatchReader<'a, L>,
    pieces: CornerPieces<L::Vector>,
    /// The places of one face: those near each corner, and those in the middle.
    waiting: [Sieve; 4],
    /// Those that the present depth of a corner reaches.
    reached: Sieve,
    quarters: [Quartic<L::Vector>; 3],
}

impl<'a, L: Store> Worker<'a, L> {
    #[inline(always)]
    fn new(surface: &'a PlainLoop, store: L) -> Self {
        let reader = PatchReader::new(surface, store);
        let none = Quartic { coefficients: [store.load(DVec3::ZERO); 14] };
        let (waiting, reached, quarters) = (Default::default(), Sieve::default(), [none; 3]);
        Self { store, surface, reader, pieces: reader.scratch(), waiting, reached, quarters }
    }

    /// Evaluates `places` of `face`; `put` gets each place's index and result.
    #[inline(always)]
    fn face(&mut self, face: FaceId, places: &[impl Located], put: &mut impl Put) {
        if self.surface.topology().is_regular(face) {
            let quartic = self.reader.whole(face);
            for (i, place) in places.iter().enumerate() {
                let (s, t) = place.st();
                let (s, t) = place::clamp(s, t);
                put.put(i, self.jet(&quartic, (s, t), (0, 1.0)));
            }
        } else {
            self.irregular_face(face, places, put);
        }
    }

    #[inline(always)]
    fn irregular_face(&mut self, face: FaceId, places: &[impl Located], put: &mut impl Put) {
        for waiting in &mut self.waiting {
            waiting.clear(places.len());
        }
        self.reached.clear(places.len());
        for (i, place) in places.iter().enumerate() {
            let (s, t) = place.st();
            let (s, t) = place::clamp(s, t);
            let (quarter, a, b) = place::quarter_of_face(s, t);
            let place = Waiting { a, b, index: i as u32, quarter };
            self.waiting[usize::from(quarter & 3)].offer(place, true);
        }
        if self.waiting[3].count > 0 {
            let quartic = self.reader.middle(face);
            for w in self.waiting[3].taken() {
                let st = (1.0 - 2.0 * w.a, 1.0 - 2.0 * w.b);
                put.put(w.index as usize, self.jet(&quartic, st, (0, -2.0)));
            }
        }
        for corner in 0..3 {
            if self.waiting[usize::from(corner)].count > 0 {
                self.corner(face, corner, put);
            }
        }
    }

    /// Evaluates the places near a corner, depth by depth.
    #[inline(always)]
    fn corner(&mut self, face: FaceId, corner: u8, put: &mut impl Put) {
        self.reader.corner(face, corner, &mut self.pieces);
        let mut scale = 2.0;
        for _ in 0..place::DEEPEST {
            let wanted = self.reach(corner);
            if wanted & 1 != 0 {
                self.quarters[0] = self.pieces.quarter(0);
            }
            if wanted & 2 != 0 {
                self.quarters[1] = self.pieces.quarter(1);
            }
            if wanted & 4 != 0 {
                self.quarters[2] = self.pieces.quarter(2);
            }
            for w in self.reached.taken() {
                let (s, t, turn) = place::in_quarter(w.quarter, w.a, w.b);
                let quartic = &self.quarters[usize::from(w.quarter)];
                put.put(w.index as usize, self.jet(quartic, (s, t), (corner, turn * scale)));
            }
            if self.waiting[usize::from(corner)].count == 0 {
                return;
            }
            self.pieces.descend();
            scale *= 2.0;
        }
        let plane = self.reader.tangent_plane(face, corner);
        for w in self.waiting[usize::from(corner)].taken() {
            put.put(w.index as usize, self.jet(&plane, (0.0, 0.0), (corner, 1.0)));
        }
    }

    /// Takes what the next depth reaches from the places that wait near `corner`; which quarters hold
    /// any, as bits.
    #[inline(always)]
    fn reach(&mut self, corner: u8) -> u8 {
        let waiting = &mut self.waiting[usize::from(corner)];
        let count = core::mem::take(&mut waiting.count);
        self.reached.count = 0;
        let mut wanted = 0;
        for i in 0..count {
            let w = waiting.places[i];
            let (a, b) = (2.0 * w.a, 2.0 * w.b);
            let quarter = place::quarter_of_corner(a, b);
            let (place, now) = (Waiting { a, b, index: w.index, quarter }, a + b > 0.5);
            wanted |= u8::from(now) << quarter;
            self.reached.offer(place, now);
            waiting.offer(place, !now);
        }
        wanted
    }

    /// The value at `(s, t)`; derivatives are turned to the face's coordinates from those of `corner`,
    /// `scale` times as fast.
    #[inline(always)]
    fn jet(&self, quartic: &Quartic<L::Vector>, (s, t): (f64, f64), (corner, scale): (u8, f64)) -> Jet {
        let [position, ds, dt] = quartic.with_derivatives(s, t);
        let [ds, dt] = place::to_face(corner, scale, ds, dt);
        Jet { position: self.store.store(position), ds: self.store.store(ds), dt: self.store.store(dt) }
    }
}

#[cfg(test)]
mod tests;
