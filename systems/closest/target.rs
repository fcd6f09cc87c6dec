//! A surface as the target of a fit.

use std::fmt;
use std::sync::Arc;

use glam::DVec3;
use selvedge_components::evaluate::SurfacePoint;
use selvedge_components::target::{Foot, Target, TargetError};

use super::{ClosestError, SurfaceIndex, Walk};

/// How a hint limits the search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Search {
    /// Not at all: the answer is the closest point of the whole surface.
    #[default]
    Everywhere,
    /// To the sheet that the hint lies on: what thin parts need, whose other side may be nearer.
    AroundHint,
}

/// A surface that is fitted to.
pub struct SurfaceTarget<S> {
    /// The surface, ready to be searched.
    pub index: Arc<SurfaceIndex<S>>,
    /// What hints mean.
    pub search: Search,
    /// To be raised when another surface takes this one's place.
    pub revision: u64,
}

impl<S> SurfaceTarget<S> {
    /// The target of which all is searched.
    pub const fn new(index: Arc<SurfaceIndex<S>>) -> Self {
        Self { index, search: Search::Everywhere, revision: 0 }
    }
}

impl<S> fmt::Debug for SurfaceTarget<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SurfaceTarget").field("search", &self.search).field("revision", &self.revision).finish()
    }
}

impl<S: Walk> Target for SurfaceTarget<S> {
    fn closest(&self, to: DVec3, hint: Option<SurfacePoint>) -> Result<Foot, TargetError> {
        let found = match (hint, self.search) {
            (None, _) => self.index.closest(to),
            (Some(hint), Search::Everywhere) => self.index.closest_from(to, hint),
            (Some(hint), Search::AroundHint) => self.index.closest_around(to, hint),
        };
        match found {
            Ok(closest) => Ok(Foot { position: closest.position, at: Some(closest.at) }),
            Err(ClosestError::NotFinite { .. } | ClosestError::Ambiguous { .. }) => {
                Err(TargetError::NotFinite { to, answer: DVec3::NAN })
            }
        }
    }

    fn revision(&self) -> u64 {
        self.revision
    }
}
