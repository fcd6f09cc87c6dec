//! # Pre-image: where a curve runs on the source
//!
//! Closest points along the curve, as many as it takes for neighbours to lie in one face or in two
//! that share an edge, and for the chords to follow the curve. The pre-image is approximate: it
//! decides which faces go and which stay, and never where the new border lies, which is the curve
//! itself. [Litke et al. 2001, Section 3.1]

use glam::DVec3;
use selvedge_components::curve::{Curve, wrap};
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, HalfedgeId};

use super::error::PreImageError;
use super::hints::Hints;
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

/// The cosine of the angle between neighbouring pieces above which both are halved: a quarter of a radian,
/// some times the turn of pieces that follow their curve. A long piece whose halves seem straight may end
/// beyond a small fillet, all of whose turn is then at that end.
const COS_SHARP: f64 = 0.968_912_421_710_644_8;

/// Pieces shorter than this part of a step are not halved for what they turn by: a quarter of a face of the
/// finest level, so what turns there is beyond any cage.
const SHORTEST: f64 = 1.0 / (1_u64 << 13) as f64;

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
    Tracer { mesh, target, curve, options, hints: &Hints::default() }.round()
}

/// Finds the pre-images of the parts of `curve` that lie on the surface, where it may leave across
/// borders: one that runs round if all of it does.
///
/// # Errors
/// As [`trace`]; [`PreImageError::EndsInside`]; a curve that leaves and comes back within a sixty-fourth of its parameter is not
/// followed, but refused as [`PreImageError::LeavesSurface`].
pub fn trace_parts(
    mesh: &Connectivity,
    target: &dyn Target,
    curve: &dyn Curve,
    options: TraceOptions,
) -> Result<Vec<PreImage>, PreImageError> {
    trace_near(mesh, target, curve, options, &Hints::default())
}

/// As [`trace_parts`], for a curve that is said to run at some places. The target should stay on the
/// sheet that a place lies on; the curve is then followed over it from place to place.
///
/// # Errors
/// As [`trace_parts`]; [`PreImageError::Ambiguous`] where places lead to others that do not meet.
pub fn trace_near(
    mesh: &Connectivity,
    target: &dyn Target,
    curve: &dyn Curve,
    options: TraceOptions,
    hints: &Hints,
) -> Result<Vec<PreImage>, PreImageError> {
    let tracer = Tracer { mesh, target, curve, options, hints };
    let knots = tracer.knots(LOOKS);
    let seen = tracer.seen(&knots)?;
    if seen.iter().all(Option::is_some) && curve.closed() {
        return Ok(vec![tracer.round()?]);
    }
    let ends = [seen[0], seen[seen.len() - 1]];
    if let (false, Some(end)) = (curve.closed(), ends.into_iter().flatten().next()) {
        let gap = curve.position(0.0).distance(curve.position(1.0));
        return Err(PreImageError::EndsInside { u: end.u, at: end.position, gap });
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
            let start = tracer.junction(now, before, is.map(|point| point.at))?;
            open = Some(PreImage { points: vec![start], extent: Extent::Across });
        }
        let Some(part) = &mut open else { continue };
        let end = match is {
            Some(point) => PathPoint { u: now, ..point },
            None => tracer.junction(before, now, was.map(|point| point.at))?,
        };
        let last = part.points[part.points.len() - 1];
        if end.u > last.u {
            tracer.between(last, end, &mut part.points)?;
            part.points.push(end);
        }
        if let (None, Some(part)) = (is, open.take_if(|_| is.is_none())) {
            parts.push(PreImage { points: tracer.smoothed(part.points, false)?, ..part });
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
    hints: &'a Hints,
}

impl Tracer<'_> {
    /// The pre-image of a curve that lies on the surface as a whole.
    fn round(&self) -> Result<PreImage, PreImageError> {
        let curve = self.curve;
        let knots = self.knots(FIRST);
        let mut points = vec![self.at(0.0, self.begin(0.0)?)?];
        for pair in knots.windows(2) {
            let last = points[points.len() - 1];
            let end = self.at(pair[1], self.hints.at(pair[1]).or(Some(last.at)))?;
            self.between(last, end, &mut points)?;
            points.push(end);
        }
        points = self.smoothed(points, true)?;
        let length: f64 = points.windows(2).map(|p| p[0].position.distance(p[1].position)).sum();
        // Shorter than rounding of its own coordinates: nothing can be told apart along it.
        let size = points[0].position.abs().max_element().max(self.options.step);
        if length <= 1e3 * f64::EPSILON * size {
            return Err(PreImageError::NoLength { at: points[0].position, length });
        }
        if curve.closed() {
            let end = points.pop().map_or(points[0], |end| end);
            // Followed from place to place, it might end on another sheet than it began on.
            if path::connect(self.mesh, end.at, points[0].at, 0.0).is_none() {
                let places = [end.at, points[0].at];
                return Err(PreImageError::Ambiguous { u: end.u, at: end.position, places });
            }
        }
        Ok(PreImage { points, extent: Extent::Round })
    }

    /// Where to begin to look for the place at `u`, if anything is said of it: the curve is followed
    /// there from the nearest place that is given.
    fn begin(&self, u: f64) -> Result<Option<SurfacePoint>, PreImageError> {
        let Some(given) = self.hints.near(u, self.curve) else { return Ok(None) };
        let way = u - given.u;
        let looks = f64::from(self.hints.looks(self.curve, LOOKS, self.options.step));
        let steps = (way.abs() * looks).ceil().max(1.0) as u32;
        let mut place = given.at;
        for k in 0..=steps {
            let u = given.u + way * (f64::from(k) / f64::from(steps));
            let u = if self.curve.closed() { wrap(u) } else { u };
            let position = self.curve.position(u);
            if !position.is_finite() {
                return Err(PreImageError::NotFinite { u, at: position });
            }
            let foot =
                self.target.closest(position, Some(place)).map_err(|source| PreImageError::Target { u, source })?;
            place = foot.at.ok_or(PreImageError::NoPlace { u })?;
        }
        Ok(Some(place))
    }

    /// Where the curve is looked at to begin with, ascending.
    fn knots(&self, least: u32) -> Vec<f64> {
        let mut knots = knots(self.curve, self.hints.looks(self.curve, least, self.options.step));
        knots.extend(self.hints.parameters());
        knots.sort_unstable_by(f64::total_cmp);
        knots.dedup();
        knots
    }

    /// The points of the pre-image at `knots`; `None` beyond a border. Where places are given, each is
    /// sought from the one before, or from its own.
    fn seen(&self, knots: &[f64]) -> Result<Vec<Option<PathPoint>>, PreImageError> {
        let mut last = self.begin(knots[0])?;
        let step = |&u: &f64| {
            let hint = self.hints.at(u).or(last);
            let point = self.inside(u, hint)?;
            if !self.hints.is_empty() {
                last = point.map_or_else(|| self.begin(u), |point| Ok(Some(point.at)))?;
            }
            Ok(point)
        };
        knots.iter().map(step).collect()
    }

    /// The point of the pre-image at `u`; `None` beyond a border.
    fn inside(&self, u: f64, hint: Option<SurfacePoint>) -> Result<Option<PathPoint>, PreImageError> {
        match self.at(u, hint) {
            Ok(point) => Ok(Some(point).filter(|p| !self.on_border(p.at))),
            Err(PreImageError::LeavesSurface { .. }) => Ok(None),
            Err(why) => Err(why),
        }
    }

    /// The point of the border at which the curve leaves the surface, between a parameter inside and
    /// one outside: the last place whose closest point is still on the border.
    fn junction(
        &self,
        mut inside: f64,
        mut outside: f64,
        near: Option<SurfacePoint>,
    ) -> Result<PathPoint, PreImageError> {
        let near = near.filter(|_| !self.hints.is_empty());
        loop {
            let middle = 0.5 * (inside + outside);
            if middle == inside || middle == outside {
                break;
            }
            match self.inside(middle, near)? {
                Some(_) => inside = middle,
                None => outside = middle,
            }
        }
        self.at(outside, near)
    }

    /// The curve's own parameter of one that may run on to 1 and beyond.
    fn own(&self, u: f64) -> f64 {
        if self.curve.closed() && u >= 1.0 { u - 1.0 } else { u }
    }

    fn at(&self, counted: f64, hint: Option<SurfacePoint>) -> Result<PathPoint, PreImageError> {
        let u = self.own(counted);
        let position = self.curve.position(u);
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
        Ok(PathPoint { u: counted, position, at, distance })
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
                return Err(PreImageError::Ambiguous { u: self.own(a.u), at: a.position, places });
            }
            if a.u > points[points.len() - 1].u {
                points.push(a);
            }
        }
        Ok(())
    }

    /// The points with more of them where the way from one to the next turns sharply and the curve has no
    /// corner; the first and the last of those that run round are one place.
    fn smoothed(&self, mut points: Vec<PathPoint>, round: bool) -> Result<Vec<PathPoint>, PreImageError> {
        let long = SHORTEST * self.options.step;
        for _ in 0..DEEPEST {
            let halved = self.sharp(&points, round, long);
            if !halved.contains(&true) {
                break;
            }
            let mut finer = vec![points[0]];
            for (pair, halved) in points.windows(2).zip(halved) {
                let [a, b] = [pair[0], pair[1]];
                let u = 0.5 * (a.u + b.u);
                if halved && a.u < u && u < b.u {
                    let middle = self.at(u, Some(a.at))?;
                    self.between(a, middle, &mut finer)?;
                    finer.push(middle);
                    self.between(middle, b, &mut finer)?;
                }
                finer.push(b);
            }
            points = finer;
        }
        Ok(points)
    }

    /// Of each piece between two points, whether it is `long` and the way turns sharply at an end of it.
    fn sharp(&self, points: &[PathPoint], round: bool, long: f64) -> Vec<bool> {
        let count = points.len() - 1;
        let way = |k: usize| points[k + 1].position - points[k].position;
        let mut sharp = vec![false; count];
        for k in if round { 0..count } else { 1..count } {
            let before = (k + count - 1) % count;
            let (first, second) = (way(before), way(k));
            let turns = first.dot(second) < COS_SHARP * first.length() * second.length();
            if turns && !self.curve.corners().contains(&self.own(points[k].u)) {
                sharp[before] |= first.length() > long;
                sharp[k] |= second.length() > long;
            }
        }
        sharp
    }

    fn follows(&self, a: &PathPoint, middle: &PathPoint, b: &PathPoint) -> bool {
        let (first, second) = (middle.position - a.position, b.position - middle.position);
        let straight = first.dot(second) >= COS_TURN * first.length() * second.length();
        straight && first.length() + second.length() <= self.options.step
    }
}
