//! Meshes made in code, and places on them.
#![allow(dead_code, reason = "each benchmark uses its own part of this module")]

use std::f64::consts::TAU;
use std::sync::Arc;

use selvedge::DVec3;
use selvedge::mesh::{Connectivity, FaceId};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::subdivision::PlainLoop;

/// splitmix64: the same numbers everywhere.
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// A closed cage: points and triangles.
pub struct Cage {
    pub points: Vec<DVec3>,
    pub faces: Vec<[u32; 3]>,
}

/// How the quads of a torus are cut in two.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Cut {
    /// All along the same diagonal: every valence is 6.
    Regular,
    /// Each along one drawn at random, vertices and faces in no order: valences 4 to 8, and hardly a
    /// face without an irregular vertex.
    Irregular,
}

/// A torus of `n` by `m` quads, twice as many triangles.
pub fn torus(n: u32, m: u32, cut: Cut) -> Cage {
    let mut random = Random(42);
    let mut names: Vec<u32> = (0..n * m).collect();
    if cut == Cut::Irregular {
        random.shuffle(&mut names);
    }
    let mut points = vec![DVec3::ZERO; names.len()];
    let mut faces = Vec::with_capacity(2 * names.len());
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        let at = |i: u32, j: u32| names[((i % n) * m + j % m) as usize];
        let (a, b) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
        let r = 1.0 + 0.4 * b.cos();
        points[at(i, j) as usize] = DVec3::new(r * a.cos(), r * a.sin(), 0.4 * b.sin());
        let [p, q, r, s] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        let other = cut == Cut::Irregular && random.below(2) == 1;
        faces.extend(if other { [[p, q, s], [q, r, s]] } else { [[p, q, r], [p, r, s]] });
    }
    if cut == Cut::Irregular {
        random.shuffle(&mut faces);
    }
    Cage { points, faces }
}

impl Cage {
    pub fn surface(&self) -> PlainLoop {
        let mesh = Connectivity::new(self.points.len(), &self.faces).expect("a torus has no fault");
        PlainLoop::new(Arc::new(mesh), self.points.clone(), &[]).expect("finite points")
    }

    /// Anywhere on it, in no order.
    pub fn places(&self, count: usize) -> Vec<SurfacePoint> {
        let mut random = Random(7);
        let place = |_| {
            let (s, t) = (random.unit(), random.unit());
            let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
            SurfacePoint::new(FaceId::new(random.below(self.faces.len())), s, t)
        };
        (0..count).map(place).collect()
    }
}
