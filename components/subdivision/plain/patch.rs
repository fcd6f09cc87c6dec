//! Control points of the regular pieces of a face.

use glam::DVec3;

use super::fan::{Fan, reflect};
use super::limit::border_limit;
use super::place::{Piece, Place};
use super::{PlainLoop, VertexRule};
use crate::evaluate::{Jet, SurfacePoint};
use crate::mesh::{FaceId, HalfedgeId};
use crate::subdivision::boxspline::{Net, Quartic};

impl PlainLoop {
    /// The control points of a regular face; beyond borders, their phantoms.
    #[inline]
    pub fn regular_net(&self, face: FaceId) -> Net {
        let corners = self.topology().mesh().face(face).map(|v| self.point(v));
        let mut net = [DVec3::ZERO; 12];
        net[..3].copy_from_slice(&corners);
        for i in 0..3 {
            let h = HalfedgeId::of(face, i);
            net[3 + i] = self.across(h, corners[i], corners[(i + 1) % 3], corners[(i + 2) % 3]);
            [net[6 + 2 * i], net[7 + 2 * i]] = self.behind(h, corners[i]);
        }
        net
    }

    /// The far corner of the neighbour across `h`, which runs from `a` to `b` with `c` on its left.
    #[inline(always)]
    fn across(&self, h: HalfedgeId, a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
        let mesh = self.topology().mesh();
        match mesh.twin(h) {
            Some(twin) => self.point(mesh.opposite(twin)),
            None => reflect(a, b, c),
        }
    }

    /// The third and fourth point after `h` in the ring of six around the regular vertex `v` that it
    /// leaves.
    #[inline(always)]
    fn behind(&self, h: HalfedgeId, v: DVec3) -> [DVec3; 2] {
        let mesh = self.topology().mesh();
        let turned = |h: HalfedgeId| mesh.twin(h.previous());
        match turned(h).and_then(turned).and_then(turned) {
            Some(third) => [self.point(mesh.to(third)), self.point(mesh.opposite(third))],
            None => self.behind_border(h, v),
        }
    }

    /// As [`Self::behind`] at a regular border vertex or corner: its ring is completed by phantoms.
    /// [`reflect`] gives those across the border edges; at a corner those between continue its two
    /// edges straight on, which alone keeps it in place.
    fn behind_border(&self, h: HalfedgeId, v: DVec3) -> [DVec3; 2] {
        let mesh = self.topology().mesh();
        let vertex = mesh.from(h);
        let mut ring = [DVec3::ZERO; 6];
        let mut k = 0;
        for (place, n) in ring.iter_mut().zip(mesh.neighbours(vertex)) {
            *place = self.point(n);
            k += 1;
        }
        let first = mesh.ring(vertex).position(|g| g == h).unwrap_or(0);
        if k == 2 {
            let [a, b, ..] = ring;
            ring[2..].copy_from_slice(&[reflect(v, b, a), v + v - a, v + v - b, reflect(v, a, b)]);
        } else {
            ring[4] = reflect(v, ring[3], ring[2]);
            ring[5] = reflect(v, ring[0], ring[1]);
        }
        [ring[(first + 3) % 6], ring[(first + 4) % 6]]
    }

    /// The control points, one step finer, of the middle quarter of a face that is not regular. Its
    /// coordinates are turned by half a turn.
    fn middle_net(&self, face: FaceId) -> Net {
        let mesh = self.topology().mesh();
        let h = [0, 1, 2].map(|i| HalfedgeId::of(face, i));
        let mid = h.map(|h| self.edges[mesh.edge(h).index()]);
        let corner = mesh.face(face).map(|v| self.vertices[v.index()]);
        // Around the midpoint of edge i: the two edges of the neighbour's far corner.
        let around = |i: usize| match mesh.twin(h[i]) {
            Some(twin) => [twin.next(), twin.previous()].map(|g| self.edges[mesh.edge(g).index()]),
            None => {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                [reflect(mid[i], corner[i], mid[k]), reflect(mid[i], corner[j], mid[j])]
            }
        };
        let ([a0, a1], [b0, b1], [c0, c1]) = (around(1), around(2), around(0));
        [mid[1], mid[2], mid[0], corner[2], corner[0], corner[1], a0, a1, b0, b1, c0, c1]
    }

    /// The fan of the face left of `h` around the vertex that `h` leaves, one step finer, and that
    /// vertex's limit, which the fan's points are relative to.
    fn fan(&self, h: HalfedgeId, fan: &mut Fan) -> DVec3 {
        let mesh = self.topology().mesh();
        let (v, back) = (mesh.from(h), h.previous());
        let finer = |h: HalfedgeId| self.edges[mesh.edge(h).index()];
        fan.rule = self.topology().rule(v);
        fan.centre = self.vertices[v.index()];
        fan.spokes.clear();
        fan.first = 0;
        let start = if fan.rule == VertexRule::Interior { h } else { mesh.outgoing(v) };
        let mut next = Some(start);
        while let Some(g) = next {
            if g == h {
                fan.first = fan.spokes.len();
            }
            fan.spokes.push(finer(g));
            next = mesh.twin(g.previous()).filter(|&g| g != start);
            if next.is_none() && fan.rule != VertexRule::Interior {
                fan.spokes.push(finer(g.previous()));
            }
        }
        let (x, y, w) = (finer(h.next()), self.vertices[mesh.to(h).index()], self.vertices[mesh.from(back).index()]);
        let k = fan.spokes.len();
        let (r0, r1) = (fan.spokes[fan.first], fan.spokes[(fan.first + 1) % k]);
        let z = mesh.twin(h).map_or_else(|| reflect(r0, y, x), |t| finer(t.previous()));
        let u = mesh.twin(back).map_or_else(|| reflect(r1, w, x), |t| finer(t.next()));
        fan.outer = [z, y, x, w, u];
        self.centre_fan(fan)
    }

    /// Makes the fan's points relative to the limit of its centre, which is returned: then rounding
    /// shrinks with the fan, and differences between its points stay exact however fine it gets.
    fn centre_fan(&self, fan: &mut Fan) -> DVec3 {
        let k = fan.spokes.len();
        let limit = match fan.rule {
            VertexRule::Interior => {
                let mask = self.topology().mask(k);
                fan.weight = mask.step;
                let sum = fan.spokes.iter().fold(DVec3::ZERO, |sum, &p| sum + p);
                fan.centre * (1.0 - k as f64 * mask.limit) + sum * mask.limit
            }
            VertexRule::Border => border_limit(fan.centre, fan.spokes[0], fan.spokes[k - 1]),
            VertexRule::Corner => fan.centre,
        };
        fan.centre -= limit;
        for p in fan.spokes.iter_mut().chain(&mut fan.outer) {
            *p -= limit;
        }
        limit
    }
}

/// Reads the polynomials of a face's pieces; keeps what neighbouring pieces share.
///
/// Cheapest when the pieces of one face are asked for in the order of [`Piece::rank`].
#[derive(Clone, Debug)]
pub struct PatchReader<'a> {
    surface: &'a PlainLoop,
    fans: [CornerFan; 3],
    spare: Vec<DVec3>,
    face: Option<FaceId>,
}

/// The fan around one corner, at one level.
#[derive(Clone, Debug, Default)]
struct CornerFan {
    /// `None`: not gathered for the present face.
    depth: Option<u8>,
    limit: DVec3,
    fan: Fan,
}

impl<'a> PatchReader<'a> {
    /// A reader of `surface`.
    pub fn new(surface: &'a PlainLoop) -> Self {
        Self { surface, fans: Default::default(), spare: Vec::new(), face: None }
    }

    /// The polynomial of `piece` of `face`, which must exist, in the piece's own coordinates.
    ///
    /// For [`Piece::Vertex`] that is the tangent plane there.
    pub fn quartic(&mut self, face: FaceId, piece: Piece) -> Quartic {
        let surface = self.surface;
        match piece {
            Piece::Whole => Quartic::new(&surface.regular_net(face)),
            Piece::Middle => Quartic::new(&surface.middle_net(face)),
            Piece::Corner { corner, depth, quarter } => self.corner_quartic(face, corner, depth, quarter),
            Piece::Vertex { corner } => vertex_quartic(surface, HalfedgeId::of(face, usize::from(corner))),
        }
    }

    fn corner_quartic(&mut self, face: FaceId, corner: u8, depth: u8, quarter: u8) -> Quartic {
        if self.face != Some(face) {
            self.fans.iter_mut().for_each(|f| f.depth = None);
            self.face = Some(face);
        }
        let around = &mut self.fans[usize::from(corner)];
        let mut level = match around.depth {
            Some(level) if level <= depth => level,
            _ => {
                around.limit = self.surface.fan(HalfedgeId::of(face, usize::from(corner)), &mut around.fan);
                0
            }
        };
        while level < depth {
            around.fan.step(&mut self.spare);
            level += 1;
        }
        around.depth = Some(level);
        let mut quartic = Quartic::new(&around.fan.quarter(Piece::QUARTERS[usize::from(quarter)]));
        quartic.coefficients[0] += around.limit;
        quartic
    }

    /// Position and first derivatives at `at`; NaN for a face that does not exist.
    pub fn jet(&mut self, at: SurfacePoint) -> Jet {
        let topology = self.surface.topology();
        if at.face.index() >= topology.mesh().face_count() {
            return Jet { position: DVec3::NAN, ds: DVec3::NAN, dt: DVec3::NAN };
        }
        let place = if topology.is_regular(at.face) {
            Place::in_regular(at.st.x, at.st.y)
        } else {
            Place::in_irregular(at.st.x, at.st.y)
        };
        let quartic = self.quartic(at.face, place.piece);
        place.piece.to_face(quartic.jet(place.s, place.t))
    }
}

/// The tangent plane at the vertex that `h` leaves, as a polynomial of the first degree in the
/// corner's coordinates.
fn vertex_quartic(surface: &PlainLoop, h: HalfedgeId) -> Quartic {
    let mut coefficients = [DVec3::ZERO; 14];
    coefficients[0] = surface.vertex_limit(surface.topology().mesh().from(h));
    (coefficients[1], coefficients[5]) = surface.vertex_tangents(h);
    Quartic { coefficients }
}
