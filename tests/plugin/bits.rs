//! Every position of every frame of some twenty scenes, as hashes in `bits.txt`: a change that is to change no result changes
//! none of them.
//!
//! `BITS=write cargo test --test plugin bits` writes the file anew; a line of `bits.md` says why. The hashes are those of
//! x86-64: other processors and math libraries round otherwise, which the line `math` tells, and nothing is compared there.

use std::collections::HashMap;
use std::fmt::Write;

use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::{Island, UntangleSettings};
use bevy_drape::solver::resolve::{Method, ResolveSettings};
use bevy_drape::solver::sim::ClothSim;
use drape_scenes::{self as scenes, Scene, Tangle};

use crate::common::*;
use crate::skinned;

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

/// A scene of the solver and the frames that it takes.
struct OfSolver {
    name: String,
    scene: Scene,
    frames: u32,
}

/// Every position of a scene as it is now, in this order.
fn positions(scene: &Scene) -> impl Iterator<Item = f32> + '_ {
    scene.cloths.iter().flat_map(|cloth| &cloth.sim.state.positions).flat_map(Vec4::to_array)
}

impl OfSolver {
    fn step(&mut self) {
        self.scene.step(1.0 / 60.0);
    }

    fn hash(mut self) -> u64 {
        let mut hash = Hash::new();
        for _ in 0..self.frames {
            self.step();
            hash.add(positions(&self.scene));
        }
        hash.0
    }
}

/// An app, the frames that it takes, and what happens to it before each.
pub struct InApp {
    pub name: &'static str,
    pub app: App,
    pub frames: u32,
    pub happen: Box<dyn Fn(&mut App, u32)>,
}

impl InApp {
    /// Of every position of every cloth in every frame.
    pub fn hash(mut self) -> u64 {
        let mut hash = Hash::new();
        for frame in 0..self.frames {
            (self.happen)(&mut self.app, frame);
            self.app.update();
            let mut cloths = self.app.world_mut().query::<(Entity, &ClothParticles)>();
            let mut cloths: Vec<_> = cloths.iter(self.app.world()).collect();
            cloths.sort_by_key(|(entity, _)| *entity);
            for x in cloths.iter().flat_map(|(_, particles)| &particles.state().positions) {
                hash.add(x.to_array());
            }
        }
        hash.0
    }
}

fn spawn_sheets(app: &mut App, material: &ClothMaterial, far: f32) -> Entity {
    let ball = (Transform::from_xyz(far, 0.0, 0.0), ClothCollider::ball(0.3));
    app.world_mut().spawn(ball);
    let at = |y: f32| Transform::from_xyz(far, y, 0.0).with_rotation(Quat::from_rotation_y(y));
    let first = spawn(app, sheet(16), (material.clone(), at(0.4)));
    spawn(app, sheet(12), (material.clone(), at(0.5)));
    first
}

/// The scenes of the solver, each untangled by a method or left alone.
fn of_solver() -> Vec<OfSolver> {
    const BY_END: Option<Method> = Some(Method::ByEndType);
    let mut all = Vec::new();
    let mut add = |name: &str, mut scene: Scene, method: Option<Method>, itself: bool, frames: u32| {
        if let Some(method) = method {
            let settings = UntangleSettings { resolve: ResolveSettings { method, ..default() }, ..default() };
            scene = scene.untangled(settings, EvaluateSettings::default(), itself).expect("a scene");
        }
        all.push(OfSolver { name: name.to_owned(), scene, frames });
    };
    add("hang", scenes::hang(24), None, false, 120);
    add("ball", scenes::ball(24), None, false, 120);
    add("ball self collision", scenes::ball(24), BY_END, true, 120);
    add("flags", scenes::flags(2, 20), None, false, 120);
    add("flag self collision", scenes::flags(1, 20), BY_END, true, 120);
    add("layers", scenes::layers(3, 16), BY_END, false, 120);
    add("stack", scenes::stack(4, 14), BY_END, true, 90);
    add("curtain", scenes::curtain(14), BY_END, true, 120);
    add("twist", scenes::twist(14), BY_END, true, 120);
    add("skirt", scenes::skirt(14), BY_END, true, 120);
    add("funnel", scenes::funnel(20), BY_END, true, 120);
    add("pinch", scenes::pinch(16), BY_END, true, 90);
    add("needles", scenes::needles(20), BY_END, true, 90);
    add("far away", shifted(scenes::ball(16), Vec3::new(100.0, -3.0, 7.0)), BY_END, true, 60);
    for (name, method) in [
        ("end type", Method::ByEndType),
        ("global", Method::GlobalGradient),
        ("local", Method::LocalGradient),
        ("history", Method::History),
    ] {
        for tangle in [Tangle::Dent, Tangle::FullCut] {
            add(&format!("{tangle:?} {name}"), scenes::tangle(tangle, 14), Some(method), false, 30);
        }
    }
    all
}

/// The apps.
pub fn in_apps() -> Vec<InApp> {
    let mut fabrics = app();
    for (k, (_, material)) in ClothMaterial::PRESETS.into_iter().enumerate() {
        spawn(&mut fabrics, sheet(10), (border(), material, Transform::from_xyz(2.0 * k as f32, 0.0, 0.0)));
    }
    let mut rest = app();
    let sleeper = spawn_sheets(&mut rest, &ClothMaterial::COTTON, 0.0);
    let wake = move |app: &mut App, frame| {
        if frame == 240 {
            let mut particles = app.world_mut().get_mut::<ClothParticles>(sleeper).expect("a cloth");
            particles.apply_impulse(Vec3::new(0.2, 0.3, 0.0), Vec3::new(0.0, 0.02, 0.0), 0.2);
        }
    };
    let mut moved = app();
    let carried = spawn(&mut moved, sheet(12), border());
    let carry = move |app: &mut App, frame| {
        let mut transform = app.world_mut().get_mut::<Transform>(carried).expect("a transform");
        transform.translation.x += if frame == 45 { 500.0 } else { 0.02 };
    };
    let mut lod = app();
    let level = ClothLod { full_within: 10.0, still_beyond: 100.0, ..default() };
    let camera = lod.world_mut().spawn((Camera3d::default(), Transform::from_xyz(5.0, 0.0, 0.0))).id();
    spawn(&mut lod, sheet(12), (border(), level));
    let recede = move |app: &mut App, _| app.world_mut().get_mut::<Transform>(camera).expect("a camera").translation.x += 0.7;
    let mut away = app();
    spawn_sheets(&mut away, &ClothMaterial::COTTON, 1000.0);
    let mut net = app();
    let body = (
        Transform::from_xyz(0.1, 0.6, 0.05),
        ClothCollider::ball(0.15),
        ClothCoupling::TwoWay,
        ClothRigidBody { inverse_mass: Vec3::splat(2.0), ..default() },
    );
    net.world_mut().spawn(body);
    spawn(&mut net, sheet(16), (border(), ClothMaterial::RUBBER));
    let mut worn = app();
    let (limits, drive) = (
        ClothLimits { max_distance: ClothMap::Uniform(0.15), ..default() },
        ClothDrive { frequency: ClothMap::Uniform(0.5), ..default() },
    );
    let (_, joints) = skinned::dressed(&mut worn, 12, (limits, drive, ClothInertia::CHARACTER));
    let dance = move |app: &mut App, frame: u32| {
        for (which, joint) in joints.into_iter().enumerate() {
            skinned::put(app, joint, skinned::dance(frame as f32 / 60.0, which as f32));
        }
    };
    vec![
        InApp { name: "skinned", app: worn, frames: 120, happen: Box::new(dance) },
        InApp { name: "fabrics", app: fabrics, frames: 60, happen: Box::new(|_, _| {}) },
        InApp { name: "sleep and waking", app: rest, frames: 300, happen: Box::new(wake) },
        InApp { name: "teleport", app: moved, frames: 90, happen: Box::new(carry) },
        InApp { name: "level of detail", app: lod, frames: 90, happen: Box::new(recede) },
        InApp { name: "far away", app: away, frames: 90, happen: Box::new(|_, _| {}) },
        InApp { name: "two-way body", app: net, frames: 90, happen: Box::new(|_, _| {}) },
    ]
}

/// Each scene and what it came to.
fn all() -> Vec<(String, u64)> {
    let of_solver = of_solver().into_iter().map(|scene| (scene.name.replace(' ', "_"), scene.hash()));
    let in_apps = in_apps().into_iter().map(|scene| (format!("app: {}", scene.name).replace(' ', "_"), scene.hash()));
    of_solver.chain(in_apps).collect()
}

/// A heap of crossing triangles that asks for more work than a frame may do.
fn heap() -> OfSolver {
    let mut scene = scenes::tangle(Tangle::FullCut, 20);
    for (k, cloth) in scene.cloths.iter_mut().enumerate() {
        for (i, x) in cloth.sim.state.positions.iter_mut().enumerate() {
            x.y += 0.03 * ((i * (k + 3)) as f32).sin();
        }
        cloth.sim.state.previous.clone_from(&cloth.sim.state.positions);
    }
    let settings = UntangleSettings { effort: 16, ..default() };
    let scene = scene.untangled(settings, EvaluateSettings::default(), true).expect("a scene");
    OfSolver { name: "heap".into(), scene, frames: 30 }
}

/// What decides the next frame of a scene of the solver, as bytes.
fn written(scene: &Scene) -> Vec<u8> {
    let cloths: Vec<_> = scene.cloths.iter().map(|cloth| &cloth.sim).collect();
    let mut bytes = Vec::new();
    ciborium::into_writer(&(cloths, scene.untangle.as_ref().map(|u| &u.island)), &mut bytes).expect("memory");
    bytes
}

/// Puts what was [written] into a scene.
fn read(bytes: &[u8], scene: &mut Scene) {
    let (cloths, island): (Vec<ClothSim>, Option<Island>) = ciborium::from_reader(bytes).expect("what was written");
    for (cloth, sim) in scene.cloths.iter_mut().zip(cloths) {
        cloth.sim = sim;
    }
    if let Some((untangling, island)) = scene.untangle.as_mut().zip(island) {
        untangling.island = island;
    }
}

/// Ten frames before `end`, at random, ascending.
pub fn ten_before(end: u32, seed: u64) -> Vec<u32> {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut frames: Vec<u32> = (0..10).map(|_| random.u32(1..end)).collect();
    frames.sort_unstable();
    frames
}

#[test]
fn a_scene_that_was_copied_or_written_at_ten_frames_goes_on_with_the_same_bits() {
    const AFTER: u32 = 120;
    let mut deferred = false;
    for (seed, mut scene) in (0..).zip(of_solver().into_iter().chain([heap()])) {
        let (frames, mut copies) = (ten_before(scene.frames, seed), Vec::new());
        let mut ends = HashMap::new();
        let bits = |scene: &Scene| positions(scene).map(f32::to_bits).collect::<Vec<_>>();
        let mut first = vec![bits(&scene.scene)];
        for frame in 1..=scene.frames + AFTER {
            scene.step();
            deferred |= scene.scene.untangle.as_ref().is_some_and(|u| !u.island.deferred().is_nothing());
            first.push(bits(&scene.scene));
            if frames.contains(&frame) {
                copies.push((frame, scene.scene.clone(), written(&scene.scene)));
            }
            if frame > AFTER && frames.contains(&(frame - AFTER)) {
                ends.insert(frame, written(&scene.scene));
            }
        }
        assert!(!copies.is_empty());
        for (k, (frame, mut copy, bytes)) in copies.into_iter().enumerate() {
            if k % 2 == 1 {
                // Another program has what drives the cloths, and reads the rest.
                for cloth in &mut copy.cloths {
                    cloth.sim = ClothSim::default();
                }
                copy.untangle.iter_mut().for_each(|u| u.island = Island::default());
                read(&bytes, &mut copy);
                assert_eq!(written(&copy), bytes, "{}, frame {frame}", scene.name);
            }
            for after in frame + 1..=frame + AFTER {
                copy.step(1.0 / 60.0);
                assert!(bits(&copy) == first[after as usize], "{}: copied at {frame}, frame {after}", scene.name);
            }
            assert!(written(&copy) == ends[&(frame + AFTER)], "{}: copied at {frame}, what it keeps", scene.name);
        }
    }
    assert!(deferred, "no frame put work off");
}

#[test]
fn two_runs_of_a_scene_are_equal_in_all_that_is_kept() {
    for (mut first, mut second) in of_solver().into_iter().zip(of_solver()) {
        let same = |a: &Scene, b: &Scene| {
            a.cloths.iter().zip(&b.cloths).all(|(a, b)| a.sim == b.sim)
                && a.untangle.as_ref().map(|u| &u.island) == b.untangle.as_ref().map(|u| &u.island)
        };
        for _ in 0..20 {
            first.step();
            second.step();
        }
        assert!(same(&first.scene, &second.scene), "{}", first.name);
        second.step();
        assert!(!same(&first.scene, &second.scene), "{}: a frame later", first.name);
    }
}

fn shifted(mut scene: Scene, by: Vec3) -> Scene {
    for cloth in &mut scene.cloths {
        for x in cloth.sim.state.positions.iter_mut().chain(&mut cloth.sim.state.previous) {
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
    let file = drape_tests::root().join("tests/plugin/bits.txt");
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
