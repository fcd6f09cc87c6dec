//! Control meshes of every local shape, with control points in no special place.

use std::f64::consts::TAU;

use glam::DVec3;

/// Points, faces, declared corners.
pub type Cage = (Vec<DVec3>, Vec<[u32; 3]>, Vec<u32>);

/// splitmix64: the same numbers everywhere.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A place in the unit triangle.
    pub fn place(&mut self) -> (f64, f64) {
        let (s, t) = (self.unit(), self.unit());
        if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) }
    }

    pub fn jitter(&mut self, points: &mut [DVec3], size: f64) {
        for p in points {
            *p += DVec3::new(self.unit() - 0.5, self.unit() - 0.5, self.unit() - 0.5) * size;
        }
    }
}

/// Two poles of valence `k` and a ring of valence 4 between them.
pub fn bipyramid(k: u32) -> Cage {
    let ring = (0..k).map(|i| TAU * f64::from(i) / f64::from(k)).map(|a| DVec3::new(a.cos(), a.sin(), 0.0));
    let mut points: Vec<DVec3> = [DVec3::Z, -DVec3::Z].into_iter().chain(ring).collect();
    Random(u64::from(k)).jitter(&mut points, 0.2);
    let next = |i: u32| 2 + (i + 1) % k;
    let faces = (0..k).flat_map(|i| [[0, 2 + i, next(i)], [1, next(i), 2 + i]]).collect();
    (points, faces, Vec::new())
}

/// A disk around an inner vertex of valence `k`; its rim has valence 3.
pub fn disk(k: u32, corners: &[u32]) -> Cage {
    let (points, faces, _) = bipyramid(k);
    let faces = faces.iter().step_by(2).map(|f: &[u32; 3]| f.map(|v| v.saturating_sub(1))).collect();
    let points = points.iter().enumerate().filter(|(i, _)| *i != 1).map(|(_, p)| *p).collect();
    (points, faces, corners.to_vec())
}

/// An open fan: vertex 0 on the border with valence `k`, so `k - 1` faces; those at its ends have
/// two border edges.
pub fn open_fan(k: u32, corners: &[u32]) -> Cage {
    let angle = |i: u32| 2.5 * f64::from(i) / f64::from(k - 1);
    let rim = (0..k).map(|i| DVec3::new(angle(i).cos(), angle(i).sin(), 0.0));
    let mut points: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain(rim).collect();
    Random(1000 + u64::from(k)).jitter(&mut points, 0.2);
    (points, (1..k).map(|i| [0, i, i + 1]).collect(), corners.to_vec())
}

/// A regular lattice patch of `n` by `m` quads, each cut in two, with a border of valences 2, 3, 4.
pub fn sheet(n: u32, m: u32, corners: &[u32]) -> Cage {
    let at = |i: u32, j: u32| i * (m + 1) + j;
    let mut points: Vec<DVec3> =
        (0..=n).flat_map(|i| (0..=m).map(move |j| DVec3::new(f64::from(i), f64::from(j), 0.0))).collect();
    Random(u64::from(n * 100 + m)).jitter(&mut points, 0.4);
    let quad = |i, j| [[at(i, j), at(i + 1, j), at(i, j + 1)], [at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]];
    let faces = (0..n).flat_map(|i| (0..m).flat_map(move |j| quad(i, j))).collect();
    (points, faces, corners.to_vec())
}

/// A torus of `n` by `m` quads, each cut in two: all valences 6.
pub fn torus(n: u32, m: u32) -> Cage {
    let at = |i: u32, j: u32| (i % n) * m + j % m;
    let place = |i: u32, j: u32| {
        let (a, b) = (TAU * f64::from(i) / f64::from(n), TAU * f64::from(j) / f64::from(m));
        let r = 1.0 + 0.4 * b.cos();
        DVec3::new(r * a.cos(), r * a.sin(), 0.4 * b.sin())
    };
    let mut points: Vec<DVec3> = (0..n).flat_map(|i| (0..m).map(move |j| place(i, j))).collect();
    Random(u64::from(n * 1000 + m)).jitter(&mut points, 0.1);
    let quad = |i, j| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    (points, (0..n).flat_map(|i| (0..m).flat_map(move |j| quad(i, j))).collect(), Vec::new())
}

/// A torus after `flips` random edge flips, and with a few faces taken out: valences 3 to about 12,
/// borders of any valence with several irregular vertices per face.
pub fn scrambled(seed: u64, flips: usize, holes: usize) -> Cage {
    let (points, mut faces, _) = torus(8, 7);
    let mut random = Random(seed);
    for _ in 0..flips {
        flip(&mut faces, points.len(), &mut random);
    }
    for _ in 0..holes {
        let (a, kept) = (random.below(faces.len()), faces.clone());
        faces.swap_remove(a);
        if super::Connectivity::new(points.len(), &faces).is_err() {
            faces = kept;
        }
    }
    (points, faces, Vec::new())
}

/// Flips a random edge if the mesh stays one without double edges and valences below 3.
fn flip(faces: &mut [[u32; 3]], vertices: usize, random: &mut Random) {
    let (f, i) = (random.below(faces.len()), random.below(3));
    let (a, b, c) = (faces[f][i], faces[f][(i + 1) % 3], faces[f][(i + 2) % 3]);
    let Some(g) = faces.iter().position(|g| (0..3).any(|j| g[j] == b && g[(j + 1) % 3] == a)) else { return };
    let d = faces[g].into_iter().find(|&v| v != a && v != b).unwrap_or(a);
    let joined = faces.iter().any(|g| g.contains(&c) && g.contains(&d));
    let valence = |v: u32| faces.iter().filter(|g| g.contains(&v)).count();
    if c == d || joined || valence(a) <= 3 || valence(b) <= 3 {
        return;
    }
    let kept = (faces[f], faces[g]);
    (faces[f], faces[g]) = ([a, d, c], [d, b, c]);
    if super::Connectivity::new(vertices, faces).is_err() {
        (faces[f], faces[g]) = kept;
    }
}

/// One of each kind.
pub fn zoo() -> Vec<(String, Cage)> {
    let triangle = |corners: &[u32]| open_fan(2, corners);
    let mut zoo = vec![
        ("triangle".to_owned(), triangle(&[])),
        ("triangle, one corner".to_owned(), triangle(&[1])),
        ("triangle, three corners".to_owned(), triangle(&[0, 1, 2])),
        ("tetrahedron".to_owned(), bipyramid(3)),
        // Beyond usual valences, and just not.
        ("bipyramid 32".to_owned(), bipyramid(32)),
        ("bipyramid 31".to_owned(), bipyramid(31)),
        ("sheet".to_owned(), sheet(4, 3, &[])),
        ("sheet, four corners".to_owned(), sheet(4, 3, &[0, 3, 16, 19])),
        ("strip".to_owned(), sheet(5, 1, &[])),
        ("small torus".to_owned(), torus(4, 4)),
    ];
    for k in 3..10 {
        zoo.push((format!("disk {k}"), disk(k, &[1, 2])));
    }
    for k in 3..12 {
        zoo.push((format!("fan {k}"), open_fan(k, &[])));
        zoo.push((format!("fan {k}, corner"), open_fan(k, &[0, 2])));
    }
    for seed in 0..4 {
        zoo.push((format!("scrambled {seed}"), scrambled(seed, 60, 0)));
        zoo.push((format!("scrambled {seed} with holes"), scrambled(seed, 40, 12)));
    }
    zoo
}
