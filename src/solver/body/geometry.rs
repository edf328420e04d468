//! From a parry shape to what the kernels need: the primitive's numbers, or a query on the shape.

use glam::{Vec2, Vec3, Vec3A, Vec4};
use parry3d::math::Pose;
use parry3d::query::PointQuery;
use parry3d::shape::{Compound, ConvexPolyhedron, HeightField, Shape, TriMesh, TypedShape};

use super::distance::{self, Sample};

/// One convex shape, surface or primitive of a body.
#[derive(Clone, Copy)]
pub(super) enum Geometry<'a> {
    Ball { radius: f32 },
    Capsule { a: Vec3A, ab: Vec3A, inverse_length2: f32, radius: f32 },
    Cuboid { half: Vec3A },
    HalfSpace { normal: Vec3A },
    Cylinder { half_height: f32, radius: f32 },
    Cone { half_height: f32, radius: f32, side: Vec2 },
    Hull { planes: &'a [Vec4], polyhedron: &'a ConvexPolyhedron },
    Mesh { mesh: &'a TriMesh, solid: bool },
    Heights { field: &'a HeightField },
    Other { shape: &'a dyn Shape },
}

impl<'a> Geometry<'a> {
    /// A capsule from `a` to `b` `[m]`.
    pub(super) fn capsule(a: Vec3, b: Vec3, radius: f32) -> Self {
        let ab = Vec3A::from(b - a);
        let length2 = ab.length_squared();
        let inverse_length2 = if length2 > 1.0e-20 { 1.0 / length2 } else { 0.0 };
        Self::Capsule { a: a.into(), ab, inverse_length2, radius }
    }

    /// `planes` are those that [`hull_planes`] made of the same shape.
    pub(super) fn of(shape: &'a dyn Shape, planes: &'a [Vec4]) -> Self {
        match shape.as_typed_shape() {
            TypedShape::Ball(s) => Self::Ball { radius: s.radius },
            TypedShape::Capsule(s) => Self::capsule(s.segment.a, s.segment.b, s.radius),
            TypedShape::Cuboid(s) => Self::Cuboid { half: Vec3A::from(s.half_extents) },
            TypedShape::HalfSpace(s) => Self::HalfSpace { normal: s.normal.into() },
            TypedShape::Cylinder(s) => Self::Cylinder { half_height: s.half_height, radius: s.radius },
            TypedShape::Cone(s) => {
                let side = distance::cone_side(s.half_height, s.radius);
                Self::Cone { half_height: s.half_height, radius: s.radius, side }
            }
            TypedShape::ConvexPolyhedron(polyhedron) => Self::Hull { planes, polyhedron },
            TypedShape::TriMesh(mesh) => Self::Mesh { mesh, solid: mesh.pseudo_normals_if_oriented().is_some() },
            TypedShape::HeightField(field) => Self::Heights { field },
            _ => Self::Other { shape },
        }
    }

    /// Distance and normal at a point; no nearer than they are where nothing is within `reach` `[m]`.
    #[inline]
    pub(super) fn sample(&self, q: Vec3A, reach: f32) -> Sample {
        match *self {
            Self::Ball { radius } => distance::ball(q, radius),
            Self::Capsule { a, ab, inverse_length2, radius } => distance::capsule(q, a, ab, inverse_length2, radius),
            Self::Cuboid { half } => distance::cuboid(q, half),
            Self::HalfSpace { normal } => distance::half_space(q, normal),
            Self::Cylinder { half_height, radius } => distance::cylinder(q, half_height, radius),
            Self::Cone { half_height, radius, side } => distance::cone(q, half_height, radius, side),
            Self::Hull { planes, polyhedron } => hull(q, reach, planes, polyhedron),
            Self::Mesh { mesh, solid } => self::mesh(q, reach, mesh, solid),
            Self::Heights { field } => heights(q, reach, field),
            Self::Other { shape } => other(q, reach, shape),
        }
    }

    /// Radius of a ball that fits inside `[m]`: a shorter path through it stays inside. 0 for surfaces.
    pub(super) fn inner_radius(&self) -> f32 {
        match *self {
            Self::Ball { radius } | Self::Capsule { radius, .. } => radius,
            Self::Cuboid { half } => half.min_element(),
            Self::HalfSpace { .. } => f32::MAX,
            Self::Cylinder { half_height, radius } => half_height.min(radius),
            Self::Cone { half_height, radius, .. } => 0.5 * half_height.min(radius),
            // The hull's own origin may be outside of it: no promise.
            Self::Hull { .. } | Self::Mesh { .. } | Self::Heights { .. } | Self::Other { .. } => 0.0,
        }
    }
}

/// Half of the thickness of a part of a body `[m]`: the radius of a ball inside it. For a hull it is half the shortest side of
/// its box, for surfaces 0.
pub(super) fn half_thickness(shape: &dyn Shape) -> f32 {
    match shape.as_typed_shape() {
        TypedShape::ConvexPolyhedron(_) => shape.compute_local_aabb().half_extents().min_element(),
        _ => Geometry::of(shape, &[]).inner_radius(),
    }
}

/// Faces of a hull as `(n, c)`, `n · q = c`.
pub(super) fn hull_planes(polyhedron: &ConvexPolyhedron, planes: &mut Vec<Vec4>) {
    for face in polyhedron.faces() {
        let corner = polyhedron
            .vertices_adj_to_face()
            .get(face.first_vertex_or_edge as usize)
            .and_then(|&vertex| polyhedron.points().get(vertex as usize));
        if let Some(&corner) = corner {
            planes.push(face.normal.extend(face.normal.dot(corner)));
        }
    }
}

/// Distance to a convex hull. Inside it is that to the nearest face. Outside, that is a lower bound, and only points closer
/// than `reach` pay for the exact distance to edges and vertices (GJK).
pub(super) fn hull(q: Vec3A, reach: f32, planes: &[Vec4], polyhedron: &ConvexPolyhedron) -> Sample {
    let mut best = Vec4::new(0.0, 1.0, 0.0, 0.0);
    let mut highest = f32::MIN;
    for &plane in planes {
        let height = Vec3A::from_vec4(plane).dot(q) - plane.w;
        if height > highest {
            highest = height;
            best = plane;
        }
    }
    if planes.is_empty() {
        return Sample::beyond(reach);
    }
    if highest >= reach {
        return Sample::beyond(highest);
    }
    if highest > 1.0e-5 {
        let nearest = Vec3A::from(polyhedron.project_local_point(q.into(), true).point);
        let away = q - nearest;
        let length = away.length();
        if length > highest && length.is_finite() {
            return Sample { distance: length, normal: away / length };
        }
    }
    Sample { distance: highest, normal: Vec3A::from_vec4(best) }
}

/// Distance by projection, two-sided unless the mesh is a solid.
pub(super) fn mesh(q: Vec3A, reach: f32, mesh: &TriMesh, solid: bool) -> Sample {
    // Inside a solid the surface may be further away than the reach.
    let far = if solid { reach.max(mesh.local_aabb().half_extents().min_element()) } else { reach };
    let Some(nearest) = mesh.project_local_point_with_max_dist(q.into(), false, far) else {
        return Sample::beyond(reach);
    };
    away_from(q, reach, nearest.point.into(), solid && nearest.is_inside)
}

/// Two-sided distance to a height field.
pub(super) fn heights(q: Vec3A, reach: f32, field: &HeightField) -> Sample {
    match field.project_local_point_with_max_dist(q.into(), false, reach) {
        Some(nearest) => away_from(q, reach, nearest.point.into(), false),
        None => Sample::beyond(reach),
    }
}

/// Distance to any other shape of parry.
pub(super) fn other(q: Vec3A, reach: f32, shape: &dyn Shape) -> Sample {
    let nearest = shape.project_local_point(q.into(), false);
    away_from(q, reach, nearest.point.into(), nearest.is_inside)
}

fn away_from(q: Vec3A, reach: f32, nearest: Vec3A, inside: bool) -> Sample {
    let away = q - nearest;
    let length = away.length();
    if !length.is_finite() {
        return Sample::beyond(reach);
    }
    let normal = away / length.max(1.0e-12);
    if length < 1.0e-9 {
        // On the surface: no direction, and no side to lose.
        return Sample { distance: 0.0, normal: Vec3A::ZERO };
    }
    if inside { Sample { distance: -length, normal: -normal } } else { Sample { distance: length, normal } }
}

/// Calls `visit` for each simple part of a shape: itself, or the parts of a compound.
pub(super) fn for_each_part(shape: &dyn Shape, mut visit: impl FnMut(u32, Pose, &dyn Shape)) {
    if let Some(compound) = shape.as_shape::<Compound>() {
        for (i, (pose, part)) in (0_u32..).zip(compound.shapes()) {
            visit(i, *pose, &*part.0);
        }
    } else {
        visit(0, Pose::IDENTITY, shape);
    }
}

/// As [`for_each_part`], with what is sampled of each part. `planes` is a buffer.
pub(super) fn for_each_geometry(
    shape: &dyn Shape,
    planes: &mut Vec<Vec4>,
    mut visit: impl FnMut(u32, Pose, &dyn Shape, Geometry<'_>),
) {
    for_each_part(shape, |i, local, part| {
        planes.clear();
        if let Some(polyhedron) = part.as_convex_polyhedron() {
            hull_planes(polyhedron, planes);
        }
        visit(i, local, part, Geometry::of(part, planes));
    });
}

/// Part `i` of a shape, as [`for_each_part`] numbers them.
pub(super) fn part(shape: &dyn Shape, i: u32) -> Option<&dyn Shape> {
    match shape.as_shape::<Compound>() {
        Some(compound) => compound.shapes().get(i as usize).map(|(_, part)| &*part.0),
        None => (i == 0).then_some(shape),
    }
}
