//! What cloth gives bodies, without an engine: momentum, weight, stability.

use std::sync::Arc;

use bevy_drape::solver::body::{Body, Pose, SharedShape};
use bevy_drape::solver::couple::{Reaction, Rigid};
use bevy_drape::solver::rest::RestShape;
use bevy_drape::solver::settings::Fabric;
use bevy_drape::solver::sim::ClothSim;
use bevy_drape::solver::step::{FrameInput, prepare, step};
use bevy_drape::solver::wind::Wind;
use drape_scenes::{SceneCloth, fabric, grid};
use glam::{Mat3, Quat, Vec3};

const DT: f32 = 1.0 / 60.0;
const G: f32 = 9.81;

/// A ball, or a box, as a physics engine would have it.
#[derive(Clone)]
struct Ball {
    at: Vec3,
    turn: Quat,
    velocity: Vec3,
    spin: Vec3,
    mass: f32,
    /// Of a box, half its side.
    radius: f32,
    is_box: bool,
    gravity: f32,
    /// Whether it goes up and down only, without turning: on a rail.
    on_rail: bool,
    given: Reaction,
}

impl Ball {
    fn new(mass: f32, radius: f32, at: Vec3) -> Self {
        let (turn, velocity, spin) = (Quat::IDENTITY, Vec3::ZERO, Vec3::ZERO);
        let (is_box, on_rail) = (false, false);
        Self { at, turn, velocity, spin, mass, radius, is_box, gravity: G, on_rail, given: Reaction::default() }
    }

    fn inertia(&self) -> f32 {
        (if self.is_box { 2.0 / 3.0 } else { 0.4 }) * self.mass * self.radius * self.radius
    }

    /// Moves by a frame without cloth. Returns the body for the cloth, and the shape.
    fn advance(&mut self) -> (Rigid, Body) {
        let from = Pose::from_parts(self.at, self.turn);
        self.at += self.velocity * DT - Vec3::Y * (0.5 * self.gravity * DT * DT);
        self.velocity.y -= self.gravity * DT;
        self.turn = (Quat::from_scaled_axis(self.spin * DT) * self.turn).normalize();
        let (axes, turns) = if self.on_rail { (Vec3::Y, 0.0) } else { (Vec3::ONE, 1.0 / self.inertia()) };
        let rigid = Rigid {
            inverse_mass: axes / self.mass,
            inverse_inertia: Mat3::from_diagonal(Vec3::splat(turns)),
            from: from.translation,
            to: self.at,
            velocity: Some(self.velocity),
        };
        let half = self.radius;
        let shape = if self.is_box { SharedShape::cuboid(half, half, half) } else { SharedShape::ball(half) };
        (rigid, Body::new(shape, from, Pose::from_parts(self.at, self.turn)))
    }

    fn take(&mut self, given: Reaction) {
        if self.on_rail {
            self.velocity.y += given.linear.y / self.mass;
        } else {
            self.velocity += given.linear / self.mass;
            self.spin += given.angular / self.inertia();
        }
        self.at += given.shift;
        self.turn = (given.turn * self.turn).normalize();
        self.given = given;
    }
}

/// Steps a cloth and a ball by a frame. `hold`: places of pins in the anchors that hang on the ball. Returns what each of
/// `masts` was given.
fn frame(
    cloth: &mut SceneCloth,
    ball: Option<&mut Ball>,
    hold: &[u32],
    masts: &[(Vec3, &[u32])],
    gravity: Vec3,
) -> Vec<Reaction> {
    let coupling = cloth.sim.memory.coupling_mut();
    coupling.clear();
    for (at, pins) in masts {
        let slot = coupling.add(Rigid::immovable(*at, *at));
        pins.iter().for_each(|&pin| coupling.hold(pin, slot));
    }
    let mut bodies = Vec::new();
    let mut movable = None;
    if let Some(ball) = ball {
        let (rigid, body) = ball.advance();
        let slot = coupling.add(rigid);
        hold.iter().for_each(|&pin| coupling.hold(pin, slot));
        if hold.is_empty() {
            bodies.push(Body { rigid: Some(slot), ..body });
        } else {
            // Pins follow the way of the ball.
            for &pin in hold {
                let to = cloth.anchors.to[pin as usize];
                cloth.anchors.from[pin as usize] = to;
                cloth.anchors.to[pin as usize] =
                    ball.at + body.to.rotation * body.from.rotation.inverse() * (to - body.from.translation);
            }
        }
        movable = Some((ball, slot));
    }
    let wind = Wind { density: if gravity == Vec3::ZERO { 0.0 } else { Wind::default().density }, ..Wind::default() };
    let input = FrameInput { dt: DT, gravity, bodies: &bodies, wind: &wind, skinned: None };
    if cloth.sim.state.substeps == 0 {
        prepare(&cloth.rest, &cloth.fabric, &cloth.anchors, &mut cloth.sim.state, &mut cloth.sim.memory);
    }
    let SceneCloth { rest, fabric, stepping, anchors, sim: ClothSim { state, memory, .. }, .. } = cloth;
    let done = step(rest, fabric, stepping, anchors, &input, state, memory);
    assert!(done.worst_edge.is_finite(), "the cloth blew up");
    cloth.report = done;
    if let Some((ball, slot)) = movable {
        let given = cloth.sim.memory.coupling().given(slot);
        ball.take(given);
        for &pin in hold {
            let to = &mut cloth.anchors.to[pin as usize];
            *to = ball.at + given.turn * (*to - (ball.at - given.shift));
        }
    }
    (0..masts.len() as u32).map(|slot| cloth.sim.memory.coupling().given(slot)).collect()
}

/// A sheet of `size` [m] with n by n vertices in xz, its middle at `at`.
fn sheet(n: u32, size: f32, at: Vec3, fabric: Fabric, pinned: impl Fn(u32, u32) -> bool) -> SceneCloth {
    let source = grid(n, n, |u, v| Vec3::new((u - 0.5) * size, 0.0, (v - 0.5) * size));
    let (rest, _) = RestShape::build(&source).expect("a sound sheet");
    let pins: Vec<u32> = (0..n * n).filter(|i| pinned(i / n, i % n)).collect();
    SceneCloth::new(Arc::new(rest), fabric, at, &pins)
}

/// A net of `n` by `n` vertices, hung up by its border with a tenth to spare.
fn net(n: u32, size: f32, fabric: Fabric) -> SceneCloth {
    let mut net = sheet(n, size, Vec3::ZERO, fabric, border(n));
    for x in net.anchors.from.iter_mut().chain(&mut net.anchors.to) {
        *x *= 0.9;
    }
    for x in net.sim.state.positions.iter_mut().chain(&mut net.sim.state.previous) {
        *x = (x.truncate() * 0.9).extend(x.w);
    }
    net
}

fn border(n: u32) -> impl Fn(u32, u32) -> bool {
    move |i, j| i == 0 || j == 0 || i == n - 1 || j == n - 1
}

/// Mass [kg], momentum [kg m/s] and angular momentum about the origin [kg m²/s] of the free particles.
fn momentum(cloth: &SceneCloth) -> (f32, Vec3, Vec3) {
    let mut sum = (0.0, Vec3::ZERO, Vec3::ZERO);
    for (i, x) in cloth.sim.state.positions.iter().enumerate().filter(|(_, x)| x.w > 0.0) {
        let p = cloth.sim.state.velocity(i) / x.w;
        sum = (sum.0 + 1.0 / x.w, sum.1 + p, sum.2 + x.truncate().cross(p));
    }
    sum
}

/// Faces straight above a point.
fn faces_over(cloth: &SceneCloth, p: Vec3) -> usize {
    let above = |face: &&[u32; 3]| {
        let x = face.map(|v| (cloth.sim.state.positions[v as usize].truncate() - p).as_dvec3());
        // Twice the areas, seen from above, of the triangles that the point makes with the sides.
        let area = |i: usize, j: usize| x[i].x * x[j].z - x[i].z * x[j].x;
        let areas = [area(1, 2), area(2, 0), area(0, 1)];
        let around = areas.iter().all(|a| *a > 0.0) || areas.iter().all(|a| *a < 0.0);
        around && areas.iter().zip(x).map(|(a, x)| a * x.y).sum::<f64>() / areas.iter().sum::<f64>() > 0.0
    };
    cloth.rest.topology.faces.iter().filter(above).count()
}

fn weight_of(cloth: &SceneCloth) -> f32 {
    cloth.fabric.density * cloth.rest.areas.iter().sum::<f32>() * G
}

#[test]
fn a_ball_of_a_kilogram_comes_to_rest_in_a_net_whose_pins_bear_its_weight() {
    // An elastic net brings it to rest; at the strain limit a net quivers, and the ball rolls about in it, in each start
    // otherwise.
    let elastic = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..fabric() };
    for (fabric, starts, slowest) in [(&elastic, 1, 0.05), (&fabric(), 4, 0.5)] {
        let mut mean = 0.0;
        for start in 0..starts {
            let mut net = net(24, 2.0, fabric.clone());
            let all: Vec<u32> = (0..net.anchors.particles.len() as u32).collect();
            let mut ball = Ball::new(1.0, 0.2, Vec3::new(1.0e-3 * start as f32, 0.5, 0.0));
            let (mut sum, mut fastest) = (0.0, 0.0_f32);
            for f in 0..900 {
                let given = frame(&mut net, Some(&mut ball), &[], &[(Vec3::ZERO, &all)], Vec3::NEG_Y * G);
                if f >= 840 {
                    sum += given[0].linear.y / DT / 60.0;
                    fastest = fastest.max(ball.velocity.length());
                }
            }
            let expected = -(G + weight_of(&net));
            let error = (sum / expected - 1.0).abs();
            assert!(error < 0.02, "start {start}: pins bear {sum} N of {expected} N");
            assert!(ball.at.y > -0.6 && ball.at.y < 0.0, "start {start}: the ball is at {}", ball.at);
            assert!(fastest < 2.0 * slowest, "start {start}: the ball still moves at {fastest} m/s");
            mean += fastest / starts as f32;
        }
        assert!(mean < slowest, "the ball still moves at {mean} m/s");
    }
}

#[test]
fn a_ball_that_flies_into_a_free_sheet_keeps_the_momentum_of_both() {
    for (mass, offset) in [(1.0, 0.0), (0.05, 0.2), (20.0, 0.3)] {
        let still = Fabric { density: 0.3, drag: 0.0, damping: 0.0, ..fabric() };
        let mut cloth = sheet(20, 1.0, Vec3::ZERO, still, |_, _| false);
        let mut ball =
            Ball { gravity: 0.0, velocity: Vec3::NEG_Y * 4.0, ..Ball::new(mass, 0.15, Vec3::new(offset, 0.3, 0.05)) };
        let total = |cloth: &SceneCloth, ball: &Ball| {
            let (_, p, l) = momentum(cloth);
            let own = ball.velocity * ball.mass;
            (p + own, l + ball.at.cross(own) + ball.spin * ball.inertia())
        };
        let before = total(&cloth, &ball);
        for _ in 0..30 {
            frame(&mut cloth, Some(&mut ball), &[], &[], Vec3::ZERO);
        }
        let after = total(&cloth, &ball);
        let linear = (after.0 - before.0).length() / before.0.length();
        let scale = before.0.length() * 0.5;
        let angular = (after.1 - before.1).length() / scale;
        assert!(ball.velocity.y > -3.99, "the ball of {mass} kg met nothing");
        assert!(linear < 0.01, "momentum of {mass} kg and cloth is off by {linear}");
        assert!(angular < 0.01, "angular momentum of {mass} kg and cloth is off by {angular}");
    }
}

/// Its corners stretch the sheet: sweeps for the strain limit and pushes out of the box take turns. It spins, and rubs.
#[test]
fn a_box_that_flies_into_a_sheet_spinning_gives_it_what_it_loses() {
    for (mass, held) in [(0.05, false), (1.0, false), (20.0, false), (0.05, true), (1.0, true)] {
        let still = Fabric { density: 0.3, drag: 0.0, damping: 0.0, ..fabric() };
        let n = 20;
        let mut cloth = sheet(n, 1.0, Vec3::ZERO, still, |i, j| held && i == 0 && j == 0);
        let masts: &[(Vec3, &[u32])] = if held { &[(Vec3::new(-0.5, 0.0, -0.5), &[0])] } else { &[] };
        let at = Vec3::new(0.1, 0.25, 0.05);
        let (velocity, spin) = (Vec3::NEG_Y * 4.0, Vec3::Y * 10.0);
        let turn = Quat::from_rotation_arc(Vec3::ONE.normalize(), Vec3::NEG_Y);
        let mut cube = Ball { is_box: true, turn, gravity: 0.0, velocity, spin, ..Ball::new(mass, 0.1, at) };
        let total = |cloth: &SceneCloth, cube: &Ball| {
            let (_, p, l) = momentum(cloth);
            let own = cube.velocity * cube.mass;
            (p + own, l + cube.at.cross(own) + cube.spin * cube.inertia())
        };
        let before = total(&cloth, &cube);
        let mut given = Vec3::ZERO;
        for _ in 0..30 {
            let reactions = frame(&mut cloth, Some(&mut cube), &[], masts, Vec3::ZERO);
            given += reactions.iter().map(|reaction| reaction.linear).sum::<Vec3>();
        }
        let (after, scale) = (total(&cloth, &cube), before.0.length());
        let case = format!("{mass} kg, held {held}");
        assert!(cube.velocity.y > -3.99 && cube.spin.y < 9.9, "{case}: met nothing, {} m/s, {}", cube.velocity, cube.spin);
        let linear = (after.0 + given - before.0).length() / scale;
        assert!(linear < 1.0e-3, "{case}: momentum is off by {linear}");
        // What the mast bears is not about the origin.
        let angular = (after.1 - before.1).length() / (0.5 * scale);
        assert!(held || angular < 0.02, "{case}: angular momentum is off by {angular}");
    }
}

#[test]
fn a_ball_smaller_than_a_face_is_caught_between_particles_and_momentum_is_kept() {
    let still = Fabric { drag: 0.0, damping: 0.0, ..fabric() };
    for (mass, speed) in [(0.002, 1.0), (0.02, 1.0), (0.02, 10.0)] {
        let n = 20;
        let edge = 1.0 / (n - 1) as f32;
        let mut cloth = sheet(n, 1.0, Vec3::ZERO, still.clone(), |_, _| false);
        let at = Vec3::new(0.3 * edge, 0.05, 0.3 * edge);
        let mut ball = Ball { gravity: 0.0, velocity: Vec3::NEG_Y * speed, ..Ball::new(mass, 0.4 * edge, at) };
        let total = |cloth: &SceneCloth, ball: &Ball| momentum(cloth).1 + ball.velocity * ball.mass;
        let before = total(&cloth, &ball);
        for f in 0..30 {
            frame(&mut cloth, Some(&mut ball), &[], &[], Vec3::ZERO);
            // Later the sheet may fold over it.
            let over = if f < 6 { faces_over(&cloth, ball.at) } else { 0 };
            assert_eq!(over, 0, "{mass} kg at {speed} m/s: faces over the ball at {}", ball.at);
        }
        assert!(ball.velocity.y > -0.99 * speed, "{mass} kg at {speed} m/s met nothing: {}", ball.velocity);
        let lost = total(&cloth, &ball).distance(before) / before.length();
        assert!(lost < 0.01, "{mass} kg at {speed} m/s: momentum is off by {lost}");
    }
}

#[test]
fn balls_of_a_gram_to_a_tonne_in_a_net_and_under_a_sheet_stay_stable() {
    // What is thousands of times as heavy as the cloth stretches its way through; a hundred times, it may be thrown out at the
    // default rate.
    let light = [0.001, 0.01, 0.1, 1.0, 3.0, 1000.0].map(|mass| (mass, 360.0));
    for (mass, rate) in light.into_iter().chain([3.0, 10.0, 30.0].map(|mass| (mass, 720.0))) {
        let mut net = net(20, 1.0, fabric());
        net.stepping.substep_rate = rate;
        let mut ball = Ball::new(mass, 0.15, Vec3::new(0.03, 0.3, 0.0));
        let (mut fastest, mut worst) = (0.0_f32, 0.0_f32);
        for f in 0..480 {
            frame(&mut net, Some(&mut ball), &[], &[], Vec3::NEG_Y * G);
            assert!(ball.at.is_finite() && ball.velocity.is_finite(), "a ball of {mass} kg is at {}", ball.at);
            // Nothing is thrown up higher than it fell from.
            assert!(ball.at.y < 0.31, "a ball of {mass} kg was thrown to {}", ball.at);
            worst = worst.max(net.report.worst_edge);
            if f > 420 {
                fastest = fastest.max(ball.velocity.length());
            }
        }
        let edge = net.report.worst_edge;
        if mass < 1000.0 {
            assert!(ball.at.y > -0.5, "a ball of {mass} kg fell to {}", ball.at);
            assert!(fastest < 0.5, "a ball of {mass} kg still moves at {fastest} m/s");
        } else {
            assert!(edge < 1.2, "the net that {mass} kg went through is stretched to {edge}");
        }
        // A heavy sheet falls on it, and both fall on.
        let mut sheet = sheet(20, 1.0, Vec3::Y * 0.3, Fabric { density: 1.0, ..fabric() }, |_, _| false);
        let mut ball = Ball { gravity: 0.0, ..Ball::new(mass, 0.15, Vec3::ZERO) };
        for _ in 0..60 {
            frame(&mut sheet, Some(&mut ball), &[], &[], Vec3::NEG_Y * G);
        }
        assert!(ball.velocity.y < 0.0 && ball.velocity.y > -G, "a ball of {mass} kg moves at {}", ball.velocity);
    }
}

#[test]
fn a_fast_body_far_away_costs_nothing() {
    let mut cloth = sheet(16, 1.0, Vec3::Y * 0.01, fabric(), |_, _| false);
    let floor = Body::at_rest(SharedShape::halfspace(Vec3::Y), Pose::IDENTITY);
    let pose = |x: f32| Pose::from_parts(Vec3::new(x, 1.0, 0.0), Quat::IDENTITY);
    let coupling = cloth.sim.memory.coupling_mut();
    let (from, to) = (pose(100.0), pose(100.5));
    let rigid = Rigid {
        inverse_mass: Vec3::splat(0.001),
        inverse_inertia: Mat3::IDENTITY,
        from: from.translation,
        to: to.translation,
        velocity: None,
    };
    let heavy = Some(coupling.add(rigid));
    prepare(&cloth.rest, &cloth.fabric, &cloth.anchors, &mut cloth.sim.state, &mut cloth.sim.memory);
    // The third passes by at 30 m/s, 0.3 m above.
    let cases = [(None, 100.0, 0.0), (heavy, 100.0, 0.0), (None, 0.0, 0.5), (None, 0.0, 0.9), (heavy, 0.0, 0.9)];
    for (rigid, from, rise) in cases {
        let body = Body { rigid, ..Body::new(SharedShape::ball(0.2), pose(from), pose(from + 0.5)) };
        let bodies = [floor.clone(), body];
        let wind = Wind::default();
        let input = FrameInput { dt: DT, gravity: Vec3::NEG_Y * G, bodies: &bodies, wind: &wind, skinned: None };
        let SceneCloth { rest, fabric, stepping, anchors, sim: ClothSim { state, memory, .. }, .. } = &mut cloth;
        let near = rise > 0.8;
        // Once the floor is known to be near; what is high above comes down on it.
        state.positions.iter_mut().chain(&mut state.previous).for_each(|x| x.y += rise);
        let done = (0..3).map(|_| step(rest, fabric, stepping, anchors, &input, state, memory)).last().expect("a report");
        state.positions.iter_mut().chain(&mut state.previous).for_each(|x| x.y -= rise);
        assert_eq!(done.substeps > 6, near, "{} substeps with a body at {from} m, {rigid:?}", done.substeps);
    }
}

#[test]
fn a_fast_body_costs_no_more_once_it_has_gone_though_another_lies_on_the_cloth() {
    let mut cloth = sheet(16, 1.0, Vec3::ZERO, fabric(), border(16));
    let (at, far) = (Vec3::Y * 0.12, Pose::from_translation(Vec3::X * 100.0));
    let rigid =
        Rigid { inverse_mass: Vec3::splat(3.0), inverse_inertia: Mat3::IDENTITY, from: at, to: at, velocity: Some(Vec3::ZERO) };
    let slot = cloth.sim.memory.coupling_mut().add(rigid);
    let lies = Pose::from_translation(at);
    let heavier = Body { rigid: Some(slot), ..Body::new(SharedShape::ball(0.2), lies, lies) };
    prepare(&cloth.rest, &cloth.fabric, &cloth.anchors, &mut cloth.sim.state, &mut cloth.sim.memory);
    let passes = Pose::from_parts(Vec3::new(-0.6, 0.04, 0.4), Quat::IDENTITY);
    let steps = [(far, far), (far, far), (passes, Pose::from_translation(passes.translation + Vec3::X)), (far, far)];
    let [_, before, during, after] = steps.map(|(from, to)| {
        let bodies = [heavier.clone(), Body::new(SharedShape::ball(0.05), from, to)];
        let wind = Wind::default();
        let input = FrameInput { dt: DT, gravity: Vec3::NEG_Y * G, bodies: &bodies, wind: &wind, skinned: None };
        let SceneCloth { rest, fabric, stepping, anchors, sim: ClothSim { state, memory, .. }, .. } = &mut cloth;
        let frames = (0..10).map(|_| step(rest, fabric, stepping, anchors, &input, state, memory).substeps);
        frames.take(if from == to { 10 } else { 1 }).last().expect("a frame")
    });
    assert_eq!([before, during, after], [12, 48, 12]);
}

#[test]
fn cloth_that_lies_on_a_heavier_body_takes_no_more_substeps() {
    let mut cloth = sheet(60, 0.5, Vec3::Y * 0.25, fabric(), |_, _| false);
    let mut most = 0;
    for f in 0..240 {
        // A crate of 20 kg on the ground.
        let mut crate_ = Ball::new(20.0, 0.2, Vec3::ZERO);
        crate_.gravity = 0.0;
        frame(&mut cloth, Some(&mut crate_), &[], &[], Vec3::NEG_Y * G);
        assert!(f < 60 || crate_.given.linear.y < 0.0, "frame {f}: the cloth should lie on it: {:?}", crate_.given);
        most = most.max(cloth.report.substeps);
    }
    assert_eq!(most, 6, "substeps");
}

/// Cotton that is stretched out flat gives way by nothing but its strain limit, or its springs. Once, balls heavier than it
/// went through.
#[test]
fn a_flat_sheet_bears_a_heavy_ball_at_the_default_rate() {
    let elastic = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, ..fabric() };
    let falls = [(32, 1.0, 0.05), (32, 1.0, 0.6), (48, 1.0, 0.6), (32, 3.0, 0.05), (32, 3.0, 0.6), (48, 3.0, 0.6)];
    for (fabric, lowest, longest) in [(fabric(), -0.3, 1.4), (elastic, -0.55, 1.9)] {
        for (n, mass, drop) in falls {
            let mut cloth = sheet(n, 1.0, Vec3::ZERO, fabric.clone(), border(n));
            let mut ball = Ball::new(mass, 0.1, Vec3::new(0.01, 0.1 + drop, 0.0));
            // Free to go aside, what bounces comes down beside the sheet sooner or later. On 32², 3 kg go on hopping by 13 mm.
            ball.on_rail = drop > 0.5;
            let (mut most, mut fastest) = (0, 0.0_f32);
            for f in 0..900 {
                frame(&mut cloth, Some(&mut ball), &[], &[], Vec3::NEG_Y * G);
                most = most.max(cloth.report.substeps);
                assert!(ball.at.y > lowest && ball.at.y < 0.11 + drop, "{n}², frame {f}: {mass} kg are at {}", ball.at);
                if f > 840 {
                    fastest = fastest.max(ball.velocity.length());
                }
            }
            assert!(fastest < 0.55, "{n}²: {mass} kg still move at {fastest} m/s");
            assert!(cloth.report.worst_edge < longest, "{n}²: {mass} kg draw edges out to {}", cloth.report.worst_edge);
            // Lifted off it, no more.
            ball.at.y = 3.0;
            ball.velocity = Vec3::ZERO;
            for _ in 0..3 {
                frame(&mut cloth, Some(&mut ball), &[], &[], Vec3::NEG_Y * G);
            }
            assert!(most > 6 && cloth.report.substeps == 6, "{most} substeps, then {}", cloth.report.substeps);
        }
    }
}

#[test]
fn two_sheets_on_one_light_ball_do_not_push_it_twice() {
    /// Speed at which both come down on it [m/s].
    const SPEED: f32 = 4.0;
    // Each is stepped without knowing of the other: they share the ball.
    let run = |share: f32| {
        let mut sheets = [0, 1].map(|_| sheet(12, 0.6, Vec3::Y * 0.25, Fabric { density: 1.0, ..fabric() }, |_, _| false));
        for sheet in &mut sheets {
            sheet.sim.state.substep = 1.0 / 360.0;
            sheet.sim.state.previous.iter_mut().for_each(|x| x.y += SPEED / 360.0);
        }
        let mut ball = Ball { gravity: 0.0, ..Ball::new(0.005, 0.15, Vec3::ZERO) };
        let mut fastest = 0.0_f32;
        for _ in 0..60 {
            let (rigid, body) = ball.advance();
            let mut sum = Reaction::default();
            for cloth in &mut sheets {
                let coupling = cloth.sim.memory.coupling_mut();
                coupling.clear();
                let slot = coupling.add(Rigid {
                    inverse_mass: rigid.inverse_mass * share,
                    inverse_inertia: rigid.inverse_inertia * share,
                    ..rigid
                });
                let bodies = [Body { rigid: Some(slot), ..body.clone() }];
                let wind = Wind { density: 0.0, ..Wind::default() };
                cloth.step(&FrameInput { dt: DT, gravity: Vec3::ZERO, bodies: &bodies, wind: &wind, skinned: None });
                let given = cloth.sim.memory.coupling().given(slot);
                sum.linear += given.linear;
                sum.shift += given.shift / share;
            }
            ball.take(sum);
            fastest = fastest.max(ball.velocity.length());
        }
        fastest
    };
    let (apart, shared) = (run(1.0), run(2.0));
    assert!(shared < 1.1 * SPEED, "a light ball is hit at {SPEED} m/s and gets as fast as {shared} m/s");
    assert!(apart > 1.3 * SPEED, "if each took it for its own, it would get as fast as {apart} m/s");
}

/// Inner steps let bodies push once in several of them: no weight is lost on the way.
#[test]
fn a_ball_in_a_fine_net_is_borne_by_its_pins_whole() {
    let fabric = Fabric { strain_limit: f32::INFINITY, tether_scale: f32::INFINITY, drag: 1.0, ..fabric() };
    let mut net = net(60, 0.6, fabric);
    let all: Vec<u32> = (0..net.anchors.particles.len() as u32).collect();
    // Lighter than the net, which takes no more substeps for it.
    let mut ball = Ball::new(0.08, 0.1, Vec3::Y * 0.15);
    let (mut pins, mut given) = (0.0, 0.0);
    for f in 0..600 {
        let borne = frame(&mut net, Some(&mut ball), &[], &[(Vec3::ZERO, &all)], Vec3::NEG_Y * G);
        if f >= 480 {
            pins += borne[0].linear.y / DT / 120.0;
            given += ball.given.linear.y / DT / 120.0;
        }
    }
    assert!(net.report.inner_steps >= 3, "{} inner steps", net.report.inner_steps);
    let weight = 0.08 * G;
    assert!((given / weight - 1.0).abs() < 0.02, "the net gives the ball {given} N of {weight} N");
    let expected = -(weight + weight_of(&net));
    // What is stuck in a settling cloth gives up the velocity of its last inner step, which bore load: 3 % of it. Without
    // damping pins are within 0.1 %.
    assert!((pins / expected - 1.0).abs() < 0.04, "pins bear {pins} N of {expected} N");
}

#[test]
fn two_masts_bear_their_shares_of_a_hanging_sheet() {
    masts(20);
}

#[test]
fn two_masts_bear_their_shares_of_a_fine_sheet() {
    let inner_steps = masts(90);
    assert!(inner_steps >= 3, "{inner_steps} inner steps");
}

/// A metre of `n` by `n` vertices on two masts; the inner steps that it took.
fn masts(n: u32) -> u32 {
    let mut cloth = sheet(n, 1.0, Vec3::ZERO, fabric(), |i, j| j == 0 && (i < 2 || i >= n - 2));
    let (left, right): (Vec<u32>, Vec<u32>) =
        (0..cloth.anchors.particles.len() as u32).partition(|&k| cloth.anchors.to[k as usize].x < 0.0);
    let masts = [(Vec3::NEG_X * 0.5, &left[..]), (Vec3::X * 0.5, &right[..])];
    let mut sums = [Vec3::ZERO; 2];
    for f in 0..600 {
        let given = frame(&mut cloth, None, &[], &masts, Vec3::NEG_Y * G);
        if f >= 540 {
            (0..2).for_each(|i| sums[i] += given[i].linear / DT / 60.0);
        }
    }
    let weight = weight_of(&cloth);
    for (i, sum) in sums.iter().enumerate() {
        assert!((sum.y / (-0.5 * weight) - 1.0).abs() < 0.02, "mast {i} bears {} N of {weight} N", sum.y);
    }
    assert!(sums[0].x > 0.0 && sums[1].x < 0.0, "the sheet draws its masts together: {sums:?}");
    cloth.report.inner_steps
}

#[test]
fn a_weight_on_the_corner_of_a_hanging_sheet_is_borne_by_the_other_end() {
    let n = 16;
    for mass in [0.02, 0.2, 2.0] {
        let source = grid(n, n, |u, v| Vec3::new(u - 0.5, -v, 0.0));
        let (rest, _) = RestShape::build(&source).expect("a sound sheet");
        let pins: Vec<u32> = (0..n).flat_map(|i| [i * n, i * n + n - 1]).collect();
        let mut cloth = SceneCloth::new(Arc::new(rest), Fabric { drag: 0.5, ..fabric() }, Vec3::ZERO, &pins);
        let (top, low): (Vec<u32>, Vec<u32>) =
            (0..cloth.anchors.particles.len() as u32).partition(|&k| cloth.anchors.to[k as usize].y > -0.5);
        let mut ball = Ball::new(mass, 0.1, Vec3::new(0.0, -1.0, 0.0));
        let (mut sum, mut fastest) = (0.0, 0.0_f32);
        for f in 0..600 {
            let given = frame(&mut cloth, Some(&mut ball), &low, &[(Vec3::ZERO, &top)], Vec3::NEG_Y * G);
            if f >= 540 {
                sum += given[0].linear.y / DT / 60.0;
                fastest = fastest.max(ball.velocity.length());
            }
        }
        // What is pinned to the ball weighs nothing.
        let own: f32 = low.iter().map(|&k| cloth.rest.areas[cloth.anchors.particles[k as usize] as usize]).sum();
        let expected = -(mass * G + weight_of(&cloth) - own * cloth.fabric.density * G);
        assert!((sum / expected - 1.0).abs() < 0.02, "pins bear {sum} N of {expected} N");
        assert!(ball.at.y > -1.2, "the weight of {mass} kg is at {}", ball.at);
        assert!(fastest < 0.02, "the weight of {mass} kg still moves at {fastest} m/s");
    }
}
