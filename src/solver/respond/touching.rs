//! The pairs that touch, to be looked at.

use glam::{Vec3, Vec4};

use super::Contacts;
use super::cloths::offset_between;
use crate::solver::detect::{ProximityKind, Surface};

/// A pair that touched in the last substep.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Touching {
    /// Whether a particle touched a face, or two edges each other.
    pub kind: ProximityKind,
    /// The closest points of the first primitive and the second `[m]`, in the frame of the island.
    pub points: [Vec3; 2],
    /// Unit vector from the second towards the first, on the side where it belongs.
    pub normal: Vec3,
    /// With what the pair is pushed apart, on average over the last substeps `[N]`.
    pub force: f32,
}

impl Contacts {
    /// The pairs that touched when last [solved](Self::solve), of particles at `positions` `[m]`, each in the frame of
    /// simulation of its cloth. The next look for pairs forgets them.
    ///
    /// Force `F = C / (h² Σ w² m⁻¹)`, a mean over the last substeps. `C` is the push of a pair in a substep `h`, `w` are
    /// weights of the closest points, `m` masses as they were pushed.
    pub(crate) fn touching_pairs<'a>(
        &'a self,
        surface: &'a Surface,
        positions: &'a [Vec4],
    ) -> impl Iterator<Item = Touching> + 'a {
        self.bearing().filter(|_| self.substep > 0.0).filter_map(move |(pair, load)| {
            let [.., second] = pair.particles;
            let x = pair
                .particles
                .iter()
                .all(|p| (*p as usize) < positions.len())
                .then(|| pair.points(positions, offset_between(pair.parts, &self.offsets)))?;
            let offset = self.offset(surface.part(second));
            let of = |range: core::ops::Range<usize>, sign: f32| -> Vec3 {
                range.map(|i| (x[i].truncate() + offset) * (sign * pair.weights[i])).sum()
            };
            let split = pair.first();
            let force = load.drive / (self.substep * self.substep);
            let points = [of(0..split, 1.0), of(split..4, -1.0)];
            let touching = Touching { kind: pair.kind, points, normal: pair.normal, force };
            (force.is_finite() && points.iter().all(|p| p.is_finite())).then_some(touching)
        })
    }
}
