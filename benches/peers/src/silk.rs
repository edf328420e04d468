//! `bevy_silk` in a Bevy app without a window.
//!
//! Its plugin runs `init`, `update` and `render` in `Update`. Only `update` simulates; `render` recomputes normals and writes
//! the mesh, which no other engine here does. So the component that `render` asks for is taken off after `init`, and what a
//! frame of the same app costs without a cloth is subtracted.

use std::time::{Duration, Instant};

use bevy_017::app::TaskPoolPlugin;
use bevy_017::asset::Assets;
use bevy_017::mesh::Mesh;
use bevy_017::prelude::{App, Entity, Mesh3d, Vec3};
use bevy_017::time::{TimePlugin, TimeUpdateStrategy};
use bevy_silk::components::cloth::Cloth;
use bevy_silk::components::cloth_rendering::ClothRendering;
use bevy_silk::prelude::{ClothBuilder, ClothConfig, ClothPlugin, rectangle_mesh};

use crate::measure::percentile;
use crate::peer::{FRAME, Peer, Scene, Solved};

/// Frames of an empty app from which [`Peer::overhead`] is taken.
const EMPTY_FRAMES: u32 = 300;

/// An app with one cloth.
pub struct Silk {
    app: App,
    cloth: Entity,
    /// Iterations of all sticks in a frame.
    sweeps: u64,
    overhead: f64,
}

impl Silk {
    /// The scene with the plugin's defaults. Nothing where the sheet meets a ball or itself: it collides only with bodies,
    /// through another engine's plugin.
    pub fn new(scene: Scene, size: u32) -> Option<Self> {
        if scene != Scene::Hang {
            return None;
        }
        let mut app = app();
        let step = 1.0 / (size - 1) as f32;
        let size = size as usize;
        // Vertices run along Z first: `(0, 0)` and `(0, size - 1)` are corners as on the other engines.
        let mesh = rectangle_mesh((size, size), (Vec3::Z * step, Vec3::X * step), Vec3::Y);
        let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
        let builder = ClothBuilder::new().with_pinned_vertex_ids([0, size - 1].into_iter());
        let cloth = app.world_mut().spawn((Mesh3d(mesh), builder)).id();
        // `init` inserts the cloth at the end of this frame: nothing has moved yet.
        app.update();
        app.world_mut().entity_mut(cloth).remove::<ClothRendering>();
        let sweeps = u64::from(app.world().resource::<ClothConfig>().sticks_computation_depth);
        Some(Self { app, cloth, sweeps, overhead: empty_frame() })
    }

    fn cloth(&self) -> Option<&Cloth> {
        self.app.world().get(self.cloth)
    }
}

impl Peer for Silk {
    fn step(&mut self) -> Solved {
        self.app.update();
        let springs = self.cloth().map_or(0, |cloth| cloth.stick_lengths.len() as u64 * self.sweeps);
        Solved { springs, all: springs }
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        self.cloth().map_or_else(Vec::new, |cloth| cloth.current_point_positions.iter().map(Vec3::to_array).collect())
    }

    fn springs(&self) -> Vec<[u32; 2]> {
        self.cloth().map_or_else(Vec::new, |cloth| cloth.stick_lengths.keys().map(|k| k.map(|v| v as u32)).collect())
    }

    fn overhead(&self) -> f64 {
        self.overhead
    }
}

/// An app with the plugin, what the plugin needs, and time that goes by one [`FRAME`] an update.
fn app() -> App {
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TimePlugin))
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(FRAME)))
        .init_resource::<Assets<Mesh>>()
        .add_plugins(ClothPlugin);
    app
}

/// Median time of an update without a cloth [s].
fn empty_frame() -> f64 {
    let mut app = app();
    app.update();
    let times = (0..EMPTY_FRAMES).map(|_| {
        let start = Instant::now();
        app.update();
        start.elapsed().as_secs_f64()
    });
    percentile(times.collect(), 50)
}
