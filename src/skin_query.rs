//! Questions about the skin beneath cloth: where it is, what limits the cloth there, and how deep points lie in bodies.

use bevy::ecs::system::SystemParam;
use bevy::math::DVec3;
use bevy::prelude::*;

use crate::components::Cloth;
use crate::simulation::{ClothInputs, ClothParticles, ClothRest};
use crate::solver::body;
use crate::solver::skinned::Skinned;

/// Asks what cloths were given of skin and bodies in the last simulated frame: for reports and tools. Points are in the world
/// `[m]`, one per particle.
///
/// An entity that is no bound cloth has none of it.
#[derive(SystemParam)]
pub struct ClothSkinQuery<'w, 's> {
    cloths: Query<'w, 's, (&'static ClothRest, &'static ClothInputs, &'static ClothParticles), With<Cloth>>,
}

impl ClothSkinQuery<'_, '_> {
    /// Where the animated skin itself takes each particle `[m]`, before it is taken out of bodies. A cloth without a skin has
    /// its mesh for one.
    #[must_use]
    pub fn places(&self, cloth: Entity) -> Option<impl Iterator<Item = DVec3> + '_> {
        let (rest, inputs, particles) = self.cloths.get(cloth).ok()?;
        let origin = particles.origin();
        Some(inputs.pose(rest.shape(), origin).map(move |place| origin + place.as_dvec3()))
    }

    /// Targets and limits as the solver has them, in its own frame: [`ClothParticles::origin`]. None where nothing is asked of
    /// the skin.
    #[must_use]
    pub fn skinned(&self, cloth: Entity) -> Option<&Skinned> {
        let (_, inputs, _) = self.cloths.get(cloth).ok()?;
        inputs.skinned.is_active().then_some(&inputs.skinned)
    }

    /// How deep points `[m]` lie in the bodies that the cloth could meet `[m]`, margins not counted; 0 outside.
    #[must_use]
    pub fn depths(&self, cloth: Entity, points: impl IntoIterator<Item = DVec3>) -> Option<Vec<f32>> {
        let (_, inputs, particles) = self.cloths.get(cloth).ok()?;
        let points: Vec<Vec3> = points.into_iter().map(|point| (point - particles.origin()).as_vec3()).collect();
        Some(body::depths(&inputs.bodies, &points))
    }
}
