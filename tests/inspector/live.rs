//! Changes take effect at once and never make the cloth jump; without the panel nothing is different.

use bevy::prelude::*;
use bevy_drape::ClothParticles;
use bevy_drape::prelude::*;

use crate::common::*;
use crate::panel::{Panel, app_with_panel};

/// How far a vertex may move in the frame after a change [m].
const JUMP: f32 = 0.005;
/// How far it does at most when stiffness goes to its new value step by step; at once it would be 0.9 mm [m].
const EASED: f32 = 0.0001;

/// A sheet that hangs still.
fn hanging(material: ClothMaterial) -> (App, Entity) {
    let mut app = app();
    let material = ClothMaterial { drag: 4.0, ..material };
    let cloth = spawn(&mut app, sheet(32), (border(), Transform::from_xyz(0.0, 2.0, 0.0), material));
    run(&mut app, 600);
    (app, cloth)
}

/// Farthest way of a vertex in the first frame after a change, and in any of the next thirty [m].
fn ways(app: &mut App, cloth: Entity, change: impl FnOnce(&mut ClothMaterial)) -> (f32, f32) {
    change(&mut app.world_mut().get_mut::<ClothMaterial>(cloth).expect("a cloth"));
    let mut before = world_positions(app, cloth);
    let mut frames = Vec::new();
    for _ in 0..30 {
        app.update();
        let after = world_positions(app, cloth);
        frames.push(before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max));
        before = after;
    }
    (frames[0], frames.iter().copied().fold(0.0, f32::max))
}

/// Stretches without a limit, so that nothing but its stiffness holds it.
fn free(stretch_stiffness: f32) -> ClothMaterial {
    ClothMaterial { stretch_stiffness, strain_limit: 1.0, tether_scale: f32::INFINITY, ..default() }
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures of the documentation")]
fn a_hundred_times_stiffer_or_softer_moves_no_vertex_by_more_than_5_mm_in_the_next_frame() {
    let usual = ClothMaterial::default();
    let cases = [(usual.clone(), 100.0, EASED), (usual, 0.01, EASED), (free(50.0), 100.0, JUMP), (free(5000.0), 0.01, JUMP)];
    for (material, factor, bound) in cases {
        let start = material.stretch_stiffness;
        let (mut app, cloth) = hanging(material);
        let (next, most) = ways(&mut app, cloth, |material| {
            material.stretch_stiffness *= factor;
            material.shear_stiffness *= factor;
            material.bend_stiffness *= factor;
        });
        println!("{start} N/m times {factor}: {:.3} mm in the next frame, {:.3} mm in any", 1.0e3 * next, 1.0e3 * most);
        assert!(next < bound, "{} mm in the next frame at {start} N/m times {factor}", 1.0e3 * next);
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures of the documentation")]
fn another_fabric_density_or_limit_does_not_make_it_jump_either() {
    let heavier = |m: &mut ClothMaterial| m.density *= 20.0;
    let (mut app, cloth) = hanging(ClothMaterial::SILK);
    let (next, most) = ways(&mut app, cloth, heavier);
    println!("density times 20: {:.3} mm in the next frame, {:.3} mm in any", 1.0e3 * next, 1.0e3 * most);
    assert!(next < JUMP, "density: {next} m");
    for (from, to) in [("silk", "leather"), ("leather", "silk"), ("rubber", "denim"), ("cotton", "rubber")] {
        let [from_, to_] = [from, to].map(|name| ClothMaterial::preset(name).expect("a preset"));
        let (mut app, cloth) = hanging(from_);
        let (next, most) = ways(&mut app, cloth, |material| *material = to_);
        println!("{from} to {to}: {:.3} mm in the next frame, {:.3} mm in any", 1.0e3 * next, 1.0e3 * most);
        assert!(next < JUMP, "{from} to {to}: {next} m");
    }
}

#[test]
#[expect(clippy::print_stdout, reason = "the figures of the documentation")]
fn no_preset_after_another_moves_a_vertex_of_a_hanging_sheet_by_more_than_5_mm_in_any_frame() {
    let pairs: Vec<_> = ClothMaterial::PRESETS
        .iter()
        .flat_map(|from| ClothMaterial::PRESETS.iter().map(move |to| (from, to)))
        .filter(|(from, to)| from.0 != to.0)
        .collect();
    let mut app = app();
    // Side by side, too far from each other to meet.
    let cloths: Vec<Entity> = (0..)
        .zip(&pairs)
        .map(|(i, ((_, from), _))| {
            let material = ClothMaterial { drag: 4.0, ..from.clone() };
            spawn(&mut app, sheet(32), (border(), Transform::from_xyz(2.0 * i as f32, 2.0, 0.0), material))
        })
        .collect();
    run(&mut app, 480);
    for (&cloth, (_, (_, to))) in cloths.iter().zip(&pairs) {
        *app.world_mut().get_mut::<ClothMaterial>(cloth).expect("a cloth") = to.clone();
    }
    let mut before: Vec<Vec<Vec3>> = cloths.iter().map(|&cloth| world_positions(&app, cloth)).collect();
    let mut most = vec![(0.0_f32, 0); pairs.len()];
    for frame in 0..360 {
        app.update();
        for ((&cloth, before), most) in cloths.iter().zip(&mut before).zip(&mut most) {
            let after = world_positions(&app, cloth);
            let way = before.iter().zip(&after).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
            if way > most.0 {
                *most = (way, frame);
            }
            *before = after;
        }
    }
    for (((from, _), (to, _)), (way, frame)) in pairs.iter().zip(&most) {
        println!("{from} to {to}: {:.2} mm at most, in frame {frame}", 1.0e3 * way);
    }
    for (((from, _), (to, _)), (way, frame)) in pairs.iter().zip(&most) {
        assert!(*way < JUMP, "{from} to {to}: {} mm in frame {frame}", 1.0e3 * way);
    }
}

#[test]
fn the_new_stiffness_is_reached() {
    let sag = |change: Option<f32>, start: f32| {
        let (mut app, cloth) = hanging(free(start));
        if let Some(stiffness) = change {
            app.world_mut().get_mut::<ClothMaterial>(cloth).expect("a cloth").stretch_stiffness = stiffness;
            run(&mut app, 600);
        }
        report(&app, cloth).mean_edge
    };
    let (soft, stiff) = (sag(None, 50.0), sag(None, 5000.0));
    let (softened, stiffened) = (sag(Some(50.0), 5000.0), sag(Some(5000.0), 50.0));
    assert!(soft > stiff + 0.005, "{soft} and {stiff}");
    assert!((soft - softened).abs() < 2.0e-3 && (stiff - stiffened).abs() < 2.0e-3, "{softened} and {stiffened}");
}

#[test]
fn with_the_panel_drawn_in_every_frame_and_without_the_cloth_has_the_same_bits() {
    let start = |mut app: App| {
        let cloth = spawn(&mut app, sheet(16), (border(), Transform::from_xyz(0.0, 2.0, 0.0)));
        app.insert_resource(ClothGlobalWind::new(Vec3::new(3.0, 0.0, 1.0)));
        (app, cloth)
    };
    let bits = |app: &App, cloth| app.world().get::<ClothParticles>(cloth).expect("a bound cloth").state().clone();
    let (mut plain, cloth) = start(app());
    run(&mut plain, 90);
    let plain = bits(&plain, cloth);
    let (app, cloth) = start(app_with_panel());
    let mut panel = Panel::over(app, cloth, cloth).opened();
    for _ in 0..90 {
        panel.app().update();
        panel.steps(1);
        assert!(panel.shows("density"), "the panel is not drawn");
    }
    assert!(bits(panel.app(), cloth) == plain, "the panel changed the cloth");
}
