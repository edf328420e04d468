//! Cloth on cloth: nothing fast goes through, friction holds as Coulomb says, momentum is kept.

use std::sync::Arc;

use bevy_drape::solver::body::{Body, Pose, SharedShape, shape};
use bevy_drape::solver::rest::RestShape;
use drape_scenes::{GRAVITY, Scene, SceneCloth, fabric, grid, sheets};
use glam::{DVec3, Quat, Vec3, vec3};

use crate::{FRAME, untangled};

/// A level sheet of `side` [m] and `n` x `n` vertices, held at the corners if `held`.
fn sheet(n: u32, side: f32, turn: Quat, at: Vec3, held: bool) -> SceneCloth {
    let mesh = grid(n, n, |u, v| turn * (side * vec3(u - 0.5, 0.0, v - 0.5)));
    let (rest, _) = RestShape::build(&mesh).expect("a sheet");
    let corners = [0, n - 1, n * n - n, n * n - 1];
    SceneCloth::new(Arc::new(rest), fabric(), at, if held { &corners } else { &[] })
}

/// Gives a cloth a velocity [m/s], over a substep of the length that it will have.
fn throw(cloth: &mut SceneCloth, velocity: Vec3) {
    let h = FRAME / 6.0;
    cloth.sim.state.substep = h;
    for (x, old) in cloth.sim.state.positions.iter().zip(&mut cloth.sim.state.previous) {
        *old = *x - (velocity * h).extend(0.0);
    }
}

/// Root mean square of the speeds of particles [m/s].
fn mean_speed(cloth: &SceneCloth) -> f32 {
    let count = cloth.sim.state.positions.len();
    let square: f32 = (0..count).map(|i| cloth.sim.state.velocity(i).length_squared()).sum();
    (square / count as f32).sqrt()
}

fn middle(cloth: &SceneCloth) -> Vec3 {
    let positions = &cloth.sim.state.positions;
    positions.iter().map(|x| x.truncate()).sum::<Vec3>() / positions.len() as f32
}

/// `k` sheets of 1 m above each other, each off the middle by a few centimetres and turned, on a shape that reaches up to `top`
/// [m].
fn pile(k: u8, n: u32, top: f32, shape: SharedShape) -> Scene {
    let cloths = (0..k).map(f32::from).map(|i| {
        let at = vec3(0.03 * i, top + 0.02 + 0.03 * i, 0.02 * i);
        sheet(n, 1.0, Quat::from_rotation_y(0.35 * i), at, false)
    });
    let mut scene = Scene::new(cloths.collect());
    scene.bodies.push(Body::at_rest(shape, Pose::IDENTITY));
    scene
}

/// How far the middle of each sheet gets in `frames` [m].
fn slides_by(scene: &mut Scene, frames: u32) -> Vec<f32> {
    let start: Vec<Vec3> = scene.cloths.iter().map(middle).collect();
    (0..frames).for_each(|_| scene.step(FRAME));
    scene.cloths.iter().zip(start).map(|(cloth, start)| middle(cloth).distance(start)).collect()
}

fn momentum(scene: &Scene) -> DVec3 {
    let of = |cloth: &SceneCloth| {
        let masses = cloth.rest.areas.iter().map(|a| f64::from(cloth.fabric.density * a));
        masses.enumerate().map(|(i, m)| m * cloth.sim.state.velocity(i).as_dvec3()).sum::<DVec3>()
    };
    scene.cloths.iter().map(of).sum()
}

/// A ball of 5 cm that is shot into 64² stretches edges by 7 % in nine starts of ten, and draws a few out to 2 to 17 times
/// their length in the tenth: of eight starts, so many may.
#[test]
fn a_ball_at_30_m_per_s_does_not_pass_a_held_cloth() {
    let coarse = [(24, 0.05, 30.0), (24, 0.15, 30.0), (48, 0.05, 30.0), (64, 0.05, 10.0), (64, 0.05, 3.0), (64, 0.15, 30.0)];
    for (n, radius, speed) in coarse {
        let longest = shot((n, radius, speed), 0);
        assert!(longest < 2.5, "{n}², radius {radius}, {speed} m/s: worst edge {longest}");
    }
    let longest = [0, 1, 2, 3, 4, 5, 6, 7].map(|start| shot((64, 0.05, 30.0), start));
    assert!(longest.iter().filter(|&&edge| edge > 2.5).count() <= 2, "64², 30 m/s: worst edges {longest:?}");
}

/// The worst edge of a sheet of n by n vertices, held at its corners, that a ball is shot into: all of the cloth is longer by
/// what the ball asks for, not only what lies on it. `start`: 0, or a number for one a little off it.
fn shot((n, radius, speed): (u32, f32, f32), start: u64) -> f32 {
    let mut scene = Scene::new(vec![sheet(n, 1.0, Quat::IDENTITY, Vec3::ZERO, true)]);
    if start > 0 {
        scene = scene.jittered(start);
    }
    let at = |time: f32| Pose::from_translation(vec3(0.03, 0.3 - speed * time, 0.02));
    // It stops 0.1 m below, where the cloth can follow within its strain limit.
    let path = |time: f32| at(time.min(0.4 / speed));
    let ball = shape::ball(radius).expect("a ball");
    scene.bodies.push(Body::at_rest(ball, path(0.0)));
    let mut scene = untangled(scene, true);
    for frame in 1..=60 {
        let body = &mut scene.bodies[0];
        (body.from, body.to) = (body.to, path(frame as f32 * FRAME));
        scene.step(FRAME);
        let centre = scene.bodies[0].to.translation;
        // What lies under the ball must be under it: the middle of the cloth.
        let over = scene.cloths[0].sim.state.positions.iter().map(|x| x.truncate()).filter(|x| {
            let flat = vec3(x.x - centre.x, 0.0, x.z - centre.z).length();
            flat < 0.5 * radius && x.y > centre.y
        });
        assert_eq!(
            over.count(),
            0,
            "{n}², radius {radius}, {speed} m/s, start {start}, frame {frame}: particles above the ball"
        );
    }
    scene.cloths[0].report.worst_edge
}

#[test]
fn a_cloth_at_30_m_per_s_does_not_pass_a_wall_or_another_cloth() {
    // A wall that is thinner than what a substep covers.
    let mut scene = Scene::new(vec![sheet(24, 1.0, Quat::IDENTITY, vec3(0.0, 1.0, 0.0), false)]);
    let wall = shape::cuboid(vec3(2.0, 0.01, 2.0)).expect("a wall");
    scene.bodies.push(Body::at_rest(wall, Pose::IDENTITY));
    throw(&mut scene.cloths[0], vec3(0.0, -30.0, 0.0));
    let mut scene = untangled(scene, true);
    for frame in 1..=30 {
        scene.step(FRAME);
        assert!(scene.cloths[0].lowest() > 0.01, "frame {frame}: lowest particle at {} m", scene.cloths[0].lowest());
    }

    for turn in [0.0, 0.4] {
        let turn = Quat::from_rotation_y(turn);
        let held = sheet(24, 1.2, Quat::IDENTITY, Vec3::ZERO, true);
        let thrown = sheet(24, 0.8, turn, vec3(0.01, 0.6, 0.02), false);
        let mut scene = Scene::new(vec![held, thrown]);
        throw(&mut scene.cloths[1], vec3(0.0, -30.0, 0.0));
        let mut scene = untangled(scene, true);
        for frame in 1..=30 {
            scene.step(FRAME);
            let shown = crate::Picture::of(&scene).crossings();
            assert_eq!(shown, 0, "turned by {turn}, frame {frame}: shown crossings");
        }
        let [held, thrown] =
            [0, 1].map(|k| scene.cloths[k].sim.state.positions.iter().map(|x| x.truncate()).collect::<Vec<_>>());
        let across = |a: &Vec3, b: &Vec3| vec3(a.x - b.x, 0.0, a.z - b.z).length();
        let under = thrown.iter().filter(|x| {
            let below = held.iter().min_by(|a, b| across(a, x).total_cmp(&across(b, x)));
            below.is_some_and(|below| across(below, x) < 0.05 && x.y < below.y - 0.05)
        });
        assert_eq!(under.count(), 0, "turned by {turn}: particles of the thrown cloth under the held one");
    }
}

/// How far the upper of two sheets slides down the lower one, which is fixed on a slope, in a second [m].
fn slides(degrees: f32, friction: f32) -> f32 {
    let turn = Quat::from_rotation_z(-degrees.to_radians());
    let lower = sheet(21, 1.4, turn, Vec3::ZERO, false);
    let mut upper = sheet(12, 0.4, turn, turn * vec3(-0.2, 0.0051, 0.003), false);
    upper.fabric.static_friction = friction;
    upper.fabric.dynamic_friction = friction;
    let mut scene = Scene::new(vec![lower, upper]);
    let lower = &mut scene.cloths[0];
    lower.fabric.static_friction = friction;
    lower.fabric.dynamic_friction = friction;
    let to: Vec<Vec3> = lower.sim.state.positions.iter().map(|x| x.truncate()).collect();
    lower.anchors.particles = (0..to.len() as u32).collect();
    lower.anchors.weights = vec![1.0; to.len()];
    (lower.anchors.from, lower.anchors.to) = (to.clone(), to);
    scene.cloths.iter_mut().for_each(SceneCloth::prepare);
    let along = turn * Vec3::X;
    let middle =
        |scene: &Scene| scene.cloths[1].sim.state.positions.iter().map(|x| along.dot(x.truncate())).sum::<f32>() / 144.0;
    let mut scene = untangled(scene, true);
    let start = middle(&scene);
    (0..60).for_each(|_| scene.step(FRAME));
    middle(&scene) - start
}

#[test]
fn a_sheet_on_a_sheet_sticks_to_a_slope_of_30_degrees_above_the_tangent_and_slides_below() {
    let tangent = 30.0f32.to_radians().tan();
    let stuck = slides(30.0, 1.15 * tangent);
    assert!(stuck < 0.01, "with more friction than the tangent it slid by {stuck} m");
    let slid = slides(30.0, 0.7 * tangent);
    // a = g (sin 30° - 0.7 tan 30° cos 30°) = 0.3 g sin 30°.
    let ideal = 0.5 * 0.3 * 0.5 * -GRAVITY.y;
    assert!((0.7 * ideal..1.1 * ideal).contains(&slid), "with less it slid by {slid} m of {ideal}");
}

#[test]
fn two_free_cloths_that_collide_keep_their_momentum() {
    let first = sheet(16, 0.6, Quat::from_rotation_x(0.2), Vec3::ZERO, false);
    let second = sheet(14, 0.5, Quat::from_rotation_y(0.5), vec3(0.03, 0.12, 0.02), false);
    let mut scene = Scene { gravity: Vec3::ZERO, ..Scene::new(vec![first, second]) };
    throw(&mut scene.cloths[0], vec3(0.3, 2.0, 0.0));
    throw(&mut scene.cloths[1], vec3(0.0, -3.0, 0.4));
    // Air would take some.
    scene.wind.density = 0.0;
    scene.cloths.iter_mut().for_each(|cloth| cloth.fabric.drag = 0.0);
    let mut scene = untangled(scene, true);
    let size = scene.cloths.iter().map(|c| c.rest.areas.iter().sum::<f32>() * c.fabric.density * 3.0).sum::<f32>();
    let start = momentum(&scene);
    let mut touched = 0;
    for frame in 1..=60 {
        scene.step(FRAME);
        touched = touched.max(scene.untangle.as_ref().map_or(0, |u| u.island.pairs().1));
        let drift = momentum(&scene).distance(start) / f64::from(size);
        assert!(drift < 1.0e-5, "frame {frame}: momentum drifted by {drift} of what is in motion");
    }
    assert!(touched > 20, "{touched} pairs touched");
}

/// What pushes the upper of two sheets up [N], on average over a second, once they lie on each other on a floor; and its weight
/// [N].
fn borne() -> (f32, f32) {
    let lower = sheet(12, 0.5, Quat::IDENTITY, vec3(0.0, 0.006, 0.0), false);
    let upper = sheet(12, 0.3, Quat::from_rotation_y(0.3), vec3(0.0, 0.012, 0.0), false);
    let weight = upper.rest.areas.iter().sum::<f32>() * upper.fabric.density * -GRAVITY.y;
    let mut scene = Scene::new(vec![lower, upper]);
    scene.bodies.push(Body::at_rest(shape::half_space(Vec3::Y).expect("a floor"), Pose::IDENTITY));
    let mut scene = untangled(scene, true);
    (0..240).for_each(|_| scene.step(FRAME));
    let mut sum = 0.0;
    for _ in 0..60 {
        scene.step(FRAME);
        let island = &scene.untangle.as_ref().expect("untangled").island;
        island.touches(|parts, _, normal, drive| {
            let h = scene.cloths[0].sim.state.substep;
            sum += if parts[0] == 1 { normal.y } else { -normal.y } * drive / (h * h * 60.0);
        });
    }
    (sum, weight)
}

#[test]
fn cloth_on_cloth_bears_its_weight() {
    let (force, weight) = borne();
    // What it has of its own speed is taken from it at the end of a frame, once of six times by nobody's force.
    assert!((force - weight).abs() < 0.2 * weight, "{force} N of {weight}");
}

/// Two free sheets of `mass` [kg/m²] that meet flat at 1 m/s, with restitutions: how fast they part, of the speed at which they
/// met, and the worst edge (dimensionless).
fn part(n: u32, turn: f32, masses: [f32; 2], restitution: [f32; 2]) -> (f64, f32) {
    let first = sheet(n, 0.5, Quat::IDENTITY, Vec3::ZERO, false);
    let second = sheet(n, 0.5, Quat::from_rotation_y(turn), vec3(0.013, 0.03, 0.007), false);
    let mut scene = Scene { gravity: Vec3::ZERO, ..Scene::new(vec![first, second]) };
    scene.wind.density = 0.0;
    for (k, cloth) in scene.cloths.iter_mut().enumerate() {
        (cloth.fabric.drag, cloth.fabric.restitution) = (0.0, restitution[k]);
        cloth.fabric.density = masses[k];
        cloth.prepare();
    }
    throw(&mut scene.cloths[1], vec3(0.0, -1.0, 0.0));
    let mut scene = untangled(scene, true);
    let mean = |cloth: &SceneCloth| {
        let sum: DVec3 =
            cloth.rest.areas.iter().enumerate().map(|(i, a)| f64::from(*a) * cloth.sim.state.velocity(i).as_dvec3()).sum();
        sum.y / f64::from(cloth.rest.areas.iter().sum::<f32>())
    };
    let mut worst = 0.0_f32;
    for _ in 0..12 {
        scene.step(FRAME);
        assert_eq!(scene.crossings(), 0);
        worst = scene.cloths.iter().map(|c| c.report.worst_edge).fold(worst, f32::max);
    }
    (mean(&scene.cloths[1]) - mean(&scene.cloths[0]), worst)
}

#[test]
fn cloths_part_as_their_restitution_says() {
    for (n, turn) in [(12, 0.0), (20, 0.0), (20, 0.05)] {
        for masses in [[0.2, 0.2], [2.0, 0.2]] {
            for (restitution, wanted) in [([0.0, 0.0], 0.0), ([0.5, 0.0], 0.5), ([0.3, 0.8], 0.8)] {
                let (apart, worst) = part(n, turn, masses, restitution);
                assert!((apart - wanted).abs() < 0.15, "{n}, {turn}, {masses:?}, {restitution:?}: {apart} m/s");
                assert!(worst < 1.15, "{worst}");
            }
        }
    }
}

/// Settling is what was slow for a while, and may be hit in the next frame.
#[test]
fn settling_cloths_part_as_their_restitution_says() {
    for restitution in [0.0, 0.8] {
        let cloths = [0.0, 0.03].map(|y| sheet(20, 1.0, Quat::IDENTITY, vec3(0.0, y, 0.0), false));
        let mut scene = Scene { gravity: Vec3::ZERO, ..Scene::new(cloths.into()) };
        for cloth in &mut scene.cloths {
            cloth.fabric.restitution = restitution;
            cloth.prepare();
        }
        let mut scene = untangled(scene, true);
        (0..60).for_each(|_| scene.step(FRAME));
        assert!(scene.cloths.iter().all(|c| c.sim.memory.is_settling()));
        let above = &mut scene.cloths[1];
        let gap = above.fabric.thickness + 0.4 * FRAME;
        above.sim.state.positions.iter_mut().for_each(|x| x.y = gap);
        throw(above, vec3(0.0, -1.0, 0.0));
        scene.step(FRAME);
        let speed = |cloth: &SceneCloth| {
            let n = cloth.sim.state.positions.len();
            (0..n).map(|i| cloth.sim.state.velocity(i).y).sum::<f32>() / n as f32
        };
        let apart = speed(&scene.cloths[1]) - speed(&scene.cloths[0]);
        assert!((apart - restitution).abs() < 0.1, "{restitution}: {apart} m/s");
    }
}

#[test]
fn a_cloth_leaves_a_floor_as_its_restitution_says() {
    for restitution in [0.0, 0.3, 0.8] {
        let mut scene = Scene::new(vec![sheet(16, 0.5, Quat::IDENTITY, vec3(0.0, 0.1, 0.0), false)]);
        scene.bodies.push(Body::at_rest(shape::half_space(Vec3::Y).expect("a floor"), Pose::IDENTITY));
        scene.gravity = Vec3::ZERO;
        scene.wind.density = 0.0;
        (scene.cloths[0].fabric.drag, scene.cloths[0].fabric.restitution) = (0.0, restitution);
        throw(&mut scene.cloths[0], vec3(0.0, -2.0, 0.0));
        (0..12).for_each(|_| scene.step(FRAME));
        let cloth = &scene.cloths[0];
        let speed = momentum(&scene).y / cloth.rest.areas.iter().map(|a| f64::from(a * cloth.fabric.density)).sum::<f64>();
        assert!((speed - 2.0 * f64::from(restitution)).abs() < 0.02, "{restitution}: {speed} m/s");
    }
}

/// What springs press on a body does not come in with any speed.
#[test]
fn a_cloth_that_is_drawn_over_a_ball_does_not_bounce() {
    for restitution in [0.0, 0.5, 1.0] {
        let n = 32;
        let mesh = grid(n, n, |u, v| vec3(u - 0.5, 0.0, v - 0.5));
        let border: Vec<u32> = (0..n).flat_map(|i| [i, (n - 1) * n + i, i * n, i * n + n - 1]).collect();
        let (rest, _) = RestShape::build(&mesh).expect("a sheet");
        let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric(), vec3(0.0, 0.31, 0.0), &border)]);
        scene.cloths[0].fabric.restitution = restitution;
        scene.bodies.push(Body::at_rest(shape::ball(0.3).expect("a ball"), Pose::IDENTITY));
        for frame in 1..=240 {
            let down = 0.1 * (frame as f32 * FRAME).min(1.0);
            scene.cloths[0].anchors.to.iter_mut().for_each(|to| to.y = 0.31 - down);
            scene.step(FRAME);
            let worst = scene.cloths[0].report.worst_edge;
            assert!(worst < 1.1, "restitution {restitution}, frame {frame}: worst edge {worst}");
        }
        let state = &scene.cloths[0].sim.state;
        let fastest = (0..state.positions.len()).map(|i| state.velocity(i).length()).fold(0.0, f32::max);
        assert!(fastest < 0.01, "restitution {restitution}: {fastest} m/s");
    }
}

/// Sheets side by side on a slope, less than a margin apart: what touches no cloth has the bits that it would have alone.
#[test]
fn cloth_on_a_body_that_touches_no_cloth_keeps_every_bit() {
    let sheets = || {
        let turn = Quat::from_rotation_z(0.2);
        let at = |x: f32| turn * vec3(x, 0.006, 0.0);
        let cloths = [0.0, 0.4053].map(|x| sheet(16, 0.4, turn, at(x), false));
        let mut scene = Scene::new(cloths.into());
        scene.bodies.push(Body::at_rest(shape::half_space(turn * Vec3::Y).expect("a slope"), Pose::IDENTITY));
        scene
    };
    let (mut alone, mut together) = (sheets(), untangled(sheets(), true));
    let mut pairs = 0;
    for frame in 1..=120 {
        alone.step(FRAME);
        together.step(FRAME);
        for (a, b) in alone.cloths.iter().zip(&together.cloths) {
            assert!(a.sim.state == b.sim.state, "frame {frame}");
        }
        let contacts = together.untangle.as_ref().map(|u| u.island.pairs());
        pairs = pairs.max(contacts.map_or(0, |(pairs, touching)| if touching == 0 { pairs } else { 0 }));
    }
    assert!(pairs > 0 && alone.cloths.iter().all(|c| c.report.body_contacts > 0), "{pairs} pairs");
}

/// What lies between is pressed into the ball in every substep, and not the one above after it.
#[test]
fn a_sheet_that_lies_on_a_sheet_on_a_ball_is_at_rest() {
    // Of 12² lies on its faces, of 20² on its particles.
    for n in [12, 20] {
        let mut scene = untangled(sheets(n), true);
        (0..300).for_each(|_| scene.step(FRAME));
        for cloth in &scene.cloths {
            let speed = mean_speed(cloth);
            assert!(speed < 0.015 && cloth.sim.memory.is_settling(), "{n}²: {speed} m/s");
        }
    }
}

/// Friction of 0.5 holds them.
#[test]
fn sheets_on_a_ball_do_not_slide_off_each_other() {
    let mut scene = untangled(pile(3, 24, 0.4, shape::ball(0.4).expect("a ball")), true);
    (0..180).for_each(|_| scene.step(FRAME));
    let slid = slides_by(&mut scene, 300);
    assert_eq!(scene.crossings(), 0);
    assert!(slid.iter().all(|slid| *slid < 0.02), "{slid:?} m in 5 s");
}

/// Nothing but the faces of the lower one lies on the edges of the box, and the upper one on those.
#[test]
fn two_sheets_over_a_box_stay() {
    for seed in [0, 1] {
        let mut scene = untangled(pile(2, 20, 0.3, shape::cuboid(Vec3::splat(0.3)).expect("a box")).jittered(seed), true);
        (0..300).for_each(|_| scene.step(FRAME));
        let slid = slides_by(&mut scene, 300);
        assert_eq!(scene.crossings(), 0);
        assert!(slid.iter().all(|slid| *slid < 0.005), "{seed}: {slid:?} m in 5 s");
        let longest = scene.cloths.iter().map(|c| c.report.worst_edge).fold(0.0, f32::max);
        assert!(longest < 1.2, "{seed}: {longest} times its length");
    }
}

/// Ten sheets on a ball: what one pass over pairs leaves over keeps a heap trembling for ever, at 140 mm/s (root mean square);
/// two passes at 90.
#[test]
fn a_heap_of_ten_sheets_comes_to_rest() {
    let mut scene = untangled(drape_scenes::stack(10, 24), true);
    (0..150).for_each(|_| scene.step(FRAME));
    let speeds: Vec<f32> = scene.cloths.iter().map(mean_speed).collect();
    assert!(speeds.iter().all(|speed| *speed < 0.04), "{speeds:?} m/s");
    let slid = slides_by(&mut scene, 30);
    assert!(slid.iter().all(|slid| *slid < 0.002), "{slid:?} m in half a second");
    assert_eq!(scene.crossings(), 0);
}

/// Folded double on a plane that is tilted to 10°, a third of what friction of 0.5 holds: what carries a fold is not dragged
/// along by it.
#[test]
fn a_fold_on_a_slope_stays() {
    let mesh = grid(24, 24, |u, v| vec3(u - 0.5, if v < 0.5 { 0.006 } else { 0.012 }, 0.25 - (v - 0.5).abs()));
    let flat = grid(24, 24, |u, v| vec3(u - 0.5, 0.0, v - 0.5));
    let (rest, _) = RestShape::build(&flat).expect("a sheet");
    let mut cloth = SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &[]);
    for (i, x) in mesh.positions.iter().enumerate() {
        cloth.sim.state.positions[i] = x.extend(cloth.sim.state.positions[i].w);
    }
    cloth.sim.state.previous.clone_from(&cloth.sim.state.positions);
    let mut scene = untangled(Scene::new(vec![cloth]), true);
    scene.bodies.push(Body::at_rest(shape::half_space(Vec3::Y).expect("a plane"), Pose::IDENTITY));
    (0..300).for_each(|_| scene.step(FRAME));
    for tilt in 1..=10u8 {
        scene.gravity = Quat::from_rotation_x(f32::from(tilt).to_radians()) * GRAVITY;
        (0..30).for_each(|_| scene.step(FRAME));
    }
    let slid = slides_by(&mut scene, 600)[0];
    assert!(slid < 0.002 && scene.crossings() == 0, "{slid} m in 10 s");
}

/// Folds that lie in each other pull to and fro within a frame, and get nowhere.
#[test]
fn curtains_whose_folds_touch_come_to_rest() {
    let n = 24;
    let mesh = grid(n, n, |u, v| vec3(u - 0.5, -v, 0.0));
    let top: Vec<u32> = (0..).zip(&mesh.positions).filter(|(_, x)| x.y > -1.0e-4).map(|(i, _)| i).collect();
    let (rest, _) = RestShape::build(&mesh).expect("a curtain");
    let rest = Arc::new(rest);
    let curtain = |z: f32| SceneCloth::new(Arc::clone(&rest), fabric(), vec3(0.0, 0.0, z), &top);
    let mut scene = untangled(Scene::new(vec![curtain(0.0), curtain(0.002)]), true);
    let wide: Vec<f32> = scene.cloths[0].anchors.to.iter().map(|to| to.x).collect();
    for frame in 1..=360 {
        // Drawn together to four fifths of their width in two seconds.
        let share = 1.0 - 0.2 * (frame as f32 / 120.0).min(1.0);
        for cloth in &mut scene.cloths {
            cloth.anchors.to.iter_mut().zip(&wide).for_each(|(to, x)| to.x = x * share);
        }
        scene.step(FRAME);
    }
    let touching = scene.untangle.as_ref().map_or(0, |u| u.island.pairs().1);
    assert!(touching > 20 && scene.crossings() == 0, "{touching} touch");
    for cloth in &scene.cloths {
        let speed = mean_speed(cloth);
        assert!(speed < 0.01 && cloth.sim.memory.is_settling(), "{speed} m/s");
    }
}

/// Tethers give way to a body that draws cloth taut, not to a wall that a curtain leans on.
#[test]
fn a_curtain_that_leans_on_a_wall_hangs_as_long_as_it_is() {
    for (degrees, limit) in [(0.0, 0.05), (2.0, 0.05), (20.0, f32::INFINITY)] {
        let n = 40;
        let mesh = grid(n, n, |u, v| vec3(u - 0.5, -v, 0.0));
        let top: Vec<u32> = (0..).zip(&mesh.positions).filter(|(_, x)| x.y > -1.0e-4).map(|(i, _)| i).collect();
        let (rest, _) = RestShape::build(&mesh).expect("a curtain");
        let mut scene = Scene::new(vec![SceneCloth::new(Arc::new(rest), fabric(), Vec3::ZERO, &top)]);
        scene.cloths[0].fabric.strain_limit = limit;
        let normal = Quat::from_rotation_x(-f32::to_radians(degrees)) * Vec3::Z;
        let wall = Pose::from_translation(-0.004 * normal);
        scene.bodies.push(Body::at_rest(shape::half_space(normal).expect("a wall"), wall));
        (0..300).for_each(|_| scene.step(FRAME));
        let ends = scene.cloths[0].sim.state.positions.iter().map(|x| x.truncate().length()).fold(0.0, f32::max);
        let longest = vec3(0.5, 1.0, 0.0).length();
        assert!(scene.cloths[0].report.body_contacts > 100 && ends < 1.01 * longest, "{degrees}°: {ends} m of {longest}");
    }
}
