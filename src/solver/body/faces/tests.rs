//! One triangle, or a few, and bodies that are finer than it.

use glam::{Vec3, Vec4, vec3};
use parry3d::math::Pose;

use super::*;
use crate::solver::body::{Body, BodyContext, Touch, shape};
use crate::solver::couple::Coupling;
use crate::solver::rest::{RestShape, SourceMesh};

const H: f32 = 1.0 / 480.0;
const THICKNESS: f32 = 0.005;
const RADIUS: f32 = 0.01;
const TOUCH: Touch = Touch { thickness: THICKNESS, static_friction: 0.0, dynamic_friction: 0.0, restitution: 0.0 };

/// A level triangle around the origin with sides of 0.2 m, at rest, and particles of inverse masses `w`.
struct Triangle {
    rest: RestShape,
    positions: Vec<Vec4>,
    previous: Vec<Vec4>,
    contacts: FaceContacts,
}

fn project(contacts: &mut FaceContacts, bodies: &[Body], positions: &mut [Vec4], previous: &mut [Vec4]) -> u32 {
    let mut context = BodyContext { bodies, span: (0.0, 1.0), touch: TOUCH, coupling: &mut Coupling::default() };
    let touches = contacts.project(&mut context, positions, previous);
    contacts.stop_again(&mut context, positions, previous);
    touches
}

impl Triangle {
    fn new(w: [f32; 3]) -> Self {
        let corner = |turn: f32| 0.2 / 3.0f32.sqrt() * vec3(turn.cos(), 0.0, turn.sin());
        let positions = [0.0, 1.0, 2.0].map(|third| corner(third * std::f32::consts::TAU / 3.0)).to_vec();
        let mesh = SourceMesh { positions, triangles: vec![[0, 1, 2]], ..SourceMesh::default() };
        let (rest, _) = RestShape::build(&mesh).expect("a triangle");
        let positions: Vec<Vec4> = rest.positions.iter().zip(w).map(|(x, w)| x.extend(w)).collect();
        Self { rest, previous: positions.clone(), positions, contacts: FaceContacts::default() }
    }

    fn gather(&mut self, bodies: &[Body]) {
        let Self { rest, positions, contacts, .. } = self;
        let sheet = Sheet { topology: &rest.topology, longest_edge: 0.2, positions, thickness: THICKNESS };
        contacts.gather(bodies, &sheet, 0.1, H);
    }

    /// One frame of one substep; the number of touches.
    fn frame(&mut self, bodies: &[Body]) -> u32 {
        self.gather(bodies);
        let Self { positions, previous, contacts, .. } = self;
        project(contacts, bodies, positions, previous)
    }

    fn heights(&self) -> [f32; 3] {
        [0, 1, 2].map(|p| self.positions[p].y)
    }
}

/// A ball that goes from one point to another.
fn ball(radius: f32, from: Vec3, to: Vec3) -> Body {
    Body::new(shape::ball(radius).expect("a ball"), Pose::from_translation(from), Pose::from_translation(to))
}

#[test]
fn only_what_is_finer_than_the_mesh_has_faces_listed() {
    let mut triangle = Triangle::new([1.0; 3]);
    for (radius, listed) in [(RADIUS, 1), (0.2, 1), (10.0, 0)] {
        let at = (radius + THICKNESS) * Vec3::NEG_Y;
        triangle.gather(&[ball(radius, at, at)]);
        assert_eq!(triangle.contacts.candidates(), listed, "a ball of {radius} m");
    }
    let out_of_reach = ball(RADIUS, Vec3::Y, Vec3::Y);
    triangle.gather(&[out_of_reach]);
    assert_eq!(triangle.contacts.candidates(), 0);
}

#[test]
fn a_ball_between_particles_lifts_the_face_to_its_share_of_the_thickness() {
    let mut triangle = Triangle::new([1.0; 3]);
    let rise = [-0.02, 0.01].map(|y| y * Vec3::Y);
    assert!(triangle.frame(&[ball(RADIUS, rise[0], rise[1])]) > 0);
    let top = 0.01 + RADIUS + SHARE * THICKNESS;
    for y in triangle.heights() {
        assert!((y - top).abs() < 1.0e-5, "a corner at {y} m, {top} expected");
    }
    assert!(triangle.contacts.loads().all(|(body, _, load)| body == 0 && load > 0.0));
    assert_eq!(triangle.contacts.touching().count(), 3);
}

#[test]
fn corners_share_the_push_by_their_inverse_masses() {
    let mut triangle = Triangle::new([1.0, 2.0, 4.0]);
    triangle.frame(&[ball(RADIUS, -0.013 * Vec3::Y, -0.011 * Vec3::Y)]);
    let [a, b, c] = triangle.heights();
    assert!(a > 1.0e-4, "{a} m");
    assert!((b / a - 2.0).abs() < 1.0e-3 && (c / a - 4.0).abs() < 1.0e-3, "{a} {b} {c} m");
}

#[test]
fn a_face_that_falls_through_a_ball_in_one_substep_stays_above() {
    let mut triangle = Triangle::new([1.0; 3]);
    let body = ball(RADIUS, Vec3::ZERO, Vec3::ZERO);
    let way = 0.1 * Vec3::Y;
    triangle.previous.iter_mut().for_each(|x| *x += (0.5 * way).extend(0.0));
    triangle.positions.clone_from(&triangle.previous);
    triangle.gather(std::slice::from_ref(&body));
    triangle.positions.iter_mut().for_each(|x| *x -= way.extend(0.0));
    let Triangle { positions, previous, contacts, .. } = &mut triangle;
    project(contacts, &[body], positions, previous);
    let middle: f32 = triangle.heights().iter().sum::<f32>() / 3.0;
    assert!(middle > RADIUS, "the middle is at {middle} m");
}

#[test]
fn what_pins_hold_is_not_moved() {
    let body = [ball(RADIUS, -0.02 * Vec3::Y, Vec3::ZERO)];
    let mut triangle = Triangle::new([0.0, 0.0, 1.0]);
    triangle.frame(&body);
    let [a, b, c] = triangle.heights();
    assert_eq!([a, b], [0.0; 2]);
    assert!(c > 0.0, "the free corner is at {c} m");
    let mut held = Triangle::new([0.0; 3]);
    held.gather(&body);
    assert_eq!(held.contacts.candidates(), 0);
}

#[test]
fn a_load_is_known_in_the_next_frame_unless_the_face_is_left_out() {
    let body = [ball(RADIUS, -0.013 * Vec3::Y, -0.011 * Vec3::Y)];
    let mut triangle = Triangle::new([1.0; 3]);
    triangle.frame(&body);
    let loads = |triangle: &Triangle| triangle.contacts.loads().map(|(.., load)| load).collect::<Vec<_>>();
    let before = loads(&triangle);
    triangle.gather(&body);
    assert!(!before.is_empty() && loads(&triangle) == before);
    triangle.contacts.leave_out(&[2]);
    assert!(loads(&triangle).is_empty());
}

#[test]
fn a_body_without_a_pose_and_a_frame_without_time_list_nothing() {
    let mut triangle = Triangle::new([1.0; 3]);
    triangle.gather(&[ball(RADIUS, Vec3::NAN, Vec3::ZERO)]);
    assert_eq!(triangle.contacts.candidates(), 0);
    let sheet =
        Sheet { topology: &triangle.rest.topology, longest_edge: 0.2, positions: &triangle.positions, thickness: THICKNESS };
    triangle.contacts.gather(&[ball(RADIUS, Vec3::ZERO, Vec3::ZERO)], &sheet, 0.1, 0.0);
    assert_eq!(triangle.contacts.candidates(), 0);
}

#[test]
fn cloth_that_is_farther_than_numbers_reach_meets_no_sharp_edges() {
    let (vertices, triangles) = (vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z], vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
    let surface = shape::trimesh(vertices, triangles).expect("a surface");
    let turned = Pose::from_rotation(glam::Quat::from_rotation_y(0.3));
    let body = [Body::at_rest(surface, turned)];
    for (far, meets) in [(0.0, true), (1.0e20, false), (3.0e38, false)] {
        let mut triangle = Triangle::new([1.0; 3]);
        triangle.positions.iter_mut().for_each(|x| *x += Vec3::splat(far).extend(0.0));
        triangle.gather(&body);
        assert_eq!(triangle.contacts.candidates() > 0, meets, "{far} m away");
    }
}

/// A face is pressed on a small ball by `depth` `[m]` and moved aside by 1 mm. Returns where its middle gets, and where it gets
/// after the face was drawn in once more and pushed out again.
fn rubbed(depth: f32, friction: f32) -> [Vec3; 2] {
    let touch = Touch { static_friction: friction, dynamic_friction: friction, ..TOUCH };
    let at = vec3(0.0, -RADIUS - SHARE * THICKNESS, 0.0);
    let body = Body { static_friction: friction, dynamic_friction: friction, ..ball(RADIUS, at, at) };
    let mut triangle = Triangle::new([1.0; 3]);
    triangle.gather(std::slice::from_ref(&body));
    let Triangle { positions, previous, contacts, .. } = &mut triangle;
    let move_by = |by: Vec3, positions: &mut [Vec4]| positions.iter_mut().for_each(|x| *x += by.extend(0.0));
    move_by(vec3(1.0e-3, -depth, 0.0), positions);
    let (bodies, mut coupling) = ([body], Coupling::default());
    let mut context = BodyContext { bodies: &bodies, span: (0.0, 1.0), touch, coupling: &mut coupling };
    assert!(contacts.project(&mut context, positions, previous) > 0);
    contacts.apply_friction(&mut context, positions, previous);
    let middle = |positions: &[Vec4]| positions.iter().map(|x| x.truncate()).sum::<Vec3>() / 3.0;
    let slid = middle(positions);
    move_by(Vec3::NEG_Y * depth, positions);
    contacts.push_to_planes(&mut context, positions);
    [slid, middle(positions)]
}

#[test]
fn what_touches_within_a_face_is_held_as_coulomb_says_and_pushed_out_again() {
    for (friction, slid) in [(0.0, 1.0e-3), (0.25, 0.5e-3), (0.5, 0.0)] {
        let [held, again] = rubbed(2.0e-3, friction);
        assert!((held.x - slid).abs() < 1.0e-4, "friction {friction}: {held}");
        assert!((again.y - held.y).abs() < 1.0e-4, "friction {friction}: drawn in to {again}");
    }
}
