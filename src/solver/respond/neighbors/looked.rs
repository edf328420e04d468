//! Faces as they were when last looked at, and whether they have turned since.

use glam::{Vec3, Vec3A};

/// How far particles may drift, as a share of the least height that a face had when it was last looked at. Up to the first its
/// normal cannot have turned. Beyond the second much else may have changed.
const DRIFT_OF_HEIGHT: [f32; 2] = [0.1, 0.5];
/// Cosine of how far a normal may have turned since, or will, for what was flat to be flat still: 0.2 radians.
const TURNED: f32 = 0.98;

/// A face when it was last looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Looked {
    /// Twice its area along its normal `[m²]`.
    pub(super) normal: Vec3,
    /// Its least height `[m]`.
    pub(super) height: f32,
    /// How far its particles had drifted then, at most `[m]`.
    pub(super) drift: f32,
}

impl Looked {
    /// A face as it is now, its particles having drifted as far as `drift` `[m]`.
    #[inline]
    pub(super) fn at([a, b, c]: [Vec3A; 3], drift: f32) -> Self {
        let normal = (b - a).cross(c - a);
        let base = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
        Self { normal: normal.into(), height: (normal.length_squared() / base.max(f32::MIN_POSITIVE)).sqrt(), drift }
    }

    /// Whether it has turned since, its particles having drifted as far as `drift` `[m]`; `now` and `there`: where they are and
    /// will be `[m]`.
    #[inline]
    pub(super) fn has_turned(&self, drift: f32, now: impl Fn() -> [Vec3A; 3], there: impl Fn() -> [Vec3A; 3]) -> bool {
        let [still, far] = DRIFT_OF_HEIGHT.map(|share| share * self.height);
        let drift = drift + self.drift;
        let turned = |[a, b, c]: [Vec3A; 3]| {
            let normal = (b - a).cross(c - a);
            let was = Vec3A::from(self.normal);
            let along = normal.dot(was);
            !(along > 0.0 && along * along >= TURNED * TURNED * normal.length_squared() * was.length_squared())
        };
        // NaN passes no comparison.
        !(drift <= still) && (!(drift <= far) || turned(now()) || turned(there()))
    }
}

#[cfg(test)]
mod tests {
    use glam::{Quat, vec3};

    use super::*;

    #[test]
    fn a_face_has_turned_by_its_normal_or_when_nobody_can_tell() {
        let corners = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.3, 0.6, 0.0)].map(Vec3A::from);
        let face = Looked::at(corners, 0.0);
        assert!((face.height - 0.6).abs() < 1e-6, "{}", face.height);
        let by = |angle: f32| corners.map(|x| Vec3A::from(Quat::from_rotation_y(angle) * Vec3::from(x)));
        let asked = |drift: f32, now: f32, there: f32| face.has_turned(drift, || by(now), || by(there));
        assert!(!asked(0.2, 0.15, -0.15));
        assert!(asked(0.2, 0.25, 0.0) && asked(0.2, 0.0, -0.25), "now, or soon");
        assert!(asked(0.2, 3.1, 0.0), "turned over");
        assert!(!asked(0.059, 1.0, 1.0), "what hardly moved is not asked");
        assert!(asked(0.31, 0.0, 0.0), "what moved by half of its height is not known any more");
        assert!(asked(f32::NAN, 0.0, 0.0) && asked(0.2, f32::NAN, 0.0));
        let drifted = Looked::at(corners, 0.1);
        assert!(drifted.has_turned(0.059, || by(0.25), || corners), "nor is what had drifted before, known not to have moved");
        assert!(Looked::at([corners[0]; 3], 0.0).has_turned(0.1, || corners, || corners), "a face without area");
    }
}
