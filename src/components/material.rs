//! What a cloth is made of.

use core::f32::consts::PI;

use bevy::prelude::*;

use super::checked::Checked;
use crate::solver::settings::Fabric;

/// Mechanical properties of a fabric, in SI units and independent of the mesh's resolution.
///
/// Values outside a range are clamped when used (never a panic), named in [`ClothReport::clamped`](crate::ClothReport::clamped)
/// and told once.
///
/// # Where the presets come from
///
/// A preset is calibrated to a drape coefficient, measured for most, quoted for silk, wool and denim. The test is Cusick's (BS
/// 5058): a specimen of 30 cm on a disk of 18 cm. Sources are the 25 fabrics of Gong, Mao, Wang (CVPR 2024), and figures quoted
/// with them. Bending stiffness and friction lie inside what is measured for the fabric. `HB / B` is 18 (polyester faille) to
/// 52 /m (broadcloth), 23 to 54 in denims (J. Textiles 2016, 4614168). `cargo run --release --example fabric_lab` measures
/// them. At the default rates silk, cotton and denim on edges of 5 to 15 mm are within three points of runs with many more
/// substeps.
///
/// Areal densities are those of the trade (shirting 110 to 160 g/m², suiting 180 to 300, denim 340 to 480, garment leather 600
/// to 1000). Stiffness against stretching is the secant at 490 N/m of load and an elongation of 2 to 6 % (KES-F), shear 1
/// gf/(cm·deg) = 56 N/m. Rubber is a latex sheet of 0.5 mm from Young's modulus `E` = 1.5e6 Pa: `E·t` for stretching,
/// `E·t³/(12·(1 - ν²))` for bending. Two bolts of one fabric differ by a factor of two, and its two sides by five points of
/// drape: take them as starting points. `lab::SAMPLES`, with the feature `lab`, has the source of each, and the real thickness
/// where it is known. `thickness` here is a distance that contact keeps, five to thirty times as large, since meshes are
/// coarse.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothMaterial {
    /// Areal density `[kg/m²]`. Default 0.2, range 0.01 to 10. Lighter flutters more; very light cloth needs a higher substep
    /// rate.
    pub density: f32,
    /// Membrane stiffness along the threads `[N/m]`: tension per metre of width at a strain of one. Default 2000, range 0 to
    /// 1e7. Low is rubber; high needs substeps before it is noticed.
    pub stretch_stiffness: f32,
    /// Shear stiffness `G` of the membrane `[N/m]`: force per metre of width at an angle of one radian. Default 50, range 0 to
    /// 1e7; a woven fabric has 20 to 200. Low drapes into finer folds; 0 lets quads shear freely.
    pub shear_stiffness: f32,
    /// Bending stiffness `B` `[N·m]`: moment per metre of width and curvature. Default 1e-5, range 0 to 1. Low folds finely;
    /// high keeps the shape at rest. Held down to edges of a few millimetres, see
    /// [`ClothReport::bend_held`](crate::ClothReport::bend_held).
    pub bend_stiffness: f32,
    /// Stretch stiffness along the warp over that along the weft (dimensionless); `stretch_stiffness` is their mean. Default 1,
    /// range 0.1 to 10. The warp runs along `v` of the mesh's texture coordinates (`Mesh::ATTRIBUTE_UV_0`), the weft along `u`;
    /// without coordinates there is none, and a warning.
    pub stretch_ratio: f32,
    /// Bending stiffness along the warp over that along the weft (dimensionless); `bend_stiffness` is their mean. Default 1,
    /// range 0.1 to 10; woven fabrics have 0.7 to 2.5. Squares cut into triangles along the threads hold it within 5 % of their
    /// bending length, equilateral triangles up to a ratio of 3. Squares cut in four at 45° to the threads do not hold it at
    /// all.
    pub bend_ratio: f32,
    /// Angle by which the warp is turned from `v` towards `u` of the texture `[rad]`. Default 0, range -π to π. It turns the
    /// two ratios, and what stretches and what shears unless [`ClothMembrane::Springs`](crate::ClothMembrane::Springs) is asked
    /// for. A mirrored texture has it mirrored, like a left sleeve beside a right one.
    pub warp_angle: f32,
    /// Curvature that the friction between its yarns holds `[1/m]`, `HB / B` (2HB and B of Kawabata 1980). Default 0, range 0
    /// to 1000; silk 18, wool 25, cotton 40. A fold that was pressed to `κ` stays at `(κ - HB / B) / 2`, and at `HB / B` at
    /// most, and cloth stops at once. At 0 folds open all the way, and cloth swings. More than 0 makes it twice as stiff where
    /// it begins to bend.
    pub bend_hysteresis: f32,
    /// Damping inside the fabric `[1/s]`: rate at which stretching motion decays. Default 2, range 0 to 1000. High values look
    /// like moving in honey.
    pub damping: f32,
    /// Linear damping `[1/s]`: rate at which every velocity decays, whatever the wind. Default 0.1, range 0 to 100. At 0 cloth
    /// swings for ever.
    pub drag: f32,
    /// Largest elongation of an edge as a fraction of its length (dimensionless). Default 0.05, range 0 to 10; infinite
    /// switches it off.
    pub strain_limit: f32,
    /// Thickness `[m]`: distance kept to bodies. Default 0.005, range 1e-4 to 1. Thin cloth may show what it lies on.
    /// Two layers of cloth keep the mean of theirs, from centre to centre.
    pub thickness: f32,
    /// Coulomb coefficient below which the cloth sticks (dimensionless). Default 0.5, range 0 to 10; combined with a body's by
    /// the geometric mean.
    pub static_friction: f32,
    /// Coulomb coefficient while the cloth slides (dimensionless). Default 0.4, range 0 to 10.
    pub dynamic_friction: f32,
    /// Restitution: speed after an impact over the speed before it (dimensionless). Default 0, range 0 to 1. Between two cloths
    /// the larger counts; bodies have none of their own. Contacts slower than 0.25 m/s do not bounce.
    pub restitution: f32,
    /// How far it may hang from a pin, over the distance along the cloth at rest (dimensionless). Default 1, range 0.1 to 10;
    /// infinite switches it off.
    pub tether_scale: f32,
    /// Aerodynamic drag coefficient of the surface (dimensionless). Default 1.2, range 0 to 10.
    pub drag_coefficient: f32,
    /// Aerodynamic lift coefficient of the surface (dimensionless). Default 0.6, range 0 to 10.
    pub lift_coefficient: f32,
}

impl Default for ClothMaterial {
    fn default() -> Self {
        Self::BASE
    }
}

impl ClothMaterial {
    const BASE: Self = Self {
        density: 0.2,
        stretch_stiffness: 2000.0,
        shear_stiffness: 50.0,
        bend_stiffness: 1.0e-5,
        stretch_ratio: 1.0,
        bend_ratio: 1.0,
        warp_angle: 0.0,
        bend_hysteresis: 0.0,
        damping: 2.0,
        drag: 0.1,
        strain_limit: 0.05,
        thickness: 0.005,
        static_friction: 0.5,
        dynamic_friction: 0.4,
        restitution: 0.0,
        tether_scale: 1.0,
        drag_coefficient: 1.2,
        lift_coefficient: 0.6,
    };

    /// Plain-woven shirting of 0.3 mm (`thickness` is the distance kept, which meshes need to be larger): drape coefficient 65
    /// ± 6.
    pub const COTTON: Self = Self {
        density: 0.15,
        stretch_stiffness: 12_000.0,
        shear_stiffness: 85.0,
        bend_stiffness: 1.1e-5,
        bend_ratio: 1.6,
        bend_hysteresis: 40.0,
        strain_limit: 0.05,
        thickness: 0.005,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        ..Self::BASE
    };

    /// Light habotai, 0.12 mm: drape coefficient 35 ± 8.
    pub const SILK: Self = Self {
        density: 0.06,
        stretch_stiffness: 9_000.0,
        shear_stiffness: 22.0,
        bend_stiffness: 1.55e-6,
        bend_ratio: 1.4,
        bend_hysteresis: 18.0,
        damping: 1.0,
        strain_limit: 0.05,
        thickness: 0.004,
        static_friction: 0.3,
        dynamic_friction: 0.25,
        ..Self::BASE
    };

    /// Worsted suiting, 0.57 mm: drape coefficient 52 ± 8.
    pub const WOOL: Self = Self {
        density: 0.25,
        stretch_stiffness: 8_000.0,
        shear_stiffness: 40.0,
        bend_stiffness: 1.25e-5,
        bend_ratio: 1.4,
        bend_hysteresis: 25.0,
        damping: 3.0,
        strain_limit: 0.06,
        thickness: 0.007,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        ..Self::BASE
    };

    /// Raw trouser denim, 0.8 mm: drape coefficient 82 ± 6.
    pub const DENIM: Self = Self {
        density: 0.4,
        stretch_stiffness: 20_000.0,
        shear_stiffness: 190.0,
        bend_stiffness: 7.2e-5,
        bend_ratio: 2.3,
        bend_hysteresis: 35.0,
        damping: 4.0,
        strain_limit: 0.03,
        thickness: 0.008,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        ..Self::BASE
    };

    /// Garment leather of 0.9 mm: drape coefficient 65 ± 8; it has no threads, so shearing is nearly as stiff as stretching.
    pub const LEATHER: Self = Self {
        density: 0.8,
        stretch_stiffness: 15_000.0,
        shear_stiffness: 5_000.0,
        bend_stiffness: 6.8e-5,
        bend_hysteresis: 20.0,
        damping: 6.0,
        strain_limit: 0.03,
        thickness: 0.01,
        static_friction: 0.7,
        dynamic_friction: 0.6,
        ..Self::BASE
    };

    /// Latex sheet of 0.5 mm: drape coefficient 46 ± 5; it stretches, so neither strain limit nor tethers. Nothing in it rubs.
    pub const RUBBER: Self = Self {
        density: 0.47,
        stretch_stiffness: 750.0,
        shear_stiffness: 250.0,
        bend_stiffness: 2.5e-5,
        damping: 4.0,
        strain_limit: f32::INFINITY,
        thickness: 0.006,
        static_friction: 1.0,
        dynamic_friction: 0.8,
        tether_scale: f32::INFINITY,
        ..Self::BASE
    };

    /// Denim that was washed until it is soft: drape coefficient 70 ± 8.
    pub const WASHED_DENIM: Self = Self { bend_stiffness: 3.7e-5, ..Self::DENIM };

    /// Satin of five threads, 0.24 kg/m²: drape coefficient 56 ± 13.
    pub const SATIN: Self = Self {
        density: 0.24,
        stretch_stiffness: 10_000.0,
        shear_stiffness: 60.0,
        bend_stiffness: 1.4e-5,
        bend_ratio: 1.3,
        bend_hysteresis: 20.0,
        static_friction: 0.3,
        dynamic_friction: 0.25,
        ..Self::BASE
    };

    /// Plain weave of polyester and cotton as in work clothes and light canvas, 0.48 mm: drape coefficient 80 ± 6.
    pub const CANVAS: Self = Self {
        density: 0.22,
        stretch_stiffness: 15_000.0,
        shear_stiffness: 105.0,
        bend_stiffness: 3.1e-5,
        bend_ratio: 1.3,
        bend_hysteresis: 35.0,
        damping: 3.0,
        strain_limit: 0.04,
        thickness: 0.006,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        ..Self::BASE
    };

    /// Polyester faille of dresses and linings, 0.1 kg/m²: drape coefficient 28 ± 5.
    pub const FAILLE: Self = Self {
        density: 0.1,
        stretch_stiffness: 9_000.0,
        shear_stiffness: 40.0,
        bend_stiffness: 1.8e-6,
        bend_ratio: 1.3,
        bend_hysteresis: 18.0,
        damping: 1.0,
        thickness: 0.004,
        static_friction: 0.3,
        dynamic_friction: 0.25,
        ..Self::BASE
    };

    /// Viscose that flows, 0.21 kg/m²: drape coefficient 15 ± 3.
    pub const VISCOSE: Self = Self {
        density: 0.213,
        stretch_stiffness: 6_000.0,
        shear_stiffness: 40.0,
        bend_stiffness: 1.05e-6,
        bend_ratio: 1.2,
        bend_hysteresis: 18.0,
        strain_limit: 0.06,
        ..Self::BASE
    };

    /// The presets by name, as files and panels list them.
    pub const PRESETS: [(&str, Self); 11] = [
        ("cotton", Self::COTTON),
        ("silk", Self::SILK),
        ("wool", Self::WOOL),
        ("denim", Self::DENIM),
        ("washed_denim", Self::WASHED_DENIM),
        ("leather", Self::LEATHER),
        ("rubber", Self::RUBBER),
        ("satin", Self::SATIN),
        ("canvas", Self::CANVAS),
        ("faille", Self::FAILLE),
        ("viscose", Self::VISCOSE),
    ];

    /// The preset of that name, in any case.
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        Self::PRESETS.into_iter().find(|(n, _)| n.eq_ignore_ascii_case(name)).map(|(_, material)| material)
    }

    /// A field by its name.
    #[must_use]
    pub fn field_mut(&mut self, name: &str) -> Option<&mut f32> {
        Some(match name {
            "density" => &mut self.density,
            "stretch_stiffness" => &mut self.stretch_stiffness,
            "shear_stiffness" => &mut self.shear_stiffness,
            "bend_stiffness" => &mut self.bend_stiffness,
            "stretch_ratio" => &mut self.stretch_ratio,
            "bend_ratio" => &mut self.bend_ratio,
            "warp_angle" => &mut self.warp_angle,
            "bend_hysteresis" => &mut self.bend_hysteresis,
            "damping" => &mut self.damping,
            "drag" => &mut self.drag,
            "strain_limit" => &mut self.strain_limit,
            "thickness" => &mut self.thickness,
            "static_friction" => &mut self.static_friction,
            "dynamic_friction" => &mut self.dynamic_friction,
            "restitution" => &mut self.restitution,
            "tether_scale" => &mut self.tether_scale,
            "drag_coefficient" => &mut self.drag_coefficient,
            "lift_coefficient" => &mut self.lift_coefficient,
            _ => return None,
        })
    }

    /// Whether it is stiffer along one direction of the texture than along another.
    pub(crate) fn is_directed(&self) -> bool {
        self.stretch_ratio != 1.0 || self.bend_ratio != 1.0
    }

    /// What the solver sees, numbers out of range clamped.
    #[must_use]
    pub fn to_fabric(&self) -> Fabric {
        self.fabric(&mut Checked::default())
    }

    /// What the solver sees.
    pub(crate) fn fabric(&self, checked: &mut Checked) -> Fabric {
        let base = Self::BASE;
        Fabric {
            density: checked.within("density", self.density, base.density, 0.01, 10.0),
            stretch_stiffness: checked.within("stretch_stiffness", self.stretch_stiffness, base.stretch_stiffness, 0.0, 1.0e7),
            shear_stiffness: checked.within("shear_stiffness", self.shear_stiffness, base.shear_stiffness, 0.0, 1.0e7),
            bend_stiffness: checked.within("bend_stiffness", self.bend_stiffness, base.bend_stiffness, 0.0, 1.0),
            stretch_ratio: checked.within("stretch_ratio", self.stretch_ratio, base.stretch_ratio, 0.1, 10.0),
            bend_ratio: checked.within("bend_ratio", self.bend_ratio, base.bend_ratio, 0.1, 10.0),
            warp_angle: checked.within("warp_angle", self.warp_angle, base.warp_angle, -PI, PI),
            bend_hysteresis: checked.within("bend_hysteresis", self.bend_hysteresis, base.bend_hysteresis, 0.0, 1000.0),
            damping: checked.within("damping", self.damping, base.damping, 0.0, 1000.0),
            drag: checked.within("drag", self.drag, base.drag, 0.0, 100.0),
            strain_limit: checked.within_or_off("strain_limit", self.strain_limit, base.strain_limit, 0.0, 10.0),
            thickness: checked.within("thickness", self.thickness, base.thickness, 1.0e-4, 1.0),
            static_friction: checked.within("static_friction", self.static_friction, base.static_friction, 0.0, 10.0),
            dynamic_friction: checked.within("dynamic_friction", self.dynamic_friction, base.dynamic_friction, 0.0, 10.0),
            restitution: checked.within("restitution", self.restitution, base.restitution, 0.0, 1.0),
            tether_scale: checked.within_or_off("tether_scale", self.tether_scale, base.tether_scale, 0.1, 10.0),
            drag_coefficient: checked.within("drag_coefficient", self.drag_coefficient, base.drag_coefficient, 0.0, 10.0),
            lift_coefficient: checked.within("lift_coefficient", self.lift_coefficient, base.lift_coefficient, 0.0, 10.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_inside_its_documented_ranges() {
        for (name, material) in ClothMaterial::PRESETS {
            let mut checked = Checked::default();
            material.fabric(&mut checked);
            assert!(checked.clamped.is_empty(), "{name}: {:?}", checked.clamped);
        }
    }

    #[test]
    fn the_default_material_is_the_default_fabric() {
        assert_eq!(ClothMaterial::default().fabric(&mut Checked::default()), Fabric::default());
    }
}
