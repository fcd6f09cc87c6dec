//! The engine in a Bevy app of the same bevy_ecs version.

use bevy_app::{App, Plugin, Update};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{InternedScheduleLabel, ScheduleLabel};

use crate::install;

/// Installs the engine into one of an app's schedules; by default into [`Update`].
///
/// ```
/// # use bevy_app::prelude::*;
/// let mut app = App::new();
/// app.add_plugins(selvedge::SelvedgePlugin::default());
/// app.update();
/// ```
#[derive(Clone, Copy, Debug)]
pub struct SelvedgePlugin {
    schedule: InternedScheduleLabel,
}

impl SelvedgePlugin {
    /// Installs into this schedule.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }
}

impl Default for SelvedgePlugin {
    fn default() -> Self {
        Self::new(Update)
    }
}

impl Plugin for SelvedgePlugin {
    fn build(&self, app: &mut App) {
        app.init_schedule(self.schedule);
        app.world_mut().resource_scope(|world, mut schedules: Mut<Schedules>| {
            install(world, schedules.entry(self.schedule));
        });
    }
}
