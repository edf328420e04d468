//! What is elsewhere than foreseen: which particles are, and the pairs of those.

use glam::{Vec3, Vec3A, Vec4};

use super::foresee::{foreseen, limited, longest_way};
use super::looked::Looked;
use super::{Contacts, MARGIN, Moment, NeighborList};
use crate::solver::detect::Surface;
use crate::solver::detect::tree::Tree;

/// How far particles may stray from where they were foreseen, as a share of the distance within which pairs were found. Two
/// that both stray by less than half of it cannot meet.
const STRAY: f32 = 0.45;

impl NeighborList {
    /// Notes which particles of the cloth that begins at particle `first` may touch something that was not found before. It is
    /// for the next substep, at whose end `share` (0 to 1) of the time looked ahead will have passed. `positions` and
    /// `previous` and `offset` `[m]` as gathered, `thickness` `[m]` of the cloth. Whether there are any.
    pub(crate) fn strayed(
        &mut self,
        first: usize,
        positions: &[Vec4],
        previous: &[Vec4],
        offset: Vec3,
        share: f32,
        thickness: f32,
    ) -> bool {
        let common = Vec3A::from(offset) - self.shared * share;
        let limit = STRAY * (1.0 + MARGIN) * thickness;
        let range = first..first + positions.len();
        let stray = |(x, old): (&Vec4, &Vec4), (start, ahead): (&Vec3A, &Vec3A)| {
            Vec3A::from_vec4(*x * 2.0 - *old) + common - *start - (*ahead - *start) * share
        };
        let known = || positions.iter().zip(previous).zip(self.start[range.clone()].iter().zip(&self.ahead[range.clone()]));
        let mut far = Vec3A::ZERO;
        for (now, foreseen) in known() {
            let stray = stray(now, foreseen);
            far = far.max(stray * stray);
        }
        // The largest of each axis: no less than the farthest particle's.
        if far.element_sum() <= limit * limit {
            return false;
        }
        let mut any = false;
        for ((now, foreseen), astray) in known().zip(&mut self.astray[range.clone()]) {
            *astray = !(stray(now, foreseen).length_squared() <= limit * limit);
            any |= *astray;
        }
        any
    }

    /// Finds the pairs anew whose particles have [strayed](Self::strayed), for the rest `dt` `[s]` of the time looked ahead, of
    /// which `share` has passed.
    #[expect(clippy::too_many_arguments, reason = "arrays of an island, which it keeps apart")]
    pub(crate) fn update_strayed(
        &mut self,
        surface: &Surface,
        tree: &mut Tree,
        moment: &Moment<'_>,
        share: f32,
        dt: f32,
        tangled: impl Fn(u32) -> f32 + Sync,
        contacts: &mut Contacts,
    ) {
        self.mark(surface, moment, share);
        contacts.forget_all_but(|pair| pair.inverted || pair.faces.iter().all(|&f| !self.marked[f as usize]));
        contacts.close.retain(|faces| faces.iter().all(|&f| !self.marked[f as usize]));
        contacts.note_inverted();
        self.foresee_astray(surface, moment, share, dt);
        tree.refit(surface, moment.positions, Some(&self.ahead));
        tree.mark(&self.marked);
        self.ask_leaves(surface, tree, moment, tangled, contacts, true);
    }

    /// Marks the faces with a particle that is astray, and notes how those are now.
    fn mark(&mut self, surface: &Surface, moment: &Moment<'_>, share: f32) {
        for ((marked, face), t) in self.marked.iter_mut().zip(&mut self.faces).zip(&surface.topology.faces) {
            *marked = t.iter().any(|&v| self.astray[v as usize]);
            if *marked {
                // What is astray is looked at where it is. How far the others have drifted within a frame is not known, so that
                // they are looked at again.
                let drift = |v: u32| if self.astray[v as usize] { 0.0 } else { self.drift[v as usize] };
                let drift = if share > 0.0 { f32::INFINITY } else { t.iter().map(|&v| drift(v)).fold(0.0, f32::max) };
                *face = Looked::at(t.map(|v| Vec3A::from_vec4(moment.positions[v as usize])), drift);
            }
        }
    }

    /// Foresees anew where particles that are astray will be, when the rest `dt` `[s]` of the time looked ahead has passed.
    fn foresee_astray(&mut self, surface: &Surface, moment: &Moment<'_>, share: f32, dt: f32) {
        let longest = longest_way(surface, moment.thickest());
        // Of the time since the last look at everything and until the next: at its end all of it.
        let since = if share > 0.0 { (1.0 - share) / share } else { 1.0 };
        for (part, &h) in surface.parts.iter().zip(moment.substep) {
            let scale = if h > 0.0 { dt / h } else { 0.0 };
            for v in part.range() {
                if core::mem::take(&mut self.astray[v]) {
                    // Others were looked at where they were at that substep, not where they will have drifted from.
                    self.shifted[v] = share > 0.0;
                    let now = Vec3A::from_vec4(moment.positions[v]) - self.shared * share;
                    let motion = foreseen(moment, v, scale, self.before[v], since);
                    self.ahead[v] = now + limited(motion - self.shared * (1.0 - share), longest);
                    // So that it is here now.
                    self.start[v] = (now - self.ahead[v] * share) / (1.0 - share);
                }
            }
        }
    }
}
