//! Clothes on a character: limits, drive, inertia, and what goes along in a teleport.

use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::prelude::*;
use bevy_drape::prelude::*;

use crate::common::*;

/// A sheet that hangs on the skin of two joints: its first half follows the first.
pub fn dressed(app: &mut App, n: u32, extra: impl Bundle) -> (Entity, [Entity; 2]) {
    let mut mesh = sheet(n);
    let rest = vectors(&mesh, Mesh::ATTRIBUTE_POSITION);
    let index = |p: &Vec3| if p.x < 0.0 { [0, 9, 9, 9] } else { [1, 9, 9, 9] };
    let indices: Vec<[u16; 4]> = rest.iter().map(index).collect();
    let count = rest.len();
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_INDEX, bevy::mesh::VertexAttributeValues::Uint16x4(indices));
    mesh.insert_attribute(Mesh::ATTRIBUTE_JOINT_WEIGHT, vec![[1.0, 0.0, 0.0, 0.0]; count]);
    let joints = [(); 2].map(|()| app.world_mut().spawn(Transform::default()).id());
    let inverse_bindposes = app
        .world_mut()
        .resource_mut::<Assets<SkinnedMeshInverseBindposes>>()
        .add(SkinnedMeshInverseBindposes::from(vec![Mat4::IDENTITY; 2]));
    (spawn(app, mesh, (SkinnedMesh { inverse_bindposes, joints: joints.to_vec() }, extra)), joints)
}

pub fn put(app: &mut App, entity: Entity, at: Transform) {
    *app.world_mut().get_mut::<Transform>(entity).expect("a transform") = at;
}

/// How far the shown vertices are from their places on the skin [m].
fn strays(app: &App, n: u32, cloth: Entity, joints: [Entity; 2]) -> f32 {
    let at = joints.map(|joint| *app.world().get::<GlobalTransform>(joint).expect("a joint"));
    let rest = vectors(&sheet(n), Mesh::ATTRIBUTE_POSITION);
    let off = |(p, now): (&Vec3, Vec3)| at[usize::from(p.x >= 0.0)].transform_point(*p).distance(now);
    rest.iter().zip(world_positions(app, cloth)).map(off).fold(0.0, f32::max)
}

/// A dance: to and fro at up to 4 m/s, and turning.
pub fn dance(time: f32, which: f32) -> Transform {
    let sway = 8.0 * time;
    Transform {
        translation: Vec3::new(0.5 * sway.sin(), 0.1 * (2.0 * sway).cos() + 0.02 * which, 0.0),
        rotation: Quat::from_rotation_y(0.6 * sway.cos() + 0.1 * which),
        ..default()
    }
}

#[test]
fn nothing_is_farther_from_the_skin_than_it_may_be_at_any_frame_rate() {
    for rate in [30.0, 60.0, 144.0] {
        let mut app = app();
        frame_length(&mut app, 1.0 / rate);
        let limits = ClothLimits { max_distance: ClothMap::Uniform(0.05), ..default() };
        let (cloth, joints) = dressed(&mut app, 12, limits);
        run(&mut app, 2);
        let mut most = 0.0f32;
        for frame in 0..(2.0 * rate) as u32 {
            let time = frame as f32 / rate;
            (0..2).for_each(|i| put(&mut app, joints[i], dance(time, i as f32)));
            run(&mut app, 1);
            most = most.max(strays(&app, 12, cloth, joints));
        }
        assert!(most < 0.051 && finite(&app, cloth), "{rate} Hz: {most}");
        assert!(most > 0.03, "it moves: {rate} Hz: {most}");
    }
}

#[test]
fn nothing_sinks_deeper_than_the_backstop() {
    let mut app = app();
    let limits = ClothLimits {
        max_distance: ClothMap::Uniform(0.5),
        backstop_distance: ClothMap::Uniform(0.02),
        backstop_radius: 1000.0,
        ..default()
    };
    let (cloth, joints) = dressed(&mut app, 12, limits);
    run(&mut app, 2);
    for frame in 0..120 {
        let up = Transform::from_xyz(0.0, 0.3 * (0.1 * frame as f32).sin(), 0.0);
        joints.iter().for_each(|joint| put(&mut app, *joint, up));
        run(&mut app, 1);
        let low = lowest(&world_positions(&app, cloth)) - up.translation.y;
        assert!(low > -0.021, "frame {frame}: {low}");
    }
    let low = lowest(&world_positions(&app, cloth));
    assert!(low < 0.0, "it lies on the backstop, not on the skin: {low}");
}

#[test]
fn at_a_scale_of_nothing_cloth_is_its_skin_and_at_one_it_falls() {
    let mut app = app();
    let (cloth, joints) = dressed(&mut app, 12, ClothLimits { scale: 0.0, ..default() });
    run(&mut app, 30);
    joints.iter().for_each(|joint| put(&mut app, *joint, Transform::from_xyz(0.1, 0.0, 0.0)));
    run(&mut app, 1);
    assert!(strays(&app, 12, cloth, joints) < 1.0e-4, "{}", strays(&app, 12, cloth, joints));
    app.world_mut().get_mut::<ClothLimits>(cloth).expect("limits").scale = 1.0;
    run(&mut app, 30);
    assert!(strays(&app, 12, cloth, joints) > 0.5);
}

#[test]
fn a_drive_holds_cloth_against_gravity_as_far_as_its_frequency_says() {
    for (frequency, sag) in [(2.0f32, 0.0621), (4.0, 0.01553)] {
        let mut app = app();
        let drive = ClothDrive { frequency: ClothMap::Uniform(frequency), ..default() };
        let (cloth, joints) = dressed(&mut app, 8, (drive, ClothSleepDisabled));
        run(&mut app, 300);
        let stray = strays(&app, 8, cloth, joints);
        assert!((stray - sag).abs() < 0.05 * sag, "{frequency} Hz: {stray} in place of {sag}");
    }
}

#[test]
fn what_is_within_a_millimetre_is_pinned_and_a_live_change_makes_no_jump() {
    let mut app = app();
    let (cloth, _) = dressed(&mut app, 8, ClothLimits { max_distance: ClothMap::Uniform(0.0), ..default() });
    run(&mut app, 5);
    assert_eq!(report(&app, cloth).pinned, 64);
    app.world_mut().get_mut::<ClothLimits>(cloth).expect("limits").max_distance = ClothMap::Uniform(0.3);
    run(&mut app, 120);
    assert_eq!(report(&app, cloth).pinned, 0);
    let mut before = world_positions(&app, cloth);
    assert!(lowest(&before) < -0.25, "{}", lowest(&before));
    app.world_mut().get_mut::<ClothLimits>(cloth).expect("limits").max_distance = ClothMap::Uniform(0.1);
    for frame in 0..60 {
        run(&mut app, 1);
        let now = world_positions(&app, cloth);
        let step = before.iter().zip(&now).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(step < 0.06, "frame {frame}: {step}");
        before = now;
    }
    assert!(lowest(&before) > -0.11, "{}", lowest(&before));
}

#[test]
fn a_map_that_is_not_there_is_done_without() {
    let mut app = app();
    let limits = ClothLimits { max_distance: ClothMap::attribute("_CLOTH_MAXDIST", 0.0, 0.3), ..default() };
    let (cloth, _) = dressed(&mut app, 8, (limits, border()));
    run(&mut app, 30);
    assert_eq!((status(&app, cloth), report(&app, cloth).pinned), (ClothStatus::Active, 8));
    assert!(finite(&app, cloth));
}

/// The shape of a cloth as its carrier sees it.
fn seen_by(app: &App, cloth: Entity, carrier: Transform) -> Vec<Vec3> {
    let back = carrier.to_matrix().inverse();
    world_positions(app, cloth).into_iter().map(|x| back.transform_point3(x)).collect()
}

fn farthest(a: &[Vec3], b: &[Vec3]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

#[test]
fn cloth_that_feels_nothing_of_its_carrier_hangs_as_if_that_stood() {
    let shape = |moves: bool| {
        let mut app = app();
        let inertia = ClothInertia { linear: 0.0, angular: 0.0, ..default() };
        let cloth = spawn(&mut app, sheet(10), (border(), inertia, ClothSleepDisabled));
        run(&mut app, 5);
        let mut at = Transform::default();
        for frame in 1..=300 {
            if moves {
                let time = frame as f32 / 60.0;
                at = Transform::from_xyz(20.0 * time, 0.0, 0.0).with_rotation(Quat::from_rotation_y(12.566 * time));
                put(&mut app, cloth, at);
            }
            run(&mut app, 1);
        }
        seen_by(&app, cloth, at)
    };
    let off = farthest(&shape(true), &shape(false));
    assert!(off < 0.001, "{off}");
}

#[test]
fn the_motion_of_a_space_is_not_felt_and_that_within_it_is() {
    let shape = |lift: f32, sway: f32, frames: u32| {
        let mut app = app();
        let space = app.world_mut().spawn(Transform::default()).id();
        let inertia = ClothInertia { space: Some(space), ..default() };
        let cloth = spawn(&mut app, sheet(10), (border(), inertia, ClothSleepDisabled));
        app.world_mut().entity_mut(cloth).insert(ChildOf(space));
        run(&mut app, 5);
        let mut at = Transform::default();
        for frame in 1..=frames {
            let time = frame as f32 / 60.0;
            at.translation.y = lift * time;
            put(&mut app, space, at);
            put(&mut app, cloth, Transform::from_xyz(0.0, 0.0, sway * (4.0 * time).sin()));
            run(&mut app, 1);
        }
        seen_by(&app, cloth, at)
    };
    let off = farthest(&shape(10.0, 0.0, 300), &shape(0.0, 0.0, 300));
    assert!(off < 0.001, "{off}");
    // What swings is not so to the last digit.
    let off = farthest(&shape(10.0, 0.1, 60), &shape(0.0, 0.1, 60));
    assert!(off < 0.005, "{off}");
    assert!(farthest(&shape(10.0, 0.1, 60), &shape(10.0, 0.0, 60)) > 0.02);
}

#[test]
fn cloth_that_feels_all_of_it_has_the_same_bits_as_without_inertia() {
    let bits = |inertia: Option<ClothInertia>| {
        let mut app = app();
        let cloth = spawn(&mut app, sheet(10), (border(), ClothSleepDisabled));
        if let Some(inertia) = inertia {
            app.world_mut().entity_mut(cloth).insert(inertia);
        }
        for frame in 0..60 {
            put(&mut app, cloth, dance(frame as f32 / 60.0, 0.0));
            run(&mut app, 1);
        }
        particles(&app, cloth)
    };
    assert_eq!(bits(None), bits(Some(ClothInertia::default())));
}

#[test]
fn a_limit_of_speed_is_the_speed_that_is_felt() {
    let lag = |max_speed: f32, speed: f32| {
        let mut app = app();
        let inertia = ClothInertia { max_speed, ..default() };
        let cloth = spawn(&mut app, sheet(10), (border(), inertia, ClothSleepDisabled));
        let air = ClothGlobalWind { air_density: 0.0, ..default() };
        app.insert_resource(air);
        run(&mut app, 60);
        for frame in 1..=20 {
            put(&mut app, cloth, Transform::from_xyz(0.0, 0.0, -speed * frame as f32 / 60.0));
            run(&mut app, 1);
        }
        seen_by(&app, cloth, Transform::from_xyz(0.0, 0.0, -speed * 20.0 / 60.0))
    };
    let off = farthest(&lag(2.0, 6.0), &lag(f32::INFINITY, 2.0));
    assert!(off < 0.002, "{off}");
    assert!(farthest(&lag(f32::INFINITY, 6.0), &lag(f32::INFINITY, 2.0)) > 0.1);
}

#[test]
fn cloths_and_colliders_of_a_character_teleport_as_one() {
    let mut app = app();
    record::<ClothTeleported>(&mut app);
    let hero = app.world_mut().spawn((Transform::default(), ClothCharacter)).id();
    let cloths = [0.0, 3.0].map(|x| {
        let cloth = spawn(&mut app, sheet(8), (border(), Transform::from_xyz(x, 0.0, 0.0)));
        app.world_mut().entity_mut(cloth).insert(ChildOf(hero));
        cloth
    });
    // In the way of neither, unless it is swept from one place to the other.
    app.world_mut().spawn((Transform::from_xyz(0.0, -0.4, 0.3), ClothCollider::ball(0.1), ChildOf(hero)));
    run(&mut app, 60);
    let before = cloths.map(|cloth| seen_by(&app, cloth, Transform::default()));
    for jump in [Vec3::new(10.0, 0.0, 0.0), Vec3::new(0.0, 0.0, -2.4)] {
        let at = *app.world().get::<Transform>(hero).expect("a transform");
        let turned =
            Transform { translation: at.translation + jump, rotation: at.rotation * Quat::from_rotation_y(3.1), ..default() };
        put(&mut app, hero, turned);
        run(&mut app, 1);
        for (cloth, before) in cloths.iter().zip(&before) {
            let off = farthest(&seen_by(&app, *cloth, turned), before);
            assert!(off < 0.05, "{jump}: {off}");
        }
    }
    assert_eq!(seen::<ClothTeleported>(&app).len(), 4);
}

#[test]
fn what_is_fast_and_legal_is_no_teleport_at_any_frame_rate() {
    for rate in [10.0, 15.0, 30.0, 60.0] {
        let mut app = app();
        frame_length(&mut app, 1.0 / rate);
        record::<ClothTeleported>(&mut app);
        let cloth = spawn(&mut app, sheet(8), border());
        run(&mut app, 2);
        for frame in 0..(2.0 * rate) as u32 {
            let time = frame as f32 / rate;
            let turn = Quat::from_rotation_y(1125f32.to_radians() * time);
            put(&mut app, cloth, Transform::from_xyz(12.0 * time, 0.0, 0.0).with_rotation(turn));
            run(&mut app, 1);
        }
        assert_eq!(seen::<ClothTeleported>(&app).len(), 0, "{rate} Hz");
        assert!(finite(&app, cloth));
    }
}

#[test]
fn in_very_long_frames_nothing_is_faster_than_it_is() {
    let mut app = app();
    frame_length(&mut app, 0.2);
    let cloth = spawn(&mut app, sheet(8), (border(), ClothSleepDisabled));
    run(&mut app, 2);
    let mut worst = 0.0f32;
    for frame in 0..10 {
        put(&mut app, cloth, Transform::from_xyz(4.0 * 0.2 * frame as f32, 0.0, 0.0));
        run(&mut app, 1);
        let state = app.world().get::<ClothParticles>(cloth).expect("a cloth").state();
        worst = (0..64).map(|i| state.velocity(i).length()).fold(worst, f32::max);
    }
    // What is pinned is drawn along at 4 m/s in the half of the frame that is simulated, not at 8.
    assert!(worst < 7.0, "{worst}");
}

#[test]
fn a_skin_that_turns_carries_its_cloth_and_a_root_that_stands_does_not_hold_it() {
    let mut app = app();
    record::<ClothTeleported>(&mut app);
    // All pins are on the second joint.
    let pins = ClothPins::where_position(|p| p.x > 0.499);
    let (cloth, joints) = dressed(&mut app, 8, pins);
    run(&mut app, 30);
    put(&mut app, joints[1], Transform::from_xyz(20.0, 0.0, 0.0));
    run(&mut app, 1);
    assert_eq!(seen::<ClothTeleported>(&app).len(), 1, "it went with its pins");
    put(&mut app, joints[0], Transform::from_xyz(-20.0, 0.0, 0.0));
    run(&mut app, 1);
    assert_eq!(seen::<ClothTeleported>(&app).len(), 1, "nothing of it hangs on the other");
    assert!(finite(&app, cloth));
}

#[test]
fn a_skin_that_is_in_motion_when_it_comes_takes_its_cloth_along() {
    let mut app = app();
    let (cloth, joints) = dressed(&mut app, 10, (border(), ClothSleepDisabled));
    let at = |frame: u32| Transform::from_xyz(6.0 * frame as f32 / 60.0, 0.0, 0.0);
    for frame in 0..12 {
        joints.iter().for_each(|joint| put(&mut app, *joint, at(frame)));
        run(&mut app, 1);
        let state = app.world().get::<ClothParticles>(cloth).expect("a cloth").state();
        let relative = |i: usize| (state.velocity(i) - Vec3::X * 6.0).length();
        let fastest = (0..100).map(relative).fold(0.0, f32::max);
        // It begins with the speed of the skin, and falls from there.
        let falls = 9.81 * (frame as f32 - 2.0).max(0.0) / 60.0;
        assert!(frame < 3 || fastest < falls + 0.3, "frame {frame}: {fastest} in place of {falls}");
        assert!(strays(&app, 10, cloth, joints) < 0.2, "frame {frame}: {}", strays(&app, 10, cloth, joints));
    }
}

#[test]
fn another_pose_at_once_tears_nothing() {
    let mut app = app();
    let limits = ClothLimits { max_distance: ClothMap::Uniform(0.1), ..default() };
    let (cloth, joints) = dressed(&mut app, 10, (limits, ClothSleepDisabled));
    run(&mut app, 60);
    // The second half of it turns by a right angle about the seam, in a frame.
    put(&mut app, joints[1], Transform::from_rotation(Quat::from_rotation_z(1.57)));
    run(&mut app, 1);
    let worst = report(&app, cloth).worst_edge;
    let fastest = {
        let state = app.world().get::<ClothParticles>(cloth).expect("a cloth").state();
        (0..100).map(|i| state.velocity(i).length()).fold(0.0, f32::max)
    };
    assert!(worst < 1.5 && fastest < 10.0, "worst edge {worst}, {fastest} m/s");
}

#[test]
fn cloth_begins_where_it_was_made_and_what_comes_later_on_its_skin() {
    let mut app = app();
    // What is pinned is on the second joint, which is bent from the first frame on.
    let pins = ClothPins::where_position(|p| p.x > 0.499);
    let (cloth, joints) = dressed(&mut app, 8, pins);
    let root = app.world_mut().spawn((Transform::default(), ClothCharacter)).id();
    app.world_mut().entity_mut(root).add_children(&[cloth, joints[0]]);
    app.world_mut().entity_mut(joints[0]).add_child(joints[1]);
    let bend = Transform::from_rotation(Quat::from_rotation_z(1.0));
    put(&mut app, joints[1], bend);
    let rest = vectors(&sheet(8), Mesh::ATTRIBUTE_POSITION);
    let off = |now: Vec<Vec3>, bend: Transform| {
        let pinned = rest.iter().filter(|rest| rest.x > 0.499).map(|rest| bend.transform_point(*rest));
        // Particles have an order of their own.
        pinned.map(|at| now.iter().map(|x| x.distance(at)).fold(f32::INFINITY, f32::min)).fold(0.0, f32::max)
    };
    for frame in 0..40 {
        run(&mut app, 1);
        let solved = off(particles(&app, cloth), Transform::IDENTITY);
        assert!(frame > 12 || solved < 1.0e-3, "frame {frame}: it is in the bind pose, not {solved} m off");
        let shown = off(world_positions(&app, cloth), bend);
        assert!(shown < 1.0e-3, "frame {frame}: {shown} m off the character");
    }
    assert!(off(particles(&app, cloth), bend) < 1.0e-3, "then it is where the character is");
    let later = app.world_mut().entity_mut(cloth).clone_and_spawn();
    for _ in 0..5 {
        run(&mut app, 1);
        assert!(off(particles(&app, later), bend) < 1.0e-3);
    }
    // Another clip takes over. What carries the cloth is on its way, too, and does not teleport.
    record::<ClothTeleported>(&mut app);
    let bend = Transform::from_rotation(Quat::from_rotation_z(-0.5));
    put(&mut app, joints[1], bend);
    for frame in 0..20 {
        run(&mut app, 1);
        for cloth in [cloth, later] {
            assert!(off(world_positions(&app, cloth), bend) < 1.0e-3, "it is shown on the character");
            let solved = off(particles(&app, cloth), bend);
            assert!(if frame < 8 { solved > 0.1 } else { frame < 16 || solved < 1.0e-3 }, "frame {frame}: {solved}");
        }
    }
    assert_eq!(seen::<ClothTeleported>(&app).len(), 0);
}

#[test]
fn a_pose_that_is_loaded_is_that_of_the_skeleton_that_is_there() {
    let mut app = app();
    let (cloth, joints) = dressed(&mut app, 8, ClothPins::where_position(|p| p.x > 0.499));
    app.world_mut().entity_mut(joints[0]).add_child(joints[1]);
    put(&mut app, joints[1], Transform::from_rotation(Quat::from_rotation_z(1.0)));
    run(&mut app, 300);
    let (pose, saved) = (app.world().get::<ClothParticles>(cloth).expect("a cloth").pose(), particles(&app, cloth));
    let later = app.world_mut().entity_mut(cloth).clone_and_spawn();
    app.world_mut().entity_mut(later).insert(pose);
    for frame in 0..30 {
        run(&mut app, 1);
        let farthest = particles(&app, later).iter().zip(&saved).map(|(now, then)| now.distance(*then)).fold(0.0, f32::max);
        assert!(frame < 4 || farthest < 0.1, "frame {frame}: {farthest} m from where it was");
    }
}

#[test]
fn inertia_that_is_out_of_range_is_told_of_and_used_clamped() {
    let mut app = app();
    let inertia = ClothInertia { linear: 2.0, max_turn: -1.0, ..default() };
    let cloth = spawn(&mut app, sheet(6), (border(), inertia));
    run(&mut app, 5);
    assert_eq!(report(&app, cloth).clamped, ["inertia.linear", "inertia.max_turn"]);
    assert!(finite(&app, cloth));
}

/// Whether a cloth has its own skin, to be skinned by the GPU, and nothing is simulated.
fn is_animated(app: &App, cloth: Entity, source: &Handle<Mesh>) -> bool {
    let world = app.world();
    let has_skin = world.get::<SkinnedMesh>(cloth).is_some();
    let shown = world.get::<Mesh3d>(cloth).expect("a mesh").0.id();
    assert_eq!(has_skin, shown == source.id(), "mesh and skin go together");
    has_skin && report(app, cloth).substeps == 0
}

#[test]
fn a_cloth_fades_into_its_animation_and_out_of_it_without_a_jump() {
    for rate in [30.0, 60.0, 144.0] {
        let mut app = app();
        frame_length(&mut app, 1.0 / rate);
        let limits = ClothLimits { max_distance: ClothMap::Uniform(0.2), ..default() };
        let (cloth, joints) = dressed(&mut app, 12, (limits, ClothBlend::default()));
        let source = app.world().get::<Mesh3d>(cloth).expect("a mesh").0.clone();
        let mut frame = 0;
        let mut advance = |app: &mut App, frames: u32| {
            for _ in 0..frames {
                let time = frame as f32 / rate;
                (0..2).for_each(|i| put(app, joints[i], dance(time, i as f32)));
                run(app, 1);
                frame += 1;
            }
        };
        let second = rate as u32;
        advance(&mut app, second);
        assert!(!is_animated(&app, cloth, &source) && strays(&app, 12, cloth, joints) > 0.03);
        let set = |app: &mut App, weight: f32| app.world_mut().get_mut::<ClothBlend>(cloth).expect("a blend").weight = weight;
        set(&mut app, 0.5);
        advance(&mut app, second);
        assert!(strays(&app, 12, cloth, joints) < 0.102, "half of its limits");
        set(&mut app, 0.0);
        let mut last = f32::INFINITY;
        for _ in 0..second {
            advance(&mut app, 1);
            if is_animated(&app, cloth, &source) {
                break;
            }
            last = strays(&app, 12, cloth, joints);
        }
        assert!(is_animated(&app, cloth, &source) && last < 5.0e-3, "{rate} Hz: {last} m from its skin");
        advance(&mut app, second);
        assert!(is_animated(&app, cloth, &source));
        set(&mut app, 1.0);
        advance(&mut app, 1);
        let off = strays(&app, 12, cloth, joints);
        assert!(!is_animated(&app, cloth, &source) && off < 5.0e-3, "{rate} Hz: it begins {off} m from its skin");
        advance(&mut app, second);
        let off = strays(&app, 12, cloth, joints);
        assert!((0.03..0.201).contains(&off) && finite(&app, cloth), "{rate} Hz: {off}");
        assert_eq!(report(&app, cloth).restores + report(&app, cloth).resets, 0);
    }
}

#[test]
fn far_away_a_skinned_cloth_is_animated_only_and_it_can_change_meanwhile() {
    let mut app = app();
    let camera = app.world_mut().spawn((Camera3d::default(), Transform::from_xyz(0.0, 0.0, 3.0))).id();
    let limits = ClothLimits { max_distance: ClothMap::Uniform(0.2), ..default() };
    let lod = ClothLod { full_within: 10.0, still_beyond: 100.0, ..default() };
    let (cloth, joints) = dressed(&mut app, 12, (limits, lod));
    let source = app.world().get::<Mesh3d>(cloth).expect("a mesh").0.clone();
    run(&mut app, 30);
    assert!(!is_animated(&app, cloth, &source));
    put(&mut app, camera, Transform::from_xyz(0.0, 0.0, 300.0));
    run(&mut app, 30);
    assert!(is_animated(&app, cloth, &source));
    assert_eq!(report(&app, cloth).detail, ClothDetail::Still);
    // Pins change, the character goes far, and it comes back.
    record::<ClothTeleported>(&mut app);
    *app.world_mut().get_mut::<ClothPins>(cloth).expect("pins") = border();
    joints.iter().for_each(|joint| put(&mut app, *joint, Transform::from_xyz(500.0, 0.0, 0.0)));
    run(&mut app, 5);
    assert!(is_animated(&app, cloth, &source));
    put(&mut app, camera, Transform::from_xyz(500.0, 0.0, 3.0));
    run(&mut app, 60);
    assert!(!is_animated(&app, cloth, &source) && finite(&app, cloth));
    assert!(strays(&app, 12, cloth, joints) < 0.21, "{}", strays(&app, 12, cloth, joints));
    assert_eq!(seen::<ClothTeleported>(&app).len(), 0);
    // It stops being a cloth while it is animated.
    put(&mut app, camera, Transform::from_xyz(500.0, 0.0, 300.0));
    run(&mut app, 30);
    app.world_mut().entity_mut(cloth).remove::<Cloth>();
    run(&mut app, 2);
    let world = app.world();
    assert!(world.get::<SkinnedMesh>(cloth).is_some() && world.get::<Mesh3d>(cloth).expect("a mesh").0.id() == source.id());
}
