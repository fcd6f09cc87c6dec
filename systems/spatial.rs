//! What is near, what overlaps, what a ray meets: boxes in space, sorted into a tree.
//!
//! The tree is built by `obvhs` and kept here as plain nodes; nothing outside this file knows of
//! it. Its boxes are f32 about a centre of their own, rounded outward, so every answer errs on the
//! side of visiting too much; the caller's exact test in f64 decides. Visits come in an order that
//! follows from the boxes alone.

mod along;

use std::time::Duration;

use glam::DVec3;
use obvhs::aabb::Aabb;
use obvhs::bvh2::builder::build_bvh2;
use obvhs::{Boundable, BvhBuildParams};

use along::Fours;

/// A box with sides along the axes, in model units. Empty where `min` exceeds `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least coordinates.
    pub min: DVec3,
    /// The greatest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// Holds nothing.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The least box that holds all `points`.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The box and everything within `by` of it along the axes.
    pub fn grown(self, by: f64) -> Self {
        Self { min: self.min - by, max: self.max + by }
    }

    /// The least box that holds both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Do the boxes share a point?
    pub fn overlaps(&self, other: &Self) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// The squared distance from `point`; 0 inside.
    #[inline]
    pub fn distance_squared(&self, point: DVec3) -> f64 {
        (self.min - point).max(point - self.max).max(DVec3::ZERO).length_squared()
    }

    fn is_sound(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }
}

/// A tree over boxes; they are known by their place in the list it was built from.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    primitives: Vec<u32>,
    /// Boxes are kept as `(x - origin) * scale`.
    origin: DVec3,
    scale: f64,
    fours: Fours,
}

/// Children of an inner node stand side by side from `first`; primitives of a leaf too.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    min: [f32; 3],
    max: [f32; 3],
    first: u32,
    /// How many primitives; 0 for an inner node.
    count: u32,
}

/// A box on its way into the tree.
struct Rounded {
    min: [f32; 3],
    max: [f32; 3],
}

impl Boundable for Rounded {
    fn aabb(&self) -> Aabb {
        Aabb::new(self.min.into(), self.max.into())
    }
}

impl Bvh {
    /// Sorts `boxes`. One that is empty or not finite counts as holding everything, so it is always
    /// visited.
    pub fn new(boxes: &[Bounds]) -> Self {
        let all = boxes.iter().filter(|b| b.is_sound()).fold(Bounds::EMPTY, |all, b| all.union(*b));
        let all = if all.is_sound() { all } else { Bounds { min: DVec3::ZERO, max: DVec3::ZERO } };
        let origin = all.min * 0.5 + all.max * 0.5;
        let scale = scale_for((all.max * 0.5 - all.min * 0.5).max_element());
        let rounded: Vec<Rounded> = boxes
            .iter()
            .map(|b| {
                let Bounds { min, max } = if b.is_sound() { *b } else { all };
                let down = |x: f64, o: f64| below(((x - o) * scale).next_down());
                let up = |x: f64, o: f64| above(((x - o) * scale).next_up());
                Rounded {
                    min: [down(min.x, origin.x), down(min.y, origin.y), down(min.z, origin.z)],
                    max: [up(max.x, origin.x), up(max.y, origin.y), up(max.z, origin.z)],
                }
            })
            .collect();
        let mut spent = Duration::ZERO;
        // What is asked of a primitive costs more than its box does: each has a leaf of its own.
        let parameters = BvhBuildParams { max_prims_per_leaf: 1, ..BvhBuildParams::fast_build() };
        let tree = build_bvh2(&rounded, parameters, &mut spent);
        let nodes = tree.nodes.iter().map(|node| Node {
            min: node.aabb.min.to_array(),
            max: node.aabb.max.to_array(),
            first: node.first_index,
            count: node.prim_count,
        });
        Self { nodes: nodes.collect(), primitives: tree.primitive_indices, origin, scale, fours: Fours::default() }
    }

    /// How many boxes there are.
    pub fn len(&self) -> usize {
        self.primitives.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.primitives.is_empty()
    }

    /// Visits the boxes whose squared distance from `point` is not above `limit`, nearer branches
    /// first. `visit` gets a box and the limit so far and returns the new one: its own squared
    /// distance if that is less, say. Returns the last limit.
    pub fn near(&self, point: DVec3, limit: f64, mut visit: impl FnMut(u32, f64) -> f64) -> f64 {
        let at = (point - self.origin) * self.scale;
        let square = self.scale * self.scale;
        let mut limit = limit;
        let mut stack = Stack::new();
        let distance = |n: u32| self.nodes[n as usize].distance_squared(at);
        if !self.nodes.is_empty() {
            stack.push((distance(0), 0));
        }
        while let Some((lower, n)) = stack.pop() {
            if lower > limit * square {
                continue;
            }
            let node = self.nodes[n as usize];
            if node.count > 0 {
                for &primitive in self.leaf(&node) {
                    limit = visit(primitive, limit);
                }
                continue;
            }
            let (a, b) = ((distance(node.first), node.first), (distance(node.first + 1), node.first + 1));
            let (near, far) = if b.0 < a.0 { (b, a) } else { (a, b) };
            stack.push(far);
            stack.push(near);
        }
        limit
    }

    /// The box for which `distance_squared`, in model units squared, is least; the first of the list
    /// where several are as near. `None` where there are no boxes.
    ///
    /// No box may be nearer than its distance to `point` as a box.
    pub fn nearest(&self, point: DVec3, mut distance_squared: impl FnMut(u32) -> f64) -> Option<(u32, f64)> {
        let mut best: Option<(u32, f64)> = None;
        self.near(point, f64::INFINITY, |i, limit| {
            let d = distance_squared(i);
            if best.is_none_or(|(j, least)| d < least || (d == least && i < j)) {
                best = Some((i, d));
            }
            best.map_or(limit, |b| b.1)
        });
        best
    }

    /// Visits the boxes that may share a point with `bounds`.
    pub fn overlapping(&self, bounds: Bounds, mut visit: impl FnMut(u32)) {
        if self.nodes.is_empty() {
            return;
        }
        let own = Bounds { min: (bounds.min - self.origin) * self.scale, max: (bounds.max - self.origin) * self.scale };
        let mut stack = Stack::new();
        stack.push((0.0, 0));
        while let Some((_, n)) = stack.pop() {
            let node = self.nodes[n as usize];
            if !node.bounds().overlaps(&own) {
                continue;
            }
            if node.count > 0 {
                self.leaf(&node).iter().for_each(|&i| visit(i));
            } else {
                stack.push((0.0, node.first + 1));
                stack.push((0.0, node.first));
            }
        }
    }

    /// Visits the pairs of a box here and a box of `other` that may share a point.
    pub fn pairs(&self, other: &Self, mut visit: impl FnMut(u32, u32)) {
        if self.nodes.is_empty() || other.nodes.is_empty() {
            return;
        }
        let mut stack = vec![(0, 0)];
        while let Some((a, b)) = stack.pop() {
            let (left, right) = (self.nodes[a as usize], other.nodes[b as usize]);
            let (own, its) = (self.world(&left), other.world(&right));
            if !own.overlaps(&its) {
                continue;
            }
            if left.count > 0 && right.count > 0 {
                for &i in self.leaf(&left) {
                    other.leaf(&right).iter().for_each(|&j| visit(i, j));
                }
            } else if right.count > 0 || (left.count == 0 && own.size() >= its.size()) {
                stack.extend([(left.first + 1, b), (left.first, b)]);
            } else {
                stack.extend([(a, right.first + 1), (a, right.first)]);
            }
        }
    }

    fn leaf(&self, node: &Node) -> &[u32] {
        &self.primitives[node.first as usize..(node.first + node.count) as usize]
    }

    /// A node's box in model units, rounded outward.
    fn world(&self, node: &Node) -> Bounds {
        let Bounds { min, max } = node.bounds();
        let (min, max) = (min / self.scale + self.origin, max / self.scale + self.origin);
        let down = |x: f64| x.next_down();
        let up = |x: f64| x.next_up();
        Bounds {
            min: DVec3::new(down(min.x), down(min.y), down(min.z)),
            max: DVec3::new(up(max.x), up(max.y), up(max.z)),
        }
    }
}

type Stack = smallvec::SmallVec<[(f64, u32); 64]>;

impl Node {
    #[inline]
    fn bounds(&self) -> Bounds {
        let wide = |a: [f32; 3]| DVec3::new(f64::from(a[0]), f64::from(a[1]), f64::from(a[2]));
        Bounds { min: wide(self.min), max: wide(self.max) }
    }

    #[inline]
    fn distance_squared(&self, point: DVec3) -> f64 {
        self.bounds().distance_squared(point)
    }
}

impl Bounds {
    fn size(&self) -> f64 {
        (self.max - self.min).element_sum()
    }
}

/// The power of two that brings `size` below 1: distances squared then neither overflow nor vanish
/// in f32, whatever the unit.
fn scale_for(size: f64) -> f64 {
    if size > 0.0 && size.is_finite() { 2.0_f64.powi(-(size.log2().ceil().clamp(-1000.0, 1000.0) as i32)) } else { 1.0 }
}

/// The largest f32 below `x`.
fn below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// The smallest f32 above `x`.
fn above(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

#[cfg(test)]
#[path = "spatial_tests.rs"]
mod tests;
