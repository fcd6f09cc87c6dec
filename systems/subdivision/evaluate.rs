//! Evaluate: many places of a plain Loop surface at once.
//!
//! Places are brought together by face, and by polynomial where a face has several; each polynomial
//! is made once and evaluated in as many lanes as the machine has. Which places come together changes
//! no bit of any result.

use pulp::Arch;
use selvedge_components::evaluate::{Jet, SurfacePoint};
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::PlainLoop;
use selvedge_components::subdivision::plain::{PatchReader, Piece, Place};
use thiserror::Error;

use super::lanes::{self, Put};
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
    over_chunks(places, jets, |places, jets| {
        let sorted = sort_by_face(places, surface.topology().mesh().face_count());
        let mut worker = Worker::new(surface);
        for run in sorted.chunk_by(|a, b| a.face == b.face) {
            let of_run = run.iter().map(|r| (r.s, r.t));
            worker.face(FaceId(run[0].face), of_run, &mut Scattered { run, jets });
        }
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
    over_chunks(places, jets, |places, mut jets| {
        let mut worker = Worker::new(surface);
        for run in places.chunk_by(|a, b| a.face == b.face) {
            let (own, rest) = jets.split_at_mut(run.len());
            jets = rest;
            worker.face(run[0].face, run.iter().map(|p| (p.st.x, p.st.y)), &mut InOrder(own));
        }
    });
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

/// Fewer places than this are not shared between threads: they take about as long as waking one.
const ALONE: usize = 4096;

/// Gives every thread one run of the places: the longer the run, the more places share a face.
fn over_chunks(places: &[SurfacePoint], jets: &mut [Jet], work: impl Fn(&[SurfacePoint], &mut [Jet]) + Sync + Send) {
    // Indices within a run are kept in 32 bits.
    let size = places.len().div_ceil(parallel::threads()).clamp(ALONE, 1 << 31);
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

/// Results go on under the index in the low half of their keys.
struct ByKey<'a, P> {
    keys: &'a [u64],
    put: &'a mut P,
}

impl<P: Put> Put for ByKey<'_, P> {
    #[inline(always)]
    fn put(&mut self, index: usize, jet: Jet) {
        self.put.put(self.keys[index] as u32 as usize, jet);
    }
}

/// Evaluates face by face; scratch is kept between faces.
struct Worker<'a> {
    surface: &'a PlainLoop,
    arch: Arch,
    reader: PatchReader<'a>,
    /// The places of one face in their pieces' coordinates, pieces together.
    s: Vec<f64>,
    t: Vec<f64>,
    /// `(rank of the piece, index)` of each, packed so that they sort as one number.
    keys: Vec<u64>,
    unsorted: Vec<(f64, f64)>,
}

impl<'a> Worker<'a> {
    fn new(surface: &'a PlainLoop) -> Self {
        let (s, t, keys, unsorted) = Default::default();
        Self { surface, arch: Arch::new(), reader: PatchReader::new(surface), s, t, keys, unsorted }
    }

    /// Evaluates `places` of `face`; `put` gets each place's index and result.
    fn face(&mut self, face: FaceId, places: impl Iterator<Item = (f64, f64)>, put: &mut impl Put) {
        self.s.clear();
        self.t.clear();
        if let Some(quartic) = self.surface.quartic(face) {
            for (s, t) in places {
                let place = Place::in_regular(s, t);
                self.s.push(place.s);
                self.t.push(place.t);
            }
            let job = lanes::Jets { quartic: &quartic, piece: Piece::Whole, s: &self.s, t: &self.t, put };
            self.arch.dispatch(job);
        } else {
            self.irregular_face(face, places, put);
        }
    }

    fn irregular_face(&mut self, face: FaceId, places: impl Iterator<Item = (f64, f64)>, put: &mut impl Put) {
        self.keys.clear();
        self.unsorted.clear();
        for (i, (s, t)) in places.enumerate() {
            let place = Place::in_irregular(s, t);
            self.keys.push(u64::from(place.piece.rank()) << 32 | i as u64);
            self.unsorted.push((place.s, place.t));
        }
        self.keys.sort_unstable();
        for run in self.keys.chunk_by(|a, b| a >> 32 == b >> 32) {
            let piece = Piece::of_rank((run[0] >> 32) as u32);
            let quartic = self.reader.quartic(face, piece);
            self.s.clear();
            self.t.clear();
            for &key in run {
                let (s, t) = self.unsorted[key as u32 as usize];
                self.s.push(s);
                self.t.push(t);
            }
            let put = &mut ByKey { keys: run, put };
            self.arch.dispatch(lanes::Jets { quartic: &quartic, piece, s: &self.s, t: &self.t, put });
        }
    }
}
