//! Which trims of a source touch, and are made together.

use bevy_ecs::entity::Entity;
use selvedge_components::subdivision::FaceCode;

use super::locate::Reach;

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

/// The groups that the trims of one source come to, each trim with how far it reaches, and how many of
/// those steps each has taken: from their first guesses on, a step that a group has needed is taken
/// wherever the trims come to be that very group again.
///
/// So groups depend on which trims there are, and not on which there have been: what a trim needed
/// together with one that has gone, or has become another, does not stay with it.
pub fn replay(trims: &[(Entity, &[Reach])]) -> (Vec<Group>, Vec<usize>) {
    let mut steps = vec![0; trims.len()];
    loop {
        let reserved: Vec<(Entity, &[FaceCode])> = trims
            .iter()
            .zip(&steps)
            .map(|(&(trim, reaches), &step)| (trim, reaches.get(step).map_or(&[][..], |reach| &reach.reserved)))
            .collect();
        let groups = groups(&reserved);
        let mut goes_on = false;
        for group in &groups {
            let members: Vec<usize> = (0..trims.len()).filter(|&t| group.contains(&trims[t].0)).collect();
            let has_needed = |&t: &usize| trims[t].1.get(steps[t] + 1).is_some_and(|next| next.with == *group);
            if members.iter().all(has_needed) {
                members.into_iter().for_each(|t| steps[t] += 1);
                goes_on = true;
            }
        }
        if !goes_on {
            return (groups, steps);
        }
    }
}

fn first_of(joined: &[usize], mut t: usize) -> usize {
    while joined[t] != t {
        t = joined[t];
    }
    t
}

#[cfg(test)]
mod tests {
    use selvedge_components::trim::Omega;

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

    #[test]
    fn what_trims_needed_together_does_not_stay_with_one_of_them() {
        let e = |n| Entity::from_raw_u32(n).expect("a small number");
        let reach = |with: &[Entity], faces: &[u64]| Reach {
            with: with.to_vec(),
            reserved: faces.iter().map(|&f| FaceCode(f)).collect(),
            rings: 0,
            omega: Omega::Changed,
        };
        let (a, b, c) = (e(1), e(2), e(3));
        let pair = [a, b];
        let of_a = [reach(&[], &[1, 2]), reach(&pair, &[1, 2, 3]), reach(&[a, b, c], &[1, 2, 3, 4])];
        let of_b = [reach(&[], &[2]), reach(&pair, &[2]), reach(&[a, b, c], &[2])];
        let of_c = [reach(&[], &[3]), reach(&[a, b, c], &[3])];
        let all = [(a, &of_a[..]), (b, &of_b[..]), (c, &of_c[..])];
        assert_eq!(replay(&all), (vec![vec![a, b, c]], vec![2, 2, 1]));
        // Without the second, the first never needed more, and does not reach the third.
        assert_eq!(replay(&[all[0], all[2]]), (vec![vec![a], vec![c]], vec![0, 0]));
        // Nor was the second, where it has become another, ever with the first.
        let another = [reach(&[], &[2])];
        assert_eq!(replay(&[all[0], (b, &another[..])]), (vec![pair.to_vec()], vec![0, 0]));
        // What the pair needed by itself it still needs.
        assert_eq!(replay(&[all[0], all[1]]), (vec![pair.to_vec()], vec![1, 1]));
    }
}
