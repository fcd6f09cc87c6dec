//! # Remove: what lies on the right of the curves goes
//!
//! A triangle goes if a curve crosses it, if one of its corners is too near to a curve to leave room
//! for the strip, or if it lies on the right of a curve, which a flood fill tells. What is left has
//! one simple loop of edges along each curve; where it has not, the cage is too coarse there.

use glam::DVec3;
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::NONE;

use super::error::RemeshError;
use super::track::{Near, Track, size, spread};

/// What becomes of a triangle of the adapted cage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It stays.
    Kept,
    /// It lies on the right of a curve and goes.
    Removed,
    /// A curve crosses it or passes near it: the strip takes the place of its left part.
    Cut,
}

/// What is left, and its edge along each curve.
#[derive(Clone, Debug, Default)]
pub struct Remains {
    /// By triangle.
    pub fates: Vec<Fate>,
    /// One for each curve, in the order of the curves.
    pub loops: Vec<Rim>,
    /// The nearest place of the curves, for the vertices near them.
    pub near: Vec<Option<Near>>,
}

/// The edge of what is left along one curve, in the curve's direction: round, or from border to
/// border.
#[derive(Clone, Debug, Default)]
pub struct Rim {
    /// Its vertices; the first is not repeated.
    pub vertices: Vec<u32>,
    /// Does it run round?
    pub closed: bool,
    /// How far along the curve the nearest place to each is, unwrapped: it grows by the curve's
    /// length in going round, but need not be monotone.
    pub along: Vec<f64>,
}

/// Either an error that no finer cage mends, or a place where a finer cage may help.
#[derive(Debug)]
pub enum Trouble {
    /// Final.
    Error(RemeshError),
    /// What is wrong, and the places of the curves that need a finer cage.
    TooCoarse {
        /// What is wrong.
        what: &'static str,
        /// Never empty.
        places: Vec<Place>,
    },
}

/// A place of a curve, and the cage there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The place.
    pub near: Near,
    /// The finest level of the triangles there.
    pub level: u32,
    /// The greatest of their sizes, in model units.
    pub size: f64,
}

/// The adapted cage, ready to be cut.
#[derive(Debug)]
pub struct Cage<'a> {
    /// Its triangles.
    pub mesh: &'a Connectivity,
    /// The corners of the triangles.
    pub triangles: &'a [[u32; 3]],
    /// The levels of the triangles.
    pub levels: &'a [u32],
    /// The limit points of its vertices.
    pub limit: &'a [DVec3],
    /// The curves.
    pub track: &'a Track,
    /// The part of its size that a triangle's corner must be away from a curve.
    pub margin: f64,
    /// By segment of the curves, how long the strip's triangles are there at least: the margin is as much a
    /// part of that.
    pub lengths: &'a [f64],
}

impl Cage<'_> {
    /// Cuts the cage. `crossed` lists triangles with a segment that crosses them; `stays` tells of
    /// one that no segment crosses whether it lies on the left of all curves.
    pub fn cut(&self, crossed: &[(u32, u32)], stays: &dyn Fn(usize) -> bool) -> Result<Remains, Trouble> {
        let room = |segment: u32| self.margin * self.lengths[segment as usize];
        let near = spread(self.track, self.triangles, self.limit, crossed.iter().copied(), |_| true, |s| 2.0 * room(s));
        let mut fates = vec![Fate::Kept; self.triangles.len()];
        crossed.iter().for_each(|&(f, _)| fates[f as usize] = Fate::Cut);
        for (fate, corners) in fates.iter_mut().zip(self.triangles) {
            let own = self.margin * size(corners.map(|v| self.limit[v as usize]));
            // The curve itself lies a little aside of its track.
            let too_near = |n: Near| n.distance < own.max(room(n.segment)) + self.track.stand_off(n.segment);
            if corners.iter().any(|&v| near[v as usize].is_some_and(too_near)) {
                *fate = Fate::Cut;
            }
        }
        self.make_room_at_corners(&near, &mut fates);
        let mut remains = Remains { fates, loops: Vec::new(), near };
        self.flood(&mut remains, stays);
        self.trim(&mut remains)?;
        remains.loops = self.rims(&mut remains)?;
        Ok(remains)
    }

    /// A corner of a curve may come near to the inside of an edge, whose ends are far enough.
    fn make_room_at_corners(&self, near: &[Option<Near>], fates: &mut [Fate]) {
        let corners: Vec<u32> =
            (0..self.track.points.len() as u32).filter(|&p| self.track.points[p as usize].corner).collect();
        if corners.is_empty() {
            return;
        }
        for (fate, triangle) in fates.iter_mut().zip(self.triangles).filter(|(fate, _)| **fate == Fate::Kept) {
            let at = triangle.map(|v| self.limit[v as usize]);
            let h = size(at);
            let Some(own) = triangle.iter().find_map(|&v| near[v as usize].filter(|n| n.distance < 2.0 * h)) else {
                continue;
            };
            let too_near = |&p: &u32| {
                let place = Near { segment: p, part: 0.0, distance: 0.0 };
                let point = &self.track.points[p as usize];
                // Other curves and other stretches may lie on the far side of a thin part.
                point.cut == self.track.points[own.segment as usize].cut
                    && self.track.distance_along(own, place) < APART * h
                    && (0..3).any(|i| from_segment(point.position, at[i], at[(i + 1) % 3]) < self.margin * h)
            };
            if corners.iter().any(too_near) {
                *fate = Fate::Cut;
            }
        }
    }

    /// The unit normal of the limit triangles around a vertex.
    pub fn normal(&self, v: u32) -> DVec3 {
        let faces = self.mesh.ring(VertexId(v)).map(|h| h.face());
        let sum = faces.map(|f| {
            let [a, b, c] = self.triangles[f.index()].map(|v| self.limit[v as usize]);
            (b - a).cross(c - a)
        });
        sum.fold(DVec3::ZERO, |sum, n| sum + n).normalize_or_zero()
    }

    /// Decides part by part what stays: parts are sets of triangles joined through edges.
    fn flood(&self, remains: &mut Remains, stays: &dyn Fn(usize) -> bool) {
        let mut seen = vec![false; self.triangles.len()];
        for seed in 0..self.triangles.len() {
            if seen[seed] || remains.fates[seed] == Fate::Cut {
                continue;
            }
            let fate = if stays(seed) { Fate::Kept } else { Fate::Removed };
            seen[seed] = true;
            let mut members = vec![seed];
            while let Some(f) = members.pop() {
                remains.fates[f] = fate;
                for t in (0..3).filter_map(|i| self.mesh.twin(HalfedgeId::of(FaceId::new(f), i))) {
                    let g = t.face().index();
                    if !seen[g] && remains.fates[g] != Fate::Cut {
                        seen[g] = true;
                        members.push(g);
                    }
                }
            }
        }
    }

    fn is_kept(&self, remains: &Remains, h: Option<HalfedgeId>) -> bool {
        h.is_some_and(|h| remains.fates[h.face().index()] == Fate::Kept)
    }

    /// Is `h` an edge of what is left that is no border of the source?
    fn is_rim(&self, remains: &Remains, h: HalfedgeId) -> bool {
        self.is_kept(remains, Some(h)) && self.mesh.twin(h).is_some() && !self.is_kept(remains, self.mesh.twin(h))
    }

    /// Drops triangles with two rim edges, and fans that hang on to the rest by a vertex.
    fn trim(&self, remains: &mut Remains) -> Result<(), Trouble> {
        let all = 0..self.triangles.len();
        let mut todo: Vec<usize> =
            all.clone().filter(|&f| remains.fates[f] == Fate::Kept && self.touches_cut(remains, f)).collect();
        loop {
            // Each round drops a triangle or ends.
            while let Some(f) = todo.pop() {
                let rims = |remains: &Remains| {
                    (0..3).filter(|&i| self.is_rim(remains, HalfedgeId::of(FaceId::new(f), i))).count()
                };
                if remains.fates[f] == Fate::Kept && rims(remains) >= 2 {
                    self.drop_triangle(remains, f, &mut todo);
                }
            }
            let pinched = self.pinches(remains);
            let mut places = Vec::new();
            for &v in &pinched {
                // Opening one may have opened others.
                if self.is_pinched(remains, v) {
                    places.extend(self.open_pinch(remains, v, &mut todo));
                }
            }
            if !places.is_empty() {
                return Err(Trouble::TooCoarse { what: "too coarse between boundaries", places });
            }
            if pinched.is_empty() {
                return Ok(());
            }
        }
    }

    /// The vertices at which two stretches of rim meet, or one runs along a border; ascending.
    fn pinches(&self, remains: &Remains) -> Vec<VertexId> {
        let mut on_rim = vec![false; self.limit.len()];
        for h in (0..3 * self.triangles.len()).map(HalfedgeId::new).filter(|&h| self.is_rim(remains, h)) {
            on_rim[self.mesh.from(h).index()] = true;
            on_rim[self.mesh.to(h).index()] = true;
        }
        let rim = (0..on_rim.len()).filter(|&v| on_rim[v]).map(VertexId::new);
        rim.filter(|&v| self.is_pinched(remains, v)).collect()
    }

    fn is_pinched(&self, remains: &Remains, v: VertexId) -> bool {
        let leaving = self.mesh.ring(v).filter(|&h| self.is_rim(remains, h)).count();
        let arriving = self.mesh.ring(v).filter(|&h| self.is_rim(remains, h.previous())).count();
        if !self.mesh.is_border(v) {
            return leaving > 1 || arriving > 1;
        }
        // A curve that crosses the border has one end of its rim there; it is seen from one fan.
        let crosses = remains.near[v.index()]
            .is_some_and(|n| !self.track.tracks[self.track.points[n.segment as usize].cut as usize].closed);
        leaving + arriving > usize::from(crosses) || self.kept_fans(remains, v).len() > 1 && leaving + arriving > 0
    }

    /// A place of a curve with the cage at `v`.
    pub fn place(&self, v: u32, near: Near) -> Place {
        let around = || self.mesh.ring(VertexId(v)).map(|h| h.face().index());
        let sizes = around().map(|f| size(self.triangles[f].map(|v| self.limit[v as usize])));
        let level = around().map(|f| self.levels[f]).max().unwrap_or(0);
        Place { near, level, size: sizes.fold(0.0, f64::max) }
    }

    fn touches_cut(&self, remains: &Remains, f: usize) -> bool {
        (0..3).any(|i| self.is_rim(remains, HalfedgeId::of(FaceId::new(f), i)))
    }

    fn drop_triangle(&self, remains: &mut Remains, f: usize, todo: &mut Vec<usize>) {
        remains.fates[f] = Fate::Cut;
        for v in self.triangles[f] {
            todo.extend(self.mesh.ring(VertexId(v)).map(|h| h.face().index()));
        }
    }

    /// The kept triangles around `v`, fan by fan.
    fn kept_fans(&self, remains: &Remains, v: VertexId) -> Vec<Vec<usize>> {
        let ring: Vec<HalfedgeId> = self.mesh.ring(v).collect();
        let kept: Vec<bool> = ring.iter().map(|&h| self.is_kept(remains, Some(h))).collect();
        let count = ring.len();
        let closed = !self.mesh.is_border(v);
        // Begin after a gap, so that no fan is seen in two pieces.
        let Some(gap) = (0..count).find(|&i| !kept[i]) else {
            return vec![ring.iter().map(|h| h.face().index()).collect()];
        };
        let begin = if closed { gap } else { 0 };
        let mut fans: Vec<Vec<usize>> = Vec::new();
        let mut open = false;
        for i in (begin..begin + count).map(|i| i % count) {
            if kept[i] {
                if !open {
                    fans.push(Vec::new());
                }
                if let Some(fan) = fans.last_mut() {
                    fan.push(ring[i].face().index());
                }
            }
            open = kept[i];
        }
        fans
    }

    /// Two stretches of rim meet at `v`: if they are the same stretch of one curve, the smaller fan
    /// goes; otherwise the places are returned where the cage must be finer.
    fn open_pinch(&self, remains: &mut Remains, v: VertexId, todo: &mut Vec<usize>) -> Vec<Place> {
        let fans = self.kept_fans(remains, v);
        let around = fans.iter().flatten().flat_map(|&f| self.triangles[f]);
        let nears: Vec<(u32, Near)> = around.filter_map(|w| Some((w, remains.near[w as usize]?))).collect();
        let places = || nears.iter().map(|&(w, n)| self.place(w, n)).collect();
        if self.mesh.is_border(v) {
            return places();
        }
        let cut = |n: &Near| self.track.points[n.segment as usize].cut;
        if nears.iter().any(|(_, n)| cut(n) != cut(&nears[0].1)) {
            return places();
        }
        let h =
            fans.iter().flatten().map(|&f| size(self.triangles[f].map(|v| self.limit[v as usize]))).fold(0.0, f64::max);
        let pairs = nears.iter().flat_map(|a| nears.iter().map(|b| self.track.distance_along(a.1, b.1)));
        if pairs.fold(0.0, f64::max) > APART * h {
            return places();
        }
        if let Some(smaller) = fans.iter().min_by_key(|fan| fan.len()) {
            smaller.iter().for_each(|&f| self.drop_triangle(remains, f, todo));
        }
        Vec::new()
    }

    /// The rim along each curve.
    fn rims(&self, remains: &mut Remains) -> Result<Vec<Rim>, Trouble> {
        let mut rims: Vec<Option<Rim>> = vec![None; self.track.tracks.len()];
        let mut seen = vec![false; 3 * self.triangles.len()];
        let all_edges = || (0..3 * self.triangles.len()).map(HalfedgeId::new);
        // Those that begin at a border first: the others run round.
        let crossing = all_edges().filter(|&h| self.mesh.is_border(self.mesh.from(h)));
        let starts: Vec<HalfedgeId> = crossing.chain(all_edges()).filter(|&h| self.is_rim(remains, h)).collect();
        for h in starts {
            if seen[h.index()] || !self.is_rim(remains, h) {
                continue;
            }
            let walk = self.walk(remains, h, &mut seen);
            let closed = !self.mesh.is_border(walk[0]);
            let nears: Vec<Near> = walk.iter().filter_map(|v| remains.near[v.index()]).collect();
            let Some(&first) = nears.first() else {
                let curve = self.track.points.last().map_or(0, |p| p.curve as usize);
                return Err(Trouble::Error(RemeshError::NothingLeft { curve }));
            };
            let cut = self.track.points[first.segment as usize].cut;
            let of = |n: &Near| self.track.points[n.segment as usize].cut;
            let all = || walk.iter().zip(&nears).map(|(v, &n)| self.place(v.0, n)).collect();
            if nears.len() < walk.len() || nears.iter().any(|n| of(n) != cut) {
                // Where the walk changes from one curve to another.
                let count = nears.len();
                let changes = (0..count).filter(|&i| of(&nears[i]) != of(&nears[(i + 1) % count]));
                let places: Vec<Place> =
                    changes.flat_map(|i| [i, (i + 1) % count]).map(|i| self.place(walk[i].0, nears[i])).collect();
                let places = if places.is_empty() { all() } else { places };
                return Err(Trouble::TooCoarse { what: "too coarse between two curves", places });
            }
            let whole = self.track.tracks[cut as usize];
            let along = if whole.closed {
                self.unwrap(&nears, whole.length)
            } else {
                nears.iter().map(|&n| self.track.along(n)).collect()
            };
            let sound = match (closed, whole.closed) {
                (true, true) => ((along[walk.len()] - along[0]) / whole.length).round() == 1.0,
                (false, false) => {
                    let near_end =
                        |i: usize, end: f64| (along[i] - end).abs() < APART * self.place(walk[i].0, nears[i]).size;
                    near_end(0, 0.0) && near_end(walk.len() - 1, whole.length)
                }
                _ => false,
            };
            let rim = Rim { vertices: walk.iter().map(|v| v.0).collect(), closed, along: along[..walk.len()].to_vec() };
            let is_pocket =
                !sound && closed && (!whole.closed || ((along[walk.len()] - along[0]) / whole.length).round() == 0.0);
            if sound && rims[cut as usize].is_none() {
                rims[cut as usize] = Some(rim);
            } else if is_pocket && self.drop_pocket(remains, h) {
                // What hung on by nothing is gone.
            } else {
                return Err(Trouble::TooCoarse { what: "without a single rim", places: all() });
            }
        }
        if let Some(c) = rims.iter().position(Option::is_none) {
            let whole = self.track.tracks[c];
            let segments =
                (whole.begin..whole.begin + whole.count).filter(|&s| self.track.points[s as usize].next != NONE);
            let level = self.levels.iter().copied().max().unwrap_or(0);
            let places =
                segments.map(|segment| Place { near: Near { segment, part: 0.0, distance: 0.0 }, level, size: 0.0 });
            return Err(Trouble::TooCoarse { what: "without a rim", places: places.collect() });
        }
        Ok(rims.into_iter().flatten().collect())
    }

    /// The rim from `start` on, with the rest on the left; up to a border, its vertex included, or
    /// round.
    fn walk(&self, remains: &Remains, start: HalfedgeId, seen: &mut [bool]) -> Vec<VertexId> {
        let mut walk = Vec::new();
        let mut h = start;
        loop {
            seen[h.index()] = true;
            walk.push(self.mesh.from(h));
            let end = self.mesh.to(h);
            let mut n = h.next();
            // Each vertex of a rim has one fan, so this ends at a rim edge or at a border.
            while let Some(t) = self.mesh.twin(n).filter(|_| !self.is_rim(remains, n)) {
                n = t.next();
            }
            if !self.is_rim(remains, n) {
                walk.push(end);
                return walk;
            }
            h = n;
            if seen[h.index()] {
                return walk;
            }
        }
    }

    /// Distances along the curve without jumps where it closes, one more than there are places: the
    /// last is the first again, having gone round.
    fn unwrap(&self, nears: &[Near], length: f64) -> Vec<f64> {
        let mut out: Vec<f64> = Vec::with_capacity(nears.len() + 1);
        for near in nears.iter().chain(nears.first()) {
            let along = self.track.along(*near);
            let last = out.last().copied().unwrap_or(along);
            out.push(along - ((along - last) / length).round() * length);
        }
        out
    }

    /// Removes the part of what is left that holds `h` if all of it is near the curve: a few
    /// triangles between the curve's bends. `false` if it is more than that.
    fn drop_pocket(&self, remains: &mut Remains, h: HalfedgeId) -> bool {
        let mut members = vec![h.face().index()];
        let mut inside = std::collections::HashSet::from([h.face().index()]);
        let mut next = 0;
        while let Some(&f) = members.get(next) {
            next += 1;
            let corners = self.triangles[f];
            let h = size(corners.map(|v| self.limit[v as usize]));
            if !corners.iter().all(|&v| remains.near[v as usize].is_some_and(|n| n.distance < POCKET * h)) {
                return false;
            }
            for t in (0..3).filter_map(|i| self.mesh.twin(HalfedgeId::of(FaceId::new(f), i))) {
                if remains.fates[t.face().index()] == Fate::Kept && inside.insert(t.face().index()) {
                    members.push(t.face().index());
                }
            }
        }
        members.into_iter().for_each(|f| remains.fates[f] = Fate::Cut);
        true
    }
}

/// The distance of `x` from the segment `a b`.
fn from_segment(x: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let squared = along.length_squared();
    let part = if squared > 0.0 { ((x - a).dot(along) / squared).clamp(0.0, 1.0) } else { 0.0 };
    x.distance(a.lerp(b, part))
}

/// Two places of a rim that are farther apart along the curve than this many sizes of a triangle are
/// different stretches of it: the triangles around one vertex span two or three.
const APART: f64 = 6.0;

/// A pocket reaches no farther from the curve than this many sizes: the band between is one wide.
const POCKET: f64 = 2.0;
