//! # Clean up: flips of edges bring valences back to six
//!
//! The error of a trimmed surface falls by `1 / lambda^2` per level at a vertex of valence `k`, for
//! `lambda = 3/8 + cos(2 pi / k) / 4`: by 3.55 at valence 7, by 3.28 at 8. So high valences are worth
//! avoiding.

use std::collections::HashSet;

use glam::DVec3;
use selvedge_components::mesh::{Connectivity, EdgeId, VertexId};

/// The cosine of the smallest angle that a flip may make, 15 degrees: thinner triangles cost more in
/// the fit than a valence gains.
pub const SMALLEST_ANGLE_COSINE: f64 = 0.965_925_826_289_068_3;

/// Rounds; each lowers the sum of squares, most of it in the first.
const ROUNDS: u32 = 20;

/// Flips edges of `triangles` between vertices that `may` names while that lowers the sum of
/// `(valence - 6)^2`. Vertices on a border keep their edges. Returns the triangles that changed,
/// ascending.
pub fn clean_up(
    mut mesh: Connectivity,
    triangles: &mut [[u32; 3]],
    positions: &[DVec3],
    may: impl Fn(u32) -> bool,
) -> Vec<u32> {
    let mut changed = HashSet::new();
    for _ in 0..ROUNDS {
        let mut valence: Vec<i64> =
            (0..mesh.vertex_count()).map(|v| i64::from(mesh.valence(VertexId::new(v)))).collect();
        let mut busy = vec![false; triangles.len()];
        let mut made = HashSet::new();
        for e in (0..mesh.edge_count()).map(EdgeId::new) {
            let h = mesh.halfedge(e);
            let Some(twin) = mesh.twin(h) else { continue };
            let (f, g) = (h.face().index(), twin.face().index());
            let [a, b, c, d] = [mesh.from(h), mesh.to(h), mesh.opposite(h), mesh.opposite(twin)];
            let quad = [a, b, c, d];
            if busy[f] || busy[g] || quad.iter().any(|&v| mesh.is_border(v) || !may(v.0)) {
                continue;
            }
            let key = (c.min(d), c.max(d));
            if c == d || made.contains(&key) || mesh.neighbours(c).any(|n| n == d) {
                continue;
            }
            let cost = |change: [i64; 4]| -> i64 {
                quad.iter().zip(change).map(|(v, x)| (valence[v.index()] + x - 6).pow(2)).sum()
            };
            // A valence below four makes folds, whatever the sum says.
            let fair = valence[a.index()] > 4 && valence[b.index()] > 4;
            if !fair || cost([-1, -1, 1, 1]) >= cost([0; 4]) || !is_sound(quad.map(|v| positions[v.index()])) {
                continue;
            }
            triangles[f] = [a.0, d.0, c.0];
            triangles[g] = [d.0, b.0, c.0];
            for (v, x) in quad.iter().zip([-1, -1, 1, 1]) {
                valence[v.index()] += x;
            }
            (busy[f], busy[g]) = (true, true);
            made.insert(key);
            changed.extend([f as u32, g as u32]);
        }
        if made.is_empty() {
            break;
        }
        match Connectivity::new(positions.len(), triangles) {
            Ok(next) => mesh = next,
            // Flips that pass the checks above keep a manifold one.
            Err(_) => break,
        }
    }
    let mut changed: Vec<u32> = changed.into_iter().collect();
    changed.sort_unstable();
    changed
}

/// May the edge `a b` of the triangles `a b c` and `b a d` become `c d`?
fn is_sound([a, b, c, d]: [DVec3; 4]) -> bool {
    let normal = (b - a).cross(c - a) + (a - b).cross(d - b);
    let facing = |[p, q, r]: [DVec3; 3]| (q - p).cross(r - p).dot(normal) > 0.0;
    let wide = |[p, q, r]: [DVec3; 3]| {
        let angle = |a: DVec3, b: DVec3| a.dot(b) <= SMALLEST_ANGLE_COSINE * a.length() * b.length();
        angle(q - p, r - p) && angle(r - q, p - q) && angle(p - r, q - r)
    };
    let after = [[a, d, c], [d, b, c]];
    after.into_iter().all(facing) && after.into_iter().all(wide)
}
