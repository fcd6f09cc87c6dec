//! How far leaves are from their triangles at most, by how the surface over them stands off.

use glam::DVec3;
use selvedge_components::mesh::{FaceId, HalfedgeId};
use selvedge_components::subdivision::Deviation;

use super::assemble::Leaf;
use super::check::{Checker, SHARP};
use super::inner::Inner;
use super::known::{Known, StandOff};
use super::sample::{Piece, Place, borders};
use crate::parallel::map_dear_in_order;
use crate::subdivision::limit::Nest;

impl<'a> Checker<'a> {
    /// By vertex, how far the border is off the edges of leaves about it; empty if none is off.
    pub(super) fn off_rims(&self, known: &Known) -> Vec<f64> {
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
    pub(super) fn face_bounds(&self, face: usize, known: &Known) -> Vec<f64> {
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
