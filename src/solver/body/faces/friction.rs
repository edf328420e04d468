//! Friction of faces on bodies.

use glam::Vec4;

use super::project::by_part;
use super::push::mobility;
use super::{Candidate, FaceContacts, SHARE, point};
use crate::solver::body::BodyContext;

impl FaceContacts {
    /// Friction of faces, after that of [particles](crate::solver::body::BodyContacts::apply_friction).
    pub(crate) fn apply_friction(&mut self, context: &mut BodyContext<'_>, positions: &mut [Vec4], previous: &[Vec4]) {
        self.list_touching();
        for (part, touching) in by_part(&self.parts, &self.touching) {
            let Some(mut ground) = context.part(part.body, part.local, part.radius) else { continue };
            let mut rigid = context.rigid(part.body, self.dt, 1);
            for candidate in touching.iter().filter_map(|k| self.candidates.get(*k as usize)) {
                let Candidate { weights, plane, floor, load, .. } = candidate;
                let corners = candidate.corners(positions);
                let Some(mobility) = mobility(weights, &corners.map(|x| x.w)) else { continue };
                let way = (ground.start(point(weights, candidate.corners(previous))), point(weights, corners));
                let held = ground.hold((*plane, *floor, *load), way, (mobility, SHARE * ground.keep), &mut rigid);
                let Some(by) = held else { continue };
                for (p, share) in candidate.shares(&corners, mobility) {
                    positions[p as usize] += (by * share).extend(0.0);
                }
                // Faces share particles: one after the other, and the body moves with each.
                if let Some(rigid) = &mut rigid {
                    rigid.give_now();
                    ground.follow(rigid);
                }
            }
        }
    }
}
