//! The edges of triangles, and chains of them.

use selvedge_components::triangles::Triangles;

use super::error::DiagramError;

/// An edge of a mesh.
pub(super) struct Edge {
    /// Its vertices, ascending.
    pub ends: [u32; 2],
    /// How many triangles have it.
    pub triangles: u32,
}

/// Every edge once, in ascending order.
pub(super) fn edges(mesh: &Triangles) -> Result<Vec<Edge>, DiagramError> {
    let count = mesh.positions.len();
    let mut all = Vec::with_capacity(3 * mesh.triangles.len());
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= count) {
            return Err(DiagramError::IndexOutOfRange { triangle, vertex, count });
        }
        let [a, b, c] = *corners;
        all.extend([[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)]));
    }
    all.sort_unstable();
    Ok(all.chunk_by(|a, b| a == b).map(|same| Edge { ends: same[0], triangles: same.len() as u32 }).collect())
}

/// Joins edges end to end into chains as long as possible, in the order of the edges; a closed
/// chain ends where it began.
pub(super) fn chain_up(edges: &[[u32; 2]]) -> Vec<Vec<u32>> {
    let mut ways: Vec<(u32, usize)> = edges.iter().enumerate().flat_map(|(i, ends)| ends.map(|end| (end, i))).collect();
    ways.sort_unstable();
    let mut used = vec![false; edges.len()];
    let mut chains = Vec::new();
    // Ends of open chains first, so that none is begun in its middle.
    let alone = ways.chunk_by(|a, b| a.0 == b.0).filter(|at| at.len() % 2 == 1).map(|at| at[0].0);
    let starts: Vec<u32> = alone.chain(edges.iter().map(|ends| ends[0])).collect();
    for start in starts {
        let mut chain = vec![start];
        let mut here = start;
        loop {
            let from = ways.partition_point(|way| way.0 < here);
            let next = ways[from..].iter().take_while(|way| way.0 == here).find(|way| !used[way.1]);
            let Some(&(_, edge)) = next else { break };
            used[edge] = true;
            let [a, b] = edges[edge];
            here = if a == here { b } else { a };
            chain.push(here);
        }
        if chain.len() > 1 {
            chains.push(chain);
        }
    }
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_triangles_have_five_edges_one_of_them_shared() {
        let mesh = Triangles {
            positions: vec![glam::DVec3::ZERO; 4],
            triangles: vec![[0, 1, 2], [2, 1, 3]],
            ..Triangles::default()
        };
        let all = edges(&mesh).expect("indices in range");
        assert_eq!(all.len(), 5);
        let shared: Vec<[u32; 2]> = all.iter().filter(|edge| edge.triangles == 2).map(|edge| edge.ends).collect();
        assert_eq!(shared, [[1, 2]]);
    }

    #[test]
    fn chains_use_every_edge_once_and_begin_at_open_ends() {
        assert_eq!(chain_up(&[[1, 2], [0, 1], [2, 3]]), [[0, 1, 2, 3]]);
        assert_eq!(chain_up(&[[0, 1], [1, 2], [0, 2]]), [[0, 1, 2, 0]]);
        let two_loops = chain_up(&[[0, 1], [1, 2], [0, 2], [5, 6], [6, 7], [5, 7]]);
        assert_eq!(two_loops.len(), 2);
        let star = [[0, 1], [0, 2], [0, 3]];
        let used: usize = chain_up(&star).iter().map(|chain| chain.len() - 1).sum();
        assert_eq!(used, 3);
    }
}
