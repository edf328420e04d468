//! A table cloth over a ball, for now one that only waves.

mod stage;

use bevy::{
    mesh::VertexAttributeValues,
    prelude::*,
};
use stage::{FabricLook, OrbitCamera, Stage, fabric};

/// A mesh that this example moves.
#[derive(Component)]
struct Waves;

fn main() -> AppExit {
    Stage::new("drape")
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.3, 0.0), 4.6).from(0.45, 0.34))
        .report(|time: Res<Time>| format!("{:.2} s of waves", time.elapsed_secs()))
        .build()
        .add_systems(Startup, setup)
        .add_systems(Update, wave)
        .run()
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let ball = materials.add(StandardMaterial {
        base_color: Color::srgb(0.86, 0.84, 0.80),
        perceptual_roughness: 0.35,
        ..default()
    });
    let wood = materials.add(StandardMaterial {
        base_color: Color::srgb(0.62, 0.45, 0.30),
        perceptual_roughness: 0.5,
        ..default()
    });
    commands.spawn((Mesh3d(meshes.add(Cylinder::new(0.55, 0.05))), MeshMaterial3d(wood.clone()), Transform::from_xyz(0.0, 0.55, 0.0)));
    commands.spawn((Mesh3d(meshes.add(Cylinder::new(0.05, 0.55))), MeshMaterial3d(wood), Transform::from_xyz(0.0, 0.275, 0.0)));
    commands.spawn((Mesh3d(meshes.add(Sphere::new(0.25).mesh().ico(12).unwrap_or_else(|_| Sphere::new(0.25).mesh().uv(48, 32)))), MeshMaterial3d(ball), Transform::from_xyz(1.0, 0.25, 0.75)));
    let looks = [
        (FabricLook::Gingham(Color::srgb(0.93, 0.92, 0.88)), Color::srgb(0.72, 0.10, 0.10), Vec3::new(0.0, 0.0, 0.0)),
        (FabricLook::Denim, Color::srgb(0.12, 0.20, 0.40), Vec3::new(-1.5, 0.0, -0.6)),
        (FabricLook::Silk, Color::srgb(0.05, 0.42, 0.42), Vec3::new(1.5, 0.0, -0.8)),
    ];
    for (look, color, place) in looks {
        let repeats = if look == FabricLook::Denim { 12.0 } else { 6.0 };
        let material = fabric(&mut images, &mut materials, look, color, repeats);
        let mesh = Plane3d::default().mesh().size(1.4, 1.4).subdivisions(70).build();
        let mesh = mesh.with_generated_tangents().unwrap_or_else(|error| panic!("{error}"));
        commands.spawn((Waves, Mesh3d(meshes.add(mesh)), MeshMaterial3d(material), Transform::from_translation(place)));
    }
}

/// A cloth over a round table, more or less.
fn wave(mut meshes: ResMut<Assets<Mesh>>, waves: Query<&Mesh3d, With<Waves>>, time: Res<Time>) {
    for mesh in &waves {
        let Some(mut mesh) = meshes.get_mut(mesh) else { continue };
        if let Ok(VertexAttributeValues::Float32x3(points)) = mesh.try_attribute_mut(Mesh::ATTRIBUTE_POSITION) {
            for point in points {
                let flat = Vec2::new(point[0], point[2]);
                let angle = flat.to_angle();
                let out = (flat.length() - 0.55).max(0.0);
                let swing = 0.06 * (8.0 * angle + 2.0 * time.elapsed_secs()).sin() + 0.02 * (19.0 * angle - time.elapsed_secs()).sin();
                point[1] = 0.585 - 0.95 * out * (1.0 - (-out * 12.0).exp()) + swing * out * 3.0;
            }
        }
        mesh.compute_smooth_normals();
    }
}
