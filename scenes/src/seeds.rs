//! Random tangles, each from a number. What share of them comes apart, and how soon, is the second measure of an untangling
//! method.

use core::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3, Vec3};

use super::{Scene, SceneCloth, fabric, grid};
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::resolve::ContourKind;
use bevy_drape::solver::rest::{RestShape, SourceMesh};

/// First of the seeds of the generator; that of tangle `k` is this plus `k`.
const SEED: u64 = 0x5EED_0000;
/// How far starts are jittered, as a fraction of an edge.
const JITTER: f64 = 1.0e-3;

/// How a random tangle came about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SeedKind {
    /// A fold or dent of one sheet through another, 1 to 20 edges deep.
    FoldThrough,
    /// The corner of a sheet through another, 1 to 20 edges deep, at any angle.
    CornerPoke,
    /// Two sheets in any position to each other.
    Placed,
    /// Three or four wavy sheets above each other.
    Layers,
    /// A sheet folded over, with a dent of one half through the other.
    FoldedOver,
    /// A sheet with a corner rolled over and through itself.
    CornerRolled,
}

impl SeedKind {
    /// All of them; tangle `k` is of kind `k % 6`.
    pub const ALL: [Self; 6] =
        [Self::FoldThrough, Self::CornerPoke, Self::Placed, Self::Layers, Self::FoldedOver, Self::CornerRolled];

    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::FoldThrough => "fold through",
            Self::CornerPoke => "corner poke",
            Self::Placed => "placed",
            Self::Layers => "layers",
            Self::FoldedOver => "folded over",
            Self::CornerRolled => "corner rolled",
        }
    }

    /// Whether a sheet crosses itself.
    #[must_use]
    pub const fn is_self_tangle(self) -> bool {
        matches!(self, Self::FoldedOver | Self::CornerRolled)
    }
}

/// A random tangle of sheets of 1 m, 16 to 64 vertices along each side, which are not stretched where they start.
#[derive(Clone, Debug)]
pub struct Seed {
    /// Its number.
    pub number: u64,
    /// How it came about.
    pub kind: SeedKind,
    /// Cloths: shape at rest and where the vertices start `[m]`.
    pub cloths: Vec<(SourceMesh, Vec<Vec3>)>,
}

impl Seed {
    /// Tangle `number`. Some come out clean; those are no tangles.
    #[must_use]
    pub fn new(number: u64) -> Self {
        let mut rng = fastrand::Rng::with_seed(SEED + number);
        let kind = SeedKind::ALL[(number % 6) as usize];
        let n = rng.u32(16..=64);
        let mut cloths = match kind {
            SeedKind::FoldThrough => fold_through(&mut rng, n),
            SeedKind::CornerPoke => corner_poke(&mut rng, n),
            SeedKind::Placed => placed(&mut rng, n),
            SeedKind::Layers => layers(&mut rng, n),
            SeedKind::FoldedOver => folded_over(&mut rng, n),
            SeedKind::CornerRolled => corner_rolled(&mut rng, n),
        };
        let size = JITTER / f64::from(n - 1);
        for point in cloths.iter_mut().flat_map(|(_, start)| start) {
            let mut one = || (size * (2.0 * rng.f64() - 1.0)) as f32;
            *point += Vec3::new(one(), one(), one());
        }
        Self { number, kind, cloths }
    }

    /// The cloths floating, without untangling.
    #[must_use]
    pub fn scene(&self) -> Scene {
        let cloth = |(mesh, start): &(SourceMesh, Vec<Vec3>)| {
            let rest = Arc::new(RestShape::build(mesh).map(|(rest, _)| rest).unwrap_or_default());
            let mut cloth = SceneCloth::new(rest.clone(), fabric(), Vec3::ZERO, &[]);
            for (at, &particle) in start.iter().zip(&rest.particle_of_vertex) {
                if let Some(position) = cloth.sim.state.positions.get_mut(particle as usize) {
                    *position = at.extend(position.w);
                }
            }
            cloth.sim.state.previous.clone_from(&cloth.sim.state.positions);
            cloth
        };
        Scene { gravity: Vec3::ZERO, ..Scene::new(self.cloths.iter().map(cloth).collect()) }
    }
}

/// What became of a random tangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeedRun {
    /// Crossings as it came; 0: not tangled at all.
    pub start: u32,
    /// Whether all its contours were closed.
    pub closed: bool,
    /// Frames until nothing crossed.
    pub clean_after: Option<u32>,
    /// Largest ratio of the contours' length to that 30 frames before.
    pub growth: f32,
    /// Crossings at the end.
    pub left: u32,
}

impl Seed {
    /// Steps the tangle by frames of 1/60 s until it is clean, `most` at most. A sheet collides with itself where it is a
    /// self-tangle, or always.
    #[must_use]
    pub fn run(&self, settings: UntangleSettings, self_collision: bool, most: u32) -> Option<SeedRun> {
        let own = self_collision || self.kind.is_self_tangle();
        let mut scene = self.scene().untangled(settings, EvaluateSettings::default(), own).ok()?;
        let start = scene.look();
        let closed = scene.contours().iter().all(|c| c.kind == ContourKind::Closed);
        let mut run = SeedRun { start: start.crossings, closed, clean_after: None, growth: 0.0, left: start.crossings };
        let mut lengths = vec![start.contour_length];
        for frame in 1..=most {
            if run.left == 0 {
                break;
            }
            scene.step(1.0 / 60.0);
            let now = scene.untangle.as_ref()?.island.total();
            if let Some(before) = lengths.len().checked_sub(30).and_then(|k| lengths.get(k)) {
                run.growth = run.growth.max(now.contour_length / before);
            }
            lengths.push(now.contour_length);
            run.left = now.crossings;
            run.clean_after = now.is_clean().then_some(frame);
        }
        Some(run)
    }
}

/// A sheet of `n` x `n` vertices that is `rest(x, y)` when nothing pulls it and starts at `start(x, y)`, both from -0.5 to 0.5.
fn sheet(n: u32, rest: impl Fn(f64, f64) -> DVec3, start: impl Fn(f64, f64) -> DVec3) -> (SourceMesh, Vec<Vec3>) {
    let side = f64::from(n - 1);
    let place = |k: u32| (f64::from(k / n) / side - 0.5, f64::from(k % n) / side - 0.5);
    let mut mesh = grid(n, n, |_, _| Vec3::ZERO);
    for (k, to) in (0..).zip(&mut mesh.positions) {
        let (x, y) = place(k);
        *to = rest(x, y).as_vec3();
    }
    let start = (0..n * n).map(place).map(|(x, y)| start(x, y).as_vec3()).collect();
    (mesh, start)
}

/// A sheet that starts as it is at rest.
fn shaped(n: u32, at: impl Fn(f64, f64) -> DVec3) -> (SourceMesh, Vec<Vec3>) {
    sheet(n, &at, &at)
}

fn plane(x: f64, y: f64) -> DVec3 {
    DVec3::new(x, y, 0.0)
}

fn between(rng: &mut fastrand::Rng, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.f64()
}

/// A direction from the cube, not from its centre.
fn axis(rng: &mut fastrand::Rng) -> DVec3 {
    loop {
        let axis = DVec3::from_array([(); 3].map(|()| rng.f64() - 0.5));
        if axis.length() > 0.1 {
            return axis.normalize();
        }
    }
}

/// A place within the middle half of a sheet `[m]`.
fn place(rng: &mut fastrand::Rng) -> DVec2 {
    DVec2::new(between(rng, -0.25, 0.25), between(rng, -0.25, 0.25))
}

/// 1 to 20 edges of a sheet of `n` x `n` vertices, at most 0.45 m.
fn depth(rng: &mut fastrand::Rng, n: u32) -> f64 {
    (between(rng, 1.0, 20.0) / f64::from(n - 1)).min(0.45)
}

fn bell(x: f64, y: f64, centre: DVec2, width: f64) -> f64 {
    (-DVec2::new(x, y).distance_squared(centre) / (2.0 * width * width)).exp()
}

fn fold_through(rng: &mut fastrand::Rng, n: u32) -> Vec<(SourceMesh, Vec<Vec3>)> {
    let (m, depth, height) = (rng.u32(16..=64), depth(rng, n), 1.5 / f64::from(n - 1));
    let tilt = DQuat::from_axis_angle(axis(rng), between(rng, -0.02, 0.02));
    let (centre, width, long) = (place(rng), between(rng, 0.05, 0.15), rng.bool());
    let dent = shaped(m, |x, y| {
        let through = bell(if long { centre.x } else { x }, y, centre, width);
        DVec3::new(0.013, 0.007, height - (depth + height) * through) + tilt * plane(x, y)
    });
    vec![shaped(n, plane), dent]
}

fn corner_poke(rng: &mut fastrand::Rng, n: u32) -> Vec<(SourceMesh, Vec<Vec3>)> {
    let (m, depth, centre) = (rng.u32(16..=64), depth(rng, n), place(rng));
    let turn = DQuat::from_rotation_z(between(rng, 0.0, 2.0 * PI)) * DQuat::from_rotation_y(-between(rng, 0.4, 0.4 + PI / 3.0));
    let corner =
        shaped(m, |x, y| centre.extend(-depth) + turn * DVec3::new((x + y + 1.0) * 0.5, (x - y) * 0.5, 0.0) * 2.0f64.sqrt());
    vec![shaped(n, plane), corner]
}

fn placed(rng: &mut fastrand::Rng, n: u32) -> Vec<(SourceMesh, Vec<Vec3>)> {
    let (m, centre, height) = (rng.u32(16..=64), 1.5 * place(rng), between(rng, -0.28, 0.32));
    let turn = DQuat::from_axis_angle(axis(rng), between(rng, 0.0, PI));
    vec![shaped(n, plane), shaped(m, |x, y| centre.extend(height) + turn * plane(x, y))]
}

fn layers(rng: &mut fastrand::Rng, n: u32) -> Vec<(SourceMesh, Vec<Vec3>)> {
    let (count, height, gap) = (rng.u32(3..=4), between(rng, 0.02, 0.07), between(rng, 0.01, 0.04));
    let layer = |k: u32| {
        let k = f64::from(k);
        let phase = [(); 2].map(|()| between(rng, 0.0, 2.0 * PI));
        shaped(n, |x, y| {
            let wave = (5.0 * x + phase[0]).sin() * (6.0 * y + phase[1]).cos();
            DVec3::new(x + 0.003 * k, y + 0.005 * k, gap * k + height * wave)
        })
    };
    (0..count).map(layer).collect()
}

fn folded_over(rng: &mut fastrand::Rng, n: u32) -> Vec<(SourceMesh, Vec<Vec3>)> {
    let (depth, centre, width) = (depth(rng, n).min(0.2), place(rng), between(rng, 0.06, 0.16));
    let radius = (2.0 / f64::from(n - 1)).max(0.03);
    let half = 0.5 * PI * radius;
    let height = |x: f64, y: f64| {
        // Fades in behind the fold, so that the sheet has no step.
        let fade = (5.0 * (x - half)).clamp(0.0, 1.0);
        let through = fade * fade * (3.0 - 2.0 * fade) * bell(x, y, DVec2::new(0.25 + 0.4 * centre.x, centre.y), width);
        DVec3::Z * (2.0 * radius + depth) * through
    };
    let fold = |x: f64, y: f64| {
        if x < -half {
            plane(x, y)
        } else if x > half {
            DVec3::new(-x, y, 2.0 * radius) - height(x, y)
        } else {
            let angle = (x + half) / radius;
            DVec3::new(radius * angle.sin() - half, y, radius * (1.0 - angle.cos()))
        }
    };
    vec![sheet(n, |x, y| plane(x, y) + height(x, y), fold)]
}

fn corner_rolled(rng: &mut fastrand::Rng, n: u32) -> Vec<(SourceMesh, Vec<Vec3>)> {
    let across = DVec3::new(1.0, 1.0 + between(rng, -0.15, 0.15), 0.0).normalize();
    let (length, angle) = (between(rng, 0.25, 0.6), between(rng, 200.0, 240.0).to_radians());
    let radius = between(rng, 1.5, 3.5) / f64::from(n - 1);
    let roll = |x: f64, y: f64| {
        let past = plane(x, y).dot(across) - (0.7 - length);
        if past <= 0.0 {
            return plane(x, y);
        }
        let (turned, on) = ((past / radius).min(angle), (past - angle * radius).max(0.0));
        let along = radius * turned.sin() + on * turned.cos() - past;
        plane(x, y) + along * across + DVec3::Z * (radius * (1.0 - turned.cos()) + on * turned.sin())
    };
    vec![sheet(n, plane, roll)]
}
