//! # Adapt: the cage near a curve becomes as fine as the curve asks for
//!
//! Three rules, each a set of red splits (one face into four):
//!
//! 1. *follow*: a face is split while a piece of curve inside it is longer than its chord by more
//!    than [`AdaptOptions::bend`] [Litke et al. 2001, Section 3.1], or while a smooth piece of curve
//!    is shorter than some of its edges; and along a smooth piece the level changes by one only every
//!    [`AdaptOptions::alike`] faces;
//! 2. *near*: every face nearer to a curve than [`AdaptOptions::near`] of its own size is split down
//!    to the level that the curve uses, so that the strip along the curve is narrow and its faces
//!    alike: wide strips end in vertices of valence 8;
//! 3. *balance*: neighbours differ by one level at most.

use std::collections::HashMap;

use glam::DVec3;
use selvedge_components::subdivision::{CornerTable, FaceCode, LoopSurface};

use super::error::RemeshError;
use super::field::Field;
use super::leaves::Leaves;
use super::track::{Near, Track, Visit, size, spread};

/// What the cage near a curve is adapted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptOptions {
    /// Arc over chord, less one, above which a face is split; half as much where the curve's radius is less
    /// than a twelfth of the length of its smooth piece. Two hundredths are a turn of 0.7 radians in a face, nine
    /// faces round a circle at least. Half that everywhere would make bores on many cages dearer, up to twice,
    /// and none cheaper; a fillet needs it, to have more than one vertex.
    pub bend: f64,
    /// Faces nearer to a curve than this many of their own sizes are split to the curve's level.
    pub near: f64,
    /// How many edges a smooth piece of curve between two corners has at least.
    pub pieces: f64,
    /// How many faces of a level follow a smooth piece of curve, from where it asks for that level, before
    /// they may be coarser: more than half of what a circle has, so that a circle has one level.
    pub alike: f64,
    /// The level that the whole cage is brought to first: each level halves the reach of a change.
    pub base: u32,
    /// The finest level allowed.
    pub finest: u32,
    /// The most faces that the cage may have.
    pub most_faces: usize,
}

impl Default for AdaptOptions {
    fn default() -> Self {
        Self { bend: 0.02, near: 1.2, pieces: 3.0, alike: 16.0, base: 0, finest: 14, most_faces: 1 << 22 }
    }
}

/// Leaves that suit all curves of `track`. `least` asks for a level where rule 1 finds less, by
/// segment; for none beyond [`finest`].
///
/// # Errors
/// [`RemeshError::TooFine`], [`RemeshError::TooManyFaces`].
pub fn adapt(
    surface: &LoopSurface,
    corners: &CornerTable,
    track: &Track,
    options: &AdaptOptions,
    least: &[u32],
) -> Result<Leaves, RemeshError> {
    let limit = finest(surface, options);
    let mut leaves = Leaves::uniform(&surface.mesh, options.base.min(limit));
    let pieces = Pieces::new(track);
    let asked = follow(surface, corners, track, &pieces, options, limit)?;
    let levels = pieces.alike(track, &asked, options);
    let finest: Vec<u32> = levels.into_iter().zip(least).map(|(level, &least)| level.max(least).min(limit)).collect();
    let deepest = finest.iter().copied().max().unwrap_or(0);
    for level in options.base..deepest {
        for code in near(surface, corners, track, options, &leaves, level, &finest) {
            leaves.split(&surface.mesh, level, code);
        }
        let faces = surface.mesh.face_count() + 3 * leaves.split_count();
        if faces > options.most_faces {
            return Err(RemeshError::TooManyFaces { level: level + 1, faces, limit: options.most_faces });
        }
    }
    leaves.fill(&surface.mesh);
    Ok(leaves)
}

/// The finest level that a cage may have: as far as its faces can be addressed.
pub fn finest(surface: &LoopSurface, options: &AdaptOptions) -> u32 {
    options.finest.min(FaceCode::finest(surface.mesh.face_count()).saturating_sub(2))
}

/// What a segment of a track asks for by itself.
#[derive(Clone, Copy, Debug)]
struct Asked {
    level: u32,
    /// About the edge of a face of that level there, in model units.
    edge: f64,
}

/// Rule 1: the finest level that each segment asks for.
fn follow(
    surface: &LoopSurface,
    corners: &CornerTable,
    track: &Track,
    pieces: &Pieces,
    options: &AdaptOptions,
    limit: u32,
) -> Result<Vec<Asked>, RemeshError> {
    let mut asked = vec![Asked { level: options.base, edge: 0.0 }; track.points.len()];
    let mut open: Option<Vec<FaceCode>> = None;
    let mut within = vec![true; track.points.len()];
    for level in options.base..=limit {
        let mut visits = track.visits(level, |segment| within[segment as usize]);
        if let Some(open) = &open {
            visits.retain(|v| open.binary_search(&v.code.parent()).is_ok());
        }
        if visits.is_empty() {
            return Ok(asked);
        }
        let faces = super::super::region::ascending(visits.iter().map(|v| v.code).collect());
        let field = Field::new(surface, corners, level, &faces);
        let mut split = Vec::new();
        let runs: Vec<_> = visits.chunk_by(|a, b| a.code == b.code && joined(track, a, b)).collect();
        let sharp = sharp(track, &runs, options.bend, |s| pieces.lengths[pieces.of_segment[s as usize] as usize]);
        for (run, is_sharp) in runs.into_iter().zip(sharp) {
            let Some(face) = field.level.mesh.find(run[0].code) else { continue };
            let edge = size(field.triangle(face));
            let (arc, chord) = arc_and_chord(track, run);
            let piece = pieces.of_segment[run[0].segment as usize] as usize;
            let length = pieces.lengths[piece];
            let bend = allowed(options.bend, arc, turn(track, run), length);
            let bends = arc > SHORTEST * edge && arc > (1.0 + bend) * chord;
            let turns = is_sharp && arc > TOUCHES * edge;
            if bends || turns || options.pieces * edge > length {
                if level == limit {
                    let what = if bends || turns { BENDS } else { SHORT };
                    return Err(too_fine(track, run[0].segment, what, limit, edge));
                }
                split.push(run[0].code);
                run.iter().for_each(|v| asked[v.segment as usize] = Asked { level: level + 1, edge: 0.5 * edge });
            }
        }
        let split = super::super::region::ascending(split);
        within = track.having(&visits, |v| split.binary_search(&v.code).is_ok());
        open = Some(split);
    }
    Ok(asked)
}

fn too_fine(track: &Track, segment: u32, what: &'static str, limit: u32, size: f64) -> RemeshError {
    let p = &track.points[segment as usize];
    RemeshError::TooFine { what, size, limit, curve: p.curve as usize, u: p.u, at: p.position }
}

/// What a cage cannot follow.
const BENDS: &str = "the curve bends too sharply for them, and has no corner there";

/// See [`BENDS`].
const SHORT: &str = "a piece of the curve between two corners or crossings is too short for them";

/// A curve that touches a face by less than this part of its size is the business of the faces
/// beside it; where it runs through a vertex it may touch some by a rounding error.
const SHORTEST: f64 = 0.1;

/// Nor does a curve run through a face that it touches by less than this part of its size.
const TOUCHES: f64 = 1e-3;

/// A curve bends tightly where its radius is less than this part of its piece's length: half of that of a
/// circle.
const TIGHT: f64 = 1.0 / 12.0;

/// What arc over chord less one may be of an arc that turns by `turn` radians, on a piece of `length`.
fn allowed(bend: f64, arc: f64, turn: f64, length: f64) -> f64 {
    if arc < TIGHT * length * turn { 0.5 * bend } else { bend }
}

/// A face is split, too, where the curve turns by more radians than this many times the square root of
/// [`AdaptOptions::bend`], in it alone or in it and the next: twice the turn of the arc that `bend` describes.
/// Arc over chord does not see the turn of a small fillet next to an edge of the face, or across one, for
/// nearly all of the arc is straight then.
const SHARP: f64 = 10.0;

/// Is `b` the smooth continuation of `a`?
fn joined(track: &Track, a: &Visit, b: &Visit) -> bool {
    a.segment == b.segment
        || track.points[a.segment as usize].next == b.segment && !track.points[b.segment as usize].corner
}

/// How long a run of visits is, along the track and straight.
fn arc_and_chord(track: &Track, run: &[Visit]) -> (f64, f64) {
    let at = |visit: &Visit, end: usize| {
        track.position(Near { segment: visit.segment, part: visit.part[end], distance: 0.0 })
    };
    let arc = run.iter().map(|v| at(v, 0).distance(at(v, 1))).sum();
    (arc, at(&run[0], 0).distance(at(&run[run.len() - 1], 1)))
}

/// Of each run of visits, whether the curve turns sharply in it, or in it and a neighbour: see [`SHARP`].
/// `length` is that of the piece of a segment.
fn sharp(track: &Track, runs: &[&[Visit]], bend: f64, length: impl Fn(u32) -> f64) -> Vec<bool> {
    let turns: Vec<f64> = runs.iter().map(|run| turn(track, run)).collect();
    let arcs: Vec<f64> = runs.iter().map(|run| arc_and_chord(track, run).0).collect();
    let is_sharp =
        |k: usize, arc: f64, turn: f64| turn > SHARP * allowed(bend, arc, turn, length(runs[k][0].segment)).sqrt();
    let begins: HashMap<u32, usize> = runs.iter().enumerate().rev().map(|(k, run)| (run[0].segment, k)).collect();
    let mut sharp: Vec<bool> = (0..runs.len()).map(|k| is_sharp(k, arcs[k], turns[k])).collect();
    for (k, run) in runs.iter().enumerate() {
        let last = run[run.len() - 1];
        // The one after the last of a closed curve is its first.
        let wraps = || begins.get(&track.points[last.segment as usize].next).copied();
        let after = runs.get(k + 1).filter(|next| joined(track, &last, &next[0])).map(|_| k + 1).or_else(wraps);
        let after = after.filter(|&after| after != k && joined(track, &last, &runs[after][0]));
        if let Some(after) = after
            && is_sharp(k, arcs[k] + arcs[after], turns[k] + turn(track, &[last, runs[after][0]]) + turns[after])
        {
            (sharp[k], sharp[after]) = (true, true);
        }
    }
    sharp
}

/// By how much visits turn in all, one after the other, in radians.
fn turn(track: &Track, visits: &[Visit]) -> f64 {
    let at = |visit: &Visit, end: usize| {
        track.position(Near { segment: visit.segment, part: visit.part[end], distance: 0.0 })
    };
    // What is next to nothing of its segment says nothing of its direction.
    let ways = visits.iter().filter(|v| v.part[1] - v.part[0] > LEAST_PART);
    let ways = ways.filter_map(|v| (at(v, 1) - at(v, 0)).try_normalize());
    let mut last = None;
    let turns = ways.filter_map(|way| last.replace(way).map(|last: DVec3| last.angle_between(way)));
    turns.sum()
}

/// See [`turn`].
const LEAST_PART: f64 = 1e-6;

/// The smooth pieces of the tracks, from corner to corner.
struct Pieces {
    /// By segment.
    of_segment: Vec<u32>,
    /// By piece, in model units.
    lengths: Vec<f64>,
    /// By piece, its segments in their order, and whether the last leads back to the first.
    segments: Vec<(Vec<u32>, bool)>,
}

impl Pieces {
    fn new(track: &Track) -> Self {
        let count = track.points.len();
        let mut pieces = Self { of_segment: vec![0; count], lengths: Vec::new(), segments: Vec::new() };
        for whole in &track.tracks {
            let points = || whole.begin..whole.begin + whole.count;
            // From a corner on, so that a piece over the end of a closed curve is one.
            let corner = points().find(|&p| track.points[p as usize].corner);
            let begin = corner.filter(|_| whole.closed).unwrap_or(whole.begin);
            for p in (begin..whole.begin + whole.count).chain(whole.begin..begin) {
                if p == begin || track.points[p as usize].corner {
                    pieces.lengths.push(0.0);
                    pieces.segments.push((Vec::new(), whole.closed && corner.is_none()));
                }
                let piece = pieces.lengths.len() - 1;
                pieces.of_segment[p as usize] = piece as u32;
                if track.is_segment(p) {
                    pieces.lengths[piece] += length(track, p);
                    pieces.segments[piece].0.push(p);
                }
            }
        }
        pieces
    }

    /// The level of each segment: what it asks for itself, and what one nearby along its piece does.
    fn alike(&self, track: &Track, asked: &[Asked], options: &AdaptOptions) -> Vec<u32> {
        let mut levels: Vec<u32> = asked.iter().map(|asked| asked.level).collect();
        let deepest = levels.iter().copied().max().unwrap_or(0);
        for (segments, closed) in &self.segments {
            // Round a closed piece twice: what comes before its beginning is at its end.
            let rounds = if *closed { 2 } else { 1 };
            let once = || segments.iter().copied();
            let forward: Vec<u32> = (0..rounds).flat_map(|_| once()).collect();
            let backward: Vec<u32> = (0..rounds).flat_map(|_| once().rev()).collect();
            for level in options.base + 1..=deepest {
                for way in [&forward, &backward] {
                    let mut left = 0.0_f64;
                    for &p in way {
                        let Asked { level: own, edge } = asked[p as usize];
                        if own >= level {
                            // The edge of a face of `level`, which is no finer than its own.
                            left = left.max(options.alike * edge * f64::from(1_u32 << (own - level)));
                        }
                        if left > 0.0 {
                            levels[p as usize] = levels[p as usize].max(level);
                        }
                        left -= length(track, p);
                    }
                }
            }
        }
        levels
    }
}

/// The length of a segment, in model units.
fn length(track: &Track, segment: u32) -> f64 {
    let (a, b) = track.ends(segment);
    a.distance(b)
}

/// Rule 2: the faces of `level` that are to be split.
fn near(
    surface: &LoopSurface,
    corners: &CornerTable,
    track: &Track,
    options: &AdaptOptions,
    leaves: &Leaves,
    level: u32,
    finest: &[u32],
) -> Vec<FaceCode> {
    let existing = leaves.existing(&surface.mesh, level);
    let field = Field::new(surface, corners, level, &existing);
    let mesh = &field.level.mesh;
    let wanted = |segment: u32| finest[segment as usize] > level;
    let visits = track.visits(level, wanted).into_iter();
    let seeds: Vec<(u32, u32)> = visits.filter_map(|v| Some((mesh.find(v.code)?, v.segment))).collect();
    let near = spread(track, &mesh.corners, &field.limit, seeds.iter().copied(), wanted, |_| 0.0);
    let mut split: Vec<FaceCode> = seeds.iter().map(|&(face, _)| mesh.codes[face as usize]).collect();
    for (face, code) in mesh.codes.iter().enumerate() {
        if existing.binary_search(code).is_err() {
            continue;
        }
        let [a, b, c] = mesh.corners[face].map(|v| near[v as usize]);
        let corners = field.triangle(face as u32);
        let limit = options.near * size(corners);
        let middle = |i: usize, from: Option<Near>| {
            let x = 0.5 * (corners[i] + corners[(i + 1) % 3]);
            let near = from.map(|n| track.nearest(n.segment, x)).filter(|n| wanted(n.segment));
            near.map_or(f64::INFINITY, |n| n.distance)
        };
        let distances = [a, b, c].into_iter().enumerate().map(|(i, n)| {
            let own = n.map_or(f64::INFINITY, |n| n.distance);
            own.min(middle(i, n)).min(middle((i + 2) % 3, n))
        });
        if distances.fold(f64::INFINITY, f64::min) < limit {
            split.push(*code);
        }
    }
    super::super::region::ascending(split)
}
