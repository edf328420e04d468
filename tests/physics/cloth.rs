//! The solver against theory: what a cloth does must not depend on its mesh or on the frame rate.

use std::f32::consts::TAU;
use std::sync::Arc;

use bevy::tasks::TaskPoolBuilder;
use bevy_drape::solver::body::{Body, Pose, shape};
use bevy_drape::solver::recover::{Limits, Recovery};
use bevy_drape::solver::rest::{RestShape, SourceMesh};
use bevy_drape::solver::settings::Fabric;
use bevy_drape::solver::sim::ClothSim;
use bevy_drape::solver::step::FrameInput;
use bevy_drape::solver::wind::Wind;
use drape_scenes::{GRAVITY, Scene, SceneCloth, ball, fabric, flags, grid, hang};
use glam::{Vec3, vec3};

fn build(mesh: &SourceMesh) -> Arc<RestShape> {
    Arc::new(RestShape::build(mesh).expect("a valid mesh").0)
}

/// No air, no damping: nothing but gravity and the constraints.
fn vacuum(cloth: SceneCloth) -> Scene {
    Scene { wind: Wind::NONE, ..Scene::new(vec![cloth]) }
}

fn undamped() -> Fabric {
    Fabric { damping: 0.0, drag: 0.0, bend_hysteresis: 0.0, ..fabric() }
}

/// Frame lengths [s] that wander between 4 and 40 ms, the same in every run.
fn jittered(frame: u32) -> f32 {
    0.004 + 0.036 * ((frame.wrapping_mul(2_654_435_761) >> 16) & 0xff) as f32 / 255.0
}

/// Runs for `seconds` with frames of the given lengths.
fn run(scene: &mut Scene, seconds: f64, frame: impl Fn(u32) -> f32) {
    let mut n = 0;
    while scene.cloths[0].sim.state.time < seconds {
        scene.step(frame(n));
        n += 1;
    }
}

#[test]
fn a_falling_sheet_falls_as_far_as_a_stone() {
    for rate in [30.0, 60.0, 144.0, 0.0] {
        let rest = build(&grid(12, 12, |u, v| vec3(u, 0.0, v)));
        let mut scene = vacuum(SceneCloth::new(rest, undamped(), Vec3::ZERO, &[]));
        run(&mut scene, 1.0, |n| if rate > 0.0 { 1.0 / rate } else { jittered(n) });
        let cloth = &scene.cloths[0];
        let theory = 0.5 * f64::from(GRAVITY.y) * cloth.sim.state.time.powi(2);
        let error = f64::from(cloth.lowest()) / theory - 1.0;
        assert!(error.abs() < 1.0e-3, "{rate} Hz: {} m for {theory} m", cloth.lowest());
    }
}

/// Period [s] of the oscillation along x of a weighted sum of particles, from its zero crossings until `seconds`.
fn period(scene: &mut Scene, weights: &[f32], seconds: f64) -> f64 {
    let sum = |scene: &Scene| -> f32 { scene.cloths[0].sim.state.positions.iter().zip(weights).map(|(x, w)| x.x * w).sum() };
    let dt = 1.0 / 120.0;
    let mut crossings = Vec::new();
    let mut last = sum(scene);
    while scene.cloths[0].sim.state.time < seconds {
        scene.step(dt);
        let (x, t) = (sum(scene), scene.cloths[0].sim.state.time);
        if last < 0.0 && x >= 0.0 {
            crossings.push(t - f64::from(dt * x / (x - last)));
        }
        last = x;
    }
    (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64
}

#[test]
fn a_pendulum_swings_with_the_period_of_theory() {
    // A triangle hinged along one side is a point mass on a rod of its height.
    let (length, angle) = (0.8f32, 0.1f32);
    let tip = vec3(length * angle.sin(), -length * angle.cos(), 0.0);
    let positions = vec![vec3(0.0, 0.0, -0.5), vec3(0.0, 0.0, 0.5), tip];
    let mesh = SourceMesh { positions, triangles: vec![[0, 1, 2]], ..SourceMesh::default() };
    let rest = build(&mesh);
    let mut weights = [0.0; 3];
    weights[rest.particle_of_vertex[2] as usize] = 1.0;
    let mut scene = vacuum(SceneCloth::new(rest, undamped(), Vec3::ZERO, &[0, 1]));
    let found = period(&mut scene, &weights, 20.0);
    let theory = f64::from(TAU * (length / -GRAVITY.y).sqrt() * (1.0 + angle * angle / 16.0));
    assert!((found / theory - 1.0).abs() < 0.02, "{found} s for {theory} s");
}

#[test]
fn a_hanging_curtain_swings_as_a_heavy_chain() {
    // The lowest mode of a chain hanging from one end: omega = j / 2 sqrt(g / L), j the first zero of J0 (Bernoulli 1738).
    let length = 1.0f32;
    // Without tethers, which hold a curtain as a bundle of pendulums, and with steps short enough for a long chain of springs.
    for (n, substep_rate) in [(9, 360.0), (17, 960.0), (33, 1920.0)] {
        let mesh = grid(n, 5, |u, v| vec3(0.0, -length * u, 0.2 * v));
        let rest = build(&mesh);
        let top: Vec<u32> = (0..5).collect();
        let limp = Fabric { bend_stiffness: 0.0, drag: 5.0, tether_scale: f32::INFINITY, ..undamped() };
        let mut scene = vacuum(SceneCloth::new(rest, limp, Vec3::ZERO, &top));
        scene.cloths[0].stepping.substep_rate = substep_rate;
        run(&mut scene, 4.0, |_| 1.0 / 120.0);
        // At rest under its weight; now into the shape of that mode, J0(j sqrt(1 - s)).
        let j = 2.404_826_f64;
        let cloth = &mut scene.cloths[0];
        cloth.fabric.drag = 0.0;
        let shape = |y: f32| bessel_j0(j * f64::from(1.0 + y / length).max(0.0).sqrt()) as f32;
        for x in cloth.sim.state.positions.iter_mut().chain(&mut cloth.sim.state.previous) {
            x.x = 0.02 * shape(x.y);
        }
        // Modes are orthogonal under the mass: this sum sees no other.
        let weights: Vec<f32> = cloth.rest.positions.iter().zip(&cloth.rest.areas).map(|(p, a)| a * shape(p.y)).collect();
        let found = period(&mut scene, &weights, 14.0);
        let theory = f64::from(TAU) / (0.5 * j * f64::from(-GRAVITY.y / length).sqrt());
        assert!((found / theory - 1.0).abs() < 0.02, "{n} rows: {found} s for {theory} s");
    }
}

/// Bessel function of the first kind of order 0, by its series.
fn bessel_j0(x: f64) -> f64 {
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..20 {
        term *= -(x * x / 4.0) / f64::from(k * k);
        sum += term;
    }
    sum
}

#[test]
fn energy_does_not_grow_without_wind_and_damping() {
    for n in [16, 32, 64] {
        let mut scene = hang(n);
        scene.wind = Wind::NONE;
        scene.cloths[0].fabric = undamped();
        scene.cloths[0].prepare();
        // The energy there is to move: the weight times the height it can fall.
        let scale = f64::from(drape_scenes::DENSITY * -GRAVITY.y * 0.5);
        let mut energy = Vec::new();
        for _ in 0..480 {
            energy.push(scene.cloths[0].energy(GRAVITY));
            scene.step(1.0 / 60.0);
        }
        let gain = energy.windows(61).map(|w| w[60] - w[0]).fold(f64::MIN, f64::max);
        assert!(gain < 0.01 * scale, "{n}²: gained {gain:.4} of {scale:.3} J within a second");
        let highest = energy.iter().copied().fold(f64::MIN, f64::max) - energy[0];
        assert!(highest < 0.01 * scale, "{n}²: {highest:.4} of {scale:.3} J more than at the start");
    }
}

/// How far a curtain held at five points of its upper edge, drawn together to 0.9 of its width, hangs down [m].
fn curtain_sag(n: u32, frame: impl Fn(u32) -> f32) -> f32 {
    let rest = build(&grid(n, n, |u, v| vec3(v - 0.5, -u, 0.0)));
    let pins: Vec<u32> = (0..5).map(|k| ((n - 1) as f32 * k as f32 / 4.0).round() as u32).collect();
    let mut cloth = SceneCloth::new(rest, fabric(), Vec3::ZERO, &pins);
    for target in &mut cloth.anchors.to {
        target.x *= 0.9;
    }
    let mut scene = Scene::new(vec![cloth]);
    run(&mut scene, 8.0, frame);
    // The mean height: the lowest point alone is a matter of one fold.
    let heights = &scene.cloths[0].sim.state.positions;
    let areas = &scene.cloths[0].rest.areas;
    let weighted: f32 = heights.iter().zip(areas).map(|(x, a)| -x.y * a).sum();
    weighted / areas.iter().sum::<f32>()
}

#[test]
fn a_curtain_hangs_as_low_at_every_resolution() {
    let sags = [16, 32, 64].map(|n| curtain_sag(n, |_| 1.0 / 60.0));
    let (low, high) = (sags.iter().copied().fold(f32::MAX, f32::min), sags.iter().copied().fold(0.0, f32::max));
    assert!(high / low < 1.02, "sags {sags:?}");
}

#[test]
fn a_curtain_hangs_as_low_at_every_frame_rate() {
    let frames: [&dyn Fn(u32) -> f32; 4] = [&|_| 1.0 / 30.0, &|_| 1.0 / 60.0, &|_| 1.0 / 144.0, &jittered];
    let sags = frames.map(|frame| curtain_sag(32, frame));
    let (low, high) = (sags.iter().copied().fold(f32::MAX, f32::min), sags.iter().copied().fold(0.0, f32::max));
    assert!(high / low < 1.02, "sags {sags:?}");
}

#[test]
fn a_sheet_held_at_two_corners_does_not_stretch_like_rubber() {
    for n in [64, 128] {
        let mut scene = hang(n);
        run(&mut scene, 5.0, |_| 1.0 / 60.0);
        let report = scene.cloths[0].report;
        assert!(report.worst_edge <= 1.10, "{n}²: worst edge {}", report.worst_edge);
        assert!(report.mean_edge <= 1.01, "{n}²: mean edge {}", report.mean_edge);
    }
}

#[test]
fn a_sheet_held_along_a_border_comes_to_rest_with_all_diagonals_one_way() {
    for n in [16, 40, 64] {
        let mut mesh = grid(n, n, |u, v| vec3(u - 0.5, -v, 0.0));
        let quads = (0..n - 1).flat_map(|j| (0..n - 1).map(move |i| j * n + i));
        mesh.triangles = quads.flat_map(|a| [[a, a + 1, a + n], [a + 1, a + n + 1, a + n]]).collect();
        let border: Vec<u32> = (0..n * n).filter(|&v| mesh.positions[v as usize].y == 0.0).collect();
        assert_eq!(border.len(), n as usize);
        let mut scene = Scene::new(vec![SceneCloth::new(build(&mesh), fabric(), Vec3::ZERO, &border)]);
        run(&mut scene, 5.0, |_| 1.0 / 60.0);
        let cloth = &scene.cloths[0];
        let fastest = (0..cloth.sim.state.positions.len()).map(|i| cloth.sim.state.velocity(i).length()).fold(0.0, f32::max);
        assert!(cloth.report.worst_edge < 1.02, "{n}²: worst edge {}", cloth.report.worst_edge);
        assert!(fastest < 0.02, "{n}²: {fastest} m/s");
    }
}

#[test]
fn a_sheet_over_a_ball_does_not_stretch_like_rubber() {
    for (n, limit) in [(64, 1.10), (128, 1.20)] {
        let mut scene = ball(n);
        run(&mut scene, 4.0, |_| 1.0 / 60.0);
        let mut worst = 0.0f32;
        for _ in 0..60 {
            scene.step(1.0 / 60.0);
            worst = worst.max(scene.cloths[0].report.worst_edge);
        }
        assert!(worst <= limit, "{n}²: worst edge {worst}");
        let mean = scene.cloths[0].report.mean_edge;
        assert!(mean <= 1.01, "{n}²: mean edge {mean}");
    }
}

/// A leg that swings in a skirt, in one frame.
fn swinging(leg: f32, frame: u32) -> Body {
    let at = |n: u32| {
        let t = 2.0 * n as f32 / 60.0;
        Pose::translation(0.17 * t.sin(), 0.43, 0.17 * t.cos())
    };
    let leg = shape::capsule_between(Vec3::Y * -0.15, Vec3::Y * 0.15, leg).expect("a valid capsule");
    Body::new(leg, at(frame), at(frame + 1))
}

#[test]
fn slivers_at_the_waist_of_a_skirt_hold_its_weight() {
    let (around, rings) = (120, 24);
    let mesh = grid(around + 1, rings, |u, v| {
        // Rings close to each other at the waist, and every other one turned by half a vertex.
        let angle = TAU * (u + 0.5 * ((v * (rings - 1) as f32).round() % 2.0) / around as f32);
        let out = 0.15 + 0.35 * v * (0.3 + 0.7 * v);
        vec3(out * angle.cos(), 0.7 - 0.2 * v, out * angle.sin())
    });
    let waist: Vec<u32> = (0..=around).map(|i| i * rings).collect();
    let cloth = SceneCloth::new(build(&mesh), Fabric { density: 0.2, ..fabric() }, Vec3::ZERO, &waist);
    let mut scene = Scene::new(vec![cloth]);
    scene.cloths[0].stepping.substep_rate = 2880.0;
    let mut worst = 0.0f32;
    for frame in 0..300 {
        scene.bodies = vec![swinging(0.06, frame)];
        scene.step(1.0 / 60.0);
        worst = worst.max(scene.cloths[0].report.worst_edge);
    }
    assert!(worst <= 1.12, "worst edge {worst}");
}

#[test]
fn a_storm_of_200_metres_per_second_does_not_end_as_a_blow_up() {
    for (name, mut scene) in [("flag", flags(1, 40)), ("flag", flags(1, 64)), ("sheet", hang(40)), ("sheet", hang(64))] {
        scene.wind.velocity = scene.wind.velocity.normalize_or(Vec3::X) * 200.0;
        let cloth = &mut scene.cloths[0];
        cloth.fabric.density = 0.1;
        cloth.prepare();
        let pose: Vec<Vec3> = cloth.sim.state.positions.iter().map(|x| x.truncate()).collect();
        let mut recovery = Recovery::default();
        recovery.start(&cloth.sim.state);
        let mut restored = 0;
        for _ in 0..600 {
            scene.step(1.0 / 60.0);
            let SceneCloth { sim: ClothSim { state, .. }, report, .. } = &mut scene.cloths[0];
            let taken_back = recovery.judge(state, report.worst_edge, &Limits::default(), |out| out.clone_from(&pose));
            restored += usize::from(taken_back.is_some());
            recovery.end_frame();
        }
        assert!(!recovery.is_frozen() && restored <= 3, "{name} of {} particles: restored {restored} times", pose.len());
    }
}

#[test]
fn no_resolution_and_no_density_diverges() {
    for n in [10, 30, 100, 256] {
        for density in [0.1, 1.0] {
            let mut scene = hang(n);
            scene.cloths[0].fabric.density = density;
            scene.cloths[0].prepare();
            let mut worst = 0.0f32;
            for _ in 0..if n > 200 { 120 } else { 300 } {
                scene.step(1.0 / 60.0);
                worst = worst.max(scene.cloths[0].report.worst_edge);
            }
            assert!(worst < 2.0, "{n}² at {density} kg/m²: worst edge {worst}");
        }
    }
}

#[test]
fn heavier_cloth_of_one_fabric_hangs_alike() {
    let low = [0.1, 0.3, 1.0].map(|density| {
        let mut scene = hang(32);
        scene.cloths[0].fabric.density = density;
        scene.cloths[0].prepare();
        run(&mut scene, 8.0, |_| 1.0 / 60.0);
        scene.cloths[0].lowest()
    });
    assert!((low[0] / low[2] - 1.0).abs() < 0.02, "{low:?}");
}

#[test]
fn a_frame_without_length_changes_nothing() {
    let mut scene = hang(12);
    run(&mut scene, 0.5, |_| 1.0 / 60.0);
    let before = scene.cloths[0].sim.state.clone();
    for dt in [0.0, -0.0, -1.0, f32::NAN, f32::NEG_INFINITY] {
        scene.step(dt);
        assert!(scene.cloths[0].sim.state == before, "dt = {dt} moved the cloth");
    }
}

#[test]
fn a_huge_frame_is_cut_and_the_rest_counted_as_lost() {
    let mut scene = hang(12);
    for (dt, lost) in [(5.0, 4.9), (f32::INFINITY, f32::INFINITY), (0.1, 0.0)] {
        scene.step(dt);
        let report = scene.cloths[0].report;
        assert!((report.lost_time - lost).abs() < 1.0e-5 || report.lost_time == lost, "{dt}: lost {}", report.lost_time);
        assert!(report.worst_edge < 1.5, "{dt}: worst edge {}", report.worst_edge);
    }
}

#[test]
fn a_tiny_frame_moves_by_a_tiny_way() {
    let mut scene = hang(12);
    for _ in 0..1000 {
        scene.step(1.0e-5);
    }
    let fallen = scene.cloths[0].lowest();
    assert!((-6.0e-4..-3.0e-4).contains(&fallen), "fell {fallen} m in 0.01 s");
}

#[test]
fn the_bits_are_the_same_with_1_2_and_4_threads_and_in_a_second_run() {
    let run_on = |threads: usize| {
        let mut scene = flags(6, 20);
        let pool = TaskPoolBuilder::new().num_threads(threads).build();
        for _ in 0..90 {
            let input =
                FrameInput { dt: 1.0 / 60.0, gravity: scene.gravity, bodies: &scene.bodies, wind: &scene.wind, skinned: None };
            pool.scope(|scope| {
                for cloth in &mut scene.cloths {
                    let input = &input;
                    scope.spawn(async move { cloth.step(input) });
                }
            });
            scene.wind.advance(1.0 / 60.0);
        }
        scene.cloths.into_iter().map(|c| c.sim.state).collect::<Vec<_>>()
    };
    let one = run_on(1);
    for threads in [1, 2, 4] {
        assert!(run_on(threads) == one, "the bits differ with {threads} threads");
    }
}

#[test]
fn pins_are_exactly_where_their_targets_are() {
    let mut scene = hang(16);
    for n in 0..60 {
        let angle = n as f32 * 0.1;
        for target in &mut scene.cloths[0].anchors.to {
            *target += vec3(angle.cos(), angle.sin(), 0.0) * 20.0 / 60.0;
        }
        scene.step(1.0 / 60.0);
        let cloth = &scene.cloths[0];
        for (p, target) in cloth.anchors.particles.iter().zip(&cloth.anchors.to) {
            assert_eq!(cloth.sim.state.positions[*p as usize].truncate(), *target, "frame {n}");
        }
        assert!(cloth.report.worst_edge < 3.0, "frame {n}: {}", cloth.report.worst_edge);
    }
}

#[test]
fn cloth_without_a_strain_limit_between_two_pins_stays_finite() {
    let rest = build(&grid(12, 12, |u, v| vec3(u, 0.0, v)));
    let row: Vec<u32> = (0..12).collect();
    let rubber = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, stretch_stiffness: 750.0, ..fabric() };
    let mut scene = vacuum(SceneCloth::new(rest, rubber, Vec3::ZERO, &row));
    run(&mut scene, 2.0, |_| 1.0 / 60.0);
    let worst = scene.cloths[0].report.worst_edge;
    assert!(worst < 2.0, "worst edge {worst}");
}

#[test]
fn a_softly_held_particle_stays_near_its_target() {
    let rest = build(&grid(8, 8, |u, v| vec3(u, 0.0, v)));
    let every: Vec<u32> = (0..64).collect();
    for (weight, reach) in [(0.9, 0.05), (0.5, 0.5)] {
        let mut cloth = SceneCloth::new(rest.clone(), fabric(), Vec3::ZERO, &every);
        cloth.anchors.weights.fill(weight);
        cloth.prepare();
        let mut scene = vacuum(cloth);
        run(&mut scene, 3.0, |_| 1.0 / 60.0);
        let sunk = -scene.cloths[0].lowest();
        assert!(sunk > 0.0 && sunk < reach, "weight {weight}: sunk {sunk} m");
    }
}
