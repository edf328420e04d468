//! Settings as text: Rust to paste into a program, RON to put into a file, and back.

use bevy::prelude::*;
use bevy::reflect::enums::VariantType;
use bevy::reflect::{PartialReflect, ReflectRef};

use super::entry::parse;
use super::setting::Part;
use super::settings::ClothSettings;
use super::table::settings_of;
use crate::components::ClothMaterial;

/// The components of a cloth that differ from their defaults, as an expression each: what goes into `commands.spawn((..))`.
///
/// The material is written over the preset that it differs least from. Pins, wind and gravity of the world are not part of it.
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
    add(&mut lines, &settings.skip);
    if let Some(wind) = &settings.own_wind {
        lines.push(format!("ClothWind({})", over(&wind.0, &crate::GlobalWind::default(), "default()")));
    }
    lines.join(",\n") + ",\n"
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
    match value.reflect_ref() {
        ReflectRef::Enum(variant) => {
            let path = format!("{}::{}", value.reflect_short_type_path(), variant.variant_name());
            let fields = (0..variant.field_len())
                .filter_map(|i| Some(format!("{}: {}", variant.name_at(i)?, literal(variant.field_at(i)?))));
            match variant.variant_type() {
                VariantType::Struct => format!("{path} {{ {} }}", fields.collect::<Vec<_>>().join(", ")),
                VariantType::Tuple | VariantType::Unit => path,
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

/// A material as the text of a `.cloth.ron` file.
#[must_use]
pub fn as_ron(material: &ClothMaterial) -> String {
    // Numbers and names only: there is nothing in it that could fail.
    ron::ser::to_string_pretty(material, ron::ser::PrettyConfig::default()).unwrap_or_default() + "\n"
}

/// A material from the text of a `.cloth.ron` file.
///
/// # Errors
/// Where the text is wrong, or which field is out of range.
pub fn from_ron(text: &str) -> Result<ClothMaterial, String> {
    let material: ClothMaterial = ron::from_str(text).map_err(|error| format!("not a material: {error}"))?;
    let mut settings = ClothSettings { material, ..ClothSettings::default() };
    for setting in settings_of(Part::Material) {
        let (Some(value), Some(scale)) = (setting.get(&mut settings), setting.scale()) else { continue };
        parse(&(value as f32).to_string(), setting.unit, &scale).map_err(|reason| format!("{}: {reason}", setting.name))?;
    }
    Ok(settings.material)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::{ClothSolver, SkipFrame, SkipPolicy, TeleportMode};

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
            solver: ClothSolver { substep_rate: 720.0, teleport: TeleportMode::Reset, ..default() },
            skip: SkipFrame { policy: SkipPolicy::UntilClean { max: 3 }, ..default() },
            ..default()
        };
        let expected = "ClothMaterial::default(),\nClothSolver {\n    substep_rate: 720.0,\n    teleport: TeleportMode::Reset,\n    \
                        ..default()\n},\nSkipFrame {\n    policy: SkipPolicy::UntilClean { max: 3 },\n    ..default()\n},\n";
        assert_eq!(as_rust(&settings), expected);
    }

    #[test]
    fn every_preset_comes_back_from_its_file() {
        for (name, preset) in ClothMaterial::PRESETS {
            assert_eq!(from_ron(&as_ron(&preset)), Ok(preset), "{name}");
        }
    }

    #[test]
    fn a_file_that_is_wrong_says_where() {
        for (text, reason) in [
            ("(density: 0.2, colour: 3)", "colour"),
            ("(density: -1)", "density: it must not be negative"),
            ("(density: NaN)", "density: `NaN` is not a number"),
            ("(stretch_stiffness: \"stiff\")", "1:"),
            ("hello", "not a material"),
        ] {
            let error = from_ron(text).expect_err(text);
            assert!(error.contains(reason), "{text}: {error}");
        }
    }
}
