//! The stages of a frame by name, and where they run: what every part that takes a place in the frame has to know.

use bevy::ecs::intern::Interned;
use bevy::ecs::schedule::{IntoScheduleConfigs, ScheduleLabel};
use bevy::ecs::system::ScheduleSystem;
use bevy::prelude::*;

/// The stages of a frame, chained in this order.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ClothSystems {
    /// Binds meshes; gathers settings, anchors, bodies and wind.
    Prepare,
    /// Steps every cloth by a frame.
    Integrate,
    /// Looks for crossings, and for what may touch in the next frame.
    Detect,
    /// Untangles.
    Resolve,
    /// Judges the result; tells of recoveries.
    Evaluate,
    /// Prepares contacts of the next frame; tells of those of this one. Lets cloth sleep that is at rest.
    Respond,
    /// Writes meshes and bounds. In `PostUpdate` when the other stages run in a fixed schedule.
    Sync,
}

/// How the schedule of the cloths relates to what is shown.
#[derive(Resource, Clone, Copy, Debug)]
pub(crate) struct ClothClock {
    /// Whether shown positions lie between the last two frames of a fixed clock.
    pub interpolates: bool,
    /// Where all stages except Sync run.
    #[cfg(any(feature = "debug", feature = "record"))]
    pub schedule: Interned<dyn ScheduleLabel>,
    /// Where Sync runs.
    pub shows: Interned<dyn ScheduleLabel>,
}

/// Adds systems that look at what Integrate left, before Detect looks for what the next frame needs. For plugins that are
/// finished.
#[cfg(feature = "debug")]
pub(crate) fn after_integrate<M>(app: &mut App, systems: impl IntoScheduleConfigs<ScheduleSystem, M>) {
    let schedule = clock(app).schedule;
    app.add_systems(schedule, systems.after(ClothSystems::Integrate).before(ClothSystems::Detect));
}

/// Adds systems that look at a whole frame, once for every one that is shown. For plugins that are finished.
pub(crate) fn after_sync<M>(app: &mut App, systems: impl IntoScheduleConfigs<ScheduleSystem, M>) {
    let shows = clock(app).shows;
    app.add_systems(shows, systems.after(ClothSystems::Sync));
}

/// Where all stages except Sync run. For plugins that are finished.
#[cfg(feature = "record")]
pub(crate) fn of(app: &App) -> Interned<dyn ScheduleLabel> {
    clock(app).schedule
}

fn clock(app: &App) -> ClothClock {
    match app.world().get_resource::<ClothClock>() {
        Some(clock) => *clock,
        None => panic!("there is nothing to look at without ClothPlugin. Add it: `app.add_plugins(ClothPlugin::default())`."),
    }
}
