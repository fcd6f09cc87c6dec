//! The triangles between lattice points, and where these lie.

use glam::DVec2;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::Lattice;

use crate::parallel;

/// Faces that are worked on together.
const FACES_PER_BLOCK: usize = 64;

/// The triangles of `lattice` on `mesh`, counter-clockwise: `steps^2` for each face, faces in order.
///
/// A face's triangles go row by row along its third corner: row `i` alternates between
/// `(i, j) (i + 1, j) (i, j + 1)` and `(i + 1, j) (i + 1, j + 1) (i, j + 1)`, `j` rising.
pub fn triangles(mesh: &Connectivity, lattice: &Lattice) -> Vec<[u32; 3]> {
    let per_face = lattice.steps() * lattice.steps();
    let mut triangles = vec![[0; 3]; lattice.triangle_count()];
    let blocks: Vec<_> = triangles.chunks_mut(FACES_PER_BLOCK * per_face).enumerate().collect();
    parallel::for_each(blocks, |(block, triangles)| {
        let (mut low, mut high) = (Vec::new(), Vec::new());
        for (i, own) in triangles.chunks_exact_mut(per_face).enumerate() {
            let face = FaceId::new(block * FACES_PER_BLOCK + i);
            let mut rest = own;
            write_row(mesh, lattice, face, 0, &mut low);
            for row in 0..lattice.steps() {
                write_row(mesh, lattice, face, row + 1, &mut high);
                let (strip, others) = rest.split_at_mut(2 * (lattice.steps() - row) - 1);
                write_strip(&low, &high, strip);
                rest = others;
                core::mem::swap(&mut low, &mut high);
            }
        }
    });
    triangles
}

/// The numbers of the vertices `(row, 0) .. (row, steps - row)` of `face`.
fn write_row(mesh: &Connectivity, lattice: &Lattice, face: FaceId, row: usize, numbers: &mut Vec<u32>) {
    let n = lattice.steps();
    let [bottom, far, left] = [0, 1, 2].map(|i| HalfedgeId::of(face, i));
    numbers.clear();
    if row == 0 {
        return numbers.extend((0..=n).map(|j| lattice.along(mesh, left, n - j)));
    }
    numbers.push(lattice.along(mesh, bottom, row));
    if row < n {
        let inside = lattice.face(face) + if row + 1 < n { lattice.inside(row, 1) as u32 } else { 0 };
        numbers.extend(inside..inside + (n - row - 1) as u32);
        numbers.push(lattice.along(mesh, far, n - row));
    }
}

/// The triangles between two rows, the upper one shorter by one.
fn write_strip(low: &[u32], high: &[u32], strip: &mut [[u32; 3]]) {
    for ((pair, low), high) in strip.chunks_mut(2).zip(low.windows(2)).zip(high) {
        pair[0] = [low[0], *high, low[1]];
    }
    for ((pair, low), high) in strip.chunks_exact_mut(2).zip(&low[1..]).zip(high.windows(2)) {
        pair[1] = [high[0], high[1], *low];
    }
}

/// Where each vertex of `lattice` lies: on the first face that has it.
pub fn origins(mesh: &Connectivity, lattice: &Lattice) -> Vec<SurfacePoint> {
    let n = lattice.steps();
    let share = |i: usize| i as f64 / n as f64;
    let corners = (0..mesh.vertex_count()).map(|v| {
        let h = mesh.ring(VertexId::new(v)).min().expect("no vertex is unused");
        along(h, 0.0)
    });
    let edges = (0..mesh.edge_count()).flat_map(|e| {
        let h = mesh.halfedge(selvedge_components::mesh::EdgeId::new(e));
        let forward = mesh.from(h) < mesh.to(h);
        (1..n).map(move |k| along(h, share(if forward { k } else { n - k })))
    });
    let inside = (0..mesh.face_count()).flat_map(|f| {
        (1..n).flat_map(move |i| (1..n - i).map(move |j| SurfacePoint::new(FaceId::new(f), share(i), share(j))))
    });
    let mut origins = Vec::with_capacity(lattice.vertex_count());
    origins.extend(corners.chain(edges).chain(inside));
    origins
}

/// The point a share of the way along `h`.
fn along(h: HalfedgeId, share: f64) -> SurfacePoint {
    let rest = 1.0 - share;
    let st = [DVec2::new(share, 0.0), DVec2::new(rest, share), DVec2::new(0.0, rest)][h.corner()];
    SurfacePoint { face: h.face(), st }
}
