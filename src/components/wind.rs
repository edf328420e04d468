//! Wind: everywhere, in zones, and per cloth.

use bevy::prelude::*;

use super::checked::Checked;

/// Wind everywhere. Default: still air.
#[derive(Resource, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Resource, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothGlobalWind {
    /// Velocity of the air `[m/s]`. Default 0, at most 200.
    pub velocity: Vec3,
    /// Strength of gusts as a fraction of the speed (dimensionless). Default 0.3, range 0 to 5; open country 0.15, a city 0.3.
    pub turbulence: f32,
    /// Size of the largest gusts `[m]`. Default 4, range 0.05 to 1000. Much larger than the cloth: the wind swells as a whole;
    /// smaller: noise.
    pub gust_length: f32,
    /// How often the largest gusts change on top of passing by `[Hz]`. Default 0.5, range 0 to 20.
    pub gust_frequency: f32,
    /// Seed of the gusts: the same seed blows the same gusts.
    pub seed: u32,
    /// Density of the air `[kg/m³]`. Default 1.225, range 0 to 1000; 0 is vacuum.
    pub air_density: f32,
}

impl Default for ClothGlobalWind {
    fn default() -> Self {
        Self { velocity: Vec3::ZERO, turbulence: 0.3, gust_length: 4.0, gust_frequency: 0.5, seed: 0, air_density: 1.225 }
    }
}

impl ClothGlobalWind {
    /// Steady wind with the default gusts `[m/s]`.
    #[must_use]
    pub fn new(velocity: Vec3) -> Self {
        Self { velocity, ..Self::default() }
    }

    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        Self {
            velocity: checked.vector("wind.velocity", self.velocity, Vec3::ZERO, 200.0),
            turbulence: checked.within("wind.turbulence", self.turbulence, 0.3, 0.0, 5.0),
            gust_length: checked.within("wind.gust_length", self.gust_length, 4.0, 0.05, 1000.0),
            gust_frequency: checked.within("wind.gust_frequency", self.gust_frequency, 0.5, 0.0, 20.0),
            seed: self.seed,
            air_density: checked.within("wind.air_density", self.air_density, 1.225, 0.0, 1000.0),
        }
    }
}

/// Wind at one cloth in place of [`ClothGlobalWind`]; [`ClothWindZone`]s still add to it.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothWind(pub ClothGlobalWind);

impl ClothWind {
    /// Steady wind with the default gusts `[m/s]`.
    #[must_use]
    pub fn new(velocity: Vec3) -> Self {
        Self(ClothGlobalWind::new(velocity))
    }

    /// No wind at all, as indoors.
    #[must_use]
    pub fn still() -> Self {
        Self::default()
    }
}

/// A region where more wind blows; moves and turns with its entity.
#[derive(Component, Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize), serde(default))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
#[require(Transform)]
pub struct ClothWindZone {
    /// Where it blows, in the space of the entity.
    pub shape: ClothWindZoneShape,
    /// Velocity added to the air `[m/s]`, in the axes of the entity. Default 0, at most 200.
    pub velocity: Vec3,
    /// Whether it takes the place of the wind around it, as in a shelter, instead of adding to it. Default false.
    pub replace: bool,
    /// Distance from the border inwards over which it rises to its full strength `[m]`. Default 0.2, range 0 to 1000.
    pub falloff: f32,
}

/// Where a zone blows.
#[derive(Clone, Copy, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "serialize", derive(serde::Serialize, serde::Deserialize))]
#[reflect(Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub enum ClothWindZoneShape {
    /// In a cuboid around the origin.
    Cuboid {
        /// Half its lengths `[m]`, not negative.
        half_size: Vec3,
    },
    /// In a sphere around the origin.
    Sphere {
        /// Radius `[m]`.
        radius: f32,
    },
}

impl Default for ClothWindZoneShape {
    fn default() -> Self {
        Self::Sphere { radius: 1.0 }
    }
}

impl Default for ClothWindZone {
    fn default() -> Self {
        Self { shape: ClothWindZoneShape::default(), velocity: Vec3::ZERO, replace: false, falloff: 0.2 }
    }
}

impl ClothWindZone {
    /// Wind of `velocity` `[m/s]` in a box of lengths `size` `[m]`.
    #[must_use]
    pub fn cuboid(size: Vec3, velocity: Vec3) -> Self {
        Self { shape: ClothWindZoneShape::Cuboid { half_size: 0.5 * size }, velocity, ..Self::default() }
    }

    /// Wind of `velocity` `[m/s]` in a sphere of `radius` `[m]`.
    #[must_use]
    pub fn sphere(radius: f32, velocity: Vec3) -> Self {
        Self { shape: ClothWindZoneShape::Sphere { radius }, velocity, ..Self::default() }
    }

    pub(crate) fn checked(&self, checked: &mut Checked) -> Self {
        Self {
            shape: match self.shape {
                ClothWindZoneShape::Cuboid { half_size } => {
                    if half_size.min_element() < 0.0 {
                        checked.refuse("zone.half_size");
                    }
                    let half_size = half_size.max(Vec3::ZERO);
                    ClothWindZoneShape::Cuboid { half_size: checked.vector("zone.half_size", half_size, Vec3::ZERO, 1.0e6) }
                }
                ClothWindZoneShape::Sphere { radius } => {
                    ClothWindZoneShape::Sphere { radius: checked.within("zone.radius", radius, 0.0, 0.0, 1.0e6) }
                }
            },
            velocity: checked.vector("zone.velocity", self.velocity, Vec3::ZERO, 200.0),
            replace: self.replace,
            falloff: checked.within("zone.falloff", self.falloff, 0.2, 0.0, 1000.0),
        }
    }
}
