//! Sheets that start in each other, and how they come apart.
//!
//! Eight tangles in slow motion, floating; what crosses is drawn as a coloured line. `--units FOLDER` adds the seven contour units of Wicke et al. 2006
//! from `unit_*.obj` files.
//!
//! | key | does |
//! |---|---|
//! | 1 to 8 | one tangle: dent, deep dent, corner, border overlap, strip stab, tilted strip, full cut, waves |
//! | 0 | all of them |
//! | F1 to F7 | the seven units, if they are there |
//! | H, L, G, E | history (1995), local gradient (2006), global gradient (2009), by end type |
//! | S | slow motion or real time |
//! | space | pauses |

mod stage;
mod tangles;

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy_drape::prelude::*;
use bevy_drape::scenes::Tangle;
use bevy_drape::solver::rest::SourceMesh;
use clap::Parser;
use stage::{FabricLook, OrbitCamera, Stage, StageArgs, fabric};

/// Vertices along each side of a sheet.
const SIZE: u32 = 30;
/// Pace of slow motion.
const SLOW: f32 = 0.2;
/// The units, in the order of their keys.
const UNITS: [&str; 7] = ["Closed", "Eight", "LL", "BBII", "BIBI", "BLI", "Cross"];
/// How often each triangle of a unit is cut into four.
const SUBDIVISIONS: u32 = 3;

/// Sheets that start in each other.
#[derive(Parser, Clone)]
struct Arguments {
    #[command(flatten)]
    stage: StageArgs,
    /// Which tangle to show first, 1 to 8; 0 shows all.
    #[arg(long, default_value_t = 0)]
    tangle: usize,
    /// Folder with the contour units.
    #[arg(long)]
    units: Option<PathBuf>,
}

/// What the keys choose.
#[derive(Resource)]
struct Choice {
    tangle: usize,
    unit: Option<usize>,
    units: Option<PathBuf>,
    method: UntangleMethod,
    slow: bool,
}

fn main() -> AppExit {
    let arguments = Arguments::parse();
    let (distance, middle) = if arguments.tangle == 0 { (8.4, 1.15) } else { (2.6, 1.2) };
    let choice = Choice {
        tangle: arguments.tangle.min(8),
        unit: None,
        units: arguments.units,
        method: UntangleMethod::ByEndType,
        slow: true,
    };
    Stage::from_args("tangled", arguments.stage)
        .camera(OrbitCamera::around(Vec3::new(0.0, middle, 0.0), distance).from(0.4, 0.3))
        .hint("0 to 8: tangle    F1 to F7: unit    H L G E: method    S: slow motion    space: pause")
        .report(report)
        .build()
        .add_plugins((ClothPlugin::default(), tangles::plugin))
        .insert_resource(ClothGravity(Vec3::ZERO))
        .insert_resource(choice)
        .add_systems(Startup, spawn)
        .add_systems(Update, (keys, pace, describe).chain())
        .run()
}

fn spawn(
    mut commands: Commands,
    choice: Res<Choice>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let cream = fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.93, 0.90, 0.82), 6.0);
    let red = fabric(&mut images, &mut materials, FabricLook::Cotton, Color::srgb(0.70, 0.18, 0.14), 6.0);
    let mut spawn = |name: &str, source: &SourceMesh, second: bool, at: Vec3| {
        let coordinates = |i: usize| [source.positions[i].x + 0.5, source.positions[i].y + 0.5];
        commands.spawn((
            Name::new(name.to_string()),
            Mesh3d(meshes.add(tangles::mesh(source, coordinates))),
            MeshMaterial3d(if second { red.clone() } else { cream.clone() }),
            // What was up in the formulas lies along z here.
            Transform::from_translation(at).with_rotation(Quat::from_rotation_x(-core::f32::consts::FRAC_PI_2)),
            (Cloth, ClothMaterial::COTTON, Untangle::default().with_method(choice.method)),
        ));
    };
    if let Some(unit) = choice.unit {
        let path = choice.units.as_ref().map(|folder| folder.join(format!("unit_{}.obj", UNITS[unit])));
        match path.as_deref().and_then(read_obj) {
            Some(mesh) => spawn(UNITS[unit], &mesh, false, Vec3::new(0.0, 1.3, 0.0)),
            None => warn!("there is no unit_{}.obj: `--units FOLDER` says where to look", UNITS[unit]),
        }
        return;
    }
    for (i, tangle) in Tangle::ALL.into_iter().enumerate() {
        let at = match choice.tangle {
            0 => Vec3::new(1.6 * (i % 4) as f32 - 2.4, 2.1 - 1.4 * (i / 4) as f32, 0.0),
            k if k == i + 1 => Vec3::new(0.0, 1.2, 0.0),
            _ => continue,
        };
        let [first, second] = tangle.meshes(SIZE);
        spawn(tangle.name(), &first, false, at);
        spawn("", &second, true, at);
    }
}

/// The vertices and triangles of an OBJ file, subdivided and brought to the size of a metre.
fn read_obj(path: &Path) -> Option<SourceMesh> {
    let text = std::fs::read_to_string(path).ok()?;
    let mut mesh = SourceMesh::default();
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let kind = words.next();
        if kind == Some("v") {
            let c: Vec<f32> = words.filter_map(|w| w.parse().ok()).collect();
            mesh.positions.push(Vec3::new(*c.first()?, *c.get(1)?, *c.get(2)?));
        } else if kind == Some("f") {
            let c: Vec<u32> = words.filter_map(|w| w.split('/').next()?.parse::<u32>().ok()?.checked_sub(1)).collect();
            mesh.triangles.push([*c.first()?, *c.get(1)?, *c.get(2)?]);
        }
    }
    for _ in 0..SUBDIVISIONS {
        subdivide(&mut mesh)?;
    }
    let (low, high) = mesh.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
    let size = (high - low).max_element();
    for p in &mut mesh.positions {
        *p = (*p - 0.5 * (low + high)) / size;
    }
    Some(mesh)
}

/// Each triangle becomes four.
fn subdivide(mesh: &mut SourceMesh) -> Option<()> {
    let mut middles = std::collections::BTreeMap::new();
    let mut triangles = Vec::new();
    for t in &mesh.triangles {
        let mut m = [0; 3];
        for (k, m) in m.iter_mut().enumerate() {
            let (a, b) = (t[k], t[(k + 1) % 3]);
            let middle = 0.5 * (*mesh.positions.get(a as usize)? + *mesh.positions.get(b as usize)?);
            *m = *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                mesh.positions.push(middle);
                mesh.positions.len() as u32 - 1
            });
        }
        triangles.extend([[t[0], m[0], m[2]], [m[0], t[1], m[1]], [m[2], m[1], t[2]], m]);
    }
    mesh.triangles = triangles;
    Some(())
}

fn keys(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    mut choice: ResMut<Choice>,
    cloths: Query<Entity, With<Cloth>>,
) {
    use KeyCode::*;
    let digits = [Digit0, Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, Digit8];
    let mut again = false;
    if let Some(k) = digits.into_iter().position(|key| keys.just_pressed(key)) {
        (choice.tangle, choice.unit, again) = (k, None, true);
    }
    if let Some(k) = [F1, F2, F3, F4, F5, F6, F7].into_iter().position(|key| keys.just_pressed(key)) {
        (choice.unit, again) = (Some(k), true);
    }
    for (key, method) in [KeyH, KeyL, KeyG, KeyE].into_iter().zip(UntangleMethod::ALL) {
        if keys.just_pressed(key) {
            (choice.method, again) = (method, true);
        }
    }
    if keys.just_pressed(KeyS) {
        choice.slow = !choice.slow;
    }
    if again {
        cloths.iter().for_each(|cloth| commands.entity(cloth).despawn());
        commands.run_system_cached(spawn);
    }
}

fn pace(choice: Res<Choice>, mut time: ResMut<Time<Virtual>>) {
    if choice.is_changed() {
        time.set_relative_speed(if choice.slow { SLOW } else { 1.0 });
    }
}

fn describe(choice: Res<Choice>, cloths: Query<(&Name, &ClothReport)>, mut panel: Query<&mut Text, With<tangles::Panel>>) {
    for mut text in &mut panel {
        text.0 = words(&choice, &cloths);
    }
}

fn words(choice: &Choice, cloths: &Query<(&Name, &ClothReport)>) -> String {
    let named = cloths.iter().filter(|(name, _)| !name.as_str().is_empty());
    let lines: String = named.map(|(name, report)| format!("{name}: {}\n", tangles::line(report))).collect();
    format!("{:?}\n{lines}", choice.method)
}

fn report(choice: Res<Choice>, cloths: Query<(&Name, &ClothReport)>) -> String {
    words(&choice, &cloths)
}
