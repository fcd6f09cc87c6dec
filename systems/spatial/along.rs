//! What a line meets: the tree's boxes by fours.
//!
//! A line visits few boxes and asks many that it misses: four at a time they are asked at once. All is in
//! f32, in the tree's own frame about the point of the line nearest to its centre; every box is grown by what
//! rounding may take off.

use std::sync::OnceLock;

use glam::DVec3;
use smallvec::SmallVec;

use super::{Bvh, Node};

/// The nodes by fours, once a line has asked.
#[derive(Clone, Debug, Default)]
pub(super) struct Fours(OnceLock<Vec<Four>>);

/// Up to four boxes, coordinate by coordinate; those that are not there hold nothing.
#[derive(Clone, Copy, Debug)]
struct Four {
    min: [[f32; 4]; 3],
    max: [[f32; 4]; 3],
    children: [u32; 4],
}

/// Marks a child that is a leaf: the rest is its node in the tree. Others are known by their place among the
/// fours.
const LEAF: u32 = 1 << 31;

impl Four {
    /// Inside out, and beyond the frame: a line leaves these before it enters them. Infinity less its own slack
    /// would be no number.
    const EMPTY: Self = Self { min: [[8.0; 4]; 3], max: [[-8.0; 4]; 3], children: [LEAF; 4] };

    fn put(&mut self, lane: usize, node: &Node, child: u32) {
        for axis in 0..3 {
            (self.min[axis][lane], self.max[axis][lane]) = (node.min[axis], node.max[axis]);
        }
        self.children[lane] = child;
    }
}

/// Sorts a tree's nodes by fours: of the boxes below a node the largest gives way to its two, until there
/// are four.
fn fours(nodes: &[Node]) -> Vec<Four> {
    let mut all = Vec::with_capacity(nodes.len() / 3 + 1);
    // Which node each of the fours stands for.
    let mut open = vec![0_u32];
    while let Some(&top) = open.get(all.len()) {
        let mut below = SmallVec::<[u32; 4]>::from_slice(&[top]);
        let is_inner = |n: u32| nodes[n as usize].count == 0;
        while below.len() < 4 {
            let inner = (0..below.len()).filter(|&k| is_inner(below[k]));
            let largest =
                inner.max_by(|&a, &b| nodes[below[a] as usize].area().total_cmp(&nodes[below[b] as usize].area()));
            let Some(largest) = largest else { break };
            let first = nodes[below[largest] as usize].first;
            below[largest] = first;
            below.push(first + 1);
        }
        let mut four = Four::EMPTY;
        for (lane, &n) in below.iter().enumerate() {
            let child = if is_inner(n) {
                open.push(n);
                open.len() as u32 - 1
            } else {
                n | LEAF
            };
            four.put(lane, &nodes[n as usize], child);
        }
        all.push(four);
    }
    all
}

impl Node {
    /// Half the area of its box.
    fn area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|axis| self.max[axis] - self.min[axis]);
        x * y + y * z + z * x
    }
}

/// A line in a tree's frame, which boxes within `[-1, 1]` fill.
///
/// Its parameter is 0 at the point nearest to the centre, and the direction's largest coordinate is 1.
struct Line {
    /// By axis, the coordinate that the nearer sides of boxes are measured from, and the farther ones: apart by
    /// what rounding may take off.
    from: [[f32; 2]; 3],
    inverse: [f32; 3],
    /// The parameter that is 0 here, and how many of these make one there.
    zero: f64,
    scale: f64,
}

/// What products in f32 lose at most, as a share.
const SLACK: f32 = 4.0 * f32::EPSILON;

/// Along an axis on which the line moves less than this it does not move at all, as far as boxes can tell.
const STILL: f64 = 1e-30;

impl Line {
    /// `None` if the line passes the frame by, or is no line.
    fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let scale = direction.abs().max_element();
        let along = direction / scale;
        let zero = -origin.dot(along) / along.length_squared();
        let nearest = origin + along * zero;
        // Boxes and this point in f32, differences of them; and the digits that a far origin has lost.
        let pad = 8.0 * f64::from(f32::EPSILON) + 8.0 * f64::EPSILON * (origin.abs().max_element() + zero.abs());
        // The frame's own radius is below 2.
        if nearest.length() > 2.0 + pad || !along.is_finite() {
            return None;
        }
        let inverse = along.to_array().map(|x| if x.abs() < STILL { STILL.recip() } else { x.recip() });
        let from = core::array::from_fn(|axis| {
            let [least, most] = [nearest[axis] - pad, nearest[axis] + pad].map(|x| x as f32);
            if inverse[axis] < 0.0 { [least, most] } else { [most, least] }
        });
        Some(Self { from, inverse: inverse.map(|x| x as f32), zero: zero / scale, scale })
    }

    /// The line's parameter here.
    fn parameter(&self, t: f64) -> f32 {
        ((t - self.zero) * self.scale) as f32
    }

    /// Where the line enters each of the boxes, and where it leaves.
    #[inline]
    fn pass(&self, boxes: &Four) -> [[f32; 4]; 2] {
        let (mut enter, mut leave) = ([f32::NEG_INFINITY; 4], [f32::INFINITY; 4]);
        for axis in 0..3 {
            let (inverse, [near_from, far_from]) = (self.inverse[axis], self.from[axis]);
            let (low, high) = (&boxes.min[axis], &boxes.max[axis]);
            let (near, far) = if inverse < 0.0 { (high, low) } else { (low, high) };
            for lane in 0..4 {
                let (near, far) = ((near[lane] - near_from) * inverse, (far[lane] - far_from) * inverse);
                enter[lane] = if near > enter[lane] { near } else { enter[lane] };
                leave[lane] = if far < leave[lane] { far } else { leave[lane] };
            }
        }
        for lane in 0..4 {
            enter[lane] -= SLACK * enter[lane].abs();
            leave[lane] += SLACK * leave[lane].abs();
        }
        [enter, leave]
    }
}

impl Bvh {
    /// Visits the boxes that the line `origin + t direction` may meet for `t` in `range`, roughly in
    /// the order of `t`. `visit` gets a box and the range's end so far and returns the new one.
    pub fn along(&self, origin: DVec3, direction: DVec3, range: [f64; 2], mut visit: impl FnMut(u32, f64) -> f64) {
        let line = Line::new((origin - self.origin) * self.scale, direction * self.scale);
        let (Some(line), false) = (line, self.nodes.is_empty()) else { return };
        let fours = self.fours.0.get_or_init(|| fours(&self.nodes));
        // Ends in f32, rounded outward.
        let begin = line.parameter(range[0]);
        let begin = begin - SLACK * begin.abs();
        let last = |end: f64| {
            let end = line.parameter(end);
            end + SLACK * end.abs()
        };
        let (mut exact, mut end) = (range[1], last(range[1]));
        let mut stack = SmallVec::<[(f32, u32); 64]>::new();
        stack.push((begin, 0));
        while let Some((t, n)) = stack.pop() {
            if t > end {
                continue;
            }
            if n & LEAF != 0 {
                for &primitive in self.leaf(&self.nodes[(n & !LEAF) as usize]) {
                    exact = visit(primitive, exact);
                }
                end = last(exact);
                continue;
            }
            let four = &fours[n as usize];
            let [enter, leave] = line.pass(four);
            let bottom = stack.len();
            for lane in 0..4 {
                let enter = if enter[lane] > begin { enter[lane] } else { begin };
                let leave = if leave[lane] < end { leave[lane] } else { end };
                if enter <= leave {
                    // The nearest comes to lie on top.
                    let mut at = stack.len();
                    stack.push((enter, four.children[lane]));
                    while at > bottom && stack[at - 1].0 < enter {
                        stack.swap(at - 1, at);
                        at -= 1;
                    }
                }
            }
        }
    }
}
