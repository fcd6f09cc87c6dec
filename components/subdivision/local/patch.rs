//! A face with everything that shapes the limit surface over it.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::ring::{BorderRule, Place, Ring};
use super::tangents::FINEST_SAMPLE;
use super::{Descent, Scheme};
use crate::evaluate::Jet;
use crate::subdivision::boxspline::{Net, Quartic};
use crate::subdivision::level::{LevelMesh, NONE};
use crate::subdivision::stencil::LevelState;

/// A face and the rings of its corners, at some level: enough to evaluate the limit surface anywhere
/// on it when no finer details are to come.
#[derive(Clone, Debug)]
pub struct Patch<'a> {
    pub(super) scheme: Scheme<'a>,
    pub(super) rings: [Ring; 3],
    /// The index, in each corner's ring, of the face's next corner; the one after follows it.
    pub(super) at: [usize; 3],
}

/// The level at which a face at a given border takes the border's own tangents.
///
/// What is left is `2^-16` of a root face wide. The jets at its corners are blended there: the
/// position is then off by the third derivatives over `2^48`, and the first derivatives by the third
/// over `2^35`. The differences that make the tangents have lost 16 bits, 7e-12 of the size of the
/// coordinates; more steps would gain less than they lose.
const NEAR_BORDER: u32 = 16;

/// A face that details have made is quartered this often at least, however fine it is.
const LEAST_NEAR_BORDER: u32 = 8;

/// How often a face is quartered towards an irregular vertex. The neighbourhood shrinks by 5/8 at
/// least: what is left is `(5/8)^84 < 2^-56` of it.
const NEAR_VERTEX: u32 = 84;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ask {
    Position,
    Jet,
}

impl<'a> Patch<'a> {
    /// The patch of `face` of `mesh`; the rings of its corners must be whole.
    pub fn of(scheme: Scheme<'a>, mesh: &LevelMesh, state: &LevelState, face: u32) -> Self {
        let corners = mesh.corners[face as usize];
        let at = [0, 1, 2].map(|c| mesh.ring(corners[c]).position(|h| h == 3 * face + c as u32).unwrap_or(0));
        Self { scheme, rings: corners.map(|v| Ring::of(scheme, mesh, state, v)), at }
    }

    /// Position and derivatives where the corners weigh `weights`, which are not negative and sum to
    /// 1. The derivatives are by the second and third weight, in model units per face of the patch.
    pub fn jet(self, weights: [f64; 3]) -> Jet {
        self.evaluate(weights, Ask::Jet)
    }

    /// The position alone; the same bits as [`Patch::jet`] gives.
    pub fn position(self, weights: [f64; 3]) -> DVec3 {
        self.evaluate(weights, Ask::Position).position
    }

    fn evaluate(mut self, weights: [f64; 3], ask: Ask) -> Jet {
        let mut place = Descent::from(weights);
        let mut origin = DVec3::ZERO;
        let edge = self.border_edge(weights);
        let on_border = match (edge, ask) {
            (None, _) => None,
            (Some(c), Ask::Jet) => self.on_curve(c, weights),
            (Some(c), Ask::Position) => match self.point_on_curve(c, weights) {
                Some(position) => return Jet { position, ..Jet::default() },
                None => None,
            },
        };
        let mut depth = 0;
        let mut jet = loop {
            let weights = place.weights;
            if let Some(net) = self.net() {
                let quartic = Quartic::new(&net);
                break match ask {
                    Ask::Position => Jet { position: quartic.position(weights[1], weights[2]), ..Jet::default() },
                    Ask::Jet => quartic.jet(weights[1], weights[2]),
                };
            }
            if let Some(corner) = weights.iter().position(|&w| w == 1.0) {
                break self.corner_jet(corner);
            }
            if depth >= self.deepest(depth) {
                break self.blend(weights);
            }
            if depth == 1 && !self.reads_curves() {
                // Relative to the vertex that the faces shrink to, differences keep their digits.
                if let Some(corner) = self.irregular() {
                    origin = self.rings[corner].limit(self.scheme);
                    self.rings.iter_mut().for_each(|r| r.shift(-origin));
                }
            }
            self = self.quarter(place.enter());
            depth += 1;
        };
        jet.position += origin;
        let jet = place.back(jet);
        match on_border {
            Some((position, edge, velocity)) => with_velocity(Jet { position, ..jet }, edge, velocity),
            None => jet,
        }
    }

    /// The position where no quartering is needed for it: on a given border, and at a corner.
    pub fn position_at_once(&self, weights: [f64; 3]) -> Option<DVec3> {
        let on_border = self.border_edge(weights).and_then(|c| self.point_on_curve(c, weights));
        let at_corner = || weights.iter().position(|&w| w == 1.0).map(|c| self.rings[c].limit(self.scheme));
        on_border.or_else(at_corner)
    }

    /// Hands out all four quarters in turn, each as [`Patch::quarter`] gives it.
    pub fn quarters(&self, mut put: impl FnMut(Self)) {
        let scheme = self.scheme;
        let vertices = [0, 1, 2].map(|c| self.rings[c].vertex_point());
        let middles = [0, 1, 2].map(|c| self.rings[c].spoke_point(scheme, self.at[c]));
        let halves = [0, 1, 2].map(|c| self.middle_ring(c, &vertices, &middles));
        for c in 0..3 {
            put(self.corner_quarter(c, &middles, [halves[c].clone(), halves[(c + 2) % 3].clone()]));
        }
        put(Self { scheme, rings: halves, at: [1; 3] });
    }

    /// One of the four quarters: 0 to 2 hold the corner of that number, 3 is the middle one.
    pub fn quarter(&self, child: usize) -> Self {
        let scheme = self.scheme;
        let vertices = [0, 1, 2].map(|c| self.rings[c].vertex_point());
        let middles = [0, 1, 2].map(|c| self.rings[c].spoke_point(scheme, self.at[c]));
        let middle = |c: usize| self.middle_ring(c, &vertices, &middles);
        if child > 2 {
            return Self { scheme, rings: [middle(0), middle(1), middle(2)], at: [1; 3] };
        }
        self.corner_quarter(child, &middles, [middle(child), middle((child + 2) % 3)])
    }

    /// The quarter at corner `c`, of which the edge to the next corner, and that from the corner after,
    /// have `halves` as their middles.
    fn corner_quarter(&self, c: usize, middles: &[DVec3; 3], halves: [Ring; 2]) -> Self {
        let (scheme, next, after) = (self.scheme, (c + 1) % 3, (c + 2) % 3);
        let i = self.at[c];
        let own = self.rings[c].finer_with(scheme, [(i, middles[c]), (self.rings[c].turn(i, 1), middles[after])]);
        let mut at = [0; 3];
        (at[c], at[next], at[after]) = (i, 2, 0);
        let [to_next, from_after] = halves;
        // Each moved once: a ring is large.
        let rings = match c {
            0 => [own, to_next, from_after],
            1 => [from_after, own, to_next],
            _ => [to_next, from_after, own],
        };
        Self { scheme, rings, at }
    }

    /// The ring of the vertex that halves the edge from corner `c` to the next: from the next corner,
    /// counter-clockwise.
    fn middle_ring(&self, c: usize, vertices: &[DVec3; 3], middles: &[DVec3; 3]) -> Ring {
        let (n, p) = ((c + 1) % 3, (c + 2) % 3);
        let (a, b) = (&self.rings[c], &self.rings[n]);
        let (i, j) = (self.at[c], b.turn(self.at[n], 1));
        let mut spokes: SmallVec<[DVec3; 8]> = smallvec![vertices[n], middles[n], middles[p], vertices[c]];
        let mut beside = SmallVec::new();
        let place = match (&a.place, &b.place) {
            (Place::Border(from), Place::Border(to)) if self.is_border_edge(c) => {
                Place::Border(from.middle(self.scheme, to, middles[c]))
            }
            _ => {
                spokes.push(a.spoke_point(self.scheme, a.turn(i, a.valence() - 1)));
                spokes.push(b.spoke_point(self.scheme, b.turn(j, 1)));
                beside.extend(
                    [(b, 0, j), (a, 3, i)]
                        .iter()
                        .filter(|(ring, ..)| ring.corner != NONE)
                        .map(|&(ring, spoke, back)| super::ring::Beside { spoke, corner: ring.corner, back }),
                );
                Place::Inside
            }
        };
        Ring { level: a.level + 1, centre: middles[c], spokes, place, corner: NONE, beside }
    }

    /// Does a border run along the edge from corner `c` to the next?
    pub(super) fn is_border_edge(&self, c: usize) -> bool {
        self.at[c] == 0 && self.rings[c].border().is_some()
    }

    /// The polynomial that is the whole face, where there is one.
    pub fn quartic(&self) -> Option<Quartic> {
        self.net().map(|net| Quartic::new(&net))
    }

    /// The control points, where the surface over the face is one polynomial.
    fn net(&self) -> Option<Net> {
        if !self.rings.iter().all(Ring::is_regular) {
            return None;
        }
        let (rings, at) = (&self.rings, &self.at);
        let mut net = [DVec3::ZERO; 12];
        for c in 0..3 {
            net[c] = rings[c].centre;
            let around = |by: usize| rings[c].around((at[c] + by) % 6);
            net[3 + c] = around(5);
            (net[6 + 2 * c], net[7 + 2 * c]) = (around(3), around(4));
        }
        Some(net)
    }

    /// The corner that is not regular, where there is exactly one.
    fn irregular(&self) -> Option<usize> {
        let mut irregular = (0..3).filter(|&c| !self.rings[c].is_regular());
        irregular.next().filter(|_| irregular.next().is_none())
    }

    /// Does quartering read a curve: is a given border near, or a corner that one has made special?
    fn reads_curves(&self) -> bool {
        self.rings.iter().any(|r| r.is_given() || !r.beside.is_empty())
    }

    /// How many quarterings are worth it, of which `depth` are done.
    fn deepest(&self, depth: u32) -> u32 {
        if !self.rings.iter().any(Ring::is_given) {
            return NEAR_VERTEX;
        }
        if self.rings.iter().any(|r| r.level >= FINEST_SAMPLE) {
            return 0;
        }
        let smooth = |r: &Ring| r.is_smooth() && r.beside.is_empty();
        if !self.rings.iter().all(smooth) {
            return NEAR_VERTEX;
        }
        let first = self.rings[0].level - depth;
        NEAR_BORDER.saturating_sub(first).max(LEAST_NEAR_BORDER)
    }

    /// The given border edge that the point with `weights` lies on.
    fn border_edge(&self, weights: [f64; 3]) -> Option<usize> {
        (0..3).find(|&c| weights[(c + 2) % 3] == 0.0 && self.is_border_edge(c))
    }

    /// On border edge `c`: the curve's own point; `None` on a plain border.
    fn point_on_curve(&self, c: usize, weights: [f64; 3]) -> Option<DVec3> {
        let (level, (side, step)) = (self.rings[c].level, self.rings[c].border()?.leaving);
        self.scheme.surface.sides[side as usize].point_on(level, step, weights[(c + 1) % 3])
    }

    /// On border edge `c`: the curve's own point, `c`, and the curve's velocity along it, per edge of
    /// the patch; `None` on a plain border.
    fn on_curve(&self, c: usize, weights: [f64; 3]) -> Option<(DVec3, usize, DVec3)> {
        let (level, (side, step)) = (self.rings[c].level, self.rings[c].border()?.leaving);
        let (side, share) = (&self.scheme.surface.sides[side as usize], weights[(c + 1) % 3]);
        Some((side.point_on(level, step, share)?, c, side.velocity_on(level, step, share)?))
    }

    /// Position and derivatives at a corner.
    fn corner_jet(&self, c: usize) -> Jet {
        let ring = &self.rings[c];
        let [next, after] = ring.tangents(self.scheme).of_face(self.at[c], ring.valence());
        let (ds, dt) = match c {
            0 => (next, after),
            1 => (-after, next - after),
            _ => (after - next, -next),
        };
        Jet { position: ring.limit(self.scheme), ds, dt }
    }

    /// Between the jets at the corners of a small patch: `sum w_i (P_i + J_i (x - x_i) / 2)`, exact for
    /// quadratics. Corners where the surface is not smooth give no tangents.
    fn blend(&self, [_, s, t]: [f64; 3]) -> Jet {
        // Quartering has doubled what rounding the weights kept from summing to 1.
        let weights = [1.0 - s - t, s, t];
        let jets = [0, 1, 2].map(|c| self.corner_jet(c));
        let smooth = [0, 1, 2].map(|c| self.rings[c].is_smooth());
        let mut all = Jet::default();
        let mut total = 0.0;
        for c in 0..3 {
            let (jet, w) = (&jets[c], weights[c]);
            all.position += jet.position * w;
            if smooth[c] {
                let corner = [f64::from(u8::from(c == 1)), f64::from(u8::from(c == 2))];
                if smooth == [true; 3] {
                    let (x, y) = (s - corner[0], t - corner[1]);
                    all.position += (jet.ds * x + jet.dt * y) * (0.5 * w);
                }
                // A corner on which all the weight lies still shares its tangents with the others.
                let share = w.max(f64::MIN_POSITIVE);
                all.ds += jet.ds * share;
                all.dt += jet.dt * share;
                total += share;
            }
        }
        if total > 0.0 {
            return Jet { ds: all.ds / total, dt: all.dt / total, ..all };
        }
        let heaviest = (1..3).fold(0, |best, c| if weights[c] > weights[best] { c } else { best });
        Jet { position: all.position, ..jets[heaviest] }
    }
}

impl Ring {
    /// Is the surface around the vertex what it would be inside, among six neighbours?
    fn is_regular(&self) -> bool {
        match (&self.place, self.valence()) {
            (Place::Inside, 6) => self.beside.is_empty(),
            (Place::Border(border), 4) => border.rule == BorderRule::Plain && self.beside.is_empty(),
            (Place::Border(border), 2) => border.rule == BorderRule::PlainCorner,
            _ => false,
        }
    }

    /// Point `i` of the six around a regular vertex; beyond a regular plain border, the phantoms that make
    /// the border's rules those of the interior.
    fn around(&self, i: usize) -> DVec3 {
        let (c, s) = (self.centre, &self.spokes);
        match (s.len(), i) {
            (k, i) if i < k => s[i],
            (4, 4) => c + s[3] - s[2],
            (2, 2) => c + s[1] - s[0],
            (2, 3) => c + c - s[0],
            (2, 4) => c + c - s[1],
            _ => c + s[0] - s[1],
        }
    }

    fn is_given(&self) -> bool {
        self.border().is_some_and(|b| matches!(b.rule, BorderRule::Given | BorderRule::GivenCorner))
    }

    /// Is the limit surface differentiable here by the coordinates of the faces?
    fn is_smooth(&self) -> bool {
        match &self.place {
            Place::Inside => self.valence() == 6,
            Place::Border(border) => match border.rule {
                BorderRule::Plain | BorderRule::Given => self.valence() == 4,
                BorderRule::PlainCorner | BorderRule::GivenCorner => self.valence() < 4 && self.corner == NONE,
            },
        }
    }
}

/// `jet` with `velocity` as its derivative along edge `c`; across, it stays as it is.
fn with_velocity(jet: Jet, c: usize, velocity: DVec3) -> Jet {
    match c {
        0 => Jet { ds: velocity, ..jet },
        1 => {
            let across = jet.ds + jet.dt;
            Jet { ds: (across - velocity) * 0.5, dt: (across + velocity) * 0.5, ..jet }
        }
        _ => Jet { dt: -velocity, ..jet },
    }
}
