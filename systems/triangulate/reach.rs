//! How far stored details reach: which limit points of a level wait for finer ones.
//!
//! A detail of level `m` moves the limit points of its own vertex and of that vertex's neighbours at
//! level `m`, since the limit mask reads one ring. So the limit point of a vertex is final on the first level from which no finer level has
//! a detail on the vertex or next to it. That level follows from the surface alone: a vertex has the
//! same bits in every triangulation.

use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::{Address, Details, FaceCode};

use crate::subdivision::region;

/// What the details of one surface move, by level.
#[derive(Debug, Default)]
pub struct Reach {
    levels: Vec<Level>,
}

#[derive(Debug, Default)]
struct Level {
    /// Faces that have a corner with a detail of this level, ascending.
    moved: Vec<FaceCode>,
    /// Faces that have corners whose limit points finer details move, ascending; and which corners,
    /// one bit each.
    waiting: Vec<(FaceCode, u8)>,
}

impl Reach {
    /// What `details` move on the surface over `mesh`. A detail whose address is not one of its
    /// level moves nothing.
    pub fn new(mesh: &Connectivity, details: &Details) -> Self {
        let depth = details.depth().min(FaceCode::finest(mesh.face_count()) + 1);
        let mut levels: Vec<Level> = (0..depth).map(|_| Level::default()).collect();
        for (level, stored) in (0..depth).zip(&details.levels) {
            let around = |&(address, _): &(Address, _)| faces_around(mesh, level, address);
            levels[level as usize].moved = region::ascending(stored.iter().flat_map(around).collect());
        }
        for m in (1..levels.len()).rev() {
            let (coarser, finer) = levels.split_at_mut(m);
            coarser[m - 1].waiting = waiting_parents(&finer[0]);
        }
        Self { levels }
    }

    /// One more than the finest level that has a detail.
    pub fn depth(&self) -> u32 {
        self.levels.len() as u32
    }

    /// The faces of `level` with corners whose limit points wait for details of finer levels, and
    /// which corners: bit `c` for corner `c`.
    pub fn waiting(&self, level: u32) -> &[(FaceCode, u8)] {
        self.levels.get(level as usize).map_or(&[], |l| &l.waiting)
    }

    /// Which corners of a face of `level` wait.
    pub fn waits(&self, level: u32, face: FaceCode) -> u8 {
        let waiting = self.waiting(level);
        waiting.binary_search_by_key(&face, |w| w.0).map_or(0, |i| waiting[i].1)
    }

    /// The descendants, at `finer`, of a face of `level` that have a corner with a detail.
    pub fn moved_below(&self, level: u32, face: FaceCode, finer: u32) -> &[FaceCode] {
        let Some(l) = self.levels.get(finer as usize) else { return &[] };
        let shift = 2 * (finer - level);
        let begin = l.moved.partition_point(|f| f.0 >> shift < face.0);
        let end = l.moved.partition_point(|f| f.0 >> shift <= face.0);
        &l.moved[begin..end]
    }
}

/// A corner of a face waits if the child that holds it has a detail of its own level, or waits.
fn waiting_parents(fine: &Level) -> Vec<(FaceCode, u8)> {
    let mut bits: Vec<(FaceCode, u8)> = Vec::new();
    for &child in &fine.moved {
        if child.child_number() < 3 {
            bits.push((child.parent(), 1 << child.child_number()));
        }
    }
    for &(child, corners) in &fine.waiting {
        let number = child.child_number();
        if number < 3 && corners >> number & 1 == 1 {
            bits.push((child.parent(), 1 << number));
        }
    }
    bits.sort_unstable();
    bits.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 |= next.1;
        }
        same
    });
    bits
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
