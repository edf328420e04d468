//! What a cloth is made of.

use bevy::prelude::*;

use super::checked::Checked;
use crate::solver::settings::Fabric;

/// Mechanical properties of a fabric, in SI units and independent of the mesh's resolution.
///
/// Values outside a range are clamped when used (never a panic), named in [`ClothReport::clamped`](crate::ClothReport::clamped) and told once.
///
/// # Where the presets come from
///
/// Areal densities are those of the trade (shirting 110 to 160 g/m², suiting 180 to 300, denim 340 to 480, garment leather 600 to 1000).
/// Stiffnesses are rounded from the ranges that the Kawabata evaluation system reports (KES-F; S. Kawabata, *The Standardization and
/// Analysis of Hand Evaluation*, 1980), converted to SI: tensile secant at 490 N/m of load and an elongation of 2 to 6 %, shear `G` 1
/// gf/(cm·deg) = 56 N/m, bending `B` 1 gf·cm²/cm = 9.8e-5 N·m; their order among each other follows H. Wang, J. O'Brien, R. Ramamoorthi,
/// *Data-driven elastic models for cloth: modeling and measurement*, 2011. Rubber is a latex sheet of 0.5 mm from Young's modulus `E` =
/// 1.5e6 Pa: `E·t` for stretching, `E·t³/(12·(1 - ν²))` for bending. Two bolts of one fabric differ by a factor of two: take them as
/// starting points.
#[derive(Component, Clone, Debug, PartialEq, Reflect)]
#[cfg_attr(feature = "presets", derive(serde::Serialize, serde::Deserialize), serde(default, deny_unknown_fields))]
#[reflect(Component, Default, Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serialize", reflect(Serialize, Deserialize))]
pub struct ClothMaterial {
    /// Areal density [kg/m²]. Default 0.2, range 0.01 to 10. Lighter flutters more; very light cloth needs a higher substep rate.
    pub density: f32,
    /// Membrane stiffness along the threads [N/m]: tension per metre of width at a strain of one. Default 2000, range 0 to 1e7.
    /// Low is rubber; high needs substeps before it is noticed.
    pub stretch_stiffness: f32,
    /// Membrane stiffness across the diagonals [N/m]. Default 200, range 0 to 1e7. Low drapes into finer folds; 0 lets quads shear freely.
    pub shear_stiffness: f32,
    /// Bending stiffness [N·m]. Default 1e-5, range 0 to 1. Low folds finely; high keeps the shape at rest.
    ///
    /// The solver caps it at about `(A1 + A2) / (8 h² Σ w c²)` for two triangles of areas `A1` and `A2`, substep `h`, inverse masses `w`
    /// and bending coefficients `c`, beyond which a substep would overshoot. Fine meshes therefore bend more softly than asked: at 360 Hz
    /// the cap is about 1e-5 N·m for 64 × 64 vertices per metre and 1e-6 N·m for 128 × 128. Raise
    /// [`ClothSolver::substep_rate`](crate::ClothSolver::substep_rate) where that shows.
    pub bend_stiffness: f32,
    /// Damping inside the fabric [1/s]: rate at which stretching motion decays. Default 2, range 0 to 1000. High looks like moving in honey.
    pub damping: f32,
    /// Damping against the still world [1/s]: rate at which every velocity decays. Default 0.1, range 0 to 100. 0 swings for ever.
    pub drag: f32,
    /// Largest elongation of an edge as a fraction of its length (dimensionless). Default 0.05, range 0 to 10; infinite switches it off.
    pub strain_limit: f32,
    /// Thickness [m]: distance kept to bodies. Default 0.005, range 1e-4 to 1. Thin cloth may show what it lies on.
    /// Two layers of cloth keep the mean of theirs, from centre to centre.
    pub thickness: f32,
    /// Coulomb coefficient below which it sticks (dimensionless). Default 0.5, range 0 to 10; combined with a body's by the geometric mean.
    pub static_friction: f32,
    /// Coulomb coefficient while it slides (dimensionless). Default 0.4, range 0 to 10.
    pub dynamic_friction: f32,
    /// Speed with which it leaves what it struck, over that with which it met it (dimensionless). Default 0, range 0 to 1. Of two cloths that meet the
    /// larger counts; bodies have none of their own. What meets at less than 0.25 m/s does not bounce.
    pub restitution: f32,
    /// How far it may hang from a pin, over the distance along the cloth at rest (dimensionless). Default 1, range 0.1 to 10; infinite
    /// switches it off.
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
        shear_stiffness: 200.0,
        bend_stiffness: 1.0e-5,
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

    /// Plain-woven shirting: 0.15 kg/m², KES-F `G` 1.5, `B` 0.1.
    pub const COTTON: Self = Self {
        density: 0.15,
        stretch_stiffness: 12_000.0,
        shear_stiffness: 85.0,
        bend_stiffness: 1.0e-5,
        strain_limit: 0.05,
        thickness: 0.005,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        ..Self::BASE
    };

    /// Light habotai: 0.06 kg/m², KES-F `G` 0.4, `B` 0.03.
    pub const SILK: Self = Self {
        density: 0.06,
        stretch_stiffness: 9_000.0,
        shear_stiffness: 22.0,
        bend_stiffness: 3.0e-6,
        damping: 1.0,
        strain_limit: 0.05,
        thickness: 0.004,
        static_friction: 0.3,
        dynamic_friction: 0.25,
        ..Self::BASE
    };

    /// Worsted suiting: 0.25 kg/m², KES-F `G` 0.7, `B` 0.12.
    pub const WOOL: Self = Self {
        density: 0.25,
        stretch_stiffness: 8_000.0,
        shear_stiffness: 40.0,
        bend_stiffness: 1.2e-5,
        damping: 3.0,
        strain_limit: 0.06,
        thickness: 0.007,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        ..Self::BASE
    };

    /// Trouser denim: 0.4 kg/m², KES-F `G` 4, `B` 1.
    pub const DENIM: Self = Self {
        density: 0.4,
        stretch_stiffness: 20_000.0,
        shear_stiffness: 220.0,
        bend_stiffness: 1.0e-4,
        damping: 4.0,
        strain_limit: 0.03,
        thickness: 0.008,
        static_friction: 0.6,
        dynamic_friction: 0.5,
        ..Self::BASE
    };

    /// Garment leather of 1 mm: 0.8 kg/m²; it has no threads, so shearing is nearly as stiff as stretching.
    pub const LEATHER: Self = Self {
        density: 0.8,
        stretch_stiffness: 15_000.0,
        shear_stiffness: 5_000.0,
        bend_stiffness: 3.0e-4,
        damping: 6.0,
        strain_limit: 0.03,
        thickness: 0.01,
        static_friction: 0.7,
        dynamic_friction: 0.6,
        ..Self::BASE
    };

    /// Latex sheet of 0.5 mm: 0.47 kg/m²; stretches, so neither strain limit nor tethers.
    pub const RUBBER: Self = Self {
        density: 0.47,
        stretch_stiffness: 750.0,
        shear_stiffness: 250.0,
        bend_stiffness: 2.0e-5,
        damping: 4.0,
        strain_limit: f32::INFINITY,
        thickness: 0.006,
        static_friction: 1.0,
        dynamic_friction: 0.8,
        tether_scale: f32::INFINITY,
        ..Self::BASE
    };

    /// The presets by name, as files and panels list them.
    pub const PRESETS: [(&str, Self); 6] = [
        ("cotton", Self::COTTON),
        ("silk", Self::SILK),
        ("wool", Self::WOOL),
        ("denim", Self::DENIM),
        ("leather", Self::LEATHER),
        ("rubber", Self::RUBBER),
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

    /// What the solver sees.
    pub(crate) fn fabric(&self, checked: &mut Checked) -> Fabric {
        let base = Self::BASE;
        Fabric {
            density: checked.within("density", self.density, base.density, 0.01, 10.0),
            stretch_stiffness: checked.within("stretch_stiffness", self.stretch_stiffness, base.stretch_stiffness, 0.0, 1.0e7),
            shear_stiffness: checked.within("shear_stiffness", self.shear_stiffness, base.shear_stiffness, 0.0, 1.0e7),
            bend_stiffness: checked.within("bend_stiffness", self.bend_stiffness, base.bend_stiffness, 0.0, 1.0),
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
