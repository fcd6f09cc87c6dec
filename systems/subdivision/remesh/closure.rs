//! The conforming triangle mesh of a set of leaves: where a neighbour is finer, a leaf is cut into
//! two or three triangles.

use std::collections::HashMap;

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::{Address, CornerTable, FaceCode, LoopSurface};

use super::error::RemeshError;
use super::field::Field;
use super::leaves::{Hanging, Leaves};

/// The triangles of an adapted cage.
#[derive(Clone, Debug, Default)]
pub struct Adapted {
    /// By leaf, in the order of [`Leaves::all`].
    pub triangles: Vec<[u32; 3]>,
    /// What each triangle is.
    pub sources: Vec<Piece>,
    /// The vertices, in the order in which the triangles meet them.
    pub vertices: Vec<LatticeVertex>,
}

/// A triangle of an adapted cage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The level of its leaf.
    pub level: u32,
    /// Its leaf.
    pub leaf: FaceCode,
    /// Is it all of it?
    pub part: Part,
}

impl Piece {
    /// The middle of its leaf.
    pub fn middle(&self) -> SurfacePoint {
        let sum = self.leaf.corners(self.level).iter().fold((0, 0), |sum, p| (sum.0 + p.0, sum.1 + p.1));
        let whole = 3.0 * f64::from(1_u32 << self.level);
        SurfacePoint::new(self.leaf.root_face(self.level), f64::from(sum.0) / whole, f64::from(sum.1) / whole)
    }
}

/// How much of its leaf a triangle is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All.
    Whole,
    /// One of two or three, because a neighbour is finer.
    Closure,
}

/// A vertex of an adapted cage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeVertex {
    /// The level at which it first appears.
    pub birth: u32,
    /// Its address at that level.
    pub address: Address,
    /// The coarsest level among its leaves: whose control point it takes. Never below `birth`.
    pub level: u32,
    /// That control point: the effective one, which all rules read.
    pub point: DVec3,
    /// The boundary detail at that level; zero off the given borders.
    pub detail: DVec3,
    /// The limit point.
    pub limit: DVec3,
}

/// The level at which the vertex at `address` of `level` first appears, and its address there.
pub fn birth(mut level: u32, mut address: Address) -> (u32, Address) {
    while level > 0 {
        address = match address {
            Address::Corner(_) => return (0, address),
            Address::Edge(e, steps) if steps % 2 == 0 => Address::Edge(e, steps / 2),
            Address::Face(f, i, j) if i % 2 == 0 && j % 2 == 0 => Address::Face(f, i / 2, j / 2),
            _ => return (level, address),
        };
        level -= 1;
    }
    (level, address)
}

/// The same vertex's address at a finer level.
pub fn at_level(address: Address, birth: u32, level: u32) -> Address {
    let up = level - birth;
    match address {
        Address::Corner(_) => address,
        Address::Edge(e, steps) => Address::Edge(e, steps << up),
        Address::Face(f, i, j) => Address::Face(f, i << up, j << up),
    }
}

/// Closes `leaves` into one conforming mesh and places its vertices.
///
/// # Errors
/// [`RemeshError::NotFinite`].
pub fn close(surface: &LoopSurface, corners: &CornerTable, leaves: &Leaves) -> Result<Adapted, RemeshError> {
    let mesh = &*surface.mesh;
    let all = leaves.all(mesh);
    let mut names = Names::default();
    for &(level, code) in &all {
        names.corners(mesh, level, code);
    }
    let mut vertices = names.vertices;
    place(surface, corners, &all, &names.index, &mut vertices)?;
    let names = names.index;
    let mut adapted = Adapted { vertices, ..Adapted::default() };
    for &(level, code) in &all {
        let corners = code.corners(level);
        let face = code.root_face(level);
        let name = |level: u32, (i, j): (u32, u32)| names[&birth(level, Address::of(mesh, level, face, i, j))];
        let own = corners.map(|p| name(level, p));
        let hanging = leaves.hanging(mesh, level, code);
        let middles = [0, 1, 2].map(|i| {
            let (p, q) = (corners[i], corners[(i + 1) % 3]);
            // Only looked up where there is a vertex.
            if hanging >> i & 1 == 1 { name(level + 1, (p.0 + q.0, p.1 + q.1)) } else { u32::MAX }
        });
        let limit = |v: u32| adapted.vertices[v as usize].limit;
        let pieces = template(own, middles, hanging, limit);
        let part = if hanging == 0 { Part::Whole } else { Part::Closure };
        for triangle in pieces {
            adapted.triangles.push(triangle);
            adapted.sources.push(Piece { level, leaf: code, part });
        }
    }
    Ok(adapted)
}

/// The vertices by their birth, numbered as they are met.
#[derive(Default)]
struct Names {
    index: HashMap<(u32, Address), u32>,
    vertices: Vec<LatticeVertex>,
}

impl Names {
    fn corners(&mut self, mesh: &Connectivity, level: u32, code: FaceCode) {
        for (i, j) in code.corners(level) {
            let key = birth(level, Address::of(mesh, level, code.root_face(level), i, j));
            let next = self.vertices.len() as u32;
            let name = *self.index.entry(key).or_insert(next);
            if name == next {
                self.vertices.push(LatticeVertex {
                    birth: key.0,
                    address: key.1,
                    level,
                    point: DVec3::NAN,
                    detail: DVec3::ZERO,
                    limit: DVec3::NAN,
                });
            }
            let coarsest = &mut self.vertices[name as usize].level;
            *coarsest = (*coarsest).min(level);
        }
    }
}

/// Reads control and limit points off the levels of the source.
fn place(
    surface: &LoopSurface,
    corners: &CornerTable,
    leaves: &[(u32, FaceCode)],
    names: &HashMap<(u32, Address), u32>,
    vertices: &mut [LatticeVertex],
) -> Result<(), RemeshError> {
    let finest = leaves.iter().map(|l| l.0).max().unwrap_or(0);
    for level in 0..=finest {
        let faces: Vec<FaceCode> = leaves.iter().filter(|l| l.0 == level).map(|l| l.1).collect();
        if faces.is_empty() {
            continue;
        }
        let field = Field::new(surface, corners, level, &faces);
        for (v, address) in field.level.mesh.addresses(&surface.mesh).into_iter().enumerate() {
            let Some(&name) = names.get(&birth(level, address)) else { continue };
            let vertex = &mut vertices[name as usize];
            if vertex.level == level {
                vertex.point = field.level.state.effective[v];
                vertex.detail = field.level.state.detail(&field.level.mesh, v as u32);
                vertex.limit = field.limit[v];
            }
        }
    }
    match vertices.iter().position(|v| !(v.point.is_finite() && v.limit.is_finite())) {
        Some(v) => {
            Err(RemeshError::NotFinite { vertex: selvedge_components::mesh::VertexId::new(v), at: vertices[v].limit })
        }
        None => Ok(()),
    }
}

/// The triangles of one leaf. `middles[i]` halves the edge after corner `i` where bit `i` is set.
///
/// A leaf with three finer neighbours is split itself, so two is the most there is.
fn template(own: [u32; 3], middles: [u32; 3], hanging: Hanging, limit: impl Fn(u32) -> DVec3) -> Vec<[u32; 3]> {
    match hanging.count_ones() {
        0 => vec![own],
        1 => {
            let i = hanging.trailing_zeros() as usize;
            let [p, q, r] = [own[i], own[(i + 1) % 3], own[(i + 2) % 3]];
            vec![[p, middles[i], r], [middles[i], q, r]]
        }
        2 => {
            // The edge from p to q is whole; the quadrilateral beside it takes its shorter diagonal.
            let i = (!hanging & 0b111).trailing_zeros() as usize;
            let [p, q, r] = [own[i], own[(i + 1) % 3], own[(i + 2) % 3]];
            let (qr, rp) = (middles[(i + 1) % 3], middles[(i + 2) % 3]);
            let tip = [qr, r, rp];
            if limit(p).distance(limit(qr)) <= limit(q).distance(limit(rp)) {
                vec![tip, [p, q, qr], [p, qr, rp]]
            } else {
                vec![tip, [p, q, rp], [q, qr, rp]]
            }
        }
        _ => {
            let [p, q, r] = own;
            let [pq, qr, rp] = middles;
            vec![[p, pq, rp], [pq, q, qr], [rp, qr, r], [pq, qr, rp]]
        }
    }
}
