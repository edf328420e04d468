//! Named and random tangles come apart, at load as well; what nothing takes apart is drawn to its shape at rest.

use bevy_drape::solver::anchors::Anchors;
use bevy_drape::solver::evaluate::EvaluateSettings;
use bevy_drape::solver::island::UntangleSettings;
use bevy_drape::solver::resolve::{Method, ResolveSettings};
use bevy_drape::solver::verdict::Escalation;
use drape_scenes::{self as scenes, Scene, SceneCloth, Seed, Tangle, untangled};
use glam::Vec3;

use super::{FRAME, clean_after, positions, worst_edge};

/// How heavy the two sheets of a scene are.
#[derive(Clone, Copy, Debug)]
enum Masses {
    Equal,
    Heavy(usize),
    Pinned(usize),
}

const MASSES: [Masses; 5] = [Masses::Equal, Masses::Heavy(0), Masses::Heavy(1), Masses::Pinned(0), Masses::Pinned(1)];

/// Through how much of the other sheet the smaller part of one reaches [m]; for an overlap of borders, how far they reach past
/// each other.
fn depth(tangle: Tangle) -> f32 {
    match tangle {
        Tangle::Dent | Tangle::Waves => 0.1,
        Tangle::DeepDent => 0.4,
        Tangle::BorderOverlap => 0.45,
        Tangle::Corner | Tangle::StripStab | Tangle::TiltedStrip | Tangle::FullCut => 0.33,
    }
}

fn weigh(scene: &mut Scene, masses: Masses) {
    match masses {
        Masses::Equal => {}
        Masses::Heavy(k) => scene.cloths[k].fabric.density *= 1000.0,
        Masses::Pinned(k) => {
            let cloth = &mut scene.cloths[k];
            let targets: Vec<Vec3> = cloth.sim.state.positions.iter().map(|p| p.truncate()).collect();
            let particles = (0..targets.len() as u32).collect();
            cloth.anchors = Anchors { particles, weights: vec![1.0; targets.len()], from: targets.clone(), to: targets };
        }
    }
    scene.cloths.iter_mut().for_each(SceneCloth::prepare);
}

fn farthest(from: &[Vec3], scene: &Scene) -> f32 {
    positions(scene).iter().zip(from).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
}

fn come_apart(n: u32, jitters: u64, self_collision: bool) {
    for tangle in Tangle::ALL {
        for masses in MASSES {
            for seed in 1..=jitters {
                let mut scene = scenes::tangle(tangle, n);
                scene = scene.jittered(seed);
                weigh(&mut scene, masses);
                let start = positions(&scene);
                let mut scene = untangled(scene, self_collision);
                let what = format!("{} {n}² {masses:?}, jitter {seed}, self-collision {self_collision}", tangle.name());
                let clean = clean_after(&mut scene, 120);
                assert!(clean.is_some(), "{what}: {} crossings after 2 s", scene.crossings());
                let (moved, most) = (farthest(&start, &scene), 2.0 * depth(tangle) + 1.0 / (n - 1) as f32);
                assert!(moved <= most, "{what}: moved by {moved} m of {most}");
                (0..30).for_each(|_| scene.step(FRAME));
                assert!(worst_edge(&scene) < 1.2, "{what}: strain {}", worst_edge(&scene));
            }
        }
    }
}

#[test]
fn the_eight_scenes_come_apart_at_13_for_all_masses_and_ten_jittered_starts() {
    come_apart(13, 10, false);
}

#[test]
fn the_eight_scenes_come_apart_at_30_for_all_masses_and_ten_jittered_starts() {
    come_apart(30, 10, false);
}

#[test]
fn the_eight_scenes_come_apart_at_64_for_all_masses() {
    come_apart(64, 1, false);
}

#[test]
fn the_eight_scenes_come_apart_when_sheets_collide_with_themselves() {
    come_apart(13, 3, true);
    come_apart(30, 2, true);
}

#[test]
fn the_summed_gradient_leaves_cut_sheets_tangled_for_two_seconds_and_the_local_one_undoes_a_dent() {
    let with = |tangle, method| {
        let settings = UntangleSettings { resolve: ResolveSettings { method, ..Default::default() }, ..Default::default() };
        let mut scene = scenes::tangle(tangle, 13).untangled(settings, EvaluateSettings::default(), false).expect("two cloths");
        clean_after(&mut scene, 120)
    };
    for tangle in [Tangle::StripStab, Tangle::TiltedStrip, Tangle::FullCut] {
        assert_eq!(with(tangle, Method::GlobalGradient), None, "{}", tangle.name());
    }
    assert!(with(Tangle::Dent, Method::LocalGradient).is_some());
}

#[test]
fn of_random_tangles_all_are_clean_in_300_frames_and_almost_all_in_60() {
    let (mut tangled, mut soon, mut closed, mut closed_soon, mut grown) = (0, 0, 0, 0, Vec::new());
    for number in 0..150 {
        let run = Seed::new(number).run(UntangleSettings::default(), false, 300).expect("a few cloths");
        if run.start == 0 {
            continue;
        }
        let after = run.clean_after.unwrap_or_else(|| panic!("seed {number}: {} crossings left", run.left));
        tangled += 1;
        soon += u32::from(after <= 60);
        closed += u32::from(run.closed);
        closed_soon += u32::from(run.closed && after <= 60);
        if run.growth > 1.05 {
            grown.push(number);
        }
    }
    assert!(tangled > 120 && 100 * soon >= 99 * tangled, "{soon} of {tangled} within 60 frames");
    assert!(closed > 20 && 100 * closed_soon >= 99 * closed, "{closed_soon} of {closed} closed ones within 60 frames");
    assert!(grown.len() < 3, "contours grew in {grown:?}");
}

#[test]
fn at_load_everything_comes_apart_without_velocity() {
    for tangle in Tangle::ALL {
        let mut scene = untangled(scenes::tangle(tangle, 20), true);
        let report = scene.untangle_at_load(400);
        let what = format!("{}: {report:?}", tangle.name());
        assert!(report.before.crossings > 0 && report.after.is_clean() && scene.look().is_clean(), "{what}");
        assert!(report.farthest <= depth(tangle), "{what}");
        let states = scene.cloths.iter().map(|c| &c.sim.state);
        let moves = states.flat_map(|s| s.positions.iter().zip(&s.previous)).map(|(a, b)| (*a - *b).truncate().length());
        let fastest = moves.fold(0.0, f32::max);
        assert!(fastest < 1.0e-5, "{what}: {fastest} m per substep");
    }
    let left: Vec<u64> = (0..60)
        .filter(|&k| {
            let mut scene = untangled(Seed::new(k).scene(), true);
            !scene.untangle_at_load(600).after.is_clean()
        })
        .collect();
    assert_eq!(left, Vec::<u64>::new(), "seeds still tangled");
}

#[test]
fn what_nothing_takes_apart_is_drawn_to_its_shape_at_rest_in_the_end() {
    // Without iterations only the last resort does anything.
    let settings = UntangleSettings { iterations: 0, ..UntangleSettings::default() };
    let mut scene = Seed::new(4).scene().untangled(settings, EvaluateSettings::default(), true).expect("a sheet");
    let mut seen = Vec::new();
    let clean = (1..=600).find(|_| {
        scene.step(FRAME);
        let outcome = scene.cloths[0].sim.display.outcome();
        if outcome.became_last_resort || seen.last() != Some(&outcome.escalation) {
            seen.push(outcome.escalation);
        }
        scene.crossings() == 0
    });
    assert!(clean.is_some(), "{} crossings left", scene.crossings());
    let expected = [Escalation::None, Escalation::Regions, Escalation::Candidates, Escalation::Blend];
    assert!(seen.starts_with(&expected), "{seen:?}");
}

#[test]
fn any_thread_gives_the_same_bits() {
    let run = || {
        let mut scene = untangled(Seed::new(3).scene(), true);
        (0..20).for_each(|_| scene.step(FRAME));
        positions(&scene)
    };
    let here = run();
    let there: Vec<_> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..3).map(|_| scope.spawn(run)).collect();
        workers.into_iter().filter_map(|w| w.join().ok()).collect()
    });
    assert!(there.len() == 3 && there.iter().all(|t| *t == here));
}
