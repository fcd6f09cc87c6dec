//! How far the limit surface of a leaf stands off the triangles that stand for it.

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{FaceId, HalfedgeId};
use selvedge_components::subdivision::{FaceCode, QuarterPoints};
use smallvec::SmallVec;

use super::Subject;
use super::inner::Inner;
use super::measure::{Plane, squared_to_segment};
use crate::foot;
use crate::subdivision::limit::{Nest, Spot};

/// Where a leaf is sampled: at whole multiples of 1/16, which a face makes many of at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grid {
    /// To decide: the fifteen points that divide its edges by four.
    Quarters,
    /// To check: 55 points, those next to the ones that divide its edges by nine; few of the fifteen.
    Ninths,
}

impl Grid {
    /// All its points but the corners, as the weights of these.
    pub fn weights(self) -> Vec<[f64; 3]> {
        let n = match self {
            Self::Quarters => 4,
            Self::Ninths => 9,
        };
        let all = (0..=n).flat_map(|i| (0..=n - i).map(move |j| [n - i - j, i, j]));
        let inner = all.filter(|steps| !steps.contains(&n));
        let sixteenths = |part: u32| (16.0 * f64::from(part) / f64::from(n)).round() / 16.0;
        inner.map(|[_, i, j]| [i, j].map(sixteenths)).map(|[s, t]| [1.0 - s - t, s, t]).collect()
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

/// Is it farther off than `limit`?
pub fn is_beyond(found: &Farthest, limit: f64) -> bool {
    found.squared.is_nan() || found.squared > limit * limit
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

/// A face of the hierarchy: its level and its code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// The level.
    pub level: u32,
    /// The code.
    pub code: FaceCode,
}

impl Place {
    /// What tells it from others in its root face: it ascends along the paths of quarters, the order in which
    /// they are come to, and a face comes before its quarters.
    pub fn along_paths(&self) -> (u64, u32) {
        // Two bits for each level, the first on top.
        let path = if self.level == 0 { 0 } else { self.code.0 << (64 - 2 * self.level) };
        (path, self.level)
    }

    /// Its quarters.
    pub fn quarters(&self) -> [Self; 4] {
        [0, 1, 2, 3].map(|child| Self { level: self.level + 1, code: self.code.child(child) })
    }

    /// The root face that it lies in.
    pub fn root(&self) -> FaceId {
        self.code.root_face(self.level)
    }
}

/// A triangle on a leaf: its corners, each with its weights on the leaf.
pub type Piece = [(DVec3, [f64; 3]); 3];

/// The triangles of a leaf.
pub type Pieces = SmallVec<[Piece; 4]>;

/// Where a triangle is asked how far the surface is, in eighths: about its centre, and halfway from there to
/// its corners and to the middles of its edges. On a leaf that is cut they are sixteenths.
const INSIDE: [[u32; 3]; 7] = [[3, 3, 2], [6, 1, 1], [1, 6, 1], [1, 1, 6], [4, 3, 1], [1, 4, 3], [3, 1, 4]];

/// How often the place over a point is looked for by how far the surface slides. Each step leaves of the
/// distance what the slide changes over it, a tenth or less on faces that nearly keep a chord.
const SLIDES: usize = 4;

/// A face that is sampled.
pub struct Sampled<'n, 'a> {
    subject: &'n Subject,
    nest: &'n mut Nest<'a>,
    place: Place,
    spot: Spot,
    /// Its corners in the domain of the polynomial that covers it.
    inner: Option<[[f64; 2]; 3]>,
    corners: [DVec3; 3],
    borders: [bool; 3],
}

impl<'n, 'a> Sampled<'n, 'a> {
    /// The face at `place`, within the root face of `nest`.
    pub fn new(subject: &'n Subject, nest: &'n mut Nest<'a>, place: Place) -> Self {
        let spot = nest.spot(place.level, place.code);
        let inner = nest.quartic(spot).map(|_| Inner::new(place, spot.level).corners());
        let borders = borders(subject, place);
        let mut sampled = Self { subject, nest, place, spot, inner, corners: [DVec3::ZERO; 3], borders };
        sampled.corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|w| sampled.position(w));
        sampled
    }

    /// Where its corners stand on the limit surface.
    pub fn corners(&self) -> [DVec3; 3] {
        self.corners
    }

    /// Which of its edges lie on a border.
    pub fn borders(&self) -> [bool; 3] {
        self.borders
    }

    /// The sample of the limit surface over it that is farthest off, or the first that is beyond `limit`;
    /// `near` answers with the squared distance of a point to the triangles that stand for it.
    pub fn farthest(&mut self, weights: &[[f64; 3]], limit: f64, mut near: impl FnMut(DVec3) -> f64) -> Farthest {
        let mut farthest = Farthest::default();
        for &w in weights {
            self.see(&mut farthest, w, &mut near);
            if is_beyond(&farthest, limit) {
                return farthest;
            }
        }
        if self.inner.is_none() {
            self.see_moved(&mut farthest, &mut near);
        }
        farthest
    }

    fn see(&mut self, farthest: &mut Farthest, w: [f64; 3], near: &mut impl FnMut(DVec3) -> f64) {
        let x = self.position(w);
        farthest.see(x, on_border(x, w, self.borders, self.corners).unwrap_or_else(|| near(x)));
    }

    /// The point of its triangles that is farthest from the limit surface, of those that are farther
    /// than `enough`.
    ///
    /// The point of the surface with the same weights is no nearer than the foot, nor is what is found
    /// from there over this face: only where that is beyond the `limit` the foot is looked for all around.
    pub fn farthest_back(&mut self, pieces: &[Piece], enough: f64, limit: f64) -> Farthest {
        let mut farthest = Farthest::default();
        let plane = Plane::new(self.corners);
        for piece in pieces {
            let on_leaf = |b: [f64; 3]| core::array::from_fn(|w| (0..3).map(|c| piece[c].1[w] * b[c]).sum());
            for b in INSIDE.map(|eighths| eighths.map(|part| f64::from(part) / 8.0)) {
                let y = (0..3).fold(DVec3::ZERO, |sum, c| sum + piece[c].0 * b[c]);
                let mut distance = self.distance_over(plane.as_ref(), on_leaf(b), y, enough);
                if distance > limit {
                    let starts = core::iter::once(b).chain(foot::AROUND).map(|b| self.on_root(on_leaf(b)));
                    let (surface, mesh) = (&self.subject.limit, &self.subject.surface.mesh);
                    distance = distance.min(foot::distance(surface, mesh, starts, y, limit));
                }
                farthest.see(y, if distance <= enough { 0.0 } else { distance * distance });
            }
        }
        farthest
    }

    /// The distance of `y` to the limit surface over this face, from above: to where it stands over the
    /// place with the weights `start`, and to where it has slid away from `y` as often as `limit` is
    /// exceeded and a step brings it nearer.
    fn distance_over(&mut self, plane: Option<&Plane>, start: [f64; 3], y: DVec3, limit: f64) -> f64 {
        let mut weights = start;
        let mut least = f64::INFINITY;
        for _ in 0..SLIDES {
            let x = self.position(weights);
            let distance = x.distance(y);
            let Some(plane) = plane.filter(|_| distance > limit && distance < least) else {
                return if distance.is_nan() { distance } else { least.min(distance) };
            };
            least = distance;
            let (here, there) = (plane.under(x).weights, plane.under(y).weights);
            weights = core::array::from_fn(|c| (weights[c] + there[c] - here[c]).max(0.0));
            let sum: f64 = weights.iter().sum();
            weights = weights.map(|w| w / sum);
        }
        least
    }

    fn position(&mut self, weights: [f64; 3]) -> DVec3 {
        match (self.inner, self.nest.quartic(self.spot)) {
            (Some(inner), Some(quartic)) => {
                let [s, t] = [0, 1].map(|k| (0..3).map(|c| weights[c] * inner[c][k]).sum());
                quartic.position(s, t)
            }
            _ => self.nest.position(self.spot, weights),
        }
    }

    fn on_root(&self, weights: [f64; 3]) -> SurfacePoint {
        let Place { level, code } = self.place;
        let share = 0.5_f64.powi(level as i32);
        let corners = code.corners(level);
        let (s, t) = corners
            .iter()
            .zip(weights)
            .fold((0.0, 0.0), |(s, t), (&(i, j), w)| (s + w * f64::from(i), t + w * f64::from(j)));
        SurfacePoint::new(code.root_face(level), s * share, t * share)
    }

    /// Details finer than the grid show at the points that they move: the corners of their faces.
    fn see_moved(&mut self, farthest: &mut Farthest, near: &mut impl FnMut(DVec3) -> f64) {
        let Place { level, code } = self.place;
        let subject = self.subject;
        for finer in level + 1..subject.reach.depth() {
            let down = finer - level;
            for face in subject.reach.moved_below(level, code, finer) {
                let inner = FaceCode(face.0 - (code.0 << (2 * down)));
                let n = 1 << down;
                for (i, j) in inner.corners(down) {
                    self.see(farthest, [n - i - j, i, j].map(|w| f64::from(w) / f64::from(n)), near);
                }
            }
        }
    }
}

/// The farthest of the points that divide the edges of a face by four, the corners left out, as
/// [`Sampled::farthest`] finds it.
pub fn farthest_of(
    points: &QuarterPoints,
    borders: [bool; 3],
    weights: &[[f64; 3]],
    mut near: impl FnMut(DVec3) -> f64,
) -> Farthest {
    let mut farthest = Farthest::default();
    let corners = corners_of(points);
    let inner = [1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 12, 13].map(|k| points[k]);
    for (&x, &w) in inner.iter().zip(weights) {
        farthest.see(x, on_border(x, w, borders, corners).unwrap_or_else(|| near(x)));
    }
    farthest
}

/// The corners of the face with these points.
pub fn corners_of(points: &QuarterPoints) -> [DVec3; 3] {
    [points[0], points[14], points[4]]
}

/// The squared distance of a point of the border to the edge that stands for it; `None` off the
/// border. Where the border is concave the triangle reaches beyond the surface, and the inside of the
/// triangle is no match for it.
fn on_border(x: DVec3, weights: [f64; 3], border: [bool; 3], corners: [DVec3; 3]) -> Option<f64> {
    let edge = (0..3).find(|&edge| border[edge] && weights[(edge + 2) % 3] == 0.0)?;
    Some(squared_to_segment(x, corners[edge], corners[(edge + 1) % 3]))
}

/// Which edges of a face lie on a border.
pub fn borders(subject: &Subject, Place { level, code }: Place) -> [bool; 3] {
    let (n, root) = (1_u32 << level, code.root_face(level));
    let corners = code.corners(level).map(|(i, j)| [n - i - j, i, j]);
    [0, 1, 2].map(|edge| {
        let (from, to) = (corners[edge], corners[(edge + 1) % 3]);
        // The root edge across from the corner that weighs nothing all along runs from the next corner.
        let across = (0..3).find(|&c| from[c] == 0 && to[c] == 0);
        across.is_some_and(|c| subject.surface.mesh.twin(HalfedgeId::of(root, (c + 1) % 3)).is_none())
    })
}
