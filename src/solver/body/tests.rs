//! Scenes of particles and bodies: nothing passes through, nothing bounces, friction is Coulomb's.

use glam::{Quat, Vec3, Vec4};
use parry3d::math::Pose;
use parry3d::query::Ray;
use parry3d::shape::{SharedShape, TypedShape};

use super::*;
use crate::solver::couple::Coupling;

const RATE: f32 = 480.0;
const SUBSTEPS: u32 = 8;
const H: f32 = 1.0 / RATE;
const DT: f32 = SUBSTEPS as f32 * H;
const THICKNESS: f32 = 0.005;
const GRAVITY: Vec3 = Vec3::new(0.0, -9.81, 0.0);

fn touch(friction: f32) -> Touch {
    Touch { thickness: THICKNESS, static_friction: friction, dynamic_friction: friction, restitution: 0.0 }
}

#[derive(Default)]
struct Scene {
    positions: Vec<Vec4>,
    previous: Vec<Vec4>,
    springs: Vec<(usize, usize, f32)>,
    contacts: BodyContacts,
    touching: u32,
    gravity: Vec3,
    friction: f32,
}

impl Scene {
    /// A sheet of `n x n` particles in the plane of `x` and `z`, at one velocity.
    fn sheet(n: usize, size: f32, turn: Quat, center: Vec3, velocity: Vec3) -> Self {
        let mut scene = Self { friction: 0.4, ..Self::default() };
        for i in 0..n {
            for j in 0..n {
                let at = Vec3::new(i as f32, 0.0, j as f32) / (n - 1) as f32 - Vec3::new(0.5, 0.0, 0.5);
                let x = turn * (at * size) + center;
                scene.positions.push(x.extend(1.0));
                scene.previous.push((x - velocity * H).extend(0.0));
            }
        }
        scene
    }

    fn with_springs(mut self, n: usize) -> Self {
        let mut join = |a: usize, b: usize| {
            let rest = (self.positions[a] - self.positions[b]).truncate().length();
            self.springs.push((a, b, rest));
        };
        for i in 0..n {
            for j in 0..n {
                let a = i * n + j;
                if j + 1 < n {
                    join(a, a + 1);
                }
                if i + 1 < n {
                    join(a, a + n);
                }
                if i + 1 < n && j + 1 < n {
                    join(a, a + n + 1);
                    join(a + 1, a + n);
                }
            }
        }
        self
    }

    fn frame(&mut self, bodies: &[Body], mut check: impl FnMut(f32, f32, &[Vec4], &[Vec4])) {
        let approach = Approach { dt: DT, substep: H, gravity: self.gravity, thickness: THICKNESS, extra: 0.0 };
        self.contacts.gather(bodies, &self.positions, &self.previous, &approach);
        for k in 0..SUBSTEPS {
            let (s0, s1) = (k as f32 / SUBSTEPS as f32, (k + 1) as f32 / SUBSTEPS as f32);
            for (x, prev) in self.positions.iter_mut().zip(&mut self.previous) {
                if x.w > 0.0 {
                    let next = *x + (*x - *prev).truncate().extend(0.0) + (self.gravity * H * H).extend(0.0);
                    *prev = *x;
                    *x = next;
                }
            }
            for &(a, b, rest) in &self.springs {
                let d = (self.positions[b] - self.positions[a]).truncate();
                let push = d * (0.5 * (1.0 - rest / d.length()));
                self.positions[a] += push.extend(0.0);
                self.positions[b] -= push.extend(0.0);
            }
            let before = self.previous.clone();
            let (touch, mut coupling) = (touch(self.friction), Coupling::default());
            let Self { contacts, positions, previous, .. } = self;
            let mut context = BodyContext { bodies, span: (s0, s1), touch, coupling: &mut coupling };
            self.touching = contacts.project(&mut context, positions, previous, &[], Projection::First);
            contacts.apply_friction(&mut context, positions, previous);
            check(s0, s1, &before, &self.positions);
        }
    }

    fn velocity(&self, i: usize) -> Vec3 {
        (self.positions[i] - self.previous[i]).truncate() / H
    }

    fn center(&self) -> Vec3 {
        self.positions.iter().map(|x| x.truncate()).sum::<Vec3>() / self.positions.len() as f32
    }
}

fn lerp(body: &Body, s: f32) -> Pose {
    Pose::from_parts(
        body.from.translation.lerp(body.to.translation, s),
        body.from.rotation.lerp(body.to.rotation, s).normalize(),
    )
}

fn is_surface(shape: &SharedShape) -> bool {
    matches!(shape.as_typed_shape(), TypedShape::TriMesh(_) | TypedShape::HeightField(_))
}

/// Whether a straight way in body space goes through the shape.
fn passes(shape: &SharedShape, a: Vec3, b: Vec3) -> bool {
    if is_surface(shape) {
        a != b && shape.cast_local_ray(&Ray::new(a, b - a), 1.0, false).is_some()
    } else {
        (0..=16).any(|k| shape.contains_local_point(a.lerp(b, k as f32 / 16.0)))
    }
}

fn distance(shape: &SharedShape, q: Vec3) -> f32 {
    let p = shape.project_local_point(q, false);
    if p.is_inside && !is_surface(shape) { -p.point.distance(q) } else { p.point.distance(q) }
}

/// A bumpy grid of triangles, wound to face up.
fn hills(n: usize, size: f32, height: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut vertices = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let (u, v) = (i as f32 / (n - 1) as f32, j as f32 / (n - 1) as f32);
            let y = height * ((u * 9.0).sin() + (v * 7.0).cos()) * 0.5;
            vertices.push(Vec3::new((u - 0.5) * size, y, (v - 0.5) * size));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            let a = (i * n + j) as u32;
            let b = a + n as u32;
            triangles.push([a, a + 1, b]);
            triangles.push([b, a + 1, b + 1]);
        }
    }
    (vertices, triangles)
}

fn sphere_mesh() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    parry3d::shape::Ball::new(0.3).to_trimesh(24, 16)
}

fn shapes() -> Vec<(&'static str, SharedShape)> {
    let (vertices, triangles) = hills(17, 1.4, 0.1);
    let heights: Vec<f32> = vertices.iter().map(|p| p.y).collect();
    let random_points: Vec<Vec3> = {
        let mut random = fastrand::Rng::with_seed(4);
        let mut axis = move || random.f32() - 0.5;
        (0..60).map(|_| Vec3::new(axis(), axis(), axis()) * 0.7).collect()
    };
    let (ball_vertices, ball_triangles) = sphere_mesh();
    vec![
        ("ball", shape::ball(0.3).unwrap()),
        ("small ball", shape::ball(0.02).unwrap()),
        ("capsule", shape::capsule_between(Vec3::new(-0.4, 0.0, 0.0), Vec3::new(0.4, 0.1, 0.0), 0.1).unwrap()),
        ("cuboid", shape::cuboid(Vec3::new(0.4, 0.2, 0.3)).unwrap()),
        ("thin cuboid", shape::cuboid(Vec3::new(0.4, 0.001, 0.4)).unwrap()),
        ("cylinder", shape::cylinder(0.3, 0.2).unwrap()),
        ("cone", shape::cone(0.3, 0.3).unwrap()),
        ("convex hull", shape::convex_hull(&random_points).unwrap()),
        ("half-space", shape::half_space(Vec3::Y).unwrap()),
        ("triangle mesh", shape::trimesh(vertices, triangles).unwrap()),
        ("closed triangle mesh", shape::solid_trimesh(ball_vertices, ball_triangles).unwrap()),
        ("height field", shape::heightfield(17, 17, &heights, Vec3::new(1.4, 1.0, 1.4)).unwrap()),
        (
            "compound",
            shape::compound(vec![
                (Pose::translation(-0.25, 0.0, 0.0), shape::cuboid(Vec3::new(0.25, 0.1, 0.3)).unwrap()),
                (Pose::translation(0.25, 0.0, 0.0), shape::cuboid(Vec3::new(0.25, 0.1, 0.3)).unwrap()),
                (Pose::translation(0.0, 0.1, 0.0), shape::ball(0.15).unwrap()),
            ])
            .unwrap(),
        ),
    ]
}

fn poses() -> [(&'static str, Quat); 2] {
    [("straight", Quat::IDENTITY), ("turned", Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.2))]
}

/// No way of any particle in any substep goes through a body.
fn assert_nothing_passes(what: &str, scene: &mut Scene, frames: u32, mut body: impl FnMut(u32) -> Body) {
    let mut passed = 0;
    let mut deepest = f32::MAX;
    for f in 0..frames {
        let body = body(f);
        let bodies = [body.clone()];
        scene.frame(&bodies, |s0, s1, before, after| {
            let (from, to) = (lerp(&body, s0), lerp(&body, s1));
            for (a, b) in before.iter().zip(after) {
                let (a, b) = (from.inverse_transform_point(a.truncate()), to.inverse_transform_point(b.truncate()));
                passed += u32::from(passes(&body.shape, a, b));
                deepest = deepest.min(distance(&body.shape, b));
            }
        });
    }
    assert!(scene.positions.iter().all(|x| x.is_finite()), "{what}: not finite");
    assert_eq!(passed, 0, "{what}: {passed} ways went through, nearest {:.2} mm", deepest * 1e3);
}

#[test]
fn particles_dropped_at_10_and_30_metres_per_second_stay_outside_of_every_shape() {
    for (name, shape) in shapes() {
        for (how, turn) in poses() {
            for speed in [10.0, 30.0] {
                let mut scene = Scene::sheet(24, 1.2, Quat::IDENTITY, Vec3::Y * 1.1, Vec3::NEG_Y * speed);
                scene.gravity = GRAVITY;
                let body = Body::at_rest(shape.clone(), Pose::from_rotation(turn));
                assert_nothing_passes(&format!("{name}, {how}, {speed} m/s"), &mut scene, 20, |_| body.clone());
            }
        }
    }
}

#[test]
fn every_shape_driven_at_10_and_30_metres_per_second_pushes_the_sheet_before_it() {
    for (name, shape) in shapes() {
        for (how, turn) in poses() {
            for speed in [10.0, 30.0] {
                let mut scene = Scene::sheet(24, 1.2, Quat::IDENTITY, Vec3::ZERO, Vec3::ZERO);
                let spin = Quat::from_rotation_y(2.0 * DT);
                let pose = |f: u32| {
                    let y = -0.75 + speed * DT * f as f32;
                    Pose::from_parts(Vec3::new(0.0, y, 0.0), (0..f).fold(turn, |q, _| (spin * q).normalize()))
                };
                assert_nothing_passes(&format!("{name}, {how}, {speed} m/s"), &mut scene, 12, |f| {
                    Body::new(shape.clone(), pose(f), pose(f + 1))
                });
            }
        }
    }
}

#[test]
fn at_rest_every_particle_on_a_shape_keeps_more_than_half_the_thickness() {
    for (name, shape) in shapes() {
        let mut scene = Scene::sheet(16, 0.5, Quat::IDENTITY, Vec3::Y * 0.45, Vec3::ZERO).with_springs(16);
        scene.gravity = GRAVITY;
        let bodies = [Body::at_rest(shape.clone(), Pose::IDENTITY)];
        let mut nearest = f32::MAX;
        for f in 0..180 {
            scene.frame(&bodies, |_, _, _, _| {});
            if f > 60 {
                for x in &scene.positions {
                    nearest = nearest.min(distance(&shape, x.truncate()));
                }
            }
        }
        assert!(nearest > 0.5 * THICKNESS, "{name}: nearest {:.3} mm of {:.3} mm", nearest * 1e3, THICKNESS * 1e3);
    }
}

/// Way down the slope in 2 s `[m]` of a sheet with springs, and of the sheet's theory without friction.
fn slide(shape: SharedShape, pose: Pose, down: Vec3, up: Vec3, friction: f32, springs: bool) -> f32 {
    let turn = Quat::from_rotation_arc(Vec3::Y, up);
    let mut scene = Scene::sheet(12, 0.4, turn, up * (THICKNESS + 1.0e-5), Vec3::ZERO);
    if springs {
        scene = scene.with_springs(12);
    }
    scene.gravity = GRAVITY;
    scene.friction = friction;
    let body = Body { static_friction: friction, dynamic_friction: friction, ..Body::at_rest(shape, pose) };
    let bodies = [body];
    let start = scene.center();
    for _ in 0..120 {
        scene.frame(&bodies, |_, _, _, _| {});
    }
    (scene.center() - start).dot(down)
}

#[test]
fn on_a_30_degree_slope_a_sheet_stays_above_tan_30_and_slides_below() {
    let angle = 30.0_f32.to_radians();
    let turn = Quat::from_rotation_z(-angle);
    let (up, down) = (turn * Vec3::Y, turn * Vec3::X);
    let plate = shape::cuboid(Vec3::new(8.0, 0.1, 8.0)).unwrap();
    let (vertices, triangles) = hills(9, 16.0, 0.0);
    let scenes = [
        ("half-space", shape::half_space(Vec3::Y).unwrap(), Pose::from_rotation(turn)),
        ("cuboid", plate, Pose::from_parts(up * -0.1, turn)),
        ("triangle mesh", shape::trimesh(vertices, triangles).unwrap(), Pose::from_rotation(turn)),
    ];
    for (name, shape, pose) in scenes {
        for springs in [false, true] {
            for ratio in [1.1, 1.5] {
                let way = slide(shape.clone(), pose, down, up, ratio * angle.tan(), springs);
                assert!(way.abs() < 1.0e-3, "{name}, springs {springs}, {ratio} tan 30: slid {:.3} mm in 2 s", way * 1e3);
            }
            for ratio in [0.9, 0.5, 0.0] {
                let way = slide(shape.clone(), pose, down, up, ratio * angle.tan(), springs);
                let theory = 0.5 * 9.81 * angle.sin() * (1.0 - ratio) * 4.0;
                let error = way / theory - 1.0;
                assert!(error.abs() < 0.1, "{name}, springs {springs}, {ratio} tan 30: {way:.3} m, theory {theory:.3} m");
            }
        }
    }
}

#[test]
fn a_moving_and_a_turning_body_carry_what_lies_on_them() {
    let plate = shape::cylinder(2.0, 0.1).unwrap();
    let mut scene = Scene::sheet(8, 0.3, Quat::IDENTITY, Vec3::new(0.5, 0.1 + THICKNESS, 0.0), Vec3::ZERO);
    scene.gravity = GRAVITY;
    scene.friction = 0.8;
    let pose = |f: u32| {
        // From rest to 1 m/s and 1 rad/s at 2 m/s² and 2 rad/s².
        let t = f as f32 * DT;
        let way = if t < 0.5 { t * t } else { t - 0.25 };
        Pose::from_parts(Vec3::X * way, Quat::from_rotation_y(way))
    };
    let start: Vec<Vec3> = scene.positions.iter().map(|x| x.truncate()).collect();
    for f in 0..60 {
        let body = Body { static_friction: 0.8, dynamic_friction: 0.8, ..Body::new(plate.clone(), pose(f), pose(f + 1)) };
        scene.frame(&[body], |_, _, _, _| {});
    }
    let end = pose(60);
    let slip = scene.positions.iter().zip(&start).map(|(x, s)| (end.inverse_transform_point(x.truncate()) - *s).length());
    let slip = slip.fold(0.0_f32, f32::max);
    // A body's velocity is constant within a frame, so it jumps by a dt = 0.03 m/s. Friction needs 0.03² / (2 μ g) = 0.07 mm to
    // catch up with that.
    assert!(slip < 3.0e-3, "slipped {:.2} mm on the body over 1 s", slip * 1e3);
}

#[test]
fn a_deep_overlap_is_left_without_gaining_speed() {
    for (name, shape) in shapes() {
        // Inside of a compound each part pushes towards its own nearest face, which may be the seam.
        if (is_surface(&shape) && name != "closed triangle mesh") || name == "compound" {
            continue;
        }
        let mut scene = Scene::sheet(16, 0.5, Quat::IDENTITY, Vec3::NEG_Y * 0.01, Vec3::ZERO);
        let bodies = [Body::at_rest(shape.clone(), Pose::IDENTITY)];
        let mut fastest = 0.0_f32;
        let mut inside_at_end = 0;
        for f in 0..60 {
            scene.frame(&bodies, |_, _, _, _| {});
            for i in 0..scene.positions.len() {
                fastest = fastest.max(scene.velocity(i).length());
                let d = distance(&shape, scene.positions[i].truncate());
                inside_at_end += u32::from(f == 59 && d < 0.9 * THICKNESS);
            }
        }
        assert!(fastest < 0.05, "{name}: {fastest} m/s after an overlap at rest");
        assert_eq!(inside_at_end, 0, "{name}: particles still inside after 1 s");
    }
}

#[test]
fn a_falling_particle_lands_without_bouncing() {
    for (name, shape) in shapes() {
        let mut scene = Scene::sheet(12, 0.5, Quat::IDENTITY, Vec3::Y * 0.6, Vec3::NEG_Y * 5.0);
        let bodies = [Body::at_rest(shape, Pose::IDENTITY)];
        let mut energy = 25.0_f32 * 1.0001;
        for _ in 0..30 {
            scene.frame(&bodies, |_, _, _, _| {});
            let now = (0..scene.positions.len()).map(|i| scene.velocity(i).length_squared()).fold(0.0, f32::max);
            assert!(now <= energy, "{name}: the fastest particle went from {} to {} m/s", energy.sqrt(), now.sqrt());
            energy = now.max(1.0e-6) * 1.0001;
        }
    }
}

#[test]
fn pinned_and_non_finite_particles_and_bodies_are_left_alone() {
    let mut scene = Scene::sheet(4, 0.2, Quat::IDENTITY, Vec3::ZERO, Vec3::ZERO);
    for x in &mut scene.positions {
        x.w = 0.0;
    }
    scene.positions[3] = Vec4::new(f32::NAN, 0.0, 0.0, 1.0);
    scene.positions[5] = Vec4::new(f32::INFINITY, 0.0, 0.0, 1.0);
    let pinned = scene.positions[0];
    let ball = shape::ball(0.5).unwrap();
    let broken = Pose::from_parts(Vec3::splat(f32::NAN), Quat::IDENTITY);
    let zero = Pose::from_parts(Vec3::ZERO, Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    let bodies = [
        Body::at_rest(ball.clone(), Pose::IDENTITY),
        Body::at_rest(ball.clone(), broken),
        Body::new(ball, Pose::IDENTITY, zero),
        Body::at_rest(shape::half_space(Vec3::Y).unwrap(), broken),
    ];
    scene.frame(&bodies, |_, _, _, _| {});
    assert_eq!(scene.touching, 0, "contacts of pinned or broken particles");
    assert_eq!(scene.positions[0], pinned, "a pinned particle moved");
}

#[test]
fn buffers_do_not_grow_once_warm_and_a_second_run_has_the_same_bits() {
    let run = || {
        let mut scene = Scene::sheet(20, 0.8, Quat::IDENTITY, Vec3::Y * 0.5, Vec3::ZERO).with_springs(20);
        scene.gravity = GRAVITY;
        let bodies: Vec<Body> = shapes().into_iter().map(|(_, s)| Body::at_rest(s, Pose::IDENTITY)).collect();
        for _ in 0..60 {
            scene.frame(&bodies, |_, _, _, _| {});
        }
        let warm = scene.contacts.capacities();
        for _ in 0..10 {
            scene.frame(&bodies, |_, _, _, _| {});
        }
        assert_eq!(warm, scene.contacts.capacities());
        scene.positions.iter().flat_map(|x| x.to_array().map(f32::to_bits)).collect::<Vec<_>>()
    };
    assert_eq!(run(), run());
}

/// Where a particle ends that lay on a floor and moves by `way` `[m]` in a substep, from where it lay `[m]`. `again`: it is
/// drawn in by as much a second time.
fn aside(friction: f32, way: Vec3, restitution: f32, again: bool) -> Vec3 {
    let body = Body {
        static_friction: friction,
        dynamic_friction: friction,
        ..Body::at_rest(shape::half_space(Vec3::Y).expect("a floor"), Pose::IDENTITY)
    };
    let (bodies, touch, mut coupling) = ([body], Touch { restitution, ..touch(friction) }, Coupling::default());
    let start = Vec4::new(0.0, THICKNESS, 0.0, 1.0);
    let (mut positions, mut previous) = ([start], [start]);
    let mut contacts = BodyContacts::default();
    let approach = Approach { dt: DT, substep: H, gravity: GRAVITY, thickness: THICKNESS, extra: 0.0 };
    contacts.gather(&bodies, &positions, &previous, &approach);
    positions[0] += way.extend(0.0);
    let inbound = [way.extend(0.0)];
    let mut context = BodyContext { bodies: &bodies, span: (0.0, 1.0), touch, coupling: &mut coupling };
    contacts.project(&mut context, &mut positions, &mut previous, &inbound, Projection::First);
    if again {
        positions[0].y += way.y;
        contacts.push_to_planes(&mut context, &mut positions);
    }
    contacts.apply_friction(&mut context, &mut positions, &previous);
    positions[0].truncate() - start.truncate()
}

#[test]
fn friction_comes_last_and_counts_every_push() {
    let way = Vec3::new(1.0e-3, -2.0e-3, 0.0);
    let slid = |again: bool| aside(0.2, way, 0.0, again);
    assert!((slid(false) - Vec3::X * 0.6e-3).length() < 1.0e-6, "{}", slid(false));
    // Its load is a mean over substeps, of which a second push is a quarter of one.
    assert!((slid(true) - Vec3::X * 0.5e-3).length() < 1.0e-6, "{}", slid(true));
    assert!(aside(0.6, way, 0.0, false).length() < 1.0e-6, "it sticks");
}

#[test]
fn what_bounces_rubs_under_all_that_turned_it_back() {
    let way = Vec3::new(10.0e-3, -10.0e-3, 0.0);
    let end = aside(0.2, way, 0.5, false);
    assert!((end - Vec3::new(7.0e-3, 5.0e-3, 0.0)).length() < 1.0e-5, "{end}");
}

/// Springs draw a particle through a sheet of triangles after bodies were met; it has met none, and so has no plane. Then it
/// rubs as if it had met it the first time.
#[test]
fn what_is_drawn_through_a_surface_is_put_back_when_it_is_looked_at_again() {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, 0.0, z));
    let surface = SharedShape::trimesh(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).expect("a surface");
    let bodies = Body::at_rest(surface, Pose::IDENTITY);
    let bodies = [Body { static_friction: 0.2, dynamic_friction: 0.2, ..bodies }];
    for side in [1.0, -1.0] {
        let start = Vec4::new(0.1, side * 1.5 * THICKNESS, 0.3, 1.0);
        let (mut positions, mut previous) = ([start], [start]);
        let (mut contacts, mut coupling, touch) = (BodyContacts::default(), Coupling::default(), touch(0.2));
        let approach = Approach { dt: DT, substep: H, gravity: GRAVITY, thickness: THICKNESS, extra: 0.02 };
        contacts.gather(&bodies, &positions, &previous, &approach);
        let mut context = BodyContext { bodies: &bodies, span: (0.0, 1.0), touch, coupling: &mut coupling };
        let before = &mut previous;
        assert_eq!(contacts.project(&mut context, &mut positions, before, &[], Projection::First), 0);
        positions[0] += Vec4::new(2.0e-3, -side * 2.0 * THICKNESS, 0.0, 0.0);
        assert_eq!(contacts.project(&mut context, &mut positions, before, &[], Projection::Relax), 1);
        assert!((positions[0].y - side * THICKNESS).abs() < 1.0e-5, "side {side}: at {}", positions[0].y);
        contacts.apply_friction(&mut context, &mut positions, before);
        // It was pushed by 1.5 thicknesses, 7.5 mm, and 0.2 of that is 1.5 mm.
        let slid = positions[0].x - start.x;
        assert!((slid - 0.5e-3).abs() < 1.0e-5, "side {side}: slid by {slid} m");
    }
}
