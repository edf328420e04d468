//! Every setting of a cloth while it moves: a flag, a table cloth, two sheets driven through each other, and the panel that
//! tunes them.
//!
//! Click a cloth, drag a slider; the wind in the world is an arrow that is dragged.
//!
//! | key | does |
//! |---|---|
//! | I | opens and closes the panel |
//! | space | pauses |

use bevy::prelude::*;
use bevy_drape::inspector::ClothInspectorPlugin;
use bevy_drape::prelude::*;
use drape_stage::{FabricLook, OrbitCamera, Stage, fabric};

/// Size of the flag [m] and height of its upper edge [m].
const FLAG: Vec2 = Vec2::new(1.2, 0.8);
const MAST: f32 = 2.3;
/// Radius and height of the table [m].
const TABLE: (f32, f32) = (0.45, 0.72);
/// Height of the stretched sheet [m]; how far the other is driven through it [m] and how long down and up take [s].
const STRETCHED: f32 = 0.9;
const DRIVE: (f32, f32) = (0.55, 4.0);
/// Wind at the start [m/s].
const WIND: Vec3 = Vec3::new(5.0, 0.0, 1.5);

fn main() -> AppExit {
    Stage::new("inspector")
        .camera(OrbitCamera::around(Vec3::new(1.3, 1.05, 0.0), 6.6).from(0.1, 0.2))
        .hint("click: pick a cloth   I: panel")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), ClothInspectorPlugin { open: true, ..default() }))
        .insert_resource(ClothGlobalWind::new(WIND))
        .add_systems(Startup, (flag, table, sheets))
        .add_systems(Update, drive)
        .run()
}

/// The sheet that is driven.
#[derive(Component)]
struct Driven;

fn flag(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let sheet = Plane3d::new(Vec3::Z, FLAG / 2.0).mesh().subdivisions(38).build().with_generated_tangents()?;
    let look = FabricLook::Stripes(Color::srgb(0.95, 0.94, 0.90));
    let steel = StandardMaterial { base_color: Color::srgb(0.75, 0.76, 0.78), metallic: 0.8, ..default() };
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.025, MAST + 0.1))),
        MeshMaterial3d(materials.add(steel)),
        Transform::from_xyz(-1.93, (MAST + 0.1) / 2.0, -0.6),
        ClothCollider::cylinder(0.025, MAST + 0.1),
    ));
    commands.spawn((
        Name::new("flag"),
        Mesh3d(meshes.add(sheet)),
        MeshMaterial3d(fabric(&mut images, &mut materials, look, Color::srgb(0.72, 0.08, 0.10), 2.0)),
        Transform::from_xyz(-1.9 + FLAG.x / 2.0, MAST - FLAG.y / 2.0, -0.6),
        Cloth,
        ClothMaterial::SILK,
        ClothPins::where_position(|p| p.x < -0.49 * FLAG.x),
    ));
    Ok(())
}

fn table(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let (radius, height) = TABLE;
    let at = Vec3::new(-0.55, 0.0, 0.5);
    let wood =
        materials.add(StandardMaterial { base_color: Color::srgb(0.55, 0.38, 0.24), perceptual_roughness: 0.5, ..default() });
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(radius - 0.015, 0.03).mesh().resolution(96))),
        MeshMaterial3d(wood.clone()),
        Transform::from_translation(at + Vec3::Y * (height - 0.02)),
        ClothCollider::cylinder(radius, 0.04),
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.05, height - 0.04))),
        MeshMaterial3d(wood),
        Transform::from_translation(at + Vec3::Y * (height - 0.04) / 2.0),
        ClothCollider::cylinder(0.05, height - 0.04),
    ));
    commands.spawn(ClothCollider::ground().with_friction(0.8));
    let sheet = Plane3d::default().mesh().size(1.3, 1.3).subdivisions(46).build().with_generated_tangents()?;
    let look = FabricLook::Gingham(Color::srgb(0.94, 0.93, 0.89));
    commands.spawn((
        Name::new("table cloth"),
        Mesh3d(meshes.add(sheet)),
        MeshMaterial3d(fabric(&mut images, &mut materials, look, Color::srgb(0.70, 0.10, 0.10), 6.0)),
        Transform::from_translation(at + Vec3::Y * (height + 0.05)).with_rotation(Quat::from_rotation_y(0.3)),
        Cloth,
        ClothMaterial::COTTON,
        // Indoors.
        ClothWind::still(),
    ));
    Ok(())
}

fn sheets(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let mut cotton = |color: Color| fabric(&mut images, &mut materials, FabricLook::Cotton, color, 6.0);
    let (cream, blue) = (cotton(Color::srgb(0.93, 0.90, 0.82)), cotton(Color::srgb(0.16, 0.30, 0.62)));
    let flat = Plane3d::default().mesh().size(0.9, 0.9).subdivisions(28).build().with_generated_tangents()?;
    let hanging = Plane3d::new(Vec3::Z, Vec2::new(0.25, 0.35)).mesh().subdivisions(28).build().with_generated_tangents()?;
    // Nothing keeps them apart: they are taken apart afterwards.
    let through = (ClothMaterial::COTTON, ClothCollision { contact: false, ..default() }, ClothWind::still());
    commands.spawn((
        Name::new("stretched sheet"),
        Mesh3d(meshes.add(flat)),
        MeshMaterial3d(cream),
        Transform::from_xyz(0.55, STRETCHED, -0.2),
        (Cloth, through.clone()),
        ClothPins::where_position(|p| p.x.abs() > 0.449 && p.z.abs() > 0.449),
    ));
    commands.spawn((
        Driven,
        Name::new("driven sheet"),
        Mesh3d(meshes.add(hanging)),
        MeshMaterial3d(blue),
        Transform::from_xyz(0.58, top(0.0), -0.18).with_rotation(Quat::from_rotation_y(0.35)),
        (Cloth, through),
        ClothPins::where_position(|p| p.y > 0.349),
    ));
    Ok(())
}

/// Height of the middle of the driven sheet after `t` [s].
fn top(t: f32) -> f32 {
    let (depth, period) = DRIVE;
    STRETCHED + 0.42 - 0.5 * depth * (1.0 - (t * core::f32::consts::TAU / period).cos())
}

fn drive(time: Res<Time>, mut driven: Query<&mut Transform, With<Driven>>) {
    for mut at in &mut driven {
        at.translation.y = top(time.elapsed_secs());
    }
}

fn report(cloths: Query<(&Name, &ClothReport)>) -> String {
    let line = |(name, report): (&Name, &ClothReport)| {
        format!("{name}: worst edge {:.3} of rest, {} crossings\n", report.worst_edge, report.crossings)
    };
    cloths.iter().map(line).collect()
}
