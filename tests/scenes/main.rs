//! Scenes in which cloth folds, twists and is pinched show no crossing, in any frame, from any of a few starts that differ by a
//! thousandth of an edge. What is shown is checked with code that shares nothing with the detector.

mod contact;
mod gusts;
mod threads;

use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use drape_scenes::shown::Picture;
use drape_scenes::{self as scenes, Scene, untangled};

const FRAME: f32 = 1.0 / 60.0;

/// Runs a scene from three starts and asserts that no shown frame crosses, that at most 0.5 % of all frames are held, and that
/// no edge is ever longer than `longest` times its rest length.
fn shows_no_crossing(name: &str, frames: u32, longest: f32, scene: impl Fn() -> Scene) {
    shows_no_crossing_from([1, 2, 3], name, frames, longest, scene);
}

/// The same, from other starts.
fn shows_no_crossing_from<const N: usize>(seeds: [u64; N], name: &str, frames: u32, longest: f32, scene: impl Fn() -> Scene) {
    let (mut held, mut worst) = (0, 0.0f32);
    let all = frames * N as u32;
    for seed in seeds {
        let mut scene = untangled(scene().jittered(seed), true);
        for frame in 1..=frames {
            scene.step(FRAME);
            let crossings = Picture::of(&scene).crossings();
            assert_eq!(crossings, 0, "{name}, start {seed}, frame {frame}: shown crossings");
            held += u32::from(scene.is_held());
            worst = scene.cloths.iter().map(|c| c.report.worst_edge).fold(worst, f32::max);
        }
    }
    assert!(200 * held <= all, "{name}: {held} of {all} frames held");
    assert!(worst < longest, "{name}: worst edge {worst}");
}

#[test]
fn two_strips_fall_crosswise() {
    shows_no_crossing("crosswise", 240, 1.25, || scenes::crosswise(20));
}

#[test]
fn a_ball_swings_into_a_curtain() {
    shows_no_crossing("curtain", 240, 1.4, || scenes::curtain(20));
}

#[test]
fn a_skirt_walks() {
    shows_no_crossing("skirt", 300, 1.25, || scenes::skirt(20));
}

/// The edge of the table pushes faces out before friction acts. With friction first the cloth jams, and edges get 20 to 40
/// times as long.
#[test]
fn a_cloth_is_pulled_off_a_table() {
    shows_no_crossing("tablecloth", 180, 1.4, || scenes::tablecloth(30));
}

/// Its corners slide over each other and over those of the table. Where the CCD bounded the length of the way of what passes,
/// these three starts jammed: edges got 8, 50 and 103 times as long, and 49, 23 and 31 frames crossed.
#[test]
fn a_finer_cloth_is_pulled_off_a_table() {
    shows_no_crossing_from([4, 5], "tablecloth", 150, 3.5, || scenes::tablecloth(36));
    shows_no_crossing_from([0], "tablecloth", 150, 3.5, || scenes::tablecloth(45));
}

/// Where nothing else helps a cloth is put back as a whole. If it stayed where it was while its pins went on, it would be torn at
/// ever harder: edges of this start got 181 times as long, and 47 frames crossed.
#[test]
fn a_cloth_that_is_put_back_goes_along_with_its_pins() {
    shows_no_crossing_from([3], "tablecloth", 150, 5.5, || scenes::tablecloth(36));
}

#[test]
fn a_reef_knot_is_pulled_tight() {
    shows_no_crossing("reef knot", 270, 1.3, || scenes::reef_knot(40));
}

/// Its threads have to get longer.
#[test]
fn a_tube_is_twisted_by_more_than_two_turns() {
    shows_no_crossing_from([1], "twisted tube", 400, 3.0, || scenes::twisted_tube(32));
}

/// It is lower by more than a tenth under the ball.
#[test]
fn a_ball_presses_a_stack() {
    shows_no_crossing_from([1], "pressed", 240, 1.2, || scenes::pressed(16));
    let mut scene = untangled(scenes::pressed(16), true);
    let middle = |scene: &Scene| {
        let near = |x: &&glam::Vec4| x.x.hypot(x.z) < 0.05;
        scene.cloths.iter().flat_map(|c| &c.sim.state.positions).filter(near).map(|x| x.y).fold(0.0, f32::max)
    };
    (0..60).for_each(|_| scene.step(FRAME));
    let loose = middle(&scene);
    (0..90).for_each(|_| scene.step(FRAME));
    assert!(loose > 0.045 && middle(&scene) < 0.9 * loose, "{loose} m high, then {}", middle(&scene));
}

#[test]
fn a_sheet_winds_round_a_ball_that_begins_to_turn() {
    shows_no_crossing("turning ball", 360, 1.3, || scenes::turning_ball(30));
}

#[test]
fn a_skirt_spins_one_way_and_the_other() {
    shows_no_crossing("spin", 360, 1.25, || scenes::spin(20));
}

#[test]
fn a_pinched_corner_stays_whole_and_is_let_go() {
    shows_no_crossing("pinch", 300, 1.25, || scenes::pinch(20));
}

#[test]
fn a_sheet_falls_on_needles() {
    shows_no_crossing("needles", 180, 1.25, || scenes::needles(20));
}

/// Overwound until it is drawn over its pins, which cannot be taken back when cloth crosses them.
#[test]
fn a_strip_is_turned_at_both_ends_until_it_knots() {
    shows_no_crossing_from([4, 26], "twist", 420, 5.0, || scenes::twist(28));
}

#[test]
fn a_sheet_slips_through_a_funnel() {
    shows_no_crossing("funnel", 300, 1.25, || scenes::funnel(20));
}

/// In frames of up to 0.1 s, within which all of it moves by several edges.
#[test]
fn a_sheet_that_is_let_go_falls_in_a_heap_at_any_frame_rate() {
    for (rate, vertex) in [60, 20, 10].into_iter().flat_map(|rate| [(rate, 0), (rate, 15), (rate, 450)]) {
        let mut scene = untangled(scenes::heap(30, vertex), true);
        let mut worst = 0.0f32;
        for frame in 1..=7 * rate {
            scene.step(1.0 / rate as f32);
            assert_eq!(scene.crossings(), 0, "vertex {vertex}, frame {frame} at {rate} Hz");
            worst = worst.max(scene.cloths[0].report.worst_edge);
        }
        assert!(worst < 1.5, "vertex {vertex} at {rate} Hz: worst edge {worst}");
    }
}

#[test]
fn the_checker_counts_what_is_shown_of_every_cloth_also_of_one_that_is_pinned() {
    let mut scene = scenes::tangle(scenes::Tangle::FullCut, 12);
    scene.cloths[0].anchors = {
        let to: Vec<glam::Vec3> = scene.cloths[0].sim.state.positions.iter().map(|x| x.truncate()).collect();
        let particles = (0..to.len() as u32).collect();
        bevy_drape::solver::anchors::Anchors { particles, weights: vec![1.0; to.len()], from: to.clone(), to }
    };
    scene.cloths[0].prepare();
    let off = UntangleSettings { iterations: 0, ..UntangleSettings::default() };
    let mut scene = scene.untangled(off, EvaluateSettings::default(), true).expect("two sheets");
    scene.step(FRAME);
    let shown = Picture::of(&scene).crossings();
    assert!(shown > 0 && shown == scene.crossings() as usize, "{shown} shown, {} found", scene.crossings());
}
