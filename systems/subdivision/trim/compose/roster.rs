//! Which faces a result has, and what their vertices are called.

use glam::DVec3;
use selvedge_components::mesh::{FaceId, VertexId};
use selvedge_components::subdivision::NONE;

use super::{Composer, Piece};

/// A face of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Face {
    /// This one of the source.
    Source(u32),
    /// This one of a piece.
    Piece(u32, u32),
}

/// Some faces, and the names of their vertices.
pub(super) struct Roster {
    /// Those of the source first, each kind ascending.
    pub faces: Vec<Face>,
    /// Vertices of the source that are used, ascending: they come first.
    roots: Vec<VertexId>,
    /// Then those of pieces that are used, ascending: piece and vertex.
    new: Vec<(u32, u32)>,
}

impl Roster {
    pub fn of(composer: &Composer<'_>, faces: Vec<Face>) -> Self {
        let (mut roots, mut new) = (vec![false; composer.source.mesh.vertex_count()], Vec::new());
        for &face in &faces {
            match face {
                Face::Source(f) => composer.source.mesh.face(FaceId(f)).iter().for_each(|v| roots[v.index()] = true),
                Face::Piece(p, f) => {
                    let piece = &composer.pieces[p as usize];
                    for v in piece.surface.mesh.face(FaceId(f)) {
                        match piece.root(v) {
                            Some(root) => roots[root.index()] = true,
                            None => new.push((p, v.0)),
                        }
                    }
                }
            }
        }
        new.sort_unstable();
        new.dedup();
        let roots = (0..roots.len()).filter(|&v| roots[v]).map(VertexId::new).collect();
        Self { faces, roots, new }
    }

    pub fn vertex_count(&self) -> usize {
        self.roots.len() + self.new.len()
    }

    /// The corners of all faces.
    pub fn corners(&self, composer: &Composer<'_>) -> Vec<[u32; 3]> {
        let of_face = |&face: &Face| match face {
            Face::Source(f) => composer.source.mesh.face(FaceId(f)).map(|v| self.root(v).map_or(NONE, |v| v.0)),
            Face::Piece(p, f) => {
                let corners = composer.pieces[p as usize].surface.mesh.face(FaceId(f));
                corners.map(|v| self.of_piece(composer, p, v).map_or(NONE, |v| v.0))
            }
        };
        self.faces.iter().map(of_face).collect()
    }

    pub fn root(&self, of_source: VertexId) -> Option<VertexId> {
        self.roots.binary_search(&of_source).ok().map(VertexId::new)
    }

    pub fn of_piece(&self, composer: &Composer<'_>, p: u32, v: VertexId) -> Option<VertexId> {
        match composer.pieces[p as usize].root(v) {
            Some(root) => self.root(root),
            None => self.new.binary_search(&(p, v.0)).ok().map(|i| VertexId::new(self.roots.len() + i)),
        }
    }

    pub fn face_of_source(&self, f: FaceId) -> Option<FaceId> {
        let own = self.faces.partition_point(|face| matches!(face, Face::Source(_)));
        let key = |face: &Face| if let Face::Source(f) = face { *f } else { NONE };
        self.faces[..own].binary_search_by_key(&f.0, key).ok().map(FaceId::new)
    }

    pub fn face_of_piece(&self, piece: &Piece<'_>, p: u32, f: FaceId) -> Option<FaceId> {
        let key = |face: &Face| if let Face::Piece(p, f) = face { Some((*p, *f)) } else { None };
        match piece.still[f.index()] {
            NONE => self.faces.binary_search_by_key(&Some((p, f.0)), key).ok().map(FaceId::new),
            still => self.face_of_source(FaceId(still)),
        }
    }

    pub fn point(&self, composer: &Composer<'_>, v: VertexId) -> DVec3 {
        match self.roots.get(v.index()) {
            Some(root) => composer.source.points[root.index()],
            None => {
                let (p, v) = self.new[v.index() - self.roots.len()];
                composer.pieces[p as usize].surface.points[v as usize]
            }
        }
    }
}
