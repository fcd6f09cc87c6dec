//! How far the limit surface of a leaf stands off the triangles that stand for it.
//!
//! A leaf whose patch is one polynomial is sampled in closed form. Any other (an irregular vertex, a
//! border, finer details) is sampled at the limit points some levels deeper.

use glam::DVec3;
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::{FaceCode, Kind, LevelMesh, NONE};

use super::measure::squared_to_segment;
use super::pyramid::Pyramid;
use super::reach::union;
use super::{Subject, TriangulateError};
use crate::parallel::map_in_order;
use crate::subdivision::region;

/// Where a leaf is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lattice {
    /// To decide: the fifteen points that divide its edges by four.
    Quarters,
    /// To check: the 55 points that divide its edges by nine, the centre among them, no others but
    /// the corners among the fifteen. Where there is no polynomial: the 45 points of eighths.
    Ninths,
}

impl Lattice {
    fn steps(self) -> u32 {
        match self {
            Self::Quarters => 4,
            Self::Ninths => 9,
        }
    }

    /// How many levels deeper limit points are taken.
    fn depth(self) -> u32 {
        match self {
            Self::Quarters => 2,
            Self::Ninths => 3,
        }
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
        Self { samples, ..if other.squared > self.squared { other } else { self } }
    }
}

/// For the faces asked of `pyramid`, by level and in their order: the farthest sample. `near` is asked
/// for a level and a place in [`Floor::faces`](super::pyramid::Floor::faces), and answers with the
/// squared distance of a point to the triangles that stand for that face.
///
/// # Errors
/// [`TriangulateError::LimitNotFinite`].
pub fn farthest<D: Fn(DVec3) -> f64>(
    subject: &Subject,
    pyramid: &Pyramid,
    lattice: Lattice,
    near: impl Fn(usize, usize) -> D + Sync,
) -> Result<Vec<Vec<Farthest>>, TriangulateError> {
    let places = places(lattice.steps());
    let mut found: Vec<Vec<Option<Farthest>>> = Vec::new();
    for (l, floor) in pyramid.floors.iter().enumerate() {
        found.push(map_in_order(floor.faces.len(), |place| {
            let mesh = &floor.level.mesh;
            let net = net(subject, mesh, floor.faces[place])?;
            let quartic = Quartic::new(&net.map(|v| floor.level.state.effective[v as usize]));
            let squared = near(l, place);
            let mut farthest = Farthest::default();
            for &(s, t) in &places {
                let x = quartic.position(s, t);
                farthest.see(x, squared(x));
            }
            Some(farthest)
        }));
    }
    let rest = Rest::new(subject, pyramid, lattice, &found)?;
    let measured = rest.measure(pyramid, &near);
    for ((l, place), farthest) in rest.leaves.into_iter().zip(measured) {
        found[l][place] = Some(farthest);
    }
    Ok(found.into_iter().map(|level| level.into_iter().flatten().collect()).collect())
}

/// All points but the corners that divide the edges of a face into `n` steps, as (s, t).
fn places(n: u32) -> Vec<(f64, f64)> {
    let at = |i: u32| f64::from(i) / f64::from(n);
    let all = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
    all.filter(|&(i, j)| i != n && j != n && i + j != 0).map(|(i, j)| (at(i), at(j))).collect()
}

/// The twelve vertices that shape the patch of a face, in the order of a
/// [`Net`](selvedge_components::subdivision::boxspline::Net), if its patch is one
/// polynomial of them: all corners are interior vertices of valence 6, no rule of a special corner
/// acts on an edge of theirs, and no finer detail changes it. Vertices on a border may be among the
/// outer nine.
fn net(subject: &Subject, mesh: &LevelMesh, face: u32) -> Option<[u32; 12]> {
    let regular = |&v: &u32| mesh.vertices[v as usize].kind == Kind::Interior && mesh.vertices[v as usize].valence == 6;
    let corners = mesh.corners[face as usize];
    if !corners.iter().all(regular) || subject.reach.changes(mesh.level, mesh.codes[face as usize]) {
        return None;
    }
    let mut net = [0; 12];
    net[..3].copy_from_slice(&corners);
    for corner in 0..3 {
        // Counter-clockwise from the next corner: that corner, the previous one, the far corner
        // across the edge between, the two that are left, and the far corner across this edge.
        let mut h = 3 * face + corner as u32;
        for spoke in 0..6 {
            match spoke {
                3 | 4 => net[6 + 2 * corner + spoke - 3] = mesh.to(h),
                5 => net[3 + corner] = mesh.to(h),
                _ => {}
            }
            h = mesh.turned(h)?;
        }
    }
    net.iter().all(|&v| mesh.vertices[v as usize].corner == NONE).then_some(net)
}

/// The leaves without a polynomial, with the limit points some levels deeper.
struct Rest {
    /// Level and place of each.
    leaves: Vec<(usize, usize)>,
    deeper: Pyramid,
}

impl Rest {
    fn new(
        subject: &Subject,
        pyramid: &Pyramid,
        lattice: Lattice,
        found: &[Vec<Option<Farthest>>],
    ) -> Result<Self, TriangulateError> {
        let mut leaves = Vec::new();
        let depth = lattice.depth();
        let levels = (pyramid.floors.len() + depth as usize).max(subject.reach.depth() as usize);
        let mut wanted: Vec<Vec<FaceCode>> = vec![Vec::new(); levels];
        for (l, found) in found.iter().enumerate() {
            let floor = &pyramid.floors[l];
            for place in (0..found.len()).filter(|&p| found[p].is_none()) {
                leaves.push((l, place));
                let code = floor.level.mesh.codes[floor.faces[place] as usize];
                let (level, first) = (l as u32 + depth, code.0 << (2 * depth));
                wanted[level as usize].extend((0..1 << (2 * depth)).map(|i| FaceCode(first + i)));
                // Details still finer show at the points they move.
                for finer in level + 1..subject.reach.depth() {
                    wanted[finer as usize].extend(subject.reach.moved_below(l as u32, code, finer));
                }
            }
        }
        let wanted: Vec<_> = wanted.into_iter().map(|level| union(&region::ascending(level), &[])).collect();
        Ok(Self { leaves, deeper: Pyramid::new(subject, &wanted)? })
    }

    fn measure<D: Fn(DVec3) -> f64>(
        &self,
        pyramid: &Pyramid,
        near: &(impl Fn(usize, usize) -> D + Sync),
    ) -> Vec<Farthest> {
        map_in_order(self.leaves.len(), |i| {
            let (l, place) = self.leaves[i];
            let (squared, floor) = (near(l, place), &pyramid.floors[l]);
            let face = floor.faces[place];
            let code = floor.level.mesh.codes[face as usize];
            let border = floor.borders(face);
            let corners = pyramid.corners(l, face);
            let mut farthest = Farthest::default();
            for (m, deep) in self.deeper.floors.iter().enumerate().skip(l + 1) {
                let down = (m - l) as u32;
                let codes = &deep.level.mesh.codes;
                let below = |f: u32| codes[f as usize].0 >> (2 * down);
                let begin = deep.faces.partition_point(|&f| below(f) < code.0);
                let end = deep.faces.partition_point(|&f| below(f) <= code.0);
                for &f in &deep.faces[begin..end] {
                    let inner = FaceCode(codes[f as usize].0 - (code.0 << (2 * down)));
                    let lattice = inner.corners(down);
                    for (x, (i, j)) in self.deeper.corners(m, f).into_iter().zip(lattice) {
                        let weights = [(1 << down) - i - j, i, j];
                        farthest.see(x, on_border(x, weights, border, corners).unwrap_or_else(|| squared(x)));
                    }
                }
            }
            farthest
        })
    }
}

/// The squared distance of a point of the border to the edge that stands for it; `None` off the
/// border. Where the border is concave the triangle reaches beyond the surface, and the inside of the
/// triangle is no match for it.
fn on_border(x: DVec3, weights: [u32; 3], border: [bool; 3], corners: [DVec3; 3]) -> Option<f64> {
    let edge = (0..3).find(|&edge| border[edge] && weights[(edge + 2) % 3] == 0)?;
    Some(squared_to_segment(x, corners[edge], corners[(edge + 1) % 3]))
}
