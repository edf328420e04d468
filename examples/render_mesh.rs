//! A quilt of 14,400 vertices that follows a cloth of 441, beside that cloth.
//!
//! R lets both fall again.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use drape_scenes as scenes;
use drape_stage::{FabricLook, OrbitCamera, Stage, cut, fabric};

/// Side of both [m].
const SIDE: f32 = 1.25;
/// Vertices along a side of what is simulated, and of what is drawn.
const VERTICES: [u32; 2] = [21, 120];
/// Side of a pad of the quilt and how high it is [m].
const PAD: (f32, f32) = (0.125, 0.03);
/// Radius of the balls [m].
const BALL: f32 = 0.35;
/// How far the balls are from the middle [m].
const AWAY: f32 = 0.65;

fn main() -> AppExit {
    Stage::new("render mesh")
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.3, 0.0), 2.9).from(-0.35, 0.5))
        .hint("R: again")
        .report(report)
        .build()
        .add_plugins(ClothPlugin::default())
        .add_systems(Startup, (balls, cloths))
        .add_systems(Update, again)
        .run()
}

fn balls(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let stone = materials.add(Color::srgb(0.80, 0.78, 0.75));
    let ball = meshes.add(Sphere::new(BALL).mesh().uv(64, 32));
    for x in [-AWAY, AWAY] {
        commands.spawn((
            Mesh3d(ball.clone()),
            MeshMaterial3d(stone.clone()),
            Transform::from_xyz(x, BALL, 0.0),
            ClothCollider::ball(BALL),
        ));
    }
    commands.spawn(ClothCollider::ground().with_friction(0.8));
}

/// The quilt: padded between seams, in the place of the cloth.
fn quilt() -> Result<Mesh> {
    let height = |x: f32, z: f32| {
        let wave = |x: f32| (core::f32::consts::PI * x / PAD.0).sin().abs();
        0.2 * PAD.1 + PAD.1 * (wave(x) * wave(z)).sqrt()
    };
    let point = |u: f32, v: f32| {
        let (x, z) = (SIDE * (u - 0.5), SIDE * (v - 0.5));
        Vec3::new(x, height(x, z), z)
    };
    cut::cut(&scenes::grid(VERTICES[1], VERTICES[1], point), VERTICES[1], Vec2::splat(SIDE))
}

fn cloths(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let coarse = meshes.add(cut::square(VERTICES[0], SIDE)?);
    let fine = meshes.add(quilt()?);
    let linen = fabric(&mut images, &mut materials, FabricLook::Linen, Color::srgb(0.20, 0.34, 0.52), 5.0);
    let above = |x: f32| Transform::from_xyz(x, 2.0 * BALL + 0.1, 0.0);
    let cloth = || (Mesh3d(coarse.clone()), Cloth, ClothMaterial::WOOL);
    commands.spawn((cloth(), MeshMaterial3d(linen.clone()), above(-AWAY)));
    // Without a material it is not drawn.
    let simulated = commands.spawn((cloth(), above(AWAY), Visibility::default())).id();
    commands.spawn((Mesh3d(fine), MeshMaterial3d(linen), ClothRenderMesh { cloth: simulated }, ChildOf(simulated)));
    Ok(())
}

fn again(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>, cloths: Query<Entity, With<Cloth>>) {
    if keys.just_pressed(KeyCode::KeyR) {
        cloths.iter().for_each(|cloth| {
            commands.entity(cloth).insert(ClothReset);
        });
    }
}

fn report(cloths: Query<&ClothReport>) -> String {
    cloths.iter().map(|r| format!("worst edge {:.3} of rest, {} crossings\n", r.worst_edge, r.crossings)).collect()
}
