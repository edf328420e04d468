//! Bad numbers are refused, and the reason is shown.

use crate::panel::Panel;

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
