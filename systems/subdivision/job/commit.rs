//! How the result of a job becomes the details of its surface.

use bevy_ecs::entity::Entity;
use glam::DVec3;
use selvedge_components::subdivision::{Address, Details};

/// Where a detail coefficient sits.
pub type Place = (u32, Address);

/// Changes to entities that make the details of a surface what a job has worked out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Commit {
    /// Details of the surface that stay, with another value.
    pub write: Vec<(Entity, DVec3)>,
    /// Details of the job that become the surface's, with this value.
    pub give: Vec<(Entity, DVec3)>,
    /// Places that have no entity yet.
    pub spawn: Vec<(Place, DVec3)>,
    /// Details of either that are no more.
    pub despawn: Vec<Entity>,
}

/// Plans the changes. A detail that the surface has already keeps its entity, and with it whatever
/// a host has put there; one that is zero is not stored.
///
/// `of_surface` and `of_job` are in any order; the plan depends on their places alone, as long as
/// no place is named twice in one of them.
pub fn commit(result: &Details, mut of_surface: Vec<(Place, Entity)>, mut of_job: Vec<(Place, Entity)>) -> Commit {
    of_surface.sort_unstable();
    of_job.sort_unstable();
    let mut plan = Commit::default();
    let (mut held, mut made) = (of_surface.into_iter().peekable(), of_job.into_iter().peekable());
    let levels = (0_u32..).zip(&result.levels);
    let stored =
        levels.flat_map(|(level, stored)| stored.iter().map(move |&(address, value)| ((level, address), value)));
    for (place, value) in stored.filter(|(_, value)| *value != DVec3::ZERO) {
        while let Some((_, left)) = held.next_if(|(at, _)| *at < place) {
            plan.despawn.push(left);
        }
        while let Some((_, left)) = made.next_if(|(at, _)| *at < place) {
            plan.despawn.push(left);
        }
        let ours = held.next_if(|(at, _)| *at == place);
        let theirs = made.next_if(|(at, _)| *at == place);
        match (ours, theirs) {
            (Some((_, stays)), double) => {
                plan.write.push((stays, value));
                plan.despawn.extend(double.map(|(_, entity)| entity));
            }
            (None, Some((_, entity))) => plan.give.push((entity, value)),
            (None, None) => plan.spawn.push((place, value)),
        }
    }
    plan.despawn.extend(held.chain(made).map(|(_, entity)| entity));
    plan
}

#[cfg(test)]
mod tests {
    use selvedge_components::mesh::VertexId;

    use super::*;

    fn at(v: u32) -> Address {
        Address::Corner(VertexId(v))
    }

    fn entity(n: u32) -> Entity {
        Entity::from_raw_u32(n).unwrap()
    }

    #[test]
    fn a_result_keeps_gives_spawns_and_clears_entities_by_place() {
        let value = |x| DVec3::new(x, 0.0, 0.0);
        let result = Details {
            levels: vec![
                vec![(at(1), value(1.0)), (at(2), value(2.0)), (at(4), DVec3::ZERO)],
                vec![(at(0), value(3.0)), (at(9), value(4.0))],
            ],
        };
        let of_surface = vec![((1, at(0)), entity(10)), ((0, at(0)), entity(11)), ((1, at(5)), entity(12))];
        let of_job = vec![((0, at(4)), entity(22)), ((1, at(0)), entity(21)), ((0, at(1)), entity(20))];
        let plan = commit(&result, of_surface, of_job);
        assert_eq!(plan.write, [(entity(10), value(3.0))], "the surface's own stays");
        assert_eq!(plan.give, [(entity(20), value(1.0))]);
        assert_eq!(plan.spawn, [((0, at(2)), value(2.0)), ((1, at(9)), value(4.0))]);
        let mut gone = plan.despawn;
        gone.sort_unstable();
        let mut expected = [11, 12, 21, 22].map(entity);
        expected.sort_unstable();
        assert_eq!(gone, expected, "doubles, zeros and places that are no more");
    }

    #[test]
    fn an_empty_result_clears_all() {
        let of_surface = vec![((0, at(0)), entity(1))];
        let of_job = vec![((0, at(0)), entity(2)), ((3, at(0)), entity(3))];
        let plan = commit(&Details::default(), of_surface, of_job);
        assert_eq!(plan, Commit { despawn: [1, 2, 3].map(entity).to_vec(), ..Commit::default() });
    }
}
