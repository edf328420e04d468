//! The plugin: orders the stages of the frame. Optional plugins place themselves around them.
//!
//! ```text
//! PostUpdate (or the schedule that was asked for)
//!   TransformSystems::Propagate
//!    └─ Prepare ─ Integrate ─ Detect ─ Resolve ─ Evaluate ─ Respond ─ Sync
//!                                                                     └─ AssetEventSystems, VisibilitySystems::CalculateBounds
//! ```

use bevy::app::{
    FixedFirst, FixedLast, FixedPostUpdate, FixedPreUpdate, FixedUpdate, PostStartup, PreStartup, RunFixedMainLoop, Startup,
};
use bevy::asset::AssetEventSystems;
use bevy::camera::visibility::VisibilitySystems;
use bevy::ecs::intern::Interned;
use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;
use bevy::transform::TransformSystems;
use bevy::transform::systems::{
    StaticTransformOptimizations, mark_dirty_trees, propagate_parent_transforms, sync_simple_transforms,
};

#[cfg(feature = "avian")]
use crate::avian;
use crate::bind::{BodyCache, RestCache, Sources};
use crate::components::{
    Cloth, ClothBuildReport, ClothCollision, ClothContacts, ClothGlobalWind, ClothGravity, ClothLoading, ClothMaterial,
    ClothPiece, ClothPins, ClothRenderMesh, ClothReport, ClothSkipFrame, ClothSleep, ClothSolver, ClothStatus, ClothUntangling,
};
use crate::islands::ClothIslands;
use crate::notices::Notices;
use crate::schedule::ClothClock;
use crate::schedule::ClothSystems;
use crate::simulation::{ClothInputs, WorldAir, WorldBodies};
use crate::systems::{
    background, bind, budget, carriers, character, colliders, couple, defaults, detect, evaluate, grab, inputs, integrate, lod,
    pieces, poses, release, render_mesh, resolve, respond, skeleton, skin, sleep, sources, strays, subdivide, sync, touch,
    warm_up,
};
use crate::time;

/// Simulates every entity with [`Cloth`].
///
/// By default it runs in [`PostUpdate`], after transforms are propagated: animation is done, so pinned cloth never lags. In a
/// fixed schedule, `ClothPlugin::new(FixedPostUpdate)`, it runs after physics and in lockstep with it. It then sees the motion
/// of the same tick, and interpolates what is shown. Animation in `PostUpdate` it sees a frame late.
///
/// # Panics
/// When it is added twice, to a schedule that runs once, or without meshes and their assets.
pub struct ClothPlugin {
    schedule: Interned<dyn ScheduleLabel>,
}

impl Default for ClothPlugin {
    fn default() -> Self {
        Self::new(PostUpdate)
    }
}

impl ClothPlugin {
    /// Simulates in `schedule`, with the clock of that schedule.
    pub fn new(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern() }
    }
}

impl Plugin for ClothPlugin {
    fn build(&self, app: &mut App) {
        assert!(
            !app.world().contains_resource::<ClothClock>(),
            "ClothPlugin was added twice. Add it once: `app.add_plugins(ClothPlugin::default())`, \
             or `app.add_plugins(ClothPlugin::new(FixedPostUpdate))` for a fixed clock."
        );
        let once = [PreStartup.intern(), Startup.intern(), PostStartup.intern()];
        assert!(
            !once.contains(&self.schedule) && self.schedule != RunFixedMainLoop.intern(),
            "ClothPlugin cannot run in {:?}. Use a schedule that runs every frame or tick: `app.add_plugins(ClothPlugin::default())`.",
            self.schedule
        );
        let fixed =
            [FixedFirst.intern(), FixedPreUpdate.intern(), FixedUpdate.intern(), FixedPostUpdate.intern(), FixedLast.intern()];
        let interpolates = fixed.contains(&self.schedule);
        let shows = if interpolates { PostUpdate.intern() } else { self.schedule };

        let clock = ClothClock {
            interpolates,
            #[cfg(any(feature = "debug", feature = "record"))]
            schedule: self.schedule,
            shows,
        };
        app.insert_resource(clock);
        register(app);

        #[cfg(feature = "presets")]
        app.add_plugins(crate::presets::ClothPresetPlugin).add_systems(
            self.schedule,
            crate::presets::apply
                .run_if(resource_exists::<Assets<crate::presets::ClothPreset>>)
                .in_set(ClothSystems::Prepare)
                .before(sources::watch),
        );
        #[cfg(feature = "gltf")]
        app.add_systems(self.schedule, crate::gltf::systems().before(crate::presets::apply));
        #[cfg(feature = "gltf")]
        crate::gltf::keep(app);

        order(app, self.schedule);
        if interpolates {
            order(app, shows);
            // What moved in this tick is seen in this tick.
            app.init_resource::<StaticTransformOptimizations>().add_systems(
                self.schedule,
                (mark_dirty_trees, propagate_parent_transforms, sync_simple_transforms)
                    .chain()
                    .in_set(TransformSystems::Propagate),
            );
        }
        stages(app, self.schedule, shows);
        #[cfg(feature = "avian")]
        bodies_of_avian(app, self.schedule);
    }

    fn finish(&self, app: &mut App) {
        assert!(
            app.world().contains_resource::<Assets<Mesh>>(),
            "ClothPlugin needs meshes. Add `DefaultPlugins`, or for a headless app \
             `app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin))`."
        );
    }

    fn is_unique(&self) -> bool {
        // So that the panic in `build` says what to write.
        false
    }
}

/// What is kept between frames, and what is forgotten when a component goes.
fn register(app: &mut App) {
    app.init_resource::<time::ClothTime>()
        .init_resource::<ClothGravity>()
        .init_resource::<ClothGlobalWind>()
        .init_resource::<ClothLoading>()
        .init_resource::<RestCache>()
        .init_resource::<Sources>()
        .init_resource::<BodyCache>()
        .init_resource::<Notices>()
        .init_resource::<WorldBodies>()
        .init_resource::<WorldAir>()
        .init_resource::<ClothIslands>()
        .add_observer(release::on_remove_cloth)
        .add_observer(pieces::on_remove_piece)
        .add_observer(render_mesh::on_remove_render_mesh)
        .add_observer(subdivide::on_remove_subdivision)
        .add_observer(release::on_remove_body)
        .add_observer(release::on_remove_collider)
        .add_observer(couple::on_remove_coupling)
        .add_observer(release::on_remove_zone)
        .add_observer(touch::on_remove_events)
        .add_observer(touch::end_without::<ClothInputs>)
        .add_observer(touch::end_without::<ClothContacts>)
        .add_observer(release::on_remove_grab)
        .add_observer(release::on_disable);
    keep_required(app);
}

/// The stages of the frame, in the order in which they run.
fn stages(app: &mut App, schedule: Interned<dyn ScheduleLabel>, shows: Interned<dyn ScheduleLabel>) {
    app.add_systems(
        schedule,
        (
            (
                time::tick,
                sources::watch,
                (
                    strays::tell::<ClothMaterial, Cloth>,
                    strays::tell::<ClothSolver, Cloth>,
                    strays::tell::<ClothPins, Cloth>,
                    strays::tell::<ClothPiece, Mesh3d>,
                    strays::tell::<ClothRenderMesh, Mesh3d>,
                )
                    .chain(),
                subdivide::meshes,
                poses::hand_down,
                bind::bind,
                character::bodies,
                colliders::shapes,
                (
                    colliders::poses,
                    couple::bodies,
                    inputs::air,
                    warm_up::pace,
                    inputs::settings,
                    budget::budget,
                    // Bevy forgets there what was seen in the last frame.
                    lod::detail.before(VisibilitySystems::VisibilityPropagate),
                    skin::change,
                    (skeleton::pose, carriers::travel, carriers::inertia, carriers::aim, poses::reset, poses::take).chain(),
                    grab::grabs,
                    sleep::watch,
                    inputs::surroundings,
                    couple::couple,
                )
                    .chain()
                    .run_if(time::flows),
            )
                .chain()
                .in_set(ClothSystems::Prepare),
            (
                (integrate::alone, integrate::together, integrate::judge, couple::give, background::finish)
                    .chain()
                    .run_if(time::flows),
                couple::rest.run_if(not(time::flows)),
            )
                .chain()
                .in_set(ClothSystems::Integrate),
            (detect::leave, detect::form_islands, detect::detect).chain().run_if(time::flows).in_set(ClothSystems::Detect),
            resolve::resolve.run_if(time::flows).in_set(ClothSystems::Resolve),
            (
                (evaluate::look, evaluate::judge, evaluate::tell, evaluate::overruled_layers).chain().run_if(time::flows),
                evaluate::recoveries,
            )
                .chain()
                .in_set(ClothSystems::Evaluate),
            (respond::respond, touch::touches, sleep::doze, background::begin)
                .chain()
                .run_if(time::flows)
                .in_set(ClothSystems::Respond),
        ),
    )
    .add_systems(
        shows,
        warm_up::hide
            .after(ClothSystems::Prepare)
            .before(ClothSystems::Integrate)
            .before(VisibilitySystems::VisibilityPropagate),
    )
    .add_systems(
        shows,
        (sync::shape, pieces::follow, render_mesh::follow, sync::write, pieces::write, render_mesh::shape, render_mesh::write)
            .chain()
            .in_set(ClothSystems::Sync),
    );
}

/// Bodies of avian are met as others are, and take what cloth gives them.
#[cfg(feature = "avian")]
fn bodies_of_avian(app: &mut App, schedule: Interned<dyn ScheduleLabel>) {
    app.init_resource::<avian::Seen>()
        .add_observer(avian::on_switch_off::<avian3d::prelude::ColliderDisabled>)
        .add_observer(avian::on_switch_off::<avian3d::prelude::Sensor>)
        .add_observer(avian::on_switch_off::<crate::components::ClothCollisionDisabled>);
    let takes_over = (avian::give, avian::show).chain().after(couple::rest);
    app.add_systems(
        schedule,
        (
            (avian::masses, avian::colliders.after(colliders::poses))
                .chain()
                .after(time::tick)
                .before(couple::bodies)
                .in_set(ClothSystems::Prepare),
            takes_over.in_set(ClothSystems::Integrate),
        )
            .run_if(time::flows),
    );
}

/// What a cloth requires comes back as its default when it is removed: a cloth without pins falls.
fn keep_required(app: &mut App) {
    app.add_observer(defaults::on_remove::<ClothMaterial>)
        .add_observer(defaults::on_remove::<ClothSolver>)
        .add_observer(defaults::on_remove::<ClothPins>)
        .add_observer(defaults::on_remove::<ClothCollision>)
        .add_observer(defaults::on_remove::<ClothUntangling>)
        .add_observer(defaults::on_remove::<ClothSkipFrame>)
        .add_observer(defaults::on_remove::<ClothSleep>)
        .add_observer(defaults::on_remove::<ClothStatus>)
        .add_observer(defaults::on_remove::<ClothReport>)
        .add_observer(defaults::on_remove::<ClothBuildReport>);
}

/// Chains the stages in a schedule, after transforms and before whatever reads meshes.
fn order(app: &mut App, schedule: Interned<dyn ScheduleLabel>) {
    use ClothSystems::{Detect, Evaluate, Integrate, Prepare, Resolve, Respond, Sync};
    app.configure_sets(
        schedule,
        (Prepare, Integrate, Detect, Resolve, Evaluate, Respond, Sync)
            .chain()
            .after(TransformSystems::Propagate)
            .before(AssetEventSystems)
            .before(VisibilitySystems::CalculateBounds),
    );
}
