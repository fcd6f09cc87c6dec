//! Windings made to agree.

use super::edges::EdgeGroups;
use super::faults::{edge, face_faults, run_alike};
use super::{FaceId, Fault};

/// What [`orient`] did.
#[derive(Clone, Debug, PartialEq, Eq, Default)]
pub struct Oriented {
    /// The faces with windings that agree.
    pub faces: Vec<[u32; 3]>,
    /// The faces that were turned round, ascending.
    pub flipped: Vec<FaceId>,
}

/// Makes the windings of each connected component agree, turning as few faces as can be (the
/// minority of the component; on a tie its first face stays).
///
/// Components are joined through edges of exactly two faces; edges of more are not crossed. Which
/// side of a closed component is outside is not asked: one that is inside out as a whole stays so.
///
/// # Errors
/// What [`faults`](super::faults) says of faces by themselves, which comes first; otherwise
/// one [`Fault::NonOrientable`] for each component that admits no consistent winding.
pub fn orient(vertex_count: usize, faces: &[[u32; 3]]) -> Result<Oriented, Vec<Fault>> {
    let mut found = face_faults(vertex_count, faces);
    if !found.is_empty() {
        return Err(found);
    }
    let across = neighbours(faces, &EdgeGroups::new(vertex_count, faces));
    let mut turns = vec![Turn::Unknown; faces.len()];
    for seed in 0..faces.len() {
        if turns[seed] == Turn::Unknown {
            found.extend(settle_component(seed, faces, &across, &mut turns).err());
        }
    }
    if found.is_empty() { Ok(apply(faces, &turns)) } else { Err(found) }
}

/// What is to become of a face's winding.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Turn {
    Unknown,
    Keep,
    Reverse,
}

impl Turn {
    fn reversed(self) -> Self {
        match self {
            Self::Unknown => Self::Unknown,
            Self::Keep => Self::Reverse,
            Self::Reverse => Self::Keep,
        }
    }
}

/// How two faces run through the edge that they share.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Direction {
    Alike,
    Opposite,
}

/// The face across each side of each face and how the two run, where exactly two faces meet.
type Across = [Option<(usize, Direction)>; 3];

fn neighbours(faces: &[[u32; 3]], groups: &EdgeGroups) -> Vec<Across> {
    let mut across: Vec<Across> = vec![[None; 3]; faces.len()];
    for group in groups.iter() {
        if let [(_, a), (_, b)] = *group {
            let how = if run_alike(faces, a, b) { Direction::Alike } else { Direction::Opposite };
            let (a, b) = (a as usize, b as usize);
            across[a / 3][a % 3] = Some((b / 3, how));
            across[b / 3][b % 3] = Some((a / 3, how));
        }
    }
    across
}

/// Decides the turn of every face of the component of `seed`, or names the first edge at which the
/// decisions clash. All its faces are decided either way.
fn settle_component(seed: usize, faces: &[[u32; 3]], across: &[Across], turns: &mut [Turn]) -> Result<(), Fault> {
    turns[seed] = Turn::Keep;
    let mut component = vec![seed];
    let mut clash = Ok(());
    let mut next = 0;
    while let Some(&f) = component.get(next) {
        next += 1;
        for (i, neighbour) in across[f].iter().enumerate() {
            let Some((other, how)) = *neighbour else { continue };
            let wanted = if how == Direction::Opposite { turns[f] } else { turns[f].reversed() };
            if turns[other] == Turn::Unknown {
                turns[other] = wanted;
                component.push(other);
            } else if turns[other] != wanted && clash.is_ok() {
                clash = Err(Fault::NonOrientable { face: FaceId::new(seed), ends: edge(faces, (3 * f + i) as u32) });
            }
        }
    }
    let reversed = component.iter().filter(|&&f| turns[f] == Turn::Reverse).count();
    if 2 * reversed > component.len() {
        for f in component {
            turns[f] = turns[f].reversed();
        }
    }
    clash
}

fn apply(faces: &[[u32; 3]], turns: &[Turn]) -> Oriented {
    let mut out = Oriented { faces: faces.to_vec(), flipped: Vec::new() };
    for (f, _) in turns.iter().enumerate().filter(|&(_, &turn)| turn == Turn::Reverse) {
        out.faces[f].swap(1, 2);
        out.flipped.push(FaceId::new(f));
    }
    out
}
