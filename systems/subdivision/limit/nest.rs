//! A root face and what evaluates it, quarter within quarter, each made once.

use glam::DVec3;
use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::{Descent, FaceCode, Patch, PatchLattice, QuarterPoints, quartered};
use smallvec::SmallVec;

use super::{Kept, LimitSurface, Piece};

/// The faces within a root face that have been asked for.
///
/// Beside given borders and irregular vertices a face has polynomials only in its quarters' quarters:
/// whoever asks for many points of it shares them here, and the samples of curves that make them.
#[derive(Debug)]
pub struct Nest<'a> {
    limit: &'a LimitSurface,
    nodes: Vec<Node<'a>>,
    lattices: Vec<PatchLattice>,
}

#[derive(Debug)]
struct Node<'a> {
    body: Body<'a>,
    /// The first of its quarters, once they are there.
    children: Option<u32>,
    /// Where its points stand in a lattice of its own or of a face around it.
    view: Option<View>,
}

impl<'a> Node<'a> {
    fn new(body: Body<'a>, view: Option<View>) -> Self {
        Self { body, children: None, view }
    }
}

/// A face within a lattice.
#[derive(Clone, Copy, Debug)]
struct View {
    lattice: u32,
    /// Its corners, in steps towards the second and the third corner of the lattice.
    corners: [(usize, usize); 3],
}

/// Steps of [`QuarterPoints`] along an edge.
const QUARTERS: usize = 1 << QUARTERS_DEPTH;
const QUARTERS_DEPTH: u32 = 2;

impl View {
    /// All of a lattice.
    fn whole(lattice: u32, steps: usize) -> Self {
        Self { lattice, corners: [(0, 0), (steps, 0), (0, steps)] }
    }

    /// How many steps of the lattice its edges have.
    fn steps(&self) -> usize {
        let [a, b, _] = self.corners;
        a.0.abs_diff(b.0).max(a.1.abs_diff(b.1))
    }

    /// Its quarters, as long as their edges have [`QUARTERS`] steps.
    fn quarters(&self) -> [Option<Self>; 4] {
        let middle = |p: (usize, usize), q: (usize, usize)| (usize::midpoint(p.0, q.0), usize::midpoint(p.1, q.1));
        let [a, b, c] = self.corners;
        let quarters = quartered(self.corners, [middle(a, b), middle(b, c), middle(c, a)]);
        let is_fine = self.steps() >= 2 * QUARTERS;
        quarters.map(|corners| is_fine.then_some(Self { lattice: self.lattice, corners }))
    }

    fn points(&self, lattice: &PatchLattice) -> QuarterPoints {
        let place = |i: usize, j: usize| {
            let part = |of: fn((usize, usize)) -> usize| {
                let [a, b, c] = self.corners.map(of);
                (a * (QUARTERS - i - j) + b * i + c * j) / QUARTERS
            };
            lattice.point(part(|p| p.0), part(|p| p.1))
        };
        by_quarters(place)
    }
}

/// What `of` gives for each of the [`QuarterPoints`], by steps towards the second and the third corner.
fn by_quarters(mut of: impl FnMut(usize, usize) -> DVec3) -> QuarterPoints {
    let (mut i, mut j) = (0, 0);
    core::array::from_fn(|_| {
        let point = of(i, j);
        (i, j) = if i + j == QUARTERS { (i + 1, 0) } else { (i, j + 1) };
        point
    })
}

#[derive(Debug)]
enum Body<'a> {
    /// Itself and its quarters.
    Kept(Kept, [Kept; 4]),
    Quartic(Box<Quartic>),
    /// With the lattice that has been asked for so far, if any.
    Patch(Box<Patch<'a>>, Option<Box<PatchLattice>>),
    /// A root face that is not there.
    Nothing,
}

/// A face in a [`Nest`], or the one within whose polynomial it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spot {
    node: u32,
    /// The level of the node; that of the face where it is not below a polynomial.
    pub level: u32,
}

/// Quarters deeper than this below the first that is asked are not kept. A point that has not met a
/// polynomial by then is within `2^-8` of the face's size of a border or an irregular vertex.
const KEPT_DEPTH: u32 = 8;

impl<'a> Nest<'a> {
    /// The root face `face`, and nothing in it yet.
    pub fn new(limit: &'a LimitSurface, face: FaceId) -> Self {
        let body = body_of(limit, limit.root(face));
        Self { limit, nodes: vec![Node::new(body, None)], lattices: Vec::new() }
    }

    /// The face `code` of `level`, which lies in the root face.
    pub fn spot(&mut self, level: u32, code: FaceCode) -> Spot {
        let mut spot = self.root();
        while spot.level < level && self.quartic(spot).is_none() {
            let child = code.0 >> (2 * (level - spot.level - 1)) & 3;
            spot = self.child(spot, child as usize);
        }
        spot
    }

    /// The root face.
    pub fn root(&self) -> Spot {
        Spot { node: 0, level: 0 }
    }

    /// The quarter `child` of a face that is no polynomial.
    pub fn child(&mut self, spot: Spot, child: usize) -> Spot {
        let first = self.nodes[spot.node as usize].children.unwrap_or_else(|| self.quarter(spot.node));
        Spot { node: first + child as u32, level: spot.level + 1 }
    }

    fn quarter(&mut self, node: u32) -> u32 {
        let first = self.nodes.len() as u32;
        let mut children = SmallVec::<[Body<'a>; 4]>::new();
        match &self.nodes[node as usize].body {
            Body::Kept(_, kept) => children.extend(kept.map(|kept| body_of(self.limit, kept))),
            Body::Patch(patch, _) => patch.quarters(|quarter| children.push(body_of_patch(quarter))),
            Body::Quartic(_) | Body::Nothing => children.extend([const { Body::Nothing }; 4]),
        }
        let views = self.nodes[node as usize].view.map_or([None; 4], |view| view.quarters());
        self.nodes.extend(children.into_iter().zip(views).map(|(body, view)| Node::new(body, view)));
        self.nodes[node as usize].children = Some(first);
        first
    }

    /// The polynomial that is the whole of a face.
    pub fn quartic(&self, spot: Spot) -> Option<&Quartic> {
        match &self.nodes[spot.node as usize].body {
            Body::Quartic(quartic) => Some(quartic),
            _ => None,
        }
    }

    /// The limit points that divide the edges of a face by four.
    ///
    /// Where nothing but subdivision is left to come they are made all at once; if its quarters are `next`,
    /// together with those of these.
    pub fn quarter_points(&mut self, spot: Spot, next: bool) -> QuarterPoints {
        let node = spot.node as usize;
        if self.nodes[node].view.is_none() {
            let depth = if next { QUARTERS_DEPTH + 1 } else { QUARTERS_DEPTH };
            let lattice = match &self.nodes[node].body {
                Body::Patch(patch, _) => Some(PatchLattice::new(patch, depth)),
                Body::Kept(own, _) => self.limit.patch(*own).map(|patch| PatchLattice::new(&patch, depth)),
                Body::Quartic(_) | Body::Nothing => None,
            };
            if let Some(lattice) = lattice {
                self.nodes[node].view = Some(View::whole(self.lattices.len() as u32, lattice.steps()));
                self.lattices.push(lattice);
            }
        }
        match self.nodes[node].view {
            Some(view) => view.points(&self.lattices[view.lattice as usize]),
            None => by_quarters(|i, j| {
                let [s, t] = [i, j].map(|steps| steps as f64 / QUARTERS as f64);
                self.position(spot, [1.0 - s - t, s, t])
            }),
        }
    }

    /// The limit position where the corners of a face weigh `weights`.
    ///
    /// Where the weights are sixteenths, a face that is not polynomial makes all such points at once.
    pub fn position(&mut self, mut spot: Spot, weights: [f64; 3]) -> DVec3 {
        let mut way = Descent::from(weights);
        let deepest = spot.level + KEPT_DEPTH;
        loop {
            match &mut self.nodes[spot.node as usize].body {
                Body::Quartic(quartic) => return quartic.position(way.weights[1], way.weights[2]),
                Body::Nothing => return DVec3::NAN,
                Body::Kept(..) => {}
                Body::Patch(patch, lattice) => {
                    // Corners need no lattice, and whoever asks for them may need a finer one next.
                    let is_corner = way.weights.contains(&1.0);
                    if let Some(place) = LatticePlace::of(way.weights).filter(|_| !is_corner) {
                        return place.point(patch, lattice);
                    }
                    if let Some(position) = patch.position_at_once(way.weights) {
                        return position;
                    }
                    if spot.level >= deepest {
                        return (**patch).clone().position(way.weights);
                    }
                }
            }
            spot = self.child(spot, way.enter());
        }
    }
}

/// A place of a lattice that is worth making for more than one point.
struct LatticePlace {
    depth: u32,
    i: usize,
    j: usize,
}

impl LatticePlace {
    /// The place with these weights, if they are quarters or sixteenths.
    fn of([_, s, t]: [f64; 3]) -> Option<Self> {
        [2, 4].into_iter().find_map(|depth| {
            let [i, j] = [s, t].map(|weight| weight * f64::from(1 << depth));
            (i.fract() == 0.0 && j.fract() == 0.0).then_some(Self { depth, i: i as usize, j: j as usize })
        })
    }

    /// The point there, of the lattice that is there or of one that is made.
    fn point(&self, patch: &Patch<'_>, lattice: &mut Option<Box<PatchLattice>>) -> DVec3 {
        let steps = 1 << self.depth;
        let fine_enough = lattice.take().filter(|lattice| lattice.steps() >= steps);
        let lattice = lattice.insert(fine_enough.unwrap_or_else(|| Box::new(PatchLattice::new(patch, self.depth))));
        let every = lattice.steps() / steps;
        lattice.point(every * self.i, every * self.j)
    }
}

fn body_of(limit: &LimitSurface, face: Kept) -> Body<'_> {
    match limit.piece(face) {
        Some(Piece::Children(children)) => Body::Kept(face, children),
        Some(Piece::Quartic(quartic)) => Body::Quartic(Box::new(quartic)),
        Some(Piece::Patch(patch)) => body_of_patch(patch),
        None => Body::Nothing,
    }
}

fn body_of_patch(patch: Patch<'_>) -> Body<'_> {
    match patch.quartic() {
        Some(quartic) => Body::Quartic(Box::new(quartic)),
        None => Body::Patch(Box::new(patch), None),
    }
}
