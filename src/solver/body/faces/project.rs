//! What each substep does with the faces listed: lays those that touched, and keeps faces out of parts, one part after the
//! other.

use glam::{Vec3A, Vec4};

use super::push::mobility;
use super::setting::{Setting, State};
use super::{FaceContacts, Part, SHARE, point};
use crate::solver::body::geometry::{self, Geometry};
use crate::solver::body::motion::{Motion, RigidProxy};
use crate::solver::body::nearest::Convex;
use crate::solver::body::provisional::Provisional;
use crate::solver::body::respond::Projection;
use crate::solver::body::squeeze::Squeezes;
use crate::solver::body::{Bearing, BodyContext};

/// Turns in which faces are stopped again, and in which they are kept in front of where the substep began, at most. Without
/// turns of the first kind, a table cloth of 36² that is pulled away at 3 m/s jams. Without those of the second it goes through
/// the table.
pub(super) const STOPS: u32 = 2;
pub(super) const PUTS: u32 = 6;

impl FaceContacts {
    /// The same for faces as [`BodyContacts::project_provisionally`](crate::solver::body::BodyContacts::project_provisionally),
    /// after it.
    pub(crate) fn project_provisionally(
        &mut self,
        context: &mut BodyContext<'_>,
        positions: &mut [Vec4],
        provisional: &mut Provisional,
    ) {
        self.list_touching();
        for (part, touching) in by_part(&self.parts, &self.touching) {
            let Some(ground) = context.part(part.body, part.local, part.radius) else { continue };
            for candidate in touching.iter().filter_map(|k| self.candidates.get(*k as usize)) {
                let (weights, corners) = (&candidate.weights, candidate.corners(positions));
                let point = point(weights, corners);
                let Some(way) = ground.way_to(candidate.plane, 0.0, point, SHARE * ground.keep) else { continue };
                let Some(mobility) = mobility(weights, &corners.map(|x| x.w)) else { continue };
                for (p, share) in candidate.shares(&corners, mobility) {
                    provisional.put(p, way * share, positions);
                }
            }
        }
    }

    /// The same for the corners of faces as [`BodyContacts::each_touch`](crate::solver::body::BodyContacts::each_touch).
    pub(crate) fn each_touch(
        &mut self,
        context: &mut BodyContext<'_>,
        positions: &[Vec4],
        mut touches: impl FnMut(u32, Option<Bearing>),
    ) {
        self.list_touching();
        for (part, touching) in by_part(&self.parts, &self.touching) {
            let Some(ground) = context.part(part.body, part.local, part.radius) else { continue };
            for candidate in touching.iter().filter_map(|k| self.candidates.get(*k as usize)) {
                for &p in &candidate.particles {
                    let Some(&x) = positions.get(p as usize) else { continue };
                    touches(p, ground.bearing(candidate.plane, Vec3A::from_vec4(x)));
                }
            }
        }
    }

    /// The same for faces as [`BodyContacts::push_to_planes`](crate::solver::body::BodyContacts::push_to_planes), after it.
    pub(crate) fn push_to_planes(&mut self, context: &mut BodyContext<'_>, positions: &mut [Vec4]) {
        self.list_touching();
        for (part, touching) in by_part(&self.parts, &self.touching) {
            let Some(mut ground) = context.part(part.body, part.local, part.radius) else { continue };
            let mut rigid = context.rigid(part.body, self.dt, 1);
            for k in touching {
                let Some(candidate) = self.candidates.get_mut(*k as usize) else { continue };
                let (weights, corners) = (&candidate.weights, candidate.corners(positions));
                let point = point(weights, corners);
                let to = ground.way_to(candidate.plane, candidate.floor, point, SHARE * ground.keep);
                let Some(mut way) = to else { continue };
                let Some(mobility) = mobility(weights, &corners.map(|x| x.w)) else { continue };
                candidate.load = Projection::Relax.load(candidate.load, way.length());
                if let Some(rigid) = &mut rigid {
                    way = rigid.split(mobility, point + way, way, Vec3A::ZERO).0;
                    rigid.give_now();
                    ground.follow(rigid);
                }
                for (p, share) in candidate.shares(&corners, mobility) {
                    positions[p as usize] += (way * share).extend(0.0);
                }
            }
        }
    }

    /// Lists the candidates that touched when last projected, once per projection.
    pub(super) fn list_touching(&mut self) {
        if !self.is_listed {
            self.touching.clear();
            self.touching.extend((0..).zip(&self.candidates).filter(|(_, c)| c.is_touching()).map(|(k, _)| k));
            self.is_listed = true;
        }
    }

    /// Once in a substep, after the particles: keeps faces out of parts. As
    /// [`BodyContacts::project`](crate::solver::body::BodyContacts::project); returns the number of touches.
    pub(crate) fn project(&mut self, context: &mut BodyContext<'_>, positions: &mut [Vec4], previous: &mut [Vec4]) -> u32 {
        self.is_listed = false;
        self.squeezes.advance(Projection::First);
        self.each_near(context, (positions, previous), |setting, passes, state, squeezes| {
            let load = state.candidate.load;
            let touched = setting.meet(state, squeezes);
            if !passes {
                // While no time passes loads stay.
                state.candidate.load = load;
            } else if !touched {
                state.candidate.load = 0.0;
            }
            touched
        })
    }

    /// Last in a substep: stops faces again, in turns, that the push of another, or friction, led into a part.
    pub(crate) fn stop_again(&mut self, context: &mut BodyContext<'_>, positions: &mut [Vec4], previous: &mut [Vec4]) {
        for turn in 0..STOPS + PUTS {
            let stopped = self.each_near(context, (positions, previous), |setting, passes, state, _| {
                passes && setting.stop_again(turn, state)
            });
            if stopped == 0 {
                break;
            }
            // What was stopped bears a load now.
            self.is_listed = false;
        }
    }

    /// Calls `act` for every candidate that may touch, with whether time passes; the number of those that did.
    fn each_near(
        &mut self,
        context: &mut BodyContext<'_>,
        (positions, previous): (&mut [Vec4], &mut [Vec4]),
        mut act: impl FnMut(&Setting<'_>, bool, &mut State<'_, '_>, &mut Squeezes) -> bool,
    ) -> u32 {
        let BodyContext { bodies, span: (s0, s1), touch, ref mut coupling } = *context;
        let h = (s1 - s0).max(0.0) * self.dt;
        let mut count = 0;
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
                recovery: Projection::First.recovery(h),
            };
            let mut rigid = slot.filter(|_| h > 0.0).map(|slot| RigidProxy::new(slot, s1, h));
            for candidate in candidates.iter_mut().filter(|candidate| !candidate.left_out) {
                if support.is_none() {
                    setting.take(self.feature_edges.get(candidate.feature_edge as usize));
                }
                if setting.is_clear(candidate, positions) {
                    continue;
                }
                let mut state = State { candidate, positions, previous, rigid: &mut rigid };
                let acted = act(&setting, h != 0.0, &mut state, &mut self.squeezes);
                count += u32::from(acted);
                if let Some(rigid) = rigid.as_ref().filter(|_| acted && h != 0.0) {
                    setting.motion.follow(rigid.slot, part.radius);
                }
            }
        }
        count
    }
}

/// Each part that has faces among those that touch (rising numbers of candidates), with them.
pub(super) fn by_part<'a>(parts: &'a [Part], mut touching: &'a [u32]) -> impl Iterator<Item = (&'a Part, &'a [u32])> {
    debug_assert!(touching.is_sorted());
    parts.iter().filter_map(move |part| {
        let here;
        (here, touching) = touching.split_at(touching.partition_point(|k| *k < part.candidates.1));
        (!here.is_empty()).then_some((part, here))
    })
}
