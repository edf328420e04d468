//! Nothing is allocated per frame once buffers are warm.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

// SAFETY: every call is passed on to the system's allocator unchanged.
#[expect(unsafe_code, reason = "a global allocator cannot be written without")]
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.with(|c| c.set(c.get() + 1));
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.with(|c| c.set(c.get() + 1));
        // SAFETY: as the caller promises.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn a_warm_and_clean_step_with_untangling_allocates_nothing() {
    use bevy_drape::solver::body::{Body, Pose, shape};
    use drape_scenes::{self as scenes, Scene, Tangle};
    use glam::Vec3;
    let mut over_a_box = scenes::layers(2, 20);
    over_a_box.bodies.clear();
    let cuboid = shape::cuboid(Vec3::splat(0.3)).expect("a box");
    over_a_box.bodies.push(Body::at_rest(cuboid, Pose::IDENTITY));
    let bodies = [("needles", scenes::needles(20)), ("funnel", scenes::funnel(20)), ("box", over_a_box)];
    let scenes = [("hang", scenes::hang(32)), ("waves", scenes::tangle(Tangle::Waves, 20))].into_iter().chain(bodies);
    let untangled = |scene: Scene| scenes::untangled(scene, true);
    let without = ("hang without contacts", untangled(scenes::hang(32)).without_contact());
    for (name, mut scene) in scenes.map(|(name, scene)| (name, untangled(scene))).chain([without]) {
        // A funnel takes a while to swallow a sheet; lists of what is near its wall grow until then.
        for _ in 0..900 {
            scene.step(1.0 / 60.0);
        }
        let before = COUNT.with(Cell::get);
        for _ in 0..120 {
            scene.step(1.0 / 60.0);
            assert_eq!(scene.crossings(), 0, "{name} is not clean");
        }
        let allocations = COUNT.with(Cell::get) - before;
        assert_eq!(allocations, 0, "{name}: {allocations} allocations in 120 frames");
    }
}

#[test]
fn a_warm_step_allocates_nothing() {
    use drape_scenes as scenes;
    for (name, mut scene) in [("hang", scenes::hang(32)), ("ball", scenes::ball(32)), ("flags", scenes::flags(3, 24))] {
        for _ in 0..240 {
            scene.step(1.0 / 60.0);
        }
        let before = COUNT.with(Cell::get);
        for _ in 0..120 {
            scene.step(1.0 / 60.0);
        }
        let allocations = COUNT.with(Cell::get) - before;
        assert_eq!(allocations, 0, "{name}: {allocations} allocations in 120 frames");
    }
}

#[test]
fn what_the_panel_records_allocates_nothing_after_the_first_frame() {
    use bevy_drape::inspector::{History, Sample};
    let mut history = History::default();
    history.record(Sample::default());
    let before = COUNT.with(Cell::get);
    for frame in 1..3000 {
        history.record(Sample { time: f64::from(frame) / 144.0, ..Sample::default() });
    }
    let allocations = COUNT.with(Cell::get) - before;
    assert_eq!((allocations, history.samples().count() > 400), (0, true));
}

#[test]
fn a_cloth_that_comes_to_rest_allocates_nothing() {
    let mut scene = drape_scenes::ball(20).untangled(Default::default(), Default::default(), true).expect("one cloth");
    for _ in 0..60 {
        scene.step(1.0 / 60.0);
    }
    // While it settles lists of contacts may still grow; once it is settling nothing does.
    while !scene.cloths[0].sim.memory.is_settling() && scene.cloths[0].sim.state.time < 60.0 {
        scene.step(1.0 / 60.0);
    }
    assert!(scene.cloths[0].sim.memory.is_settling(), "does not settle in 60 s");
    let before = COUNT.with(Cell::get);
    for _ in 0..120 {
        scene.step(1.0 / 60.0);
    }
    let allocations = COUNT.with(Cell::get) - before;
    assert_eq!(allocations, 0, "{allocations} allocations in 120 frames");
}

#[test]
fn a_warm_step_that_gives_bodies_something_allocates_nothing() {
    use bevy_drape::solver::body::{Body, Pose, shape};
    use bevy_drape::solver::couple::Rigid;
    use bevy_drape::solver::step::FrameInput;
    use bevy_drape::solver::wind::Wind;
    use drape_scenes as scenes;
    use glam::{Mat3, Vec3};

    let mut cloth = scenes::hang(32).cloths.remove(0);
    let at = Vec3::new(0.0, -0.4, 0.0);
    let rigid = Rigid { inverse_mass: Vec3::ONE, inverse_inertia: Mat3::IDENTITY, ..Rigid::immovable(at, at) };
    let ball = shape::ball(0.2).expect("a ball");
    let bodies = [Body { rigid: Some(0), ..Body::at_rest(ball, Pose::from_parts(at, glam::Quat::IDENTITY)) }];
    let wind = Wind::default();
    let mut given = 0.0;
    let mut frame = |given: &mut f32| {
        let coupling = cloth.sim.memory.coupling_mut();
        coupling.clear();
        let slots = [coupling.add(rigid), coupling.add(Rigid::immovable(Vec3::ZERO, Vec3::ZERO))];
        coupling.hold(0, slots[1]);
        cloth.step(&FrameInput { dt: 1.0 / 60.0, gravity: Vec3::NEG_Y * 9.81, bodies: &bodies, wind: &wind, skinned: None });
        *given += cloth.sim.memory.coupling().given(slots[0]).linear.length()
            * cloth.sim.memory.coupling().given(slots[1]).linear.length();
    };
    (0..240).for_each(|_| frame(&mut given));
    let before = COUNT.with(Cell::get);
    (0..120).for_each(|_| frame(&mut given));
    let allocations = COUNT.with(Cell::get) - before;
    assert_eq!(allocations, 0, "{allocations} allocations in 120 frames");
    assert!(given > 0.0, "nothing was given");
}

#[test]
fn a_fabric_that_changes_in_every_frame_allocates_nothing() {
    use bevy_drape::solver::step::{FrameInput, prepare};
    use glam::Vec3;
    let mut cloth = drape_scenes::hang(24).cloths.remove(0);
    let wind = bevy_drape::solver::wind::Wind::default();
    let input = FrameInput { dt: 1.0 / 60.0, gravity: Vec3::NEG_Y * 9.81, bodies: &[], wind: &wind, skinned: None };
    let mut before = 0;
    for frame in 0..240 {
        if frame == 120 {
            before = COUNT.with(Cell::get);
        }
        cloth.fabric.bend_stiffness *= 1.01;
        prepare(&cloth.rest, &cloth.fabric, &cloth.anchors, &mut cloth.sim.state, &mut cloth.sim.memory);
        cloth.step(&input);
    }
    let allocations = COUNT.with(Cell::get) - before;
    assert_eq!(allocations, 0, "{allocations} allocations in 120 frames");
}
