//! The rules of one subdivision step, and of the limit, as sparse rows over effective points.
//!
//! A level's state is its *effective control points* `e`: the control point `p` of an interior
//! vertex or of one on a plain border, and `p - d` on a given border, where `p` is the curve's
//! sample and `d` the boundary detail. Every interior rule reads `e`.

use core::ops::Range;

use glam::DVec3;

use super::corner::{CornerTable, LATTICE_WEIGHT, Pull, SpecialCorner};
use super::level::{Kind, LevelMesh, Origin, RingState, sample};
use super::masks;
use super::surface::LoopSurface;

/// A sparse matrix, row by row; entries of a row stand in the order in which they are summed.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows {
    starts: Vec<u32>,
    columns: Vec<u32>,
    weights: Vec<f64>,
}

impl Default for Rows {
    fn default() -> Self {
        Self::new()
    }
}

impl Rows {
    /// A matrix without rows.
    pub fn new() -> Self {
        Self { starts: vec![0], columns: Vec::new(), weights: Vec::new() }
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Are there no rows?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = (u32, f64)>) {
        for (column, weight) in row {
            self.columns.push(column);
            self.weights.push(weight);
        }
        self.starts.push(self.columns.len() as u32);
    }

    /// Makes room for the rows of all `others`.
    fn reserve<'a>(&mut self, others: impl Iterator<Item = &'a Self> + Clone) {
        let entries = others.clone().map(|other| other.columns.len()).sum();
        self.starts.reserve(others.map(Self::len).sum());
        self.columns.reserve(entries);
        self.weights.reserve(entries);
    }

    /// Adds all rows of `other`.
    pub fn append(&mut self, other: &Self) {
        let before = self.columns.len() as u32;
        self.starts.extend(other.starts[1..].iter().map(|start| before + start));
        self.columns.extend_from_slice(&other.columns);
        self.weights.extend_from_slice(&other.weights);
    }

    /// The entries of row `r`: columns and weights.
    #[inline]
    pub fn row(&self, r: usize) -> (&[u32], &[f64]) {
        let (a, b) = (self.starts[r] as usize, self.starts[r + 1] as usize);
        (&self.columns[a..b], &self.weights[a..b])
    }

    /// Row `r` applied to `x`.
    #[inline]
    pub fn dot(&self, r: usize, x: &[DVec3]) -> DVec3 {
        let (columns, weights) = self.row(r);
        columns.iter().zip(weights).fold(DVec3::ZERO, |sum, (&c, &w)| sum + w * x[c as usize])
    }
}

/// How one level's effective points make the next one's: `e' = S e + offset`, and on a given
/// border `d' = S d`, `e' = p' - d'`.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// One row per vertex of the finer level.
    pub rows: Rows,
    /// What the concave corners add, by vertex of the finer level: the part of their quadratic that
    /// the curves give.
    pub offsets: Vec<(u32, DVec3)>,
    /// Edge points that the seed's flatness moves: `(vertex, special corner, vertex of the corner)`.
    pub flat: Vec<(u32, u32, u32)>,
}

impl Step {
    /// The rules that make the vertices of `range` of `fine`, which is a refinement of `coarse`.
    pub fn of(
        surface: &LoopSurface,
        corners: &CornerTable,
        coarse: &LevelMesh,
        fine: &LevelMesh,
        range: Range<u32>,
    ) -> Self {
        let mut step = Self::default();
        for name in range {
            match fine.vertices[name as usize].origin {
                Origin::Root => {}
                Origin::Vertex(v) => step.push_vertex(coarse, v),
                Origin::Edge(h) => step.push_edge(surface, corners, coarse, h, name),
            }
        }
        step
    }

    /// Adds the rules of the vertices that come after all that it has, part by part.
    pub fn append(&mut self, parts: Vec<Self>) {
        self.rows.reserve(parts.iter().map(|part| &part.rows));
        for next in parts {
            self.rows.append(&next.rows);
            self.offsets.extend(next.offsets);
            self.flat.extend(next.flat);
        }
    }

    fn push_vertex(&mut self, mesh: &LevelMesh, v: u32) {
        let vertex = mesh.vertices[v as usize];
        match vertex.kind {
            Kind::Interior => {
                let beta = masks::neighbour_weight(vertex.valence);
                let own = 1.0 - f64::from(vertex.valence) * beta;
                self.rows.push([(v, own)].into_iter().chain(mesh.ring(v).map(|h| (mesh.to(h), beta))));
            }
            Kind::Plain => {
                let (ahead, behind) = (mesh.to(vertex.start), mesh.previous_on_border(v).unwrap_or(v));
                self.rows.push([(v, 0.75), (ahead, 0.125), (behind, 0.125)]);
            }
            Kind::PlainCorner => self.rows.push([(v, 1.0)]),
            Kind::Given(_) => self.rows.push([(v, 0.25)]),
        }
    }

    fn push_edge(&mut self, surface: &LoopSurface, corners: &CornerTable, mesh: &LevelMesh, h: u32, name: u32) {
        let (a, b) = (mesh.from(h), mesh.to(h));
        let Some(twin) = mesh.twin(h) else {
            let given = mesh.border(h).is_some_and(|(s, _)| sample(&surface.sides[s as usize], 0, 0).is_some());
            let weight = if given { 0.125 } else { 0.5 };
            return self.rows.push([(a, weight), (b, weight)]);
        };
        let (left, right) = (mesh.opposite(h), mesh.opposite(twin));
        let special = |v: u32| corners.corners.get(mesh.vertices[v as usize].corner as usize);
        let [near, far] = edge_weights(special(a), special(b));
        let plain = [(a, near), (b, far), (left, 0.125), (right, 0.125)];
        // Where both ends draw the point, the first of the corners does, whichever way the edge runs.
        let ends = if mesh.vertices[b as usize].corner < mesh.vertices[a as usize].corner { [b, a] } else { [a, b] };
        for corner in ends {
            match special(corner).map(|c| c.pull) {
                Some(Pull::Quadratic { s }) => {
                    let at = SectorEdge::of(mesh, corner, if corner == a { b } else { a });
                    let constant = special(corner)
                        .map_or(DVec3::ZERO, |c| at.constant(surface, mesh.level + 1, c, mesh.sample(corner)));
                    self.offsets.push((name, s * constant));
                    let pulled = plain.map(|(v, w)| (v, (1.0 - s) * w));
                    return self.rows.push(pulled.into_iter().chain([(corner, s * at.corner_weight())]));
                }
                Some(Pull::Flat { .. }) => self.flat.push((name, mesh.vertices[corner as usize].corner, corner)),
                Some(Pull::None) | None => {}
            }
        }
        self.rows.push(plain);
    }

    /// The next level's state from this one's; details stored for the next level are not added
    /// yet. `effective` is what the rows make of this level's effective points.
    ///
    /// These may be the rules of some vertices only: row 0 then is that of vertex `first` of `fine`, and the
    /// state is that of these vertices alone, from there on. `first` is 0 for a whole level.
    pub fn apply(
        &self,
        first: u32,
        corners: &CornerTable,
        [coarse, fine]: [&LevelMesh; 2],
        state: &LevelState,
        effective: Vec<DVec3>,
    ) -> LevelState {
        let mut next = LevelState { effective, details: Vec::new() };
        for &(v, offset) in &self.offsets {
            next.effective[(v - first) as usize] += offset;
        }
        for &(v, corner, at) in &self.flat {
            let pull = corners.corners[corner as usize].pull;
            let point = &mut next.effective[(v - first) as usize];
            *point = flatten(*point, coarse.sample(at), pull);
        }
        let begin = fine.given.partition_point(|given| given.vertex < first);
        for given in &fine.given[begin..] {
            let row = (given.vertex - first) as usize;
            if row >= self.rows.len() {
                break;
            }
            let (columns, weights) = self.rows.row(row);
            let d = columns.iter().zip(weights).fold(DVec3::ZERO, |sum, (&c, &w)| sum + w * state.detail(coarse, c));
            next.details.push(d);
            next.effective[row] = given.sample - d;
        }
        next
    }
}

/// The state of one level.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LevelState {
    /// Effective control points, one per vertex.
    pub effective: Vec<DVec3>,
    /// Boundary details, one per entry of [`LevelMesh::given`].
    pub details: Vec<DVec3>,
}

impl LevelState {
    /// The boundary detail of `v`; zero off the given borders.
    #[inline]
    pub fn detail(&self, mesh: &LevelMesh, v: u32) -> DVec3 {
        match mesh.vertices[v as usize].kind {
            Kind::Given(g) => self.details[g as usize],
            _ => DVec3::ZERO,
        }
    }
}

/// Limit positions as sparse rows over one level's effective points.
#[derive(Clone, Debug, Default)]
pub struct LimitRows {
    /// The vertices that have a row, ascending: interior ones and those on plain borders, with whole
    /// rings. On a given border the limit point is the sample.
    pub vertices: Vec<u32>,
    /// One row each.
    pub rows: Rows,
    /// What concave corners add, by row.
    offsets: Vec<(u32, DVec3)>,
    flat: Vec<FlatTerm>,
}

/// One ring point next to a flattened corner, one step finer.
#[derive(Clone, Debug)]
struct FlatTerm {
    row: u32,
    weight: f64,
    edge: Vec<(u32, f64)>,
    pull: Pull,
    tip: DVec3,
}

impl LimitRows {
    /// The limit masks of the vertices of `mesh` that `wanted` selects.
    ///
    /// The mask of an interior vertex is exact unless its ring holds a special corner: the edge to
    /// the corner then has another rule than the mask assumes. One step later it no longer does, so
    /// there the row is the mask of the next level after the rules that lead to it.
    pub fn new(surface: &LoopSurface, corners: &CornerTable, mesh: &LevelMesh, wanted: impl Fn(u32) -> bool) -> Self {
        Self::of(surface, corners, mesh, (0..mesh.vertices.len() as u32).filter(|&v| wanted(v)))
    }

    /// The limit masks of some vertices, which ascend.
    pub fn of(
        surface: &LoopSurface,
        corners: &CornerTable,
        mesh: &LevelMesh,
        vertices: impl IntoIterator<Item = u32>,
    ) -> Self {
        let mut limit = Self::default();
        for v in vertices {
            let vertex = mesh.vertices[v as usize];
            if !Self::has_row(mesh, v) {
                continue;
            }
            limit.vertices.push(v);
            match vertex.kind {
                Kind::Interior if mesh.is_beside_special(v) => {
                    limit.push_beside_corner(surface, corners, mesh, v);
                }
                Kind::Interior => {
                    let omega = masks::limit_weight(vertex.valence);
                    let own = 1.0 - f64::from(vertex.valence) * omega;
                    limit.rows.push([(v, own)].into_iter().chain(mesh.ring(v).map(|h| (mesh.to(h), omega))));
                }
                Kind::Plain => {
                    let (ahead, behind) = (mesh.to(vertex.start), mesh.previous_on_border(v).unwrap_or(v));
                    limit.rows.push([(v, 2.0 / 3.0), (ahead, 1.0 / 6.0), (behind, 1.0 / 6.0)]);
                }
                Kind::PlainCorner | Kind::Given(_) => limit.rows.push([(v, 1.0)]),
            }
        }
        limit
    }

    /// The limit positions of `vertices`, which ascend and have masks: the bits of the rows of [`Self::of`]
    /// applied to `state`, without the rows.
    pub fn points(
        surface: &LoopSurface,
        corners: &CornerTable,
        mesh: &LevelMesh,
        state: &LevelState,
        vertices: &[u32],
    ) -> Vec<DVec3> {
        let at = |v: u32| state.effective[v as usize];
        let point = |&v: &u32| {
            let vertex = mesh.vertices[v as usize];
            if vertex.kind == Kind::Interior && !mesh.is_beside_special(v) {
                let omega = masks::limit_weight(vertex.valence);
                let own = 1.0 - f64::from(vertex.valence) * omega;
                mesh.ring(v).fold(DVec3::ZERO + own * at(v), |sum, h| sum + omega * at(mesh.to(h)))
            } else {
                Self::of(surface, corners, mesh, [v]).apply(state).first().copied().unwrap_or(DVec3::NAN)
            }
        };
        vertices.iter().map(point).collect()
    }

    /// Has `v` a mask: is its ring whole, and it not on a given border?
    pub fn has_row(mesh: &LevelMesh, v: u32) -> bool {
        let vertex = mesh.vertices[v as usize];
        vertex.ring != RingState::Cut && !matches!(vertex.kind, Kind::Given(_))
    }

    /// Adds the masks of vertices that come after all that it has, part by part.
    pub fn append(&mut self, parts: Vec<Self>) {
        self.rows.reserve(parts.iter().map(|part| &part.rows));
        for next in parts {
            let before = self.rows.len() as u32;
            self.vertices.extend(next.vertices);
            self.rows.append(&next.rows);
            self.offsets.extend(next.offsets.into_iter().map(|(row, offset)| (before + row, offset)));
            self.flat.extend(next.flat.into_iter().map(|term| FlatTerm { row: before + term.row, ..term }));
        }
    }

    fn push_beside_corner(&mut self, surface: &LoopSurface, corners: &CornerTable, mesh: &LevelMesh, v: u32) {
        let valence = mesh.vertices[v as usize].valence;
        let omega = masks::limit_weight(valence);
        let mut finer = Step::default();
        finer.push_vertex(mesh, v);
        for (i, h) in mesh.ring(v).enumerate() {
            finer.push_edge(surface, corners, mesh, h, i as u32 + 1);
        }
        let mut row: Vec<(u32, f64)> = Vec::new();
        for r in 0..finer.rows.len() {
            let mask = if r == 0 { 1.0 - f64::from(valence) * omega } else { omega };
            let (columns, entries) = finer.rows.row(r);
            for (&c, &w) in columns.iter().zip(entries) {
                match row.iter_mut().find(|e| e.0 == c) {
                    Some(entry) => entry.1 += mask * w,
                    None => row.push((c, mask * w)),
                }
            }
        }
        let name = self.rows.len() as u32;
        self.rows.push(row);
        self.offsets.extend(finer.offsets.iter().map(|&(_, offset)| (name, omega * offset)));
        for &(edge, corner, at) in &finer.flat {
            let (columns, entries) = finer.rows.row(edge as usize);
            self.flat.push(FlatTerm {
                row: name,
                weight: omega,
                edge: columns.iter().copied().zip(entries.iter().copied()).collect(),
                pull: corners.corners[corner as usize].pull,
                tip: mesh.sample(at),
            });
        }
    }

    /// The limit positions, in the order of [`Self::vertices`].
    pub fn apply(&self, state: &LevelState) -> Vec<DVec3> {
        self.apply_range(state, 0..self.rows.len())
    }

    /// The limit positions of some of [`Self::vertices`].
    pub fn apply_range(&self, state: &LevelState, range: Range<usize>) -> Vec<DVec3> {
        let begin = range.start;
        let inside = |row: u32| range.contains(&(row as usize));
        let mut limit: Vec<_> = range.clone().map(|r| self.rows.dot(r, &state.effective)).collect();
        for &(row, offset) in self.offsets.iter().filter(|o| inside(o.0)) {
            limit[row as usize - begin] += offset;
        }
        for term in self.flat.iter().filter(|t| inside(t.row)) {
            let x = term.edge.iter().fold(DVec3::ZERO, |sum, &(c, w)| sum + w * state.effective[c as usize]);
            limit[term.row as usize - begin] += term.weight * (flatten(x, term.tip, term.pull) - x);
        }
        limit
    }
}

/// Weights of the two ends of an interior edge. Where both ends are special, each asks for its own
/// weights; they get the mean.
pub(super) fn edge_weights(start: Option<&SpecialCorner>, end: Option<&SpecialCorner>) -> [f64; 2] {
    let of = |c: Option<&SpecialCorner>| c.map(|c| [0.75 - c.weight, c.weight]);
    match (of(start), of(end).map(|[near, far]| [far, near])) {
        (None, None) => [LATTICE_WEIGHT; 2],
        (Some(w), None) | (None, Some(w)) => w,
        (Some(a), Some(b)) => [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])],
    }
}

/// One interior edge at a concave lattice corner of valence 5 or 6.
///
/// In the basis of the first border edge `a` and the last one `b` the lattice directions of the
/// interior edges are whole numbers `(x, y)`, and the third lattice direction is `a + b` (valence 5,
/// a sector of 240 degrees) or `a - b` (valence 6, of 300 degrees).
pub(super) struct SectorEdge {
    x: f64,
    y: f64,
    /// The sign of the third lattice direction.
    third: f64,
}

impl SectorEdge {
    fn of(mesh: &LevelMesh, corner: u32, other: u32) -> Self {
        let spoke = mesh.neighbours(corner).position(|n| n == other).unwrap_or(1);
        Self::new(mesh.vertices[corner as usize].valence, spoke)
    }

    /// The interior edge that is number `spoke` among the edges of a corner of `valence`, counted
    /// counter-clockwise from the border edge that leaves it, number 0.
    pub(super) fn new(valence: u32, spoke: usize) -> Self {
        const FIVE: [(f64, f64); 3] = [(0.0, -1.0), (-1.0, -1.0), (-1.0, 0.0)];
        const SIX: [(f64, f64); 4] = [(1.0, -1.0), (0.0, -1.0), (-1.0, 0.0), (-1.0, 1.0)];
        let five = valence == 5;
        let directions = if five { &FIVE[..] } else { &SIX[..] };
        let (x, y) = directions[(spoke.max(1) - 1).min(directions.len() - 1)];
        Self { x, y, third: if five { 1.0 } else { -1.0 } }
    }

    /// The weight of the corner's effective point: the quadratic's mixed derivative is
    /// `6 d' - Daa - Dbb` (or its negative), and `d' = d / 4 = (q0 - e) / 4`.
    pub(super) fn corner_weight(&self) -> f64 {
        (1.0 - 6.0 * self.third * self.x * self.y) / 4.0
    }

    /// The quadratic at `(x, y)` on `level` less the part that the corner's effective point gives;
    /// `q0` is the curve's sample at the corner.
    pub(super) fn constant(&self, surface: &LoopSurface, level: u32, corner: &SpecialCorner, q0: DVec3) -> DVec3 {
        let [leaving, arriving] = corner.sides.map(|s| &surface.sides[s as usize]);
        let length = (arriving.vertices.len() as u64 - 1) << level;
        let jet = |q1: Option<DVec3>, q2: Option<DVec3>| {
            let (q1, q2) = (q1.unwrap_or(q0), q2.unwrap_or(q0));
            ((4.0 * (q1 - q0) - (q2 - q0)) / 2.0, q0 - 2.0 * q1 + q2)
        };
        let (ga, daa) = jet(sample(leaving, level, 1), sample(leaving, level, 2));
        let (gb, dbb) = jet(sample(arriving, level, length - 1), sample(arriving, level, length - 2));
        let (x, y, xy) = (self.x, self.y, self.third * self.x * self.y);
        q0 * (1.0 - self.corner_weight()) + x * ga + y * gb + 0.5 * (x * x * daa + y * y * dbb) - xy * (daa + dbb)
    }
}

/// The seed's flatness: towards the tangent plane, at the distance of `x` itself from `tip`.
/// A point straight above the tip has no direction in the plane: it goes towards the tip.
pub(super) fn flatten(x: DVec3, tip: DVec3, pull: Pull) -> DVec3 {
    let Pull::Flat { s, normal } = pull else { return x };
    let inside = x - normal * (x - tip).dot(normal);
    let in_plane = (x - tip).length() * (inside - tip).normalize_or_zero();
    (1.0 - s) * x + s * (tip + in_plane)
}
