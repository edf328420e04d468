//! How far a cloth may be from the animated skin, and how firmly it is drawn to it.

use bevy::prelude::*;

use super::ClothMap;
use super::checked::Checked;

/// Limits: how far a cloth may be from its animated skin. They are skinned constraints, as Jolt and `NvCloth` have them.
///
/// The skin of a cloth without weights is its mesh, carried by its entity. So a cape whose node is a child of a bone needs no
/// weights. Lengths are in metres at the scale at which the cloth was bound; a character that is scaled later scales them.
///
/// ```
/// # use bevy::prelude::*;
/// # use bevy_drape::prelude::*;
/// # fn skirt() -> impl Bundle {
/// // Painted in Blender: 0 at the waist, which follows the skin, 1 at the hem, which goes up to 0.3 m from it.
/// ClothLimits { max_distance: ClothMap::attribute("_CLOTH_MAXDIST", 0.0, 0.3), ..default() }
/// # }
/// ```
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothLimits {
    /// Farthest distance of each vertex from its place on the skin `[m]`. Default [`ClothMap::Off`], range 0 to 100. Below 1 mm
    /// it is a pin.
    pub max_distance: ClothMap,
    /// How far behind its place on the skin, against the normal, each vertex may sink `[m]`: there lies the surface of a ball.
    /// Default [`ClothMap::Off`], range -1 to 1; 0 lies on the skin, less before it. Off where it is no less than the maximum
    /// distance.
    pub backstop_distance: ClothMap,
    /// Radius of that ball `[m]`. Default 1, range 0.01 to 1000. 0.1 suits limbs; 1 and more is nearly a plane.
    pub backstop_radius: f32,
    /// Factor of the maximum distance (dimensionless). Default 1, range 0 to 10. At 0 the cloth is its skin; below 1 vertices
    /// without a maximum distance have the radius of the cloth for one.
    pub scale: f32,
    /// Whether places on the skin are taken out of bodies before they limit, and before they drive. Default true. Skins pass
    /// through legs; without it, cloth is held inside the legs.
    pub avoid_bodies: bool,
}

impl Default for ClothLimits {
    fn default() -> Self {
        Self {
            max_distance: ClothMap::Off,
            backstop_distance: ClothMap::Off,
            backstop_radius: 1.0,
            scale: 1.0,
            avoid_bodies: true,
        }
    }
}

impl ClothLimits {
    /// Longest maximum distance `[m]`.
    pub(crate) const LONGEST: f32 = 100.0;

    /// Radius of the backstop `[m]` and scale.
    pub(crate) fn checked(&self, checked: &mut Checked) -> (f32, f32) {
        check(&self.max_distance, "limits.max_distance", (0.0, Self::LONGEST), checked);
        check(&self.backstop_distance, "limits.backstop_distance", (-1.0, 1.0), checked);
        (
            checked.within("limits.backstop_radius", self.backstop_radius, 1.0, 0.01, 1000.0),
            checked.within("limits.scale", self.scale, 1.0, 0.0, 10.0),
        )
    }
}

/// A spring from each vertex to its place on the animated skin: cloth that keeps its shape, from languid to stiff, at any frame
/// rate.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothDrive {
    /// Frequency of the spring `[Hz]`. Default [`ClothMap::Off`], range 0 to 60. 1 is languid, 4 firm, 15 nearly stiff. Gravity
    /// draws it down by `g / (2 pi f)²`: 248, 15 and 1.1 mm.
    pub frequency: ClothMap,
    /// Damping over critical damping (dimensionless). Default 1, range 0 to 10. At 1 it is within 5 % after 0.75 periods and
    /// does not overshoot.
    pub damping_ratio: f32,
}

impl Default for ClothDrive {
    fn default() -> Self {
        Self { frequency: ClothMap::Off, damping_ratio: 1.0 }
    }
}

impl ClothDrive {
    /// Highest frequency `[Hz]`.
    pub(crate) const HIGHEST: f32 = 60.0;

    /// The damping ratio.
    pub(crate) fn checked(&self, checked: &mut Checked) -> f32 {
        check(&self.frequency, "drive.frequency", (0.0, Self::HIGHEST), checked);
        checked.within("drive.damping_ratio", self.damping_ratio, 1.0, 0.0, 10.0)
    }
}

/// Names a number of a map that is out of range. The number is used clamped, and as the lower end when it is not a number.
fn check(map: &ClothMap, name: &'static str, (least, most): (f32, f32), checked: &mut Checked) {
    match *map {
        ClothMap::Off => {}
        ClothMap::Uniform(value) => {
            checked.within(name, value, least, least, most);
        }
        ClothMap::Painted { low, high, .. } => {
            checked.within(name, low, least, least, most);
            checked.within(name, high, least, least, most);
        }
    }
}
