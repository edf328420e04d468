//! The smallest app with cloth: a sheet pinned along one side falls over a ball.

mod stage;

use bevy::prelude::*;
use bevy_drape::prelude::*;
use stage::{FabricLook, OrbitCamera, Stage, fabric};

fn main() -> AppExit {
    Stage::new("hello_cloth")
        .camera(OrbitCamera::around(Vec3::new(0.2, 1.1, 0.0), 4.0).from(0.7, 0.25))
        .report(|cloth: Single<&ClothReport>| format!("worst edge {:.3} of rest", cloth.worst_edge))
        .build()
        .add_plugins(ClothPlugin::default())
        .add_systems(Startup, setup)
        .run()
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let sheet = Plane3d::default().mesh().size(2.0, 2.0).subdivisions(60).build().with_generated_tangents()?;
    let red = fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.75, 0.12, 0.10), 10.0);
    commands.spawn((
        Mesh3d(meshes.add(sheet)),
        MeshMaterial3d(red),
        Transform::from_xyz(0.0, 2.0, 0.0),
        Cloth,
        ClothMaterial::COTTON,
        ClothPins::where_position(|p| p.z < -0.99),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.5).mesh().uv(64, 32))),
        MeshMaterial3d(materials.add(Color::srgb(0.55, 0.55, 0.58))),
        Transform::from_xyz(0.0, 0.9, -0.1),
        ClothCollider::ball(0.5),
    ));
    commands.spawn(ClothCollider::ground());
    Ok(())
}
