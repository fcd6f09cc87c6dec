//! The independent evaluation that the tests compare with: the scheme's definition, step by step,
//! on a mesh of its own, with nothing regular about it.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;

/// What is known of a vertex: interior, on a smooth border, or kept in place.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Kind {
    Interior,
    Border,
    Corner,
}

/// A mesh as the scheme is defined on it.
#[derive(Clone, Debug)]
pub struct Naive {
    pub points: Vec<DVec3>,
    pub kinds: Vec<Kind>,
    pub faces: Vec<[usize; 3]>,
}

type Edge = (usize, usize);

fn edge(a: usize, b: usize) -> Edge {
    (a.min(b), a.max(b))
}

impl Naive {
    pub fn new(points: &[DVec3], faces: &[[u32; 3]], corners: &[u32]) -> Self {
        let faces: Vec<[usize; 3]> = faces.iter().map(|f| f.map(|v| v as usize)).collect();
        let mut mesh = Self { points: points.to_vec(), kinds: vec![Kind::Interior; points.len()], faces };
        for (&(a, b), wings) in &mesh.wings() {
            if wings.len() == 1 {
                mesh.kinds[a] = Kind::Border;
                mesh.kinds[b] = Kind::Border;
            }
        }
        for &c in corners {
            mesh.kinds[c as usize] = Kind::Corner;
        }
        mesh
    }

    /// For every edge the vertices across it.
    fn wings(&self) -> BTreeMap<Edge, Vec<usize>> {
        let mut wings: BTreeMap<Edge, Vec<usize>> = BTreeMap::new();
        for f in &self.faces {
            for i in 0..3 {
                wings.entry(edge(f[i], f[(i + 1) % 3])).or_default().push(f[(i + 2) % 3]);
            }
        }
        wings
    }

    /// For every vertex all neighbours, and those along the border.
    fn rings(&self) -> Vec<(Vec<usize>, Vec<usize>)> {
        let mut rings = vec![(Vec::new(), Vec::new()); self.points.len()];
        for ((a, b), wings) in self.wings() {
            for (v, n) in [(a, b), (b, a)] {
                rings[v].0.push(n);
                if wings.len() == 1 {
                    rings[v].1.push(n);
                }
            }
        }
        rings
    }

    fn combine(&self, v: usize, own: f64, ring: &[usize], each: f64) -> DVec3 {
        ring.iter().fold(self.points[v] * own, |sum, &n| sum + self.points[n] * each)
    }

    /// One step; face `f` becomes `4 f .. 4 f + 4`, its children at the corners and the middle one.
    pub fn step(&self) -> Self {
        let rings = self.rings();
        let mut points = Vec::new();
        for (v, (ring, border)) in rings.iter().enumerate() {
            let k = ring.len() as f64;
            points.push(match self.kinds[v] {
                Kind::Corner => self.points[v],
                Kind::Border => self.combine(v, 0.75, border, 0.125),
                Kind::Interior => {
                    let beta = (0.625 - (0.375 + 0.25 * (2.0 * PI / k).cos()).powi(2)) / k;
                    self.combine(v, 1.0 - k * beta, ring, beta)
                }
            });
        }
        let mut kinds = self.kinds.clone();
        let mut middle = BTreeMap::new();
        for (&(a, b), wings) in &self.wings() {
            middle.insert((a, b), points.len());
            let (ends, across) =
                (self.points[a] + self.points[b], wings.iter().map(|&w| self.points[w]).sum::<DVec3>());
            let border = wings.len() == 1;
            points.push(if border { ends / 2.0 } else { ends * 3.0 / 8.0 + across / 8.0 });
            kinds.push(if border { Kind::Border } else { Kind::Interior });
        }
        let mut faces = Vec::new();
        for &[a, b, c] in &self.faces {
            let (ab, bc, ca) = (middle[&edge(a, b)], middle[&edge(b, c)], middle[&edge(c, a)]);
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        Self { points, kinds, faces }
    }

    /// The limit of every vertex.
    pub fn limits(&self) -> Vec<DVec3> {
        let one = |(v, (ring, border)): (usize, &(Vec<usize>, Vec<usize>))| match self.kinds[v] {
            Kind::Corner => self.points[v],
            Kind::Border => self.combine(v, 4.0 / 6.0, border, 1.0 / 6.0),
            Kind::Interior => {
                let k = ring.len() as f64;
                let beta = (0.625 - (0.375 + 0.25 * (2.0 * PI / k).cos()).powi(2)) / k;
                let chi = 1.0 / (3.0 / (8.0 * beta) + k);
                self.combine(v, 1.0 - k * chi, ring, chi)
            }
        };
        self.rings().iter().enumerate().map(one).collect()
    }

    /// Only the faces that touch `face`, which becomes the first. Exact for what lies in `face`:
    /// a step needs no more. Edges cut open must not be taken for borders, so a vertex of `face`
    /// keeps its whole ring and the others are never asked.
    fn around(&self, face: usize) -> Self {
        let corners = self.faces[face];
        let mut ids = BTreeMap::new();
        let (mut points, mut kinds, mut faces) = (Vec::new(), Vec::new(), Vec::new());
        let touching =
            self.faces.iter().enumerate().filter(|(f, g)| *f != face && g.iter().any(|v| corners.contains(v)));
        for g in std::iter::once(&corners).chain(touching.map(|(_, g)| g)) {
            faces.push(g.map(|v| {
                *ids.entry(v).or_insert_with(|| {
                    points.push(self.points[v]);
                    kinds.push(self.kinds[v]);
                    points.len() - 1
                })
            }));
        }
        Self { points, kinds, faces }
    }

    /// The limit at the weights `w` of the corners of `face`: `levels` steps towards the point, then
    /// linear between the limits of the face that holds it. The error is that of a chord, `4^-levels`
    /// where the surface is curved evenly.
    pub fn deep(&self, face: usize, mut w: [f64; 3], levels: u32) -> DVec3 {
        let mut mesh = self.around(face);
        for _ in 0..levels {
            let child = (0..3).find(|&i| w[i] > 0.5).unwrap_or(3);
            w = match child {
                3 => [1.0 - 2.0 * w[2], 1.0 - 2.0 * w[0], 1.0 - 2.0 * w[1]],
                i => {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    let mut finer = [0.0; 3];
                    (finer[j], finer[k]) = (2.0 * w[j], 2.0 * w[k]);
                    finer[i] = 1.0 - finer[j] - finer[k];
                    finer
                }
            };
            mesh = mesh.step().around(child);
        }
        let limits = mesh.limits();
        let [a, b, c] = mesh.faces[0].map(|v| limits[v]);
        a * w[0] + b * w[1] + c * w[2]
    }
}
