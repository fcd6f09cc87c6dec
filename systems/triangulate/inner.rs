//! A face within the domain of one polynomial.

use selvedge_components::subdivision::boxspline::Quartic;
use selvedge_components::subdivision::{Deviation, FaceCode, quartered};

use super::sample::Place;

/// A face of the hierarchy within one of its ancestors, or the ancestor itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inner {
    /// Levels below the ancestor.
    depth: u32,
    /// The corners, in steps of `2^-depth` towards the ancestor's second and third corner.
    corners: [(u32, u32); 3],
}

impl Inner {
    /// `place` within its ancestor of level `base`.
    pub fn new(Place { level, code }: Place, base: u32) -> Self {
        let depth = level - base;
        let way = FaceCode(code.0 & ((1 << (2 * depth)) - 1));
        Self { depth, corners: way.corners(depth) }
    }

    /// Its corners in the ancestor's domain.
    pub fn corners(&self) -> [[f64; 2]; 3] {
        let step = self.step();
        self.corners.map(|(i, j)| [step * f64::from(i), step * f64::from(j)])
    }

    /// Its quarters.
    pub fn quarters(&self) -> [Self; 4] {
        let sum = |p: (u32, u32), q: (u32, u32)| (p.0 + q.0, p.1 + q.1);
        let [a, b, c] = self.corners;
        quartered([sum(a, a), sum(b, b), sum(c, c)], [sum(a, b), sum(b, c), sum(c, a)])
            .map(|corners| Self { depth: self.depth + 1, corners })
    }

    fn step(&self) -> f64 {
        0.5_f64.powi(self.depth as i32)
    }

    /// The corner from which the two edges run along `s` and `t`, both forwards or both backwards, as
    /// the next and the one after.
    fn base(&self) -> usize {
        let along = |c: usize| {
            let [a, b] = [c, (c + 1) % 3].map(|c| self.corners[c]);
            a.1 == b.1
        };
        (0..3).find(|&c| along(c)).unwrap_or(0)
    }

    /// How it stands off its triangle.
    pub fn deviation(&self, quartic: &Quartic) -> Deviation {
        let base = self.base();
        let [from, to] = [base, (base + 1) % 3].map(|c| self.corners[c]);
        let size = if to.0 > from.0 { self.step() } else { -self.step() };
        Deviation::new(quartic, self.corners()[base], size).turned(base)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a walk down comes to is what the codes say.
    #[test]
    fn quarters_are_those_of_the_codes() {
        let root = Place { level: 1, code: FaceCode(5) };
        let mut faces = vec![(root, Inner::new(root, 1))];
        for _ in 0..4 {
            let quarters = |(place, inner): &(Place, Inner)| {
                let (Place { level, code }, inner) = (*place, inner.quarters());
                [0, 1, 2, 3].map(|k| (Place { level: level + 1, code: code.child(k) }, inner[k]))
            };
            faces = faces.iter().flat_map(quarters).collect();
            assert!(faces.iter().all(|(place, inner)| *inner == Inner::new(*place, 1)));
        }
    }
}
