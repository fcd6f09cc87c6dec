//! # Pre-image: where a curve runs on the source
//!
//! Closest points along the curve, as many as it takes for neighbours to lie in one face or in two
//! that share an edge, and for the chords to follow the curve. The pre-image is approximate: it
//! decides which faces go and which stay, and never where the new border lies, which is the curve
//! itself. [Litke et al. 2001, Section 3.1]

use glam::DVec3;
use selvedge_components::curve::Curve;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, HalfedgeId};

use super::error::PreImageError;
use super::path::{self, Join};
use selvedge_components::target::Target;

/// A point of a pre-image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// The curve's parameter.
    pub u: f64,
    /// The curve's point, in model units.
    pub position: DVec3,
    /// The place of the source that stands for it.
    pub at: SurfacePoint,
    /// How far the curve's point lies off the surface, in model units.
    pub distance: f64,
}

/// Where a curve, or a part of one between two borders, runs on a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PreImage {
    /// The points by rising parameter. One that runs round does not repeat its first point; the
    /// parameters of a part of a closed curve may run on beyond 1.
    pub points: Vec<PathPoint>,
    /// Does it run round, or from border to border?
    pub extent: Extent,
}

/// How a pre-image begins and ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Extent {
    /// It ends where it begins.
    #[default]
    Round,
    /// It begins and ends on a border: at junctions, where the curve is cut.
    Across,
}

impl PreImage {
    /// The greatest distance of the curve from the surface, over the points.
    pub fn distance(&self) -> f64 {
        self.points.iter().map(|p| p.distance).fold(0.0, f64::max)
    }
}

/// How a pre-image is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceOptions {
    /// The greatest distance that the curve may lie off the surface, in model units.
    pub curve: f64,
    /// The greatest step between points, in model units: a part of the cage's edge.
    pub step: f64,
}

/// The cosine of the angle between neighbouring chords below which they follow the curve: 1/40 radian.
/// Chords that turn by `a` stand off an arc of radius `r` by `r a^2 / 8`, here 8e-5 of it: less than a
/// twentieth of a cage edge down to edges of `r / 600`, where walls of a few of them end.
const COS_TURN: f64 = 0.999_687_516_276_041_7;

/// Halvings of the first pieces: `2^-24` of the curve is below the resolution of any cage.
const DEEPEST: u32 = 24;

/// Pieces to begin with, so that no closed curve is a single chord.
const FIRST: u32 = 16;

/// Finds the pre-image of `curve`.
///
/// # Errors
/// When the curve is not finite, is too far off, leaves the surface, has no length, or jumps from
/// one part of the surface to another.
pub fn trace(
    mesh: &Connectivity,
    target: &dyn Target,
    curve: &dyn Curve,
    options: TraceOptions,
) -> Result<PreImage, PreImageError> {
    let knots = knots(curve, FIRST);
    let tracer = Tracer { mesh, target, curve, options };
    let mut points = vec![tracer.at(0.0, None)?];
    for pair in knots.windows(2) {
        let last = points[points.len() - 1];
        let end = tracer.at(pair[1], Some(last.at))?;
        tracer.between(last, end, &mut points)?;
        points.push(end);
    }
    let length: f64 = points.windows(2).map(|p| p[0].position.distance(p[1].position)).sum();
    // Shorter than rounding of its own coordinates: nothing can be told apart along it.
    let size = points[0].position.abs().max_element().max(options.step);
    if length <= 1e3 * f64::EPSILON * size {
        return Err(PreImageError::NoLength { at: points[0].position, length });
    }
    if curve.closed() {
        points.pop();
    }
    Ok(PreImage { points, extent: Extent::Round })
}

/// Finds the pre-images of the parts of `curve` that lie on the surface, where it may leave across
/// borders: one that runs round if all of it does.
///
/// # Errors
/// As [`trace`]; a curve that leaves and comes back within a sixty-fourth of its parameter is not
/// followed, but refused as [`PreImageError::LeavesSurface`].
pub fn trace_parts(
    mesh: &Connectivity,
    target: &dyn Target,
    curve: &dyn Curve,
    options: TraceOptions,
) -> Result<Vec<PreImage>, PreImageError> {
    let tracer = Tracer { mesh, target, curve, options };
    let knots = knots(curve, LOOKS);
    let seen: Vec<Option<PathPoint>> = knots.iter().map(|&u| tracer.inside(u)).collect::<Result<_, _>>()?;
    if seen.iter().all(Option::is_some) && curve.closed() {
        return Ok(vec![trace(mesh, target, curve, options)?]);
    }
    let mut parts = Vec::new();
    let count = knots.len();
    // A part of a closed curve may begin before its end: it is followed into the next round.
    let rounds = if curve.closed() { 2 * count - 1 } else { count };
    let at = |i: usize| if i < count { (knots[i], seen[i]) } else { (knots[i - count + 1] + 1.0, seen[i - count + 1]) };
    let mut open: Option<PreImage> = None;
    for i in 1..rounds {
        let ((before, was), (now, is)) = (at(i - 1), at(i));
        if was.is_none() && is.is_some() {
            if i >= count {
                break;
            }
            let start = tracer.junction(now, before)?;
            open = Some(PreImage { points: vec![start], extent: Extent::Across });
        }
        let Some(part) = &mut open else { continue };
        let end = match is {
            Some(point) => PathPoint { u: now, ..point },
            None => tracer.junction(before, now)?,
        };
        let last = part.points[part.points.len() - 1];
        if end.u > last.u {
            tracer.between(last, end, &mut part.points)?;
            part.points.push(end);
        }
        if is.is_none() {
            parts.extend(open.take());
        }
    }
    Ok(parts)
}

/// How often a curve that may leave the surface is looked at to begin with.
const LOOKS: u32 = 64;

/// Where a curve is looked at to begin with, ascending: at `count` even steps and at its corners. A
/// step next to a corner is left out: a piece between the two would be shorter than all others, at
/// worst by rounding alone, and pieces of which nothing but rounding is left seem to cross.
fn knots(curve: &dyn Curve, count: u32) -> Vec<f64> {
    const NEXT_TO: f64 = 1.0 / 64.0;
    let step = 1.0 / f64::from(count);
    let inside = |u: &f64| NEXT_TO * step < *u && *u < 1.0 - NEXT_TO * step;
    let corners: Vec<f64> = curve.corners().iter().copied().filter(inside).collect();
    let even = (1..count).map(|k| f64::from(k) * step);
    let away = even.filter(|u| corners.iter().all(|corner| (corner - u).abs() > NEXT_TO * step));
    let mut knots: Vec<f64> = away.chain([0.0, 1.0]).collect();
    knots.extend(&corners);
    knots.sort_unstable_by(f64::total_cmp);
    knots.dedup();
    knots
}

struct Tracer<'a> {
    mesh: &'a Connectivity,
    target: &'a dyn Target,
    curve: &'a dyn Curve,
    options: TraceOptions,
}

impl Tracer<'_> {
    /// The point of the pre-image at `u`; `None` beyond a border.
    fn inside(&self, u: f64) -> Result<Option<PathPoint>, PreImageError> {
        match self.at(u, None) {
            Ok(point) => Ok(Some(point).filter(|p| !self.on_border(p.at))),
            Err(PreImageError::LeavesSurface { .. }) => Ok(None),
            Err(why) => Err(why),
        }
    }

    /// The point of the border at which the curve leaves the surface, between a parameter inside and
    /// one outside: the last place whose closest point is still on the border.
    fn junction(&self, mut inside: f64, mut outside: f64) -> Result<PathPoint, PreImageError> {
        loop {
            let middle = 0.5 * (inside + outside);
            if middle == inside || middle == outside {
                break;
            }
            match self.inside(middle)? {
                Some(_) => inside = middle,
                None => outside = middle,
            }
        }
        let point = self.at(outside, None)?;
        Ok(point)
    }

    fn at(&self, u: f64, hint: Option<SurfacePoint>) -> Result<PathPoint, PreImageError> {
        let wrapped = if self.curve.closed() && u > 1.0 { u - 1.0 } else { u };
        let position = self.curve.position(wrapped);
        if !position.is_finite() {
            return Err(PreImageError::NotFinite { u, at: position });
        }
        let foot = self.target.closest(position, hint).map_err(|source| PreImageError::Target { u, source })?;
        let at = foot.at.ok_or(PreImageError::NoPlace { u })?;
        let distance = foot.position.distance(position);
        if distance > self.options.curve {
            return Err(if self.on_border(at) {
                PreImageError::LeavesSurface { u, at: position, distance }
            } else {
                PreImageError::TooFarOff { u, at: position, distance, limit: self.options.curve }
            });
        }
        Ok(PathPoint { u, position, at, distance })
    }

    fn on_border(&self, at: SurfacePoint) -> bool {
        // Closest points on a border are put there exactly; what rounding remains is a few units.
        let zero = |w: f64| w.abs() <= 16.0 * f64::EPSILON;
        let off = [at.st.y, 1.0 - at.st.x - at.st.y, at.st.x];
        (0..3).any(|i| zero(off[i]) && self.mesh.twin(HalfedgeId::of(at.face, i)).is_none())
    }

    /// Pushes the points that are needed between `a` and `b`, in order.
    fn between(&self, a: PathPoint, b: PathPoint, points: &mut Vec<PathPoint>) -> Result<(), PreImageError> {
        // Pieces still to be looked at, the first on top.
        let mut stack = vec![(a, b, 0)];
        while let Some((a, b, depth)) = stack.pop() {
            let way = path::connect(self.mesh, a.at, b.at, 0.0).map(|(_, join)| join);
            let middle = self.at(0.5 * (a.u + b.u), Some(a.at))?;
            let spent = depth == DEEPEST || middle.u <= a.u || middle.u >= b.u;
            let done = match way {
                Some(Join::Straight) => self.follows(&a, &middle, &b),
                // A bent way is as good as a straight one once it is too short to matter.
                Some(Join::Bent) => a.position.distance(b.position) < self.options.step / 256.0,
                None => false,
            };
            if !done && !spent {
                stack.push((middle, b, depth + 1));
                stack.push((a, middle, depth + 1));
                continue;
            }
            if way.is_none() {
                let places = [a.at, b.at];
                return Err(PreImageError::Ambiguous { u: a.u, at: a.position, places });
            }
            if a.u > points[points.len() - 1].u {
                points.push(a);
            }
        }
        Ok(())
    }

    fn follows(&self, a: &PathPoint, middle: &PathPoint, b: &PathPoint) -> bool {
        let (first, second) = (middle.position - a.position, b.position - middle.position);
        let straight = first.dot(second) >= COS_TURN * first.length() * second.length();
        straight && first.length() + second.length() <= self.options.step
    }
}
