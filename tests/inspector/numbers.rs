//! Bad numbers are refused, and the reason is shown.

use bevy_drape::ClothMaterial;
use bevy_drape::inspector::ClothInspector;
use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::pos2;
use egui_kittest::kittest::Queryable;

use crate::panel::Panel;

/// What the field that is called so shows.
fn text_of(panel: &Panel, label: &str) -> String {
    panel.harness.get_by_role_and_label(Role::TextInput, label).value().unwrap_or_default()
}

#[test]
fn numbers_that_make_no_sense_are_refused_with_the_reason_and_change_nothing() {
    let mut panel = Panel::new().opened();
    for (label, typed, reason) in [
        ("material density", "NaN", "density: `NaN` is not a number"),
        ("material density", "-0.2", "density: it must not be negative"),
        ("material density", "heavy", "density: `heavy` is not a number"),
        ("material stretch_stiffness", "1e12", "stretch_stiffness: 1e12 is out of range"),
        ("material stretch_stiffness", "inf", "stretch_stiffness: inf is out of range"),
        ("untangle iterations", "2.5", "iterations: 2.5 is not a whole number"),
        ("solver substep_rate", " ", "substep_rate: nothing was typed"),
        ("pins 0 weight", "2", "weight: 2 is out of range"),
    ] {
        let before = panel.settings();
        panel.type_into(label, typed);
        assert!(panel.shows(reason), "{label}: `{typed}` is refused without `{reason}`");
        assert_eq!(panel.settings(), before, "{label}: `{typed}` was taken");
    }
}

#[test]
fn a_good_number_after_a_bad_one_is_taken_and_the_reason_goes() {
    let mut panel = Panel::new();
    panel.type_into("material density", "-1");
    assert!(panel.shows("must not be negative"));
    panel.type_into("material density", "0.3 kg/m²");
    assert_eq!(panel.settings().material.density, 0.3);
    assert!(!panel.shows("must not be negative"));
}

#[test]
fn a_limit_is_switched_off_by_its_word() {
    let mut panel = Panel::new();
    panel.type_into("material strain_limit", "off");
    assert_eq!(panel.settings().material.strain_limit, f32::INFINITY);
    panel.click("reset material strain_limit");
    assert_eq!(panel.settings().material.strain_limit, 0.05);
}

#[test]
fn what_is_being_typed_goes_to_its_own_cloth_when_another_is_picked() {
    let mut panel = Panel::new();
    let other = panel.others();
    panel.begin_typing("material density", "5");
    panel.click("second");
    assert_eq!(panel.settings().material.density, 5.0);
    assert_eq!(panel.others(), other, "the other cloth got it");
    assert_eq!(text_of(&panel, "material density"), "0.2", "of the other cloth");
    // As when it is clicked in the scene: picked before the panel is drawn, with nothing of it under the pointer.
    panel.begin_typing("material density", "3");
    let (cloth, beside) = (panel.cloth, pos2(510.0, 4990.0));
    panel.harness.drag_at(beside);
    panel.steps(1);
    panel.app().world_mut().resource_mut::<ClothInspector>().selected = Some(cloth);
    panel.harness.drop_at(beside);
    panel.steps(3);
    assert_eq!(panel.others().material.density, 3.0);
    assert_eq!(panel.settings().material.density, 5.0, "the one that was picked got it");
    assert_eq!(text_of(&panel, "material density"), "5");
}

#[test]
fn what_is_being_typed_does_not_go_over_a_preset_that_is_clicked() {
    let mut panel = Panel::new().opened();
    panel.begin_typing("material density", "5");
    panel.click("preset silk");
    assert_eq!(panel.settings().material, ClothMaterial::SILK);
    panel.begin_typing("wind turbulence", "1.5");
    panel.click("a wind of its own");
    assert_eq!(panel.settings().own_wind.map(|own| own.0.turbulence), Some(1.5), "the wind of the world as it was typed");
}

#[test]
fn what_was_refused_goes_when_the_number_under_it_is_another() {
    let mut panel = Panel::new();
    let refused = |panel: &mut Panel| {
        panel.type_into("material density", "-1");
        assert!(panel.shows("must not be negative"));
    };
    let gone = |panel: &Panel, shown: &str| {
        assert!(!panel.shows("must not be negative"), "the reason is still there");
        assert_eq!(text_of(panel, "material density"), shown);
    };
    refused(&mut panel);
    panel.click("preset silk");
    gone(&panel, "0.06");
    // Another preset, and the same one again.
    refused(&mut panel);
    panel.click("preset silk");
    gone(&panel, "0.06");
    refused(&mut panel);
    panel.click("second");
    gone(&panel, "0.2");
    panel.click("first");
    gone(&panel, "0.06");
    refused(&mut panel);
    let cloth = panel.cloth;
    panel.app().world_mut().get_mut::<ClothMaterial>(cloth).expect("a cloth").density = 0.7;
    panel.steps(2);
    gone(&panel, "0.7");
}

#[test]
fn what_was_refused_at_the_default_has_a_way_back() {
    let mut panel = Panel::new();
    let before = panel.settings();
    panel.type_into("material density", "rubbish");
    assert!(panel.shows("is not a number"));
    panel.click("reset material density");
    assert!(!panel.shows("is not a number"), "the reason is still there");
    assert_eq!((text_of(&panel, "material density").as_str(), panel.settings() == before), ("0.2", true));
}
