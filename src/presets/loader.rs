//! From the bytes of a `.cloth.ron` file to a preset, or to where it is wrong and how.

use std::str::Utf8Error;

use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext};
use bevy::prelude::*;
use bevy::reflect::Typed;
use ron::error::SpannedError;
use ron::extensions::Extensions;

use super::ClothPreset;
use super::place::{Place, nearest};
use crate::components::ClothMaterial;
use crate::notices::shortened;

/// Loads [`ClothPreset`] from `.cloth.ron` files.
#[derive(Debug, Default, TypePath)]
pub struct ClothPresetLoader;

/// Why a preset could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum ClothPresetError {
    /// The file could not be read.
    #[error("{file}: {error}")]
    Io {
        /// The file.
        file: String,
        /// What the file system says.
        error: std::io::Error,
    },
    /// The file is not text.
    #[error("{file}: {error}")]
    NotText {
        /// The file.
        file: String,
        /// Where it stops being text.
        error: Utf8Error,
    },
    /// The file is not a preset.
    #[error("{file}:{line}:{column}: {what}")]
    Schema {
        /// The file.
        file: String,
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// The field, such as `solver.substep_rate`; empty if it is none.
        field: String,
        /// What is wrong with it, and what helps.
        what: String,
    },
}

impl AssetLoader for ClothPresetLoader {
    type Asset = ClothPreset;
    type Settings = ();
    type Error = ClothPresetError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        (): &(),
        context: &mut LoadContext<'_>,
    ) -> Result<ClothPreset, ClothPresetError> {
        let file = || context.path().to_string();
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await.map_err(|error| ClothPresetError::Io { file: file(), error })?;
        let text = std::str::from_utf8(&bytes).map_err(|error| ClothPresetError::NotText { file: file(), error })?;
        ClothPreset::from_ron(text, &file())
    }

    fn extensions(&self) -> &[&str] {
        &["cloth.ron"]
    }
}

impl ClothPreset {
    /// Reads the text of a `.cloth.ron` file; `file` is its name in errors.
    ///
    /// # Errors
    /// [`ClothPresetError::Schema`] when it is not a preset: the first place that is wrong, what is wrong there, and the
    /// nearest name that is known.
    pub fn from_ron(text: &str, file: &str) -> Result<Self, ClothPresetError> {
        // A byte order mark is what some editors begin a file with.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let options = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME);
        let whole = match options.from_str::<Self>(text) {
            Ok(preset) => return Ok(preset),
            Err(error) => error,
        };
        // The fields of a material alone are a preset too.
        let alone = matches!(&whole.code, ron::Error::NoSuchStructField { found, .. } if of_material().contains(&found.as_str()))
            && !Place::of(text, &whole).field.contains('.');
        if !alone {
            return Err(schema(text, file, &whole));
        }
        options.from_str::<ClothMaterial>(text).map(Self::from).map_err(|error| schema(text, file, &error))
    }
}

/// Says where and how a text is not a preset.
fn schema(text: &str, file: &str, error: &SpannedError) -> ClothPresetError {
    let Place { line, column, field } = Place::of(text, error);
    let field = shortened(&field).into_owned();
    let unknown = |found: &str, expected: &'static [&'static str]| {
        // At the top there may be fields of a preset or of a material.
        let top: &[&str] = if field == found { of_material() } else { &[] };
        let known = || expected.iter().chain(top).copied();
        let help = match nearest(found, known()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("known are {}", expected.join(", ")),
        };
        let found = &*shortened(found);
        if field.is_empty() || field.ends_with(found) {
            format!("`{}` is not known: {help}", if field.is_empty() { found } else { &field })
        } else {
            format!("`{field}`: `{found}` is not known: {help}")
        }
    };
    let what = match &error.code {
        // Read as a material alone: what it stands beside is known, but not there.
        ron::Error::NoSuchStructField { found, .. } if field == *found && of_preset().contains(&found.as_str()) => {
            format!("`{found}` cannot stand beside the fields of a material: put those into `material: (…)`")
        }
        ron::Error::NoSuchStructField { expected, found, .. } | ron::Error::NoSuchEnumVariant { expected, found, .. } => {
            unknown(found, expected)
        }
        code if field.is_empty() => shortened(&code.to_string()).into_owned(),
        code => format!("`{field}`: {}", shortened(&code.to_string())),
    };
    ClothPresetError::Schema { file: file.into(), line, column, field, what }
}

/// Names of the fields of a preset.
fn of_preset() -> &'static [&'static str] {
    ClothPreset::type_info().as_struct().map_or(&[], |info| info.field_names())
}

/// Names of the fields of a material.
fn of_material() -> &'static [&'static str] {
    ClothMaterial::type_info().as_struct().map_or(&[], |info| info.field_names())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::components::{ClothColorChannel, ClothDrive, ClothLimits, ClothMap};

    fn wrong(text: &str) -> String {
        match ClothPreset::from_ron(text, "a.cloth.ron") {
            Ok(preset) => format!("read as {preset:?}"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn every_field_of_a_material_is_known_by_name() {
        let mut material = ClothMaterial::default();
        assert!(of_material().len() >= 13 && of_material().iter().all(|name| material.field_mut(name).is_some()));
    }

    #[test]
    fn a_preset_or_a_material_alone_is_read_and_the_rest_has_defaults() {
        let heavy = ClothMaterial { density: 0.9, ..ClothMaterial::default() };
        for text in [
            "(density: 0.9)",
            "(material: (density: 0.9))",
            "\u{feff}( density : 0.9 , )",
            "/* old */ (material: (density: 0.9,), // thick\n)",
        ] {
            assert_eq!(ClothPreset::from_ron(text, "").ok(), Some(heavy.clone().into()), "{text}");
        }
        assert_eq!(ClothPreset::from_ron("()", "").ok(), Some(ClothPreset::default()));
        let text = "(material: (strain_limit: inf), solver: (substep_rate: 600), wind: Some((velocity: (1.0, 0.0, 2.0))), skip_frame: (policy: UntilClean(max: 9)))";
        let preset = ClothPreset::from_ron(text, "").expect("a preset");
        assert_eq!(preset.material.strain_limit, f32::INFINITY);
        assert_eq!(preset.solver.map(|s| s.substep_rate), Some(600.0));
        assert_eq!(preset.wind.map(|w| w.velocity), Some(Vec3::new(1.0, 0.0, 2.0)));
        assert_eq!((preset.collision, preset.limits, preset.drive), (None, None, None));
    }

    #[test]
    fn maps_are_read_by_the_names_of_their_variants() {
        let text = "(limits: (max_distance: Painted(paint: Attribute(\"_CLOTH_PAINT.g\"), low: 0.01, high: 0.3), backstop_distance: Uniform(0.02)),
                     drive: (frequency: Painted(paint: Color(A), low: 0, high: 4), damping_ratio: 0.5))";
        let preset = ClothPreset::from_ron(text, "").expect("a preset");
        let max_distance = ClothMap::attribute("_CLOTH_PAINT.g", 0.01, 0.3);
        let limits = ClothLimits { max_distance, backstop_distance: ClothMap::Uniform(0.02), ..ClothLimits::default() };
        assert_eq!(preset.limits, Some(limits));
        let frequency = ClothMap::color(ClothColorChannel::A, 0.0, 4.0);
        assert_eq!(preset.drive, Some(ClothDrive { frequency, damping_ratio: 0.5 }));
        let misspelt = wrong("(limits: (max_distanse: Off))");
        assert!(misspelt.ends_with("`limits.max_distanse` is not known: did you mean `max_distance`?"), "{misspelt}");
    }

    #[test]
    fn an_unknown_field_is_refused_with_its_place_and_the_nearest_known_name() {
        let nested = "(\n    material: (\n        density: 0.3,\n        bend_stifness: 1e-4,\n    ),\n)";
        assert_eq!(wrong(nested), "a.cloth.ron:4:9: `material.bend_stifness` is not known: did you mean `bend_stiffness`?");
        assert_eq!(wrong("(densty: 0.3)"), "a.cloth.ron:1:2: `densty` is not known: did you mean `density`?");
        assert_eq!(wrong("(density: 0.3,\n drg: 1)"), "a.cloth.ron:2:2: `drg` is not known: did you mean `drag`?");
        assert_eq!(wrong("(solvr: ())"), "a.cloth.ron:1:2: `solvr` is not known: did you mean `solver`?");
        let far = wrong("(solver: (colour: 1))");
        assert!(far.starts_with("a.cloth.ron:1:11: `solver.colour` is not known: known are substep_rate"), "{far}");
    }

    #[test]
    fn fields_of_a_material_beside_settings_are_sent_into_the_material() {
        let help = "cannot stand beside the fields of a material: put those into `material: (…)`";
        for (text, place) in [
            ("(density: 0.9, solver: (substep_rate: 600))", "1:16: `solver`"),
            ("(solver: (substep_rate: 600), density: 0.9)", "1:2: `solver`"),
            ("(material: (drag: 1),\n density: 0.9)", "1:2: `material`"),
        ] {
            assert_eq!(wrong(text), format!("a.cloth.ron:{place} {help}"), "{text}");
        }
    }

    #[test]
    fn the_error_in_the_guide_is_that_of_its_file() {
        let guide = include_str!("../../docs/fabrics.md");
        let file = guide.split("```ron\n").nth(1).and_then(|rest| rest.split("```").next()).expect("a file");
        let misspelt = file.replace("stretch", "strech");
        let error = wrong(&misspelt).replace("a.cloth.ron", "fabric.cloth.ron");
        assert!(guide.contains(&format!("``{error}``")), "{error}");
    }

    #[test]
    fn a_value_of_the_wrong_kind_names_its_field() {
        let value = wrong("(\n  // `solver: 3` is what it was\n  solver: (substep_rate: \"fast\"))");
        assert!(value.starts_with("a.cloth.ron:3:25: `solver.substep_rate`: "), "{value}");
        let variant = wrong("(untangle: (method: ByEndTyp))");
        assert!(variant.contains("`untangle.method`: `ByEndTyp` is not known: did you mean `ByEndType`?"), "{variant}");
        let twice = wrong("(material: (density: 1.0, density: 2.0))");
        assert!(twice.contains("material.density") && twice.contains("duplicate"), "{twice}");
    }

    #[test]
    fn whatever_the_text_there_is_an_answer() {
        let whole = "(material: (density: 0.9), wind: (velocity: (1.0, 0.0, 0.0)))";
        for end in 0..whole.len() {
            assert!(ClothPreset::from_ron(&whole[..end], "").is_err(), "{}", &whole[..end]);
        }
        for text in
            ["", "ü: (", "\"", "/*", "((((((((", "))", "(material: [1, 2])", "\u{0}", "(density: 1e999999)", "(a: r#\"x\"#)"]
        {
            // Not a panic, whether it is a preset or not.
            let _ = ClothPreset::from_ron(text, "");
        }
        let deep = "(".repeat(100_000);
        assert!(ClothPreset::from_ron(&deep, "").is_err());
    }
}
