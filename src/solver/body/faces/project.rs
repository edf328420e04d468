//! What each substep does with the faces listed: lays those that touched, and keeps faces out of parts, one part after the
//! other.

use glam::{Vec3A, Vec4};

use super::push::mobility;
use super::setting::{Setting, State};
use super::{Candidate, FaceContacts, SHARE};
use crate::solver::body::geometry::{self, Geometry};
use crate::solver::body::motion::{Motion, RigidProxy};
use crate::solver::body::nearest::Convex;
use crate::solver::body::provisional::{Grounds, Provisional};
use crate::solver::body::respond::RECOVERY_SPEED;
use crate::solver::body::{Body, Touch};
use crate::solver::couple::Coupling;

impl FaceContacts {
    /// The same for faces as [`BodyContacts::project_provisionally`](crate::solver::body::BodyContacts::project_provisionally),
    /// after it.
    pub fn project_provisionally(
        &mut self,
        grounds: &mut Grounds<'_>,
        positions: &mut [Vec4],
        previous: &[Vec4],
        provisional: &mut Provisional,
    ) {
        if !self.is_listed {
            let touches = |c: &Candidate| c.load > 0.0 && !c.left_out;
            self.touching.clear();
            self.touching.extend((0..).zip(&self.candidates).filter(|(_, c)| touches(c)).map(|(k, _)| k));
            self.is_listed = true;
        }
        let mut touching = &self.touching[..];
        for part in &self.parts {
            let (here, others) = touching.split_at(touching.partition_point(|k| *k < part.candidates.1));
            touching = others;
            let Some(ground) = grounds.part(part.body, part.local, part.radius) else { continue };
            for candidate in here.iter().filter_map(|k| self.candidates.get(*k as usize)) {
                let Candidate { particles, weights, plane, load, .. } = candidate;
                let at = |of: &[Vec4]| particles.map(|p| of.get(p as usize).copied().unwrap_or(Vec4::NAN));
                let middle = |corners: [Vec4; 3]| (0..3).map(|i| Vec3A::from_vec4(corners[i]) * weights[i]).sum::<Vec3A>();
                let corners = at(positions);
                let ways = [middle(at(previous)), middle(corners)];
                let Some(way) = ground.way_out(*plane, *load, ways, SHARE * ground.keep) else { continue };
                let Some(mobility) = mobility(weights, &corners.map(|x| x.w)) else { continue };
                for ((&p, weight), x) in candidate.piece.of(particles).iter().zip(weights).zip(corners) {
                    provisional.put(p, way * (weight * x.w / mobility), positions);
                }
            }
        }
    }

    /// Once per substep, after the particles: keeps faces out of parts. As
    /// [`BodyContacts::project`](crate::solver::body::BodyContacts::project); returns the number of touches.
    #[expect(clippy::too_many_arguments, reason = "arrays of a cloth and of a substep, which the frame keeps apart")]
    pub fn project(
        &mut self,
        bodies: &[Body],
        s0: f32,
        s1: f32,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        touch: &Touch,
        coupling: &mut Coupling,
    ) -> u32 {
        let h = (s1 - s0).max(0.0) * self.dt;
        let mut touches = 0;
        self.is_listed = false;
        self.squeezes.advance();
        for (number, part) in (0_u32..).zip(&self.parts) {
            let Some(body) = bodies.get(part.body as usize) else {
                continue;
            };
            let Some(shape) = geometry::part(&*body.shape.0, part.index) else {
                continue;
            };
            let Some(candidates) = self.candidates.get_mut(part.candidates.0 as usize..part.candidates.1 as usize) else {
                continue;
            };
            let planes = self.planes.get(part.planes.0 as usize..part.planes.1 as usize).unwrap_or(&[]);
            let slot = body.rigid.and_then(|slot| coupling.slot_mut(slot));
            let mut motion = Motion::new(body, part.local, part.radius, s0, s1);
            if let Some(slot) = &slot {
                motion.follow(slot, part.radius);
            }
            let support = shape.as_support_map();
            let mut setting = Setting {
                part: Convex { geometry: Geometry::of(shape, planes), support },
                motion,
                radius: part.radius,
                pierces: part.pierces,
                number,
                keep: SHARE * touch.kept(body),
                recovery: RECOVERY_SPEED * h,
                friction: touch.friction(body),
            };
            let mut rigid = slot.filter(|_| h > 0.0).map(|slot| RigidProxy::new(slot, s1, h));
            for candidate in candidates.iter_mut().filter(|candidate| !candidate.left_out) {
                if support.is_none() {
                    setting.take(self.feature_edges.get(candidate.feature_edge as usize));
                }
                if setting.is_clear(candidate, positions) {
                    continue;
                }
                let load = candidate.load;
                let mut state = State { candidate, positions, previous, rigid: &mut rigid };
                let touched = setting.meet(&mut state, &mut self.squeezes);
                touches += u32::from(touched);
                if h == 0.0 {
                    // While no time passes loads stay.
                    state.candidate.load = load;
                } else if !touched {
                    state.candidate.load = 0.0;
                } else if let Some(rigid) = &rigid {
                    setting.motion.follow(rigid.slot, part.radius);
                }
            }
        }
        touches
    }
}
