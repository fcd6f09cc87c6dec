//! A result becomes a surface of its own.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use selvedge_components::subdivision::Snapshot;
use selvedge_components::trim::{OtherSideOf, ResultOf, Stale};
use thiserror::Error;

use crate::spawn_surface;

/// Why something could not be baked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BakeError {
    /// It is not a result: neither what is left of a source nor what a trim removes.
    #[error("{entity} is not the result of a trim")]
    NotAResult {
        /// The entity.
        entity: Entity,
    },
    /// Its trims, or their source, have changed since it was made, and are at work or have failed.
    #[error("{entity} is the last good result, and not the present one")]
    Stale {
        /// The entity.
        entity: Entity,
    },
}

/// Makes an editable surface of `result`, which is what is left of a source, or what a trim removes.
/// Returns the surface.
///
/// It has control points and details of its own, and the curves as borders that the result had; it
/// follows neither source nor trims any more, and can be fitted, edited and trimmed like any surface.
/// What it was made of is as it was.
///
/// # Errors
/// [`BakeError::NotAResult`]; [`BakeError::Stale`] while the result is not the present one.
pub fn bake(world: &mut World, result: Entity) -> Result<Entity, BakeError> {
    let entity = world
        .get_entity(result)
        .ok()
        .filter(|entity| entity.contains::<ResultOf>() || entity.contains::<OtherSideOf>());
    let snapshot = entity.and_then(|entity| Some((entity.get::<Snapshot>()?, entity.contains::<Stale>())));
    let Some((snapshot, is_stale)) = snapshot else { return Err(BakeError::NotAResult { entity: result }) };
    if is_stale {
        return Err(BakeError::Stale { entity: result });
    }
    let surface = Arc::clone(&snapshot.surface);
    Ok(spawn_surface(world, &surface))
}
