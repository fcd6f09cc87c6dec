//! Diagonals turned where that brings valences nearer to their targets.
//!
//! ```text
//!       c              c
//!      / \            /|\
//!     a---b   ->     a | b
//!      \ /            \|/
//!       d              d
//! ```
//!
//! One turn after the other comes to rest far from the best: what one diagonal would hand on to its
//! neighbour, the neighbour would have to hand on again. So turns are tried in chains, as in the
//! heuristic of Kernighan and Lin (1970): each next turn takes an edge from a vertex that the last one
//! gave an edge to, and is the best of those that do, be it good by itself or not. A chain that does
//! not make the sum smaller is taken back.

use super::{Piece, Valences, edge, sides};

/// Turns in a chain. On the control cage of a cow (`data/cages/spot_control_mesh.obj`) chains of at
/// most 1, 2, 3, 4, 5, 6, 8 turns end with a sum that is 31, 25, 14, 14, 8, 3, 3 percent above the
/// best that simulated annealing finds; the time grows in proportion.
const LONGEST_CHAIN: usize = 6;

/// Every chain that is kept makes the sum smaller, so turning ends by itself, most often in the third
/// round. This bounds the time that it takes on a mesh made to be slow: so many triangles are looked
/// at for each triangle that there is.
const LOOKS_PER_TRIANGLE: usize = 1 << 10;

/// Turns diagonals of the pieces while that makes the sum smaller, or brings triangles that wind
/// against their face to wind with it.
pub(super) fn improve(mesh: &mut Valences<'_>, triangles: &mut [[u32; 3]], pieces: &[Piece]) {
    let mut turner = Turner::new(mesh, triangles, pieces);
    let mut kept = usize::MAX;
    while kept > 0 && turner.looks > 0 {
        kept = (0..turner.diagonals.len()).map(|start| usize::from(turner.chain(start))).sum();
    }
}

/// An edge between two triangles of one piece.
#[derive(Clone, Copy)]
struct Diagonal {
    ends: [u32; 2],
    piece: usize,
}

/// A turn that can be made or taken back.
#[derive(Clone, Copy)]
struct Turn {
    diagonal: usize,
    /// The two triangles along the diagonal.
    at: [usize; 2],
    old: [[u32; 3]; 2],
    new: [[u32; 3]; 2],
    old_ends: [u32; 2],
    new_ends: [u32; 2],
    /// By how much the sum grows.
    rise: i128,
    /// How many more of the triangles wind with their face.
    mended: i32,
}

struct Turner<'a, 'b> {
    mesh: &'a mut Valences<'b>,
    triangles: &'a mut [[u32; 3]],
    pieces: &'a [Piece],
    diagonals: Vec<Diagonal>,
    /// The diagonals that end at each vertex.
    around: Vec<Vec<usize>>,
    /// How many more triangles may be looked at.
    looks: usize,
}

impl<'a, 'b> Turner<'a, 'b> {
    fn new(mesh: &'a mut Valences<'b>, triangles: &'a mut [[u32; 3]], pieces: &'a [Piece]) -> Self {
        let mut diagonals = Vec::new();
        let mut along = Vec::new();
        for (piece, Piece { triangles: range, .. }) in pieces.iter().enumerate() {
            along.clear();
            along.extend(triangles[range.clone()].iter().flat_map(|t| sides(t)).map(|(a, b)| edge(a, b)));
            along.sort_unstable();
            let twice = along.windows(2).filter(|pair| pair[0] == pair[1]);
            diagonals.extend(twice.map(|pair| Diagonal { ends: pair[0], piece }));
        }
        let mut around = vec![Vec::new(); mesh.excess.len()];
        for (i, diagonal) in diagonals.iter().enumerate() {
            diagonal.ends.iter().for_each(|&v| around[v as usize].push(i));
        }
        let looks = triangles.len().saturating_mul(LOOKS_PER_TRIANGLE);
        Self { mesh, triangles, pieces, diagonals, around, looks }
    }

    /// Turns `start` and what should follow it, and keeps that if it makes the sum smaller.
    fn chain(&mut self, start: usize) -> bool {
        let mut made: Vec<Turn> = Vec::with_capacity(LONGEST_CHAIN);
        let mut rise = 0;
        let mut next = self.turn_of(start);
        while let Some(turn) = next {
            self.make(&turn);
            made.push(turn);
            rise += turn.rise;
            if rise < 0 || turn.mended > 0 {
                return true;
            }
            next = if made.len() < LONGEST_CHAIN { self.best_after(&made) } else { None };
        }
        while let Some(turn) = made.pop() {
            self.take_back(&turn);
        }
        false
    }

    /// The best turn of a diagonal that ends where the last turn made an edge. Of equals the first.
    fn best_after(&mut self, made: &[Turn]) -> Option<Turn> {
        let ends = made.last()?.new_ends;
        let mut best: Option<Turn> = None;
        for end in ends {
            for i in 0..self.around[end as usize].len() {
                let diagonal = self.around[end as usize][i];
                if made.iter().any(|turn| turn.diagonal == diagonal) {
                    continue;
                }
                let Some(turn) = self.turn_of(diagonal) else { continue };
                let key = |turn: &Turn| (turn.rise, turn.diagonal);
                if best.as_ref().is_none_or(|best| key(&turn) < key(best)) {
                    best = Some(turn);
                }
            }
        }
        best
    }

    /// What turning a diagonal would do; `None` where it would lie along an edge or make a triangle
    /// wind against the face.
    fn turn_of(&mut self, diagonal: usize) -> Option<Turn> {
        let Diagonal { ends: [a, b], piece } = self.diagonals[diagonal];
        let Piece { normal, triangles: ref range } = self.pieces[piece];
        self.looks = self.looks.checked_sub(range.len())?;
        let find = |a, b| range.clone().find_map(|t| Some((t, apex(self.triangles[t], a, b)?)));
        let ((s, c), (t, d)) = (find(a, b)?, find(b, a)?);
        if c == d || self.mesh.joins(c, d) {
            return None;
        }
        let (old, new) = ([self.triangles[s], self.triangles[t]], [[c, a, d], [d, b, c]]);
        let right = |two: [[u32; 3]; 2]| two.map(|t| i32::from(self.mesh.winds_with(normal, t))).iter().sum::<i32>();
        let mended = right(new) - right(old);
        let rise = [(a, -1), (b, -1), (c, 1), (d, 1)].iter().map(|&(v, by)| self.mesh.rise(v, by)).sum();
        let turn = Turn { diagonal, at: [s, t], old, new, old_ends: [a, b], new_ends: [c, d], rise, mended };
        (mended >= 0).then_some(turn)
    }

    fn make(&mut self, turn: &Turn) {
        self.replace(turn, turn.old_ends, turn.new_ends, turn.new);
    }

    fn take_back(&mut self, turn: &Turn) {
        self.replace(turn, turn.new_ends, turn.old_ends, turn.old);
    }

    fn replace(&mut self, turn: &Turn, from: [u32; 2], to: [u32; 2], triangles: [[u32; 3]; 2]) {
        self.mesh.remove(from[0], from[1]);
        self.mesh.add(to[0], to[1]);
        for v in from {
            let around = &mut self.around[v as usize];
            around.retain(|&diagonal| diagonal != turn.diagonal);
        }
        for v in to {
            self.around[v as usize].push(turn.diagonal);
        }
        self.diagonals[turn.diagonal].ends = to;
        [self.triangles[turn.at[0]], self.triangles[turn.at[1]]] = triangles;
    }
}

/// The third corner of a triangle that runs from `a` to `b`.
fn apex(triangle: [u32; 3], a: u32, b: u32) -> Option<u32> {
    (0..3).find(|&i| triangle[i] == a && triangle[(i + 1) % 3] == b).map(|i| triangle[(i + 2) % 3])
}
