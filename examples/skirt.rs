//! A skirt on a body of capsules that walks in a circle.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use drape_scenes::skirt::{self, LIMBS, Limb};
use drape_stage::{FabricLook, OrbitCamera, Stage, cut, fabric};

/// Vertices per metre.
const DETAIL: u32 = 48;
/// Where the scene's origin is: the height of the waist [m].
const ORIGIN: Vec3 = Vec3::new(0.0, 1.0, 0.0);

/// A limb, by its number.
#[derive(Component)]
struct Part(usize);

/// What is carried by the waist.
#[derive(Component)]
struct Waist;

fn main() -> AppExit {
    Stage::new("skirt")
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.75, 0.0), 4.2).from(0.3, 0.2))
        .report(report)
        .build()
        .add_plugins(ClothPlugin::default())
        .add_systems(Startup, (body, garment))
        .add_systems(Update, walk)
        .run()
}

fn body(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let wood =
        materials.add(StandardMaterial { base_color: Color::srgb(0.74, 0.58, 0.42), perceptual_roughness: 0.6, ..default() });
    for (i, (Limb { ends: [a, b], radius }, pose)) in LIMBS.into_iter().zip(skirt::limbs(0.0)).enumerate() {
        let along =
            Transform::from_translation((a + b) / 2.0).with_rotation(Quat::from_rotation_arc(Vec3::Y, (b - a).normalize()));
        commands.spawn((
            Part(i),
            cut::transform(&pose, ORIGIN),
            Visibility::default(),
            children![(
                Mesh3d(meshes.add(Capsule3d::new(radius - 0.004, a.distance(b)).mesh().longitudes(48).latitudes(24))),
                MeshMaterial3d(wood.clone()),
                along,
                ClothCollider::capsule(radius, a.distance(b)),
            )],
        ));
    }
    // The rest of the body touches no cloth.
    commands.spawn((
        Waist,
        cut::transform(&skirt::waist(0.0), ORIGIN),
        Visibility::default(),
        children![
            (
                Mesh3d(meshes.add(Capsule3d::new(0.125, 0.22).mesh().longitudes(48).latitudes(24))),
                MeshMaterial3d(wood.clone()),
                Transform::from_xyz(0.0, 0.18, 0.0),
            ),
            (Mesh3d(meshes.add(Sphere::new(0.1).mesh().uv(48, 24))), MeshMaterial3d(wood), Transform::from_xyz(0.0, 0.50, 0.0)),
        ],
    ));
}

fn garment(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let source = skirt::mesh(DETAIL);
    let rows = 1 + source.positions.windows(2).take_while(|p| p[1].y < p[0].y).count() as u32;
    let look = FabricLook::Gingham(Color::srgb(0.93, 0.90, 0.84));
    commands.spawn((
        Waist,
        Mesh3d(meshes.add(cut::cut(&source, rows, Vec2::new(1.75, 0.56))?)),
        MeshMaterial3d(fabric(&mut images, &mut materials, look, Color::srgb(0.15, 0.24, 0.48), 8.0)),
        cut::transform(&skirt::waist(0.0), ORIGIN),
        Cloth,
        ClothMaterial::COTTON,
        ClothPins::where_position(|p| p.y > -1.0e-4),
    ));
    Ok(())
}

fn walk(
    time: Res<Time>,
    mut parts: Query<(&Part, &mut Transform)>,
    mut waist: Query<&mut Transform, (With<Waist>, Without<Part>)>,
) {
    let limbs = skirt::limbs(time.elapsed_secs());
    parts.iter_mut().for_each(|(part, mut to)| *to = cut::transform(&limbs[part.0], ORIGIN));
    waist.iter_mut().for_each(|mut to| *to = cut::transform(&skirt::waist(time.elapsed_secs()), ORIGIN));
}

fn report(cloths: Query<&ClothReport>) -> String {
    cloths.iter().map(|r| format!("worst edge {:.3} of rest, {} crossings\n", r.worst_edge, r.crossings)).collect()
}
