//! The table of all settings: one line each drives its row in the panel, its tests, and what differs between A and B.

mod air;
mod character;
mod contact;
mod follow;
mod lod;
mod material;
mod sleep;
mod solver;

use super::part::Part;
use super::setting::Setting;

/// The settings of a part, in the order of its fields. Those of the pins depend on the cloth and are not in the table.
#[must_use]
pub const fn settings_of(part: Part) -> &'static [Setting] {
    match part {
        Part::Material => &material::MATERIAL,
        Part::Solver => &solver::SOLVER,
        Part::Collision => &contact::COLLISION,
        Part::Untangle => &contact::UNTANGLE,
        Part::Skip => &contact::SKIP,
        Part::Sleep => &sleep::SLEEP,
        Part::Limits => &follow::LIMITS,
        Part::Drive => &follow::DRIVE,
        Part::Blend => &character::BLEND,
        Part::Inertia => &character::INERTIA,
        Part::Body => &character::BODY,
        Part::Lod => &lod::LOD,
        Part::Priority => &character::PRIORITY,
        Part::OwnWind => &air::OWN_WIND,
        Part::Pins => &[],
        Part::Wind => &air::WIND,
        Part::Gravity => &air::GRAVITY,
        Part::Budget => &character::BUDGET,
    }
}

/// Every setting, in the order of the panel.
pub fn settings() -> impl Iterator<Item = &'static Setting> {
    Part::ALL.into_iter().flat_map(settings_of)
}

#[cfg(test)]
mod tests {
    use std::borrow::Cow;

    use bevy::prelude::*;

    use super::*;
    use crate::components::checked::Checked;
    use crate::components::{
        ClothColorChannel, ClothDrive, ClothGravity, ClothLimits, ClothLod, ClothMap, ClothSkipPolicy, ClothWind,
    };
    use crate::inspector::setting::{Kind, Scale};
    use crate::inspector::settings::ClothSettings;

    /// What the components do not use as given.
    fn clamped(settings: &ClothSettings) -> Vec<Cow<'static, str>> {
        let mut checked = Checked::default();
        settings.material.fabric(&mut checked);
        settings.solver.stepping(&mut checked);
        settings.solver.limits(&mut checked);
        settings.solver.time_scale(&mut checked);
        settings.solver.gravity(Vec3::ZERO, &mut checked);
        settings.solver.teleport_limits(&mut checked);
        settings.untangle.settings(&mut checked);
        settings.skip.settings(&mut checked);
        settings.sleep.checked(&mut checked);
        if let Some(limits) = &settings.limits {
            limits.checked(&mut checked);
        }
        if let Some(drive) = &settings.drive {
            drive.checked(&mut checked);
        }
        if let Some(lod) = &settings.lod {
            lod.checked(&mut checked);
        }
        if let Some(inertia) = &settings.inertia {
            inertia.checked(&mut checked);
        }
        if let Some(body) = &settings.body {
            body.checked(&mut checked);
        }
        if let Some(budget) = &settings.budget {
            budget.checked(&mut checked);
        }
        settings.blend.checked(&mut checked);
        settings.priority.checked(&mut checked);
        settings.wind.checked(&mut checked);
        if let Some(ClothWind(wind)) = &settings.own_wind {
            wind.checked(&mut checked);
        }
        settings.gravity.checked(&mut checked);
        checked.clamped
    }

    /// Every row exists, and vectors are 0: the limits of one are those of its length.
    fn all() -> ClothSettings {
        let (own_wind, lod) = (Some(ClothWind::default()), Some(ClothLod::default()));
        let mut all = ClothSettings { own_wind, lod, gravity: ClothGravity(Vec3::ZERO), ..default() };
        all.skip.policy = ClothSkipPolicy::UntilClean { max: 30 };
        let painted = ClothMap::color(ClothColorChannel::G, 0.0, 0.5);
        let (max_distance, backstop_distance) = (painted.clone(), painted.clone());
        all.limits = Some(ClothLimits { max_distance, backstop_distance, ..default() });
        all.drive = Some(ClothDrive { frequency: painted, ..default() });
        (all.inertia, all.body, all.budget) = (Some(default()), Some(default()), Some(default()));
        all
    }

    #[test]
    fn a_level_of_detail_begins_with_its_defaults() {
        let mut with = ClothSettings { lod: Some(ClothLod::default()), ..default() };
        for setting in &lod::LOD[1..] {
            assert_eq!(setting.default_value(), setting.get(&mut with), "{}", setting.label());
        }
    }

    #[test]
    fn limits_and_drive_begin_with_their_defaults_and_maps_with_what_their_rows_start_with() {
        let mut with = ClothSettings { limits: Some(ClothLimits::default()), drive: Some(ClothDrive::default()), ..default() };
        let rows = || follow::LIMITS[1..].iter().chain(&follow::DRIVE[1..]);
        for setting in rows().filter(|setting| !setting.name.contains('.')) {
            assert_eq!(setting.default_value(), setting.get(&mut with), "{}", setting.label());
        }
        for setting in rows().filter(|setting| setting.name.contains('.')) {
            assert_eq!(setting.get(&mut with), None, "{} of a map that is off", setting.label());
        }
        // Uniform, then painted: the number that it was stays where the paint is 1.
        for chosen in [1.0, 2.0] {
            rows().filter(|s| matches!(s.kind, Kind::Choice { .. })).for_each(|s| s.set(&mut with, chosen));
            for setting in rows().filter(|s| s.name.ends_with(".high") || chosen == 2.0 && s.name.ends_with(".low")) {
                assert_eq!(setting.default_value(), setting.get(&mut with), "{} of {chosen}", setting.label());
            }
        }
    }

    #[test]
    fn what_characters_have_begins_with_its_defaults() {
        let mut with = ClothSettings { inertia: Some(default()), body: Some(default()), budget: Some(default()), ..default() };
        for setting in
            character::INERTIA[1..].iter().chain(&character::BODY).chain(&character::BUDGET[1..]).chain(&character::BLEND)
        {
            assert_eq!(setting.default_value(), setting.get(&mut with), "{}", setting.label());
        }
    }

    /// The numbers beside the limits that the field can hold.
    fn beyond(setting: &Setting, scale: &Scale) -> Vec<f64> {
        let (low, high) = scale.limits;
        match setting.kind {
            Kind::Number(..) => vec![f64::from((low as f32).next_down()), f64::from((high as f32).next_up())],
            Kind::Count(..) => {
                [low - 1.0, high + 1.0].into_iter().filter(|v| (0.0..=f64::from(u32::MAX)).contains(v)).collect()
            }
            Kind::Layer(..) => {
                let held = f64::from(i32::MIN)..=f64::from(i32::MAX);
                [low - 1.0, high + 1.0].into_iter().filter(|v| held.contains(v)).collect()
            }
            Kind::Switch { .. } | Kind::Choice { .. } => Vec::new(),
        }
    }

    #[test]
    fn the_limits_are_those_of_the_components_and_one_step_beyond_is_clamped_and_named() {
        assert_eq!(clamped(&all()), [""; 0]);
        let mut walked = 0;
        for (setting, scale) in settings().filter_map(|s| Some((s, s.scale()?))) {
            let label = setting.label();
            let off = scale.endless.then_some(f64::INFINITY);
            for limit in [scale.limits.0, scale.limits.1].into_iter().chain(off) {
                let mut settings = all();
                setting.set(&mut settings, limit);
                assert_eq!(clamped(&settings), [""; 0], "{label} at {limit}");
                assert!(setting.in_range(&mut settings), "{label} at {limit}");
            }
            let field = if setting.part == Part::Gravity { "gravity" } else { setting.name.split('.').next().unwrap_or("") };
            for value in beyond(setting, &scale) {
                let mut settings = all();
                setting.set(&mut settings, value);
                let names = clamped(&settings);
                assert!(names.len() == 1 && names[0].rsplit('.').next() == Some(field), "{label} at {value}: {names:?}");
                assert!(!setting.in_range(&mut settings), "{label} at {value} is shown as if it were used");
                walked += 1;
            }
        }
        assert!(walked > 80, "{walked} steps beyond a limit");
    }
}
