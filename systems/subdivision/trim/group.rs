//! Which trims of a source touch, and are made together.

use bevy_ecs::entity::Entity;
use selvedge_components::subdivision::FaceCode;

/// Trims that are made together, in their order; the first carries the work.
pub type Group = Vec<Entity>;

/// The groups of the trims of one source, in the order of the first of each. Two trims are in one
/// group if faces that they may change are the same, or if others join them. `trims` are in their
/// order, each with the faces that it may change, ascending.
pub fn groups(trims: &[(Entity, &[FaceCode])]) -> Vec<Group> {
    let mut owners: Vec<(FaceCode, usize)> =
        trims.iter().enumerate().flat_map(|(t, (_, faces))| faces.iter().map(move |&f| (f, t))).collect();
    owners.sort_unstable();
    let mut joined: Vec<usize> = (0..trims.len()).collect();
    for pair in owners.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let (a, b) = (first_of(&joined, pair[0].1), first_of(&joined, pair[1].1));
        // The smaller index leads, so a group is named by its first trim.
        joined[a.max(b)] = a.min(b);
    }
    let mut groups: Vec<(usize, Group)> = Vec::new();
    for (t, &(trim, _)) in trims.iter().enumerate() {
        let lead = first_of(&joined, t);
        match groups.binary_search_by_key(&lead, |group| group.0) {
            Ok(at) => groups[at].1.push(trim),
            Err(at) => groups.insert(at, (lead, vec![trim])),
        }
    }
    groups.into_iter().map(|group| group.1).collect()
}

fn first_of(joined: &[usize], mut t: usize) -> usize {
    while joined[t] != t {
        t = joined[t];
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trims_that_share_faces_are_together_however_they_are_linked() {
        let e = |n| Entity::from_raw_u32(n).expect("a small number");
        let faces = |of: &[u64]| of.iter().map(|&f| FaceCode(f)).collect::<Vec<_>>();
        let (a, b, c, d) = (faces(&[1, 2]), faces(&[7, 8]), faces(&[2, 3, 7]), faces(&[20]));
        let trims = [(e(5), &a[..]), (e(6), &d[..]), (e(7), &b[..]), (e(8), &c[..])];
        assert_eq!(groups(&trims), [vec![e(5), e(7), e(8)], vec![e(6)]]);
        assert!(groups(&[]).is_empty());
    }
}
