//! The two ends of a towel are turned against each other until it is a rope, and the rope a knot.

use bevy::prelude::*;
use bevy_drape::prelude::*;
use drape_scenes::twist;
use drape_stage::{FabricLook, OrbitCamera, Stage, cut, fabric};

/// Vertices per metre.
const DETAIL: u32 = 56;
/// Where the middle of the towel is [m].
const ORIGIN: Vec3 = Vec3::new(0.0, 1.0, 0.0);

/// A bar that holds an end, by its number.
#[derive(Component)]
struct Bar(usize);

fn main() -> AppExit {
    Stage::new("twist")
        .camera(OrbitCamera::around(Vec3::new(0.0, 0.9, 0.0), 2.6).from(0.35, 0.2))
        .report(report)
        .build()
        .add_plugins(ClothPlugin::default())
        .add_systems(Startup, towel)
        .add_systems(Update, turn)
        .run()
}

fn towel(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let steel = materials.add(StandardMaterial {
        base_color: Color::srgb(0.75, 0.76, 0.78),
        metallic: 0.8,
        perceptual_roughness: 0.35,
        ..default()
    });
    let bar = meshes.add(Cylinder::new(0.012, 0.42));
    let source = twist::mesh(DETAIL);
    let (left, right) = (source.positions[0], source.positions[source.positions.len() - 1]);
    let bars = [left.x, right.x].map(|x| {
        let end = twist::end_of(x).unwrap_or_default();
        let mut hold = commands.spawn((Bar(end), cut::transform(&twist::ends(0.0)[end], ORIGIN), Visibility::default()));
        hold.with_child((
            Mesh3d(bar.clone()),
            MeshMaterial3d(steel.clone()),
            Transform::from_xyz(x, 0.0, 0.0).with_rotation(Quat::from_rotation_x(core::f32::consts::FRAC_PI_2)),
        ));
        hold.id()
    });
    let rows = source.positions.iter().take_while(|p| p.x <= left.x).count() as u32;
    let look = FabricLook::Stripes(Color::srgb(0.93, 0.92, 0.88));
    commands.spawn((
        Mesh3d(meshes.add(cut::cut(&source, rows, Vec2::new(right.x - left.x, right.z - left.z))?)),
        MeshMaterial3d(fabric(&mut images, &mut materials, look, Color::srgb(0.12, 0.42, 0.46), 6.0)),
        Transform::from_translation(ORIGIN),
        Cloth,
        ClothMaterial::COTTON,
        ClothPins::where_position(|p| twist::end_of(p.x) == Some(0))
            .to(bars[0])
            .and(ClothPins::where_position(|p| twist::end_of(p.x) == Some(1)).to(bars[1])),
    ));
    Ok(())
}

fn turn(time: Res<Time>, mut bars: Query<(&Bar, &mut Transform)>) {
    let ends = twist::ends(time.elapsed_secs());
    bars.iter_mut().for_each(|(bar, mut to)| *to = cut::transform(&ends[bar.0], ORIGIN));
}

fn report(cloths: Query<&ClothReport>) -> String {
    cloths.iter().map(|r| format!("worst edge {:.3} of rest, {} crossings\n", r.worst_edge, r.crossings)).collect()
}
