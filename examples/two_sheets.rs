//! Two sheets driven through each other: the experiment of Wen et al. 2009.
//!
//! A sheet is stretched between its four corners; another hangs above, and its upper border is moved down and up again, so fast
//! that it goes right through. What crosses is drawn as a line, coloured by how it ends. Side by side (`--side-by-side`, or S):
//! the three states of the paper's figures 4 and 5 on sheets that start in each other, above with the method of 2006, below
//! with ours.
//!
//! | key | does |
//! |---|---|
//! | 1, 2, 3, 4 | history (1995), local gradient (2006), global gradient (2009), by end type |
//! | up, down | finer and coarser sheets, 10² to 100² |
//! | S | one pair that is driven, or the three states side by side |
//! | R | again |
//! | I | the panel that tunes every setting |
//! | space | pauses |

mod tangles;

use bevy::prelude::*;
use bevy_drape::inspector::ClothInspectorPlugin;
use bevy_drape::prelude::*;
use clap::Parser;
use drape_stage::{FabricLook, OrbitCamera, Stage, StageArgs, fabric};
use tangles::state::Most;
use tangles::three_states::{self, Prop};

/// Vertices along each side.
const SIZES: [u32; 7] = [10, 15, 20, 25, 30, 64, 100];
/// Height of the stretched sheet [m].
const HEIGHT: f32 = 0.75;
/// How far the hanging sheet is driven down [m], and how long it takes to go down and up again [s].
const DRIVE: (f32, f32) = (0.55, 3.0);

/// Two sheets driven through each other.
#[derive(Parser, Clone)]
struct Arguments {
    #[command(flatten)]
    stage: StageArgs,
    /// Show the three states of the paper, the method of 2006 above ours.
    #[arg(long)]
    side_by_side: bool,
}

fn main() -> AppExit {
    let arguments = Arguments::parse();
    Stage::from_args("two_sheets", arguments.stage)
        .camera(camera(arguments.side_by_side))
        .hint("1 to 4: method   up, down: size   S: side by side   R: again   I: panel")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), ClothInspectorPlugin::default(), tangles::plugin))
        .insert_resource(Choice { beside: arguments.side_by_side, ..default() })
        .add_systems(Startup, sheets)
        .add_systems(Update, (keys, drive, three_states::watch, describe).chain())
        .run()
}

/// What the keys choose.
#[derive(Resource)]
struct Choice {
    method: ClothUntanglingMethod,
    size: usize,
    beside: bool,
    /// When the drive began [s].
    since: f32,
}

impl Default for Choice {
    fn default() -> Self {
        Self { method: ClothUntanglingMethod::ByEndType, size: 4, beside: false, since: 0.0 }
    }
}

/// The sheet that is driven.
#[derive(Component)]
struct Driven;

fn camera(beside: bool) -> OrbitCamera {
    if beside {
        OrbitCamera::around(three_states::MIDDLE, 4.5).from(0.0, 0.3)
    } else {
        OrbitCamera::around(Vec3::new(0.0, 0.82, 0.0), 2.7).from(0.5, 0.3)
    }
}

fn sheets(
    mut commands: Commands,
    choice: Res<Choice>,
    mut gravity: ResMut<ClothGravity>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) -> Result {
    let mut cotton = |color: Color| fabric(&mut images, &mut materials, FabricLook::Cotton, color, 6.0);
    let (cream, blue) = (cotton(Color::srgb(0.93, 0.90, 0.82)), cotton(Color::srgb(0.16, 0.30, 0.62)));
    if choice.beside {
        *gravity = ClothGravity(Vec3::ZERO);
        three_states::spawn(&mut commands, &mut meshes, [cream, blue], SIZES[choice.size]);
        return Ok(());
    }
    *gravity = ClothGravity::default();
    let subdivisions = SIZES[choice.size] - 2;
    let flat = Plane3d::default().mesh().size(1.0, 1.0).subdivisions(subdivisions).build().with_generated_tangents()?;
    let hanging = Plane3d::new(Vec3::Z, Vec2::new(0.3, 0.4)).mesh().subdivisions(subdivisions).build();
    // As in the paper, nothing keeps the sheets from crossing: they are only taken apart.
    let untangle = (
        ClothUntangling::default().with_method(choice.method),
        ClothCollision { self_collision: false, contact: false, ..default() },
    );
    commands.spawn((
        Name::new("stretched sheet"),
        Most::default(),
        Mesh3d(meshes.add(flat)),
        MeshMaterial3d(cream),
        Transform::from_xyz(0.0, HEIGHT, 0.0),
        (Cloth, ClothMaterial::COTTON, untangle),
        ClothPins::where_position(|p| p.x.abs() > 0.499 && p.z.abs() > 0.499),
    ));
    commands.spawn((
        Name::new("driven sheet"),
        Driven,
        Mesh3d(meshes.add(hanging.with_generated_tangents()?)),
        MeshMaterial3d(blue),
        Transform::from_xyz(0.03, top(0.0), 0.02).with_rotation(Quat::from_rotation_y(0.35)),
        (Cloth, ClothMaterial::COTTON, untangle),
        ClothPins::where_position(|p| p.y > 0.399),
    ));
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
    spawned: Query<Entity, Or<(With<Cloth>, With<Prop>)>>,
    mut eye: Single<&mut OrbitCamera>,
) {
    let digits = [KeyCode::Digit1, KeyCode::Digit2, KeyCode::Digit3, KeyCode::Digit4];
    let mut again = keys.just_pressed(KeyCode::KeyR);
    for (key, method) in digits.into_iter().zip(ClothUntanglingMethod::ALL.iter().copied()) {
        if keys.just_pressed(key) {
            (choice.method, again) = (method, true);
        }
    }
    if keys.just_pressed(KeyCode::KeyS) {
        (choice.beside, again) = (!choice.beside, true);
        **eye = camera(choice.beside);
    }
    if keys.just_pressed(KeyCode::ArrowUp) {
        (choice.size, again) = ((choice.size + 1).min(SIZES.len() - 1), true);
    }
    if keys.just_pressed(KeyCode::ArrowDown) {
        (choice.size, again) = (choice.size.saturating_sub(1), true);
    }
    if again {
        choice.since = time.elapsed_secs();
        spawned.iter().for_each(|entity| commands.entity(entity).despawn());
        commands.run_system_cached(sheets);
    }
}

fn describe(choice: Res<Choice>, pair: Query<(&ClothReport, &Most)>, mut panel: Query<&mut Text, With<tangles::Panel>>) {
    for mut text in &mut panel {
        let words = if choice.beside { String::new() } else { words(&choice, &pair, tangles::line) };
        text.set_if_neq(Text(words));
    }
}

fn words(choice: &Choice, pair: &Query<(&ClothReport, &Most)>, line: fn(&ClothReport, &Most) -> String) -> String {
    let n = SIZES[choice.size];
    pair.iter().map(|(report, most)| format!("{:?}, {n}x{n}: {}", choice.method, line(report, most))).collect()
}

fn report(choice: Res<Choice>, pair: Query<(&ClothReport, &Most)>, cells: Query<&Text, With<three_states::Cell>>) -> String {
    if choice.beside { three_states::report(cells) } else { words(&choice, &pair, tangles::line_with_time) }
}
