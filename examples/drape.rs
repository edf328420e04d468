//! Three fabrics fall over a table, a ball and a capsule.
//!
//! R lets them fall again, D shows what that costs.

use bevy::dev_tools::diagnostics_overlay::{DiagnosticsOverlay, DiagnosticsOverlayItem, DiagnosticsOverlayPlugin};
use bevy::prelude::*;
use bevy::ui::IsDefaultUiCamera;
use bevy_drape::ClothDiagnosticsPlugin;
use bevy_drape::prelude::*;
use clap::Parser;
use drape_stage::{FabricLook, OrbitCamera, Stage, StageArgs, fabric};

/// Three fabrics fall over a table, a ball and a capsule.
#[derive(Parser, Clone)]
struct Arguments {
    #[command(flatten)]
    stage: StageArgs,
    /// Show what the cloths cost from the start.
    #[arg(long)]
    diagnostics: bool,
}

/// Radius and height of the table [m].
const TABLE: (f32, f32) = (0.55, 0.72);
/// Height above the bodies from which the cloths fall [m].
const DROP: f32 = 0.12;

fn main() -> AppExit {
    let arguments = Arguments::parse();
    Stage::from_args("drape", arguments.stage)
        .camera(OrbitCamera::around(Vec3::new(0.12, 0.42, 0.0), 4.5).from(0.25, 0.36))
        .hint("R: again   D: diagnostics")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), ClothDiagnosticsPlugin, DiagnosticsOverlayPlugin))
        .add_systems(Startup, (bodies, cloths))
        .add_systems(PostStartup, overlay.run_if(move || arguments.diagnostics))
        .add_systems(Update, keys)
        .run()
}

/// Shows Bevy's overlay, or hides it.
fn overlay(mut commands: Commands, shown: Query<Entity, With<DiagnosticsOverlay>>, cameras: Query<Entity, With<Camera3d>>) {
    if !shown.is_empty() {
        shown.iter().for_each(|entity| commands.entity(entity).despawn());
        return;
    }
    // The camera of the stage may draw into a picture.
    cameras.iter().for_each(|camera| {
        commands.entity(camera).insert(IsDefaultUiCamera);
    });
    let item = |precision| move |path| DiagnosticsOverlayItem { precision, path, statistic: default() };
    let (times, counts) = (ClothDiagnosticsPlugin::TIMES.map(item(3)), ClothDiagnosticsPlugin::COUNTS.map(item(0)));
    commands.spawn(DiagnosticsOverlay::new("Cloth", times.into_iter().chain(counts).collect()));
}

fn bodies(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let wood =
        materials.add(StandardMaterial { base_color: Color::srgb(0.55, 0.38, 0.24), perceptual_roughness: 0.5, ..default() });
    let stone =
        materials.add(StandardMaterial { base_color: Color::srgb(0.80, 0.78, 0.75), perceptual_roughness: 0.35, ..default() });
    let (radius, height) = TABLE;
    commands.spawn((
        // What is seen ends a little before what is felt: a sharp rim shows between the particles of a cloth.
        Mesh3d(meshes.add(Cylinder::new(radius - 0.015, 0.03).mesh().resolution(96))),
        MeshMaterial3d(wood.clone()),
        Transform::from_xyz(0.0, height - 0.02, 0.0),
        ClothCollider::cylinder(radius, 0.04),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.05, height - 0.04))),
        MeshMaterial3d(wood),
        Transform::from_xyz(0.0, (height - 0.04) / 2.0, 0.0),
        ClothCollider::cylinder(0.05, height - 0.04),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Sphere::new(0.35).mesh().uv(64, 32))),
        MeshMaterial3d(stone.clone()),
        Transform::from_xyz(-1.55, 0.35, 0.1),
        ClothCollider::ball(0.35),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Capsule3d::new(0.2, 0.7).mesh().longitudes(48).latitudes(24))),
        MeshMaterial3d(stone),
        Transform::from_xyz(1.55, 0.45, 0.1).with_rotation(Quat::from_rotation_z(1.2)),
        ClothCollider::capsule(0.2, 0.7),
    ));
    commands.spawn(ClothCollider::ground().with_friction(0.8));
}

fn cloths(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let sheets = [
        (
            FabricLook::Gingham(Color::srgb(0.94, 0.93, 0.89)),
            (Color::srgb(0.70, 0.10, 0.10), 6.0),
            ClothMaterial::COTTON,
            (1.8, 80),
            Vec3::new(0.0, TABLE.1 + DROP, 0.0),
        ),
        (
            FabricLook::Denim,
            (Color::srgb(0.14, 0.22, 0.42), 12.0),
            ClothMaterial::DENIM,
            (1.3, 56),
            Vec3::new(-1.55, 0.7 + DROP, 0.1),
        ),
        (
            FabricLook::Silk,
            (Color::srgb(0.06, 0.40, 0.40), 6.0),
            ClothMaterial::SILK,
            (1.3, 64),
            Vec3::new(1.55, 0.9 + DROP, 0.1),
        ),
    ];
    for (look, (color, repeats), cloth, (size, subdivisions), place) in sheets {
        let sheet = Plane3d::default().mesh().size(size, size).subdivisions(subdivisions).build().with_generated_tangents()?;
        commands.spawn((
            Mesh3d(meshes.add(sheet)),
            MeshMaterial3d(fabric(&mut images, &mut materials, look, color, repeats)),
            Transform::from_translation(place).with_rotation(Quat::from_rotation_y(0.3)),
            Cloth,
            cloth,
        ));
    }
    Ok(())
}

fn keys(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>, falling: Query<Entity, With<Cloth>>) {
    if keys.just_pressed(KeyCode::KeyR) {
        falling.iter().for_each(|cloth| commands.entity(cloth).despawn());
        commands.run_system_cached(cloths);
    }
    if keys.just_pressed(KeyCode::KeyD) {
        commands.run_system_cached(overlay);
    }
}

fn report(cloths: Query<&ClothReport>) -> String {
    let line = |report: &ClothReport| {
        format!("worst edge {:.3} of rest, {} particles touch a body\n", report.worst_edge, report.body_contacts)
    };
    cloths.iter().map(line).collect()
}
