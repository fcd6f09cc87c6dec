//! What can be wrong with a mesh: every defect named and placed.

use glam::DVec3;
use thiserror::Error;

use super::connectivity::for_each_edge_group;
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

/// Every defect of the connectivity of `faces` over vertices `0..vertex_count`, in the order of the
/// enum, each kind by index. Empty for an oriented 2-manifold.
///
/// Indices out of range and degenerate faces hide what depends on them: those are listed alone.
/// Costs O(vertices + faces).
pub fn faults(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<Fault> {
    let mut found = face_faults(vertex_count, faces);
    if !found.is_empty() {
        return found;
    }
    let mut windings = Vec::new();
    for_each_edge_group(vertex_count, faces, |group| match *group {
        [_] => {}
        [(_, a), (_, b)] => {
            let from = |h: u32| faces[h as usize / 3][h as usize % 3];
            if from(a) == from(b) {
                windings.push(Fault::InconsistentWinding { ends: ends(faces, a), faces: [face(a), face(b)] });
            }
        }
        _ => found.push(Fault::NonManifoldEdge {
            ends: ends(faces, group[0].1),
            faces: group.iter().map(|&(_, h)| face(h)).collect(),
        }),
    });
    found.append(&mut windings);
    found.extend(vertex_faults(vertex_count, faces));
    found
}

/// Every control point that is not finite.
pub fn position_faults(positions: &[DVec3]) -> Vec<Fault> {
    let bad = positions.iter().enumerate().filter(|(_, p)| !p.is_finite());
    bad.map(|(v, &at)| Fault::NotFinite { vertex: VertexId::new(v), at }).collect()
}

/// What [`orient`] did.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Oriented {
    /// The faces with windings that agree.
    pub faces: Vec<[u32; 3]>,
    /// The faces that were turned round, ascending.
    pub flipped: Vec<FaceId>,
}

/// Makes the windings of each connected component agree, turning as few faces as can be (the
/// minority of the component; on a tie the first face stays).
///
/// # Errors
/// [`Fault::NonOrientable`] for each component that admits no consistent winding. Faces must
/// name vertices in range; edges of more than two faces are not crossed.
pub fn orient(vertex_count: usize, faces: &[[u32; 3]]) -> Result<Oriented, Vec<Fault>> {
    let early = face_faults(vertex_count, faces);
    if !early.is_empty() {
        return Err(early);
    }
    // Neighbour across each half-edge, and whether the two run through the edge alike.
    let mut across: Vec<Option<(u32, bool)>> = vec![None; 3 * faces.len()];
    for_each_edge_group(vertex_count, faces, |group| {
        if let [(_, a), (_, b)] = *group {
            let from = |h: u32| faces[h as usize / 3][h as usize % 3];
            let alike = from(a) == from(b);
            across[a as usize] = Some((b, alike));
            across[b as usize] = Some((a, alike));
        }
    });
    let mut turned: Vec<Option<bool>> = vec![None; faces.len()];
    let mut found = Vec::new();
    for seed in 0..faces.len() {
        if turned[seed].is_some() {
            continue;
        }
        turned[seed] = Some(false);
        let mut component = vec![seed];
        let mut next = 0;
        let mut clash = None;
        while let Some(&f) = component.get(next) {
            next += 1;
            let own = turned[f] == Some(true);
            for h in 3 * f..3 * f + 3 {
                let Some((twin, alike)) = across[h] else { continue };
                let (other, wanted) = (twin as usize / 3, own ^ alike);
                match turned[other] {
                    None => {
                        turned[other] = Some(wanted);
                        component.push(other);
                    }
                    Some(is) if is != wanted && clash.is_none() => {
                        clash = Some(Fault::NonOrientable { face: FaceId::new(seed), ends: ends(faces, h as u32) });
                    }
                    Some(_) => {}
                }
            }
        }
        found.extend(clash);
        let minority = component.iter().filter(|&&f| turned[f] == Some(true)).count();
        if 2 * minority > component.len() {
            for f in component {
                turned[f] = turned[f].map(|t| !t);
            }
        }
    }
    if !found.is_empty() {
        return Err(found);
    }
    let mut out = Oriented { faces: faces.to_vec(), flipped: Vec::new() };
    for (f, turn) in turned.into_iter().enumerate() {
        if turn == Some(true) {
            out.faces[f].swap(1, 2);
            out.flipped.push(FaceId::new(f));
        }
    }
    Ok(out)
}

fn face(h: u32) -> FaceId {
    FaceId(h / 3)
}

fn ends(faces: &[[u32; 3]], h: u32) -> [VertexId; 2] {
    let f = faces[h as usize / 3];
    let (a, b) = (f[h as usize % 3], f[(h as usize + 1) % 3]);
    [VertexId(a.min(b)), VertexId(a.max(b))]
}

/// Faults of single faces, and faces that repeat others: what must be right before edges mean
/// anything.
fn face_faults(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<Fault> {
    let limits = [("vertices", vertex_count, u32::MAX as usize - 1), ("faces", faces.len(), u32::MAX as usize / 3 - 1)];
    let too_many = limits.iter().filter(|&&(_, count, limit)| count > limit);
    let mut found: Vec<_> = too_many.map(|&(what, count, limit)| Fault::TooMany { what, count, limit }).collect();
    if !found.is_empty() {
        return found;
    }
    if faces.is_empty() {
        return vec![Fault::Empty];
    }
    for (f, corners) in faces.iter().enumerate() {
        let face = FaceId::new(f);
        for &index in corners.iter().filter(|&&i| i as usize >= vertex_count) {
            found.push(Fault::IndexOutOfRange { face, index, vertex_count });
        }
        let [a, b, c] = *corners;
        if a == b || a == c {
            found.push(Fault::DegenerateFace { face, vertex: VertexId(a) });
        } else if b == c {
            found.push(Fault::DegenerateFace { face, vertex: VertexId(b) });
        }
    }
    if found.is_empty() {
        found = duplicate_faces(faces);
    }
    found
}

fn duplicate_faces(faces: &[[u32; 3]]) -> Vec<Fault> {
    let mut keys: Vec<([u32; 3], u32)> = Vec::with_capacity(faces.len());
    for (f, corners) in faces.iter().enumerate() {
        let mut sorted = *corners;
        sorted.sort_unstable();
        keys.push((sorted, f as u32));
    }
    keys.sort_unstable();
    let runs = keys.chunk_by(|a, b| a.0 == b.0);
    let repeats = runs.flat_map(|run| run[1..].iter().map(|again| (run[0].1, again.1)));
    repeats.map(|(a, b)| Fault::DuplicateFace { first: FaceId(a), second: FaceId(b) }).collect()
}

/// Vertices of no face or of several fans. A fan is a set of corners of one vertex linked through
/// edges of exactly two faces.
fn vertex_faults(vertex_count: usize, faces: &[[u32; 3]]) -> Vec<Fault> {
    // Union of corners around each vertex; a corner is named by the half-edge that leaves it.
    let mut parent: Vec<u32> = (0..3 * faces.len() as u32).collect();
    fn root(parent: &mut [u32], mut c: u32) -> u32 {
        while parent[c as usize] != c {
            parent[c as usize] = parent[parent[c as usize] as usize];
            c = parent[c as usize];
        }
        c
    }
    let mut join = |a: u32, b: u32| {
        let (a, b) = (root(&mut parent, a), root(&mut parent, b));
        parent[a.max(b) as usize] = a.min(b);
    };
    let next = |h: u32| if h % 3 == 2 { h - 2 } else { h + 1 };
    for_each_edge_group(vertex_count, faces, |group| {
        for pair in group.windows(2) {
            let (a, b) = (pair[0].1, pair[1].1);
            let from = |h: u32| faces[h as usize / 3][h as usize % 3];
            let (a2, b2) = (next(a), next(b));
            if from(a) == from(b) {
                join(a, b);
                join(a2, b2);
            } else {
                join(a, b2);
                join(a2, b);
            }
        }
    });
    let mut fans = vec![0_u32; vertex_count];
    for h in 0..3 * faces.len() {
        if parent[h] == h as u32 {
            fans[faces[h / 3][h % 3] as usize] += 1;
        }
    }
    let mut found: Vec<Fault> = Vec::new();
    let many = fans.iter().enumerate().filter(|&(_, &fans)| fans > 1);
    found.extend(many.map(|(v, &fans)| Fault::NonManifoldVertex { vertex: VertexId::new(v), fans }));
    let none = fans.iter().enumerate().filter(|&(_, &fans)| fans == 0);
    found.extend(none.map(|(v, _)| Fault::UnusedVertex { vertex: VertexId::new(v) }));
    found
}
