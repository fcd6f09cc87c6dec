//! How far the limit surface of a leaf stands off the triangles that stand for it.

use glam::DVec3;
use selvedge_components::evaluate::{Evaluate, SurfacePoint};
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::{FaceCode, Patch, Scheme};
use smallvec::SmallVec;

use super::Subject;
use super::measure::squared_to_segment;
use super::pyramid::{Floor, Pyramid};
use crate::foot;
use crate::parallel::map_in_order;
use crate::subdivision::chain::Level;
use crate::subdivision::limit::regular_net;

/// Where a leaf is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// To decide: the fifteen points that divide its edges by four.
    Quarters,
    /// To check: the 55 points that divide its edges by nine, the centre among them; of the fifteen,
    /// only the corners.
    Ninths,
}

impl Grid {
    /// All its points but the corners, as the weights of these.
    fn weights(self) -> Vec<[f64; 3]> {
        let n = match self {
            Self::Quarters => 4,
            Self::Ninths => 9,
        };
        let all = (0..=n).flat_map(|i| (0..=n - i).map(move |j| [n - i - j, i, j]));
        let inner = all.filter(|steps| !steps.contains(&n));
        inner.map(|steps| steps.map(|i| f64::from(i) / f64::from(n))).collect()
    }
}

/// The point found farthest off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Farthest {
    /// Squared distance to the triangles.
    pub squared: f64,
    /// The point of the limit surface.
    pub at: DVec3,
    /// How many points were measured.
    pub samples: usize,
}

impl Farthest {
    fn see(&mut self, x: DVec3, squared: f64) {
        self.samples += 1;
        // Coordinates whose squares overflow give no number: that counts as far.
        if squared > self.squared || squared.is_nan() {
            (self.squared, self.at) = (squared, x);
        }
    }

    /// The farther one; this one where both are as far.
    pub fn or(self, other: Self) -> Self {
        let samples = self.samples + other.samples;
        Self { samples, ..if other.squared > self.squared || other.squared.is_nan() { other } else { self } }
    }
}

/// A leaf: its level, and its place in [`Floor::faces`].
pub type LeafPlace = (usize, usize);

/// The leaves of `pyramid`, by level and in their order.
pub fn leaves(pyramid: &Pyramid) -> Vec<LeafPlace> {
    let places = |(l, floor): (usize, &Floor)| (0..floor.faces.len()).map(move |place| (l, place));
    pyramid.floors.iter().enumerate().flat_map(places).collect()
}

/// For each of `leaves`: the sample of the limit surface that is farthest off. `near` is asked for a
/// leaf, and answers with the squared distance of a point to the triangles that stand for it.
pub fn farthest<D: Fn(DVec3) -> f64>(
    subject: &Subject,
    pyramid: &Pyramid,
    leaves: &[LeafPlace],
    grid: Grid,
    near: impl Fn(LeafPlace) -> D + Sync,
) -> Vec<Farthest> {
    let weights = grid.weights();
    map_in_order(leaves.len(), |i| Leaf::new(subject, pyramid, leaves[i]).farthest(&weights, near(leaves[i])))
}

/// For each of `leaves`: the point of its triangles that is farthest from the limit surface, of those
/// that are farther than `limit`. `pieces` answers with the triangles.
///
/// The point of the surface with the same weights is no nearer than the foot: where it is within the
/// limit already, the foot is not looked for.
pub fn farthest_back(
    subject: &Subject,
    pyramid: &Pyramid,
    leaves: &[LeafPlace],
    limit: f64,
    pieces: impl Fn(LeafPlace) -> Pieces + Sync,
) -> Vec<Farthest> {
    map_in_order(leaves.len(), |i| Leaf::new(subject, pyramid, leaves[i]).farthest_back(&pieces(leaves[i]), limit))
}

/// A triangle on a leaf: its corners, each with its weights on the leaf.
pub type Piece = [(DVec3, [f64; 3]); 3];

/// The triangles of a leaf.
pub type Pieces = SmallVec<[Piece; 4]>;

/// Where a triangle is asked how far the surface is: its centre, and halfway from there to its corners
/// and to the middles of its edges.
const INSIDE: [[f64; 3]; 7] = {
    let (far, near) = (2.0 / 3.0, 1.0 / 6.0);
    let edge = 5.0 / 12.0;
    [
        [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0],
        [far, near, near],
        [near, far, near],
        [near, near, far],
        [edge, edge, near],
        [near, edge, edge],
        [edge, near, edge],
    ]
};

/// A face of a level mesh that is sampled.
struct Leaf<'a> {
    subject: &'a Subject<'a>,
    floor: &'a Floor,
    face: u32,
    code: FaceCode,
    corners: [DVec3; 3],
}

/// What evaluates a leaf.
#[expect(clippy::large_enum_variant, reason = "one is made per leaf, on the stack")]
enum Surface<'a> {
    /// One polynomial.
    Quartic(Quartic),
    /// The rings of its corners.
    Patch(Box<Patch<'a>>),
    /// The levels that details reach.
    Whole,
}

impl<'a> Leaf<'a> {
    fn new(subject: &'a Subject<'a>, pyramid: &'a Pyramid, (l, place): LeafPlace) -> Self {
        let floor = &pyramid.floors[l];
        let face = floor.faces[place];
        let code = floor.level.mesh.codes[face as usize];
        Self { subject, floor, face, code, corners: pyramid.corners(l, face) }
    }

    fn farthest(&self, weights: &[[f64; 3]], near: impl Fn(DVec3) -> f64) -> Farthest {
        let surface = self.surface();
        let mut farthest = Farthest::default();
        let border = match surface {
            // Its corners are inside, so its edges are.
            Surface::Quartic(_) => [false; 3],
            _ => self.floor.borders(self.face),
        };
        let mut see = |w: [f64; 3], x: DVec3| {
            farthest.see(x, on_border(x, w, border, self.corners).unwrap_or_else(|| near(x)));
        };
        for &w in weights {
            see(w, self.position(&surface, w));
        }
        if let Surface::Whole = surface {
            self.moved_points(|w| see(w, self.position(&surface, w)));
        }
        farthest
    }

    fn farthest_back(&self, pieces: &[Piece], limit: f64) -> Farthest {
        let surface = self.surface();
        let mut farthest = Farthest::default();
        for piece in pieces {
            let on_leaf = |b: [f64; 3]| core::array::from_fn(|w| (0..3).map(|c| piece[c].1[w] * b[c]).sum());
            for b in INSIDE {
                let y = (0..3).fold(DVec3::ZERO, |sum, c| sum + piece[c].0 * b[c]);
                let mut distance = self.position(&surface, on_leaf(b)).distance(y);
                if distance > limit {
                    let starts = core::iter::once(b).chain(foot::AROUND).map(|b| self.on_root(on_leaf(b)));
                    let (surface, mesh) = (&self.subject.limit, &self.subject.surface.mesh);
                    distance = foot::distance(surface, mesh, starts, y, limit);
                }
                farthest.see(y, if distance <= limit { 0.0 } else { distance * distance });
            }
        }
        farthest
    }

    fn surface(&self) -> Surface<'a> {
        let Level { mesh, state } = &self.floor.level;
        if !self.subject.limit.is_settled(mesh.level, self.code) {
            return Surface::Whole;
        }
        match regular_net(mesh, self.face) {
            Some(net) => Surface::Quartic(Quartic::new(&net.map(|v| state.effective[v as usize]))),
            None => {
                let scheme = Scheme { surface: self.subject.surface, corners: &self.subject.corners };
                Surface::Patch(Box::new(Patch::of(scheme, mesh, state, self.face)))
            }
        }
    }

    fn position(&self, surface: &Surface<'_>, weights: [f64; 3]) -> DVec3 {
        match surface {
            Surface::Quartic(quartic) => quartic.position(weights[1], weights[2]),
            Surface::Patch(patch) => Patch::clone(patch).position(weights),
            Surface::Whole => self.subject.limit.position(self.on_root(weights)),
        }
    }

    fn on_root(&self, weights: [f64; 3]) -> SurfacePoint {
        let level = self.floor.level.mesh.level;
        let share = 0.5_f64.powi(level as i32);
        let corners = self.code.corners(level);
        let (s, t) = corners
            .iter()
            .zip(weights)
            .fold((0.0, 0.0), |(s, t), (&(i, j), w)| (s + w * f64::from(i), t + w * f64::from(j)));
        SurfacePoint::new(self.code.root_face(level), s * share, t * share)
    }

    /// Details finer than the grid show at the points that they move: the corners of their faces.
    fn moved_points(&self, mut see: impl FnMut([f64; 3])) {
        let level = self.floor.level.mesh.level;
        for finer in level + 1..self.subject.reach.depth() {
            let down = finer - level;
            for face in self.subject.reach.moved_below(level, self.code, finer) {
                let inner = FaceCode(face.0 - (self.code.0 << (2 * down)));
                let n = 1 << down;
                for (i, j) in inner.corners(down) {
                    see([n - i - j, i, j].map(|w| f64::from(w) / f64::from(n)));
                }
            }
        }
    }
}

/// The squared distance of a point of the border to the edge that stands for it; `None` off the
/// border. Where the border is concave the triangle reaches beyond the surface, and the inside of the
/// triangle is no match for it.
fn on_border(x: DVec3, weights: [f64; 3], border: [bool; 3], corners: [DVec3; 3]) -> Option<f64> {
    let edge = (0..3).find(|&edge| border[edge] && weights[(edge + 2) % 3] == 0.0)?;
    Some(squared_to_segment(x, corners[edge], corners[(edge + 1) % 3]))
}
