//! What is known of leaves from before.

use std::collections::HashMap;

use selvedge_components::mesh::FaceId;
use selvedge_components::subdivision::Deviation;

use super::assemble::LeafKey;
use super::sample::{Farthest, Place};

/// What is known of leaves, whatever the forest around them.
#[derive(Debug, Default)]
pub struct Known {
    /// What was measured by their own triangles alone: it holds in the next forest, too, for those that are
    /// still there and cut as they were.
    pub alone: HashMap<LeafKey, Farthest>,
    /// How they stand off, of those in root faces that are no polynomials: by root face, along the paths of
    /// quarters.
    stand_off: HashMap<FaceId, Vec<(Place, Deviation)>>,
}

impl Known {
    /// Adds how leaves of a root face stand off.
    pub fn learn(&mut self, root: FaceId, stand_off: Vec<(Place, Deviation)>) {
        if !stand_off.is_empty() {
            let all = self.stand_off.entry(root).or_default();
            all.extend(stand_off);
            all.sort_unstable_by_key(|(place, _)| place.along_paths());
        }
    }

    /// How leaves of a root face stand off, as far as that is known.
    pub fn stand_off(&self, root: FaceId) -> StandOff<'_> {
        StandOff(self.stand_off.get(&root).map_or(&[], Vec::as_slice))
    }
}

/// How some leaves of a root face stand off, along the paths of quarters.
pub struct StandOff<'a>(&'a [(Place, Deviation)]);

impl StandOff<'_> {
    /// How this leaf does, which comes after all that were asked for before.
    pub fn of(&mut self, leaf: Place) -> Option<Deviation> {
        while let [(place, deviation), rest @ ..] = self.0
            && place.along_paths() <= leaf.along_paths()
        {
            self.0 = rest;
            if *place == leaf {
                return Some(*deviation);
            }
        }
        None
    }
}
