//! Control points of the regular pieces of a face.

use glam::DVec3;
use prefetch_index::prefetch_index;

use super::PlainLoop;
use super::band::{Band, Bands, first_band, second_band, third_band};
use super::corner::{CornerPieces, reflect};
use super::finer::{AnyFace, FinerPoints, UsualFace};
use super::place::{self, DEEPEST, Found, Piece};
use super::topology::{FinerCorner, VertexRule};
use crate::evaluate::{Jet, SurfacePoint};
use crate::mesh::{FaceId, HalfedgeId, VertexId};
use crate::subdivision::boxspline::{Net, Quartic, Vector};

/// Makes vectors to calculate with of points.
pub trait Load: Copy {
    /// What is calculated with.
    type Vector: Vector;

    /// The vector of a point.
    fn load(self, point: DVec3) -> Self::Vector;

    /// The vector of a point that is stored with a fourth number behind it, of no meaning.
    fn load_padded(self, point: &[f64; 4]) -> Self::Vector;

    /// The vectors of points.
    #[inline(always)]
    fn load_all<const N: usize>(self, points: [DVec3; N]) -> [Self::Vector; N] {
        let mut vectors = [self.zero(); N];
        for (vector, point) in vectors.iter_mut().zip(points) {
            *vector = self.load(point);
        }
        vectors
    }

    /// The vector of zeros.
    #[inline(always)]
    fn zero(self) -> Self::Vector {
        self.load(DVec3::ZERO)
    }
}

/// Calculates with [`DVec3`].
#[derive(Clone, Copy, Debug, Default)]
pub struct AsStored;

impl Load for AsStored {
    type Vector = DVec3;

    #[inline(always)]
    fn load(self, point: DVec3) -> DVec3 {
        point
    }

    #[inline(always)]
    fn load_padded(self, &[x, y, z, _]: &[f64; 4]) -> DVec3 {
        DVec3::new(x, y, z)
    }
}

/// The control points of a regular face as they are stored; beyond borders, their phantoms.
struct RegularNet<'a, L> {
    surface: &'a PlainLoop,
    load: L,
}

impl<L: Load> RegularNet<'_, L> {
    #[inline(always)]
    fn point(&self, v: VertexId) -> L::Vector {
        self.load.load(self.surface.points[v.index()])
    }

    #[inline(always)]
    fn of(&self, face: FaceId) -> Net<L::Vector> {
        match self.surface.topology.net(face) {
            Some(net) => net.map(|v| self.point(VertexId(v))),
            None => self.beside_border(face),
        }
    }

    /// As [`Self::of`] where some of them are phantoms.
    fn beside_border(&self, face: FaceId) -> Net<L::Vector> {
        let [a, b, c] = self.surface.topology.mesh().face(face);
        let (a, b, c) = (self.point(a), self.point(b), self.point(c));
        let [ha, hb, hc] = [HalfedgeId::of(face, 0), HalfedgeId::of(face, 1), HalfedgeId::of(face, 2)];
        let ([a1, a2], [b1, b2], [c1, c2]) = (self.behind(ha, a), self.behind(hb, b), self.behind(hc, c));
        let (ab, bc, ca) = (self.across(ha, a, b, c), self.across(hb, b, c, a), self.across(hc, c, a, b));
        [a, b, c, ab, bc, ca, a1, a2, b1, b2, c1, c2]
    }

    /// The far corner of the neighbour across `h`, which runs from `a` to `b` with `c` on its left.
    #[inline(always)]
    fn across(&self, h: HalfedgeId, a: L::Vector, b: L::Vector, c: L::Vector) -> L::Vector {
        let mesh = self.surface.topology.mesh();
        match mesh.twin(h) {
            Some(twin) => self.point(mesh.opposite(twin)),
            None => reflect(a, b, c),
        }
    }

    /// The third and fourth point after `h` in the ring of six around the regular vertex `v` that it
    /// leaves.
    #[inline(always)]
    fn behind(&self, h: HalfedgeId, v: L::Vector) -> [L::Vector; 2] {
        let mesh = self.surface.topology.mesh();
        if let Some(one) = mesh.twin(h.previous())
            && let Some(two) = mesh.twin(one.previous())
            && let Some(three) = mesh.twin(two.previous())
        {
            return [self.point(mesh.to(three)), self.point(mesh.opposite(three))];
        }
        self.behind_border(h, v)
    }

    /// As [`Self::behind`] at a regular border vertex or corner: its ring is completed by phantoms.
    /// [`reflect`] gives those across the border edges; at a corner those between continue its two
    /// edges straight on, which alone keeps it in place.
    fn behind_border(&self, h: HalfedgeId, v: L::Vector) -> [L::Vector; 2] {
        let mesh = self.surface.topology.mesh();
        let vertex = mesh.from(h);
        let mut ring = [v; 6];
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
}

/// Reads the polynomials of faces and their pieces, calculating with the vectors of `L`.
#[derive(Clone, Copy, Debug)]
pub struct PatchReader<'a, L = AsStored> {
    surface: &'a PlainLoop,
    load: L,
}

impl<'a, L: Load> PatchReader<'a, L> {
    /// A reader of `surface`.
    pub const fn new(surface: &'a PlainLoop, load: L) -> Self {
        Self { surface, load }
    }

    /// The polynomial of a regular face.
    #[inline(always)]
    pub fn whole(&self, face: FaceId) -> Quartic<L::Vector> {
        Quartic::new(&RegularNet { surface: self.surface, load: self.load }.of(face))
    }

    /// The polynomial of the middle quarter of a face that is not regular, turned by half a turn: its
    /// origin is the middle of the edge opposite to the first corner.
    #[inline(always)]
    pub fn middle(&self, face: FaceId) -> Quartic<L::Vector> {
        match self.usual(face) {
            Some(face) => face.middle(),
            None => Quartic { coefficients: self.load.load_all(self.unusual_middle(face).coefficients) },
        }
    }

    /// Scratch for [`Self::corner`].
    pub fn scratch(&self) -> CornerPieces<'a, L> {
        CornerPieces::new(self.load)
    }

    /// Makes `pieces` those around a corner of a face that is not regular, of the first depth.
    #[inline(always)]
    pub fn corner(&self, face: FaceId, corner: u8, pieces: &mut CornerPieces<'a, L>) {
        pieces.begin(self.any(face).corner(usize::from(corner)));
    }

    /// Scratch for [`Self::begin`].
    pub fn no_bands(&self) -> Bands<'a, L> {
        Bands::new(self.load)
    }

    /// Makes `bands` those around a corner of a face that is not regular, of which the first is known then.
    #[inline(always)]
    pub fn begin(&self, face: FaceId, corner: u8, bands: &mut Bands<'a, L>) {
        bands.begin(self.any(face).corner(usize::from(corner)));
    }

    /// The first of [`Self::begin`]'s bands without the others; `None` at a corner on a border.
    #[inline(always)]
    pub fn first_band(&self, face: FaceId, corner: usize) -> Option<Band<L::Vector>> {
        match self.usual(face) {
            Some(face) => Some(face.first_band(corner)),
            None => Some(self.unusual_band(face, corner, 0)?.load(self.load)),
        }
    }

    /// As [`Self::first_band`] the second.
    #[inline(always)]
    pub fn second_band(&self, face: FaceId, corner: usize) -> Option<Band<L::Vector>> {
        match self.usual(face) {
            Some(face) => Some(face.second_band(corner)),
            None => Some(self.unusual_band(face, corner, 1)?.load(self.load)),
        }
    }

    /// As [`Self::first_band`] the third.
    #[inline(always)]
    pub fn third_band(&self, face: FaceId, corner: usize) -> Option<Band<L::Vector>> {
        match self.usual(face) {
            Some(face) => Some(face.third_band(corner)),
            None => Some(self.unusual_band(face, corner, 2)?.load(self.load)),
        }
    }

    /// `piece` of `face`, in the piece's own coordinates; of a vertex the tangent plane there.
    /// [`Piece::WHOLE`] belongs to regular faces, the others to the rest. What was in `scratch` is lost.
    #[inline(always)]
    pub fn band(&self, face: FaceId, piece: Piece, scratch: &mut Bands<'a, L>) -> Band<L::Vector> {
        match piece {
            Piece::WHOLE => self.plain(self.whole(face)),
            Piece::MIDDLE => self.plain(self.middle(face)),
            _ if piece.depth() == DEEPEST => self.plain(self.tangent_plane(face, piece.corner())),
            _ => {
                self.begin(face, piece.corner(), scratch);
                for _ in 0..piece.depth() {
                    scratch.descend();
                }
                scratch.band(piece.depth(), piece.corner())
            }
        }
    }

    /// As [`Self::middle`] beside a border or a large valence.
    #[cold]
    #[inline(never)]
    fn unusual_middle(&self, face: FaceId) -> Quartic<DVec3> {
        Quartic::new(&PatchReader::new(self.surface, AsStored).any(face).middle_net())
    }

    /// The band of that depth around an interior corner beside a border or a large valence.
    #[cold]
    #[inline(never)]
    fn unusual_band(&self, face: FaceId, corner: usize, depth: u8) -> Option<Band<DVec3>> {
        let of_corner = PatchReader::new(self.surface, AsStored).any(face).corner(corner);
        if of_corner.rule != VertexRule::Interior {
            return None;
        }
        Some(match depth {
            0 => first_band(of_corner.around(AsStored), corner),
            1 => second_band(of_corner.around(AsStored), corner),
            _ => third_band(of_corner.around(AsStored), corner),
        })
    }

    /// A piece that is a polynomial alone.
    #[inline(always)]
    pub fn plain(&self, quartic: Quartic<L::Vector>) -> Band<L::Vector> {
        Band::plain(self.load, quartic)
    }

    /// Asks memory for what `face` is made of, without waiting for it, unless it is regular beside a border.
    #[inline(always)]
    pub fn prefetch(&self, face: FaceId) {
        if let Some(corners) = self.surface.topology.irregular_corners(face) {
            for corner in corners {
                self.surface.finer.prefetch(corner.block);
            }
        } else if let Some(net) = self.surface.topology.net(face) {
            for v in net {
                prefetch_index(&self.surface.points, *v as usize);
            }
        }
    }

    /// Of a face that is not regular which corners are, as
    /// [`PlainTopology::regular_corners`](super::PlainTopology::regular_corners) says it, and the points around
    /// it, unless it is on a border or has a corner of a large valence.
    #[inline(always)]
    pub fn irregular(&self, face: FaceId) -> Option<(u64, Option<UsualFace<'a, L>>)> {
        let PlainLoop { topology, finer, .. } = self.surface;
        let corners = topology.irregular_corners(face)?;
        let usual = UsualFace::new(self.load, topology, finer, corners);
        Some((FinerCorner::regular_among(corners), usual))
    }

    #[inline(always)]
    fn any(&self, face: FaceId) -> AnyFace<'a, L> {
        let PlainLoop { topology, finer, .. } = self.surface;
        AnyFace { load: self.load, topology, blocks: finer, corners: topology.finer_corners(face) }
    }

    /// The points around a face that is not regular, unless it is on a border or has a corner of a large valence.
    #[inline(always)]
    fn usual(&self, face: FaceId) -> Option<UsualFace<'a, L>> {
        let PlainLoop { topology, finer, .. } = self.surface;
        UsualFace::new(self.load, topology, finer, topology.finer_corners(face))
    }

    #[inline(always)]
    fn vector(&self, v: DVec3) -> L::Vector {
        self.load.load(v)
    }

    /// The tangent plane at a corner of a face, as a polynomial of the first degree whose origin is the
    /// corner.
    #[cold]
    pub fn tangent_plane(&self, face: FaceId, corner: u8) -> Quartic<L::Vector> {
        let h = HalfedgeId::of(face, usize::from(corner));
        let mut coefficients = [self.load.zero(); 14];
        coefficients[0] = self.vector(self.surface.vertex_limit(self.surface.topology.mesh().from(h)));
        // From those towards the next corner and the one after to those along the face.
        let (a, b) = self.surface.vertex_tangents(h);
        let (s, t) = match corner {
            0 => (a, b),
            1 => (-b, a - b),
            _ => (b - a, -a),
        };
        (coefficients[1], coefficients[5]) = (self.vector(s), self.vector(t));
        Quartic { coefficients }
    }
}

impl PlainLoop {
    /// Position and first derivatives at `at`; NaN for a face that does not exist.
    pub(super) fn jet_at(&self, at: SurfacePoint) -> Jet {
        let topology = &self.topology;
        if at.face.index() >= topology.mesh().face_count() {
            return Jet { position: DVec3::NAN, ds: DVec3::NAN, dt: DVec3::NAN };
        }
        let (s, t) = place::clamp(at.st.x, at.st.y);
        let regular = topology.regular_corners(at.face).unwrap_or(place::WHOLE);
        let Found { piece, s, t, scale, weights } = place::in_face(s, t, regular);
        let reader = PatchReader::new(self, AsStored);
        let band = reader.band(at.face, Piece::from_index(piece as usize), &mut reader.no_bands());
        let [position, ds, dt] = band.with_derivatives(s, t, weights);
        Jet { position, ds: ds * scale, dt: dt * scale }
    }

    /// The control points of a regular face; beyond borders, their phantoms. `None` where
    /// [`PlainTopology::is_regular`](super::PlainTopology::is_regular) says no.
    pub fn regular_net(&self, face: FaceId) -> Option<Net> {
        self.topology.is_regular(face).then(|| RegularNet { surface: self, load: AsStored }.of(face))
    }
}
