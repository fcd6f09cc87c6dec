//! What can be wrong with a mesh: every defect named and placed.

use glam::DVec3;
use thiserror::Error;

use super::edges::{EdgeGroups, ends};
use super::{FaceId, VertexId};

/// A defect of a triangle mesh, named by what it is and placed by index.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Fault {
    /// There is no face at all.
    #[error("the mesh has no faces")]
    Empty,
    /// There are more elements than an id can name.
    #[error("{count} {what} are more than the {limit} that ids can name")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// How many there are.
        count: usize,
        /// How many there may be.
        limit: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index}, but there are {vertex_count} vertices")]
    IndexOutOfRange {
        /// The face.
        face: FaceId,
        /// The vertex index that it names.
        index: u32,
        /// How many vertices there are.
        vertex_count: usize,
    },
    /// A face names the same vertex twice.
    #[error("face {face} is degenerate: it names vertex {vertex} more than once")]
    DegenerateFace {
        /// The face.
        face: FaceId,
        /// The vertex named more than once.
        vertex: VertexId,
    },
    /// Two faces have the same three corners.
    #[error("faces {first} and {second} have the same corners")]
    DuplicateFace {
        /// The face that came first.
        first: FaceId,
        /// The face that repeats it.
        second: FaceId,
    },
    /// More than two faces share an edge.
    #[error("edge {}-{} is non-manifold: {} faces share it", .ends[0], .ends[1], .faces.len())]
    NonManifoldEdge {
        /// The ends of the edge, smaller first.
        ends: [VertexId; 2],
        /// All faces that share it.
        faces: Vec<FaceId>,
    },
    /// Two faces run through their shared edge in the same direction.
    #[error("faces {} and {} run through edge {}-{} in the same direction: their windings disagree", .faces[0], .faces[1], .ends[0], .ends[1])]
    InconsistentWinding {
        /// The ends of the edge, smaller first.
        ends: [VertexId; 2],
        /// The two faces.
        faces: [FaceId; 2],
    },
    /// No choice of windings makes the faces of this component agree.
    #[error("the surface is non-orientable: walking round from face {face} comes back reversed across edge {}-{}", .ends[0], .ends[1])]
    NonOrientable {
        /// A face of the component.
        face: FaceId,
        /// An edge at which the windings cannot agree.
        ends: [VertexId; 2],
    },
    /// The faces around a vertex form more than one fan.
    #[error("vertex {vertex} is non-manifold: its faces form {fans} separate fans")]
    NonManifoldVertex {
        /// The vertex.
        vertex: VertexId,
        /// How many fans meet there.
        fans: u32,
    },
    /// No face uses this vertex.
    #[error("vertex {vertex} is used by no face")]
    UnusedVertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// A control point is NaN or infinite.
    #[error("vertex {vertex} is not finite: {at}")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
        /// Its position.
        at: DVec3,
    },
}

impl Fault {
    /// The same fault with every face called by another name: `name` is given a face as it stands
    /// and answers with what to call it. For lists of faces that stand for another list.
    #[must_use]
    pub fn rename_faces(mut self, name: impl Fn(FaceId) -> FaceId) -> Self {
        match &mut self {
            Self::IndexOutOfRange { face, .. }
            | Self::DegenerateFace { face, .. }
            | Self::NonOrientable { face, .. } => {
                *face = name(*face);
            }
            Self::DuplicateFace { first, second } => (*first, *second) = (name(*first), name(*second)),
            Self::NonManifoldEdge { faces, .. } => faces.iter_mut().for_each(|face| *face = name(*face)),
            Self::InconsistentWinding { faces, .. } => *faces = faces.map(name),
            Self::Empty
            | Self::TooMany { .. }
            | Self::NonManifoldVertex { .. }
            | Self::UnusedVertex { .. }
            | Self::NotFinite { .. } => {}
        }
        self
    }
}

/// Every defect of the connectivity of `faces` over vertices `0..vertex_count`, each kind by index.
/// Empty for an oriented 2-manifold.
///
/// Faces that name a vertex twice or repeat another face are set aside, and the rest is judged without
/// them. What is wrong with the rest comes first, because leaving those faces out would not mend it;
/// then those faces; then vertices that no face names. An index out of range tears a hole whose rim would be called a fault too, so
/// where there is one, edges and vertices are not judged.
/// [`Fault::NonOrientable`] is for [`orient`](super::orient) to find.
///
/// Costs O(vertices + faces log(valence)).
pub fn faults(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<Fault> {
    inspect(vertex_count, faces).err().unwrap_or_default()
}

/// [`faults`], or the grouped half-edges of a mesh that has none.
pub(super) fn inspect(vertex_count: usize, faces: &[[u32; 3]]) -> Result<EdgeGroups, Vec<Fault>> {
    let mut found = face_faults(vertex_count, faces);
    if found.is_empty() {
        let groups = EdgeGroups::new(vertex_count, faces);
        found = surface_faults(vertex_count, faces, &groups);
        found.extend(unused_vertices(vertex_count, faces));
        return if found.is_empty() { Ok(groups) } else { Err(found) };
    }
    if found.iter().all(|fault| matches!(fault, Fault::DegenerateFace { .. } | Fault::DuplicateFace { .. })) {
        let mut sound = vec![true; faces.len()];
        for fault in &found {
            if let Fault::DegenerateFace { face: aside, .. } | Fault::DuplicateFace { second: aside, .. } = fault {
                sound[aside.index()] = false;
            }
        }
        let names: Vec<u32> = (0..faces.len() as u32).filter(|&f| sound[f as usize]).collect();
        let rest: Vec<[u32; 3]> = names.iter().map(|&f| faces[f as usize]).collect();
        let more = surface_faults(vertex_count, &rest, &EdgeGroups::new(vertex_count, &rest));
        let aside = found;
        found = more.into_iter().map(|fault| fault.rename_faces(|f| FaceId(names[f.index()]))).collect();
        found.extend(aside);
        found.extend(unused_vertices(vertex_count, faces));
    }
    Err(found)
}

/// Every control point that is not finite.
pub fn position_faults(positions: &[DVec3]) -> Vec<Fault> {
    let bad = positions.iter().enumerate().filter(|(_, p)| !p.is_finite());
    bad.map(|(v, &at)| Fault::NotFinite { vertex: VertexId::new(v), at }).collect()
}

/// Faults of the list as a whole and of faces judged without their neighbours.
pub(super) fn face_faults(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<Fault> {
    // Half-edges are three to a face, and the last id is kept for "none".
    let limits = [("vertices", vertex_count, u32::MAX as usize - 1), ("faces", faces.len(), u32::MAX as usize / 3 - 1)];
    let too_many = limits.iter().filter(|&&(_, count, limit)| count > limit);
    let mut found: Vec<_> = too_many.map(|&(what, count, limit)| Fault::TooMany { what, count, limit }).collect();
    if !found.is_empty() {
        return found;
    }
    if faces.is_empty() {
        return vec![Fault::Empty];
    }
    let all = || faces.iter().enumerate().map(|(f, &corners)| (FaceId::new(f), corners));
    for (face, corners) in all() {
        let beyond = corners.into_iter().filter(|&index| index as usize >= vertex_count);
        found.extend(beyond.map(|index| Fault::IndexOutOfRange { face, index, vertex_count }));
    }
    let degenerate = all().filter_map(|(face, corners)| Some((face, repeated_corner(corners)?)));
    found.extend(degenerate.map(|(face, vertex)| Fault::DegenerateFace { face, vertex }));
    found.extend(duplicate_faces(faces));
    found
}

/// The corner that a face names more than once.
fn repeated_corner([a, b, c]: [u32; 3]) -> Option<VertexId> {
    if a == b || a == c { Some(VertexId(a)) } else { (b == c).then_some(VertexId(b)) }
}

/// Every face whose corners, in whatever order, are those of an earlier one.
fn duplicate_faces(faces: &[[u32; 3]]) -> Vec<Fault> {
    let mut keys: Vec<([u32; 3], u32)> = Vec::with_capacity(faces.len());
    for (f, corners) in faces.iter().enumerate().filter(|&(_, &corners)| repeated_corner(corners).is_none()) {
        let mut sorted = *corners;
        sorted.sort_unstable();
        keys.push((sorted, f as u32));
    }
    keys.sort_unstable();
    let runs = keys.chunk_by(|a, b| a.0 == b.0);
    let mut repeats: Vec<_> = runs.flat_map(|run| run[1..].iter().map(|again| (run[0].1, again.1))).collect();
    repeats.sort_unstable();
    repeats.into_iter().map(|(a, b)| Fault::DuplicateFace { first: FaceId(a), second: FaceId(b) }).collect()
}

/// Faults of edges and vertices.
fn surface_faults(vertex_count: usize, faces: &[[u32; 3]], groups: &EdgeGroups) -> Vec<Fault> {
    let mut found = Vec::new();
    let mut windings = Vec::new();
    for group in groups.iter() {
        match *group {
            [_] => {}
            [(_, a), (_, b)] => {
                if run_alike(faces, a, b) {
                    windings.push(Fault::InconsistentWinding { ends: edge(faces, a), faces: [face(a), face(b)] });
                }
            }
            _ => found.push(Fault::NonManifoldEdge {
                ends: edge(faces, group[0].1),
                faces: group.iter().map(|&(_, h)| face(h)).collect(),
            }),
        }
    }
    found.append(&mut windings);
    found.extend(split_vertices(vertex_count, faces, groups));
    found
}

/// Do two half-edges of one edge run through it in the same direction?
pub(super) fn run_alike(faces: &[[u32; 3]], a: u32, b: u32) -> bool {
    let from = |h: u32| faces[h as usize / 3][h as usize % 3];
    from(a) == from(b)
}

/// The ends of the edge of half-edge `h`, smaller first.
pub(super) fn edge(faces: &[[u32; 3]], h: u32) -> [VertexId; 2] {
    let (low, high) = ends(faces, h as usize);
    [VertexId(low), VertexId(high)]
}

fn face(h: u32) -> FaceId {
    FaceId(h / 3)
}

/// Vertices of several fans. A fan is a set of corners of one vertex that are linked through shared
/// edges, however many faces share them: what is wrong about an edge of three faces is said of the
/// edge, and not again of its ends.
fn split_vertices(vertex_count: usize, faces: &[[u32; 3]], groups: &EdgeGroups) -> impl Iterator<Item = Fault> {
    let fans = count_fans(vertex_count, faces, groups).into_iter().enumerate();
    fans.filter(|&(_, fans)| fans > 1).map(|(v, fans)| Fault::NonManifoldVertex { vertex: VertexId::new(v), fans })
}

/// Vertices that no face names, not even one that has a fault.
fn unused_vertices(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<Fault> {
    let mut used = vec![false; vertex_count];
    for &v in faces.as_flattened() {
        used[v as usize] = true;
    }
    let unused = used.iter().enumerate().filter(|&(_, &used)| !used);
    unused.map(|(v, _)| Fault::UnusedVertex { vertex: VertexId::new(v) }).collect()
}

/// How many fans meet at each vertex: the classes of corners joined across shared edges.
fn count_fans(vertex_count: usize, faces: &[[u32; 3]], groups: &EdgeGroups) -> Vec<u32> {
    // A corner is named by the half-edge that leaves it.
    let mut corners = Classes::new(3 * faces.len());
    let next = |h: u32| if h % 3 == 2 { h - 2 } else { h + 1 };
    for group in groups.iter() {
        for pair in group.windows(2) {
            let (a, b) = (pair[0].1, pair[1].1);
            let (at_far_a, at_far_b) = (next(a), next(b));
            if run_alike(faces, a, b) {
                corners.join(a, b);
                corners.join(at_far_a, at_far_b);
            } else {
                corners.join(a, at_far_b);
                corners.join(at_far_a, b);
            }
        }
    }
    let mut fans = vec![0_u32; vertex_count];
    for h in 0..3 * faces.len() {
        if corners.parent[h] == h as u32 {
            fans[faces[h / 3][h % 3] as usize] += 1;
        }
    }
    fans
}

/// Disjoint sets with path halving; the smallest member stands for its set.
struct Classes {
    parent: Vec<u32>,
}

impl Classes {
    fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    fn root(&mut self, mut c: u32) -> u32 {
        while self.parent[c as usize] != c {
            self.parent[c as usize] = self.parent[self.parent[c as usize] as usize];
            c = self.parent[c as usize];
        }
        c
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}
