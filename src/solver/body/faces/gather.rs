//! Lists, once per frame, what may meet each part that is finer than the mesh.

use parry3d::shape::{Shape, TypedShape};

use super::list::Sheet;
use super::memory::remember;
use super::piece::PIECES;
use super::{FaceContacts, Part, SHARE};
use crate::solver::body::feature_edges::FeatureEdge;
use crate::solver::body::motion::{farthest_push, finite_or_zero, swept_box, valid};
use crate::solver::body::{Body, geometry};

impl FaceContacts {
    /// Once per frame of `dt` `[s]`, before its first substep: lists the faces that could reach a part that is fine for them.
    /// `way`: bound on the way of any particle `[m]`.
    pub(crate) fn gather(&mut self, bodies: &[Body], sheet: &Sheet<'_>, way: f32, dt: f32) {
        core::mem::swap(&mut self.parts, &mut *self.parts_before);
        core::mem::swap(&mut self.candidates, &mut *self.candidates_before);
        core::mem::swap(&mut self.feature_edges, &mut *self.feature_edges_before);
        self.parts.clear();
        self.planes.clear();
        self.candidates.clear();
        self.is_listed = false;
        self.blocks.clear();
        self.feature_edges.clear();
        self.feature_edges.push(FeatureEdge::default());
        self.edge_cache.begin();
        self.dt = dt;
        let passes = dt > 0.0;
        if !passes {
            return;
        }
        let thickness = finite_or_zero(sheet.thickness);
        let way = way + farthest_push(bodies);
        let mut known = 0;
        for (b, body) in (0_u32..).zip(bodies) {
            let (Some(from), Some(to)) = (valid(body.from), valid(body.to)) else {
                continue;
            };
            let keep = thickness + finite_or_zero(body.margin);
            let off = if body.rigid.is_some() { way } else { 0.0 };
            geometry::for_each_part(&*body.shape.0, |index, local, shape| {
                let Some(local) =
                    valid(local).filter(|_| is_fine(smallest_radius(shape), sheet.longest_edge, keep, body.rigid.is_some()))
                else {
                    return;
                };
                let (from, to) = (from * local, to * local);
                let (swept, bulge, radius) = swept_box(shape, &from, &to);
                let reach = way + off + keep + bulge;
                let first = self.candidates.len() as u32;
                let is_convex = shape.as_support_map().is_some();
                if is_convex {
                    let is_round = matches!(shape.as_typed_shape(), TypedShape::Ball(_) | TypedShape::Capsule(_));
                    self.list(sheet, is_round.then_some(0), swept.mins - reach, swept.maxs + reach);
                } else {
                    self.list_feature_edges(sheet, (&body.shape, [b, index], shape), (&from, &to), reach, keep);
                }
                let candidates = (first, self.candidates.len() as u32);
                if candidates.1 == candidates.0 {
                    return;
                }
                while self.parts_before.get(known).is_some_and(|p| (p.body, p.index) < (b, index)) {
                    known += 1;
                }
                if let Some(before) = self.parts_before.get(known).filter(|p| (p.body, p.index) == (b, index)) {
                    let was = (&self.candidates_before[..], &self.feature_edges_before[..]);
                    remember(was, before.candidates, &mut self.candidates[first as usize..], &self.feature_edges);
                }
                if body.snug.is_some() {
                    // Where cloth is that close its particles tell all there is to know.
                    let is_snug = |particles: &[u32; 3]| particles.iter().any(|&p| body.inset(p, keep) > 0.0);
                    let listed = self.candidates[first as usize..].iter_mut();
                    listed.filter(|candidate| is_snug(&candidate.particles)).for_each(|candidate| {
                        (candidate.left_out, candidate.load) = (true, 0.0);
                    });
                }
                let first_plane = self.planes.len() as u32;
                if let TypedShape::ConvexPolyhedron(polyhedron) = shape.as_typed_shape() {
                    geometry::hull_planes(polyhedron, &mut self.planes);
                }
                let planes = (first_plane, self.planes.len() as u32);
                let pierces = smallest_radius(shape) < sheet.longest_edge;
                self.parts.push(Part { body: b, index, local, planes, candidates, radius, pierces });
            });
        }
        self.squeezes.begin(self.parts.len(), PIECES as usize * sheet.topology.faces.len());
    }
}

/// Smallest radius of curvature of a shape `[m]`; infinite for those that faces are not looked at for.
fn smallest_radius(shape: &dyn Shape) -> f32 {
    match shape.as_typed_shape() {
        TypedShape::HalfSpace(_) => f32::INFINITY,
        TypedShape::Ball(ball) => ball.radius,
        TypedShape::Capsule(capsule) => capsule.radius,
        TypedShape::TriMesh(_) | TypedShape::HeightField(_) => 0.0,
        _ if shape.as_support_map().is_some() => 0.0,
        _ => f32::INFINITY,
    }
}

/// Whether particles alone would let a shape of that radius through a mesh with edges of `edge` `[m]` that is kept `keep` `[m]`
/// away.
fn is_fine(radius: f32, edge: f32, keep: f32, yields: bool) -> bool {
    // One that cloth moves would not come to rest on faces: only what is smaller than they are.
    edge * edge > 8.0 * (radius + keep) * (1.0 - SHARE) * keep && (!yields || edge > radius)
}
