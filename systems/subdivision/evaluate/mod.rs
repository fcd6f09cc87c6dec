//! Evaluate: many places of a plain Loop surface at once.
//!
//! Places are brought together by face; of a face that has several polynomials those that its places
//! need are made, each once. Which places come together changes no bit of any result.

use prefetch_index::prefetch_index;
use pulp::{Arch, Simd, WithSimd};
use selvedge_components::evaluate::{Jet, SurfacePoint};
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::PlainLoop;
use selvedge_components::subdivision::plain::AsStored;
use thiserror::Error;

use super::lanes::{AsLanes, Store};
use crate::parallel;
use worker::{BLOCK, Located, Put, Worker};

mod spread;
mod worker;

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

        dispatch(Scatter { surface, records, jets });
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
    over_chunks(size, places, jets, |places, jets| dispatch(Follow { surface, places, jets }));
    Ok(())
}

fn check(surface: &PlainLoop, places: &[SurfacePoint], jets: &[Jet]) -> Result<(), EvaluateError> {
    if places.len() != jets.len() {
        return Err(EvaluateError::Length { places: places.len(), results: jets.len() });
    }
    let faces = surface.topology().mesh().face_count();
    // The largest alone is found faster than the first that is too large.
    let largest = places.iter().fold(0, |largest, place| place.face.index().max(largest));
    if places.is_empty() || largest < faces {
        return Ok(());
    }
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

/// Results go where the records say.
struct Scattered<'a, 'b> {
    run: &'a [Record],
    jets: &'b mut [Jet],
}

impl Put for Scattered<'_, '_> {
    /// None has so many: what stands in the way of writes anywhere is better all made before.
    const CROWDED: usize = BLOCK + 1;

    #[inline(always)]
    fn put(&mut self, index: usize, jet: Jet) {
        self.jets[self.run[index].index as usize] = jet;
    }

    #[inline(always)]
    fn prefetch(&self, index: usize) {
        prefetch_index(&*self.jets, self.run[index].index as usize);
    }
}

/// Results go one after the other.
struct InOrder<'a>(&'a mut [Jet]);

impl Put for InOrder<'_> {
    const CROWDED: usize = 40;

    #[inline(always)]
    fn put(&mut self, index: usize, jet: Jet) {
        self.0[index] = jet;
    }

    /// The machine asks for what is written in a row by itself, but late: what stands in the way of other
    /// writes holds up all that reads them.
    #[inline(always)]
    fn prefetch(&self, index: usize) {
        prefetch_index(&*self.0, index);
    }
}

/// Runs `work` compiled for this machine. The coordinates of a point fill four lanes, whatever the machine has:
/// compiled for one that has eight, the same work has twice the registers, and loops over places fill them.
fn dispatch<W: WithSimd<Output = ()>>(work: W) {
    #[cfg(target_arch = "x86_64")]
    if let Some(eight) = pulp::x86::V4::try_new() {
        return eight.vectorize(InFour(*eight, work));
    }
    Arch::new().dispatch(work);
}

/// Work in four lanes of eight.
#[cfg(target_arch = "x86_64")]
struct InFour<W>(pulp::x86::V3, W);

#[cfg(target_arch = "x86_64")]
impl<W: WithSimd<Output = ()>> pulp::NullaryFnOnce for InFour<W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        self.1.with_simd(self.0);
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
        let mut put = Scattered { run: self.records, jets: self.jets };
        Worker::new(self.surface, store).run(self.records, &mut put);
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
        Worker::new(self.surface, store).run(self.places, &mut InOrder(self.jets));
    }
}

impl Located for Record {
    #[inline(always)]
    fn face(&self) -> FaceId {
        FaceId(self.face)
    }

    #[inline(always)]
    fn st(&self) -> (f64, f64) {
        (self.s, self.t)
    }
}

impl Located for SurfacePoint {
    #[inline(always)]
    fn face(&self) -> FaceId {
        self.face
    }

    #[inline(always)]
    fn st(&self) -> (f64, f64) {
        (self.st.x, self.st.y)
    }
}

#[cfg(test)]
mod tests;
