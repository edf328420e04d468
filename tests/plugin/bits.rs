//! Every position of every frame of some twenty scenes, as hashes in `bits.txt`: a change that is to change no result changes none of them.
//!
//! `BITS=write cargo test --test plugin bits` writes the file anew; the commit that does so says why. The hashes are those of x86-64: other processors and math
//! libraries round otherwise, which the line `math` tells, and nothing is compared there.

use std::fmt::Write;
use std::path::PathBuf;

use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::resolve::{Method, ResolveSettings};
use drape_scenes::{self as scenes, Scene, Tangle};

use crate::common::*;

/// FNV-1a, 64 bits.
struct Hash(u64);

impl Hash {
    const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn add(&mut self, values: impl IntoIterator<Item = f32>) {
        for byte in values.into_iter().flat_map(|value| value.to_bits().to_le_bytes()) {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

/// Of the functions that the library takes from the system.
fn math() -> u64 {
    let mut hash = Hash::new();
    for k in 0..2000 {
        let x = 0.01 * k as f32 - 7.0;
        hash.add([
            x.sin(),
            x.cos(),
            x.tan(),
            x.exp(),
            x.abs().cbrt(),
            x.abs().powf(0.75),
            x.atan2(0.3),
            x.abs().ln_1p(),
            (0.1 * x).clamp(-1.0, 1.0).acos(),
        ]);
    }
    hash.0
}

/// A scene of the solver over `frames`, untangled by a method or left alone.
fn solver(mut scene: Scene, method: Option<Method>, itself: bool, frames: u32) -> u64 {
    if let Some(method) = method {
        let settings = UntangleSettings { resolve: ResolveSettings { method, ..default() }, ..default() };
        scene = scene.untangled(settings, EvaluateSettings::default(), itself).expect("a scene");
    }
    let mut hash = Hash::new();
    for _ in 0..frames {
        scene.step(1.0 / 60.0);
        for x in scene.cloths.iter().flat_map(|cloth| &cloth.state.positions) {
            hash.add(x.to_array());
        }
    }
    hash.0
}

/// An app over `frames`, which something may happen to before each.
fn in_app(mut app: App, frames: u32, mut happen: impl FnMut(&mut App, u32)) -> u64 {
    let mut hash = Hash::new();
    for frame in 0..frames {
        happen(&mut app, frame);
        app.update();
        let mut cloths = app.world_mut().query::<(Entity, &ClothParticles)>();
        let mut cloths: Vec<_> = cloths.iter(app.world()).collect();
        cloths.sort_by_key(|(entity, _)| *entity);
        for x in cloths.iter().flat_map(|(_, particles)| &particles.state().positions) {
            hash.add(x.to_array());
        }
    }
    hash.0
}

fn spawn_sheets(app: &mut App, material: &ClothMaterial, far: f32) -> Entity {
    let ball = (Transform::from_xyz(far, 0.0, 0.0), ClothCollider::ball(0.3));
    app.world_mut().spawn(ball);
    let at = |y: f32| Transform::from_xyz(far, y, 0.0).with_rotation(Quat::from_rotation_y(y));
    let first = spawn(app, sheet(16), (material.clone(), at(0.4)));
    spawn(app, sheet(12), (material.clone(), at(0.5)));
    first
}

/// Each scene and what it came to.
fn all() -> Vec<(String, u64)> {
    const BY_END: Option<Method> = Some(Method::ByEndType);
    let mut hashes: Vec<(String, u64)> = Vec::new();
    let mut note = |name: &str, hash: u64| hashes.push((name.replace(' ', "_"), hash));
    note("hang", solver(scenes::hang(24), None, false, 120));
    note("ball", solver(scenes::ball(24), None, false, 120));
    note("ball self collision", solver(scenes::ball(24), BY_END, true, 120));
    note("flags", solver(scenes::flags(2, 20), None, false, 120));
    note("flag self collision", solver(scenes::flags(1, 20), BY_END, true, 120));
    note("layers", solver(scenes::layers(3, 16), BY_END, false, 120));
    note("stack", solver(scenes::stack(4, 14), BY_END, true, 90));
    note("curtain", solver(scenes::curtain(14), BY_END, true, 120));
    note("twist", solver(scenes::twist(14), BY_END, true, 120));
    note("skirt", solver(scenes::skirt(14), BY_END, true, 120));
    note("funnel", solver(scenes::funnel(20), BY_END, true, 120));
    note("pinch", solver(scenes::pinch(16), BY_END, true, 90));
    note("needles", solver(scenes::needles(20), BY_END, true, 90));
    note("far away", solver(shifted(scenes::ball(16), Vec3::new(100.0, -3.0, 7.0)), BY_END, true, 60));
    for (name, method) in [
        ("end type", Method::ByEndType),
        ("global", Method::GlobalGradient),
        ("local", Method::LocalGradient),
        ("history", Method::History),
    ] {
        for tangle in [Tangle::Dent, Tangle::FullCut] {
            note(&format!("{tangle:?} {name}"), solver(scenes::tangle(tangle, 14), Some(method), false, 30));
        }
    }
    let mut fabrics = app();
    for (k, (_, material)) in ClothMaterial::PRESETS.into_iter().enumerate() {
        spawn(&mut fabrics, sheet(10), (border(), material, Transform::from_xyz(2.0 * k as f32, 0.0, 0.0)));
    }
    note("app: fabrics", in_app(fabrics, 60, |_, _| {}));
    let mut rest = app();
    let sleeper = spawn_sheets(&mut rest, &ClothMaterial::COTTON, 0.0);
    note("app: sleep and waking", {
        in_app(rest, 300, |app, frame| {
            if frame == 240 {
                let mut particles = app.world_mut().get_mut::<ClothParticles>(sleeper).expect("a cloth");
                particles.apply_impulse(Vec3::new(0.2, 0.3, 0.0), Vec3::new(0.0, 0.02, 0.0), 0.2);
            }
        })
    });
    let mut moved = app();
    let carried = spawn(&mut moved, sheet(12), border());
    note("app: teleport", {
        in_app(moved, 90, |app, frame| {
            let mut transform = app.world_mut().get_mut::<Transform>(carried).expect("a transform");
            transform.translation.x += if frame == 45 { 500.0 } else { 0.02 };
        })
    });
    let mut lod = app();
    let level = ClothLod { full_within: 10.0, still_beyond: 100.0, ..default() };
    let camera = lod.world_mut().spawn((Camera3d::default(), Transform::from_xyz(5.0, 0.0, 0.0))).id();
    spawn(&mut lod, sheet(12), (border(), level));
    note("app: level of detail", {
        in_app(lod, 90, |app, _| app.world_mut().get_mut::<Transform>(camera).expect("a camera").translation.x += 0.7)
    });
    let mut net = app();
    let body = (
        Transform::from_xyz(0.1, 0.6, 0.05),
        ClothCollider::ball(0.15),
        ClothCoupling::TwoWay,
        ClothRigidBody { inverse_mass: Vec3::splat(2.0), ..default() },
    );
    net.world_mut().spawn(body);
    spawn(&mut net, sheet(16), (border(), ClothMaterial::RUBBER));
    note("app: two-way body", in_app(net, 90, |_, _| {}));
    hashes
}

fn shifted(mut scene: Scene, by: Vec3) -> Scene {
    for cloth in &mut scene.cloths {
        for x in cloth.state.positions.iter_mut().chain(&mut cloth.state.previous) {
            *x += by.extend(0.0);
        }
    }
    for body in &mut scene.bodies {
        body.from.translation += by;
        body.to.translation += by;
    }
    scene
}

#[expect(clippy::print_stderr, reason = "it says that it tested nothing")]
#[test]
fn every_bit_of_every_frame_is_what_it_was() {
    let file = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/plugin/bits.txt");
    let here = format!("{} {:016x}", std::env::consts::ARCH, math());
    let lines = |hashes: &[(String, u64)]| {
        hashes.iter().fold(format!("math {here}\n"), |mut text, (name, hash)| {
            writeln!(text, "{name} {hash:016x}").expect("a string");
            text
        })
    };
    if std::env::var("BITS").is_ok_and(|v| v == "write") {
        std::fs::write(&file, lines(&all())).expect("a file");
        return;
    }
    let kept = std::fs::read_to_string(&file).expect("bits.txt");
    if kept.lines().next() != Some(&format!("math {here}")) {
        eprintln!("the hashes are of another processor or math library: nothing is compared");
        return;
    }
    let seen = lines(&all());
    let other: Vec<_> = seen.lines().zip(kept.lines()).filter(|(a, b)| a != b).collect();
    assert!(other.is_empty() && seen.lines().count() == kept.lines().count(), "other bits: {other:#?}");
}
