//! Which particles may meet which body in this frame, and their contacts in each substep.

use glam::{Vec3, Vec3A, Vec4};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose;
use parry3d::shape::{Shape, TypedShape};

use super::Body;
use super::distance::{self, Sample};
use super::geometry::{self, Geometry};
use super::laid::{Grounds, Laid};
use super::motion::{Motion, Yielding, farthest_push, finite_or_zero, swept_box, valid};
use super::respond::{BAND, Friction, IMPACT_SPEED, Plane, RECOVERY_SPEED, respond};
use super::room::Rooms;
use super::sweep::{Swept, plane_at, sweep};
use crate::solver::couple::Coupling;
use crate::solver::settings::Fabric;

/// How far a particle is moved between substeps that has to be looked at, and how far one that is not, in units of the distance kept
/// (dimensionless): it was put where it is.
const MOVED: f32 = 0.1;
const TELEPORTED: f32 = 16.0;

/// What a frame may bring: the bound on how far a particle can get.
#[derive(Clone, Copy, Debug)]
pub struct Approach {
    /// Length of the frame `[s]`.
    pub dt: f32,
    /// Length of the substep that lies between `previous` and `positions` `[s]`; 0 or less: the cloth is at rest.
    pub substep: f32,
    /// Gravity `[m/s²]`.
    pub gravity: Vec3,
    /// Thickness of the fabric `[m]`.
    pub thickness: f32,
    /// Distance beyond ballistic motion that a particle may be dragged in the frame `[m]`, for example the longest way of an anchor, and of
    /// the wind (`Wind::fastest() · dt`). 0 if unknown.
    pub extra: f32,
}

/// The fabric's side of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// Distance kept to every body `[m]`.
    pub thickness: f32,
    /// Static friction coefficient (dimensionless).
    pub static_friction: f32,
    /// Dynamic friction coefficient (dimensionless).
    pub dynamic_friction: f32,
    /// Speed with which it leaves what it struck, over that with which it met it (dimensionless).
    pub restitution: f32,
}

impl Touch {
    /// As a fabric says.
    #[must_use]
    pub fn of(fabric: &Fabric) -> Self {
        let Fabric { thickness, static_friction, dynamic_friction, restitution, .. } = *fabric;
        Self { thickness, static_friction, dynamic_friction, restitution }
    }

    /// Friction on a body.
    pub(super) fn friction(&self, body: &Body) -> Friction {
        Friction::between((body.static_friction, body.dynamic_friction), (self.static_friction, self.dynamic_friction))
    }

    /// Distance kept to a body `[m]`.
    pub(super) fn kept(&self, body: &Body) -> f32 {
        finite_or_zero(self.thickness) + finite_or_zero(body.margin)
    }

    /// Neither rubs nor bounces.
    #[must_use]
    pub(crate) fn frictionless(fabric: &Fabric) -> Self {
        Self { thickness: fabric.thickness, ..Self::default() }
    }
}

/// One particle that may meet one part of a body in this frame.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    particle: u32,
    /// Running mean of the push per substep `[m]`; 0 out of contact.
    load: f32,
    /// The plane on which it was put when it last touched, in the space of the part.
    plane: Plane,
    /// A point of body space and a radius without any surface around it `[m]`: no query while the path stays inside.
    clear_at: Vec3,
    clear: f32,
    /// Whether it is pinned to a body, and so touches none.
    left_out: bool,
}

/// One simple shape of a body, with its candidates.
#[derive(Clone, Debug)]
struct Part {
    body: u32,
    index: u32,
    local: Pose,
    planes: (u32, u32),
    candidates: (u32, u32),
    /// Where the last known places of its candidates begin; none but for surfaces, which have no inside to tell a wrong side by.
    places: Option<u32>,
    /// Farthest point of the part from its own origin `[m]`; infinite for a half-space.
    radius: f32,
}

/// Contacts of one cloth with all bodies. Buffers are reused: nothing is allocated once they are warm.
#[derive(Clone, Debug, Default)]
pub struct BodyContacts {
    parts: Vec<Part>,
    planes: Vec<Vec4>,
    candidates: Vec<Candidate>,
    /// Those of the frame before: a contact that stays keeps its load, or friction would give way at the start of each frame.
    parts_before: Vec<Part>,
    candidates_before: Vec<Candidate>,
    /// Where candidates of surfaces were when last projected, in the surface's own space `[m]`; not a number: not known.
    places: Vec<Vec3>,
    places_before: Vec<Vec3>,
    rooms: Rooms,
    /// Length of the frame `[s]`.
    dt: f32,
    /// How far a particle can get in it by itself `[m]`.
    way: f32,
}

impl BodyContacts {
    /// Number of pairs of a particle and a part of a body that are tested in each substep of this frame.
    #[must_use]
    pub fn candidates(&self) -> usize {
        self.candidates.len()
    }

    /// Particles that touched a body when last projected, by part of a body.
    pub fn touching(&self) -> impl Iterator<Item = u32> + '_ {
        self.candidates.iter().filter(|c| c.load > 0.0).map(|c| c.particle)
    }

    /// Number of the body, particle and mean push per substep `[m]` of every contact when last projected, by body.
    pub fn loads(&self) -> impl Iterator<Item = (usize, u32, f32)> + '_ {
        self.parts.iter().flat_map(|part| {
            let candidates = self.candidates.get(part.candidates.0 as usize..part.candidates.1 as usize).unwrap_or(&[]);
            candidates.iter().filter(|c| c.load > 0.0).map(|c| (part.body as usize, c.particle, c.load))
        })
    }

    /// Whether particles could have met a body in the last frame.
    pub(crate) fn is_near(&self, body: usize) -> bool {
        self.parts.iter().any(|part| part.body as usize == body)
    }

    /// Bound on how far a particle can get in this frame by itself `[m]`, as of the last [`Self::gather`] that had bodies.
    pub(crate) fn way(&self) -> f32 {
        self.way
    }

    #[cfg(test)]
    pub(super) fn capacities(&self) -> [usize; 3] {
        [self.parts.capacity(), self.planes.capacity(), self.candidates.capacity()]
    }

    /// Once per frame, before its first substep: pairs each body with the particles that could reach it.
    ///
    /// A particle is a candidate when it lies in the box around the shape at both ends of the frame, widened by how far any particle can get:
    /// `v dt + |g| dt² + b + extra + 2 thickness`, `v` the fastest particle's speed and `b` the longest way of a body, which may push
    /// a particle against another body. Pinned (`w = 0`) and non-finite particles never are.
    pub fn gather(&mut self, bodies: &[Body], positions: &[Vec4], previous: &[Vec4], approach: &Approach) {
        core::mem::swap(&mut self.parts, &mut self.parts_before);
        core::mem::swap(&mut self.candidates, &mut self.candidates_before);
        core::mem::swap(&mut self.places, &mut self.places_before);
        self.places.clear();
        self.parts.clear();
        self.planes.clear();
        self.candidates.clear();
        let mut known = 0;
        self.dt = approach.dt;
        let passes = approach.dt > 0.0;
        if bodies.is_empty() || !passes {
            return;
        }
        let thickness = finite_or_zero(approach.thickness);
        self.way = farthest_way(positions, previous, approach);
        let way = self.way + farthest_push(bodies) + 2.0 * thickness;
        for (b, body) in (0_u32..).zip(bodies) {
            let (Some(from), Some(to)) = (valid(body.from), valid(body.to)) else {
                continue;
            };
            // A body that cloth moves gets no farther off its way than cloth does.
            let off = if body.rigid.is_some() { way } else { 0.0 };
            let reach = way + off + finite_or_zero(body.margin);
            geometry::for_each_part(&*body.shape.0, |index, local, shape| {
                let Some(local) = valid(local) else {
                    return;
                };
                let (from, to) = (from * local, to * local);
                let first_plane = self.planes.len() as u32;
                let first = self.candidates.len() as u32;
                let mut radius = f32::INFINITY;
                match shape.as_typed_shape() {
                    TypedShape::HalfSpace(s) => {
                        self.gather_half_space(from, to, s.normal, reach, positions);
                    }
                    typed => {
                        if let TypedShape::ConvexPolyhedron(polyhedron) = typed {
                            geometry::hull_planes(polyhedron, &mut self.planes);
                        }
                        let (swept, bulge, far) = swept_box(shape, &from, &to);
                        radius = far;
                        self.gather_box(&swept, reach + bulge, positions);
                    }
                }
                let candidates = (first, self.candidates.len() as u32);
                if candidates.1 > candidates.0 {
                    while self.parts_before.get(known).is_some_and(|p| (p.body, p.index) < (b, index)) {
                        known += 1;
                    }
                    let before = self.parts_before.get(known).filter(|p| (p.body, p.index) == (b, index));
                    if let Some(before) = before {
                        keep_loads(&self.candidates_before, before.candidates, &mut self.candidates[first as usize..]);
                    }
                    let planes = (first_plane, self.planes.len() as u32);
                    let places = is_two_sided(shape).then(|| {
                        let first = self.places.len();
                        self.places.resize(first + (candidates.1 - candidates.0) as usize, Vec3::NAN);
                        first as u32
                    });
                    if let (Some(now), Some(before)) = (places, before)
                        && let Some(was) = before.places
                    {
                        let was = self.places_before.get(was as usize..).unwrap_or(&[]);
                        let before = self.candidates_before.get(before.candidates.0 as usize..before.candidates.1 as usize);
                        let places = &mut self.places[now as usize..];
                        keep_places(before.unwrap_or(&[]), was, &self.candidates[first as usize..], places);
                    }
                    self.parts.push(Part { body: b, index, local, planes, candidates, places, radius });
                }
            });
        }
        self.rooms.begin(self.parts.len(), positions.len());
    }

    /// Takes out particles that are pinned to bodies, in ascending order.
    pub(crate) fn leave_out(&mut self, particles: &[u32]) {
        if particles.is_empty() {
            return;
        }
        for candidate in &mut self.candidates {
            if particles.binary_search(&candidate.particle).is_ok() {
                (candidate.left_out, candidate.load) = (true, 0.0);
            }
        }
    }

    fn gather_box(&mut self, swept: &Aabb, reach: f32, positions: &[Vec4]) {
        // The fourth lane asks for a positive inverse mass. NaN fails every comparison.
        let low = (swept.mins - Vec3::splat(reach)).extend(f32::MIN_POSITIVE);
        let high = (swept.maxs + Vec3::splat(reach)).extend(f32::MAX);
        for (particle, p) in (0_u32..).zip(positions) {
            if (p.cmpge(low) & p.cmple(high)).all() {
                self.candidates.push(Candidate::new(particle));
            }
        }
    }

    fn gather_half_space(&mut self, from: Pose, to: Pose, normal: Vec3, reach: f32, positions: &[Vec4]) {
        let plane = |pose: Pose| {
            let n = pose.rotation * normal;
            n.extend(-n.dot(pose.translation))
        };
        let (a, b) = (plane(from), plane(to));
        for (particle, p) in (0_u32..).zip(positions) {
            let q = p.truncate().extend(1.0);
            if p.w > 0.0 && a.dot(q).min(b.dot(q)) <= reach {
                self.candidates.push(Candidate::new(particle));
            }
        }
    }

    /// Lays particles that touched a body in the last substep where it will put them; bodies take nothing. [`Laid::take_back`] must come
    /// before [`Self::project`].
    pub fn lay(&self, grounds: &mut Grounds<'_>, positions: &mut [Vec4], previous: &[Vec4], laid: &mut Laid) {
        for part in &self.parts {
            let candidates = self.candidates.get(part.candidates.0 as usize..part.candidates.1 as usize);
            let Some(ground) = grounds.part(part.body, part.local, part.radius) else { continue };
            for candidate in candidates.unwrap_or_default().iter().filter(|c| c.load > 0.0 && !c.left_out) {
                let Candidate { particle, plane, load, .. } = *candidate;
                let (Some(&x), Some(&old)) = (positions.get(particle as usize), previous.get(particle as usize)) else {
                    continue;
                };
                if let Some(way) = ground.way_out(plane, load, [old, x].map(Vec3A::from_vec4), ground.keep) {
                    laid.put(particle, way, positions);
                }
            }
        }
    }

    /// Once per substep, after every other constraint: resolves contacts.
    ///
    /// `s0`, `s1`: fractions of the frame at the start and end of the substep. `previous` moves only where an overlap from before the
    /// substep is recovered, so that recovery leaves no velocity. Pinned particles (`w = 0`) never move. Bodies that name one of `coupling`
    /// are moved by what they do to the cloth, unless no time passes. `inbound`: the ways of particles in the substep `[m]` as their speeds at its start
    /// and gravity have them; empty: nothing bounces. Returns the number of contacts.
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
        self.rooms.advance();
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
                rigid: slot.filter(|_| h > 0.0).map(|slot| Yielding::new(slot, s1, h)),
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
            let mut state = Particles { positions, previous, places, rooms: &mut self.rooms };
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

impl Candidate {
    fn new(particle: u32) -> Self {
        Self { particle, load: 0.0, plane: Plane::default(), clear_at: Vec3::ZERO, clear: f32::NEG_INFINITY, left_out: false }
    }
}

/// Passes on the loads of contacts that stay; both lists are in the order of particles.
fn keep_loads(before: &[Candidate], (first, end): (u32, u32), now: &mut [Candidate]) {
    let mut before = before.get(first as usize..end as usize).unwrap_or(&[]).iter().filter(|c| c.load > 0.0).peekable();
    for candidate in now {
        while before.next_if(|old| old.particle < candidate.particle).is_some() {}
        if let Some(old) = before.next_if(|old| old.particle == candidate.particle) {
            (candidate.load, candidate.plane) = (old.load, old.plane);
        }
    }
}

/// Passes on the last known places of particles that stay; both lists are in the order of particles.
fn keep_places(before: &[Candidate], places_before: &[Vec3], now: &[Candidate], places: &mut [Vec3]) {
    let mut before = before.iter().zip(places_before).peekable();
    for (candidate, place) in now.iter().zip(places) {
        while before.next_if(|(old, _)| old.particle < candidate.particle).is_some() {}
        if let Some((_, was)) = before.next_if(|(old, _)| old.particle == candidate.particle) {
            *place = *was;
        }
    }
}

/// Whether a shape is a surface that both sides of are outside.
fn is_two_sided(shape: &dyn Shape) -> bool {
    match shape.as_typed_shape() {
        TypedShape::TriMesh(mesh) => mesh.pseudo_normals_if_oriented().is_none(),
        TypedShape::HeightField(_) => true,
        _ => false,
    }
}

/// Positions at both ends of the substep.
struct Particles<'a> {
    positions: &'a mut [Vec4],
    previous: &'a mut [Vec4],
    /// Last known places, by candidate; empty but for surfaces.
    places: &'a mut [Vec3],
    rooms: &'a mut Rooms,
}

/// Everything that is the same for all candidates of one part in one substep.
struct Setting<'a> {
    motion: Motion,
    /// The body, if it takes what it does to the cloth.
    rigid: Option<Yielding<'a>>,
    /// Whether no time passes.
    timeless: bool,
    /// Distance kept `[m]`.
    keep: f32,
    /// Place of the part among the parts.
    number: u32,
    /// How deep a straight path may cut a corner between two points outside `[m]`.
    clip: f32,
    /// Way that an overlap is recovered in the substep `[m]`.
    recovery: f32,
    friction: Friction,
    restitution: f32,
    /// Way of an approach from which on it bounces `[m]`.
    impact: f32,
    /// Ways in the substep `[m]` if nothing held the cloth together; empty: nothing bounces.
    inbound: &'a [Vec4],
}

impl Setting<'_> {
    /// `COSTLY`: a sample is a search in a tree, so remember how far away nothing is.
    #[inline]
    fn project<const COSTLY: bool>(
        mut self,
        candidates: &mut [Candidate],
        particles: &mut Particles<'_>,
        sample: impl Fn(Vec3A, f32) -> Sample,
    ) -> u32 {
        let to_body1 = self.motion.rotation1.transpose();
        let to_body0 = self.motion.rotation0.transpose();
        let band = BAND * self.keep;
        let mut contacts = 0;
        if let Some(rigid) = self.rigid.as_mut().filter(|rigid| rigid.is_movable()) {
            let touches = candidates.iter().filter(|candidate| !candidate.left_out).filter(|candidate| {
                let Some(x) = particles.positions.get(candidate.particle as usize) else { return false };
                let q = to_body1 * (Vec3A::from_vec4(*x) - self.motion.translation1);
                let off = (q - Vec3A::from(candidate.clear_at)).length();
                let clear = COSTLY && candidate.clear - off >= self.keep + band;
                !clear && sample(q, self.keep + band).distance < self.keep + band
            });
            rigid.several = touches.count().max(1) as f32;
        }
        for (k, kept) in candidates.iter_mut().enumerate().filter(|(_, candidate)| !candidate.left_out) {
            // While no time passes loads stay.
            let mut spare;
            let candidate = if self.timeless {
                spare = *kept;
                &mut spare
            } else {
                kept
            };
            let i = candidate.particle as usize;
            let (Some(position), Some(before)) = (particles.positions.get_mut(i), particles.previous.get_mut(i)) else {
                continue;
            };
            let x1 = Vec3A::from_vec4(*position);
            let x0 = Vec3A::from_vec4(*before);
            // The path relative to the body is no longer than this.
            let way = (x1 - x0).length();
            let path_bound = way + self.motion.way;
            let q1 = to_body1 * (x1 - self.motion.translation1);
            let place = if COSTLY { particles.places.get_mut(k) } else { None };
            let last = place.as_ref().map_or(Vec3A::NAN, |place| Vec3A::from(**place));
            if let Some(place) = place {
                *place = q1.into();
            }
            if COSTLY {
                let off = (q1 - Vec3A::from(candidate.clear_at)).length();
                // Every point of the path is within `path_bound` of its end.
                if candidate.clear - off - path_bound >= self.keep + band {
                    candidate.load = 0.0;
                    continue;
                }
            }
            // False for a particle that is not a number.
            let finite = way < f32::MAX;
            if !finite {
                continue;
            }
            let reach = self.keep + band + if COSTLY { (4.0 * path_bound).max(self.keep) } else { path_bound };
            let s1 = sample(q1, reach);
            let (clear_at, clear) = (Vec3A::from(candidate.clear_at), candidate.clear);
            if COSTLY {
                candidate.clear_at = q1.into();
                candidate.clear = s1.distance;
            }
            let gap1 = s1.distance - self.keep;
            if gap1 >= path_bound && gap1 >= band {
                candidate.load = 0.0;
                continue;
            }
            let keep = if gap1 < band && s1.normal != Vec3A::ZERO {
                let normal = self.motion.rotation1 * s1.normal;
                let keep = particles.rooms.keep(candidate.particle, self.number, normal, s1.distance, self.keep);
                if keep < self.keep {
                    // Squeezed, which is a load.
                    candidate.load = candidate.load.max(0.25 * (self.keep - keep));
                }
                keep
            } else {
                self.keep
            };
            let gap1 = s1.distance - keep;
            let q0 = to_body0 * (x0 - self.motion.translation0);
            if COSTLY && let Some(Swept { end, plane }) = self.strayed(&sample, last, q0, q1) {
                // Without velocity into the surface.
                let n = self.motion.rotation1 * plane.normal;
                let by = self.motion.rotation1 * (end - q1);
                let approach = n * n.dot(x1 - x0).min(0.0);
                *position += by.extend(0.0);
                *before += (by + approach).extend(0.0);
                if let Some(place) = particles.places.get_mut(k) {
                    *place = end.into();
                }
                contacts += 1;
                continue;
            }
            // What is known of the distance at the start without asking for it: at rest it is enough.
            let least = if COSTLY { (clear - (q0 - clear_at).length()).max(0.0) } else { 0.0 };
            let swept = if s1.distance < 0.0 || path_bound >= least + self.clip {
                let s0 = sample(q0, reach);
                // Outside before; inside now, or far enough to have come out on the other side.
                let crossed = s0.distance > 0.0 && (s1.distance < 0.0 || (q1 - q0).length() >= s0.distance + self.clip);
                if crossed { sweep(&sample, (q0, s0), q1, keep) } else { None }
            } else {
                None
            };
            let (end, plane) = match swept {
                Some(swept) => (swept.end, swept.plane),
                None if gap1 < band && s1.normal != Vec3A::ZERO => (q1, plane_at(q1, s1, keep)),
                None => {
                    candidate.load = 0.0;
                    continue;
                }
            };
            if swept.is_none() && gap1 >= 0.0 && candidate.load <= 0.0 {
                continue;
            }
            let friction = match &self.rigid {
                Some(rigid) if rigid.is_movable() => {
                    let at = self.motion.rotation1 * end + self.motion.translation1;
                    self.friction.times(rigid.slide(position.w, at, self.motion.rotation1 * plane.normal))
                }
                _ => self.friction,
            };
            let rise = self.inbound.get(i).map_or(0.0, |way| {
                let foreseen = to_body1 * (x0 + Vec3A::from_vec4(*way) - self.motion.translation1);
                let approach = plane.normal.dot(q0 - foreseen).min(plane.normal.dot(q0 - q1));
                if approach > self.impact { self.restitution * approach } else { 0.0 }
            });
            let response = respond(plane, q0, q1, end, self.recovery, candidate.load, friction, rise);
            if !response.end.is_finite() {
                continue;
            }
            candidate.load = response.load;
            candidate.plane = plane;
            contacts += 1;
            // As differences: a particle that stays keeps its bits.
            let mut by = self.motion.rotation1 * (response.end - q1);
            let mut silent = Vec3A::ZERO;
            if response.shift != Vec3A::ZERO {
                silent = self.motion.rotation0 * response.shift;
            }
            if let Some(rigid) = &mut self.rigid
                && by != Vec3A::ZERO
            {
                let at = self.motion.rotation1 * response.end + self.motion.translation1;
                (by, silent) = rigid.split(position.w, at, by, silent);
            }
            *position += by.extend(0.0);
            if silent != Vec3A::ZERO {
                *before += silent.extend(0.0);
            }
            if COSTLY && let Some(place) = particles.places.get_mut(k) {
                *place = response.end.into();
            }
        }
        if let Some(rigid) = self.rigid {
            rigid.finish();
        }
        contacts
    }
}

impl Setting<'_> {
    /// Where a particle belongs that was moved through a surface since it was last known at `last`: by cloth that pushes cloth, or by what
    /// takes tangles apart.
    fn strayed(&self, sample: &impl Fn(Vec3A, f32) -> Sample, last: Vec3A, q0: Vec3A, q1: Vec3A) -> Option<Swept> {
        let off = last.distance(q0);
        // False for a place that is not known.
        if !(off > MOVED * self.keep && off < TELEPORTED * self.keep) {
            return None;
        }
        let from = (last, sample(last, self.keep + off));
        if !(from.1.distance > 0.0 && off >= from.1.distance) {
            return None;
        }
        sweep(sample, from, q0, MOVED * self.keep)?;
        sweep(sample, from, q1, self.keep)
    }
}

/// Bound on the way of any particle in the frame `[m]`.
fn farthest_way(positions: &[Vec4], previous: &[Vec4], approach: &Approach) -> f32 {
    let mut fastest2 = 0.0_f32;
    if approach.substep > 0.0 {
        for (p, q) in positions.iter().zip(previous) {
            let way2 = (*p - *q).truncate().length_squared();
            if way2 < f32::MAX {
                fastest2 = fastest2.max(way2);
            }
        }
        fastest2 = fastest2.sqrt() / approach.substep;
    }
    let way = fastest2 * approach.dt + approach.gravity.length() * approach.dt * approach.dt + approach.extra.max(0.0);
    if way.is_finite() { way } else { f32::MAX.sqrt() }
}
