//! How far stored details reach.

use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::{Address, Details, FaceCode};

use crate::subdivision::region;

/// What the details of one surface move.
#[derive(Debug, Default)]
pub struct Reach {
    /// By level: the faces that have a corner with a detail of this level, ascending.
    moved: Vec<Vec<FaceCode>>,
}

impl Reach {
    /// What `details` move on the surface over `mesh`. A detail whose address is not one of its
    /// level moves nothing.
    pub fn new(mesh: &Connectivity, details: &Details) -> Self {
        let depth = details.depth().min(FaceCode::finest(mesh.face_count()) + 1);
        let of_level = |(level, stored): (u32, &Vec<(Address, _)>)| {
            region::ascending(stored.iter().flat_map(|d| faces_around(mesh, level, d.0)).collect())
        };
        Self { moved: (0..depth).zip(&details.levels).map(of_level).collect() }
    }

    /// One more than the finest level that has a detail.
    pub fn depth(&self) -> u32 {
        self.moved.len() as u32
    }

    /// Has a face of `level` descendants with a detail at a corner?
    pub fn moves_below(&self, level: u32, face: FaceCode) -> bool {
        (level + 1..self.depth()).any(|finer| !self.moved_below(level, face, finer).is_empty())
    }

    /// The descendants, at `finer`, of a face of `level` that have a corner with a detail.
    pub fn moved_below(&self, level: u32, face: FaceCode, finer: u32) -> &[FaceCode] {
        let Some(moved) = self.moved.get(finer as usize) else { return &[] };
        let shift = 2 * (finer - level);
        let begin = moved.partition_point(|f| f.0 >> shift < face.0);
        let end = moved.partition_point(|f| f.0 >> shift <= face.0);
        &moved[begin..end]
    }
}

/// All of both; both ascend.
pub fn union(a: &[FaceCode], b: &[FaceCode]) -> Vec<FaceCode> {
    if a.is_empty() || b.is_empty() {
        return if a.is_empty() { b.to_vec() } else { a.to_vec() };
    }
    let mut all = Vec::with_capacity(a.len() + b.len());
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    while let (Some(&&x), Some(&&y)) = (a.peek(), b.peek()) {
        all.push(x.min(y));
        if x <= y {
            a.next();
        }
        if y <= x {
            b.next();
        }
    }
    all.extend(a.chain(b));
    all
}

/// The faces of `level` around the vertex at `address`; none if there is no such vertex.
fn faces_around(mesh: &Connectivity, level: u32, address: Address) -> Vec<FaceCode> {
    let Some((face, corner)) = region::corner_at(mesh, level, address) else { return Vec::new() };
    let mut faces = vec![face];
    region::fan(mesh, level, face, corner, &mut faces);
    faces
}
