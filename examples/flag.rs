//! Flags in a gusty wind.
//!
//! Each is held along one side by a pole, in the wind of `ClothGlobalWind`; a gust is a few metres wide, so it passes from one
//! to the next.
//!
//! | key | does |
//! |---|---|
//! | up, down | more wind, less wind |
//! | I | the panel that tunes every setting |

use bevy::prelude::*;
use bevy_drape::inspector::ClothInspectorPlugin;
use bevy_drape::prelude::*;
use drape_stage::{FabricLook, OrbitCamera, Stage, fabric};

/// Size of a flag [m].
const SIZE: Vec2 = Vec2::new(1.5, 1.0);
/// Height of the upper edge [m].
const HEIGHT: f32 = 2.6;
/// Wind at the start [m/s].
const WIND: Vec3 = Vec3::new(7.0, 0.0, 1.5);
/// What a key press adds to the wind (factor).
const STEP: f32 = 1.15;

fn main() -> AppExit {
    Stage::new("flag")
        .camera(OrbitCamera::around(Vec3::new(0.5, 1.7, 0.0), 6.6).from(-0.12, 0.08))
        .hint("up, down: wind   I: panel   click: pick a flag for it")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), ClothInspectorPlugin::default()))
        .insert_resource(ClothGlobalWind { turbulence: 0.35, ..ClothGlobalWind::new(WIND) })
        .add_systems(Startup, setup)
        .add_systems(Update, keys)
        .run()
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let sheet = Plane3d::new(Vec3::Z, SIZE / 2.0).mesh().subdivisions(48).build().with_generated_tangents()?;
    let sheet = meshes.add(sheet);
    let pole = meshes.add(Cylinder::new(0.025, HEIGHT + 0.1));
    let steel = materials.add(StandardMaterial {
        base_color: Color::srgb(0.75, 0.76, 0.78),
        metallic: 0.8,
        perceptual_roughness: 0.35,
        ..default()
    });
    let flags = [
        (
            "silk flag",
            FabricLook::Stripes(Color::srgb(0.95, 0.94, 0.90)),
            Color::srgb(0.72, 0.08, 0.10),
            2.0,
            ClothMaterial::SILK,
            (-2.0, -0.5),
        ),
        ("cotton flag", FabricLook::Cotton, Color::srgb(0.95, 0.62, 0.08), 8.0, ClothMaterial::COTTON, (-0.1, 0.0)),
        ("denim flag", FabricLook::Denim, Color::srgb(0.10, 0.20, 0.45), 16.0, ClothMaterial::DENIM, (1.8, -0.5)),
    ];
    for (name, look, color, repeats, cloth, (x, z)) in flags {
        let cloth_material = fabric(&mut images, &mut materials, look, color, repeats);
        commands.spawn((
            Mesh3d(pole.clone()),
            MeshMaterial3d(steel.clone()),
            Transform::from_xyz(x - 0.03, (HEIGHT + 0.1) / 2.0, z),
            ClothCollider::cylinder(0.025, HEIGHT + 0.1),
        ));
        commands.spawn((
            Mesh3d(sheet.clone()),
            MeshMaterial3d(cloth_material),
            Transform::from_xyz(x + SIZE.x / 2.0, HEIGHT - SIZE.y / 2.0, z),
            Name::new(name),
            Cloth,
            cloth,
            ClothPins::where_position(|p| p.x < -0.49 * SIZE.x),
        ));
    }
    Ok(())
}

fn keys(keys: Res<ButtonInput<KeyCode>>, mut wind: ResMut<ClothGlobalWind>) {
    if keys.just_pressed(KeyCode::ArrowUp) {
        wind.velocity *= STEP;
    }
    if keys.just_pressed(KeyCode::ArrowDown) {
        wind.velocity /= STEP;
    }
}

fn report(cloths: Query<(&ClothReport, &ClothMaterial)>) -> String {
    let line = |(report, material): (&ClothReport, &ClothMaterial)| {
        format!("{:.2} kg/m2: worst edge {:.3} of rest, {} substeps\n", material.density, report.worst_edge, report.substeps)
    };
    cloths.iter().map(line).collect()
}
