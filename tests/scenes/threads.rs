//! Threads that share the work of an island change no bit of its frame, and none of what it keeps for the next one.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use bevy_drape::solver::jobs::JobSystem;
use drape_scenes::{self as scenes, Scene, untangled};
use glam::Quat;

use crate::FRAME;

/// Threads of the standard library, and how often they were asked for.
#[derive(Debug)]
struct Threads {
    count: usize,
    asked: AtomicUsize,
}

impl JobSystem for Threads {
    fn concurrency(&self) -> usize {
        self.count
    }

    fn run(&self, count: usize, job: &(dyn Fn(usize) + Sync)) {
        self.asked.fetch_add(1, Ordering::Relaxed);
        thread::scope(|scope| {
            for number in 1..count {
                scope.spawn(move || job(number));
            }
            job(0);
        });
    }
}

/// Steps a scene alone and with so many threads, and compares every frame. Returns how often threads were asked for, and in
/// how many frames something was rolled back or taken apart, so that pairs were looked for again.
fn has_the_same_bits(name: &str, counts: &[usize], frames: u32, scene: &Scene) -> (usize, u32) {
    let (mut asked, mut again) = (usize::MAX, 0);
    for &count in counts {
        let threads = Arc::new(Threads { count, asked: AtomicUsize::new(0) });
        let (mut alone, mut shared) = (scene.clone(), scene.clone());
        shared.untangle.as_mut().expect("cloths that meet").island.share(Some(threads.clone()));
        for frame in 1..=frames {
            alone.step(FRAME);
            shared.step(FRAME);
            for (a, b) in alone.cloths.iter().zip(&shared.cloths) {
                assert!(a.sim.state == b.sim.state, "{name}, {count} threads, frame {frame}: another state");
            }
            let [a, b] = [&alone, &shared].map(|scene| scene.untangle.as_ref().map(|untangling| &untangling.island));
            assert!(a == b, "{name}, {count} threads, frame {frame}: another island");
            again += u32::from(a.is_some_and(|island| island.looks() > 1 && island.total().is_clean()));
        }
        asked = asked.min(threads.asked.load(Ordering::Relaxed));
    }
    (asked, again)
}

#[test]
fn a_pile_has_the_same_bits_with_any_number_of_threads() {
    let (asked, _) = has_the_same_bits("pile", &[2, 3, 8], 50, &untangled(scenes::stack(4, 24), true));
    assert!(asked > 50, "threads were asked for {asked} times");
}

#[test]
fn cloth_that_comes_to_cross_has_the_same_bits_with_any_number_of_threads() {
    // Three sheets of 32² hit each other and a ball at up to 12 m/s.
    let mut scene = scenes::layers(3, 32);
    for (i, cloth) in (0..).zip(&mut scene.cloths) {
        let fall = glam::Vec3::NEG_Y * (4.0 * i as f32 + 4.0) * FRAME / 6.0;
        cloth.sim.state.previous.iter_mut().zip(&cloth.sim.state.positions).for_each(|(old, x)| *old = *x - fall.extend(0.0));
        cloth.sim.state.substep = FRAME / 6.0;
    }
    let (asked, again) = has_the_same_bits("layers that hit each other", &[2, 3], 40, &untangled(scene, true));
    assert!(asked > 10 && again > 0, "threads were asked for {asked} times, {again} frames were looked at again");
}

/// Two flags of 40² that are pinned along one line, exactly, in a gusty wind. Edges along the pole meet ties.
fn two_flags_on_a_pole() -> Scene {
    let mut scene = scenes::flags(2, 40);
    let [first, second] = &mut scene.cloths[..] else { unreachable!("two flags") };
    let turn = Quat::from_rotation_y(0.3);
    let (mine, theirs) = (&mut second.sim.state, &first.sim.state);
    for (x, other) in mine.positions.iter_mut().zip(&theirs.positions) {
        let at = if other.w == 0.0 { other.truncate() } else { turn * other.truncate() };
        *x = at.extend(other.w);
    }
    mine.previous.clone_from(&mine.positions);
    second.anchors = first.anchors.clone();
    scene
}

#[test]
fn cloths_on_one_line_of_pins_have_the_same_bits_with_any_number_of_threads() {
    let (asked, _) = has_the_same_bits("two flags", &[4], 60, &untangled(two_flags_on_a_pole(), true));
    assert!(asked > 10, "threads were asked for {asked} times");
}

#[test]
fn too_much_work_is_left_to_the_next_frame_by_one_thread_as_by_many() {
    for (name, effort, scene) in [("pile", 64, scenes::stack(4, 24)), ("two flags", 32, two_flags_on_a_pole())] {
        let mut scene = untangled(scene, true);
        if let Some(untangling) = &mut scene.untangle {
            untangling.settings.effort = effort;
        }
        let (asked, cut) = (has_the_same_bits(name, &[3], 40, &scene).0, cut(&scene, 40));
        assert!(asked > 0 && cut > 0, "{name}: threads were asked for {asked} times, {cut} frames left work to the next");
    }
}

/// In how many frames looks were cut.
fn cut(scene: &Scene, frames: u32) -> usize {
    let mut scene = scene.clone();
    let mut is_cut = || {
        scene.step(FRAME);
        scene.untangle.as_ref().is_some_and(|untangling| !untangling.island.deferred().is_nothing())
    };
    (0..frames).filter(|_| is_cut()).count()
}
