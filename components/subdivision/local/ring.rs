//! A vertex and its neighbours, and the rules of subdivision on them.

use glam::DVec3;
use smallvec::SmallVec;

use super::Scheme;
use crate::subdivision::corner::{Pull, SpecialCorner};
use crate::subdivision::level::{Kind, LevelMesh, NONE, sample};
use crate::subdivision::masks;
use crate::subdivision::stencil::{LevelState, SectorEdge, edge_weights, flatten};
use crate::subdivision::surface::{Border, Ends};

/// A vertex and its neighbours: effective control points of one level.
#[derive(Clone, Debug)]
pub struct Ring {
    pub(super) level: u32,
    pub(super) centre: DVec3,
    /// The neighbours, counter-clockwise; on a border from the next border vertex to the previous
    /// one.
    pub(super) spokes: SmallVec<[DVec3; 8]>,
    pub(super) place: Place,
    /// The centre's entry in the table of special corners, or [`NONE`].
    pub(super) corner: u32,
    /// The neighbours that are special corners.
    pub(super) beside: SmallVec<[Beside; 2]>,
}

/// Whether a border runs through a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    Inside,
    Border(BorderPlace),
}

/// A vertex on a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BorderPlace {
    pub rule: BorderRule,
    /// The side that leaves the vertex, and how many steps of the ring's level it is from the side's
    /// beginning.
    pub leaving: (u32, u64),
    /// The side that arrives at the vertex, and how far along it the vertex is.
    pub arriving: (u32, u64),
    /// The curve's sample; zero on plain borders.
    pub sample: DVec3,
    /// The boundary details of the vertex, of the next border vertex and of the previous one.
    pub details: [DVec3; 3],
}

/// Which rule makes a border vertex of the next level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BorderRule {
    Plain,
    PlainCorner,
    Given,
    GivenCorner,
}

/// A neighbour that is a special corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Beside {
    /// Which neighbour.
    pub spoke: usize,
    /// Its entry in the table of special corners.
    pub corner: u32,
    /// Which neighbour of that corner the ring's centre is.
    pub back: usize,
}

impl Ring {
    /// The ring of vertex `v` of `mesh`, which must be whole.
    pub fn of(scheme: Scheme<'_>, mesh: &LevelMesh, state: &LevelState, v: u32) -> Self {
        let vertex = mesh.vertices[v as usize];
        let mut ring = Self {
            level: mesh.level,
            centre: state.effective[v as usize],
            spokes: SmallVec::new(),
            place: Place::Inside,
            corner: vertex.corner,
            beside: SmallVec::new(),
        };
        let (mut last, mut end) = (vertex.start, None);
        for h in mesh.ring(v) {
            ring.add_spoke(mesh, state, v, mesh.to(h));
            last = h;
        }
        if vertex.kind != Kind::Interior {
            let previous = mesh.opposite(last);
            ring.add_spoke(mesh, state, v, previous);
            end = Some(previous);
        }
        let before = crate::subdivision::level::previous(last);
        if let (Some(previous), Some(leaving), Some(arriving)) = (end, mesh.border(vertex.start), mesh.border(before)) {
            let is_corner = leaving.1 == 0 && scheme.surface.sides[leaving.0 as usize].ends == Ends::Corners;
            let rule = match (vertex.kind, is_corner) {
                (Kind::Given(_), true) => BorderRule::GivenCorner,
                (Kind::Given(_), false) => BorderRule::Given,
                (Kind::PlainCorner, _) => BorderRule::PlainCorner,
                (Kind::Plain | Kind::Interior, _) => BorderRule::Plain,
            };
            ring.place = Place::Border(BorderPlace {
                rule,
                leaving,
                arriving: (arriving.0, arriving.1 + 1),
                sample: mesh.sample(v),
                details: [v, mesh.to(vertex.start), previous].map(|v| state.detail(mesh, v)),
            });
        }
        ring
    }

    fn add_spoke(&mut self, mesh: &LevelMesh, state: &LevelState, v: u32, neighbour: u32) {
        let corner = mesh.vertices[neighbour as usize].corner;
        if corner != NONE {
            let back = mesh.neighbours(neighbour).position(|n| n == v).unwrap_or(0);
            self.beside.push(Beside { spoke: self.spokes.len(), corner, back });
        }
        self.spokes.push(state.effective[neighbour as usize]);
    }

    /// How many edges meet here.
    #[inline]
    pub(super) fn valence(&self) -> usize {
        self.spokes.len()
    }

    #[inline]
    pub(super) fn border(&self) -> Option<&BorderPlace> {
        match &self.place {
            Place::Inside => None,
            Place::Border(border) => Some(border),
        }
    }

    /// The index of the spoke `by` places after spoke `i`, counted round.
    #[inline]
    pub(super) fn turn(&self, i: usize, by: usize) -> usize {
        let (k, at) = (self.valence(), i + by);
        if at >= k { at - k } else { at }
    }

    /// Where the vertex goes.
    pub(super) fn vertex_point(&self) -> DVec3 {
        let (c, k) = (self.centre, self.valence());
        match &self.place {
            Place::Inside => {
                let beta = if k == 6 { 0.0625 } else { masks::neighbour_weight(k as u32) };
                self.sum() * beta + c * (1.0 - k as f64 * beta)
            }
            Place::Border(border) => match border.rule {
                BorderRule::Plain => (self.spokes[0] + self.spokes[k - 1]) * 0.125 + c * 0.75,
                BorderRule::PlainCorner => c,
                BorderRule::Given | BorderRule::GivenCorner => border.sample - border.details[0] * 0.25,
            },
        }
    }

    /// The sum of the neighbours, in their order.
    fn sum(&self) -> DVec3 {
        self.spokes.iter().fold(DVec3::ZERO, |sum, &p| sum + p)
    }

    /// The new vertex on the edge to neighbour `i`.
    pub(super) fn spoke_point(&self, scheme: Scheme<'_>, i: usize) -> DVec3 {
        let last = self.valence() - 1;
        if let Some(border) = self.border() {
            if i == 0 {
                return self.border_point(scheme, (border.leaving.0, 2 * border.leaving.1 + 1), 0, border.details[1]);
            }
            if i == last {
                return self.border_point(scheme, (border.arriving.0, 2 * border.arriving.1 - 1), i, border.details[2]);
            }
        }
        let wings = self.spokes[if i == 0 { last } else { i - 1 }] + self.spokes[if i == last { 0 } else { i + 1 }];
        if self.corner != NONE || !self.beside.is_empty() {
            return self.pulled_point(scheme, i, wings);
        }
        (self.centre + self.spokes[i]) * 0.375 + wings * 0.125
    }

    fn border_point(&self, scheme: Scheme<'_>, (side, step): (u32, u64), i: usize, detail: DVec3) -> DVec3 {
        match sample(&scheme.surface.sides[side as usize], self.level + 1, step) {
            Some(sample) => sample - (self.border().map_or(DVec3::ZERO, |b| b.details[0]) + detail) * 0.125,
            None => (self.centre + self.spokes[i]) * 0.5,
        }
    }

    /// As [`Self::spoke_point`] where one end of the edge, or both, is a special corner.
    fn pulled_point(&self, scheme: Scheme<'_>, i: usize, wings: DVec3) -> DVec3 {
        let entry = |corner: u32| scheme.corners.corners.get(corner as usize);
        let far = self.beside.iter().find(|b| b.spoke == i);
        let (near, far_corner) = (entry(self.corner), far.and_then(|b| entry(b.corner)));
        let [a, b] = edge_weights(near, far_corner);
        let mut point = self.centre * a + self.spokes[i] * b + wings * 0.125;
        let here = near.map(|c| (c, i, self.centre));
        let there = far.zip(far_corner).map(|(b, c)| (c, b.back, self.spokes[i]));
        let mut ends = [here, there];
        ends.sort_by_key(|end| end.map_or(u32::MAX, |(c, ..)| c.vertex.0));
        for (corner, spoke, effective) in ends.into_iter().flatten() {
            match corner.pull {
                Pull::None => {}
                Pull::Flat { .. } => point = flatten(point, corner_sample(scheme, corner), corner.pull),
                Pull::Quadratic { s } => {
                    let edge = SectorEdge::new(scheme.surface.mesh.valence(corner.vertex), spoke);
                    let given = edge.constant(scheme.surface, self.level + 1, corner, corner_sample(scheme, corner));
                    return point * (1.0 - s) + (effective * edge.corner_weight() + given) * s;
                }
            }
        }
        point
    }

    /// The ring of the same vertex one level finer; `known` are new spokes that stand already.
    pub(super) fn finer_with(&self, scheme: Scheme<'_>, known: [(usize, DVec3); 2]) -> Self {
        let stands = |i: usize| known.iter().find(|k| k.0 == i).map(|k| k.1);
        Self {
            level: self.level + 1,
            centre: self.vertex_point(),
            spokes: (0..self.valence()).map(|i| stands(i).unwrap_or_else(|| self.spoke_point(scheme, i))).collect(),
            place: match &self.place {
                Place::Inside => Place::Inside,
                Place::Border(border) => Place::Border(border.finer()),
            },
            corner: self.corner,
            beside: SmallVec::new(),
        }
    }

    /// The ring of the same vertex one level finer.
    pub(super) fn finer(&self, scheme: Scheme<'_>) -> Self {
        self.finer_with(scheme, [(usize::MAX, DVec3::ZERO); 2])
    }

    /// The limit position.
    pub(super) fn limit(&self, scheme: Scheme<'_>) -> DVec3 {
        let (c, k) = (self.centre, self.valence());
        match &self.place {
            // An edge to a special corner has another rule than the mask assumes; a step later none
            // has.
            Place::Inside if !self.beside.is_empty() => self.finer(scheme).limit(scheme),
            Place::Inside => {
                let omega = masks::limit_weight(k as u32);
                self.spokes.iter().fold(c * (1.0 - k as f64 * omega), |sum, &p| sum + omega * p)
            }
            Place::Border(border) => match border.rule {
                BorderRule::Plain => c * (2.0 / 3.0) + self.spokes[0] * (1.0 / 6.0) + self.spokes[k - 1] * (1.0 / 6.0),
                BorderRule::PlainCorner => c,
                BorderRule::Given | BorderRule::GivenCorner => border.sample,
            },
        }
    }

    /// Moves every point by `by`. Only where no curve will be read.
    pub(super) fn shift(&mut self, by: DVec3) {
        self.centre += by;
        self.spokes.iter_mut().for_each(|p| *p += by);
    }
}

impl BorderPlace {
    fn finer(&self) -> Self {
        let [own, next, previous] = self.details;
        Self {
            rule: self.rule,
            leaving: (self.leaving.0, 2 * self.leaving.1),
            arriving: (self.arriving.0, 2 * self.arriving.1),
            sample: self.sample,
            details: [own * 0.25, (own + next) * 0.125, (own + previous) * 0.125],
        }
    }

    /// The vertex that halves the border edge from this vertex to `next`; `effective` is its
    /// effective point.
    pub fn middle(&self, scheme: Scheme<'_>, next: &Self, effective: DVec3) -> Self {
        let (side, step) = self.leaving;
        let at = (side, 2 * step + 1);
        let plain = matches!(scheme.surface.sides[side as usize].border, Border::Plain);
        let details = match plain {
            true => [DVec3::ZERO; 3],
            false => [(self.details[0] + next.details[0]) * 0.125, next.details[0] * 0.25, self.details[0] * 0.25],
        };
        Self {
            rule: if plain { BorderRule::Plain } else { BorderRule::Given },
            leaving: at,
            arriving: at,
            sample: if plain { DVec3::ZERO } else { effective + details[0] },
            details,
        }
    }
}

/// The curves' point at a corner.
fn corner_sample(scheme: Scheme<'_>, corner: &SpecialCorner) -> DVec3 {
    let sides = corner.sides.map(|s| &scheme.surface.sides[s as usize]);
    sample(sides[0], 0, 0).unwrap_or_else(|| scheme.surface.points[corner.vertex.index()])
}
