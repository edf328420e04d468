//! The same table cloth in six fabrics; with `--curtains`, the same curtain. All look alike, so that only how they fall tells
//! them apart.
//!
//! R lets the table cloths fall again.

use bevy::prelude::*;
use bevy_drape::PositionPredicate;
use bevy_drape::lab::{curtain, rate};
use bevy_drape::prelude::*;
use clap::Parser;
use drape_stage::{FabricLook, OrbitCamera, Stage, StageArgs, fabric};

/// The same table cloth, or curtain, in six fabrics.
#[derive(Parser, Clone)]
struct Arguments {
    #[command(flatten)]
    stage: StageArgs,
    /// Curtains in place of table cloths.
    #[arg(long)]
    curtains: bool,
}

/// From limp to stiff.
const FABRICS: [&str; 6] = ["viscose", "silk", "wool", "leather", "cotton", "denim"];
/// Radius and height of a table [m].
const TABLE: (f32, f32) = (0.16, 0.36);
/// Side of a table cloth and its edges [m].
const CLOTH: (f32, f32) = (0.6, 0.01);
/// Distance between two tables, and between two curtains [m].
const APART: (f32, f32) = (0.68, 1.05);
/// Width and height of a curtain, its edges, and how high it hangs [m].
const CURTAIN: (f32, f32, f32) = (1.0, 0.025, 1.15);
/// How long a curtain is drawn, from its whole width to that of [`GATHERED`] [s].
const DRAWN: f32 = 2.0;
/// How far hooks stand off the plane of the rail [m]: a sheet in one plane has no side to fold to.
const OFF: f32 = 0.01;
/// How fast that changes along the rail [rad/m]: not in step with the hooks, so that no two stand alike.
const UNEVEN: f32 = 40.0;
/// Width of a curtain that is drawn over that of its cloth.
const GATHERED: f32 = 0.7;

/// A hook on a rail: where it is while the curtain is spread, from the middle [m], and that middle [m].
#[derive(Component)]
struct Hook(f32, f32);

fn main() -> AppExit {
    let Arguments { stage, curtains } = Arguments::parse();
    let camera = if curtains {
        OrbitCamera::around(Vec3::new(0.1, 0.62, 0.0), 6.6).from(0.15, 0.12)
    } else {
        OrbitCamera::around(Vec3::new(0.0, 0.2, 0.05), 2.7).from(0.0, 0.6)
    };
    let mut app = Stage::from_args("fabrics", stage).camera(camera).hint("R: again").report(report).build();
    app.add_plugins(ClothPlugin::default());
    if curtains {
        app.add_systems(Startup, hang).add_systems(Update, draw);
    } else {
        app.add_systems(Startup, (tables, lay)).add_systems(Update, again);
    }
    app.run()
}

/// Where the `k`th table stands: three in a row, the limp ones behind [m].
fn table(k: usize) -> (f32, f32) {
    let columns = FABRICS.len() / 2;
    (((k % columns) as f32 - 1.0) * APART.0, ((k / columns) as f32 - 0.5) * APART.0)
}

fn tables(mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>, mut materials: ResMut<Assets<StandardMaterial>>) {
    let wood =
        materials.add(StandardMaterial { base_color: Color::srgb(0.55, 0.38, 0.24), perceptual_roughness: 0.5, ..default() });
    let (radius, height) = TABLE;
    // What is seen ends a little before what is felt: a sharp rim shows between the particles of a cloth.
    let top = meshes.add(Cylinder::new(radius - 0.01, 0.02).mesh().resolution(96));
    let leg = meshes.add(Cylinder::new(0.02, height - 0.02));
    for k in 0..FABRICS.len() {
        let (x, z) = table(k);
        commands.spawn((
            Mesh3d(top.clone()),
            MeshMaterial3d(wood.clone()),
            Transform::from_xyz(x, height - 0.012, z),
            ClothCollider::cylinder(radius, 0.02),
        ));
        commands.spawn((
            Mesh3d(leg.clone()),
            MeshMaterial3d(wood.clone()),
            Transform::from_xyz(x, 0.5 * (height - 0.02), z),
            ClothCollider::cylinder(0.02, height - 0.02),
        ));
    }
    commands.spawn(ClothCollider::ground());
}

fn lay(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let (side, edge) = CLOTH;
    let cells = (side / edge).round() as u32;
    let sheet = Plane3d::default().mesh().size(side, side).subdivisions(cells - 1).build().with_generated_tangents()?;
    let sheet = meshes.add(sheet);
    let look = fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.55, 0.60, 0.66), 12.0);
    for (k, name) in FABRICS.into_iter().enumerate() {
        let (x, z) = table(k);
        commands.spawn((
            Mesh3d(sheet.clone()),
            MeshMaterial3d(look.clone()),
            Transform::from_xyz(x, TABLE.1 + 0.02, z).with_rotation(Quat::from_rotation_y(0.2)),
            Cloth,
            ClothMaterial { thickness: 0.004, ..ClothMaterial::preset(name).unwrap_or_default() },
            ClothSolver { substep_rate: rate(edge), ..default() },
            Name::new(name),
        ));
    }
    Ok(())
}

fn again(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>, falling: Query<Entity, With<Cloth>>) {
    if keys.just_pressed(KeyCode::KeyR) {
        falling.iter().for_each(|cloth| commands.entity(cloth).despawn());
        commands.run_system_cached(lay);
    }
}

fn hang(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let (side, edge, height) = CURTAIN;
    let cells = (side / edge).round() as u32;
    let sheet = Plane3d::new(Vec3::Z, Vec2::splat(0.5 * side)).mesh().subdivisions(cells - 1).build();
    let sheet = meshes.add(sheet.with_generated_tangents()?);
    let look = fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.55, 0.60, 0.66), 12.0);
    let brass = materials.add(StandardMaterial { base_color: Color::srgb(0.80, 0.62, 0.30), metallic: 0.9, ..default() });
    commands.spawn((
        Mesh3d(meshes.add(Cylinder::new(0.01, FABRICS.len() as f32 * APART.1))),
        MeshMaterial3d(brass),
        Transform::from_xyz(0.0, height + 0.01, 0.0).with_rotation(Quat::from_rotation_z(core::f32::consts::FRAC_PI_2)),
    ));
    for (k, name) in FABRICS.into_iter().enumerate() {
        let middle = (k as f32 - 0.5 * (FABRICS.len() - 1) as f32) * APART.1;
        let hooks = (0..curtain::HOOKS).map(|hook| {
            // On the nearest vertex, so that all are held alike.
            let cell = (hook as f32 / (curtain::HOOKS - 1) as f32 * cells as f32).round();
            let x = (cell / cells as f32 - 0.5) * side;
            let held =
                ClothPinSelect::Position(PositionPredicate::new(move |p| p.y > 0.499 * side && (p.x - x).abs() < 0.4 * edge));
            let entity = commands.spawn((Hook(x, middle), Transform::from_xyz(middle + x, height, 0.0))).id();
            ClothPinSet { select: held, weight: 1.0, target: Some(entity) }
        });
        let pins = ClothPins { sets: hooks.collect(), ..default() };
        commands.spawn((
            Mesh3d(sheet.clone()),
            MeshMaterial3d(look.clone()),
            Transform::from_xyz(middle, height - 0.5 * side, 0.0),
            Cloth,
            ClothMaterial::preset(name).unwrap_or_default(),
            ClothSolver { substep_rate: rate(edge), ..default() },
            pins,
            Name::new(name),
        ));
    }
    Ok(())
}

/// Draws the curtains.
fn draw(time: Res<Time>, mut hooks: Query<(&Hook, &mut Transform)>) {
    let done = (time.elapsed_secs() / DRAWN).min(1.0);
    for (&Hook(x, middle), mut transform) in &mut hooks {
        transform.translation.x = middle + x * (1.0 - done * (1.0 - GATHERED));
        transform.translation.z = done * OFF * (UNEVEN * x).sin();
    }
}

fn report(cloths: Query<(&Name, &ClothReport)>) -> String {
    cloths.iter().map(|(name, report)| format!("{name}: worst edge {:.3} of rest\n", report.worst_edge)).collect()
}
