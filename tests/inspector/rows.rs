//! Each setting changes its component and nothing else.

use core::any::TypeId;

use bevy::ecs::component::ComponentInfo;
use bevy::prelude::*;
use bevy::reflect::TypeInfo;
use bevy_drape::inspector::{ClothSettings, Kind, Part, Setting, settings, show};
use bevy_drape::prelude::*;
use bevy_egui::egui::accesskit::Role;
use bevy_egui::egui::vec2;
use egui_kittest::kittest::{NodeT, Queryable};

use crate::panel::Panel;

/// A panel in which every row exists: with limits and drive that are painted, inertia, a wind of its own, a level of detail, a
/// character with a body, a budget, and a maximum until clean.
fn with_all_rows() -> Panel {
    let mut panel = Panel::new();
    let cloth = panel.cloth;
    let world = panel.app().world_mut();
    let mut entity = world.entity_mut(cloth);
    let painted = |low: f32, high: f32| ClothMap::color(ClothColorChannel::G, low, high);
    let limits = ClothLimits { max_distance: painted(0.05, 0.3), backstop_distance: painted(0.01, 0.06), ..default() };
    let drive = ClothDrive { frequency: painted(1.0, 5.0), ..default() };
    let inertia = ClothInertia::CHARACTER;
    entity.insert((
        ClothWind::default(),
        ClothLod::default(),
        limits,
        drive,
        inertia,
        ClothPriority(3.0),
        ClothBlend { weight: 0.9, rate: 3.0 },
    ));
    entity.get_mut::<ClothSkipFrame>().expect("a cloth").policy = ClothSkipPolicy::UntilClean { max: 3 };
    let character = world.spawn((Transform::default(), ClothCharacter)).id();
    world.spawn((ClothBody { margin: 0.02, ..default() }, ChildOf(character)));
    world.entity_mut(cloth).insert(ChildOf(character));
    // So much that it lowers nothing.
    world.insert_resource(ClothBudget { ms: 900.0 });
    panel.opened()
}

/// A number that may be typed and is not there yet: at 0.7 of the slider.
fn another(setting: &Setting, now: f64) -> f64 {
    let scale = setting.scale().expect("a number");
    let (low, high) = scale.slider;
    let middle = if scale.log { low * (high / low).powf(0.7) } else { 0.3 * low + 0.7 * high };
    let middle = if scale.integer { middle.round() } else { f64::from(middle as f32) };
    assert_ne!(middle as f32, now as f32, "{}", setting.label());
    middle
}

/// What the settings should be after one of them was set.
fn with(before: &ClothSettings, setting: &Setting, value: f64) -> ClothSettings {
    let mut after = before.clone();
    setting.set(&mut after, value);
    after
}

/// The part that a component is tuned in; none when there is nothing in it to tune.
fn part_of(component: &str) -> Option<Part> {
    Some(match component {
        "ClothMaterial" => Part::Material,
        "ClothSolver" => Part::Solver,
        "ClothCollision" => Part::Collision,
        "ClothUntangling" => Part::Untangle,
        "ClothSkipFrame" => Part::Skip,
        "ClothSleep" => Part::Sleep,
        "ClothLimits" => Part::Limits,
        "ClothDrive" => Part::Drive,
        "ClothBlend" => Part::Blend,
        "ClothInertia" => Part::Inertia,
        "ClothBody" => Part::Body,
        "ClothLod" => Part::Lod,
        "ClothPriority" => Part::Priority,
        "ClothWind" => Part::OwnWind,
        "ClothGlobalWind" => Part::Wind,
        "ClothGravity" => Part::Gravity,
        "ClothBudget" => Part::Budget,
        // Pins have a row for each set: `pins_are_weakened_and_let_go`. The others say how it fares.
        "ClothPins" | "Cloth" | "ClothStatus" | "ClothReport" | "ClothBuildReport" => return None,
        other => panic!("{other} has no part in the panel"),
    })
}

/// Names of the fields of a struct; of one without names, those of what is in it.
fn fields(info: &TypeInfo, all: &bevy::reflect::TypeRegistry) -> Vec<String> {
    match info {
        TypeInfo::Struct(info) => info.field_names().iter().map(ToString::to_string).collect(),
        TypeInfo::TupleStruct(info) => {
            let inner = info.field_at(0).and_then(|field| all.get_type_info(field.type_id()));
            inner.map_or(Vec::new(), |inner| fields(inner, all))
        }
        _ => Vec::new(),
    }
}

#[test]
fn every_field_of_every_component_that_a_cloth_comes_with_has_a_row() {
    let mut panel = with_all_rows();
    let cloth = panel.cloth;
    let world = panel.app().world();
    let all = world.resource::<AppTypeRegistry>().read();
    let components = world.inspect_entity(cloth).expect("a cloth").filter_map(ComponentInfo::type_id);
    let of_world =
        [TypeId::of::<ClothGlobalWind>(), TypeId::of::<ClothGravity>(), TypeId::of::<ClothBudget>(), TypeId::of::<ClothBody>()];
    let mut walked = Vec::new();
    for info in components.chain(of_world).filter_map(|id| all.get_type_info(id)) {
        let path = info.type_path_table();
        let Some(part) = path.crate_name().filter(|name| *name == "bevy_drape").and_then(|_| part_of(path.short_path())) else {
            continue;
        };
        let fields = fields(info, &all);
        assert!(!fields.is_empty() || part == Part::Priority, "{part:?} has {fields:?}");
        // A space is an entity of the scene: the panel has none to choose from.
        for field in fields.into_iter().filter(|field| field != "space") {
            let found = settings().any(|s| s.part == part && s.name.split('.').next() == Some(field.as_str()));
            assert!(found, "{part:?} has no row for `{field}`");
        }
        walked.push(part);
    }
    for part in Part::ALL {
        assert!(part == Part::Pins || walked.contains(&part), "{part:?} is of no component");
    }
}

#[test]
fn every_default_is_in_its_range_and_every_slider_within_its_limits() {
    for setting in settings() {
        let default = setting.default_value();
        assert!(default.is_some(), "{} has no default", setting.label());
        let Some(scale) = setting.scale() else { continue };
        let (low, high) = scale.limits;
        assert!(low <= scale.slider.0 && scale.slider.0 < scale.slider.1 && scale.slider.1 <= high, "{}", setting.label());
        assert!(!scale.log || scale.slider.0 > 0.0, "{} begins at 0", setting.label());
        assert!(default.is_some_and(|value| scale.holds(value)), "{}: {default:?}", setting.label());
    }
}

#[test]
fn every_tip_is_a_sentence() {
    for setting in settings() {
        for tip in [setting.does, setting.low, setting.high] {
            let words = tip.split_whitespace().count();
            assert!(words > 1 && tip.len() > 8 && tip.ends_with('.'), "{}: `{tip}`", setting.label());
        }
    }
}

#[test]
fn switches_and_choices_mark_their_default() {
    let panel = with_all_rows();
    for setting in settings() {
        let (label, default) = (setting.label(), setting.default_value());
        match setting.kind {
            Kind::Switch { .. } => {
                let told = if default == Some(0.0) { "default off" } else { "default on" };
                let node = panel.harness.get_by_role_and_label(Role::CheckBox, &label);
                assert_eq!(node.accesskit_node().description().as_deref(), Some(told), "{label}");
            }
            Kind::Choice { options, .. } => {
                let marked = |option: &&&str| {
                    let name = format!("{label}: {option}");
                    panel.harness.get_by_label(&name).accesskit_node().description().as_deref() == Some("default")
                };
                let marked: Vec<_> = options.iter().filter(marked).collect();
                assert_eq!(marked, [&options[default.expect("a default") as usize]], "{label}");
            }
            Kind::Number(..) | Kind::Count(..) | Kind::Layer(..) => {}
        }
    }
}

#[test]
fn what_is_typed_into_a_row_changes_that_setting_and_nothing_else_and_leads_back() {
    let mut panel = with_all_rows();
    let others = panel.others();
    let mut walked = 0;
    for setting in settings().filter(|s| s.scale().is_some()) {
        let (label, before) = (setting.label(), panel.settings());
        let now = setting.get(&mut before.clone()).expect("a row");
        let value = another(setting, now);
        panel.type_into(&label, &show(value, setting.scale().is_some_and(|s| s.integer)));
        assert_eq!(panel.settings(), with(&before, setting, value), "{label}");
        // Only parts of the world are seen by the other cloth.
        if !matches!(setting.part, Part::Wind | Part::Gravity | Part::Budget) {
            assert_eq!(panel.others(), others, "{label} changed the other cloth");
        }
        panel.click(&format!("reset {label}"));
        let default = setting.default_value().expect("a default");
        assert_eq!(panel.settings(), with(&before, setting, default), "{label} does not lead back");
        walked += 1;
    }
    assert!(walked > 40, "{walked} numbers");
}

#[test]
fn a_slider_that_is_dragged_changes_its_setting_and_nothing_else() {
    let mut panel = with_all_rows();
    for setting in settings().filter(|s| s.scale().is_some()) {
        let (label, before) = (setting.label(), panel.settings());
        let rect = panel.harness.get_by_role_and_label(Role::Slider, &label).rect();
        let now = setting.get(&mut before.clone()).expect("a row");
        let share = setting.scale().map_or(0.0, |s| s.share(now)) as f32;
        let from = rect.lerp_inside(vec2(share.clamp(0.05, 0.95), 0.5));
        let to = rect.lerp_inside(vec2(if share > 0.5 { 0.2 } else { 0.8 }, 0.5));
        panel.harness.drag_at(from);
        panel.steps(1);
        panel.harness.hover_at(to);
        panel.steps(1);
        panel.harness.drop_at(to);
        panel.steps(2);
        let mut after = panel.settings();
        let value = setting.get(&mut after).expect("a row");
        assert_ne!(value as f32, now as f32, "{label} did not move");
        assert_eq!(after, with(&before, setting, value), "{label}");
    }
}

#[test]
fn every_switch_and_every_option_changes_its_setting_and_nothing_else() {
    let mut panel = with_all_rows();
    for setting in settings() {
        let label = setting.label();
        match setting.kind {
            Kind::Switch { .. } => {
                for _ in 0..2 {
                    let before = panel.settings();
                    let now = setting.get(&mut before.clone()).expect("a row");
                    panel.harness.get_by_role_and_label(Role::CheckBox, &label).click();
                    panel.steps(3);
                    assert_eq!(panel.settings(), with(&before, setting, 1.0 - now), "{label}");
                }
            }
            Kind::Choice { options, .. } => {
                for (i, option) in options.iter().enumerate().rev() {
                    let before = panel.settings();
                    panel.click(&format!("{label}: {option}"));
                    assert_eq!(panel.settings(), with(&before, setting, i as f64), "{label}: {option}");
                }
            }
            Kind::Number(..) | Kind::Count(..) | Kind::Layer(..) => {}
        }
    }
}

#[test]
fn what_is_switched_off_is_a_marker_on_the_cloth_and_comes_off_again() {
    fn has<C: Component>(panel: &mut Panel) -> [bool; 2] {
        let (cloth, other) = (panel.cloth, panel.other);
        [cloth, other].map(|entity| panel.app().world().entity(entity).contains::<C>())
    }
    let mut panel = Panel::new().opened();
    let click = |panel: &mut Panel, label: &str| {
        panel.harness.get_by_role_and_label(Role::CheckBox, label).click();
        panel.steps(3);
    };
    for _ in 0..2 {
        click(&mut panel, "sleep enabled");
        assert_eq!(
            (has::<ClothSleepDisabled>(&mut panel), has::<ClothUntanglingDisabled>(&mut panel)),
            ([true, false], [false; 2])
        );
        click(&mut panel, "untangle enabled");
        assert_eq!(has::<ClothUntanglingDisabled>(&mut panel), [true, false]);
        click(&mut panel, "sleep enabled");
        assert_eq!(
            (has::<ClothSleepDisabled>(&mut panel), has::<ClothUntanglingDisabled>(&mut panel)),
            ([false; 2], [true, false])
        );
        click(&mut panel, "untangle enabled");
        assert_eq!(has::<ClothUntanglingDisabled>(&mut panel), [false; 2]);
    }
}

#[test]
fn a_level_of_detail_comes_and_goes_with_its_switch() {
    let mut panel = Panel::new().opened();
    assert_eq!((panel.settings().lod, panel.shows("lod full_within")), (None, false));
    panel.harness.get_by_role_and_label(Role::CheckBox, "lod enabled").click();
    panel.steps(4);
    assert_eq!(panel.settings().lod, Some(ClothLod::default()));
    panel.type_into("lod full_within", "7");
    assert_eq!(panel.settings().lod, Some(ClothLod { full_within: 7.0, ..default() }));
    panel.harness.get_by_role_and_label(Role::CheckBox, "lod enabled").click();
    panel.steps(4);
    assert_eq!((panel.settings().lod, panel.others().lod), (None, None));
}

#[test]
fn inertia_and_the_budget_come_and_go_with_their_switches() {
    let mut panel = Panel::new().opened();
    let switch = |panel: &mut Panel, label: &str| {
        panel.harness.get_by_role_and_label(Role::CheckBox, label).click();
        panel.steps(4);
    };
    assert_eq!((panel.settings().inertia, panel.shows("inertia max_speed")), (None, false));
    switch(&mut panel, "inertia enabled");
    panel.type_into("inertia max_speed", "8");
    assert_eq!(panel.settings().inertia, Some(ClothInertia { max_speed: 8.0, ..default() }));
    switch(&mut panel, "inertia enabled");
    assert_eq!((panel.settings().inertia, panel.others().inertia), (None, None));
    assert!(!panel.app().world().contains_resource::<ClothBudget>());
    switch(&mut panel, "budget enabled");
    panel.type_into("budget ms", "2");
    assert_eq!(panel.app().world().get_resource::<ClothBudget>(), Some(&ClothBudget { ms: 2.0 }));
    switch(&mut panel, "budget enabled");
    assert!(!panel.app().world().contains_resource::<ClothBudget>());
}

#[test]
fn every_body_of_the_character_is_set_and_no_other() {
    let mut panel = Panel::new().opened();
    assert!(!panel.shows("body margin"), "it belongs to no character");
    let cloth = panel.cloth;
    let world = panel.app().world_mut();
    let character = world.spawn((Transform::default(), ClothCharacter)).id();
    let own = [0; 2].map(|_| world.spawn((ClothBody::default(), ChildOf(character))).id());
    let other = world.spawn(ClothBody::default()).id();
    world.entity_mut(cloth).insert(ChildOf(character));
    panel.steps(4);
    panel.type_into("body margin", "0.03");
    let margin = |panel: &mut Panel, body: Entity| panel.app().world().get::<ClothBody>(body).map(|body| body.margin);
    assert_eq!(own.map(|body| margin(&mut panel, body)), [Some(0.03); 2]);
    assert_eq!(margin(&mut panel, other), Some(0.015));
}

#[test]
fn limits_come_and_go_with_their_switch_and_a_map_has_the_rows_of_what_it_is() {
    let mut panel = Panel::new().opened();
    let switch = |panel: &mut Panel| {
        panel.harness.get_by_role_and_label(Role::CheckBox, "limits enabled").click();
        panel.steps(4);
    };
    let distance = |panel: &mut Panel| panel.settings().limits.map(|limits| limits.max_distance);
    let rows = |panel: &Panel| ["low", "high"].map(|end| panel.shows(&format!("limits max_distance.{end}")));
    assert_eq!((panel.settings().limits, panel.shows("limits scale")), (None, false));
    switch(&mut panel);
    assert_eq!(panel.settings().limits, Some(ClothLimits::default()));
    assert_eq!(rows(&panel), [false, false]);
    panel.click("limits max_distance: Uniform");
    panel.steps(4);
    assert_eq!(rows(&panel), [false, true]);
    panel.type_into("limits max_distance.high", "0.4");
    assert_eq!(distance(&mut panel), Some(ClothMap::Uniform(0.4)));
    panel.click("limits max_distance: Painted");
    panel.steps(4);
    assert_eq!(rows(&panel), [true, true]);
    panel.type_into("limits max_distance.low", "0.1");
    assert_eq!(distance(&mut panel), Some(ClothMap::attribute("_CLOTH_MAXDIST", 0.1, 0.4)));
    panel.type_into("limits scale", "0.5");
    assert_eq!(panel.settings().limits.map(|limits| limits.scale), Some(0.5));
    panel.click("copy as Rust");
    let copied =
        "max_distance: ClothMap::Painted { paint: ClothPaint::Attribute(\"_CLOTH_MAXDIST\".into()), low: 0.1, high: 0.4 }";
    assert!(panel.copied.as_deref().is_some_and(|text| text.contains(copied)), "{:?}", panel.copied);
    switch(&mut panel);
    assert_eq!((panel.settings().limits, panel.others().limits), (None, None));
}

#[test]
fn a_drive_comes_and_goes_with_its_switch() {
    let mut panel = Panel::new().opened();
    let switch = |panel: &mut Panel| {
        panel.harness.get_by_role_and_label(Role::CheckBox, "drive enabled").click();
        panel.steps(4);
    };
    assert_eq!((panel.settings().drive, panel.shows("drive damping_ratio")), (None, false));
    switch(&mut panel);
    panel.click("drive frequency: Uniform");
    panel.steps(4);
    panel.type_into("drive frequency.high", "6");
    panel.type_into("drive damping_ratio", "0.5");
    let drive = ClothDrive { frequency: ClothMap::Uniform(6.0), damping_ratio: 0.5 };
    assert_eq!(panel.settings().drive, Some(drive));
    switch(&mut panel);
    assert_eq!((panel.settings().drive, panel.others().drive), (None, None));
}

#[test]
fn a_wind_of_its_own_comes_and_goes_with_its_switch() {
    let mut panel = Panel::new().opened();
    assert_eq!(panel.settings().own_wind, None);
    panel.click("a wind of its own");
    let wind = panel.settings().wind;
    assert_eq!(panel.settings().own_wind, Some(ClothWind(wind)));
    panel.steps(4);
    panel.type_into("own wind velocity.x", "7");
    assert_eq!(panel.settings().own_wind.map(|w| w.0.velocity.x), Some(7.0));
    assert_eq!(panel.settings().wind, wind, "the wind in the world");
    panel.click("a wind of its own");
    assert_eq!(panel.settings().own_wind, None);
}

#[test]
fn nothing_that_is_only_looked_at_is_marked_as_changed() {
    let mut panel = Panel::new().opened();
    let cloth = panel.cloth;
    let ticks = |world: &World| {
        let of = world.entity(cloth);
        [
            of.get_ref::<ClothMaterial>().map(|c| c.last_changed()),
            of.get_ref::<ClothSolver>().map(|c| c.last_changed()),
            of.get_ref::<ClothPins>().map(|c| c.last_changed()),
            of.get_ref::<ClothUntangling>().map(|c| c.last_changed()),
        ]
        .map(|tick| tick.expect("a cloth").get())
    };
    let before = ticks(panel.app().world());
    panel.steps(5);
    assert_eq!(ticks(panel.app().world()), before);
    panel.type_into("material density", "0.5");
    let after = ticks(panel.app().world());
    assert!(after[0] != before[0] && after[1..] == before[1..], "{before:?}, then {after:?}");
}

#[test]
fn pins_are_weakened_and_let_go() {
    let mut panel = Panel::new().opened();
    panel.type_into("pins 0 weight", "0.25");
    assert_eq!(panel.settings().pins.sets[0].weight, 0.25);
    panel.click("pins on_target_lost: Release");
    assert_eq!(panel.settings().pins.on_target_lost, ClothOnTargetLost::Release);
    panel.click("pins 0 let go");
    assert!(panel.settings().pins.sets.is_empty());
    assert_eq!(panel.others().pins.sets.len(), 1, "those of the other cloth stay");
}
