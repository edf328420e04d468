//! Lists, once per frame, the particles that could reach each part of a body.

use glam::{Vec3, Vec4};
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose;
use parry3d::shape::{Shape, TypedShape};

use super::{BodyContacts, Candidate, Part};
use crate::solver::body::motion::{farthest_push, finite_or_zero, swept_box, valid};
use crate::solver::body::respond::Plane;
use crate::solver::body::{Body, geometry};

/// What a frame may bring: the bound on how far a particle can get.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Approach {
    /// Length of the frame `[s]`.
    pub dt: f32,
    /// Length of the substep that lies between `previous` and `positions` `[s]`; 0 or less: the cloth is at rest.
    pub substep: f32,
    /// Gravity `[m/s²]`.
    pub gravity: Vec3,
    /// Thickness of the fabric `[m]`.
    pub thickness: f32,
    /// Distance beyond ballistic motion that a particle may be dragged in the frame `[m]`. Examples are the longest way of an
    /// anchor, and of the wind (`Wind::fastest() · dt`). 0 if unknown.
    pub extra: f32,
}

impl BodyContacts {
    /// Once per frame, before its first substep: pairs each body with the particles that could reach it.
    ///
    /// A particle is a candidate when it lies in the box around the shape at both ends of the frame. The box is widened by how
    /// far any particle can get: `v dt + |g| dt² + b + extra + 2 thickness`. Here `v` is the fastest particle's speed and `b`
    /// the longest way of a body, which may push a particle against another body. Pinned (`w = 0`) and non-finite particles
    /// never are.
    pub(crate) fn gather(&mut self, bodies: &[Body], positions: &[Vec4], previous: &[Vec4], approach: &Approach) {
        core::mem::swap(&mut self.parts, &mut *self.parts_before);
        core::mem::swap(&mut self.candidates, &mut *self.candidates_before);
        core::mem::swap(&mut self.places, &mut *self.places_before);
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
                    if body.snug.is_some() {
                        let keep = thickness + finite_or_zero(body.margin);
                        let listed = &mut self.candidates[first as usize..];
                        listed.iter_mut().for_each(|candidate| candidate.inset = body.inset(candidate.particle, keep));
                    }
                    let planes = (first_plane, self.planes.len() as u32);
                    let places = self.remember((b, index), &mut known, candidates, is_two_sided(shape));
                    self.parts.push(Part { body: b, index, local, planes, candidates, places, radius });
                }
            });
        }
        self.squeezes.begin(self.parts.len(), positions.len());
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
}

impl Candidate {
    fn new(particle: u32) -> Self {
        Self {
            particle,
            load: 0.0,
            plane: Plane::default(),
            floor: 0.0,
            start: Vec3::ZERO,
            previous: Vec3::ZERO,
            clear_at: Vec3::ZERO,
            clear: f32::NEG_INFINITY,
            inset: 0.0,
            left_out: false,
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
