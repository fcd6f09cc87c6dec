//! Limit points of a patch on a lattice, all at once.
//!
//! Points that divide the edges of a face by a power of two are vertices of a subdivision of it. Quartering
//! the face as a whole costs each of them a few sums; going to each by quarters of quarters costs three
//! rings a step.

use glam::DVec3;
use smallvec::SmallVec;

use super::patch::Patch;
use super::ring::{self, Beside, Ring};
use crate::subdivision::level::{NONE, sample};
use crate::subdivision::surface::Border;

/// Limit points of a face where the weights of its corners are whole multiples of `1 / steps`.
#[derive(Clone, Debug, Default)]
pub struct PatchLattice {
    steps: usize,
    /// Row by row: `(i, j)` steps towards the second and third corner, `i` by row.
    points: Vec<DVec3>,
}

/// Steps towards the second and third corner.
type Place = (isize, isize);

/// The directions from corner `c` to the next and to the
/// one after.
const ALONG: [[Place; 2]; 3] = [[(1, 0), (0, 1)], [(-1, 1), (-1, 0)], [(0, -1), (1, -1)]];

/// ... and across the edges in these directions: to the neighbours before the first and after the second.
const ACROSS: [[Place; 2]; 3] = [[(1, -1), (-1, 1)], [(0, 1), (0, -1)], [(-1, 0), (1, 0)]];

impl PatchLattice {
    /// The finest lattice: `2^10` steps along an edge, half a million points.
    pub const DEEPEST: u32 = 10;

    /// The lattice of `patch` with `2^depth` steps along an edge, [`Self::DEEPEST`] at most.
    ///
    /// Positions are those of [`Patch::position`] up to rounding; on a given border the curve's own
    /// points to the bit.
    pub fn new(patch: &Patch<'_>, depth: u32) -> Self {
        let depth = depth.min(Self::DEEPEST);
        let steps = 1 << depth;
        let mut net = ControlLattice::new(patch);
        (0..depth).for_each(|_| net = net.finer());
        let mut points = Vec::with_capacity((steps + 1) * (steps + 2) / 2);
        for i in 0..=steps as isize {
            points.extend((0..=steps as isize - i).map(|j| net.limit((i, j))));
        }
        Self { steps, points }
    }

    /// Steps along an edge; 0 for no lattice.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// The limit point `i` steps towards the second and `j` towards the third corner; `i + j` is
    /// [`Self::steps`] at most.
    #[inline]
    pub fn point(&self, i: usize, j: usize) -> DVec3 {
        // Row i' has steps + 1 - i' points.
        self.points[i * (self.steps + 1) - i * i.saturating_sub(1) / 2 + j]
    }
}

/// Control points over a face some steps down, and one row of them beyond each edge that is not a border.
struct ControlLattice<'a> {
    patch: &'a Patch<'a>,
    steps: usize,
    /// Point `(i, j)`, from -1 to `steps + 1`, stands at `(i + 1) * (steps + 3) + j + 1`. What is beyond a
    /// border or a corner is never read but where the result is replaced.
    points: Vec<DVec3>,
    /// Those of the corners.
    rings: [Ring; 3],
    borders: [Option<BorderRow>; 3],
}

/// An edge of the face that lies on a border.
struct BorderRow {
    side: u32,
    /// How many steps of `level` the edge begins from the beginning of the side.
    begin: u64,
    level: u32,
    /// Of a given border, by vertex, the curve's sample and the boundary detail.
    given: Option<Vec<[DVec3; 2]>>,
}

impl<'a> ControlLattice<'a> {
    fn new(patch: &'a Patch<'a>) -> Self {
        let borders = [0, 1, 2].map(|c| BorderRow::of(patch, c));
        let mut lattice = Self { patch, steps: 1, points: vec![DVec3::ZERO; 16], rings: patch.rings.clone(), borders };
        for (c, ring) in patch.rings.iter().enumerate() {
            let (corner, [beyond, _]) = (lattice.corner(c), ACROSS[c]);
            lattice.put(corner, ring.centre);
            if lattice.borders[c].is_none() {
                lattice.put(moved(corner, beyond), ring.spokes[ring.turn(patch.at[c], ring.valence() - 1)]);
            }
        }
        lattice
    }

    /// Where corner `c` stands.
    fn corner(&self, c: usize) -> Place {
        let n = self.steps as isize;
        [(0, 0), (n, 0), (0, n)][c]
    }

    fn index(&self, (i, j): Place) -> usize {
        ((i + 1) * self.row() as isize + j + 1) as usize
    }

    /// From a point to the one a step towards the second corner.
    fn row(&self) -> usize {
        self.steps + 3
    }

    fn at(&self, place: Place) -> DVec3 {
        self.points[self.index(place)]
    }

    fn put(&mut self, place: Place, point: DVec3) {
        let at = self.index(place);
        self.points[at] = point;
    }

    /// The sum of the six neighbours of a point inside.
    #[inline]
    fn around(&self, at: usize) -> DVec3 {
        let (p, row) = (&self.points, self.row());
        (p[at + 1] + p[at - 1]) + (p[at + row] + p[at - row]) + (p[at + row - 1] + p[at - row + 1])
    }

    /// One step of subdivision: everything by the rules inside, then borders and corners by theirs.
    fn finer(&self) -> Self {
        let steps = 2 * self.steps;
        let mut finer = Self {
            patch: self.patch,
            steps,
            points: vec![DVec3::ZERO; (steps + 3) * (steps + 3)],
            borders: [0, 1, 2].map(|c| self.borders[c].as_ref().map(|row| row.finer(self))),
            rings: self.rings.clone(),
        };
        let (n, row, p) = (steps as isize, self.row(), &self.points);
        let edge =
            |from: usize, to: usize, wings: [usize; 2]| (p[from] + p[to]) * 0.375 + (p[wings[0]] + p[wings[1]]) * 0.125;
        for i in -1..=n {
            // One row beyond each edge, and nothing beyond the corners.
            let (first, last) = match i {
                -1 => (1, n),
                0 => (0, n),
                _ => (-1, n - i + 1),
            };
            let (to, from) = (finer.index((i, 0)), self.index((i.div_euclid(2), 0)));
            for j in first..=last {
                let at = (from as isize + j.div_euclid(2)) as usize;
                finer.points[(to as isize + j) as usize] = match (i & 1, j & 1) {
                    (0, 0) => p[at] * 0.625 + self.around(at) * 0.0625,
                    (1, 0) => edge(at, at + row, [at + 1, at + row - 1]),
                    (0, _) => edge(at, at + 1, [at + row, at - row + 1]),
                    _ => edge(at + 1, at + row, [at, at + row + 1]),
                };
            }
        }
        (0..3).for_each(|c| finer.follow_border(self, c));
        (0..3).for_each(|c| finer.follow_corner(&self.rings[c], c));
        finer
    }

    /// The points on edge `c`, if that lies on a border.
    fn follow_border(&mut self, coarse: &Self, c: usize) {
        let Some(border) = &self.borders[c] else { return };
        let along = |lattice: &Self, t: usize| {
            let ((i, j), (di, dj), t) = (lattice.corner(c), ALONG[c][0], t as isize);
            (i + t * di, j + t * dj)
        };
        let points: Vec<DVec3> = match &border.given {
            Some(given) => given.iter().map(|[sample, detail]| *sample - *detail).collect(),
            None => {
                let p = |t: usize| coarse.at(along(coarse, t));
                let inner = |t: usize| match (t % 2, t / 2) {
                    (1, t) => (p(t) + p(t + 1)) * 0.5,
                    // The ends are corners: those follow.
                    (_, t) if t == 0 || t == coarse.steps => p(t),
                    (_, t) => p(t) * 0.75 + (p(t - 1) + p(t + 1)) * 0.125,
                };
                (0..=self.steps).map(inner).collect()
            }
        };
        for (t, point) in points.into_iter().enumerate() {
            self.put(along(self, t), point);
        }
    }

    /// Corner `c` and the neighbours of it that are here, of which those on borders stand already.
    fn follow_corner(&mut self, ring: &Ring, c: usize) {
        let (at, corner) = (self.patch.at[c], self.corner(c));
        let last = (c + 2) % 3;
        let spokes = [at, ring.turn(at, 1)];
        let on_border = [self.borders[c].is_some(), self.borders[last].is_some()];
        let known = [0, 1].map(|k| match on_border[k] {
            true => (spokes[k], self.at(moved(corner, ALONG[c][k]))),
            false => (usize::MAX, DVec3::ZERO),
        });
        let finer = ring.finer_with(self.patch.scheme, known);
        self.put(corner, finer.centre);
        for k in 0..2 {
            self.put(moved(corner, ALONG[c][k]), finer.spokes[spokes[k]]);
            if !on_border[k] {
                let beyond = if k == 0 { ring.turn(at, ring.valence() - 1) } else { ring.turn(at, 2) };
                self.put(moved(corner, ACROSS[c][k]), finer.spokes[beyond]);
            }
        }
        self.rings[c] = finer;
    }

    fn limit(&self, place: Place) -> DVec3 {
        let scheme = self.patch.scheme;
        if let Some(c) = (0..3).find(|&c| self.corner(c) == place) {
            return self.rings[c].limit(scheme);
        }
        let (at, n) = (self.index(place), self.steps as isize);
        let on_edge = [place.1 == 0, place.0 + place.1 == n, place.0 == 0];
        let border = (0..3).find_map(|c| self.borders[c].as_ref().filter(|_| on_edge[c]).map(|row| (c, row)));
        let Some((c, border)) = border else {
            let beside = self.special_corners_beside(place);
            if !beside.is_empty() {
                return self.ring_inside(place, beside).limit(scheme);
            }
            return self.points[at] * 0.5 + self.around(at) * (1.0 / 12.0);
        };
        if let Some(given) = &border.given {
            let t = [place.0, place.1, n - place.1][c];
            return given[t as usize][0];
        }
        let (di, dj) = ALONG[c][0];
        let sides = self.at(moved(place, (di, dj))) + self.at(moved(place, (-di, -dj)));
        self.points[at] * (2.0 / 3.0) + sides * (1.0 / 6.0)
    }
}

/// The directions to the neighbours of a point inside, counter-clockwise.
const AROUND: [Place; 6] = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)];

impl ControlLattice<'_> {
    /// The corners beside a point whose edges have rules of their own: the mask does not know of them.
    fn special_corners_beside(&self, place: Place) -> SmallVec<[Beside; 2]> {
        let mut beside = SmallVec::new();
        for (c, ring) in self.rings.iter().enumerate().filter(|(_, ring)| ring.corner != NONE) {
            let ((i, j), at) = (self.corner(c), self.patch.at[c]);
            for (direction, back) in ALONG[c].into_iter().zip([at, ring.turn(at, 1)]) {
                let spoke = AROUND.iter().position(|&(di, dj)| (-di, -dj) == direction);
                if let Some(spoke) = spoke.filter(|_| moved((i, j), direction) == place) {
                    beside.push(Beside { spoke, corner: ring.corner, back });
                }
            }
        }
        beside
    }

    /// The ring of a point on no border that is no corner.
    fn ring_inside(&self, place: Place, beside: SmallVec<[Beside; 2]>) -> Ring {
        Ring {
            level: self.rings[0].level,
            centre: self.at(place),
            spokes: AROUND.iter().map(|&way| self.at(moved(place, way))).collect(),
            place: ring::Place::Inside,
            corner: NONE,
            beside,
        }
    }
}

impl BorderRow {
    /// Edge `c` of `patch`, if it lies on a border.
    fn of(patch: &Patch<'_>, c: usize) -> Option<Self> {
        let (from, to) = (&patch.rings[c], &patch.rings[(c + 1) % 3]);
        let (border, next) = (from.border().filter(|_| patch.is_border_edge(c))?, to.border()?);
        let (side, begin) = border.leaving;
        let is_given = matches!(patch.scheme.surface.sides[side as usize].border, Border::Given { .. });
        let given = is_given.then(|| [border, next].map(|b| [b.sample, b.details[0]]).to_vec());
        Some(Self { side, begin, level: from.level, given })
    }

    /// One step finer.
    fn finer(&self, lattice: &ControlLattice<'_>) -> Self {
        let (level, begin) = (self.level + 1, 2 * self.begin);
        let side = &lattice.patch.scheme.surface.sides[self.side as usize];
        let halved = |given: &Vec<[DVec3; 2]>| {
            let mut finer = Vec::with_capacity(2 * given.len() - 1);
            for (t, pair) in given.windows(2).enumerate() {
                let [[here, detail], [there, next]] = [pair[0], pair[1]];
                let middle = sample(side, level, begin + 2 * t as u64 + 1);
                // A side that has samples at all has them everywhere.
                let middle = middle.unwrap_or((here + there) * 0.5);
                finer.extend([[here, detail * 0.25], [middle, (detail + next) * 0.125]]);
            }
            finer.extend(given.last().map(|&[sample, detail]| [sample, detail * 0.25]));
            finer
        };
        Self { side: self.side, begin, level, given: self.given.as_ref().map(halved) }
    }
}

fn moved(from: Place, by: Place) -> Place {
    (from.0 + by.0, from.1 + by.1)
}
