//! The app that is attacked: everything but a window and a GPU.

use core::time::Duration;

use bevy::ecs::schedule::{ScheduleLabel, SingleThreadedExecutor};
use bevy::gizmos::GizmoPlugin;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;

use super::plan::Setup;

/// Length of a frame, until something else is said `[s]`.
pub const FRAME: f32 = 1.0 / 60.0;

/// How an app is run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Options {
    /// Threads of the task pool of this process; those of the machine if none. There is one pool per process.
    pub threads: Option<usize>,
    /// Longest frame beyond what its work explains `[s]`; none: no clock is read.
    pub patience: Option<f32>,
    /// Whether what is done is told.
    pub tells: bool,
}

/// An app with cloth.
pub fn app(setup: &Setup, options: &Options) -> App {
    let mut app = App::new();
    let mut pools = TaskPoolOptions::default();
    if let Some(threads) = options.threads {
        pools = TaskPoolOptions::with_num_threads(threads);
    }
    let pools = TaskPoolPlugin { task_pool_options: pools };
    app.add_plugins((MinimalPlugins.set(pools), TransformPlugin, AssetPlugin::default(), MeshPlugin));
    if setup.draws {
        app.add_plugins((GizmoPlugin, ClothDebugPlugin)).insert_resource(ClothDebug::only(ClothDebug::ITEMS));
    }
    if setup.measures {
        app.add_plugins((bevy::diagnostic::DiagnosticsPlugin, ClothDiagnosticsPlugin));
    }
    if setup.physics {
        app.add_plugins(avian3d::prelude::PhysicsPlugins::default());
    }
    app.add_plugins(if setup.fixed { ClothPlugin::new(FixedPostUpdate) } else { ClothPlugin::default() });
    begin(&mut app, options);
    app
}

/// Starts an app, with its own clock. Its systems run in this thread, because what is logged is listened to in one thread,
/// unless threads are what is asked for.
pub fn begin(app: &mut App, options: &Options) {
    if options.threads.is_none() {
        for label in [FixedPostUpdate.intern(), PreUpdate.intern(), PostUpdate.intern()] {
            app.edit_schedule(label, |schedule| {
                schedule.set_executor(SingleThreadedExecutor::new());
            });
        }
    }
    // In which frame a cloth begins is not to depend on the machine.
    app.insert_resource(ClothLoading::AT_ONCE);
    frame_length(app, FRAME);
    app.finish();
    app.cleanup();
    // The first update of a manual clock has no length.
    app.update();
}

/// Sets the length of the next frames `[s]`.
pub fn frame_length(app: &mut App, seconds: f32) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(seconds)));
}
