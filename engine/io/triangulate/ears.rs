//! A face cut into triangles ear by ear.

use std::cmp::Ordering;

use glam::DVec3;

use super::{Valences, newell_normal, sides};

/// Cuts one face and adds its triangles.
pub(super) fn cut(face: &[u32], mesh: &mut Valences<'_>, triangles: &mut Vec<[u32; 3]>) {
    if let [a, b, c] = *face {
        triangles.push([a, b, c]);
        return;
    }
    let mut rest = Rest::new(face, mesh);
    while rest.corners.len() > 3 {
        let cheapest = (0..rest.corners.len()).min_by(|&i, &j| rest.compare(i, j, mesh));
        let i = cheapest.expect("four corners or more");
        let [a, b, c] = rest.triangle(i);
        mesh.add(a, c);
        triangles.push([a, b, c]);
        rest.cut_off(i, mesh);
    }
    triangles.push(rest.triangle(1));
}

/// What is left of a face while it is being cut.
struct Rest {
    normal: DVec3,
    corners: Vec<u32>,
    reflex: Vec<bool>,
    ears: Vec<Ear>,
}

/// What it means to cut off one corner of a face, apart from valences.
#[derive(Clone, Copy)]
struct Ear {
    /// The diagonal lies along an edge that exists already.
    joined: bool,
    /// It is no ear: the triangle is not inside the face.
    outside: bool,
    /// Square of the length of the diagonal.
    length: f64,
}

impl Rest {
    fn new(face: &[u32], mesh: &Valences<'_>) -> Self {
        let normal = newell_normal(face, mesh.positions);
        let mut rest = Self { normal, corners: face.to_vec(), reflex: Vec::new(), ears: Vec::new() };
        rest.reflex = (0..face.len()).map(|i| rest.is_reflex(i, mesh)).collect();
        rest.ears = (0..face.len()).map(|i| rest.ear(i, mesh)).collect();
        rest
    }

    /// The corner `i` between its neighbours.
    fn triangle(&self, i: usize) -> [u32; 3] {
        let n = self.corners.len();
        [if i == 0 { n - 1 } else { i - 1 }, i, if i + 1 == n { 0 } else { i + 1 }].map(|j| self.corners[j])
    }

    /// Orders corners by how unwelcome it is to cut them off.
    fn compare(&self, i: usize, j: usize, mesh: &Valences<'_>) -> Ordering {
        let key = |i: usize| {
            let [a, _, c] = self.triangle(i);
            (self.ears[i].joined, self.ears[i].outside, mesh.rise(a, 1) + mesh.rise(c, 1))
        };
        key(i).cmp(&key(j)).then_with(|| self.ears[i].length.total_cmp(&self.ears[j].length))
    }

    fn is_reflex(&self, i: usize, mesh: &Valences<'_>) -> bool {
        !mesh.winds_with(self.normal, self.triangle(i))
    }

    fn ear(&self, i: usize, mesh: &Valences<'_>) -> Ear {
        let triangle = self.triangle(i);
        let at = |v: u32| mesh.positions[v as usize];
        let inside = |p: DVec3| sides(&triangle).all(|(a, b)| (at(b) - at(a)).cross(p - at(a)).dot(self.normal) >= 0.0);
        let reflex = self.corners.iter().zip(&self.reflex).filter(|&(_, &reflex)| reflex).map(|(&v, _)| v);
        let holds_another = || reflex.into_iter().any(|v| !triangle.contains(&v) && inside(at(v)));
        Ear {
            joined: mesh.joins(triangle[0], triangle[2]),
            outside: self.reflex[i] || holds_another(),
            length: at(triangle[0]).distance_squared(at(triangle[2])),
        }
    }

    /// Takes corner `i` away. Only its neighbours can become ears, or cease to be.
    fn cut_off(&mut self, i: usize, mesh: &Valences<'_>) {
        self.corners.remove(i);
        self.reflex.remove(i);
        self.ears.remove(i);
        let n = self.corners.len();
        let beside = [(i + n - 1) % n, i % n];
        for j in beside {
            self.reflex[j] = self.is_reflex(j, mesh);
        }
        for j in beside {
            self.ears[j] = self.ear(j, mesh);
        }
    }
}
