//! A ball swings into a gathered curtain, which can be dragged with the mouse.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use drape_scenes::curtain::{self, BALL, SIZE, SWING};
use drape_stage::{FabricLook, OrbitCamera, Stage, cut, fabric, hand};

/// Vertices per metre of the curtain's height.
const DETAIL: u32 = 48;
/// Where the middle of the rail is [m].
const RAIL: Vec3 = Vec3::new(0.0, 1.5, 0.0);

/// The ball on its rope.
#[derive(Component)]
struct Pendulum;

fn main() -> AppExit {
    Stage::new("curtain")
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.85, 0.0), 3.6).from(0.75, 0.15))
        .hint("Left: grab and drag the curtain")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), hand::plugin))
        .add_systems(Startup, (pendulum, hang))
        .add_systems(Update, swing)
        .run()
}

fn pendulum(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let (rope, ..) = SWING;
    let brass = materials.add(StandardMaterial {
        base_color: Color::srgb(0.80, 0.62, 0.30),
        metallic: 0.9,
        perceptual_roughness: 0.3,
        ..default()
    });
    commands.spawn((
        Pendulum,
        Mesh3d(meshes.add(Sphere::new(BALL - 0.004).mesh().uv(64, 32))),
        MeshMaterial3d(brass.clone()),
        Transform::from_translation(RAIL + curtain::ball(0.0).translation),
        ClothCollider::ball(BALL),
        children![(
            Mesh3d(meshes.add(Cylinder::new(0.006, rope - BALL))),
            MeshMaterial3d(brass.clone()),
            Transform::from_xyz(0.0, (rope + BALL) / 2.0, 0.0),
        )],
    ));
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.018, SIZE.0 + 0.2))),
        MeshMaterial3d(brass),
        Transform::from_translation(RAIL + Vec3::Y * 0.02).with_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_2)),
    ));
}

fn hang(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let source = curtain::mesh(DETAIL);
    let rows = source.positions.iter().take_while(|p| p.x <= source.positions[0].x).count() as u32;
    commands.spawn((
        Mesh3d(meshes.add(cut::cut(&source, rows, Vec2::new(1.4 * SIZE.0, SIZE.1))?)),
        MeshMaterial3d(fabric(&mut images, &mut materials, FabricLook::Linen, Color::srgb(0.62, 0.16, 0.14), 5.0)),
        Transform::from_translation(RAIL),
        Cloth,
        ClothDraggable::default(),
        ClothMaterial::COTTON,
        ClothPins::where_position(|p| p.y > -1.0e-4),
    ));
    Ok(())
}

fn swing(time: Res<Time>, mut balls: Query<&mut Transform, With<Pendulum>>) {
    for mut ball in &mut balls {
        let pose = curtain::ball(time.elapsed_secs());
        // The rope hangs from a hook above the rail.
        let lean = Quat::from_rotation_arc(Vec3::Y, (Vec3::new(0.05, SWING.0 - 0.8, 0.0) - pose.translation).normalize());
        *ball = cut::transform(&pose, RAIL).with_rotation(lean);
    }
}

fn report(cloths: Query<&ClothReport>) -> String {
    cloths.iter().map(|r| format!("worst edge {:.3} of rest, {} crossings\n", r.worst_edge, r.crossings)).collect()
}
