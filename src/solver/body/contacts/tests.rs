//! A few particles and a body, in frames of one substep.

use fastrand::Rng;
use glam::{Mat3, Quat, vec3};
use parry3d::shape::{Shape, SharedShape};

use super::*;
use crate::solver::body::respond::{IMPACT_SPEED, Projection};
use crate::solver::body::{Bearing, Body, BodyContext, Provisional, Touch, shape};
use crate::solver::couple::{Coupling, Rigid};

const H: f32 = 1.0 / 480.0;
const KEEP: f32 = 0.005;
const MM: f32 = 1.0e-3;
/// Inverse mass of a particle `[1/kg]`.
const W: f32 = 2.0;
/// What counts as nothing `[m]`.
const ROUNDING: f32 = 1.0e-6;

struct Scene {
    bodies: Vec<Body>,
    touch: Touch,
    coupling: Coupling,
    positions: Vec<Vec4>,
    previous: Vec<Vec4>,
    contacts: BodyContacts,
}

impl Scene {
    /// Particles at rest, listed for a frame.
    fn new(bodies: Vec<Body>, particles: &[Vec3]) -> Self {
        let positions: Vec<Vec4> = particles.iter().map(|x| x.extend(W)).collect();
        let touch = Touch { thickness: KEEP, static_friction: 0.0, dynamic_friction: 0.0, restitution: 0.0 };
        let (coupling, contacts) = (Coupling::default(), BodyContacts::default());
        let mut scene = Self { bodies, touch, coupling, previous: positions.clone(), positions, contacts };
        scene.gather();
        scene
    }

    fn gather(&mut self) {
        let approach = Approach { dt: H, substep: H, gravity: Vec3::ZERO, thickness: KEEP, extra: 0.05 };
        self.contacts.gather(&self.bodies, &self.positions, &self.previous, &approach);
    }

    fn context(&mut self) -> (&mut BodyContacts, BodyContext<'_>, &mut [Vec4], &mut [Vec4]) {
        let Self { bodies, touch, coupling, positions, previous, contacts } = self;
        (contacts, BodyContext { bodies, span: (0.0, 1.0), touch: *touch, coupling }, positions, previous)
    }

    /// Moves all particles by `way` `[m]` and out of bodies. Returns the number of contacts.
    fn project(&mut self, way: Vec3) -> u32 {
        self.previous.clone_from(&self.positions);
        self.positions.iter_mut().for_each(|x| *x += way.extend(0.0));
        let inbound = vec![way.extend(0.0); self.positions.len()];
        let (contacts, mut context, positions, previous) = self.context();
        contacts.project(&mut context, positions, previous, &inbound, Projection::First)
    }

    fn rub(&mut self) {
        let (contacts, mut context, positions, previous) = self.context();
        contacts.apply_friction(&mut context, positions, previous);
    }

    fn at(&self, particle: usize) -> Vec3 {
        self.positions[particle].truncate()
    }

    fn way(&self, particle: usize) -> Vec3 {
        (self.positions[particle] - self.previous[particle]).truncate()
    }

    fn load(&self) -> f32 {
        self.contacts.loads().map(|(_, _, load)| load).sum()
    }
}

/// One particle that lies on a floor.
fn on_floor() -> Scene {
    Scene::new(vec![floor()], &[KEEP * Vec3::Y])
}

fn floor() -> Body {
    Body::at_rest(shape::half_space(Vec3::Y).expect("a floor"), Pose::IDENTITY)
}

fn near(a: Vec3, b: Vec3) -> bool {
    a.distance(b) < ROUNDING
}

fn distance(shape: &dyn Shape, x: Vec3) -> f32 {
    let nearest = shape.project_local_point(x, false);
    if nearest.is_inside { -nearest.point.distance(x) } else { nearest.point.distance(x) }
}

/// Shapes, and a place on each with the normal there `[m]`.
fn shapes() -> Vec<(&'static str, SharedShape, [Vec3; 2])> {
    let slope = vec3(0.6, 0.8, 0.0);
    let capsule = shape::capsule_between(vec3(-0.2, 0.0, 0.0), vec3(0.2, 0.0, 0.0), 0.1);
    let corners: Vec<Vec3> = (0..8).map(|k| 0.2 * vec3((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2) as f32)).collect();
    vec![
        ("floor", shape::half_space(Vec3::Y).expect("a floor"), [vec3(0.3, 0.0, -0.2), Vec3::Y]),
        ("slope", shape::half_space(slope).expect("a slope"), [vec3(-0.8, 0.6, 0.5), slope]),
        ("ball", shape::ball(0.3).expect("a ball"), [0.3 * slope, slope]),
        ("capsule", capsule.expect("a capsule"), [vec3(0.1, -0.1, 0.0), Vec3::NEG_Y]),
        ("cuboid", shape::cuboid(vec3(0.1, 0.2, 0.3)).expect("a box"), [vec3(0.1, 0.05, 0.1), Vec3::X]),
        ("cylinder", shape::cylinder(0.1, 0.2).expect("a cylinder"), [vec3(0.06, 0.05, -0.08), vec3(0.6, 0.0, -0.8)]),
        ("hull", shape::convex_hull(&corners).expect("a hull"), [vec3(0.1, 0.2, 0.1), Vec3::Y]),
    ]
}

#[test]
fn a_particle_that_goes_in_ends_at_the_distance_kept_and_what_is_held_or_elsewhere_stays() {
    let pose = Pose::from_parts(vec3(0.2, -0.1, 0.3), Quat::from_rotation_z(0.5));
    for (name, shape, [place, normal]) in shapes() {
        // 2 mm below the distance kept, 5 mm into the shape, and 8 cm into it within the substep.
        for (margin, depth) in [(0.0, 2.0), (0.0, 10.0), (0.002, 2.0), (0.002, 80.0)] {
            let keep = KEEP + margin;
            let over = |gap: f32| pose.transform_point(place + normal * (keep + gap));
            let held = pose.transform_point(place - 0.001 * normal);
            let body = Body { margin, ..Body::at_rest(shape.clone(), pose) };
            let mut scene = Scene::new(vec![body], &[over(MM), held, over(0.2)]);
            scene.positions[1].w = 0.0;
            scene.gather();
            let way = pose.rotation * (normal * (-MM - depth * MM));
            let contacts = scene.project(way);
            let gap = distance(&*shape.0, pose.inverse_transform_point(scene.at(0))) - keep;
            assert!(contacts == 1 && gap.abs() < 2.0 * ROUNDING, "{name}, {depth} mm: {gap} m off, {contacts} touch");
            assert!(near(scene.at(0), over(0.0)), "{name}, {depth} mm: pushed aside to {}", scene.at(0));
            assert_eq!(scene.previous[0], over(MM).extend(W), "{name}: its speed is what is left of its way");
            assert_eq!([1, 2].map(|k| scene.at(k)), [held + way, over(0.2) + way], "{name}");
            let pushed = depth * MM;
            assert!((scene.load() - pushed).abs() < 2.0 * ROUNDING, "{name}: a load of {} m", scene.load());
        }
    }
}

#[test]
fn what_only_comes_near_is_left_where_it_is() {
    for (name, shape, [place, normal]) in shapes() {
        let start = place + normal * (KEEP + 3.0 * MM);
        let mut scene = Scene::new(vec![Body::at_rest(shape, Pose::IDENTITY)], &[start]);
        let contacts = scene.project(-2.0 * MM * normal);
        assert_eq!((contacts, scene.at(0), scene.load()), (0, start - 2.0 * MM * normal, 0.0), "{name}");
    }
}

#[test]
fn an_overlap_is_brought_out_at_its_speed_and_gives_none() {
    // Height over the plane at the start, way in the substep; height and way afterwards [mm]. 1 m/s is 2.083 mm in it.
    for (gap, way, end, left) in [
        (-0.5, 0.0, 0.0, 0.0),
        (-4.0, 0.0, -1.917, 0.0),
        (-4.0, -1.0, -1.917, 0.0),
        (-4.0, 1.0, -1.917, 1.0),
        (-4.0, 3.0, -1.0, 3.0),
        (-0.5, -1.0, 0.0, 0.0),
        (0.0, -1.0, 0.0, 0.0),
        (1.0, -3.0, 0.0, -1.0),
    ] {
        let mut scene = Scene::new(vec![floor()], &[(KEEP + gap * MM) * Vec3::Y]);
        scene.project(way * MM * Vec3::Y);
        let (height, way_left) = ((scene.at(0).y - KEEP) / MM, scene.way(0).y / MM);
        let as_expected = (height - end).abs() < 2.0e-3 && (way_left - left).abs() < 2.0e-3;
        assert!(as_expected, "{gap} mm over it by {way} mm: {height} mm over it by {way_left} mm");
    }
}

#[test]
fn friction_holds_within_the_cone_and_takes_its_share_beyond() {
    // Pushed by 2 mm. Static and dynamic friction of body and fabric, way along the floor; what is left of it [mm].
    for (body, fabric, slip, left) in [
        ([0.5, 0.4], [0.5, 0.4], 0.99, 0.0),
        ([0.5, 0.4], [0.5, 0.4], 1.01, 0.21),
        ([0.5, 0.4], [0.5, 0.4], 5.0, 4.2),
        ([1.0, 0.9], [0.25, 0.1], 0.9, 0.0),
        ([1.0, 0.9], [0.25, 0.1], 1.1, 0.5),
        ([0.5, 0.4], [0.0, 0.0], 0.5, 0.5),
        ([0.1, 0.4], [0.1, 0.4], 0.7, 0.0),
        ([f32::NAN, 0.4], [0.5, f32::INFINITY], 0.5, 0.5),
    ] {
        for along in [Vec3::X, vec3(0.6, 0.0, -0.8)] {
            let mut scene = on_floor();
            (scene.bodies[0].static_friction, scene.bodies[0].dynamic_friction) = body.into();
            (scene.touch.static_friction, scene.touch.dynamic_friction) = fabric.into();
            scene.project(slip * MM * along - 2.0 * MM * Vec3::Y);
            scene.rub();
            let expected = left * MM * along;
            assert!(near(scene.way(0), expected), "{body:?} on {fabric:?}, {slip} mm: {} mm left", scene.way(0) / MM);
        }
    }
}

#[test]
fn what_was_pushed_off_is_not_held_and_what_is_within_the_band_is() {
    for (off, held) in [(0.0, true), (0.09, true), (0.11, false), (1.0, false), (-1.0, true)] {
        let mut scene = on_floor();
        (scene.touch.static_friction, scene.touch.dynamic_friction) = (1.0, 1.0);
        scene.project(vec3(0.5, -2.0, 0.0) * MM);
        scene.positions[0].y += off * MM;
        scene.rub();
        let left = scene.way(0).x / MM;
        assert_eq!(left.abs() < 1.0e-3, held, "{off} mm off: {left} mm left");
    }
}

#[test]
fn a_body_that_moves_or_turns_takes_along_what_lies_on_it() {
    let at = vec3(0.1, KEEP, 0.0);
    let poses = [
        Pose::from_translation(vec3(0.5, 0.0, 0.3) * MM),
        Pose::from_rotation(Quat::from_rotation_y(0.008)),
        Pose::from_parts(0.2 * MM * Vec3::X, Quat::from_rotation_y(-0.004)),
    ];
    for to in poses {
        for (friction, share) in [(1.0, 1.0), (0.0, 0.0)] {
            let mut scene = Scene::new(vec![Body { to, ..floor() }], &[at]);
            (scene.touch.static_friction, scene.touch.dynamic_friction) = (friction, friction);
            scene.project(-2.0 * MM * Vec3::Y);
            scene.rub();
            let expected = at.lerp(to.transform_point(at), share);
            assert!(near(scene.at(0), expected), "{friction}: at {}, {expected} expected", scene.at(0));
        }
    }
}

#[test]
fn what_strikes_faster_than_it_rests_leaves_with_its_share_of_that_speed() {
    for (restitution, speed, back) in [
        (0.5, 2.0, 1.0),
        (0.5, 0.9 * IMPACT_SPEED, 0.0),
        (0.5, 1.1 * IMPACT_SPEED, 0.55 * IMPACT_SPEED),
        (7.0, 2.0, 2.0),
        (0.0, 2.0, 0.0),
        (f32::NAN, 2.0, 0.0),
    ] {
        let mut scene = on_floor();
        scene.touch.restitution = restitution;
        scene.project(-speed * H * Vec3::Y);
        let left = scene.way(0).y / H;
        assert!((left - back).abs() < 1.0e-3, "{restitution}: {speed} m/s in, {left} m/s out");
    }
}

#[test]
fn what_is_drawn_off_its_plane_again_is_pushed_out_by_the_gap_unless_it_is_too_deep() {
    // Off the plane, after that, and what the load gains of it [mm].
    for (off, left, gain) in [(-1.0, 0.0, 0.25), (-9.9, 0.0, 2.475), (-10.1, -10.1, 0.0), (0.5, 0.5, 0.0)] {
        let mut scene = on_floor();
        scene.project(vec3(0.3, -2.0, 0.0) * MM);
        scene.positions[0].y += off * MM;
        let (contacts, mut context, positions, _) = scene.context();
        contacts.push_to_planes(&mut context, positions);
        let (end, load) = ((scene.at(0) - KEEP * Vec3::Y) / MM, scene.load() / MM);
        assert!(end.distance(vec3(0.3, left, 0.0)) < 2.0e-3, "{off} mm: {end} mm");
        assert!((load - 2.0 - gain).abs() < 2.0e-3, "{off} mm: a load of {load} mm");
    }
}

#[test]
fn what_is_laid_provisionally_goes_back_to_the_same_bits_and_takes_along_what_moved_it() {
    let rng = &mut Rng::with_seed(2);
    // About the origin, where a difference of coordinates is rounded.
    let pose = Pose::from_parts(-KEEP * Vec3::Y, Quat::from_rotation_z(0.4));
    let shape = shape::half_space(Vec3::Y).expect("a slope");
    let mut over = |gap: f32| pose.transform_point(vec3(5.0 * MM * rng.f32(), KEEP + gap, 0.0));
    let mut particles: Vec<Vec3> = (0..40).map(|_| over(0.0)).collect();
    particles.push(over(0.02));
    let mut scene = Scene::new(vec![Body::at_rest(shape, pose)], &particles);
    scene.project(pose.rotation * (-2.0 * MM * Vec3::Y));
    let draw = |x: Vec3| 0.97 * (x + pose.rotation * vec3(0.1, -1.3, 0.7) * MM);
    scene.positions.iter_mut().for_each(|x| *x = draw(x.truncate()).extend(x.w));
    let drawn = scene.positions.clone();
    for way in [Vec3::ZERO, vec3(1.0, 2.0, -3.0) * MM] {
        let mut provisional = Provisional::default();
        let (contacts, mut context, positions, _) = scene.context();
        contacts.project_provisionally(&mut context, positions, &mut provisional);
        for x in &scene.positions[..40] {
            let height = pose.inverse_transform_point(x.truncate()).y;
            assert!((height - KEEP).abs() < 2.0 * ROUNDING, "{height}");
        }
        assert_eq!(scene.positions[40], drawn[40], "it touched nothing");
        scene.positions[0] += way.extend(0.0);
        provisional.restore(&mut scene.positions);
        assert_eq!(scene.positions[1..], drawn[1..], "what nothing else moved");
        let left = scene.at(0) - drawn[0].truncate() - way;
        assert!(left.length() < 2.0 * ROUNDING, "{left}");
    }
}

#[test]
fn all_that_touches_is_told_of_with_the_way_of_the_ground_below() {
    let to = Pose::from_translation(vec3(1.0, 0.0, 2.0) * MM);
    let mut scene = Scene::new(vec![Body { to, ..floor() }], &[KEEP * Vec3::Y, 0.1 * Vec3::Y]);
    scene.project(-MM * Vec3::Y);
    let (contacts, mut context, positions, _) = scene.context();
    let mut told = Vec::new();
    contacts.each_touch(&mut context, positions, |particle, bearing| told.push((particle, bearing)));
    let [(0, Some(bearing))] = &told[..] else { panic!("{} are told of", told.len()) };
    let Bearing { at, normal, way } = bearing;
    assert!(near((*at).into(), KEEP * Vec3::Y) && near((*normal).into(), Vec3::Y), "{at}, {normal}");
    assert!(near((*way).into(), to.translation), "{way}");
}

#[test]
fn a_body_that_cloth_moves_takes_what_the_particle_gets_and_both_part_to_the_distance_kept() {
    let start = vec3(0.0, 0.1 + KEEP, 0.0);
    for (mass, share) in [(0.5, 0.5), (1.5, 0.75), (1.0e6, 1.0)] {
        let ball = Body::at_rest(shape::ball(0.1).expect("a ball"), Pose::IDENTITY);
        let mut scene = Scene::new(vec![Body { rigid: Some(0), ..ball }], &[start]);
        scene.coupling.add(Rigid {
            inverse_mass: Vec3::splat(1.0 / mass),
            inverse_inertia: Mat3::IDENTITY,
            ..Rigid::immovable(Vec3::ZERO, Vec3::ZERO)
        });
        scene.project(-2.0 * MM * Vec3::Y);
        let (by, given) = (scene.at(0).y - start.y + 2.0 * MM, scene.coupling.given(0));
        assert!((by - share * 2.0 * MM).abs() < ROUNDING, "{mass} kg: pushed by {by} m");
        assert!((given.linear.y + by / W / H).abs() < 1.0e-4, "{mass} kg: {}", given.linear);
        let apart = scene.at(0).y - given.shift.y - 0.1;
        assert!((apart - KEEP).abs() < ROUNDING, "{mass} kg: {apart} m apart");
        let before = scene.at(0).y - MM;
        scene.positions[0].y = before;
        let (contacts, mut context, positions, _) = scene.context();
        contacts.push_to_planes(&mut context, positions);
        let (by, again) = (scene.at(0).y - before, scene.coupling.given(0));
        assert!((by - share * MM).abs() < ROUNDING, "{mass} kg: pushed by {by} m again");
        assert!((again.linear.y - given.linear.y + by / W / H).abs() < 1.0e-4, "{mass} kg: {} again", again.linear);
    }
}

#[test]
fn between_two_bodies_that_leave_no_room_it_is_in_the_middle_and_stays() {
    let down = shape::half_space(Vec3::NEG_Y).expect("a ceiling");
    let ceiling = Body::at_rest(down, Pose::from_translation(6.0 * MM * Vec3::Y));
    let mut scene = Scene::new(vec![floor(), ceiling], &[4.0 * MM * Vec3::Y]);
    for substep in 0..5 {
        scene.project(Vec3::ZERO);
        assert!((scene.at(0).y - 3.0 * MM).abs() < ROUNDING, "substep {substep}: {}", scene.at(0));
    }
}

#[test]
fn a_load_is_a_mean_that_outlives_the_frame_but_not_the_contact() {
    let mut scene = on_floor();
    // Pushed in each frame, and the load then [mm]: the newest is a quarter of it.
    for (push, load) in [(2.0, 2.0), (4.0, 2.5), (2.5, 2.5), (0.5, 2.0)] {
        scene.gather();
        scene.project(-push * MM * Vec3::Y);
        assert!((scene.load() / MM - load).abs() < 1.0e-3, "{push} mm: a load of {} mm", scene.load() / MM);
    }
    scene.gather();
    assert!(scene.load() > 0.0, "it is known before the first substep");
    scene.project(20.0 * MM * Vec3::Y);
    assert_eq!((scene.load(), scene.contacts.touching().count()), (0.0, 0));
    scene.gather();
    scene.project(-22.0 * MM * Vec3::Y);
    assert!((scene.load() / MM - 2.0).abs() < 1.0e-3, "begun anew: {} mm", scene.load() / MM);
}

#[test]
fn loads_go_with_their_particles_and_bodies_whatever_numbers_these_get() {
    let wall = |x: f32| {
        let shape = shape::half_space(Vec3::X).expect("a wall");
        Body::at_rest(shape, Pose::from_translation(x * Vec3::X))
    };
    // Every other particle lies on the floor; none is near the walls but one that lies on the second.
    let height = |k: usize| if k.is_multiple_of(2) { KEEP } else { 0.02 };
    let mut particles: Vec<Vec3> = (0..8).map(|k| vec3(0.1 * k as f32, height(k), 0.0)).collect();
    particles.push(vec3(-0.5 + KEEP, 0.02, 0.0));
    let mut scene = Scene::new(vec![floor(), wall(-2.0), wall(-0.5)], &particles);
    scene.project(vec3(-1.0, -2.0, 0.0) * MM);
    let pushes = |scene: &Scene| -> Vec<(usize, u32, i32)> {
        scene.contacts.loads().map(|(body, particle, load)| (body, particle, (load / MM).round() as i32)).collect()
    };
    assert_eq!(pushes(&scene), [(0, 0, 2), (0, 2, 2), (0, 4, 2), (0, 6, 2), (2, 8, 1)]);
    // The first wall is gone, the floor comes last.
    scene.bodies = vec![floor(), wall(-0.5)];
    scene.contacts.renumber(|body| [Some(0), None, Some(1)][body as usize]);
    // One leaves, and is not listed any more.
    (scene.positions[4].y, scene.previous[4].y) = (1.0, 1.0);
    scene.gather();
    assert_eq!(pushes(&scene), [(0, 0, 2), (0, 2, 2), (0, 6, 2), (1, 8, 1)]);
    scene.contacts.leave_out(&[2, 8]);
    assert_eq!(pushes(&scene), [(0, 0, 2), (0, 6, 2)]);
    let before = scene.positions.clone();
    scene.project(-2.0 * MM * Vec3::Y);
    assert_eq!(pushes(&scene), [(0, 0, 2), (0, 6, 2)]);
    assert_eq!(scene.positions[2], before[2] - (2.0 * MM * Vec3::Y).extend(0.0), "it goes through");
    scene.contacts.renumber(|_| None);
    assert!(!scene.contacts.is_near(0) && pushes(&scene).is_empty());
}

#[test]
fn every_free_particle_that_may_reach_a_body_in_the_frame_is_listed() {
    let rng = &mut Rng::with_seed(1);
    let (mut listed, mut reach_it) = (0, 0);
    let moving = [false, true].into_iter().flat_map(|moves| shapes().into_iter().map(move |shape| (moves, shape)));
    for (moves, (name, shape, _)) in moving {
        let mut point = || vec3(rng.f32(), rng.f32(), rng.f32()) - 0.5;
        let from = Pose::from_translation(0.3 * point());
        let to = Pose::from_parts(from.translation + 0.1 * point(), Quat::from_rotation_x(0.2));
        let positions: Vec<Vec3> = (0..400).map(|_| 1.5 * point()).collect();
        let body = Body { margin: 0.03, ..Body::new(shape.clone(), from, if moves { to } else { from }) };
        let poses = [body.from, body.to];
        let mut scene = Scene::new(vec![body], &positions);
        let speed = 0.05 * point();
        scene.previous.iter_mut().for_each(|x| *x -= speed.extend(0.0));
        (0..400).step_by(5).for_each(|k| scene.positions[k].w = 0.0);
        scene.positions[1].x = f32::NAN;
        scene.gather();
        let of: Vec<u32> = scene.contacts.candidates.iter().map(|candidate| candidate.particle).collect();
        assert!(of.is_sorted_by(|a, b| a < b) && !of.contains(&1), "{name}");
        let reach = KEEP + 0.03 + 0.05 + speed.length();
        for (k, x) in (0..).zip(&scene.positions).filter(|(_, x)| x.is_finite()) {
            let gap = poses.map(|pose| distance(&*shape.0, pose.inverse_transform_point(x.truncate())));
            let gap = gap[0].min(gap[1]);
            let is_listed = of.binary_search(&k).is_ok();
            assert!(is_listed || gap > reach || x.w == 0.0, "{name}: {gap} m away");
            // Over the corner of a box around a ball.
            assert!(!is_listed || (x.w > 0.0 && gap < 0.7), "{name}: {gap} m away");
            reach_it += usize::from(gap < reach);
        }
        listed += of.len();
    }
    assert!(reach_it > 600 && listed < 3800, "{listed} listed, {reach_it} reach it");
}
