//! The curves as polylines in space with their ways over the source, and how far things lie from them.
//!
//! Distances are taken in space, but only over connected ground: each vertex learns its nearest
//! piece of curve from its neighbours. So the far side of a thin wall is not near.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};
use selvedge_components::curve::Heading;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::Connectivity;
use selvedge_components::subdivision::{FaceCode, NONE};

use super::error::PreImageError;
use super::path::{self, Leg};
use super::{Cut, PreImage};

/// One point of a track, with the segment that begins there.
#[derive(Clone, Debug)]
pub struct TrackPoint {
    /// In model units.
    pub position: DVec3,
    /// The travel parameter: `u` along the curve, `-u` against it. It rises along the track.
    pub t: f64,
    /// Does the curve turn at once here?
    pub corner: bool,
    /// How far along the track it is, in model units.
    pub along: f64,
    /// The track, by index.
    pub cut: u32,
    /// The curve, by index.
    pub curve: u32,
    /// The curve's own parameter.
    pub u: f64,
    /// The next and the previous point, or [`NONE`] at an open end.
    pub next: u32,
    /// See `next`.
    pub previous: u32,
    /// The way over the source to the next point.
    pub legs: Vec<Leg>,
}

/// All curves, directed so that what stays is on the left.
#[derive(Clone, Debug, Default)]
pub struct Track {
    /// The points of the first curve, then those of the second, and so on.
    pub points: Vec<TrackPoint>,
    /// One entry per curve.
    pub tracks: Vec<Extent>,
}

/// How far the ways of a curve keep aside of vertices and edges that its points lie on, as a part of
/// the edge; times the curve's number, so that no two of them meet a vertex or an edge at the same
/// place. Then which side is which is never a matter of rounding. A million times that is still far
/// below the finest cage.
const ASIDE: f64 = 1.0 / (1_u64 << 33) as f64;

/// A place inside every face, towards which points on its border are moved.
const INSIDE: DVec2 = DVec2::new(0.317, 0.291);

/// What is known of a whole track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Its first point.
    pub begin: u32,
    /// How many points it has.
    pub count: u32,
    /// Its length, in model units.
    pub length: f64,
    /// Does it end where it begins?
    pub closed: bool,
}

/// The nearest place of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Near {
    /// The segment, by its first point.
    pub segment: u32,
    /// Where on it, in [0, 1].
    pub part: f64,
    /// How far away, in model units.
    pub distance: f64,
}

impl Track {
    /// The track of the curves of `cuts`.
    ///
    /// # Errors
    /// When a pre-image skips over faces; with the index of its curve.
    pub fn new(mesh: &Connectivity, cuts: &[Cut], preimages: &[PreImage]) -> Result<Self, (usize, PreImageError)> {
        let mut track = Self::default();
        for (c, (cut, image)) in cuts.iter().zip(preimages).enumerate() {
            track.push(mesh, c, cut, image).map_err(|why| (c, why))?;
        }
        Ok(track)
    }

    fn push(&mut self, mesh: &Connectivity, c: usize, cut: &Cut, image: &PreImage) -> Result<(), PreImageError> {
        let count = image.points.len();
        let closed = image.extent == super::preimage::Extent::Round;
        if count < 3 {
            return Err(PreImageError::BadGiven { index: 0, reason: "it has fewer than three points" });
        }
        let aside = ASIDE * (1 + c % 1024) as f64;
        let place = |k: usize| {
            let at = image.points[k].at;
            // Where a curve ends on a border, it ends there to the bit.
            let is_end = !closed && (k == 0 || k + 1 == count);
            SurfacePoint { st: if is_end { at.st } else { at.st.lerp(INSIDE, aside) }, ..at }
        };
        let corners = cut.curve.corners();
        let order: Vec<usize> = match cut.heading {
            Heading::Along => (0..count).collect(),
            Heading::Against => (0..count).rev().collect(),
        };
        let mut points = Vec::with_capacity(count);
        for (i, &k) in order.iter().enumerate() {
            let p = &image.points[k];
            if !p.position.is_finite() {
                return Err(PreImageError::NotFinite { u: p.u, at: p.position });
            }
            // A part of a closed curve may run on to its beginning, where it may have a corner, and beyond.
            let u = if cut.curve.closed() && p.u >= 1.0 { p.u - 1.0 } else { p.u };
            let legs = if closed || i + 1 < count {
                let next = order[(i + 1) % count];
                let reason = "the next point lies in a face that does not meet this one's";
                path::connect(mesh, place(k), place(next), aside).ok_or(PreImageError::BadGiven { index: k, reason })?.0
            } else {
                Vec::new()
            };
            points.push(TrackPoint {
                position: p.position,
                t: if cut.heading == Heading::Along { p.u } else { -p.u },
                corner: corners.contains(&u),
                along: 0.0,
                cut: 0,
                curve: c as u32,
                u,
                next: NONE,
                previous: NONE,
                legs,
            });
        }
        self.append(points, closed);
        Ok(())
    }

    /// Adds the track of these points, in order; their places in it need not be known.
    pub fn append(&mut self, points: Vec<TrackPoint>, closed: bool) {
        let (begin, count) = (self.points.len() as u32, points.len() as u32);
        let cut = self.tracks.len() as u32;
        let wrap = |k: u32| begin + k % count;
        self.points.extend((0..).zip(points).map(|(k, p)| TrackPoint {
            cut,
            next: if closed || k + 1 < count { wrap(k + 1) } else { NONE },
            previous: if closed || k > 0 { wrap(k + count - 1) } else { NONE },
            ..p
        }));
        let mut along = 0.0;
        for k in begin..begin + count {
            self.points[k as usize].along = along;
            if self.is_segment(k) {
                let (a, b) = self.ends(k);
                along += a.distance(b);
            }
        }
        self.tracks.push(Extent { begin, count, length: along, closed });
    }

    /// Does a segment begin at point `i`?
    pub fn is_segment(&self, i: u32) -> bool {
        self.points[i as usize].next != NONE
    }

    /// The ends of a segment.
    pub fn ends(&self, segment: u32) -> (DVec3, DVec3) {
        let p = &self.points[segment as usize];
        (p.position, self.points[p.next as usize].position)
    }

    /// The travel parameter at `part` of a segment. It rises over the end of a closed curve.
    pub fn parameter(&self, near: Near) -> f64 {
        let p = &self.points[near.segment as usize];
        let end = self.points[p.next as usize].t;
        // Over the end of a closed curve.
        let end = if end <= p.t { end + 1.0 } else { end };
        p.t + (end - p.t) * near.part
    }

    /// The point of the polyline.
    pub fn position(&self, near: Near) -> DVec3 {
        let (a, b) = self.ends(near.segment);
        a.lerp(b, near.part)
    }

    /// How far along its curve a place is, in model units.
    pub fn along(&self, near: Near) -> f64 {
        let (from, to) = self.ends(near.segment);
        self.points[near.segment as usize].along + near.part * from.distance(to)
    }

    /// How far apart two places of one curve are along it, the shorter way round.
    pub fn distance_along(&self, a: Near, b: Near) -> f64 {
        let apart = (self.along(a) - self.along(b)).abs();
        let whole = self.tracks[self.points[a.segment as usize].cut as usize];
        if whole.closed { apart.min(whole.length - apart) } else { apart }
    }

    /// The place `along` model units along curve `cut`, going round as often as it takes.
    pub fn place(&self, cut: u32, along: f64) -> Near {
        let whole = self.tracks[cut as usize];
        let inside = if whole.closed { along.rem_euclid(whole.length) } else { along.clamp(0.0, whole.length) };
        let points = &self.points[whole.begin as usize..(whole.begin + whole.count) as usize];
        let at = points.partition_point(|p| p.along <= inside).max(1) - 1;
        // An open track's last point begins no segment.
        let at = if points[at].next == NONE { at - 1 } else { at };
        let segment = whole.begin + at as u32;
        let (from, to) = self.ends(segment);
        let length = from.distance(to);
        let part = if length > 0.0 { ((inside - points[at].along) / length).clamp(0.0, 1.0) } else { 0.0 };
        Near { segment, part, distance: 0.0 }
    }

    /// The travel parameter `along` model units along curve `cut`, unwrapped.
    pub fn parameter_at(&self, cut: u32, along: f64) -> f64 {
        let whole = self.tracks[cut as usize];
        let rounds = if whole.closed { (along / whole.length).floor() } else { 0.0 };
        self.parameter(self.place(cut, along)) + rounds
    }

    /// The place of travel parameter `t`, unwrapped.
    pub fn place_of_parameter(&self, cut: u32, t: f64) -> Near {
        let whole = self.tracks[cut as usize];
        let points = &self.points[whole.begin as usize..(whole.begin + whole.count) as usize];
        let first = points[0].t;
        let t = if whole.closed { t - (t - first).floor() } else { t };
        let at = points.partition_point(|p| p.t <= t).max(1) - 1;
        let at = if points[at].next == NONE { at - 1 } else { at };
        let segment = whole.begin + at as u32;
        let end = points.get(at + 1).map_or(first + 1.0, |p| p.t);
        let part = ((t - points[at].t) / (end - points[at].t)).clamp(0.0, 1.0);
        Near { segment, part, distance: 0.0 }
    }

    /// The place on the source at `near`.
    pub fn source(&self, near: Near) -> SurfacePoint {
        let legs = &self.points[near.segment as usize].legs;
        let leg = legs.iter().find(|l| near.part <= l.part[1]).or(legs.last());
        let Some(leg) = leg else { return SurfacePoint::default() };
        let [from, to] = leg.part;
        let f = if to > from { ((near.part - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        SurfacePoint { face: leg.face, st: leg.from.lerp(leg.to, f) }
    }

    /// How far the curve stands off a segment in its middle, about: of a bend `k` and a chord `c` it is
    /// `k c^2 / 8`, and the bend is what the track turns by over the segments to both sides of a point.
    pub fn stand_off(&self, segment: u32) -> f64 {
        let point = &self.points[segment as usize];
        let (a, b) = self.ends(segment);
        let length = a.distance(b);
        let bend = |first: u32, second: u32, joint: u32| {
            if first == NONE || !self.is_segment(second) || self.points[joint as usize].corner {
                return 0.0;
            }
            let [u, v] = [first, second].map(|s| {
                let (a, b) = self.ends(s);
                b - a
            });
            let both = u.length() + v.length();
            if both > 0.0 { 2.0 * u.angle_between(v) / both } else { 0.0 }
        };
        let before = bend(point.previous, segment, segment);
        let after = bend(segment, point.next, point.next);
        let most = before.max(after);
        if most.is_finite() { most * length * length / 8.0 } else { 0.0 }
    }

    fn to_segment(&self, segment: u32, x: DVec3) -> Near {
        let (a, b) = self.ends(segment);
        let along = b - a;
        let squared = along.length_squared();
        let part = if squared > 0.0 { ((x - a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
        Near { segment, part, distance: x.distance(a.lerp(b, part)) }
    }

    /// The nearest place to `x` that is reached by walking downhill from `segment`.
    pub fn nearest(&self, segment: u32, x: DVec3) -> Near {
        let mut best = self.to_segment(segment, x);
        for forward in [true, false] {
            let mut at = best.segment;
            loop {
                let p = &self.points[at as usize];
                at = if forward { p.next } else { p.previous };
                if at == NONE || !self.is_segment(at) {
                    break;
                }
                let found = self.to_segment(at, x);
                if found.distance >= best.distance {
                    break;
                }
                best = found;
            }
        }
        best
    }

    /// The direction of travel at `near`, of unit length: at a point between two segments, of their
    /// sum, which tells left from right there at any angle but a cusp's.
    pub fn direction(&self, near: Near) -> DVec3 {
        let unit = |s: u32| {
            let (a, b) = self.ends(s);
            (b - a).normalize_or_zero()
        };
        let own = unit(near.segment);
        let p = &self.points[near.segment as usize];
        let other = if near.part == 0.0 && p.previous != NONE {
            unit(p.previous)
        } else if near.part == 1.0 && self.is_segment(p.next) {
            unit(p.next)
        } else {
            DVec3::ZERO
        };
        (own + other).normalize_or_zero()
    }

    /// The faces of `level` that `wanted` segments cross, in order along the track. Of a fine level that
    /// are many: half a dozen and more for each step of the level.
    pub fn visits(&self, level: u32, wanted: impl Fn(u32) -> bool) -> Vec<Visit> {
        let mut visits: Vec<Visit> = Vec::new();
        for (segment, p) in (0..).zip(&self.points).filter(|(segment, _)| wanted(*segment)) {
            for leg in &p.legs {
                for (code, part) in path::crossed(leg, level) {
                    let part = part.map(|f| leg.part[0] + (leg.part[1] - leg.part[0]) * f);
                    visits.push(Visit { code, segment, part });
                }
            }
        }
        visits
    }

    /// By segment, whether it has a visit that is `wanted`.
    pub fn having(&self, visits: &[Visit], wanted: impl Fn(&Visit) -> bool) -> Vec<bool> {
        let mut having = vec![false; self.points.len()];
        visits.iter().filter(|visit| wanted(visit)).for_each(|visit| having[visit.segment as usize] = true);
        having
    }
}

/// A part of one segment inside one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// The face.
    pub code: FaceCode,
    /// The segment.
    pub segment: u32,
    /// The part of the segment, in [0, 1].
    pub part: [f64; 2],
}

/// The faces around every vertex of a triangle list, in compressed rows.
#[derive(Clone, Debug)]
pub struct Around {
    starts: Vec<u32>,
    faces: Vec<u32>,
}

impl Around {
    /// The faces of `triangles` around each of `count` vertices, ascending.
    pub fn new(count: usize, triangles: &[[u32; 3]]) -> Self {
        let mut starts = vec![0_u32; count + 1];
        triangles.iter().flatten().for_each(|&v| starts[v as usize + 1] += 1);
        (0..count).for_each(|v| starts[v + 1] += starts[v]);
        let mut fill = starts.clone();
        let mut faces = vec![0; 3 * triangles.len()];
        for (f, corners) in triangles.iter().enumerate() {
            for &v in corners {
                faces[fill[v as usize] as usize] = f as u32;
                fill[v as usize] += 1;
            }
        }
        Self { starts, faces }
    }

    /// The faces around `v`.
    pub fn of(&self, v: u32) -> &[u32] {
        &self.faces[self.starts[v as usize] as usize..self.starts[v as usize + 1] as usize]
    }
}

/// The size of a triangle: the edge of the equilateral one of the same area.
pub fn size(corners: [DVec3; 3]) -> f64 {
    let double = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length();
    // sqrt(4 A / sqrt(3))
    (double * 2.0 / 3.0_f64.sqrt()).sqrt()
}

/// How far nearness spreads, in sizes of the triangle it spreads through: beyond what any stage asks
/// for (the greatest is a `near` of some sizes).
const SPREAD: f64 = 4.0;

/// The nearest place of `track` for the vertices near it. `seeds` are triangles that segments cross;
/// only places on segments that count are nearest ones. It spreads `reach` far at least, by segment.
pub fn spread(
    track: &Track,
    triangles: &[[u32; 3]],
    positions: &[DVec3],
    seeds: impl IntoIterator<Item = (u32, u32)>,
    counts: impl Fn(u32) -> bool,
    reach: impl Fn(u32) -> f64,
) -> Vec<Option<Near>> {
    let around = Around::new(positions.len(), triangles);
    let mut near: Vec<Option<Near>> = vec![None; positions.len()];
    let mut queue = VecDeque::new();
    // What each vertex was offered last: neighbours have the same to offer, and so have all faces of one.
    let mut offered = vec![NONE; positions.len()];
    let mut offer = |near: &mut Vec<Option<Near>>, queue: &mut VecDeque<u32>, v: u32, segment: u32| {
        let is_known = offered[v as usize] == segment || near[v as usize].is_some_and(|own| own.segment == segment);
        if is_known || !positions[v as usize].is_finite() {
            return;
        }
        offered[v as usize] = segment;
        let found = track.nearest(segment, positions[v as usize]);
        if counts(found.segment) && near[v as usize].is_none_or(|old| found.distance < old.distance) {
            near[v as usize] = Some(found);
            queue.push_back(v);
        }
    };
    for (face, segment) in seeds {
        triangles[face as usize].iter().for_each(|&v| offer(&mut near, &mut queue, v, segment));
    }
    while let Some(v) = queue.pop_front() {
        let Some(own) = near[v as usize] else { continue };
        for &face in around.of(v) {
            let corners = triangles[face as usize];
            let far = SPREAD * size(corners.map(|c| positions[c as usize]));
            if own.distance > far.max(reach(own.segment)) {
                continue;
            }
            for c in corners.into_iter().filter(|&c| c != v) {
                offer(&mut near, &mut queue, c, own.segment);
            }
        }
    }
    near
}
