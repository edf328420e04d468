//! A headless app and what tests look at in it.

pub mod log;

use std::time::Duration;

use bevy::mesh::{MeshPlugin, VertexAttributeValues};
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_drape::prelude::*;
use bevy_drape::{ClothParticles, ClothPlugin};

/// Length of a frame [s].
pub const FRAME: f32 = 1.0 / 60.0;

/// An app with cloth and nothing that needs a window or a GPU, a frame of [`FRAME`] per update.
pub fn app() -> App {
    app_with(ClothPlugin::default())
}

/// As [`app`], with the plugin as given.
pub fn app_with(plugin: ClothPlugin) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, plugin));
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(FRAME)));
    // In which frame a cloth begins is not to depend on the machine.
    app.insert_resource(ClothLoading::AT_ONCE);
    app.finish();
    app.cleanup();
    // The first update of a manual clock has no length.
    app.update();
    app
}

/// Sets the length of the next frames [s].
pub fn frame_length(app: &mut App, seconds: f32) {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f32(seconds)));
}

/// Runs `frames` updates.
pub fn run(app: &mut App, frames: usize) {
    for _ in 0..frames {
        app.update();
    }
}

/// A sheet of 1 m in xz with `n` by `n` vertices.
pub fn sheet(n: u32) -> Mesh {
    Plane3d::default().mesh().size(1.0, 1.0).subdivisions(n - 2).build()
}

/// A mesh for Bevy from one for the solver.
pub fn mesh_of(source: &bevy_drape::solver::rest::SourceMesh) -> Mesh {
    let usage = bevy::asset::RenderAssetUsages::default();
    let positions: Vec<[f32; 3]> = source.positions.iter().map(Vec3::to_array).collect();
    Mesh::new(bevy::mesh::PrimitiveTopology::TriangleList, usage)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_indices(bevy::mesh::Indices::U32(source.triangles.concat()))
}

/// Adds a mesh.
pub fn add(app: &mut App, mesh: Mesh) -> Handle<Mesh> {
    app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh)
}

/// A cloth of that mesh.
pub fn spawn(app: &mut App, mesh: Mesh, extra: impl Bundle) -> Entity {
    let mesh = add(app, mesh);
    app.world_mut().spawn((Mesh3d(mesh), Cloth, extra)).id()
}

/// Pins along one border of [`sheet`].
pub fn border() -> ClothPins {
    ClothPins::where_position(|p| p.z < -0.499)
}

/// The mesh an entity shows.
pub fn shown(app: &App, entity: Entity) -> &Mesh {
    let handle = app.world().get::<Mesh3d>(entity).expect("a mesh on the entity");
    app.world().resource::<Assets<Mesh>>().get(handle).expect("a loaded mesh")
}

/// Positions in the space of the mesh.
pub fn positions(app: &App, entity: Entity) -> Vec<Vec3> {
    vectors(shown(app, entity), Mesh::ATTRIBUTE_POSITION)
}

/// Shown positions in the world.
pub fn world_positions(app: &App, entity: Entity) -> Vec<Vec3> {
    let global = app.world().get::<GlobalTransform>(entity).expect("a transform");
    positions(app, entity).into_iter().map(|p| global.transform_point(p)).collect()
}

/// An attribute of three floats.
pub fn vectors(mesh: &Mesh, attribute: bevy::mesh::MeshVertexAttribute) -> Vec<Vec3> {
    match mesh.try_attribute(attribute) {
        Ok(VertexAttributeValues::Float32x3(values)) => values.iter().map(|&v| Vec3::from(v)).collect(),
        other => panic!("no such attribute: {:?}", other.map(|_| ())),
    }
}

/// Status of a cloth.
pub fn status(app: &App, entity: Entity) -> ClothStatus {
    *app.world().get::<ClothStatus>(entity).expect("a cloth")
}

/// Report of a cloth.
pub fn report(app: &App, entity: Entity) -> &ClothReport {
    app.world().get::<ClothReport>(entity).expect("a cloth")
}

/// Simulated positions in the world.
pub fn particles(app: &App, entity: Entity) -> Vec<Vec3> {
    let particles = app.world().get::<ClothParticles>(entity).expect("a bound cloth");
    particles.world_positions().map(|p| Vec3::new(p.x as f32, p.y as f32, p.z as f32)).collect()
}

/// Whether every shown position is finite.
pub fn finite(app: &App, entity: Entity) -> bool {
    positions(app, entity).iter().all(|p| p.is_finite())
}

/// Lowest height of a set of points.
pub fn lowest(points: &[Vec3]) -> f32 {
    points.iter().map(|p| p.y).fold(f32::INFINITY, f32::min)
}

/// Counts events of one kind.
#[derive(Resource)]
pub struct Seen<E: Send + Sync + 'static>(pub Vec<E>);

/// Records every event of one kind.
pub fn record<E: EntityEvent + Clone>(app: &mut App) {
    app.insert_resource(Seen::<E>(Vec::new()));
    app.add_observer(|event: On<E>, mut seen: ResMut<Seen<E>>| seen.0.push(event.event().clone()));
}

/// Recorded events.
pub fn seen<E: EntityEvent>(app: &App) -> &[E] {
    &app.world().resource::<Seen<E>>().0
}
