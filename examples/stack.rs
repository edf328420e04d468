//! Ten sheets fall on a ball, one above the other, and stay apart.
//!
//! R lets them fall again, I opens the panel.

use bevy::prelude::*;
use bevy_drape::inspector::ClothInspectorPlugin;
use bevy_drape::prelude::*;
use drape_scenes::stack;
use drape_stage::{FabricLook, OrbitCamera, Stage, cut, fabric};

/// Sheets, and vertices along the sides of each.
const SHEETS: (u32, u32) = (10, 32);
/// Where the scene's origin, the centre of the ball, is [m].
const ORIGIN: Vec3 = Vec3::new(0.0, 0.85, 0.0);

fn main() -> AppExit {
    Stage::new("stack")
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.85, 0.0), 2.9).from(0.5, 0.28))
        .hint("R: again   I: panel")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), ClothInspectorPlugin::default()))
        .add_systems(Startup, (ball, sheets))
        .add_systems(Update, keys)
        .run()
}

fn ball(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let stone =
        materials.add(StandardMaterial { base_color: Color::srgb(0.80, 0.78, 0.75), perceptual_roughness: 0.35, ..default() });
    commands.spawn((
        // What is seen is a little smaller than what is felt: a coarse cloth is straight between its particles.
        Mesh3d(meshes.add(Sphere::new(stack::BALL - 0.004).mesh().uv(64, 32))),
        MeshMaterial3d(stone.clone()),
        Transform::from_translation(ORIGIN),
        ClothCollider::ball(stack::BALL),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.04, ORIGIN.y - 0.2))),
        MeshMaterial3d(stone),
        Transform::from_xyz(0.0, (ORIGIN.y - 0.2) / 2.0, 0.0),
        ClothCollider::cylinder(0.04, ORIGIN.y - 0.2),
    ));
    commands.spawn(ClothCollider::ground().with_friction(0.8));
}

fn sheets(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let (count, n) = SHEETS;
    // One mesh for all: they share their rest shape.
    let sheet = meshes.add(cut::square(n, 1.0)?);
    for i in 0..count {
        let color = Color::hsl(360.0 * i as f32 / count as f32, 0.55, 0.45);
        commands.spawn((
            Name::new(format!("sheet {}", i + 1)),
            Mesh3d(sheet.clone()),
            MeshMaterial3d(fabric(&mut images, &mut materials, FabricLook::Cotton, color, 12.0)),
            Transform::from_translation(ORIGIN + stack::place(i)),
            Cloth,
        ));
    }
    Ok(())
}

fn keys(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>, sheets: Query<Entity, With<Cloth>>) {
    if keys.just_pressed(KeyCode::KeyR) {
        sheets.iter().for_each(|sheet| commands.entity(sheet).despawn());
        commands.run_system_cached(self::sheets);
    }
}

fn report(cloths: Query<&ClothReport>) -> String {
    let worst = cloths.iter().map(|r| r.worst_edge).fold(0.0, f32::max);
    let crossings: u32 = cloths.iter().map(|r| r.crossings).sum();
    let contacts = cloths.iter().map(|r| r.contacts).max().unwrap_or_default();
    format!("worst edge {worst:.3} of rest, {crossings} crossings, {contacts} contacts\n")
}
