//! A sheet falls through a funnel.
//!
//! R drops another one.

use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_drape::prelude::*;
use drape_scenes::funnel::{self, FLOOR, FRICTION, SHEET};
use drape_stage::{FabricLook, OrbitCamera, Stage, cut, fabric};

/// Vertices along the sides of the sheet.
const DETAIL: u32 = 40;
/// Where the scene's origin, the neck of the funnel, is [m].
const ORIGIN: Vec3 = Vec3::new(0.0, -FLOOR, 0.0);

fn main() -> AppExit {
    Stage::new("funnel")
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.8, 0.0), 3.6).from(0.4, 0.3))
        .hint("R: again")
        .report(report)
        .build()
        .add_plugins(ClothPlugin::default())
        .add_systems(Startup, (funnel, sheet))
        .add_systems(Update, keys)
        .run()
}

fn funnel(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let (vertices, triangles) = funnel::surface();
    let seen = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, vertices.clone())
        .with_inserted_indices(Indices::U32(triangles.concat()))
        .with_computed_smooth_normals();
    let glass = StandardMaterial {
        base_color: Color::srgba(0.70, 0.80, 0.86, 0.28),
        alpha_mode: AlphaMode::Blend,
        perceptual_roughness: 0.1,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    commands.spawn((
        Mesh3d(meshes.add(seen)),
        MeshMaterial3d(materials.add(glass)),
        Transform::from_translation(ORIGIN),
        ClothCollider::tri_mesh(vertices, triangles).with_friction(FRICTION),
    ));
    commands.spawn(ClothCollider::ground());
}

fn sheet(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let (side, height) = SHEET;
    let color = Color::srgb(0.78, 0.30, 0.08);
    commands.spawn((
        Mesh3d(meshes.add(cut::square(DETAIL, side)?)),
        MeshMaterial3d(fabric(&mut images, &mut materials, FabricLook::Silk, color, 8.0)),
        Transform::from_translation(ORIGIN + Vec3::new(0.01, height, 0.02)),
        Cloth,
        ClothMaterial::SILK,
    ));
    Ok(())
}

fn keys(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>, sheets: Query<Entity, With<Cloth>>) {
    if keys.just_pressed(KeyCode::KeyR) {
        sheets.iter().for_each(|sheet| commands.entity(sheet).despawn());
        commands.run_system_cached(sheet);
    }
}

fn report(cloths: Query<&ClothReport>) -> String {
    cloths.iter().map(|r| format!("worst edge {:.3} of rest, {} crossings\n", r.worst_edge, r.crossings)).collect()
}
