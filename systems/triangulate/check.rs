//! The finished triangles are measured both ways: from the surface to them, and from them to the surface.
//!
//! Where a leaf lies within one polynomial, this bounds its distance; elsewhere fifteen points of it and their
//! second differences do. Only leaves with no bound, where details hide between such points, or one beyond the
//! chord, are sampled; and then those that may be the farthest, so that what is reported as achieved is met at
//! a place.

use core::cell::OnceCell;

use glam::DVec3;

use super::assemble::{Around, Assembly, Leaf};
use super::known::Known;
use super::measure::Facet;
use super::sample::{Farthest, Grid, Sampled, is_beyond};
use super::{QUANTUM, Subject, quantum};
use crate::parallel::map_dear_in_order;
use crate::subdivision::limit::Nest;

/// Of leaves that must be sampled anyway, distances up to this part of the chord are not told apart: what
/// lies below does not decide, and is seldom the farthest.
pub(super) const SHARP: f64 = 0.8;

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

/// A leaf that was measured.
#[derive(Clone, Copy, Debug)]
struct Measured {
    farthest: Farthest,
    /// By its own triangles alone?
    alone: bool,
}

/// What measuring reads.
pub(super) struct Checker<'a> {
    pub(super) subject: &'a Subject,
    pub(super) assembly: &'a Assembly,
    pub(super) chord: f64,
    pub(super) around: &'a Around,
    pub(super) normals: &'a [DVec3],
    pub(super) off_rim: &'a [f64],
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
}
