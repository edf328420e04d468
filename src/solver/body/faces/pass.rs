//! Tangent planes: a face in front of one never met the convex part behind it.

use glam::Vec3A;

use super::setting::{Setting, State, Way};
use crate::solver::body::advance::longest_way;
use crate::solver::body::distance::Sample;
use crate::solver::body::nearest::{Face, Near, at, to_point};
use crate::solver::scales::TOUCHING;

/// Tangent planes that are tried before the nearest point is asked for.
const PLANES: u32 = 4;
/// How much nearer another point may be than the nearest, as a share of its distance (dimensionless).
const EXACT: f32 = 0.02;

/// What tangent planes tell of a face.
enum Pass {
    /// It never met the part; a normal there, and its least height over the plane `[m]`.
    By(Vec3A, f32),
    /// Its nearest point at the end.
    Near(Near),
    /// Nothing; about where it lies.
    Unsure(Vec3A),
}

/// A face that may meet the part in the substep.
pub(super) struct Look {
    pub(super) way: Way,
    /// Its nearest point at the end.
    pub(super) end: Option<Near>,
    /// A normal of the part about where the face lies.
    pub(super) towards: Vec3A,
}

impl Look {
    /// Whether the face ends in front of a tangent plane of the part that it began in front of.
    pub(super) fn is_clear(&self) -> bool {
        self.end.filter(Near::is_outside).is_some_and(|near| {
            let foot = near.sample.normal.dot(near.point) - near.sample.distance;
            self.way.from.iter().all(|x| near.sample.normal.dot(*x) > foot)
        })
    }
}

impl Setting<'_> {
    /// Looks at a face, and notes it if it cannot meet the part.
    #[inline]
    pub(super) fn look(&self, state: &mut State<'_, '_>) -> Option<Look> {
        let way = self.way(state.candidate.particles, state.positions, state.previous)?;
        let (end, towards) = match self.pass(&way, state.candidate.piece.middle()) {
            Pass::By(normal, height) => {
                state.candidate.pass_by(normal, height - self.keep, &way.to);
                return None;
            }
            Pass::Near(near) => (Some(near), near.sample.normal),
            Pass::Unsure(towards) => (self.part.nearest(&way.to, towards), towards),
        };
        Some(Look { way, end, towards })
    }

    /// Looks for a tangent plane of the part that leaves the way of a face in front of it. The first plane is that at the
    /// middle of the face. Each next one is taken where the face is nearest to the foot of the last point on the part.
    #[inline]
    fn pass(&self, way: &Way, mut weights: [f32; 3]) -> Pass {
        let Way { from, to, .. } = way;
        let middle = at(to, &weights);
        let reach = longest_way(to, &[middle; 3]) + longest_way(from, to) + self.keep;
        let mut towards = Vec3A::ZERO;
        for _ in 0..PLANES {
            let point = at(to, &weights);
            let sample = self.part.geometry.sample(point, reach);
            let Sample { distance, normal } = sample;
            if normal == Vec3A::ZERO {
                return if distance >= reach { Pass::By(towards, f32::NEG_INFINITY) } else { Pass::Unsure(towards) };
            }
            towards = normal;
            let foot = normal.dot(point) - distance;
            let height = |face: &Face| face.iter().map(|x| normal.dot(*x) - foot).fold(f32::INFINITY, f32::min);
            let least = height(to);
            if least >= (1.0 + TOUCHING) * self.keep && height(from) > 0.0 {
                return Pass::By(normal, least);
            }
            if !(distance > 0.0) {
                break;
            }
            // No point of the face can be nearer than its lowest corner is to the plane.
            if least >= (1.0 - EXACT) * distance {
                return Pass::Near(Near { weights, point, sample });
            }
            weights = to_point(to, point - normal * distance).0;
        }
        Pass::Unsure(towards)
    }
}
