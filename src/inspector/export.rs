//! Settings as text: Rust to paste into a program, RON to put into a file, and back.

use bevy::prelude::*;
use bevy::reflect::enums::VariantType;
use bevy::reflect::{PartialReflect, ReflectRef};
use ron::extensions::Extensions;

use super::setting::Setting;
use super::settings::{ClothSettings, Edit};
use super::table::settings;
use crate::components::{
    ClothBody, ClothDrive, ClothGlobalWind, ClothGravity, ClothInertia, ClothLimits, ClothLod, ClothMaterial, ClothOnTargetLost,
};
use crate::presets::ClothPreset;

/// The components of a cloth that differ from their defaults, as an expression each: what goes into `commands.spawn((..))`.
///
/// The material is written over the preset that it differs least from. Settings that lie elsewhere follow as comments, where
/// they differ: weights of pins, the body of the character, the world's wind, gravity and budget. The program makes the sets of
/// pins, and the last three are resources.
#[must_use]
pub fn as_rust(settings: &ClothSettings) -> String {
    let mut lines = vec![material_as_rust(&settings.material)];
    fn add<T: PartialReflect + Default + PartialEq>(lines: &mut Vec<String>, value: &T) {
        if *value != T::default() {
            lines.push(over(value, &T::default(), "default()"));
        }
    }
    add(&mut lines, &settings.solver);
    add(&mut lines, &settings.collision);
    add(&mut lines, &settings.untangle);
    if settings.untangling_disabled {
        lines.push("ClothUntanglingDisabled".into());
    }
    add(&mut lines, &settings.skip);
    add(&mut lines, &settings.sleep);
    if settings.sleep_disabled {
        lines.push("ClothSleepDisabled".into());
    }
    if let Some(limits) = &settings.limits {
        lines.push(over(limits, &ClothLimits::default(), "default()"));
    }
    if let Some(drive) = &settings.drive {
        lines.push(over(drive, &ClothDrive::default(), "default()"));
    }
    if let Some(inertia) = settings.inertia {
        lines.push(over(&ClothInertia { space: None, ..inertia }, &ClothInertia::default(), "default()"));
    }
    add(&mut lines, &settings.blend);
    add(&mut lines, &settings.priority);
    if let Some(lod) = &settings.lod {
        lines.push(over(lod, &ClothLod::default(), "default()"));
    }
    if let Some(wind) = &settings.own_wind {
        lines.push(format!("ClothWind({})", over(&wind.0, &ClothGlobalWind::default(), "default()")));
    }
    lines.join(",\n") + ",\n" + &elsewhere(settings)
}

/// What differs and is no component to be spawned, as comments.
fn elsewhere(settings: &ClothSettings) -> String {
    let mut lines = Vec::new();
    for (i, set) in settings.pins.sets.iter().enumerate().filter(|(_, set)| set.weight != 1.0) {
        lines.push(format!("pins.sets[{i}].weight = {};", number_as_rust(set.weight)));
    }
    if settings.pins.on_target_lost != ClothOnTargetLost::default() {
        lines.push(format!("pins.on_target_lost = {};", literal(&settings.pins.on_target_lost)));
    }
    if settings.inertia.is_some_and(|inertia| inertia.space.is_some()) {
        lines.push("inertia.space = Some(space);".into());
    }
    if let Some(body) = settings.body.filter(|body| *body != ClothBody::default()) {
        let body = over(&body, &ClothBody::default(), "default()");
        lines.extend(format!("commands.entity(body).insert({body});").lines().map(String::from));
    }
    if let Some(budget) = &settings.budget {
        lines.push(format!("commands.insert_resource(ClothBudget {{ ms: {} }});", number_as_rust(budget.ms)));
    }
    if settings.wind != ClothGlobalWind::default() {
        let wind = over(&settings.wind, &ClothGlobalWind::default(), "default()");
        lines.extend(format!("commands.insert_resource({wind});").lines().map(String::from));
    }
    if settings.gravity != ClothGravity::default() {
        lines.push(format!("commands.insert_resource(ClothGravity({}));", literal(&settings.gravity.0)));
    }
    lines.iter().map(|line| format!("// {line}\n")).collect()
}

/// A material as a Rust expression.
#[must_use]
pub fn material_as_rust(material: &ClothMaterial) -> String {
    let presets =
        ClothMaterial::PRESETS.iter().map(|(name, preset)| (format!("ClothMaterial::{}", name.to_uppercase()), preset));
    let base = ClothMaterial::default();
    let all = core::iter::once(("default()".to_string(), &base)).chain(presets);
    let (name, nearest) = all.min_by_key(|(_, preset)| different(material, *preset)).unwrap_or(("default()".into(), &base));
    if different(material, nearest) == 0 && name != "default()" { name } else { over(material, nearest, &name) }
}

/// Number of fields that differ.
fn different(a: &dyn PartialReflect, b: &dyn PartialReflect) -> usize {
    let (ReflectRef::Struct(a), ReflectRef::Struct(b)) = (a.reflect_ref(), b.reflect_ref()) else { return 0 };
    (0..a.field_len()).filter(|&i| a.field_at(i).zip(b.field_at(i)).is_some_and(|(a, b)| !same(a, b))).count()
}

fn same(a: &dyn PartialReflect, b: &dyn PartialReflect) -> bool {
    a.reflect_partial_eq(b).unwrap_or(false)
}

/// A struct as a literal over a base.
fn over(value: &dyn PartialReflect, base: &dyn PartialReflect, base_name: &str) -> String {
    let name = value.reflect_short_type_path();
    let (ReflectRef::Struct(fields), ReflectRef::Struct(base)) = (value.reflect_ref(), base.reflect_ref()) else {
        return literal(value);
    };
    let mut out = format!("{name} {{\n");
    let mut kept = 0;
    for i in 0..fields.field_len() {
        let (Some(field), Some(default)) = (fields.field_at(i), base.field_at(i)) else { continue };
        if same(field, default) {
            kept += 1;
        } else {
            out += &format!("    {}: {},\n", fields.name_at(i).unwrap_or_default(), literal(field));
        }
    }
    if kept == fields.field_len() {
        return format!("{name}::default()");
    }
    if kept > 0 {
        out += &format!("    ..{base_name}\n");
    }
    out + "}"
}

/// A value as a literal of Rust.
fn literal(value: &dyn PartialReflect) -> String {
    if let Some(number) = value.try_downcast_ref::<f32>() {
        return number_as_rust(*number);
    }
    if let Some(vector) = value.try_downcast_ref::<Vec3>() {
        return format!("Vec3::new({})", vector.to_array().map(number_as_rust).join(", "));
    }
    if let Some(text) = value.try_downcast_ref::<String>() {
        return format!("{text:?}.into()");
    }
    match value.reflect_ref() {
        ReflectRef::Enum(variant) => {
            let path = format!("{}::{}", value.reflect_short_type_path(), variant.variant_name());
            let fields = (0..variant.field_len()).filter_map(|i| {
                let field = literal(variant.field_at(i)?);
                Some(variant.name_at(i).map_or_else(|| field.clone(), |name| format!("{name}: {field}")))
            });
            let fields = fields.collect::<Vec<_>>().join(", ");
            match variant.variant_type() {
                VariantType::Struct => format!("{path} {{ {fields} }}"),
                VariantType::Tuple => format!("{path}({fields})"),
                VariantType::Unit => path,
            }
        }
        _ => format!("{value:?}"),
    }
}

fn number_as_rust(number: f32) -> String {
    if number == f32::INFINITY {
        "f32::INFINITY".into()
    } else if number == f32::NEG_INFINITY {
        "f32::NEG_INFINITY".into()
    } else if number.is_nan() {
        "f32::NAN".into()
    } else {
        format!("{number:?}")
    }
}

/// A preset as the text of a `.cloth.ron` file.
#[must_use]
pub fn as_ron(preset: &ClothPreset) -> String {
    // Numbers and names only: there is nothing in it that could fail.
    let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
    options.to_string_pretty(preset, ron::ser::PrettyConfig::default()).unwrap_or_default() + "\n"
}

/// A preset from the text of a `.cloth.ron` file, and those of its settings that are out of range and used clamped. `file` is
/// its name in errors.
///
/// # Errors
/// Where the text is wrong: see [`ClothPreset::from_ron`].
pub fn from_ron(text: &str, file: &str) -> Result<(ClothPreset, Vec<String>), String> {
    let preset = ClothPreset::from_ron(text, file).map_err(|error| error.to_string())?;
    let mut edit = Edit::new(ClothSettings::default());
    edit.take(preset.clone());
    let clamped = settings().filter(|setting| !setting.in_range(&mut edit.settings)).map(Setting::label).collect();
    Ok((preset, clamped))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::{
        ClothCollision, ClothColorChannel, ClothMap, ClothPins, ClothSkipFrame, ClothSkipPolicy, ClothSolver,
        ClothTeleportMode, ClothUntangling,
    };

    #[test]
    fn a_preset_is_written_by_its_name_and_a_change_over_it() {
        assert_eq!(material_as_rust(&ClothMaterial::SILK), "ClothMaterial::SILK");
        assert_eq!(material_as_rust(&ClothMaterial::default()), "ClothMaterial::default()");
        let heavier = ClothMaterial { density: 0.1, strain_limit: f32::INFINITY, ..ClothMaterial::SILK };
        let text = "ClothMaterial {\n    density: 0.1,\n    strain_limit: f32::INFINITY,\n    ..ClothMaterial::SILK\n}";
        assert_eq!(material_as_rust(&heavier), text);
    }

    #[test]
    fn components_that_differ_follow_as_expressions() {
        let settings = ClothSettings {
            solver: ClothSolver { substep_rate: 720.0, teleport: ClothTeleportMode::Reset, ..default() },
            skip: ClothSkipFrame { policy: ClothSkipPolicy::UntilClean { max: 3 }, ..default() },
            ..default()
        };
        let expected = "ClothMaterial::default(),\nClothSolver {\n    substep_rate: 720.0,\n    teleport: ClothTeleportMode::Reset,\n    \
                        ..default()\n},\nClothSkipFrame {\n    policy: ClothSkipPolicy::UntilClean { max: 3 },\n    ..default()\n},\n";
        assert_eq!(as_rust(&settings), expected);
    }

    #[test]
    fn a_level_of_detail_follows_where_there_is_one() {
        let mut settings = ClothSettings { lod: Some(ClothLod::default()), ..default() };
        assert_eq!(as_rust(&settings), "ClothMaterial::default(),\nClothLod::default(),\n");
        settings.lod = Some(ClothLod { full_within: 5.0, ..default() });
        assert_eq!(as_rust(&settings), "ClothMaterial::default(),\nClothLod {\n    full_within: 5.0,\n    ..default()\n},\n");
    }

    #[test]
    fn limits_and_drive_follow_where_they_are_with_their_maps() {
        let mut settings =
            ClothSettings { limits: Some(ClothLimits::default()), drive: Some(ClothDrive::default()), ..default() };
        assert_eq!(as_rust(&settings), "ClothMaterial::default(),\nClothLimits::default(),\nClothDrive::default(),\n");
        let max_distance = ClothMap::attribute("_CLOTH_MAXDIST", 0.0, 0.25);
        settings.limits = Some(ClothLimits { max_distance, backstop_distance: ClothMap::Uniform(0.01), ..default() });
        settings.drive = Some(ClothDrive { frequency: ClothMap::color(ClothColorChannel::A, 0.0, 4.0), damping_ratio: 0.5 });
        let expected = "ClothMaterial::default(),\nClothLimits {\n    \
                        max_distance: ClothMap::Painted { paint: ClothPaint::Attribute(\"_CLOTH_MAXDIST\".into()), low: 0.0, high: 0.25 },\n    \
                        backstop_distance: ClothMap::Uniform(0.01),\n    ..default()\n},\nClothDrive {\n    \
                        frequency: ClothMap::Painted { paint: ClothPaint::Color(ClothColorChannel::A), low: 0.0, high: 4.0 },\n    \
                        damping_ratio: 0.5,\n},\n";
        assert_eq!(as_rust(&settings), expected);
    }

    #[test]
    fn what_is_disabled_follows_as_its_marker() {
        let settings = ClothSettings { untangling_disabled: true, sleep_disabled: true, ..default() };
        assert_eq!(as_rust(&settings), "ClothMaterial::default(),\nClothUntanglingDisabled,\nClothSleepDisabled,\n");
    }

    #[test]
    fn pins_and_the_world_follow_as_comments_where_they_differ() {
        let mut settings = ClothSettings {
            pins: ClothPins::vertices([0])
                .and(ClothPins::vertices([1]).weighted(0.25))
                .on_target_lost(ClothOnTargetLost::Release),
            wind: ClothGlobalWind::new(Vec3::X),
            gravity: ClothGravity(Vec3::ZERO),
            ..default()
        };
        let expected = "ClothMaterial::default(),\n// pins.sets[1].weight = 0.25;\n// pins.on_target_lost = ClothOnTargetLost::Release;\n\
                        // commands.insert_resource(ClothGlobalWind {\n//     velocity: Vec3::new(1.0, 0.0, 0.0),\n//     ..default()\n// });\n\
                        // commands.insert_resource(ClothGravity(Vec3::new(0.0, 0.0, 0.0)));\n";
        assert_eq!(as_rust(&settings), expected);
        (settings.pins, settings.wind, settings.gravity) = default();
        assert_eq!(as_rust(&settings), "ClothMaterial::default(),\n");
    }

    #[test]
    fn every_preset_comes_back_from_its_file() {
        for (name, material) in ClothMaterial::PRESETS {
            let (preset, text) = (ClothPreset::from(material.clone()), as_ron(&material.into()));
            assert_eq!(from_ron(&text, name), Ok((preset, Vec::new())), "{name}: {text}");
            assert!(!text.contains("None") && !text.contains("Some"), "{name}: {text}");
        }
    }

    #[test]
    fn every_part_of_a_file_comes_back_with_what_is_clamped_in_it() {
        let preset = ClothPreset {
            material: ClothMaterial { density: 0.005, strain_limit: f32::INFINITY, ..default() },
            solver: Some(ClothSolver { substep_rate: 1.0e6, ..default() }),
            collision: Some(ClothCollision { garment_layer: -7, ..default() }),
            untangle: Some(ClothUntangling { iterations: 65, ..default() }),
            skip_frame: Some(ClothSkipFrame { policy: ClothSkipPolicy::UntilClean { max: 3 }, ..default() }),
            limits: Some(ClothLimits { max_distance: ClothMap::attribute("_CLOTH_MAXDIST", 0.0, 200.0), ..default() }),
            drive: Some(ClothDrive { frequency: ClothMap::Uniform(4.0), damping_ratio: 11.0 }),
            wind: Some(ClothGlobalWind { turbulence: 9.0, ..ClothGlobalWind::new(Vec3::X) }),
        };
        let clamped = [
            "material density",
            "solver substep_rate",
            "untangle iterations",
            "limits max_distance.high",
            "drive damping_ratio",
            "own wind turbulence",
        ];
        assert_eq!(from_ron(&as_ron(&preset), ""), Ok((preset, clamped.map(String::from).to_vec())));
    }

    #[test]
    fn a_file_that_is_wrong_says_where() {
        for (text, reason) in [
            ("(density: 0.2, colour: 3)", "a.cloth.ron:1:16: `colour` is not known"),
            ("(material: (stretch_stiffness: \"stiff\"))", "a.cloth.ron:1:"),
            ("hello", "a.cloth.ron:1:1"),
        ] {
            let error = from_ron(text, "a.cloth.ron").expect_err(text);
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
