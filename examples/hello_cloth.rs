//! The smallest app with cloth: a sheet, pinned along one side, falls over a ball in a light wind. Copy it into an empty
//! project.

use bevy::prelude::*;
use bevy_drape::prelude::*;

fn main() {
    let wind = ClothGlobalWind::new(Vec3::new(0.5, 0.0, -1.0)); // [m/s]
    App::new().add_plugins((DefaultPlugins, ClothPlugin::default())).insert_resource(wind).add_systems(Startup, setup).run();
}

/// A camera, a light, a ground, a ball and a sheet.
pub fn setup(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    commands.spawn((Camera3d::default(), Transform::from_xyz(3.0, 2.2, 3.8).looking_at(Vec3::Y * 0.9, Vec3::Y)));
    let sun = DirectionalLight { shadow_maps_enabled: true, ..default() };
    commands.spawn((sun, Transform::from_xyz(2.0, 4.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y)));
    let (ground, ball) = (meshes.add(Plane3d::default().mesh().size(8.0, 8.0)), meshes.add(Sphere::new(0.5)));
    let grey = MeshMaterial3d(materials.add(Color::srgb(0.6, 0.65, 0.7)));
    commands.spawn((Mesh3d(ground), grey.clone(), ClothCollider::ground()));
    commands.spawn((Mesh3d(ball), grey, Transform::from_xyz(0.0, 0.9, -0.1), ClothCollider::ball(0.5)));
    let red = Color::srgb(0.75, 0.12, 0.1);
    let red = StandardMaterial { base_color: red, perceptual_roughness: 0.9, double_sided: true, cull_mode: None, ..default() };
    commands.spawn((
        Mesh3d(meshes.add(Plane3d::default().mesh().size(2.0, 2.0).subdivisions(60))),
        MeshMaterial3d(materials.add(red)),
        Transform::from_xyz(0.0, 2.0, 0.0),
        Cloth, // every other setting has a default
        ClothMaterial::COTTON,
        ClothPins::where_position(|p| p.z < -0.99), // in the space of the mesh [m]
    ));
}
