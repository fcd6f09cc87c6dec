//! Tangents of the limit surface at a vertex.

use core::f64::consts::PI;

use glam::DVec3;

use super::Scheme;
use super::ring::{BorderPlace, BorderRule, Place, Ring};
use crate::subdivision::corner::PARALLEL;
use crate::subdivision::level::sample;

/// The tangent plane at a vertex: the derivative along neighbour `i` is
/// `along cos(i angle) + across sin(i angle)`, in model units per edge.
///
/// They are the derivatives where the vertex is regular, on borders, and at corners of the lattice.
/// At other vertices derivatives by the face's coordinates vanish or grow without bound as the
/// vertex is approached; these are what they are proportional to, as if the ring shrank by 1/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangents {
    /// Along the first neighbour; on a border along the border, with the surface on the left.
    pub along: DVec3,
    /// A quarter turn on from `along`, into the surface.
    pub across: DVec3,
    /// The angle from a neighbour to the next.
    pub angle: f64,
    /// At a corner: along the first border edge and along the last, away from the corner.
    pub ends: Option<[DVec3; 2]>,
}

impl Tangents {
    /// The unit normal, outward for counter-clockwise faces; zero where there is none.
    pub fn normal(&self) -> DVec3 {
        self.along.cross(self.across).normalize_or_zero()
    }

    /// The derivatives along neighbours `i` and `i + 1` of `valence`, per edge.
    pub(super) fn of_face(&self, i: usize, valence: usize) -> [DVec3; 2] {
        [i, i + 1].map(|i| match self.ends {
            Some([first, _]) if i == 0 => first,
            Some([_, last]) if i + 1 == valence => last,
            _ => {
                let (sin, cos) = libm::sincos(self.angle * i as f64);
                self.along * cos + self.across * sin
            }
        })
    }

    fn scaled(self, by: f64) -> Self {
        let ends = self.ends.map(|ends| ends.map(|e| e * by));
        Self { along: self.along * by, across: self.across * by, ends, ..self }
    }
}

impl Ring {
    /// The tangents of the limit surface at the vertex.
    pub fn tangents(&self, scheme: Scheme<'_>) -> Tangents {
        // Next to a special corner an edge has another rule than the masks assume; a step later
        // none has, and an edge is half as long.
        if !self.beside.is_empty() {
            return self.finer(scheme).tangents(scheme).scaled(2.0);
        }
        match &self.place {
            Place::Inside => self.interior_tangents(),
            Place::Border(border) => match border.rule {
                BorderRule::Plain | BorderRule::Given => self.border_tangents(scheme, border),
                BorderRule::PlainCorner | BorderRule::GivenCorner => self.corner_tangents(scheme, border),
            },
        }
    }

    /// `2/k sum cos(2 pi i / k) e_i` and the same with sines: the left eigenvectors to the
    /// subdominant eigenvalue.
    fn interior_tangents(&self) -> Tangents {
        let angle = 2.0 * PI / self.valence() as f64;
        let (mut along, mut across) = (DVec3::ZERO, DVec3::ZERO);
        for (i, &p) in self.spokes.iter().enumerate() {
            let (sin, cos) = libm::sincos(angle * i as f64);
            // Differences: far from the origin they keep more digits than the points.
            along += (p - self.centre) * cos;
            across += (p - self.centre) * sin;
        }
        let scale = 2.0 / self.valence() as f64;
        Tangents { along: along * scale, across: across * scale, angle, ends: None }
    }

    /// At a smooth border vertex: the border's own derivative, and the zero-boundary mode.
    fn border_tangents(&self, scheme: Scheme<'_>, border: &BorderPlace) -> Tangents {
        let k = self.valence();
        let angle = PI / (k - 1) as f64;
        let along = match self.velocities(scheme, border) {
            // The curve passes smoothly; the mean of both sides is as good as either, and fair.
            [Some(next), Some(previous)] => (next - previous) * 0.5,
            _ => (self.spokes[0] - self.spokes[k - 1]) * 0.5,
        };
        Tangents { along, across: self.transverse(scheme, border), angle, ends: None }
    }

    /// The derivatives along the two border edges, away from the vertex, per edge; `None` on plain
    /// sides.
    fn velocities(&self, scheme: Scheme<'_>, border: &BorderPlace) -> [Option<DVec3>; 2] {
        let sides = &scheme.surface.sides;
        let ((next, step), (previous, end)) = (border.leaving, border.arriving);
        let leaving = sides[next as usize].velocity_on(self.level, step, 0.0);
        let arriving = sides[previous as usize].velocity_on(self.level, end - 1, 1.0);
        [leaving, arriving.map(|v| -v)]
    }

    /// The derivative across a smooth border, into the surface, per edge.
    ///
    /// `T = sum sin(i theta) e_i + a (l + r) + z c` with `theta = pi / (k - 1)`, `a = (sin theta - sum) /
    /// (8 lambda - 2)`, `z = -(sum + 2 a)` annihilates what the plain border's rules do to the ring, up to
    /// the factor `lambda = 3/8 + cos(theta) / 4` (1/2 on a given border, where the weights of the edges
    /// make it so). A given border moves otherwise than the plain rules would move it, step by step.
    /// With the border `g`, its second differences `s_j = 2^j (g(2^-j) - 2 g(0) + g(-2^-j))` in edges of
    /// the ring and its details `D`, whose slope jumps by `J` at the vertex, all those moves sum to
    ///
    /// `-(z/4 + a) s_0 - z/4 (s_1 + s_2 + ...) + (3 z + 6 a) D + (z/3 + a) J`.
    ///
    /// On a plain border this is zero.
    fn transverse(&self, scheme: Scheme<'_>, border: &BorderPlace) -> DVec3 {
        let k = self.valence();
        let (c, l, r) = (self.centre, self.spokes[0], self.spokes[k - 1]);
        if k == 2 {
            // No edge runs inside: what bends the border bends the face.
            return ((l - c) + (r - c)) * 0.5;
        }
        let theta = PI / (k - 1) as f64;
        let given = border.rule != BorderRule::Plain;
        let lambda = if given { 0.5 } else { 0.375 + 0.25 * libm::cos(theta) };
        let weights = (1..k - 1).map(|i| libm::sin(theta * i as f64));
        let sum: f64 = weights.clone().sum();
        let a = (libm::sin(theta) - sum) / (8.0 * lambda - 2.0);
        let inside = weights.zip(&self.spokes[1..]).fold(DVec3::ZERO, |t, (w, &p)| t + (p - c) * w);
        let mut t = inside + ((l - c) + (r - c)) * a;
        if given {
            let z = -(sum + 2.0 * a);
            let [d, d_next, d_previous] = border.details;
            let samples = [l + d_next, r + d_previous];
            let s0 = (samples[0] - border.sample) + (samples[1] - border.sample);
            let jump = (d_next - d) + (d_previous - d);
            t += d * (3.0 * z + 6.0 * a) + jump * (z / 3.0 + a) - s0 * (0.25 * z + a);
            let edge = inside.length();
            t -= self.second_differences(scheme, border, s0, edge) * (0.25 * z);
        }
        t * (2.0 / (k - 1) as f64)
    }

    /// `s_1 + s_2 + ...` of [`Self::transverse`].
    ///
    /// The border is smooth on both sides of the vertex, so `s_j` is a series in powers of `2^-j`, and so
    /// is what is left after `n` terms: Romberg's scheme takes its powers away one by one. It ends
    /// where a term moves the estimate by less than [`STEADY`] of an `edge` of the ring. The
    /// samples' rounding doubles from term to term, so the estimate that moved least is the best.
    fn second_differences(&self, scheme: Scheme<'_>, border: &BorderPlace, s0: DVec3, edge: f64) -> DVec3 {
        const MOST: usize = 16;
        let side = |(s, _): (u32, u64)| &scheme.surface.sides[s as usize];
        let term = |j: u32| {
            let level = self.level + j;
            let next = sample(side(border.leaving), level, (border.leaving.1 << j) + 1)?;
            let previous = sample(side(border.arriving), level, (border.arriving.1 << j) - 1)?;
            Some(((next - border.sample) + (previous - border.sample)) * f64::from(1_u32 << j))
        };
        // Row j of the scheme; the sum before any term is zero.
        let mut row = [DVec3::ZERO; MOST];
        let (mut total, mut best, mut moved) = (DVec3::ZERO, s0, f64::INFINITY);
        for j in 1..MOST {
            if self.level + j as u32 > FINEST_SAMPLE {
                break;
            }
            let Some(s) = term(j as u32) else { break };
            total += s;
            let mut corrected = total;
            for (p, slot) in row.iter_mut().enumerate().take(j) {
                let power = f64::from(1_u32 << (p + 1));
                let better = (corrected * power - *slot) / (power - 1.0);
                *slot = corrected;
                corrected = better;
            }
            let change = corrected.distance(best);
            if change < moved {
                (best, moved) = (corrected, change);
            }
            let rounding = f64::EPSILON * f64::from(1_u32 << j) * border.sample.abs().max_element();
            if moved <= rounding.max(STEADY * edge) {
                break;
            }
            row[j] = corrected;
        }
        best
    }

    /// At a corner: the tangents of the two borders span the plane.
    ///
    /// The ring's directions lie `angle` apart in the plane in which the subdivision is a contraction
    /// by 1/2: 60 degrees on the lattice; `cos(angle) = 4 (1/2 - gamma)` elsewhere.
    fn corner_tangents(&self, scheme: Scheme<'_>, border: &BorderPlace) -> Tangents {
        let k = self.valence();
        let given = self.velocities(scheme, border);
        let plain = [self.spokes[0] - self.centre, self.spokes[k - 1] - self.centre];
        let ends @ [first, last] = [0, 1].map(|i| given[i].unwrap_or(plain[i]));
        let special = scheme.corners.corners.get(self.corner as usize);
        let angle = special.map_or(PI / 3.0, |c| libm::acos((2.0 - 4.0 * c.weight).clamp(-1.0, 1.0)));
        let (sin, cos) = libm::sincos(angle * (k - 1) as f64);
        if special.is_none() && k > 3 {
            return self.spread_tangents(ends);
        }
        if sin.abs() < PARALLEL {
            let across = self.transverse(scheme, border);
            return Tangents { along: (first - last) * 0.5, across, angle: PI / (k - 1) as f64, ends: Some(ends) };
        }
        Tangents { along: first, across: (last - first * cos) / sin, angle, ends: Some(ends) }
    }

    /// At a corner of valence above 3 under the plain rules the faces' planes have limits of their
    /// own, for the mode that vanishes on the border shrinks less than the border does. The borders'
    /// plane stands for them all, or where they run straight on, that of one and the middle edge.
    fn spread_tangents(&self, ends @ [first, last]: [DVec3; 2]) -> Tangents {
        let k = self.valence();
        let angle = PI / (k - 1) as f64;
        let normal = first.cross(last);
        // Squared sine of the angle between the borders: below it rounding alone decides.
        let across = if normal.length_squared() <= f64::EPSILON * first.length_squared() * last.length_squared() {
            self.spokes[k / 2] - self.centre
        } else {
            // At a reflex corner the product points inward; the faces' own areas tell.
            let edges = self.spokes.windows(2).map(|s| (s[0] - self.centre).cross(s[1] - self.centre));
            let areas = edges.fold(DVec3::ZERO, |sum, area| sum + area);
            if areas.dot(normal) < 0.0 { -last } else { last }
        };
        Tangents { along: first, across, angle, ends: Some(ends) }
    }
}

/// By how much of an edge the last of a series' estimates has moved, at most. The estimate after it is off by
/// far less, for it has one power of 1/2 more.
const STEADY: f64 = 1e-10;

/// The finest level at which a curve is sampled: a side of a million edges still has indices.
pub(super) const FINEST_SAMPLE: u32 = 43;
