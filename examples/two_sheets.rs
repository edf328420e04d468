//! Two sheets driven through each other: the experiment of Wen et al. 2009.
//!
//! A sheet is stretched between its four corners; another hangs above, and its upper border is moved down and up again, so fast that it goes
//! right through. What crosses is drawn as a coloured line. On the left the method of 2006, on the right the one that is chosen.
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3, 4 | history (1995), local gradient (2006), global gradient (2009), by end type |
//! | up, down | finer and coarser sheets, 10² to 100² |
//! | B | one pair of sheets, or two side by side |
//! | R | again |
//! | space | pauses |

mod stage;
mod tangles;

use bevy::prelude::*;
use bevy_drape::prelude::*;
use stage::{FabricLook, OrbitCamera, Stage, fabric};

/// Vertices along each side.
const SIZES: [u32; 7] = [10, 15, 20, 25, 30, 64, 100];
/// Height of the stretched sheet [m].
const HEIGHT: f32 = 0.9;
/// How far the hanging sheet is driven down [m], and how long it takes to go down and up again [s].
const DRIVE: (f32, f32) = (0.55, 3.0);
/// Distance between the two pairs [m].
const APART: f32 = 1.5;

fn main() -> AppExit {
    Stage::new("two_sheets")
        .camera(OrbitCamera::around(Vec3::new(0.0, 1.05, 0.0), 4.2).from(0.5, 0.3))
        .hint("1 to 4: method    up, down: size    B: side by side    R: again    space: pause")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), tangles::plugin))
        .init_resource::<Choice>()
        .add_systems(Startup, sheets)
        .add_systems(Update, (keys, drive, describe).chain())
        .run()
}

/// What the keys choose.
#[derive(Resource)]
struct Choice {
    method: UntangleMethod,
    size: usize,
    beside: bool,
    /// When the drive began [s].
    since: f32,
}

impl Default for Choice {
    fn default() -> Self {
        Self { method: UntangleMethod::ByEndType, size: 4, beside: true, since: 0.0 }
    }
}

/// The sheet that is driven, and its pair.
#[derive(Component)]
struct Driven;

fn sheets(
    mut commands: Commands,
    choice: Res<Choice>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let subdivisions = SIZES[choice.size] - 2;
    let flat = Plane3d::default().mesh().size(1.0, 1.0).subdivisions(subdivisions).build().with_generated_tangents()?;
    let hanging = Plane3d::new(Vec3::Z, Vec2::new(0.3, 0.4)).mesh().subdivisions(subdivisions).build();
    let (flat, hanging) = (meshes.add(flat), meshes.add(hanging.with_generated_tangents()?));
    let cream = fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.93, 0.90, 0.82), 6.0);
    let blue = fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.16, 0.30, 0.62), 6.0);
    let pairs = if choice.beside {
        vec![(UntangleMethod::LocalGradient, -0.5 * APART), (choice.method, 0.5 * APART)]
    } else {
        vec![(choice.method, 0.0)]
    };
    for (method, x) in pairs {
        let untangle = Untangle::default().with_method(method);
        commands.spawn((
            Name::new(format!("{method:?}")),
            Mesh3d(flat.clone()),
            MeshMaterial3d(cream.clone()),
            Transform::from_xyz(x, HEIGHT, 0.0),
            (Cloth, ClothMaterial::COTTON, untangle),
            ClothPins::where_position(|p| p.x.abs() > 0.499 && p.z.abs() > 0.499),
        ));
        commands.spawn((
            Driven,
            Mesh3d(hanging.clone()),
            MeshMaterial3d(blue.clone()),
            Transform::from_xyz(x + 0.03, top(0.0), 0.02).with_rotation(Quat::from_rotation_y(0.35)),
            (Cloth, ClothMaterial::COTTON, untangle),
            ClothPins::where_position(|p| p.y > 0.399),
        ));
    }
    Ok(())
}

/// Height of the middle of the hanging sheet after `t` [s].
fn top(t: f32) -> f32 {
    let (depth, period) = DRIVE;
    HEIGHT + 0.42 - 0.5 * depth * (1.0 - (t * core::f32::consts::TAU / period).cos())
}

fn drive(time: Res<Time>, choice: Res<Choice>, mut driven: Query<&mut Transform, With<Driven>>) {
    for mut at in &mut driven {
        at.translation.y = top(time.elapsed_secs() - choice.since);
    }
}

fn keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    time: Res<Time>,
    mut choice: ResMut<Choice>,
    cloths: Query<Entity, With<Cloth>>,
) {
    let digits = [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3, KeyCode::Digit4];
    let mut again = keys.just_pressed(KeyCode::KeyR);
    for (key, method) in digits.into_iter().zip(UntangleMethod::ALL) {
        if keys.just_pressed(key) {
            (choice.method, again) = (method, true);
        }
    }
    if keys.just_pressed(KeyCode::KeyB) {
        (choice.beside, again) = (!choice.beside, true);
    }
    if keys.just_pressed(KeyCode::ArrowUp) {
        (choice.size, again) = ((choice.size + 1).min(SIZES.len() - 1), true);
    }
    if keys.just_pressed(KeyCode::ArrowDown) {
        (choice.size, again) = (choice.size.saturating_sub(1), true);
    }
    if again {
        choice.since = time.elapsed_secs();
        cloths.iter().for_each(|cloth| commands.entity(cloth).despawn());
        commands.run_system_cached(sheets);
    }
}

fn describe(choice: Res<Choice>, pairs: Query<(&Name, &ClothReport)>, mut panel: Query<&mut Text, With<tangles::Panel>>) {
    for mut text in &mut panel {
        text.0 = words(&choice, &pairs);
    }
}

fn words(choice: &Choice, pairs: &Query<(&Name, &ClothReport)>) -> String {
    let n = SIZES[choice.size];
    pairs.iter().map(|(name, report)| format!("{name}, {n}x{n}: {}\n", tangles::line(report))).collect()
}

fn report(choice: Res<Choice>, pairs: Query<(&Name, &ClothReport)>) -> String {
    words(&choice, &pairs)
}
