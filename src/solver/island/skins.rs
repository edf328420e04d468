//! Tangles of cloth that its skin holds close are drawn to the skin, where that is whole: see
//! [`TangledLimits`](crate::solver::skinned::TangledLimits).

use glam::Vec4;

use super::{Island, Member};
use crate::solver::buffer::Buffer;
use crate::solver::detect::Detector;

/// Where the skins cross that cloths of an island follow; looked at only while something is tangled.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Skins {
    detector: Option<Detector>,
    targets: Buffer<Vec<Vec4>>,
    /// By cloth.
    cross: Buffer<Vec<bool>>,
}

impl Island {
    /// Draws what was tangled in the last frame to its skin, unless that crosses itself or another.
    pub(super) fn limit_tangled(&mut self, dt: f32, cloths: &mut [Member<'_>]) {
        let mut skins = core::mem::take(&mut self.skins);
        if self.weighed {
            self.look_at_skins(cloths, &mut skins);
        }
        for (part, m) in cloths.iter_mut().enumerate().filter(|(_, m)| m.moves) {
            if let Some(skinned) = m.cloth.input.skinned
                && skinned.limits(m.sim.state.positions.len())
            {
                let tangled = if self.weighed && !skins.cross[part] { self.weights(part) } else { &[] };
                m.sim.memory.tangled_limits.advance(skinned, tangled, dt);
            }
        }
        self.skins = skins;
    }

    /// Looks for crossings of the targets of all cloths; those without any are where they are.
    #[cold]
    fn look_at_skins(&self, cloths: &[Member<'_>], skins: &mut Skins) {
        let Skins { detector, targets, cross } = skins;
        let (targets, cross) = (&mut **targets, &mut **cross);
        targets.clone_from(&self.positions);
        let mut any = false;
        for (part, m) in cloths.iter().enumerate() {
            let range = self.range(part);
            if let Some(skinned) = m.cloth.input.skinned.filter(|skinned| skinned.limits(range.len())) {
                any = true;
                let offset = m.offset;
                for (target, to) in targets[range].iter_mut().zip(&skinned.to) {
                    *target = (*to + offset).extend(target.w);
                }
            }
        }
        cross.clear();
        cross.resize(self.surface.parts.len(), false);
        if any {
            let detector = detector.get_or_insert_with(|| {
                let tree = self.untangler.detector.tree_ref().clone();
                Detector::with_tree(&self.surface, tree)
            });
            detector.bound(self.most);
            for crossing in detector.detect(&self.surface, targets) {
                cross[usize::from(self.surface.part_of_edge(crossing.edge))] = true;
                cross[usize::from(self.surface.part_of_face(crossing.face))] = true;
            }
            if !detector.is_whole() {
                // What was not looked at may cross.
                cross.fill(true);
            }
        }
    }
}
