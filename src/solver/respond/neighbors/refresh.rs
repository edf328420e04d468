//! Brings a look at everything up to date, while it holds.

use glam::{Vec3A, Vec4};

use super::foresee::foreseen;
use super::{Contacts, MARGIN, Moment, NeighborList};
use crate::solver::detect::Surface;
use crate::solver::detect::tree::Tree;

/// How far particles may drift from where they were at the last look for it to hold in the next frame, too, in thicknesses.
/// What drifted is looked at where it is, against others that may drift from one side of where they were to the other. Two that
/// were not known come to within `1 + MARGIN - CLOSE` thicknesses, a half, before they are known. Cloth is thinner there for a
/// moment, and far from crossing.
const DRIFT: f32 = CLOSE / 3.0;
/// How close faces may be that cross before they are looked at again, in thicknesses: both drift, and are foreseen to.
pub(super) const CLOSE: f32 = 0.5 + MARGIN;
/// Share of the particles that may have drifted; with more, a whole look costs less.
const MOST_DRIFTED: f32 = 0.4;

impl NeighborList {
    /// Brings the last look at all pairs up to date, if particles have drifted so little that it still holds except for a few.
    /// Those are looked at anew. False, and nothing is done, where more have drifted.
    pub(crate) fn refresh(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        moment: &Moment<'_>,
        dt: f32,
        tangled: impl Fn(u32) -> f32 + Sync,
        contacts: &mut Contacts,
    ) -> bool {
        // Where something lay in the same place, its side is not known yet.
        if self.shared != Vec3A::ZERO || contacts.coincide {
            return false;
        }
        let most = (MOST_DRIFTED * surface.len() as f32) as usize;
        let mut drifted = 0;
        for ((part, &h), touch) in surface.parts.iter().zip(moment.substep).zip(moment.touch) {
            let scale = if h > 0.0 { dt / h } else { 0.0 };
            let limit = DRIFT * touch.thickness;
            for v in part.range() {
                let (now, start) = (Vec3A::from_vec4(moment.positions[v]), self.start[v]);
                let motion = foreseen(moment, v, scale, self.before[v], 1.0);
                self.there[v] = now + motion;
                self.drift[v] = now.distance_squared(start).max(self.there[v].distance_squared(start)).sqrt();
                self.astray[v] = self.shifted[v] || !(self.drift[v] <= limit);
                drifted += usize::from(self.astray[v]);
            }
        }
        if drifted <= most {
            drifted += self.find_turned(surface, moment.positions);
        }
        if drifted > most {
            return false;
        }
        self.is_cut = false;
        if drifted > 0 {
            self.update_strayed(surface, tree, moment, 0.0, dt, tangled, contacts);
        }
        true
    }

    /// Finds the particles of faces that have turned since they were looked at, or will, though none of them has drifted too
    /// far; how many.
    fn find_turned(&mut self, surface: &Surface, positions: &[Vec4]) -> usize {
        let Self { there, drift, astray, faces, .. } = self;
        let mut count = 0;
        for (&t, face) in surface.topology.faces.iter().zip(&*faces) {
            // With one astray it is looked at anew.
            if t.iter().any(|&v| astray[v as usize]) {
                continue;
            }
            let [a, b, c] = t.map(|v| drift[v as usize]);
            let now = || t.map(|v| Vec3A::from_vec4(positions[v as usize]));
            if face.has_turned(a.max(b).max(c), now, || t.map(|v| there[v as usize])) {
                t.iter().for_each(|&v| astray[v as usize] = true);
                count += 3;
            }
        }
        count
    }
}
