//! Friction of particles on bodies.

use glam::{Vec3, Vec3A, Vec4};

use super::{BodyContacts, Candidate};
use crate::solver::body::BodyContext;
use crate::solver::body::ground::Ground;
use crate::solver::body::motion::RigidProxy;

impl BodyContacts {
    /// Friction of particles, once per substep, after all pushes. Two-way bodies take the reaction.
    pub(crate) fn apply_friction(&mut self, context: &mut BodyContext<'_>, positions: &mut [Vec4], previous: &[Vec4]) {
        let Self { parts, candidates, places, dt, .. } = self;
        for part in parts.iter() {
            let candidates = candidates.get(part.candidates.0 as usize..part.candidates.1 as usize).unwrap_or_default();
            let several = candidates.iter().filter(|candidate| candidate.is_touching()).count();
            if several == 0 {
                continue;
            }
            let Some(ground) = context.part(part.body, part.local, part.radius) else { continue };
            let mut rigid = context.rigid(part.body, *dt, several);
            let places = part.places.and_then(|first| places.get_mut(first as usize..)).unwrap_or_default();
            for (k, candidate) in candidates.iter().enumerate().filter(|(_, candidate)| candidate.is_touching()) {
                let Candidate { particle, plane, floor, load, .. } = *candidate;
                let (Some(x), Some(old)) = (positions.get_mut(particle as usize), previous.get(particle as usize)) else {
                    continue;
                };
                let start = candidate.start_in(&ground, old.truncate(), rigid.as_ref().is_some_and(RigidProxy::is_movable));
                let held = ground.hold((plane, floor, load), (start, Vec3A::from_vec4(*x)), (x.w, ground.keep), &mut rigid);
                let Some(by) = held else { continue };
                *x += by.extend(0.0);
                if let Some(place) = places.get_mut(k) {
                    // By that alone: faces may have pushed it through a surface since.
                    *place += ground.to_part_space(by);
                }
            }
            if let Some(rigid) = rigid {
                rigid.finish();
            }
        }
    }
}

impl Candidate {
    /// Where the particle began the substep, in the space of the part `[m]`. `old`: its previous position by now `[m]`. On a
    /// body that `moves`, recovery has moved the start, too.
    fn start_in(&self, ground: &Ground, old: Vec3, moves: bool) -> Vec3A {
        if moves {
            ground.start(old.into())
        } else {
            Vec3A::from(self.start) + ground.turned_back((old - self.previous).into())
        }
    }
}
