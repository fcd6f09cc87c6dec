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
