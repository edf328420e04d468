//! What a cloth is asked of its skin: maps as numbers of particles, and the normals that backstops lie along.

use bevy::math::Mat3;
use bevy::mesh::VertexAttributeValues;
use bevy::prelude::*;

use super::paint::spread;
use super::uniform_scale;
use crate::components::{ClothDrive, ClothLimits, ClothMap};
use crate::solver::rest::RestShape;
use crate::solver::scales::RESPONSE_TIME;
use crate::solver::skinned::{PINNED, Skinned};
use crate::solver::surface;

/// The maps that are asked for.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Asked {
    pub max_distance: ClothMap,
    pub backstop_distance: ClothMap,
    pub frequency: ClothMap,
}

impl Asked {
    /// Those of the components of a cloth.
    pub(crate) fn of(limits: Option<&ClothLimits>, drive: Option<&ClothDrive>) -> Self {
        let of = |map: Option<&ClothMap>| map.cloned().unwrap_or_default();
        Self {
            max_distance: of(limits.map(|limits| &limits.max_distance)),
            backstop_distance: of(limits.map(|limits| &limits.backstop_distance)),
            frequency: of(drive.map(|drive| &drive.frequency)),
        }
    }

    /// Whether [`Self::of`] would give the same.
    pub(crate) fn is_of(&self, limits: Option<&ClothLimits>, drive: Option<&ClothDrive>) -> bool {
        let same = |mine: &ClothMap, map: Option<&ClothMap>| map.map_or(mine.is_off(), |map| mine == map);
        same(&self.max_distance, limits.map(|limits| &limits.max_distance))
            && same(&self.backstop_distance, limits.map(|limits| &limits.backstop_distance))
            && same(&self.frequency, drive.map(|drive| &drive.frequency))
    }
}

/// What was asked of the skin, for particles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Followed {
    pub asked: Asked,
    /// Maximum distances, backstop distances `[m]` and frequencies `[Hz]` that particles are to have; empty where there are
    /// none.
    wanted: [Vec<f32>; 3],
    /// Unit normals of the particles at rest; empty without a backstop.
    pub normals: Vec<Vec3>,
    /// Lengths of settings over those at the scale at which the cloth was bound (dimensionless).
    pub scale: f32,
    /// Scale at which it was bound first.
    bound: f32,
    /// Time until they have what they are to have `[s]`; all at once when it is bound.
    left: Option<f32>,
}

impl Followed {
    /// Spreads maps over particles. What cannot be used is off, and told by name with the reason. `before`: what was asked of
    /// it until now.
    pub(crate) fn new(
        asked: Asked,
        mesh: &Mesh,
        rest: &RestShape,
        bake: &Mat3,
        before: Option<&Self>,
        mut told: impl FnMut(&'static str, String),
    ) -> Self {
        let bound = before.map_or_else(|| uniform_scale(bake), |before| before.bound);
        let scale = uniform_scale(bake) / bound.max(f32::MIN_POSITIVE);
        let mut list = |name: &'static str, map: &ClothMap, range, scale: f32| match spread(map, mesh, rest, range) {
            Ok(mut values) => {
                values.iter_mut().for_each(|value| *value *= scale);
                values
            }
            Err(reason) => {
                told(name, reason);
                Vec::new()
            }
        };
        let distances = list("max_distance", &asked.max_distance, (0.0, ClothLimits::LONGEST), scale);
        let backstops = list("backstop_distance", &asked.backstop_distance, (-1.0, 1.0), scale);
        let frequencies = list("frequency", &asked.frequency, (0.0, ClothDrive::HIGHEST), 1.0);
        let normals = if backstops.is_empty() { Vec::new() } else { normals(mesh, rest, bake) };
        let left = before.map(|_| RESPONSE_TIME);
        Self { asked, wanted: [distances, backstops, frequencies], normals, scale, bound, left }
    }

    /// Particles that are as good as pinned to the skin, sorted.
    pub(crate) fn pinned(&self) -> impl Iterator<Item = u32> + '_ {
        (0..).zip(&self.wanted[0]).filter(|(_, distance)| **distance < PINNED).map(|(particle, _)| particle)
    }

    /// Moves what particles have towards what they are to have, for `dt` `[s]`: a map that changed makes no cloth jump.
    pub(crate) fn advance(&mut self, dt: f32, skinned: &mut Skinned) {
        let share = match self.left {
            Some(left) if left <= 0.0 => return,
            Some(left) if dt < left => dt / left,
            _ => 1.0,
        };
        self.left = Some(self.left.map_or(0.0, |left| left - dt));
        let lists = [&mut skinned.max_distance, &mut skinned.backstop_distance, &mut skinned.frequency];
        // Where there is no limit, one begins from as far as the cloth goes; where there is no spring, from none.
        let [free, unheld] = [2.0 * skinned.radius, 0.0];
        for ((now, wanted), (off, none)) in
            lists.into_iter().zip(&self.wanted).zip([(free, f32::INFINITY), (free, f32::INFINITY), (unheld, 0.0)])
        {
            if share >= 1.0 {
                now.clone_from(wanted);
                continue;
            }
            now.resize(now.len().max(wanted.len()), none);
            for (i, now) in now.iter_mut().enumerate() {
                let to = wanted.get(i).copied().unwrap_or(off);
                let from = if now.is_finite() { *now } else { off };
                *now = from + (to - from) * share;
            }
        }
    }
}

/// Unit normals of the particles at rest: as authored, of welded vertices their mean; else those of the faces.
fn normals(mesh: &Mesh, rest: &RestShape, bake: &Mat3) -> Vec<Vec3> {
    let mut normals = vec![Vec3::ZERO; rest.positions.len()];
    let turn = bake.inverse().transpose();
    match mesh.try_attribute(Mesh::ATTRIBUTE_NORMAL) {
        Ok(VertexAttributeValues::Float32x3(authored)) => {
            let pairs = (0..).zip(&rest.particle_of_vertex).zip(authored).filter(|((v, _), _)| !rest.is_gone(*v));
            for ((_, &particle), normal) in pairs {
                let normal = (turn * Vec3::from(*normal)).normalize_or_zero();
                normals[particle as usize] += normal;
            }
            normals.iter_mut().for_each(|normal| *normal = normal.normalize_or_zero());
        }
        _ => surface::normals(&rest.topology.faces, &rest.positions, &mut Vec::new(), &mut normals),
    }
    normals
}
