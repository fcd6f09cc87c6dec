//! On the left of how many curves a place lies.
//!
//! The number rises by one where a curve is crossed from its right to its left. If it is the same
//! whichever way one goes, the curves separate what is left from what is right, and what stays of a
//! set of curves is where the number is highest: on the left of all curves, but for curves that lie
//! within what others take away. On a surface of several parts the highest number of each part
//! counts.
//!
//! Of several sets of curves the common part of what each leaves stays: where the number of all
//! curves together is the sum of the highest numbers of the sets. It is nowhere greater.
//!
//! The number of a place is known from that of a fixed place in its face, by the ways over the face
//! that a straight line to it crosses; and those fixed places from each other, across an edge.

use std::collections::VecDeque;

use glam::DVec2;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId};
use selvedge_components::subdivision::NONE;
use smallvec::SmallVec;

use super::path::{self, Leg};
use super::track::Track;

/// A leg of a track.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// The leg.
    pub leg: Leg,
    /// The segment that it belongs to.
    pub segment: u32,
}

/// The legs of all tracks, face by face, in compressed rows.
#[derive(Debug)]
pub struct Ways {
    starts: Vec<u32>,
    ways: Vec<Way>,
}

impl Ways {
    /// The legs of `track` in each of `faces` faces, by segment. Those without length are left out.
    pub fn new(track: &Track, faces: usize) -> Self {
        Self::of_curves(track, faces, |_| true)
    }

    /// The legs of those curves of `track` that are `wanted`.
    pub fn of_curves(track: &Track, faces: usize, wanted: impl Fn(u32) -> bool) -> Self {
        let mut ways = Vec::new();
        for (segment, point) in track.points.iter().enumerate().filter(|(_, point)| wanted(point.curve)) {
            let legs = point.legs.iter().filter(|l| l.from != l.to);
            ways.extend(legs.map(|&leg| Way { leg, segment: segment as u32 }));
        }
        ways.sort_by_key(|w| (w.leg.face, w.segment));
        let mut starts = vec![0_u32; faces + 1];
        ways.iter().for_each(|w| starts[w.leg.face.index() + 1] += 1);
        (0..faces).for_each(|f| starts[f + 1] += starts[f]);
        Self { starts, ways }
    }

    /// Those in `face`.
    pub fn of(&self, face: FaceId) -> &[Way] {
        &self.ways[self.starts[face.index()] as usize..self.starts[face.index() + 1] as usize]
    }

    /// The faces that have any, ascending.
    pub fn faces(&self) -> impl Iterator<Item = FaceId> + '_ {
        (0..self.starts.len() - 1).filter(|&f| self.starts[f] < self.starts[f + 1]).map(FaceId::new)
    }
}

/// Does `x` lie on the left of the line from `p` to `q`, or on it? Exactly.
pub fn is_left(p: DVec2, q: DVec2, x: DVec2) -> bool {
    let coordinates = [p, q, x].map(|v| robust::Coord { x: v.x, y: v.y });
    let [p, q, x] = coordinates;
    robust::orient2d(p, q, x) >= 0.0
}

/// By how much the number rises from `x` to `y` in one face.
fn rise<'a>(ways: impl IntoIterator<Item = &'a Way>, x: DVec2, y: DVec2) -> i32 {
    let crossed = ways.into_iter().filter_map(|way| {
        let (p, q) = (way.leg.from, way.leg.to);
        // Each way has its beginning and not its end, so that one through a joint counts once.
        let to_left = is_left(p, q, y);
        (is_left(x, y, p) != is_left(x, y, q) && is_left(p, q, x) != to_left).then_some(if to_left { 1 } else { -1 })
    });
    crossed.sum()
}

/// Pairs of faces at the rim of a mesh that is a part of a larger one, which hang together beyond the part,
/// where no curve runs. No curve runs through them either.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Beyond(pub Vec<[FaceId; 2]>);

impl Beyond {
    /// Both ways, ascending.
    fn ways(&self) -> Vec<[FaceId; 2]> {
        let mut ways: Vec<_> = self.0.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
        ways.sort_unstable();
        ways
    }
}

/// The fixed place of every face. It lies on no line that halving makes.
const FIXED: DVec2 = DVec2::new(0.347, 0.279);

/// How far beyond an edge, as a part of the face, a line towards it is drawn, so that it crosses what
/// runs along the edge: above what rounding puts outside, below what the ways keep aside.
const BEYOND: f64 = 1.0 / (1_u64 << 44) as f64;

/// The number of every place.
#[derive(Debug)]
pub struct Winding {
    ways: Ways,
    /// By face, the number of its fixed place.
    numbers: Vec<i32>,
    /// By face, the part of the surface that it belongs to.
    parts: Vec<u32>,
    /// By part, the highest number.
    highest: Vec<i32>,
}

impl Winding {
    /// The numbers of `mesh`, of which faces may hang together `beyond` it.
    ///
    /// # Errors
    /// A face where two ways lead to different numbers: the curves do not separate the surface.
    pub fn new(mesh: &Connectivity, ways: Ways, beyond: &Beyond) -> Result<Self, FaceId> {
        let count = mesh.face_count();
        let beyond = beyond.ways();
        let mut winding = Self { ways, numbers: vec![0; count], parts: vec![NONE; count], highest: Vec::new() };
        let mut queue = VecDeque::new();
        for seed in (0..count).map(FaceId::new) {
            if winding.parts[seed.index()] != NONE {
                continue;
            }
            let part = winding.highest.len() as u32;
            winding.highest.push(i32::MIN);
            winding.parts[seed.index()] = part;
            queue.push_back(seed);
            while let Some(face) = queue.pop_front() {
                let highest = &mut winding.highest[part as usize];
                *highest = (*highest).max(winding.numbers[face.index()]);
                let number = winding.numbers[face.index()];
                let across = (0..3).map(|i| HalfedgeId::of(face, i)).filter_map(|h| {
                    let twin = mesh.twin(h)?;
                    Some((twin.face(), number + winding.across(h, twin)))
                });
                let first = beyond.partition_point(|way| way[0] < face);
                let around = beyond[first..].iter().take_while(|way| way[0] == face).map(|way| (way[1], number));
                for (next, number) in across.chain(around).collect::<SmallVec<[_; 8]>>() {
                    if winding.parts[next.index()] == NONE {
                        winding.parts[next.index()] = part;
                        winding.numbers[next.index()] = number;
                        queue.push_back(next);
                    } else if winding.numbers[next.index()] != number {
                        return Err(next);
                    }
                }
            }
        }
        Ok(winding)
    }

    /// By how much the number rises from the fixed place of one face to that of the next.
    fn across(&self, h: HalfedgeId, twin: HalfedgeId) -> i32 {
        let (here, there) = (self.ways.of(h.face()), self.ways.of(twin.face()));
        if here.is_empty() && there.is_empty() {
            return 0;
        }
        // Through the middle of the widest gap between what crosses the edge.
        let mut places = vec![0.0, 1.0];
        for (h, ways, flip) in [(h, here, false), (twin, there, true)] {
            let i = h.corner();
            for end in ways.iter().flat_map(|w| [w.leg.from, w.leg.to]) {
                let weights = path::weights(end);
                if weights[(i + 2) % 3].abs() < 1e-6 {
                    let w = weights[(i + 1) % 3].clamp(0.0, 1.0);
                    places.push(if flip { 1.0 - w } else { w });
                }
            }
        }
        places.sort_unstable_by(f64::total_cmp);
        let widest = places.windows(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
        let w = widest.map_or(0.5, |gap| 0.5 * (gap[0] + gap[1]));
        let beyond = |i: usize, w: f64| {
            let on = path::corner(i) * (1.0 - w) + path::corner((i + 1) % 3) * w;
            on + (on - FIXED) * BEYOND
        };
        rise(here, FIXED, beyond(h.corner(), w)) - rise(there, FIXED, beyond(twin.corner(), 1.0 - w))
    }

    /// The number of a place that lies on no way.
    pub fn at(&self, at: SurfacePoint) -> i32 {
        self.numbers[at.face.index()] - rise(self.ways.of(at.face), at.st, FIXED)
    }

    /// The number on the left of a way, `f` of the way along it.
    pub fn left_of(&self, way: &Way, f: f64) -> i32 {
        let face = way.leg.face;
        let x = way.leg.from.lerp(way.leg.to, f);
        let is_way = |w: &&Way| (w.segment, w.leg.part) != (way.segment, way.leg.part);
        let beside = self.numbers[face.index()] - rise(self.ways.of(face).iter().filter(is_way), x, FIXED);
        // Reached from the side of the fixed place.
        beside + i32::from(!is_left(way.leg.from, way.leg.to, FIXED))
    }

    /// Takes note of a place of `face` with this number: the left of every way is to be told before
    /// [`Winding::is_highest`] is asked.
    pub fn note(&mut self, face: FaceId, number: i32) {
        let highest = &mut self.highest[self.parts[face.index()] as usize];
        *highest = (*highest).max(number);
    }

    /// Is `number` the highest in the part of the surface of `face`?
    pub fn is_highest(&self, face: FaceId, number: i32) -> bool {
        number == self.highest[self.parts[face.index()] as usize]
    }

    /// The highest number of each part of the surface.
    pub fn highest(&self) -> &[i32] {
        &self.highest
    }

    /// The lowest number of the fixed places of each part of the surface.
    pub fn lowest(&self) -> Vec<i32> {
        let mut lowest = vec![i32::MAX; self.highest.len()];
        for (&part, &number) in self.parts.iter().zip(&self.numbers) {
            lowest[part as usize] = lowest[part as usize].min(number);
        }
        lowest
    }

    /// The part of the surface that a face belongs to.
    pub fn part(&self, face: FaceId) -> u32 {
        self.parts[face.index()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use selvedge_components::subdivision::NONE;

    use super::super::track::TrackPoint;

    /// Two triangles make the unit square.
    fn square() -> Connectivity {
        Connectivity::new(4, &[[0, 1, 2], [2, 1, 3]]).expect("a square")
    }

    fn at(p: DVec2) -> SurfacePoint {
        // Face 1 is (2, 1, 3): (s, t) weigh (1, 0) and (1, 1).
        if p.x + p.y <= 1.0 {
            SurfacePoint::new(FaceId(0), p.x, p.y)
        } else {
            SurfacePoint::new(FaceId(1), 1.0 - p.y, p.x + p.y - 1.0)
        }
    }

    fn tracks(mesh: &Connectivity, loops: &[Vec<DVec2>]) -> Track {
        let mut track = Track::default();
        for points in loops {
            let n = points.len();
            let point = |i: usize| TrackPoint {
                position: points[i].extend(0.0),
                t: i as f64 / n as f64,
                corner: false,
                along: 0.0,
                cut: 0,
                curve: 0,
                u: 0.0,
                next: NONE,
                previous: NONE,
                legs: path::connect(mesh, at(points[i]), at(points[(i + 1) % n]), 0.0).expect("a way").0,
            };
            track.append((0..n).map(point).collect(), true);
        }
        track
    }

    fn ring(centre: DVec2, radius: f64, n: usize) -> Vec<DVec2> {
        (0..n).map(|k| centre + radius * DVec2::from_angle(-core::f64::consts::TAU * k as f64 / n as f64)).collect()
    }

    #[test]
    fn the_number_is_that_of_the_discs_that_hold_the_place() {
        let mesh = square();
        let discs = [(DVec2::new(0.4, 0.45), 0.3), (DVec2::new(0.6, 0.5), 0.25), (DVec2::new(0.45, 0.45), 0.1)];
        let loops: Vec<Vec<DVec2>> = discs.iter().map(|&(c, r)| ring(c, r, 64)).collect();
        let track = tracks(&mesh, &loops);
        let ways = Ways::new(&track, 2);
        let mut winding = Winding::new(&mesh, ways, &Beyond::default()).expect("they separate");
        let outside = winding.at(at(DVec2::new(0.01, 0.02)));
        winding.note(FaceId(1), outside);
        for k in 0..2000 {
            let p = DVec2::new(f64::from(k) * 0.618_034 % 1.0, f64::from(k) * 0.414_214 % 1.0);
            let near = discs.iter().any(|&(c, r)| ((p - c).length() - r).abs() < 1e-3);
            let inside = discs.iter().filter(|&&(c, r)| (p - c).length() < r).count() as i32;
            assert!(near || winding.at(at(p)) == outside - inside, "{p}");
            assert!(near || winding.is_highest(FaceId(0), winding.at(at(p))) == (inside == 0));
        }
    }
}
