//! # Compose: the result of a source, of what its trims have left
//!
//! Where no trim reaches, the source's own faces stay, with their control points and details; within
//! reach of a trim, what that has left takes their place. Faces that lie beyond a curve, but out of its
//! reach, are found by flood: from what a trim has removed, over faces of the source. What stays is
//! what no trim removes.

mod audit;
mod roster;
mod system;

use std::sync::Arc;

use bevy_ecs::entity::Entity;
use bevy_ecs::prelude::Component;
use glam::DVec3;
use selvedge_components::mesh::{Connectivity, FaceId, HalfedgeId, VertexId};
use selvedge_components::subdivision::remesh::RemeshError;
use selvedge_components::subdivision::{Address, Border, Details, LoopSurface, NONE, Side};
use selvedge_components::trim::{BorderLine, TrimFault};

use super::rename::{Names, rename_details};
use super::zone::{Zone, ZoneSide};
use crate::subdivision::remesh::{Beyond, FaceOrigin, Fate, Remeshed, VertexOrigin};
use roster::{Face, Roster};

pub use system::compose_results;

/// What trims made together have left: on the first of them, once it has finished. Derived.
#[derive(Component, Clone, Debug)]
pub struct Solved {
    /// The trims, in their order.
    pub together: Vec<Entity>,
    /// A number that no other solution of this world has.
    pub number: u64,
    /// The part of the source that was looked at; all of it where there is none.
    pub zone: Option<Arc<ZoneOf>>,
    /// The cage.
    pub remeshed: Arc<Remeshed>,
    /// What is left of that part of the source, details and all.
    pub surface: Arc<LoopSurface>,
    /// What those of them remove that were asked for it, in the same form.
    pub others: Vec<(Entity, Self)>,
}

/// A zone, and what its sides are of the source's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ZoneOf {
    /// The zone.
    pub zone: Zone,
    /// By side of the zone.
    pub sides: Vec<ZoneSide>,
    /// How faces at its rim hang together beyond it, where that may matter.
    pub beyond: Beyond,
}

impl ZoneOf {
    /// All of a source.
    fn whole(source: &LoopSurface) -> Self {
        let sides = (0..source.sides.len()).map(ZoneSide::Whole).collect();
        Self { zone: Zone::whole(&source.mesh), sides, beyond: Beyond::default() }
    }

    /// Is every side that is not in the zone as a whole as it was in `source`, the zone's surface, or
    /// gone?
    pub(super) fn keeps_partial_sides(&self, source: &LoopSurface, remeshed: &Remeshed) -> bool {
        let is_whole = |s: usize| matches!(self.sides.get(s), Some(ZoneSide::Whole(_)));
        remeshed.surface.sides.iter().zip(&remeshed.side_origin).all(|(side, origin)| match origin.line {
            BorderLine::Side(s) if !is_whole(s) => {
                let before = &source.sides[s];
                side.ends == before.ends
                    && side.edge_count() == before.edge_count()
                    && matches!(
                        (&side.border, &before.border),
                        (Border::Plain, Border::Plain) | (Border::Given { .. }, Border::Given { .. })
                    )
            }
            _ => true,
        })
    }
}

/// What a result was put together of: the numbers of the solutions, ascending.
#[derive(Component, Clone, Debug, Default, PartialEq, Eq)]
pub struct ComposedOf(pub Vec<u64>);

impl ComposedOf {
    fn of(pieces: &[&Solved]) -> Self {
        let mut numbers: Vec<u64> = pieces.iter().map(|piece| piece.number).collect();
        numbers.sort_unstable();
        Self(numbers)
    }
}

/// Why pieces make no result: which of them is in the way.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    /// The piece, by index.
    pub piece: usize,
    /// What is wrong.
    pub why: TrimFault,
}

/// What is left of `source` by all of `pieces`; `None` where there are none.
///
/// Where nothing stays, the piece is the first that leaves nothing of what those before it leave.
///
/// # Errors
/// When a piece does not separate what stays from what goes, nothing stays, or what is put together is not
/// what its pieces were.
pub fn compose(source: &LoopSurface, pieces: &[&Solved]) -> Result<Option<Arc<LoopSurface>>, Misfit> {
    match pieces {
        [] => Ok(None),
        [all] if all.zone.is_none() => Ok(Some(Arc::clone(&all.surface))),
        _ => {
            // One that was made on all of the source has all of it for its zone.
            let whole = pieces.iter().any(|piece| piece.zone.is_none()).then(|| ZoneOf::whole(source));
            let own = pieces.iter().map(|&piece| (piece, piece.zone.as_deref().or(whole.as_ref())));
            let pieces = own.filter_map(|(piece, zone)| Some(Piece::new(piece, zone?))).collect();
            Composer::new(source, pieces).compose().map(|surface| Some(Arc::new(surface)))
        }
    }
}

struct Composer<'a> {
    source: &'a LoopSurface,
    pieces: Vec<Piece<'a>>,
    /// By face of the source: does a piece take its place?
    taken: Vec<bool>,
}

/// One piece, by names of the source.
struct Piece<'a> {
    zone: &'a ZoneOf,
    remeshed: &'a Remeshed,
    surface: &'a LoopSurface,
    /// By face of the piece: the face of the source that it still is, or [`NONE`].
    still: Vec<u32>,
}

impl<'a> Piece<'a> {
    fn new(solved: &'a Solved, zone: &'a ZoneOf) -> Self {
        let still = solved.remeshed.face_origin.iter().map(|origin| match origin {
            FaceOrigin::Leaf { level: 0, code } => zone.zone.faces[code.root_face(0).index()].0,
            _ => NONE,
        });
        Self { zone, remeshed: &solved.remeshed, surface: &solved.surface, still: still.collect() }
    }

    /// By face of the zone: is all of it of this fate?
    fn whole(&self, fate: Fate) -> Vec<bool> {
        let mut shares = vec![0.0; self.zone.zone.faces.len()];
        for &(level, code, _) in self.remeshed.fates.iter().filter(|(.., found)| *found == fate) {
            // A sum of quarters of quarters is exact.
            shares[code.root_face(level).index()] += 0.25_f64.powi(level as i32);
        }
        shares.into_iter().map(|share| share == 1.0).collect()
    }

    /// The vertex of the source that a vertex of the piece is.
    fn root(&self, v: VertexId) -> Option<VertexId> {
        match self.remeshed.vertex_origin[v.index()] {
            VertexOrigin::Root(root) => Some(self.zone.zone.vertices[root.index()]),
            _ => None,
        }
    }
}

impl<'a> Composer<'a> {
    fn new(source: &'a LoopSurface, pieces: Vec<Piece<'a>>) -> Self {
        let mut taken = vec![false; source.mesh.face_count()];
        for piece in &pieces {
            let mut gone: Vec<bool> = vec![true; piece.zone.zone.faces.len()];
            for &still in piece.still.iter().filter(|&&still| still != NONE) {
                if let Some(own) = piece.zone.zone.face(FaceId(still)) {
                    gone[own.index()] = false;
                }
            }
            for (face, _) in piece.zone.zone.faces.iter().zip(gone).filter(|(_, gone)| *gone) {
                taken[face.index()] = true;
            }
        }
        Self { source, pieces, taken }
    }

    fn compose(&self) -> Result<LoopSurface, Misfit> {
        let gone: Vec<Vec<bool>> = (0..self.pieces.len()).map(|p| self.gone(p)).collect::<Result<_, _>>()?;
        if let Some(piece) = first_to_leave_nothing(&gone) {
            return Err(Misfit { piece, why: RemeshError::NothingLeft { curve: 0 }.into() });
        }
        let left = self.faces().into_iter().filter(|&face| {
            let (own, root) = self.root_of(face);
            (0..gone.len()).all(|p| Some(p) == own || !gone[p][root.index()])
        });
        let assembly = Assembly::of(self, left.collect())?;
        let surface = assembly.surface(self);
        audit::audit(self, &assembly, &surface)?;
        Ok(surface)
    }

    /// The piece that a face of the result is of, and the face of the source that it stands on.
    fn root_of(&self, face: Face) -> (Option<usize>, FaceId) {
        match face {
            Face::Source(f) => (None, FaceId(f)),
            Face::Piece(p, f) => {
                let piece = &self.pieces[p as usize];
                // Whatever a piece changes lies in faces that no other piece divides.
                let corner = piece.surface.mesh.face(FaceId(f))[0];
                let own = piece.remeshed.natural[corner.index()].face;
                (Some(p as usize), piece.zone.zone.faces[own.index()])
            }
        }
    }

    /// Faces of the source first, in their order; then the new ones, piece by piece.
    fn faces(&self) -> Vec<Face> {
        let own = (0..self.taken.len()).filter(|&f| !self.taken[f]).map(|f| Face::Source(f as u32));
        let new = (0_u32..).zip(&self.pieces).flat_map(|(p, piece)| {
            (0_u32..).zip(&piece.still).filter(|(_, still)| **still == NONE).map(move |(f, _)| Face::Piece(p, f))
        });
        own.chain(new).collect()
    }

    /// By face of the source: has the piece removed all of it? Beyond its zone that is so where it is
    /// reached from what it has removed in the zone.
    fn gone(&self, p: usize) -> Result<Vec<bool>, Misfit> {
        let (mesh, piece) = (&self.source.mesh, &self.pieces[p]);
        let zone = &piece.zone.zone;
        let (removed, kept) = (piece.whole(Fate::Removed), piece.whole(Fate::Kept));
        let mut gone = vec![false; mesh.face_count()];
        let mut stack = Vec::new();
        for (&face, _) in zone.faces.iter().zip(&removed).filter(|(_, removed)| **removed) {
            gone[face.index()] = true;
            stack.push(face);
        }
        while let Some(face) = stack.pop() {
            for next in (0..3).filter_map(|c| mesh.twin(HalfedgeId::of(face, c))).map(HalfedgeId::face) {
                match zone.face(next) {
                    None if !gone[next.index()] => {
                        gone[next.index()] = true;
                        stack.push(next);
                    }
                    // What the piece keeps is reached, from beyond its zone, from what it removes.
                    Some(own) if kept[own.index()] && zone.face(face).is_none() => {
                        let at = self.place(next);
                        return Err(Misfit { piece: p, why: RemeshError::DoesNotSeparate { curve: 0, at }.into() });
                    }
                    _ => {}
                }
            }
        }
        Ok(gone)
    }

    fn place(&self, face: FaceId) -> DVec3 {
        let corners = self.source.mesh.face(face).map(|v| self.source.points[v.index()]);
        (corners[0] + corners[1] + corners[2]) / 3.0
    }
}

/// The first piece that, with those before it, leaves nothing.
fn first_to_leave_nothing(gone: &[Vec<bool>]) -> Option<usize> {
    let faces = gone.first()?.len();
    let mut left = vec![true; faces];
    gone.iter().position(|gone| {
        left.iter_mut().zip(gone).for_each(|(left, gone)| *left &= !gone);
        !left.contains(&true)
    })
}

/// The mesh of some faces.
struct Assembly {
    roster: Roster,
    mesh: Arc<Connectivity>,
}

impl Assembly {
    /// # Errors
    /// [`RemeshError::NotManifold`], which pieces that end where the source goes on never are.
    fn of(composer: &Composer<'_>, faces: Vec<Face>) -> Result<Self, Misfit> {
        let roster = Roster::of(composer, faces);
        let mesh = Connectivity::new(roster.vertex_count(), &roster.corners(composer));
        let misfit =
            |faults| Misfit { piece: composer.pieces.len() - 1, why: RemeshError::NotManifold { faults }.into() };
        Ok(Self { roster, mesh: Arc::new(mesh.map_err(misfit)?) })
    }

    fn surface(&self, composer: &Composer<'_>) -> LoopSurface {
        let points = (0..self.mesh.vertex_count()).map(|v| self.roster.point(composer, VertexId::new(v))).collect();
        let (sides, details) = (self.sides(composer), self.details(composer));
        let corner_rule = composer.source.corner_rule;
        LoopSurface { mesh: Arc::clone(&self.mesh), points, sides, corner_rule, details }
    }

    fn sides(&self, composer: &Composer<'_>) -> Vec<Side> {
        let source = composer.source;
        let whole: Vec<bool> = source
            .sides
            .iter()
            .map(|side| {
                let mut faces = side.vertices[..side.edge_count()].iter().map(|&v| source.mesh.outgoing(v).face());
                faces.all(|f| !composer.taken[f.index()])
            })
            .collect();
        let mut sides = Vec::new();
        for side in source.sides.iter().zip(&whole).filter(|(_, whole)| **whole).map(|(side, _)| side) {
            let vertices: Option<Vec<VertexId>> = side.vertices.iter().map(|&v| self.roster.root(v)).collect();
            sides.extend(vertices.map(|vertices| Side { vertices, ..side.clone() }));
        }
        for (p, piece) in (0_u32..).zip(&composer.pieces) {
            for (s, side) in piece.surface.sides.iter().enumerate() {
                let ours = match piece.side_of_zone(s) {
                    None => true,
                    Some(ZoneSide::Whole(of_source)) => !whole[of_source],
                    Some(ZoneSide::Part | ZoneSide::Inside) => false,
                };
                let vertices =
                    side.vertices.iter().map(|&v| self.roster.of_piece(composer, p, v)).collect::<Option<_>>();
                sides.extend(vertices.filter(|_| ours).map(|vertices| Side { vertices, ..side.clone() }));
            }
        }
        sides
    }

    fn details(&self, composer: &Composer<'_>) -> Details {
        let source = composer.source;
        let pieces = composer.pieces.iter().map(|piece| &piece.surface.details);
        let levels = core::iter::once(&source.details).chain(pieces).map(|d| d.levels.len()).max().unwrap_or(0);
        let at = |level: usize| {
            let stored = |details: &'_ Details| details.levels.get(level).cloned().unwrap_or_default();
            let own = FromSource(&self.roster);
            // What lies in a zone comes with its piece.
            let outside = stored(&source.details).into_iter().filter(|(address, _)| !composer.in_a_zone(*address));
            let outside: Vec<_> = outside.collect();
            let mut all = rename_details(&outside, &source.mesh, &self.mesh, &own);
            for (p, piece) in (0_u32..).zip(&composer.pieces) {
                let names = FromPiece { assembly: self, composer, piece: p };
                all.extend(rename_details(&stored(&piece.surface.details), &piece.surface.mesh, &self.mesh, &names));
            }
            all.sort_unstable_by_key(|detail| detail.0);
            // Where zones overlap both have the source's own.
            all.dedup_by_key(|detail| detail.0);
            all
        };
        Details { levels: (0..levels).map(at).collect() }
    }
}

impl Composer<'_> {
    fn in_a_zone(&self, address: Address) -> bool {
        let mesh = &self.source.mesh;
        self.pieces.iter().any(|piece| {
            let zone = &piece.zone.zone;
            match address {
                Address::Corner(v) => zone.vertex(v).is_some(),
                Address::Edge(e, _) => {
                    let h = mesh.halfedge(e);
                    [Some(h), mesh.twin(h)].into_iter().flatten().any(|h| zone.face(h.face()).is_some())
                }
                Address::Face(f, ..) => zone.face(f).is_some(),
            }
        })
    }
}

impl Piece<'_> {
    /// The side of the zone that side `s` of the piece still runs along; `None` on a curve.
    fn side_of_zone(&self, s: usize) -> Option<ZoneSide> {
        match self.remeshed.side_origin[s].line {
            BorderLine::Side(of_zone) => self.zone.sides.get(of_zone).copied(),
            BorderLine::Cut(_) => None,
        }
    }
}

struct FromSource<'a>(&'a Roster);

impl Names for FromSource<'_> {
    fn vertex(&self, v: VertexId) -> Option<VertexId> {
        self.0.root(v)
    }

    fn face(&self, f: FaceId) -> Option<FaceId> {
        self.0.face_of_source(f)
    }
}

struct FromPiece<'a> {
    assembly: &'a Assembly,
    composer: &'a Composer<'a>,
    piece: u32,
}

impl Names for FromPiece<'_> {
    fn vertex(&self, v: VertexId) -> Option<VertexId> {
        self.assembly.roster.of_piece(self.composer, self.piece, v)
    }

    fn face(&self, f: FaceId) -> Option<FaceId> {
        self.assembly.roster.face_of_piece(&self.composer.pieces[self.piece as usize], self.piece, f)
    }
}
