//! What each substep does with the particles listed: lays those that touched, and pushes particles out part by part.

use glam::{Vec3A, Vec4};

use super::part::{Particles, Setting};
use super::{BodyContacts, Candidate, Part};
use crate::solver::body::distance;
use crate::solver::body::geometry::{self, Geometry};
use crate::solver::body::motion::{Motion, RigidProxy};
use crate::solver::body::provisional::Provisional;
use crate::solver::body::respond::{IMPACT_SPEED, Projection};
use crate::solver::body::{Bearing, BodyContext};

impl BodyContacts {
    /// Lays particles that touched a body in the last substep where it will put them; bodies take nothing.
    /// [`Provisional::restore`] must come before [`Self::project`].
    pub(crate) fn project_provisionally(
        &self,
        context: &mut BodyContext<'_>,
        positions: &mut [Vec4],
        provisional: &mut Provisional,
    ) {
        for part in &self.parts {
            let mut touching = self.touching_of(part).peekable();
            let Some(ground) = touching.peek().and_then(|_| context.part(part.body, part.local, part.radius)) else { continue };
            for candidate in touching {
                let Candidate { particle, plane, .. } = *candidate;
                let Some(&x) = positions.get(particle as usize) else { continue };
                if let Some(way) = ground.way_to(plane, 0.0, Vec3A::from_vec4(x), ground.keep) {
                    provisional.put(particle, way, positions);
                }
            }
        }
    }

    /// Calls `touches` for every particle that touched a body when last projected, with how that bears it.
    pub(crate) fn each_touch(
        &self,
        context: &mut BodyContext<'_>,
        positions: &[Vec4],
        mut touches: impl FnMut(u32, Option<Bearing>),
    ) {
        for part in &self.parts {
            let mut touching = self.touching_of(part).peekable();
            let Some(ground) = touching.peek().and_then(|_| context.part(part.body, part.local, part.radius)) else { continue };
            for candidate in touching {
                let Some(&x) = positions.get(candidate.particle as usize) else { continue };
                touches(candidate.particle, ground.bearing(candidate.plane, Vec3A::from_vec4(x)));
            }
        }
    }

    /// The candidates of a part that touched it when last projected.
    fn touching_of(&self, part: &Part) -> impl Iterator<Item = &Candidate> {
        let candidates = self.candidates.get(part.candidates.0 as usize..part.candidates.1 as usize);
        candidates.unwrap_or_default().iter().filter(|candidate| candidate.is_touching())
    }

    /// Pushes particles of this substep's contacts out to their planes again. Two-way bodies take the reaction.
    pub(crate) fn push_to_planes(&mut self, context: &mut BodyContext<'_>, positions: &mut [Vec4]) {
        let Self { parts, candidates, dt, .. } = self;
        for part in parts.iter() {
            let candidates = candidates.get_mut(part.candidates.0 as usize..part.candidates.1 as usize).unwrap_or_default();
            let several = candidates.iter().filter(|candidate| candidate.is_touching()).count();
            if several == 0 {
                continue;
            }
            let Some(ground) = context.part(part.body, part.local, part.radius) else { continue };
            let mut rigid = context.rigid(part.body, *dt, several);
            for candidate in candidates.iter_mut().filter(|candidate| candidate.is_touching()) {
                let Candidate { particle, plane, floor, load, .. } = candidate;
                let Some(x) = positions.get_mut(*particle as usize) else { continue };
                let to = ground.way_to(*plane, floor.min(0.0), Vec3A::from_vec4(*x), ground.keep);
                let Some(mut way) = to else { continue };
                *load = Projection::Relax.load(*load, way.length());
                if let Some(rigid) = &mut rigid {
                    way = rigid.split(x.w, Vec3A::from_vec4(*x) + way, way, Vec3A::ZERO).0;
                }
                *x += way.extend(0.0);
            }
            if let Some(rigid) = rigid {
                rigid.finish();
            }
        }
    }

    /// Pushes particles out: after all other constraints of a substep, and again after the turns over corners.
    /// [Friction](Self::apply_friction) follows.
    ///
    /// `previous` moves only where an overlap from before the substep is recovered, so that recovery leaves no velocity. Pinned
    /// particles (`w = 0`) never move. Two-way bodies take the reaction, unless no time passes. `inbound`: the ways of
    /// particles in the substep `[m]` as their speeds at its start and gravity have them; empty: nothing bounces. Returns the
    /// number of contacts.
    pub(crate) fn project(
        &mut self,
        context: &mut BodyContext<'_>,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        inbound: &[Vec4],
        projection: Projection,
    ) -> u32 {
        let BodyContext { bodies, span: (s0, s1), touch, ref mut coupling } = *context;
        let h = (s1 - s0).max(0.0) * self.dt;
        let mut contacts = 0;
        self.squeezes.advance(projection);
        for (number, part) in (0_u32..).zip(&self.parts) {
            let Some(body) = bodies.get(part.body as usize) else {
                continue;
            };
            let Some(shape) = geometry::part(&*body.shape.0, part.index) else {
                continue;
            };
            // What is convex pushes particles out in the next substep, or faces if it is thin.
            if projection == Projection::Relax && shape.as_support_map().is_some() {
                continue;
            }
            let planes = self.planes.get(part.planes.0 as usize..part.planes.1 as usize).unwrap_or(&[]);
            let geometry = Geometry::of(shape, planes);
            let slot = body.rigid.and_then(|slot| coupling.slot_mut(slot));
            let mut motion = Motion::new(body, part.local, part.radius, s0, s1);
            if let Some(slot) = &slot {
                motion.follow(slot, part.radius);
            }
            let Some(candidates) = self.candidates.get_mut(part.candidates.0 as usize..part.candidates.1 as usize) else {
                continue;
            };
            let keep = touch.kept(body);
            let setting = Setting {
                motion,
                rigid: slot.filter(|_| h > 0.0).map(|slot| RigidProxy::new(slot, s1, h)),
                timeless: h == 0.0,
                keep,
                number,
                clip: geometry.inner_radius().min(0.5 * keep),
                projection,
                recovery: projection.recovery(h),
                restitution: if touch.restitution > 0.0 { touch.restitution.min(1.0) } else { 0.0 },
                impact: IMPACT_SPEED * h,
                inbound,
            };
            let places = part.places.and_then(|first| self.places.get_mut(first as usize..)).unwrap_or_default();
            let mut state = Particles { positions, previous, places, squeezes: &mut self.squeezes };
            contacts += match geometry {
                Geometry::Ball { radius } => setting.project::<false>(candidates, &mut state, |q, _| distance::ball(q, radius)),
                Geometry::Capsule { a, ab, inverse_length2, radius } => {
                    setting
                        .project::<false>(candidates, &mut state, |q, _| distance::capsule(q, a, ab, inverse_length2, radius))
                }
                Geometry::Cuboid { half } => setting.project::<false>(candidates, &mut state, |q, _| distance::cuboid(q, half)),
                Geometry::HalfSpace { normal } => {
                    setting.project::<false>(candidates, &mut state, |q, _| distance::half_space(q, normal))
                }
                Geometry::Cylinder { half_height, radius } => {
                    setting.project::<false>(candidates, &mut state, |q, _| distance::cylinder(q, half_height, radius))
                }
                Geometry::Cone { half_height, radius, side } => {
                    setting.project::<false>(candidates, &mut state, |q, _| distance::cone(q, half_height, radius, side))
                }
                Geometry::Hull { planes, polyhedron } => {
                    setting.project::<true>(candidates, &mut state, |q, reach| geometry::hull(q, reach, planes, polyhedron))
                }
                Geometry::Mesh { mesh, solid } => {
                    setting.project::<true>(candidates, &mut state, |q, reach| geometry::mesh(q, reach, mesh, solid))
                }
                Geometry::Heights { field } => {
                    setting.project::<true>(candidates, &mut state, |q, reach| geometry::heights(q, reach, field))
                }
                Geometry::Other { shape } => {
                    setting.project::<true>(candidates, &mut state, |q, reach| geometry::other(q, reach, shape))
                }
            };
        }
        contacts
    }
}
