//! How a leaf meets finer neighbours: its triangles use the vertices that halve its edges.
//!
//! ```text
//!        2              2               2               2
//!       / \            /|\             / \             / \
//!      /   \          / | \          20---12          20--12
//!     /     \        /  |  \         /  \ / \         / \ / \
//!    0-------1      0--01---1       0----.---1       0--01---1
//!       none           one       two: the shorter       three
//!                                 diagonal
//! ```
//!
//! In a flat leaf no triangle is thinner, by `2 area / longest^2`, than a quarter of the leaf's own:
//! each has a quarter of its area or more, and no edge longer than its longest.

use glam::DVec3;

/// The triangles of a leaf with the given `corners`, counter-clockwise, and vertices `halves[i]`
/// inside the edge from corner `i` to corner `i + 1`, where a neighbour is finer. `position` gives
/// positions; calls `put` for each triangle.
pub fn close(
    corners: [u32; 3],
    halves: [Option<u32>; 3],
    position: impl Fn(u32) -> DVec3,
    mut put: impl FnMut([u32; 3]),
) {
    let [a, b, c] = corners;
    match halves {
        [None, None, None] => put(corners),
        [Some(ab), Some(bc), Some(ca)] => {
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().for_each(put)
        }
        [Some(m), None, None] => halve([a, b, c], m, put),
        [None, Some(m), None] => halve([b, c, a], m, put),
        [None, None, Some(m)] => halve([c, a, b], m, put),
        [Some(m), Some(n), None] => cut_corner([a, b, c], m, n, &position, put),
        [None, Some(m), Some(n)] => cut_corner([b, c, a], m, n, &position, put),
        [Some(n), None, Some(m)] => cut_corner([c, a, b], m, n, &position, put),
    }
}

/// `m` is inside the edge from the first corner to the second.
fn halve([a, b, c]: [u32; 3], m: u32, mut put: impl FnMut([u32; 3])) {
    put([a, m, c]);
    put([m, b, c]);
}

/// `m` is inside the edge from the first corner to the second, `n` inside the next: cuts the second
/// corner off, and the rest along its shorter diagonal; along the one from the first corner where
/// both are the same.
fn cut_corner([a, b, c]: [u32; 3], m: u32, n: u32, position: &impl Fn(u32) -> DVec3, mut put: impl FnMut([u32; 3])) {
    put([m, b, n]);
    if position(a).distance_squared(position(n)) <= position(m).distance_squared(position(c)) {
        put([a, m, n]);
        put([a, n, c]);
    } else {
        put([a, m, c]);
        put([m, n, c]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::triangulate::shape;

    /// Corners 0, 1, 2 of a flat leaf and the middles 3, 4, 5 of its edges.
    fn leaf(apex: DVec3) -> [DVec3; 6] {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, apex];
        [a, b, c, a.midpoint(b), b.midpoint(c), c.midpoint(a)]
    }

    fn closed(points: &[DVec3; 6], pattern: u32) -> Vec<[u32; 3]> {
        let halves = [0, 1, 2].map(|e| (pattern >> e & 1 == 1).then_some(3 + e));
        let mut triangles = Vec::new();
        close([0, 1, 2], halves, |v| points[v as usize], |t| triangles.push(t));
        triangles
    }

    /// Flat leaves, from equilateral to thin ones whose longest edge is any of the three.
    fn leaves() -> impl Iterator<Item = [DVec3; 6]> {
        (-20..=30).flat_map(|x| (1..=20).map(move |y| leaf(0.1 * DVec3::new(f64::from(x), f64::from(y), 0.0))))
    }

    /// One triangle more for each vertex, each the right way round, together the leaf; every half
    /// edge of the leaf once, and every edge inside from both sides.
    #[test]
    fn every_pattern_fills_the_leaf_edge_to_edge() {
        for points in leaves() {
            for pattern in 0..8 {
                let triangles = closed(&points, pattern);
                assert_eq!(triangles.len() as u32, 1 + pattern.count_ones());
                let area = |t: &[u32; 3]| {
                    let [a, b, c] = t.map(|v| points[v as usize]);
                    (b - a).cross(c - a).z
                };
                assert!(triangles.iter().all(|t| area(t) > 0.0), "pattern {pattern}");
                let total: f64 = triangles.iter().map(area).sum();
                assert!((total - area(&[0, 1, 2])).abs() < 1e-14);
                let edges: Vec<_> = triangles.iter().flat_map(|t| [0, 1, 2].map(|i| (t[i], t[(i + 1) % 3]))).collect();
                let open = edges.iter().filter(|&&(a, b)| !edges.contains(&(b, a))).count();
                assert_eq!(open as u32, 3 + pattern.count_ones());
            }
        }
    }

    /// The bound that the module states.
    #[test]
    fn no_triangle_is_thinner_than_a_quarter_of_its_leaf() {
        for points in leaves() {
            let shape = |t: &[u32; 3]| shape(t.map(|v| points[v as usize]));
            for pattern in 0..8 {
                let worst = closed(&points, pattern).iter().map(shape).fold(1.0, f64::min);
                assert!(worst >= 0.25 * shape(&[0, 1, 2]), "pattern {pattern} of {points:?}");
            }
        }
    }
}
