//! What each substep does with the particles listed: lays those that touched, and resolves contacts part by part.

use glam::{Vec3A, Vec4};

use super::part::{Particles, Setting};
use super::{BodyContacts, Candidate};
use crate::solver::body::distance;
use crate::solver::body::geometry::{self, Geometry};
use crate::solver::body::motion::{Motion, RigidProxy};
use crate::solver::body::provisional::{Grounds, Provisional};
use crate::solver::body::respond::{IMPACT_SPEED, RECOVERY_SPEED};
use crate::solver::body::{Body, Touch};
use crate::solver::couple::Coupling;

impl BodyContacts {
    /// Lays particles that touched a body in the last substep where it will put them; bodies take nothing.
    /// [`Provisional::restore`] must come before [`Self::project`].
    pub fn project_provisionally(
        &self,
        grounds: &mut Grounds<'_>,
        positions: &mut [Vec4],
        previous: &[Vec4],
        provisional: &mut Provisional,
    ) {
        for part in &self.parts {
            let candidates = self.candidates.get(part.candidates.0 as usize..part.candidates.1 as usize);
            let Some(ground) = grounds.part(part.body, part.local, part.radius) else { continue };
            for candidate in candidates.unwrap_or_default().iter().filter(|c| c.load > 0.0 && !c.left_out) {
                let Candidate { particle, plane, load, .. } = *candidate;
                let (Some(&x), Some(&old)) = (positions.get(particle as usize), previous.get(particle as usize)) else {
                    continue;
                };
                if let Some(way) = ground.way_out(plane, load, [old, x].map(Vec3A::from_vec4), ground.keep) {
                    provisional.put(particle, way, positions);
                }
            }
        }
    }

    /// Once per substep, after every other constraint: resolves contacts.
    ///
    /// `s0`, `s1`: fractions of the frame at the start and end of the substep. `previous` moves only where an overlap from
    /// before the substep is recovered, so that recovery leaves no velocity. Pinned particles (`w = 0`) never move. Bodies that
    /// name one of `coupling` are moved by what they do to the cloth, unless no time passes. `inbound`: the ways of particles
    /// in the substep `[m]` as their speeds at its start and gravity have them; empty: nothing bounces. Returns the number of
    /// contacts.
    #[expect(clippy::too_many_arguments, reason = "arrays of a cloth and of a substep, which the frame keeps apart")]
    pub fn project(
        &mut self,
        bodies: &[Body],
        s0: f32,
        s1: f32,
        positions: &mut [Vec4],
        previous: &mut [Vec4],
        inbound: &[Vec4],
        touch: &Touch,
        coupling: &mut Coupling,
    ) -> u32 {
        let h = (s1 - s0).max(0.0) * self.dt;
        let recovery = RECOVERY_SPEED * h;
        let mut contacts = 0;
        self.squeezes.advance();
        for (number, part) in (0_u32..).zip(&self.parts) {
            let Some(body) = bodies.get(part.body as usize) else {
                continue;
            };
            let Some(shape) = geometry::part(&*body.shape.0, part.index) else {
                continue;
            };
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
                recovery,
                friction: touch.friction(body),
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
