//! Zones: places with a wind of their own.

use glam::{Quat, Vec3};

use super::finite;

/// A place with a wind of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct WindZone {
    /// Shape of the zone around its centre.
    pub shape: ZoneShape,
    /// Centre, in the frame of simulation `[m]`.
    pub center: Vec3,
    /// Rotation of the zone.
    pub rotation: Quat,
    /// Velocity of the zone in the axes of the frame of simulation `[m/s]`.
    pub velocity: Vec3,
    /// Distance from the border inwards over which the zone rises to its full strength `[m]`. Default 0.2, range 0 to 1000; 0:
    /// a hard edge.
    pub falloff: f32,
    /// Whether the zone's wind adds to the wind around it or takes its place.
    pub mode: ZoneMode,
}

impl Default for WindZone {
    fn default() -> Self {
        Self {
            shape: ZoneShape::Sphere { radius: 1.0 },
            center: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            velocity: Vec3::ZERO,
            falloff: 0.2,
            mode: ZoneMode::Add,
        }
    }
}

/// Shape of a [`WindZone`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum ZoneShape {
    /// A ball `[m]`.
    Sphere {
        /// Radius `[m]`.
        radius: f32,
    },
    /// A box `[m]`.
    Box {
        /// Half of its sizes along its own axes `[m]`.
        half_extents: Vec3,
    },
}

/// How a zone's wind meets the wind around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub enum ZoneMode {
    /// Velocities add: a fan.
    #[default]
    Add,
    /// The zone's velocity takes the place of the wind: a shelter, a tunnel.
    Replace,
}

impl WindZone {
    /// 0 outside the shape, 1 deeper inside than the falloff, smooth between.
    #[must_use]
    pub fn weight(&self, point: Vec3) -> f32 {
        let q = point - self.center;
        let distance = match self.shape {
            ZoneShape::Sphere { radius } => q.length() - radius,
            ZoneShape::Box { half_extents } => ((self.rotation.inverse() * q).abs() - half_extents).max_element(),
        };
        // False for a distance that is not a number.
        if distance <= -self.falloff {
            1.0
        } else if distance < 0.0 {
            let t = -distance / self.falloff;
            t * t * (3.0 - 2.0 * t)
        } else {
            0.0
        }
    }

    pub(super) fn blend(&self, point: Vec3, wind: Vec3) -> Vec3 {
        let weight = self.weight(point);
        let own = finite(self.velocity);
        match self.mode {
            ZoneMode::Add => wind + own * weight,
            ZoneMode::Replace => wind.lerp(own, weight),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::wind::Wind;

    #[test]
    fn zones_add_or_replace_and_fade_at_their_border() {
        let zone =
            WindZone { velocity: Vec3::Y * 4.0, shape: ZoneShape::Box { half_extents: Vec3::ONE }, ..WindZone::default() };
        let mut wind = Wind { velocity: Vec3::X, zones: vec![zone], ..Wind::STILL };
        assert_eq!(wind.mean_at(Vec3::ZERO), Vec3::new(1.0, 4.0, 0.0));
        assert_eq!(wind.mean_at(Vec3::X * 1.01), Vec3::X);
        let half = wind.mean_at(Vec3::X * 0.9);
        assert!((half.y - 2.0).abs() < 1.0e-4, "{half} halfway through the border");
        wind.zones[0].mode = ZoneMode::Replace;
        assert_eq!(wind.mean_at(Vec3::ZERO), Vec3::Y * 4.0);
        wind.zones[0].shape = ZoneShape::Sphere { radius: 1.0 };
        assert_eq!(wind.mean_at(Vec3::splat(0.9)), Vec3::X);
    }
}
