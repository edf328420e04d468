//! Spans for tracers. A binary of its own: threads that wait do the work of other apps in the process, and would tell of their
//! spans.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use bevy::ecs::schedule::SingleThreadedExecutor;
use bevy::log::tracing;
use bevy::log::tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use bevy::log::tracing_subscriber::registry;
use bevy::mesh::MeshPlugin;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;

/// Collects names of spans.
struct Names(Arc<Mutex<Vec<&'static str>>>);

impl<S: tracing::Subscriber> Layer<S> for Names {
    fn on_new_span(&self, attributes: &tracing::span::Attributes<'_>, _: &tracing::span::Id, _: Context<'_, S>) {
        self.0.lock().expect("names").push(attributes.metadata().name());
    }
}

#[test]
fn every_stage_is_a_span_in_the_order_of_the_frame() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, ClothPlugin::default()));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(1.0 / 60.0)));
    app.finish();
    app.cleanup();
    let mesh = Plane3d::default().mesh().size(1.0, 1.0).subdivisions(8).build();
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    app.world_mut().spawn((Mesh3d(mesh), Cloth));
    (0..3).for_each(|_| app.update());
    app.edit_schedule(PostUpdate, |schedule| {
        schedule.set_executor(SingleThreadedExecutor::new());
    });
    let names = Arc::new(Mutex::new(Vec::new()));
    let subscriber = registry().with(Names(names.clone()));
    tracing::subscriber::with_default(subscriber, || app.update());
    let mut names: Vec<&str> = names.lock().expect("names").iter().copied().filter(|name| name.starts_with("cloth/")).collect();
    names.dedup();
    let stages =
        ["cloth/prepare", "cloth/integrate", "cloth/detect", "cloth/resolve", "cloth/evaluate", "cloth/respond", "cloth/sync"];
    assert_eq!(names, stages);
}
