//! Where a line meets a surface.

use glam::DVec3;
use selvedge_components::evaluate::{Jet, SurfacePoint};

use super::SurfaceIndex;
use super::cells::Cell;
use super::walk::{Spot, Walk};

/// Where a line passes through a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where on the surface.
    pub at: SurfacePoint,
    /// The point, in model units.
    pub position: DVec3,
    /// Where on the line: the point is `origin + t direction`.
    pub t: f64,
}

/// A line `origin + t direction`.
#[derive(Clone, Copy, Debug)]
struct Line {
    origin: DVec3,
    direction: DVec3,
}

/// Steps of one search: Newton's method doubles its digits each time, and starts within a nearly flat
/// cell.
const MOST_STEPS: usize = 24;

impl<S: Walk> SurfaceIndex<S> {
    /// Every place where the line passes through the surface with `t` in `range`, by ascending `t`. A
    /// place where it only touches may be missed.
    pub fn hits(&self, origin: DVec3, direction: DVec3, range: [f64; 2]) -> Vec<Hit> {
        let mut hits: Vec<Hit> = Vec::new();
        let line = Line { origin, direction };
        self.tree.along(origin, direction, range, |c, end| {
            if let Some(hit) = self.hit_from(line, self.cell(c), range)
                && !hits.iter().any(|h| self.is_same(h, &hit))
            {
                hits.push(hit);
            }
            end
        });
        hits.sort_by(|a, b| a.t.total_cmp(&b.t));
        hits
    }

    /// The first place where the line passes through the surface with `t` in `range`.
    pub fn first_hit(&self, origin: DVec3, direction: DVec3, range: [f64; 2]) -> Option<Hit> {
        let mut first: Option<Hit> = None;
        let line = Line { origin, direction };
        self.tree.along(origin, direction, range, |c, end| match self.hit_from(line, self.cell(c), range) {
            // Neighbouring cells find the same place, and differ by rounding alone: the first stays.
            Some(hit) if first.is_none_or(|f| hit.t < f.t && !self.is_same(&f, &hit)) => {
                first = Some(hit);
                // The box that holds the next best begins no later than it.
                hit.t.min(end)
            }
            _ => end,
        });
        first
    }

    fn is_same(&self, a: &Hit, b: &Hit) -> bool {
        a.position.distance(b.position) <= 64.0 * self.fine
    }

    /// Newton's method for `S(s, t) = origin + t direction` from where the line meets the cell's plane.
    fn hit_from(&self, line: Line, cell: &Cell, range: [f64; 2]) -> Option<Hit> {
        let mut spot = Spot::new(cell.place(line.weights_in(cell)?));
        let mut jet = self.surface.jet(spot.point());
        let (mut before, mut step_before) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..MOST_STEPS {
            let (ds, dt, t) = line.step(&jet)?;
            let length = (jet.ds * ds + jet.dt * dt).length();
            // A step longer than the cell leads out of what the derivatives know.
            let share = (cell.size() / length).min(1.0);
            let next = spot.moved(&*self.surface, (ds * share, dt * share));
            jet = self.surface.jet(next.point());
            spot = next;
            let off = line.distance(jet.position, t);
            // Newton's steps shrink ever faster: the next one leaves less than this.
            let left = if step_before.is_finite() { length * (length / step_before) } else { length };
            if length <= self.fine || left <= self.fine || (off <= 4.0 * self.fine && off >= 0.5 * before) {
                let slack = 4.0 * self.fine / line.direction.length();
                let inside = t >= range[0] - slack && t <= range[1] + slack;
                let hit = Hit { at: spot.point(), position: jet.position, t };
                return (inside && off <= 64.0 * self.fine).then_some(hit);
            }
            (before, step_before) = (off, length);
        }
        None
    }
}

impl Line {
    /// The step of the surface's coordinates to where its tangent plane meets the line, and the `t`
    /// there.
    fn step(&self, jet: &Jet) -> Option<(f64, f64, f64)> {
        let ([ds, dt, t], _) = self.meet(jet.position, jet.ds, jet.dt)?;
        Some((ds, dt, t))
    }

    /// `(x, y, t)` with `origin + t direction = base + x a + y b`, and the determinant that decides whether
    /// there is one. By Cramer's rule. [Möller and Trumbore 1997]
    fn meet(&self, base: DVec3, a: DVec3, b: DVec3) -> Option<([f64; 3], f64)> {
        let across = self.direction.cross(b);
        let determinant = a.dot(across);
        // Below this the line runs along the plane, as far as rounding can tell.
        let least = 16.0 * f64::EPSILON;
        let sizes = a.length_squared() * b.length_squared() * self.direction.length_squared();
        if determinant * determinant <= least * least * sizes {
            return None;
        }
        let from = self.origin - base;
        let other = from.cross(a);
        let all = [from.dot(across), self.direction.dot(other), b.dot(other)];
        Some((all.map(|x| x / determinant), determinant))
    }

    /// The distance of `point` from the point of the line at `t`.
    fn distance(&self, point: DVec3, t: f64) -> f64 {
        point.distance(self.origin + self.direction * t)
    }

    /// Where in the cell's triangle to begin; `None` if the line passes by too far off to meet the
    /// surface over the cell.
    fn weights_in(&self, cell: &Cell) -> Option<[f64; 3]> {
        let [p, q, r] = cell.points;
        let Some(([x, y, _], determinant)) = self.meet(p, q - p, r - p) else {
            // The line runs along the triangle's plane.
            return Some([1.0 / 3.0; 3]);
        };
        let weights = [1.0 - x - y, x, y];
        // Off its plane by the sag, the surface is met that much aside, the more the flatter the line: by the
        // sag over the sine of the line's angle with the plane, in heights of the triangle.
        let aside = 0.1 + cell.sag * cell.size() * self.direction.length() / determinant.abs();
        if weights.iter().any(|&w| w < -aside) {
            return None;
        }
        let inside = weights.map(|w| w.max(0.0));
        let sum: f64 = inside.iter().sum();
        Some(inside.map(|w| w / sum))
    }
}
