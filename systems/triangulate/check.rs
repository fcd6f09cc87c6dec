//! The finished triangles are measured both ways: from the surface to them, and from them to the surface.
//!
//! Where a leaf lies within one polynomial, this bounds its distance; elsewhere fifteen points of it and their
//! second differences do. Only leaves with no bound, where details hide between such points, or one beyond the
//! chord, are sampled; and then those that may be the farthest, so that what is reported as achieved is met at
//! a place.

use core::cell::OnceCell;
use std::collections::HashMap;

use glam::DVec3;
use selvedge_components::mesh::{FaceId, HalfedgeId};
use selvedge_components::subdivision::Deviation;

use super::assemble::{Around, Assembly, Leaf, LeafKey};
use super::inner::Inner;
use super::measure::Facet;
use super::sample::{Farthest, Grid, Piece, Place, Sampled, borders, is_beyond};
use super::{QUANTUM, Subject, quantum};
use crate::parallel::map_dear_in_order;
use crate::subdivision::limit::Nest;

/// Of leaves that must be sampled anyway, distances up to this part of the chord are not told apart: what
/// lies below does not decide, and is seldom the farthest.
const SHARP: f64 = 0.8;

/// How many leaves are measured at a time to find the farthest: few at first, since they tell how many
/// more must be, and then enough for every core.
const AT_A_TIME: [usize; 2] = [64, 512];

/// Finished triangles that are being measured.
#[derive(Debug)]
pub struct CheckWork {
    assembly: Assembly,
    around: Around,
    /// The unit normals of the triangles; zero without an area.
    normals: Vec<DVec3>,
    /// By vertex, how far the border is off the edges of leaves about it; empty if none is off.
    off_rim: Vec<f64>,
    weights: Vec<[f64; 3]>,
    /// By leaf, of the first root faces: no point of it is farther from the triangles than this, or the
    /// other way round; infinite where details hide between the points that would tell.
    bounds: Vec<f64>,
    /// By leaf, the farthest point that was found.
    found: Vec<Option<Farthest>>,
    stage: Stage,
}

/// What is to be done next.
#[derive(Debug)]
enum Stage {
    /// What is around the triangles.
    Around,
    /// How far borders are off the triangles.
    Rims,
    /// The bounds of the leaves of this root face and those after it.
    Bound(usize),
    /// Leaves to be measured for their bounds are beyond the chord, and how many of them are; first those that
    /// have a bound, then `others`.
    Measure { due: Vec<usize>, measured: usize, others: bool },
    /// Leaves that may be the farthest, with the most that they may be; the farthest so far, and how many to
    /// measure at once.
    Farthest { open: Vec<(f64, usize)>, most: f64, at_a_time: usize },
}

/// What measuring a leaf costs beside a bound.
const MEASURED: usize = 16;

impl CheckWork {
    /// Begins with triangles of which nothing is known.
    pub fn new(assembly: Assembly) -> Self {
        Self {
            around: Around::default(),
            normals: Vec::new(),
            off_rim: Vec::new(),
            weights: Grid::Ninths.weights(),
            bounds: Vec::with_capacity(assembly.leaves.len()),
            found: vec![None; assembly.leaves.len()],
            assembly,
            stage: Stage::Around,
        }
    }

    fn checker<'a>(&'a self, subject: &'a Subject, chord: f64) -> Checker<'a> {
        let Self { assembly, around, normals, off_rim, weights, .. } = self;
        Checker { subject, assembly, chord, around, normals, off_rim, weights }
    }

    /// Takes the next step, and adds to `spent` what it costs. `true` once there is a verdict.
    ///
    /// If a leaf fails that is to be quartered, those which cost more are not measured: they are when the
    /// next forest has its triangles.
    pub fn advance(
        &mut self,
        subject: &Subject,
        chord: f64,
        last_level: u32,
        known: &mut Known,
        spent: &mut usize,
    ) -> bool {
        let checker = self.checker(subject, chord);
        match &self.stage {
            Stage::Around => {
                (self.around, self.normals) = (self.assembly.around(), self.assembly.normals());
                *spent += self.assembly.triangle_count() / 16;
                self.stage = Stage::Rims;
                false
            }
            Stage::Rims => {
                let off_rim = checker.off_rims(known);
                *spent += off_rim.len() / 16;
                (self.off_rim, self.stage) = (off_rim, Stage::Bound(0));
                false
            }
            &Stage::Bound(first) => {
                let faces = subject.surface.mesh.face_count();
                let (end, leaves) = quantum(first, faces, |f| self.assembly.leaves_of(f).len());
                let bounds = map_dear_in_order(end - first, |f| checker.face_bounds(first + f, known));
                *spent += leaves;
                bounds.into_iter().for_each(|bounds| self.bounds.extend(bounds));
                self.stage = if end < faces { Stage::Bound(end) } else { self.due(chord, false) };
                false
            }
            &Stage::Measure { ref due, measured, .. } if measured < due.len() => {
                let end = due.len().min(measured + QUANTUM / MEASURED);
                let new = checker.measure(&due[measured..end], known, SHARP * chord);
                *spent += MEASURED * (end - measured);
                for (i, new) in new {
                    self.found[i] = Some(new.farthest);
                    if new.alone {
                        known.alone.insert(self.assembly.leaves[i].key(), new.farthest);
                    }
                }
                if let Stage::Measure { measured, .. } = &mut self.stage {
                    *measured = end;
                }
                false
            }
            &Stage::Measure { others, .. } => {
                let fails = |(leaf, found): (&Leaf, &Option<Farthest>)| {
                    leaf.place.level < last_level && found.is_some_and(|found| is_beyond(&found, chord))
                };
                if self.assembly.leaves.iter().zip(&self.found).any(fails) {
                    return true;
                }
                self.stage = if others { self.may_be_farthest() } else { self.due(chord, true) };
                false
            }
            Stage::Farthest { open, .. } if open.is_empty() => true,
            Stage::Farthest { .. } => {
                *spent += MEASURED * self.find_farther(subject, chord);
                false
            }
        }
    }

    /// The leaves that are to be measured for their bounds are beyond the chord: those that have one, or the
    /// `others`.
    fn due(&self, chord: f64, others: bool) -> Stage {
        let is_due = |&i: &usize| self.bounds[i] > chord && self.bounds[i].is_finite() != others;
        Stage::Measure { due: (0..self.bounds.len()).filter(is_due).collect(), measured: 0, others }
    }

    /// All leaves, for no other is known to be farther off yet.
    fn may_be_farthest(&self) -> Stage {
        let at_most = |i: usize| self.found[i].as_ref().map_or(self.bounds[i], distance);
        let open = (0..self.bounds.len()).map(|i| (at_most(i), i)).filter(|open| open.0 > 0.0).collect();
        Stage::Farthest { open, most: 0.0, at_a_time: AT_A_TIME[0] }
    }

    /// Measures those of the leaves which may be the farthest that may be so the most. What was measured
    /// already was from above. Returns how many.
    fn find_farther(&mut self, subject: &Subject, chord: f64) -> usize {
        let Stage::Farthest { open, most, at_a_time } = &mut self.stage else { return 0 };
        let (mut open, mut most, count) = (core::mem::take(open), *most, *at_a_time);
        let first = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if open.len() > count {
            open.select_nth_unstable_by(count, first);
        }
        let mut rest = open.split_off(open.len().min(count));
        open.sort_unstable_by(first);
        let (checker, leaf) = (self.checker(subject, chord), |k: usize| &self.assembly.leaves[open[k].1]);
        let measured = map_dear_in_order(open.len(), |k| {
            checker.farthest(&mut Nest::new(&subject.limit, leaf(k).place.root()), leaf(k), most, most).farthest
        });
        for (&(_, i), measured) in open.iter().zip(measured) {
            most = most.max(distance(&measured));
            self.found[i] = Some(measured);
        }
        rest.retain(|&(at_most, _)| at_most > most);
        self.stage = Stage::Farthest { open: rest, most, at_a_time: AT_A_TIME[1] };
        open.len()
    }

    /// The triangles, and by leaf the farthest point that was found: nothing where a bound lies within the chord
    /// and below the farthest of all.
    pub fn finish(self) -> (Assembly, Vec<Farthest>) {
        (self.assembly, self.found.into_iter().map(Option::unwrap_or_default).collect())
    }
}

/// How far off a point is.
fn distance(found: &Farthest) -> f64 {
    found.squared.sqrt()
}

/// What is known of leaves, whatever the forest around them.
#[derive(Debug, Default)]
pub struct Known {
    /// What was measured by their own triangles alone: it holds in the next forest, too, for those that are
    /// still there and cut as they were.
    alone: HashMap<LeafKey, Farthest>,
    /// How they stand off, of those in root faces that are no polynomials: by root face, along the paths of
    /// quarters.
    stand_off: HashMap<FaceId, Vec<(Place, Deviation)>>,
}

impl Known {
    /// Adds how leaves of a root face stand off.
    pub fn learn(&mut self, root: FaceId, stand_off: Vec<(Place, Deviation)>) {
        if !stand_off.is_empty() {
            let all = self.stand_off.entry(root).or_default();
            all.extend(stand_off);
            all.sort_unstable_by_key(|(place, _)| place.along_paths());
        }
    }

    /// How leaves of a root face stand off, as far as that is known.
    fn stand_off(&self, root: FaceId) -> StandOff<'_> {
        StandOff(self.stand_off.get(&root).map_or(&[], Vec::as_slice))
    }
}

/// How some leaves of a root face stand off, along the paths of quarters.
struct StandOff<'a>(&'a [(Place, Deviation)]);

impl StandOff<'_> {
    /// How this leaf does, which comes after all that were asked for before.
    fn of(&mut self, leaf: Place) -> Option<Deviation> {
        while let [(place, deviation), rest @ ..] = self.0
            && place.along_paths() <= leaf.along_paths()
        {
            self.0 = rest;
            if *place == leaf {
                return Some(*deviation);
            }
        }
        None
    }
}

/// A leaf that was measured.
#[derive(Clone, Copy, Debug)]
struct Measured {
    farthest: Farthest,
    /// By its own triangles alone?
    alone: bool,
}

/// What measuring reads.
struct Checker<'a> {
    subject: &'a Subject,
    assembly: &'a Assembly,
    chord: f64,
    around: &'a Around,
    normals: &'a [DVec3],
    off_rim: &'a [f64],
    weights: &'a [[f64; 3]],
}

impl<'a> Checker<'a> {
    /// Measures the leaves that are `due`, ascending, unless they are `known`. Distances up to `enough` are not
    /// told apart.
    fn measure(&self, due: &[usize], known: &Known, enough: f64) -> Vec<(usize, Measured)> {
        let root = |i: usize| self.assembly.leaves[i].place.root();
        // Leaves of one root face share its nest.
        let faces: Vec<&[usize]> = due.chunk_by(|&a, &b| root(a) == root(b)).collect();
        let measured = map_dear_in_order(faces.len(), |f| {
            let mut nest = Nest::new(&self.subject.limit, root(faces[f][0]));
            let measured = |&i: &usize| {
                let leaf = &self.assembly.leaves[i];
                let known = known.alone.get(&leaf.key()).map(|&farthest| Measured { farthest, alone: true });
                (i, known.unwrap_or_else(|| self.farthest(&mut nest, leaf, enough, self.chord)))
            };
            faces[f].iter().map(measured).collect::<Vec<_>>()
        });
        measured.into_iter().flatten().collect()
    }

    /// Measures a leaf. Distances up to `enough` are not told apart, and those of its triangles up to `sharp`
    /// may be less than is told.
    fn farthest(&self, nest: &mut Nest<'a>, leaf: &Leaf, enough: f64, sharp: f64) -> Measured {
        let mut sampled = Sampled::new(self.subject, nest, leaf.place);
        let (own, around) = (self.assembly.own(leaf), OnceCell::new());
        let near = |x: DVec3| {
            let squared = own(x);
            if squared <= enough * enough {
                return squared;
            }
            // Where the surface slides, the foot may lie beyond the leaf's own triangles.
            let around: &Vec<Facet> = around.get_or_init(|| self.assembly.beyond(self.around, leaf));
            around.iter().map(|facet| facet.squared(x)).fold(squared, f64::min)
        };
        let there = sampled.farthest(self.weights, f64::INFINITY, near);
        let farthest = there.or(sampled.farthest_back(&self.assembly.pieces(leaf), enough, sharp));
        // A distance beyond may be to a triangle that is quartered next.
        Measured { farthest, alone: around.get().is_none() && !is_beyond(&farthest, enough) }
    }

    /// By vertex, how far the border is off the edges of leaves about it; empty if none is off.
    fn off_rims(&self, known: &Known) -> Vec<f64> {
        let mesh = &*self.subject.surface.mesh;
        let root = |f: usize| FaceId::new(f);
        let on_border = |f: &usize| (0..3).any(|c| mesh.twin(HalfedgeId::of(root(*f), c)).is_none());
        let faces: Vec<usize> = (0..mesh.face_count()).filter(on_border).collect();
        let rims = map_dear_in_order(faces.len(), |k| {
            let mut nest = Nest::new(&self.subject.limit, root(faces[k]));
            let mut known = known.stand_off(root(faces[k]));
            let mut rims = Vec::new();
            for leaf in &self.assembly.leaves[self.assembly.leaves_of(faces[k])] {
                let borders = borders(self.subject, leaf.place);
                if borders.contains(&true) {
                    let deviation = self.deviation(&mut nest, leaf.place, &mut known);
                    let off = |e: usize| deviation.map_or(f64::INFINITY, |deviation| self.off_rim(leaf, &deviation, e));
                    rims.extend((0..3).filter(|&e| borders[e]).map(|e| (leaf.edges()[e], off(e))));
                }
            }
            rims
        });
        let mut off_rim = vec![0.0_f64; if faces.is_empty() { 0 } else { self.assembly.vertex_count() }];
        for (ends, off) in rims.into_iter().flatten() {
            ends.iter().for_each(|&v| off_rim[v as usize] = off_rim[v as usize].max(off));
        }
        off_rim
    }

    /// The bounds of the leaves of a root face: their distances to the places with the same weights, or, where
    /// these are beyond the chord or not far below it, so that the leaf may be the farthest, what heights say.
    fn face_bounds(&self, face: usize, known: &Known) -> Vec<f64> {
        let root = FaceId::new(face);
        let (mut nest, mut known) = (Nest::new(&self.subject.limit, root), known.stand_off(root));
        let mut bound = |leaf: &Leaf| {
            let Some(deviation) = self.deviation(&mut nest, leaf.place, &mut known) else { return f64::INFINITY };
            let straight = if self.assembly.triangles_of(leaf).len() == 1 {
                greater(0.0, deviation.greatest())
            } else {
                let pieces = self.assembly.pieces(leaf);
                let straight = pieces.iter().map(|piece| deviation.of_piece(piece.map(|(_, w)| w)).greatest());
                straight.fold(0.0, greater)
            };
            if straight > SHARP * self.chord { straight.min(self.sliding_leaf(leaf, &deviation)) } else { straight }
        };
        self.assembly.leaves[self.assembly.leaves_of(face)].iter().map(&mut bound).collect()
    }

    /// How far the border over edge `edge` of a leaf is off it, across it in the leaf's plane.
    fn off_rim(&self, leaf: &Leaf, deviation: &Deviation, edge: usize) -> f64 {
        let corners = leaf.edges().map(|[from, _]| self.assembly.position(from));
        let [a, b, c] = [0, 1, 2].map(|k| corners[(edge + k) % 3]);
        let across = (b - a).cross((b - a).cross(c - a)).normalize_or_zero();
        if across == DVec3::ZERO { f64::INFINITY } else { deviation.off_edge(edge, across) }
    }

    /// The bound of a leaf that the surface slides along.
    fn sliding_leaf(&self, leaf: &Leaf, deviation: &Deviation) -> f64 {
        let mut triangles = self.assembly.triangles_of(leaf);
        if triangles.len() == 1 {
            return greater(0.0, triangles.next().map_or(f64::INFINITY, |t| self.sliding(deviation, t)));
        }
        let of_piece = |(t, piece): (u32, &Piece)| {
            let deviation = deviation.of_piece(piece.map(|(_, w)| w));
            deviation.greatest().min(self.sliding(&deviation, t))
        };
        triangles.zip(&self.assembly.pieces(leaf)).map(of_piece).fold(0.0, greater)
    }

    /// How a leaf stands off the triangle of its corners; `None` where details hide.
    fn deviation(&self, nest: &mut Nest<'a>, place: Place, known: &mut StandOff<'_>) -> Option<Deviation> {
        if let Some(deviation) = known.of(place) {
            return Some(deviation);
        }
        let spot = nest.spot(place.level, place.code);
        if let Some(quartic) = nest.quartic(spot) {
            return Some(Inner::new(place, spot.level).deviation(quartic));
        }
        let hides = self.subject.reach.moves_below(place.level, place.code);
        (!hides).then(|| Deviation::of_points(&nest.quarter_points(spot, false)))
    }

    /// The same for the part of a leaf over triangle `t`, which it stands off by `deviation`, where the
    /// surface slides along the triangle: what its heights bound.
    ///
    /// A foot beyond an edge is over a neighbour, or over another triangle at a corner, and as high over
    /// that as over this, but for how far it is beyond, times the sine of the angle between the two. Nor is
    /// any point of a triangle farther off: the surface over the triangles around hangs together, and so
    /// do its feet, which leave none of the triangle out. Over a border there is no neighbour: what is beyond
    /// it lies between its edges and the border itself, which is off them by `off_rim` about each vertex.
    fn sliding(&self, deviation: &Deviation, t: u32) -> f64 {
        let (corners, normal) = (self.assembly.corners(t), self.normals[t as usize]);
        if normal == DVec3::ZERO {
            return f64::INFINITY;
        }
        let (mut squared, mut across) = (0.0_f64, 0.0_f64);
        for v in self.assembly.triangle(t) {
            across = across.max(self.off_rim.get(v as usize).copied().unwrap_or(0.0));
            for &other in self.around.of(v) {
                let other = self.normals[other as usize];
                // A triangle that faces away is no neighbour to slide to; nor is one without a normal.
                let turned = normal.dot(other) <= 0.0;
                squared = squared.max(if turned { f64::INFINITY } else { normal.cross(other).length_squared() });
            }
        }
        let bend = squared.sqrt();
        let high = (0..3).map(|e| {
            let [a, b, c] = [0, 1, 2].map(|k| corners[(e + k) % 3]);
            let outward = (b - a).cross(normal).normalize_or_zero();
            let [beyond, high] = deviation.beyond(e, outward, outward.dot(a - c), normal);
            high + bend * beyond
        });
        high.fold(deviation.along(normal), greater).hypot(across)
    }
}

/// The greater bound; what is no number bounds nothing.
fn greater(a: f64, b: f64) -> f64 {
    if b.is_nan() { f64::INFINITY } else { a.max(b) }
}
