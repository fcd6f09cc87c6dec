//! Polygons cut into triangles so that valences stay near those of a regular mesh.
//!
//! A Loop surface is smoothest, and details converge fastest, where a vertex has six edges, or four
//! on a border; the vertex of the highest valence sets the pace for all. So what is kept small is the
//! sum over all vertices of `(valence - target)^4`, target being 6 inside and 4 on a border. A border
//! vertex of one face is a corner of the outline, where 2 and 3 are as good as each other. (The
//! square in place of the fourth power would accept one vertex of valence 8 to spare four of 7.)
//!
//! 1. [`ears`]: in the order of the faces, each is cut ear by ear; of the ears of what is left of the
//!    face, that one goes first whose diagonal makes the sum grow least, then the shortest, then the
//!    first in the face's own order.
//! 2. [`turns`]: in the same order, diagonals are turned inside the two triangles along them, several
//!    in a row where only the last makes up for the first, until that makes the sum no smaller.
//!
//! An ear is a corner whose triangle, seen along the normal of the face (Newell's, exact for plane
//! faces), winds as the face does and holds none of its reflex corners (Meisters 1975), so faces that
//! are not convex are cut inside their outline. A face that winds as nothing does, because it is
//! flat or crosses itself, is cut all the same, by valence alone. No diagonal is laid along an edge
//! that exists already, unless the face leaves no choice.

mod ears;
mod turns;

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;
use selvedge_components::mesh::FaceId;

use super::polygons::Polygons;

/// Triangles and where they come from.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Triangulation {
    /// The triangles of the first face, then those of the second, and so on.
    pub triangles: Vec<[u32; 3]>,
    /// The face from which each triangle was cut.
    pub sources: Vec<FaceId>,
    /// How many faces had more than three sides.
    pub polygons: usize,
}

/// Cuts every face into triangles, by the rule above. Corners must name vertices in range.
///
/// Takes time that grows with the number of corners, and for a face with the square of its sides.
pub fn triangulate(polygons: &Polygons) -> Triangulation {
    let mut out = Triangulation::default();
    if polygons.faces().all(|face| face.len() == 3) {
        out.triangles = polygons.faces().map(|face| [face[0], face[1], face[2]]).collect();
        out.sources = (0..polygons.face_count()).map(FaceId::new).collect();
        return out;
    }
    let mut mesh = Valences::new(polygons);
    let mut pieces = Vec::new();
    for (f, face) in polygons.faces().enumerate() {
        let begin = out.triangles.len();
        ears::cut(face, &mut mesh, &mut out.triangles);
        out.sources.resize(out.triangles.len(), FaceId::new(f));
        if face.len() > 3 {
            let normal = newell_normal(face, &polygons.positions);
            pieces.push(Piece { normal, triangles: begin..out.triangles.len() });
        }
    }
    turns::improve(&mut mesh, &mut out.triangles, &pieces);
    out.polygons = pieces.len();
    out
}

/// A face of more than three sides, cut.
struct Piece {
    normal: DVec3,
    triangles: Range<usize>,
}

/// The edges of the mesh as it stands while its faces are being cut.
struct Valences<'a> {
    positions: &'a [DVec3],
    /// Valence less target.
    excess: Vec<i32>,
    /// A lower excess counts as this one: -1 at a corner, where that is valence 3.
    least: Vec<i32>,
    /// How many faces, or diagonals, there are along each edge. Only looked up, never walked.
    edges: HashMap<[u32; 2], u32>,
}

impl<'a> Valences<'a> {
    fn new(polygons: &'a Polygons) -> Self {
        let excess = vec![-6; polygons.positions.len()];
        let least = vec![i32::MIN; polygons.positions.len()];
        let mut mesh = Self { positions: &polygons.positions, excess, least, edges: HashMap::new() };
        let mut faces = vec![0_u32; polygons.positions.len()];
        for (a, b) in polygons.faces().flat_map(sides) {
            mesh.add(a, b);
            faces[a as usize] += 1;
        }
        for (a, b) in polygons.faces().flat_map(sides) {
            // The target of a border vertex is less by two, and it has two border edges.
            if mesh.edges[&edge(a, b)] == 1 {
                mesh.excess[a as usize] += 1;
                mesh.excess[b as usize] += 1;
            }
        }
        for (v, _) in faces.iter().enumerate().filter(|&(_, &faces)| faces == 1) {
            mesh.least[v] = -1;
        }
        mesh
    }

    /// Adds an edge, or one more along an edge.
    fn add(&mut self, a: u32, b: u32) {
        let along = self.edges.entry(edge(a, b)).or_default();
        *along += 1;
        if *along == 1 {
            self.excess[a as usize] += 1;
            self.excess[b as usize] += 1;
        }
    }

    fn remove(&mut self, a: u32, b: u32) {
        let along = self.edges.entry(edge(a, b)).or_default();
        *along = along.saturating_sub(1);
        if *along == 0 {
            self.excess[a as usize] -= 1;
            self.excess[b as usize] -= 1;
        }
    }

    fn joins(&self, a: u32, b: u32) -> bool {
        self.edges.get(&edge(a, b)).is_some_and(|&along| along > 0)
    }

    /// By how much the sum grows when a vertex gains (`1`) or loses (`-1`) an edge.
    fn rise(&self, v: u32, by: i32) -> i128 {
        let (excess, least) = (self.excess[v as usize], self.least[v as usize]);
        let fourth = |excess: i32| i128::from(excess.max(least)).pow(4);
        fourth(excess + by) - fourth(excess)
    }

    /// Does a triangle have area, and wind as a face of this normal does?
    fn winds_with(&self, normal: DVec3, triangle: [u32; 3]) -> bool {
        let [a, b, c] = triangle.map(|v| self.positions[v as usize]);
        (b - a).cross(c - a).dot(normal) > 0.0
    }
}

/// Twice the area of the face as a vector along its normal (Newell's formula). Taken about the first
/// corner, so that what cancels is no larger than the face.
fn newell_normal(face: &[u32], positions: &[DVec3]) -> DVec3 {
    let about = positions[face[0] as usize];
    let at = |v: u32| positions[v as usize] - about;
    sides(face).map(|(a, b)| at(a).cross(at(b))).sum()
}

fn sides(face: &[u32]) -> impl Iterator<Item = (u32, u32)> + '_ {
    (0..face.len()).map(|i| (face[i], face[(i + 1) % face.len()]))
}

fn edge(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
