//! Sheets that get into each other, or start in themselves, and how they come apart, in slow motion.
//!
//! Two sheets that are clean are put into each other: eight tangles. What crosses is drawn as a line, coloured by how it ends;
//! while the last clean shape is held in place of the tangled one, as it would be in a game, it is shown as a ghost. Seven more
//! start tangled, in themselves: there is no clean shape to hold.
//!
//! | key | does |
//! |---|---|
//! | 1 to 8 | one tangle: dent, deep dent, corner, border overlap, strip stab, tilted strip, full cut, waves |
//! | F1 to F7 | one contour unit: closed, eight, LL, BBII, BIBI, BLI, cross |
//! | 0, 9 | all tangles, all units |
//! | H, L, G, E | history (1995), local gradient (2006), global gradient (2009), by end type |
//! | P | holds for two frames, as by default, or until clean, as in the paper |
//! | S | slow motion or real time |
//! | R, space | again, pauses |

mod tangles;

use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::solver::rest::SourceMesh;
use clap::Parser;
use drape_scenes::{Tangle, Unit};
use drape_stage::{FabricLook, OrbitCamera, Stage, StageArgs, fabric};
use tangles::label::{Label, label};
use tangles::state::Most;
use tangles::{ghost, grid_mesh, upright};

/// Vertices along each side of a sheet.
const SIZE: u32 = 30;
/// Time between two frames that are simulated, in slow motion [s].
const SLOW: f32 = 0.2;
/// How long two sheets are apart before they are put into each other, or one is left in itself [s], and how far apart they are
/// [m].
const APART: (f32, f32) = (0.07, 0.03);
/// Distance between columns and between rows when all are shown [m].
const GRID: (f32, f32) = (1.5, 1.36);
/// Height of the lower row [m].
const LOW: f32 = 0.72;
/// Turn of everything about the vertical, so that no strip is seen from its edge [rad].
const TURN: f32 = -0.5;

/// Sheets that get into each other, and how they come apart.
#[derive(Parser, Clone)]
struct Arguments {
    #[command(flatten)]
    stage: StageArgs,
    /// Which tangle to show first, 1 to 8; 0 shows all.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=8))]
    tangle: u32,
    /// Which contour unit to show first instead, 1 to 7; 0 shows all.
    #[arg(long, value_parser = clap::value_parser!(u32).range(0..=7))]
    unit: Option<u32>,
}

/// What is shown.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shown {
    Tangles,
    Tangle(usize),
    Units,
    Unit(usize),
}

impl Shown {
    fn is_one(self) -> bool {
        matches!(self, Self::Tangle(_) | Self::Unit(_))
    }
}

/// What the keys choose.
#[derive(Resource)]
struct Choice {
    shown: Shown,
    method: ClothUntanglingMethod,
    policy: ClothSkipPolicy,
    slow: bool,
}

fn main() -> AppExit {
    let arguments = Arguments::parse();
    let shown = match (arguments.unit, arguments.tangle) {
        (Some(0), _) => Shown::Units,
        (Some(k), _) => Shown::Unit(k as usize - 1),
        (None, 0) => Shown::Tangles,
        (None, k) => Shown::Tangle(k as usize - 1),
    };
    let choice = Choice { shown, method: ClothUntanglingMethod::ByEndType, policy: ClothSkipPolicy::Bounded, slow: true };
    Stage::from_args("tangled", arguments.stage)
        .camera(camera(shown))
        .hint("0 to 8: tangle   9, F1 to F7: unit   H L G E: method   P: hold   S: slow motion   R: again")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), tangles::plugin))
        .insert_resource(ClothGravity(Vec3::ZERO))
        .insert_resource(choice)
        .add_observer(ghost::banish)
        .add_systems(Startup, spawn)
        .add_systems(Update, (keys, pace, begin, describe, ghost::conjure).chain())
        .add_systems(PostUpdate, ghost::appear.after(ClothSystems::Evaluate).before(ClothSystems::Sync))
        .run()
}

fn camera(shown: Shown) -> OrbitCamera {
    if shown.is_one() {
        OrbitCamera::around(Vec3::new(0.0, 0.85, 0.0), 2.9).from(0.0, 0.25)
    } else {
        OrbitCamera::around(Vec3::new(0.0, 1.30, 0.0), 6.1).from(0.0, 0.25)
    }
}

/// What happens once a sheet was shown as it is.
#[derive(Component)]
enum Next {
    /// It is put into another [m].
    Push(Vec3),
    /// It is taken apart.
    Untangle(ClothUntangling),
}

/// What a cloth is called, and its words.
#[derive(Component)]
struct Title(&'static str, Entity);

fn spawn(
    mut commands: Commands,
    choice: Res<Choice>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let mut cotton = |color: Color| fabric(&mut images, &mut materials, FabricLook::Cotton, color, 6.0);
    let (cream, red) = (cotton(Color::srgb(0.93, 0.90, 0.82)), cotton(Color::srgb(0.70, 0.18, 0.14)));
    let one = choice.shown.is_one();
    let place = |k: usize| {
        let (column, row) = ((k % 4) as f32, (k / 4) as f32);
        if one { Vec3::new(0.0, 0.85, 0.0) } else { Vec3::new(GRID.0 * (column - 1.5), LOW + GRID.1 * (1.0 - row), 0.0) }
    };
    let untangle = ClothUntangling::default().with_method(choice.method);
    let skip = ClothSkipFrame { policy: choice.policy, ..default() };
    let mut spawn = |source: &SourceMesh, material: &Handle<StandardMaterial>, at: Vec3| {
        let place = Transform::from_translation(at).with_rotation(Quat::from_rotation_y(TURN) * upright());
        let look = (Mesh3d(meshes.add(grid_mesh(source))), MeshMaterial3d(material.clone()), place);
        commands.spawn((look, Cloth, ClothMaterial::COTTON, untangle, skip)).id()
    };
    let mut titled = Vec::new();
    for (k, tangle) in Tangle::ALL.into_iter().enumerate().filter(|(k, _)| match choice.shown {
        Shown::Tangles => true,
        Shown::Tangle(only) => only == *k,
        Shown::Units | Shown::Unit(_) => false,
    }) {
        let [first, second] = tangle.meshes(SIZE);
        let above = Vec3::Y * (APART.1 + top(&first) - bottom(&second));
        // Both together stand in the middle.
        let at = place(k) - Quat::from_rotation_y(TURN) * upright() * middle(&[&first, &second]);
        titled.push((tangle.name(), spawn(&first, &cream, at), None, place(k)));
        titled.push(("", spawn(&second, &red, at + above), Some(Next::Push(-above)), place(k)));
    }
    for (k, unit) in Unit::ALL.into_iter().enumerate().filter(|(k, _)| match choice.shown {
        Shown::Units => true,
        Shown::Unit(only) => only == *k,
        Shown::Tangles | Shown::Tangle(_) => false,
    }) {
        titled.push((unit.name(), spawn(&unit.mesh(SIZE / 2), &cream, place(k)), Some(Next::Untangle(untangle)), place(k)));
    }
    for (name, cloth, next, at) in titled {
        if !name.is_empty() {
            // What stands in the lower row reaches far up.
            let below = if !one && next.is_none() && at.y > LOW { 0.27 } else { 0.55 };
            let words = commands.spawn(label(at - below * Vec3::Y, name, if one { 15.0 } else { 12.0 })).id();
            commands.entity(cloth).insert((Title(name, words), Most::default()));
        }
        if let Some(Next::Untangle(_)) = next {
            let wait = ClothUntangling { iterations: 0, ..untangle };
            commands.entity(cloth).insert((ClothCollision { self_collision: true, ..default() }, wait));
        }
        if let Some(next) = next {
            commands.entity(cloth).insert(next);
        }
    }
}

/// The middle of sheets, at their own height [m].
fn middle(sheets: &[&SourceMesh]) -> Vec3 {
    let all = sheets.iter().flat_map(|sheet| &sheet.positions);
    let (low, high) = all.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    (0.5 * (low + high)).with_z(0.0)
}

/// Height of the highest vertex [m].
fn top(mesh: &SourceMesh) -> f32 {
    mesh.positions.iter().map(|p| p.z).fold(f32::NEG_INFINITY, f32::max)
}

/// Height of the lowest vertex [m].
fn bottom(mesh: &SourceMesh) -> f32 {
    mesh.positions.iter().map(|p| p.z).fold(f32::INFINITY, f32::min)
}

/// Puts sheets into each other, and lets go of those that are in themselves.
fn begin(
    mut commands: Commands,
    time: Res<Time>,
    cloths: Query<(Entity, &Next, &ClothReport, &mut ClothParticles, &mut ClothUntangling)>,
) {
    for (cloth, next, report, mut particles, mut untangle) in cloths {
        // What is shown between two simulated frames is not looked at.
        if report.time < APART.0 || time.delta_secs() == 0.0 {
            continue;
        }
        match next {
            Next::Push(by) => {
                let state = particles.state_mut();
                state.positions.iter_mut().chain(&mut state.previous).for_each(|p| *p += by.extend(0.0));
            }
            Next::Untangle(settings) => *untangle = *settings,
        }
        commands.entity(cloth).remove::<Next>();
    }
}

fn keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    mut choice: ResMut<Choice>,
    spawned: Query<Entity, Or<(With<Cloth>, With<Label>)>>,
    mut eye: Single<&mut OrbitCamera>,
) {
    use KeyCode::*;
    let one = choice.shown.is_one();
    let mut again = keys.just_pressed(KeyR);
    let tangles = [Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8].into_iter().enumerate();
    let units = [F1, F2, F3, F4, F5, F6, F7].into_iter().enumerate();
    let shown = tangles
        .map(|(k, key)| (key, Shown::Tangle(k)))
        .chain(units.map(|(k, key)| (key, Shown::Unit(k))))
        .chain([(Digit0, Shown::Tangles), (Digit9, Shown::Units)]);
    for (_, shown) in shown.filter(|(key, _)| keys.just_pressed(*key)) {
        (choice.shown, again) = (shown, true);
    }
    for (key, method) in [KeyH, KeyL, KeyG, KeyE].into_iter().zip(ClothUntanglingMethod::ALL.iter().copied()) {
        if keys.just_pressed(key) {
            (choice.method, again) = (method, true);
        }
    }
    if keys.just_pressed(KeyP) {
        let bounded = choice.policy == ClothSkipPolicy::Bounded;
        (choice.policy, again) =
            (if bounded { ClothSkipPolicy::UntilClean { max: 600 } } else { ClothSkipPolicy::Bounded }, true);
    }
    if keys.just_pressed(KeyS) {
        choice.slow = !choice.slow;
    }
    if again {
        if one != choice.shown.is_one() {
            **eye = camera(choice.shown);
        }
        spawned.iter().for_each(|entity| commands.entity(entity).despawn());
        commands.run_system_cached(spawn);
    }
}

/// Untangling goes by frames: slow motion lets time stand still between them.
fn pace(choice: Res<Choice>, real: Res<Time<Real>>, mut time: ResMut<Time<Virtual>>, mut waited: Local<f32>) {
    // A picture is taken between two steps: what is due then waits for the next one.
    if real.delta_secs() == 0.0 {
        return;
    }
    *waited += real.delta_secs();
    let due = *waited > SLOW - 0.001;
    if due {
        *waited = 0.0;
    }
    time.set_relative_speed(if due || !choice.slow { 1.0 } else { 0.0 });
}

fn describe(
    choice: Res<Choice>,
    cloths: Query<(&Title, &ClothReport)>,
    mut labels: Query<&mut Text, With<Label>>,
    mut panel: Query<&mut Text, (With<tangles::Panel>, Without<Label>)>,
) {
    for (Title(name, words), report) in &cloths {
        if let Ok(mut text) = labels.get_mut(*words) {
            let held = if report.held { ", held" } else { "" };
            text.set_if_neq(Text(format!("{name}\n{} crossings{held}", report.crossings)));
        }
    }
    for mut text in &mut panel {
        let hold = if choice.policy == ClothSkipPolicy::Bounded { "held for 2 frames" } else { "held until clean" };
        let pace = if choice.slow { format!("{:.0} frames a second", 1.0 / SLOW) } else { "real time".into() };
        text.set_if_neq(Text(format!("{:?}, {hold}, {pace}", choice.method)));
    }
}

fn report(cloths: Query<(&Title, &ClothReport, &Most)>) -> String {
    cloths.iter().map(|(title, report, most)| format!("{}: {}\n", title.0, tangles::line_with_time(report, most))).collect()
}
