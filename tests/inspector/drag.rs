//! Every slider is dragged on a pile at rest: settings stay settings.

use bevy::prelude::*;
use bevy_drape::inspector::{ClothSettings, Part, Setting, settings};
use bevy_drape::prelude::*;
use bevy_drape::{ClothIslands, ClothSnapshot};

use crate::common::*;

/// Frames over which a slider is dragged: two seconds.
const FRAMES: u32 = 120;

/// The value at a share of the slider.
fn at(setting: &Setting, share: f64) -> f64 {
    let scale = setting.scale().expect("a number");
    let (low, high) = scale.slider;
    let value = if scale.log { low * (high / low).powf(share) } else { low + share * (high - low) };
    if scale.integer { value.round() } else { f64::from(value as f32) }
}

#[test]
fn every_slider_that_is_dragged_on_a_pile_at_rest_builds_nothing_anew_and_keeps_contacts_and_sides() {
    let mut app = app();
    app.world_mut().spawn(ClothCollider::ground());
    let material = ClothMaterial { thickness: 0.01, ..default() };
    let cloths = [0.01, 0.03].map(|y| {
        let place = Transform::from_xyz(0.0, y, 0.0);
        spawn(&mut app, sheet(12), (material.clone(), place, ClothSleepDisabled, ClothWind::default()))
    });
    run(&mut app, 180);
    let builds = app.world().resource::<ClothIslands>().builds();
    let (contacts, rest) = (report(&app, cloths[1]).contacts, ClothSnapshot::capture(app.world_mut()));
    let (before, untouched) =
        (cloths.map(|cloth| particles(&app, cloth)), ClothSettings::read(app.world(), cloths[0]).expect("a cloth"));
    assert!(contacts > 100, "{contacts}");
    let mut dragged = 0;
    for setting in settings().filter(|s| s.scale().is_some()) {
        let Some(now) = setting.get(&mut untouched.clone()) else { continue };
        let share = setting.scale().map_or(0.0, |scale| scale.share(now));
        let mut fewest = contacts;
        for frame in 0..FRAMES {
            let off = 0.1 * f64::from((0.1 * frame as f32).sin().abs());
            let mut tuned = untouched.clone();
            setting.set(&mut tuned, at(setting, if share > 0.5 { share - off } else { share + off }));
            cloths.iter().for_each(|&cloth| tuned.write(setting.part, app.world_mut(), cloth));
            app.update();
            fewest = fewest.min(report(&app, cloths[1]).contacts);
            // A pair that changed its sides would cross, and be shown in a clean shape of before.
            let is_apart = |&cloth: &Entity| report(&app, cloth).crossings == 0 && !report(&app, cloth).held;
            assert!(cloths.iter().all(is_apart), "{}, frame {frame}", setting.label());
        }
        assert_eq!(app.world().resource::<ClothIslands>().builds(), builds, "{}", setting.label());
        let way = |(&cloth, before): (&Entity, &Vec<Vec3>)| {
            particles(&app, cloth).iter().zip(before).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max)
        };
        let moved = cloths.iter().zip(&before).map(way).fold(0.0, f32::max);
        // Thickness and gravity ask for another place; wind blows the pile off.
        let bound = match setting.part {
            Part::Gravity => 0.012,
            Part::Material if setting.name == "thickness" => 0.012,
            Part::OwnWind if setting.name.starts_with("velocity") => f32::INFINITY,
            _ => 0.002,
        };
        assert!(moved < bound, "{}: a particle moved by {moved} m", setting.label());
        assert!(fewest > contacts / 2 || bound.is_infinite(), "{}: {fewest} contacts of {contacts}", setting.label());
        cloths.iter().for_each(|&cloth| untouched.write(setting.part, app.world_mut(), cloth));
        rest.restore(app.world_mut()).expect("the same cloths");
        dragged += 1;
    }
    assert!(dragged > 40, "{dragged} sliders");
}
