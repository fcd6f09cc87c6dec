//! A curve in space as an entity.

use std::sync::Arc;

use bevy_ecs::prelude::Component;

use super::Curve;

/// A curve in space, black box allowed.
///
/// Written by the host. A curve that changes inside must raise [`Curve::revision`]; replacing the
/// component by another curve is noticed by itself.
#[derive(Component, Clone, Debug)]
pub struct SpaceCurve {
    /// The curve.
    pub curve: Arc<dyn Curve>,
}

impl SpaceCurve {
    /// The curve as a component.
    pub fn new(curve: impl Curve + 'static) -> Self {
        Self { curve: Arc::new(curve) }
    }
}
