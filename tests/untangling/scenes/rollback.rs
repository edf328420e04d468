//! What came to cross within a frame is taken back, and what cannot come apart does not get worse.

use drape_scenes::{self as scenes, untangled};
use glam::{Vec3, Vec4};

use super::FRAME;

/// Where cloth is pressed from all sides there is no way out of a tangle within a frame, and every try would make it worse.
#[test]
fn a_knot_that_is_torn_at_does_not_get_more_tangled() {
    let mut knot = untangled(scenes::twist(28), true);
    for _ in 0..330 {
        knot.step(FRAME);
    }
    knot.untangle = None;
    let edge = knot.cloths[0].rest.mean_edge;
    let mut rng = fastrand::Rng::with_seed(3);
    let mut tangles = 0;
    for _ in 0..10 {
        // It knows nothing of how it was before.
        let mut scene = untangled(knot.clone(), true);
        let state = &mut scene.cloths[0].sim.state;
        let heart = state.positions.iter().map(|x| x.truncate()).min_by(|a, b| a.length().total_cmp(&b.length()));
        let heart = heart.unwrap_or_default();
        for (x, previous) in state.positions.iter_mut().zip(&mut state.previous) {
            if x.w > 0.0 && x.truncate().distance(heart) < 2.0 * edge {
                let by = Vec3::from_array(core::array::from_fn(|_| edge * (rng.f32() - 0.5))).extend(0.0);
                *x += by;
                *previous += by;
            }
        }
        let before = scene.look();
        scene.finish_frame(FRAME);
        let after = scene.look();
        assert!(
            after.contour_length <= (2.0 * before.contour_length).max(before.contour_length + 8.0 * edge),
            "{before:?} {after:?}"
        );
        tangles += u32::from(!before.is_clean());
    }
    assert!(tangles >= 5, "{tangles} of 10");
}

/// The particle nearest to the vertical axis.
fn middle(positions: &[Vec4]) -> usize {
    let from_axis = |&i: &usize| positions[i].truncate().with_y(0.0).length();
    (0..positions.len()).min_by(|i, j| from_axis(i).total_cmp(&from_axis(j))).unwrap_or_default()
}

#[test]
fn what_came_to_cross_within_a_frame_is_taken_back_and_keeps_its_velocity() {
    let mut scene = untangled(scenes::sheets(12), true);
    scene.step(FRAME);
    assert_eq!(scene.crossings(), 0);
    let [first, second] = [0, 1].map(|k| scene.cloths[k].sim.state.positions[0].y);
    let (upper, gap) = if first > second { (0, first - second) } else { (1, second - first) };
    // The particle over the middle of both goes through the other sheet, as a whole.
    let positions = &scene.cloths[upper].sim.state.positions;
    let v = middle(positions);
    let (before, velocity) = (positions[v], scene.cloths[upper].sim.state.velocity(v));
    let state = &mut scene.cloths[upper].sim.state;
    for x in [&mut state.positions[v], &mut state.previous[v]] {
        x.y -= 2.0 * gap;
    }
    assert!(scene.look().crossings > 0);
    scene.finish_frame(FRAME);
    assert_eq!(scene.crossings(), 0);
    let state = &scene.cloths[upper].sim.state;
    assert!(state.positions[v].distance(before) < 0.01 * gap && state.velocity(v).distance(velocity) < 1e-3);
}

#[test]
fn what_came_from_far_is_taken_back_if_it_flew_there() {
    let taken_back = |flies: bool| {
        let mut scene = untangled(scenes::sheets(12), true);
        scene.step(FRAME);
        let upper = usize::from(scene.cloths[0].sim.state.positions[0].y < scene.cloths[1].sim.state.positions[0].y);
        let cloth = &mut scene.cloths[upper];
        let positions = &mut cloth.sim.state.positions;
        let v = middle(positions);
        let (before, way) = (positions[v], 6.0 * cloth.rest.mean_edge);
        positions[v].y -= way;
        let flown = if flies { way * cloth.sim.state.substep / FRAME } else { 0.0 };
        cloth.sim.state.previous[v].y = positions[v].y + flown;
        scene.finish_frame(FRAME);
        scene.cloths[upper].sim.state.positions[v].distance(before) < 0.01 * way
    };
    assert!(taken_back(true));
    assert!(!taken_back(false));
}

#[test]
fn cloth_that_flutters_is_looked_at_twice_a_frame_whatever_its_substeps() {
    // Six substeps, five, one.
    for (rate, flutters) in [(60.0, true), (75.0, true), (360.0, false)] {
        let mut scene = untangled(scenes::flags(1, 16), true);
        let mut twice = 0;
        for frame in 0..3 * rate as u32 {
            scene.step(1.0 / rate);
            assert_eq!(scene.crossings(), 0, "frame {frame} at {rate} Hz");
            let horizon = scene.untangle.as_ref().map_or(0.0, |u| u.island.horizon());
            let substeps = horizon * rate * (360.0 / rate - 1e-3_f32).ceil();
            assert!((substeps - substeps.round()).abs() < 1e-3, "{substeps} substeps at {rate} Hz");
            twice += u32::from(horizon < 0.99 / rate);
        }
        assert_eq!(twice > 0, flutters, "{twice} frames at {rate} Hz");
    }
}

#[test]
fn what_is_taken_back_into_the_wall_of_a_funnel_stays_where_it_was_and_does_not_cross() {
    // In this start the wall pushes what was taken back, in the 66th frame, so that it would cross again.
    let mut scene = untangled(scenes::funnel(28).jittered(1), true);
    for frame in 1..=120 {
        scene.step(FRAME);
        assert_eq!(scene.crossings(), 0, "frame {frame}");
    }
}
