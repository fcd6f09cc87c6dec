//! From a start on the surface to the nearest point around it.

use glam::DVec3;
use selvedge_components::evaluate::Jet;

use super::walk::{Spot, Walk, faces_around};

/// How far a search has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reached {
    pub spot: Spot,
    pub position: DVec3,
    pub square: f64,
    /// Along the normal.
    pub facing: DVec3,
}

/// Steps of one search. Newton's method doubles its digits each time, so ten are plenty; what is left
/// is for starts that have to follow the surface round, a face or so at a time.
const MOST_STEPS: usize = 64;

/// How often a step is halved that leads no nearer. After 40 it has lost 12 digits: the place is as
/// near as the rounding of the distance can tell.
const MOST_HALVINGS: usize = 40;

/// Gauss-Newton steps that shrink by less than this from one to the next give way to Newton's: the
/// point is then so far off that the surface's curvature counts.
const SLOW: f64 = 0.1;

/// The step of the differences that Newton's second derivatives are made of: half of the digits, so
/// that the error of the derivatives, 1e-8 of them, still gains eight digits a step.
const DIFFERENCE: f64 = 1e-6;

/// What a step is to be.
enum Plan {
    /// Freely over the faces.
    Free((f64, f64)),
    /// Along the border edge that leaves this corner.
    Edge(usize, f64),
    /// From a vertex into this face.
    Into(Spot, (f64, f64)),
    /// There is nowhere nearer.
    Rest,
}

/// Seeks the point of `surface` nearest to `goal` around `start`, and follows the surface as long as
/// that leads nearer. `fine` is the length of step, in model units, that is no longer worth taking.
///
/// The distance at the end is never above that at the start.
pub(super) fn seek(surface: &(impl Walk + ?Sized), goal: DVec3, start: Spot, fine: f64) -> Reached {
    let mut spot = start;
    let mut jet = surface.jet(spot.point());
    let mut square = jet.position.distance_squared(goal);
    let mut before = f64::INFINITY;
    let mut curved = false;
    for _ in 0..MOST_STEPS {
        let plan = plan(surface, goal, &spot, &jet, curved);
        let length = plan.length(&jet);
        // Steps that shrink as fast as the last two did leave this much after the next one.
        let left = if before.is_finite() { length * (length / before) } else { length };
        curved |= length > SLOW * before;
        let Some((next, nearer, moved)) = take(surface, goal, &plan, (&spot, square), fine) else { break };
        (spot, jet, square) = (next, nearer, moved);
        if length <= fine || left <= fine {
            break;
        }
        before = length;
    }
    snap(surface, goal, Reached { spot, position: jet.position, square, facing: jet.ds.cross(jet.dt) })
}

/// Takes the step, or as much of it as leads nearer.
fn take(
    surface: &(impl Walk + ?Sized),
    goal: DVec3,
    plan: &Plan,
    (spot, square): (&Spot, f64),
    fine: f64,
) -> Option<(Spot, Jet, f64)> {
    let mut share = 1.0;
    for _ in 0..MOST_HALVINGS {
        let next = match *plan {
            Plan::Rest => return None,
            Plan::Free((ds, dt)) => spot.moved(surface, (ds * share, dt * share)),
            Plan::Into(from, (ds, dt)) => from.moved(surface, (ds * share, dt * share)),
            Plan::Edge(corner, by) => spot.along_edge(corner, by * share),
        };
        let jet = surface.jet(next.point());
        let moved = jet.position.distance_squared(goal);
        // A small step sideways changes the distance by less than its rounding, `fine`: there the steps'
        // own shrinking is the judge.
        if moved <= square + (2.0 * square.sqrt() + fine) * fine {
            return Some((next, jet, moved));
        }
        share *= 0.5;
    }
    None
}

fn plan(surface: &(impl Walk + ?Sized), goal: DVec3, spot: &Spot, jet: &Jet, curved: bool) -> Plan {
    if let Some(corner) = spot.corner() {
        return leave_vertex(surface, goal, spot, corner);
    }
    let offset = jet.position - goal;
    let second = if curved { second_derivatives(surface, spot, jet, offset) } else { [0.0; 3] };
    let step = newton(jet, offset, second);
    let border = spot.edges().find(|&e| surface.across(spot.face, e).is_none());
    match border {
        // The edge lies where the weight of the corner after next is zero.
        Some(e) if change(step, (e + 2) % 3) < 0.0 => {
            let along = along_edge(jet, e);
            let bend = edge_second(second, e);
            let (full, plain) = (along.length_squared() + bend, along.length_squared());
            let curvature = if full > 0.0 { full } else { plain };
            if curvature > 0.0 { Plan::Edge(e, -offset.dot(along) / curvature) } else { Plan::Rest }
        }
        _ => Plan::Free(step),
    }
}

impl Plan {
    /// How far the step leads, in model units.
    fn length(&self, jet: &Jet) -> f64 {
        match *self {
            Self::Free((ds, dt)) => (jet.ds * ds + jet.dt * dt).length(),
            Self::Edge(corner, by) => along_edge(jet, corner).length() * by.abs(),
            // A vertex is no place to judge the speed of convergence from.
            Self::Into(..) => f64::INFINITY,
            Self::Rest => 0.0,
        }
    }
}

/// Where a first step would lead, roughly: along the tangent plane.
pub(super) fn aim(jet: &Jet, goal: DVec3) -> DVec3 {
    let (ds, dt) = newton(jet, jet.position - goal, [0.0; 3]);
    jet.position + jet.ds * ds + jet.dt * dt
}

/// The step to the least of the quadratic model. `second` are the second derivatives' parts along the
/// offset; where they would make the model a saddle, they are left out.
fn newton(jet: &Jet, offset: DVec3, second: [f64; 3]) -> (f64, f64) {
    let (g, h) = (offset.dot(jet.ds), offset.dot(jet.dt));
    let (a, b, c) = (jet.ds.length_squared(), jet.ds.dot(jet.dt), jet.dt.length_squared());
    let [p, q, r] = second;
    let full = solve(a + p, b + q, c + r, g, h);
    let plain = || solve(a, b, c, g, h);
    // Parallel derivatives: down the gradient, as far as the longer one says.
    full.or_else(plain).unwrap_or_else(|| {
        let most = a.max(c);
        if most > 0.0 { (-g / most, -h / most) } else { (0.0, 0.0) }
    })
}

/// Solves `[a b; b c] x = -(g, h)` for a positive definite matrix.
fn solve(a: f64, b: f64, c: f64, g: f64, h: f64) -> Option<(f64, f64)> {
    let determinant = a * c - b * b;
    // Positive by more than the rounding of its terms.
    let sound = a > 0.0 && c > 0.0 && determinant > 8.0 * f64::EPSILON * a * c;
    sound.then(|| ((b * h - c * g) / determinant, (b * g - a * h) / determinant))
}

/// `offset . S_ss`, `offset . S_st` and `offset . S_tt`, by differences towards the inside.
fn second_derivatives(surface: &(impl Walk + ?Sized), spot: &Spot, jet: &Jet, offset: DVec3) -> [f64; 3] {
    let [a, b, c] = spot.weights;
    // A step by s trades with the first weight: each gives to the smaller.
    let (x, y) = (if a < b { -DIFFERENCE } else { DIFFERENCE }, if a < c { -DIFFERENCE } else { DIFFERENCE });
    if a.max(b) <= DIFFERENCE || a.max(c) <= DIFFERENCE {
        return [0.0; 3];
    }
    let at = |ds: f64, dt: f64| surface.jet(Spot { face: spot.face, weights: [a - ds - dt, b + ds, c + dt] }.point());
    let (by_s, by_t) = (at(x, 0.0), at(0.0, y));
    let (ss, st) = ((by_s.ds - jet.ds) / x, (by_s.dt - jet.dt) / x);
    let (ts, tt) = ((by_t.ds - jet.ds) / y, (by_t.dt - jet.dt) / y);
    [offset.dot(ss), 0.5 * offset.dot(st + ts), offset.dot(tt)]
}

/// The change of a corner's weight by a step of `(s, t)`.
fn change((ds, dt): (f64, f64), corner: usize) -> f64 {
    [-ds - dt, ds, dt][corner]
}

/// The derivative along the edge from `corner` to the next.
fn along_edge(jet: &Jet, corner: usize) -> DVec3 {
    match corner {
        0 => jet.ds,
        1 => jet.dt - jet.ds,
        _ => -jet.dt,
    }
}

/// As [`along_edge`], of a quadratic form in `(s, t)`.
fn edge_second([p, q, r]: [f64; 3], corner: usize) -> f64 {
    match corner {
        0 => p,
        1 => p - 2.0 * q + r,
        _ => r,
    }
}

/// At a vertex: into the face of its fan that promises most.
fn leave_vertex(surface: &(impl Walk + ?Sized), goal: DVec3, spot: &Spot, corner: usize) -> Plan {
    let mut best = (0.0, Plan::Rest);
    for (face, c) in faces_around(surface, spot.face, corner) {
        let mut weights = [0.0; 3];
        weights[c] = 1.0;
        let from = Spot { face, weights };
        let jet = surface.jet(from.point());
        let offset = jet.position - goal;
        // The two edges that leave the corner; whoever turns back on the second walks it backwards.
        let (next, after) = (along_edge(&jet, c), -along_edge(&jet, (c + 2) % 3));
        let (x, y, gain) = best_in_sector(offset, next, after);
        // A millionth of a millionth of the distance, sideways, is rounding.
        if gain > best.0 && gain > 1e-24 * offset.length_squared() {
            let mut by = [0.0; 3];
            (by[(c + 1) % 3], by[(c + 2) % 3]) = (x, y);
            by[c] = -x - y;
            best = (gain, Plan::Into(from, (by[1], by[2])));
        }
    }
    best.1
}

/// The `x >= 0` and `y >= 0` that make `|offset + x next + y after|^2` least, and by how much.
fn best_in_sector(offset: DVec3, next: DVec3, after: DVec3) -> (f64, f64, f64) {
    let (g, h) = (offset.dot(next), offset.dot(after));
    let (a, b, c) = (next.length_squared(), next.dot(after), after.length_squared());
    if let Some((x, y)) = solve(a, b, c, g, h)
        && x > 0.0
        && y > 0.0
    {
        return (x, y, -(g * x + h * y));
    }
    let alone = |g: f64, a: f64| if g < 0.0 && a > 0.0 { (-g / a, g * g / a) } else { (0.0, 0.0) };
    let ((x, gain_x), (y, gain_y)) = (alone(g, a), alone(h, c));
    if gain_x >= gain_y { (x, 0.0, gain_x) } else { (0.0, y, gain_y) }
}

/// Next to a vertex steps only halve what is left, for the faces' coordinates are not smooth there:
/// if the vertex itself is as near, it is the answer.
fn snap(surface: &(impl Walk + ?Sized), goal: DVec3, reached: Reached) -> Reached {
    const NEAR: f64 = 1e-6;
    let Some(corner) = reached.spot.weights.iter().position(|&w| w > 1.0 - NEAR && w < 1.0) else { return reached };
    let mut weights = [0.0; 3];
    weights[corner] = 1.0;
    let spot = Spot { face: reached.spot.face, weights };
    let position = surface.position(spot.point());
    let square = position.distance_squared(goal);
    if square <= reached.square { Reached { spot, position, square, ..reached } } else { reached }
}
