//! Half-edges sorted by the undirected edge that they run along.

/// The half-edges of a list of faces, grouped by undirected edge.
///
/// A bucket per vertex holds the edges of which it is the smaller end; a bucket is as long as the
/// vertex's valence, so sorting inside the buckets costs next to nothing and nothing is hashed.
#[derive(Clone, Debug)]
pub(super) struct EdgeGroups {
    /// Where the bucket of each vertex begins, and one entry more for the end.
    start: Vec<u32>,
    /// `(larger end, half-edge)`, ascending in each bucket.
    buckets: Vec<(u32, u32)>,
}

impl EdgeGroups {
    /// Groups the half-edges of `faces`, which name vertices in `0..vertex_count`.
    pub(super) fn new(vertex_count: usize, faces: &[[u32; 3]]) -> Self {
        let mut start = vec![0_u32; vertex_count + 1];
        for h in 0..3 * faces.len() {
            let (low, _) = ends(faces, h);
            start[low as usize + 1] += 1;
        }
        for v in 0..vertex_count {
            start[v + 1] += start[v];
        }
        let mut fill = start.clone();
        let mut buckets = vec![(0_u32, 0_u32); 3 * faces.len()];
        for h in 0..3 * faces.len() {
            let (low, high) = ends(faces, h);
            let at = &mut fill[low as usize];
            buckets[*at as usize] = (high, h as u32);
            *at += 1;
        }
        for v in 0..vertex_count {
            buckets[start[v] as usize..start[v + 1] as usize].sort_unstable();
        }
        Self { start, buckets }
    }

    /// Every edge, by its smaller end and then its larger one: all half-edges that run along it,
    /// ascending, each as `(larger end, half-edge)`.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[(u32, u32)]> {
        self.start.windows(2).flat_map(|bounds| {
            let bucket = &self.buckets[bounds[0] as usize..bounds[1] as usize];
            bucket.chunk_by(|a, b| a.0 == b.0)
        })
    }
}

/// The ends of half-edge `h`, smaller first.
pub(super) fn ends(faces: &[[u32; 3]], h: usize) -> (u32, u32) {
    let face = faces[h / 3];
    let (a, b) = (face[h % 3], face[(h + 1) % 3]);
    (a.min(b), a.max(b))
}
