//! Shapes from anything a user may pass: a valid shape, or one line that says what is wrong. Nothing here panics.
//!
//! parry's own constructors index out of bounds on bad indices and assert on flat or non-finite input, so everything is checked
//! before.

use glam::Vec3;
use parry3d::bounding_volume::Aabb;
use parry3d::math::Pose;
use parry3d::shape::{Compound, ConvexPolyhedron, HeightField, SharedShape, TriMesh, TriMeshFlags, TypedShape};
use parry3d::utils::Array2;

use crate::solver::scales::FARTHEST;

/// Coordinates of triangles that are nearer to zero are zero `[m]`: parry divides by how far apart their middles are, which
/// overflows, and panics.
const NOTHING: f32 = 1.0e-29;
/// Smallest size of a primitive and of a triangle's height `[m]`.
const SMALLEST: f32 = 1.0e-6;
/// Segments of a round primitive that is scaled unevenly and becomes a convex hull.
const SUBDIVISIONS: u32 = 24;

/// Why a shape could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ShapeError {
    /// A size is zero, negative, not finite or over 1000 km.
    #[error("{what} is {value}: it must be between 1e-6 and 1e6 m")]
    Size {
        /// Which size.
        what: &'static str,
        /// What was given `[m]`.
        value: f32,
    },
    /// A vector without a direction.
    #[error("the normal of a half-space must be finite and not zero")]
    Normal,
    /// A point is not finite or over 1000 km away.
    #[error("point {index} is not finite or beyond 1e6 m")]
    Point {
        /// Index of the first bad point.
        index: usize,
    },
    /// Every triangle was dropped: bad indices, or no area.
    #[error("no triangle is left of {given}: {out_of_range} had an index past the end, {degenerate} had no area")]
    NoTriangle {
        /// Triangles given.
        given: usize,
        /// Triangles with an index past the end.
        out_of_range: usize,
        /// Triangles without area.
        degenerate: usize,
    },
    /// The points of a convex hull span no volume.
    #[error("{points} points span no volume: a convex hull needs four points that are not in one plane")]
    Flat {
        /// Points given.
        points: usize,
    },
    /// The grid of a height field does not have the stated size.
    #[error("a height field of {rows} x {columns} needs at least 2 x 2 and {rows} x {columns} heights, not {heights}")]
    Grid {
        /// Rows, along Z.
        rows: usize,
        /// Columns, along X.
        columns: usize,
        /// Heights given.
        heights: usize,
    },
    /// A compound without parts.
    #[error("a compound needs at least one part")]
    Empty,
    /// A part of a compound has a pose that is not finite.
    #[error("part {index} of a compound has a pose that is not finite")]
    Pose {
        /// Index of the part.
        index: usize,
    },
    /// A part of a compound is itself made of parts.
    #[error(
        "part {index} of a compound is a triangle mesh, height field, polyline, voxels or compound: give it a body of its own"
    )]
    Nested {
        /// Index of the part.
        index: usize,
    },
    /// A scale of zero, or not finite.
    #[error("scale {0} is zero or not finite in an axis")]
    Scale(Vec3),
    /// A shape that cannot be scaled unevenly.
    #[error("this kind of shape cannot be scaled by {0}")]
    NotScalable(Vec3),
}

fn size(what: &'static str, value: f32) -> Result<f32, ShapeError> {
    if (SMALLEST..=FARTHEST).contains(&value) { Ok(value) } else { Err(ShapeError::Size { what, value }) }
}

fn points(points: &[Vec3]) -> Result<(), ShapeError> {
    match points.iter().position(|&p| !finite(p)) {
        Some(index) => Err(ShapeError::Point { index }),
        None => Ok(()),
    }
}

fn finite(p: Vec3) -> bool {
    // `max_element` alone may hide a NaN.
    p.is_finite() && p.abs().max_element() <= FARTHEST
}

/// A ball around the origin.
pub fn ball(radius: f32) -> Result<SharedShape, ShapeError> {
    Ok(SharedShape::ball(size("radius", radius)?))
}

/// All points within `radius` `[m]` of the segment from `-half_length` to `+half_length` `[m]` on the Y axis. A half length of
/// 0 makes a ball.
pub fn capsule(radius: f32, half_length: f32) -> Result<SharedShape, ShapeError> {
    let radius = size("radius", radius)?;
    if half_length == 0.0 {
        return Ok(SharedShape::ball(radius));
    }
    Ok(SharedShape::capsule_y(size("half length", half_length)?, radius))
}

/// All points within `radius` `[m]` of the segment `a..b` `[m]`.
pub fn capsule_between(a: Vec3, b: Vec3, radius: f32) -> Result<SharedShape, ShapeError> {
    points(&[a, b])?;
    Ok(SharedShape::capsule(a, b, size("radius", radius)?))
}

/// A box with the half extents `[m]` along X, Y and Z.
pub fn cuboid(half_extents: Vec3) -> Result<SharedShape, ShapeError> {
    let x = size("half extent x", half_extents.x)?;
    let y = size("half extent y", half_extents.y)?;
    let z = size("half extent z", half_extents.z)?;
    Ok(SharedShape::cuboid(x, y, z))
}

/// A cylinder along Y `[m]`.
pub fn cylinder(radius: f32, half_height: f32) -> Result<SharedShape, ShapeError> {
    Ok(SharedShape::cylinder(size("half height", half_height)?, size("radius", radius)?))
}

/// A cone along Y `[m]`: apex at `+half_height`, base at `-half_height`.
pub fn cone(radius: f32, half_height: f32) -> Result<SharedShape, ShapeError> {
    Ok(SharedShape::cone(size("half height", half_height)?, size("radius", radius)?))
}

/// Everything under the plane through the origin with this normal, which points out of the body.
pub fn half_space(normal: Vec3) -> Result<SharedShape, ShapeError> {
    let normal = if normal.is_finite() { normal.try_normalize() } else { None };
    Ok(SharedShape::halfspace(normal.ok_or(ShapeError::Normal)?))
}

/// A shape that was made elsewhere, if its sizes are those of a shape.
///
/// # Errors
/// The first size, point or normal that is not.
pub fn checked(shape: SharedShape) -> Result<SharedShape, ShapeError> {
    is_sound(shape.as_typed_shape())?;
    Ok(shape)
}

fn is_sound(shape: TypedShape<'_>) -> Result<(), ShapeError> {
    // No border is none.
    let border = |radius: f32| if radius == 0.0 { Ok(0.0) } else { size("border radius", radius) };
    match shape {
        TypedShape::Ball(s) => size("radius", s.radius).map(drop),
        TypedShape::Capsule(s) => size("radius", s.radius).and(points(&[s.segment.a, s.segment.b])),
        TypedShape::Cuboid(s) => cuboid(s.half_extents).map(drop),
        TypedShape::Cylinder(s) => cylinder(s.radius, s.half_height).map(drop),
        TypedShape::Cone(s) => cone(s.radius, s.half_height).map(drop),
        // Bad ones are far from unit length, or not numbers.
        TypedShape::HalfSpace(s) if s.normal.is_normalized() => Ok(()),
        TypedShape::HalfSpace(_) => Err(ShapeError::Normal),
        TypedShape::Segment(s) => points(&[s.a, s.b]),
        TypedShape::Triangle(s) => points(&[s.a, s.b, s.c]),
        TypedShape::TriMesh(s) => points(s.vertices()),
        TypedShape::Polyline(s) => points(s.vertices()),
        TypedShape::ConvexPolyhedron(s) => points(s.points()),
        TypedShape::Compound(s) => s.shapes().iter().enumerate().try_for_each(|(index, (pose, part))| {
            if !(pose.translation.is_finite() && pose.rotation.is_finite()) {
                return Err(ShapeError::Pose { index });
            }
            is_sound(part.as_typed_shape())
        }),
        TypedShape::RoundCuboid(s) => border(s.border_radius).and(cuboid(s.inner_shape.half_extents)).map(drop),
        TypedShape::RoundTriangle(s) => {
            border(s.border_radius).and(points(&[s.inner_shape.a, s.inner_shape.b, s.inner_shape.c]))
        }
        TypedShape::RoundCylinder(s) => {
            border(s.border_radius).and(cylinder(s.inner_shape.radius, s.inner_shape.half_height)).map(drop)
        }
        TypedShape::RoundCone(s) => {
            border(s.border_radius).and(cone(s.inner_shape.radius, s.inner_shape.half_height)).map(drop)
        }
        TypedShape::RoundConvexPolyhedron(s) => border(s.border_radius).and(points(s.inner_shape.points())),
        TypedShape::HeightField(s) => box_of(s.local_aabb()),
        TypedShape::Voxels(s) => box_of(s.local_aabb()),
        TypedShape::Custom(s) => box_of(s.compute_local_aabb()),
    }
}

/// Whether the box around a shape is one.
fn box_of(bounds: Aabb) -> Result<(), ShapeError> {
    points(&[bounds.mins, bounds.maxs])
}

/// The convex hull of a cloud of points `[m]`.
pub fn convex_hull(cloud: &[Vec3]) -> Result<SharedShape, ShapeError> {
    points(cloud)?;
    let flat = ShapeError::Flat { points: cloud.len() };
    if !spans_volume(cloud) {
        return Err(flat);
    }
    let hull = ConvexPolyhedron::from_convex_hull(&distinct(cloud)).ok_or(flat)?;
    Ok(SharedShape::new(hull))
}

/// Points of a cloud without those within 1e-5 of its size of another, in the order given. Near duplicates make quickhull fail.
fn distinct(cloud: &[Vec3]) -> Vec<Vec3> {
    let (low, high) = cloud.iter().fold((Vec3::MAX, Vec3::MIN), |(l, h), &p| (l.min(p), h.max(p)));
    let cell = ((high - low).max_element() * 1.0e-5).max(f32::MIN_POSITIVE);
    let mut keyed: Vec<([i32; 3], usize)> =
        cloud.iter().enumerate().map(|(i, &p)| (((p - low) / cell).round().as_ivec3().to_array(), i)).collect();
    keyed.sort_unstable();
    keyed.dedup_by_key(|(key, _)| *key);
    let mut kept: Vec<usize> = keyed.into_iter().map(|(_, i)| i).collect();
    kept.sort_unstable();
    kept.into_iter().filter_map(|i| cloud.get(i).copied()).collect()
}

/// Four points that are far from one plane, relative to the cloud's size.
fn spans_volume(cloud: &[Vec3]) -> bool {
    let Some(&a) = cloud.first() else {
        return false;
    };
    let farthest =
        |measure: &dyn Fn(Vec3) -> f32| cloud.iter().copied().max_by(|&p, &q| measure(p).total_cmp(&measure(q))).unwrap_or(a);
    let b = farthest(&|p| p.distance_squared(a));
    let ab = b - a;
    let length = ab.length();
    let long = length > SMALLEST;
    if !long {
        return false;
    }
    let along = ab / length;
    let c = farthest(&|p| (p - a).reject_from_normalized(along).length_squared());
    let ac = (c - a).reject_from_normalized(along);
    let Some(across) = ac.try_normalize() else {
        return false;
    };
    let normal = along.cross(across);
    let d = farthest(&|p| (p - a).dot(normal).abs());
    let least = 1.0e-5 * length;
    ac.length() > least && (d - a).dot(normal).abs() > least
}

/// A triangle mesh with two sides `[m]`: the cloth stays on the side it came from, and the mesh may be open.
/// Triangles with an index past the end and triangles without area are dropped.
pub fn trimesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<SharedShape, ShapeError> {
    trimesh_with(vertices, triangles, TriMeshFlags::empty())
}

/// A closed triangle mesh with an inside `[m]`, wound counter-clockwise seen from outside: cloth that starts inside is brought
/// out. A mesh that is not closed or not manifold has no inside; use [`trimesh`].
pub(crate) fn solid_trimesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<SharedShape, ShapeError> {
    trimesh_with(vertices, triangles, TriMeshFlags::ORIENTED)
}

fn trimesh_with(vertices: Vec<Vec3>, mut triangles: Vec<[u32; 3]>, flags: TriMeshFlags) -> Result<SharedShape, ShapeError> {
    let given = triangles.len();
    let (mut out_of_range, mut degenerate) = (0, 0);
    let mut bad_point = None;
    triangles.retain(|triangle| {
        let corners = triangle.map(|i| vertices.get(i as usize).copied());
        let [Some(a), Some(b), Some(c)] = corners else {
            out_of_range += 1;
            return false;
        };
        if let Some(k) = [a, b, c].iter().position(|&p| !finite(p)) {
            bad_point = bad_point.or(triangle.get(k).map(|&i| i as usize));
            return false;
        }
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        let has_area = (b - a).cross(c - a).length() > SMALLEST.max(1.0e-6 * longest) * longest;
        degenerate += usize::from(!has_area);
        has_area
    });
    if let Some(index) = bad_point {
        return Err(ShapeError::Point { index });
    }
    // Vertices that no triangle uses may be anything: they must not reach the bounding boxes.
    let settled = |p: Vec3| Vec3::select(p.abs().cmplt(Vec3::splat(NOTHING)), Vec3::ZERO, p);
    let vertices = vertices.into_iter().map(|p| if finite(p) { settled(p) } else { Vec3::ZERO }).collect();
    match TriMesh::with_flags(vertices, triangles, flags) {
        Ok(mesh) => Ok(SharedShape::new(mesh)),
        Err(_) => Err(ShapeError::NoTriangle { given, out_of_range, degenerate }),
    }
}

/// A terrain with two sides: `rows x columns` heights, row by row along Z, each row along X. They stand over a rectangle of
/// `extent.x` by `extent.z` `[m]` around the origin. Heights are multiplied by `extent.y`.
pub fn heightfield(rows: usize, columns: usize, heights: &[f32], extent: Vec3) -> Result<SharedShape, ShapeError> {
    if rows < 2 || columns < 2 || rows.checked_mul(columns) != Some(heights.len()) || heights.len() > (1 << 30) {
        return Err(ShapeError::Grid { rows, columns, heights: heights.len() });
    }
    let extent = Vec3::new(size("extent x", extent.x)?, size("height scale", extent.y)?, size("extent z", extent.z)?);
    if let Some(index) = heights.iter().position(|&h| !finite(Vec3::splat(h * extent.y))) {
        return Err(ShapeError::Point { index });
    }
    // parry stores columns one after the other.
    let mut by_column = Vec::with_capacity(heights.len());
    for column in 0..columns {
        by_column.extend(heights.iter().skip(column).step_by(columns).copied());
    }
    Ok(SharedShape::new(HeightField::new(Array2::new(rows, columns, by_column), extent)))
}

/// Several simple shapes that move as one.
pub fn compound(parts: Vec<(Pose, SharedShape)>) -> Result<SharedShape, ShapeError> {
    if parts.is_empty() {
        return Err(ShapeError::Empty);
    }
    for (index, (pose, part)) in parts.iter().enumerate() {
        let is_unit = (0.5..2.0).contains(&pose.rotation.length_squared());
        if !finite(pose.translation) || !is_unit {
            return Err(ShapeError::Pose { index });
        }
        if part.as_composite_shape().is_some()
            || matches!(part.as_typed_shape(), TypedShape::HeightField(_) | TypedShape::Voxels(_))
        {
            return Err(ShapeError::Nested { index });
        }
    }
    Ok(SharedShape::new(Compound::new(parts)))
}

/// The shape scaled by a body's world scale along its own axes. Negative scales mirror. Round primitives under an uneven scale
/// become convex hulls.
pub fn scaled(shape: &SharedShape, scale: Vec3) -> Result<SharedShape, ShapeError> {
    if scale == Vec3::ONE {
        return Ok(shape.clone());
    }
    if !(scale.is_finite() && scale.abs().min_element() > 0.0) {
        return Err(ShapeError::Scale(scale));
    }
    let s = scale.abs();
    let even = s.max_element() - s.min_element() <= 1.0e-4 * s.max_element();
    let around_y = (s.x - s.z).abs() <= 1.0e-4 * s.max_element();
    match shape.as_typed_shape() {
        TypedShape::Ball(b) if even => ball(b.radius * s.x),
        TypedShape::Capsule(c) if even => capsule_between(c.segment.a * scale, c.segment.b * scale, c.radius * s.x),
        TypedShape::Cuboid(c) => cuboid(c.half_extents * s),
        TypedShape::Cylinder(c) if around_y => cylinder(c.radius * s.x, c.half_height * s.y),
        TypedShape::Cone(c) if around_y && scale.y > 0.0 => cone(c.radius * s.x, c.half_height * s.y),
        // Normals scale with the inverse.
        TypedShape::HalfSpace(h) => half_space(h.normal / scale),
        TypedShape::Ball(b) => hull_of(b.to_trimesh(SUBDIVISIONS, SUBDIVISIONS).0, scale),
        TypedShape::Capsule(c) => hull_of(c.to_trimesh(SUBDIVISIONS, SUBDIVISIONS).0, scale),
        TypedShape::Cylinder(c) => hull_of(c.to_trimesh(SUBDIVISIONS).0, scale),
        TypedShape::Cone(c) => hull_of(c.to_trimesh(SUBDIVISIONS).0, scale),
        TypedShape::ConvexPolyhedron(p) => hull_of(p.points().to_vec(), scale),
        TypedShape::TriMesh(m) => {
            let vertices = m.vertices().iter().map(|&p| p * scale).collect();
            trimesh_with(vertices, wound(m.indices(), scale), m.flags() & TriMeshFlags::ORIENTED)
        }
        TypedShape::HeightField(h) if scale.min_element() > 0.0 => {
            let extent = h.scale() * scale;
            size("extent", extent.min_element())?;
            size("extent", extent.max_element())?;
            Ok(SharedShape::new(h.clone().scaled(scale)))
        }
        TypedShape::HeightField(h) => {
            let (vertices, triangles) = h.to_trimesh();
            trimesh(vertices.into_iter().map(|p| p * scale).collect(), wound(&triangles, scale))
        }
        TypedShape::Compound(c) => {
            let parts = c.shapes().iter().map(|(pose, part)| scaled_part(*pose, part, scale));
            compound(parts.collect::<Result<_, _>>()?)
        }
        _ if even && scale.min_element() > 0.0 => {
            shape.scale_dyn(scale, SUBDIVISIONS).map(|s| SharedShape(s.into())).ok_or(ShapeError::NotScalable(scale))
        }
        _ => Err(ShapeError::NotScalable(scale)),
    }
}

/// A part of a compound. An uneven scale shears a turned part, which only a hull of its points can be: the turn is baked into
/// them.
fn scaled_part(pose: Pose, part: &SharedShape, scale: Vec3) -> Result<(Pose, SharedShape), ShapeError> {
    let even = scale.max_element() - scale.min_element() <= 1.0e-4 * scale.abs().max_element();
    if even && scale.x > 0.0 {
        return Ok((Pose::from_parts(pose.translation * scale.x, pose.rotation), scaled(part, scale)?));
    }
    if pose.rotation.is_near_identity() {
        return Ok((Pose::from_translation(pose.translation * scale), scaled(part, scale)?));
    }
    let points = match part.as_typed_shape() {
        TypedShape::HalfSpace(h) => {
            // The plane n · x = n · t under x' = S x.
            let normal = pose.rotation * h.normal;
            return Ok((Pose::from_translation(pose.translation * scale), half_space(normal / scale)?));
        }
        TypedShape::Ball(b) => b.to_trimesh(SUBDIVISIONS, SUBDIVISIONS).0,
        TypedShape::Capsule(c) => c.to_trimesh(SUBDIVISIONS, SUBDIVISIONS).0,
        TypedShape::Cuboid(c) => c.to_trimesh().0,
        TypedShape::Cylinder(c) => c.to_trimesh(SUBDIVISIONS).0,
        TypedShape::Cone(c) => c.to_trimesh(SUBDIVISIONS).0,
        TypedShape::ConvexPolyhedron(p) => p.points().to_vec(),
        _ => return Err(ShapeError::NotScalable(scale)),
    };
    let turned = points.into_iter().map(|p| pose * p).collect();
    Ok((Pose::IDENTITY, hull_of(turned, scale)?))
}

fn hull_of(points: Vec<Vec3>, scale: Vec3) -> Result<SharedShape, ShapeError> {
    let scaled: Vec<Vec3> = points.into_iter().map(|p| p * scale).collect();
    convex_hull(&scaled)
}

/// Triangles wound so that a mirrored mesh keeps its outside.
fn wound(triangles: &[[u32; 3]], scale: Vec3) -> Vec<[u32; 3]> {
    let mirrored = scale.x * scale.y * scale.z < 0.0;
    triangles.iter().map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    fn corners() -> Vec<Vec3> {
        (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32)).collect()
    }

    #[test]
    fn triangles_whose_middles_are_next_to_nothing_apart_are_a_mesh() {
        let mut quad: Vec<Vec3> =
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, z]| Vec3::new(x, 0.0, z)).into();
        quad[3].y = f32::from_bits(223);
        assert!(trimesh(quad, vec![[0, 1, 2], [0, 2, 3]]).is_ok());
    }

    #[test]
    fn every_bad_input_is_an_error_with_its_reason_and_never_a_panic() {
        let nan = f32::NAN;
        let flat: Vec<Vec3> = corners().into_iter().map(|p| p * Vec3::new(1.0, 0.0, 1.0)).collect();
        let line: Vec<Vec3> = (0..9).map(|i| Vec3::X * i as f32).collect();
        let ball_shape = ball(1.0).unwrap();
        let mesh = trimesh(corners(), vec![[0, 1, 2]]).unwrap();
        let bad_pose = Pose::from_parts(Vec3::splat(nan), Quat::IDENTITY);
        let cases = [
            ("ball", ball(0.0)),
            ("ball", ball(nan)),
            ("ball", ball(-1.0)),
            ("ball", ball(f32::INFINITY)),
            ("capsule", capsule(1.0, -1.0)),
            ("capsule", capsule_between(Vec3::splat(nan), Vec3::ZERO, 1.0)),
            ("cuboid", cuboid(Vec3::new(1.0, 0.0, 1.0))),
            ("cylinder", cylinder(1.0, nan)),
            ("cone", cone(nan, 1.0)),
            ("half-space", half_space(Vec3::ZERO)),
            ("half-space", half_space(Vec3::new(0.0, nan, 0.0))),
            ("hull", convex_hull(&[])),
            ("hull", convex_hull(&corners()[..3])),
            ("hull", convex_hull(&flat)),
            ("hull", convex_hull(&line)),
            ("hull", convex_hull(&[Vec3::ZERO; 20])),
            ("hull", convex_hull(&[Vec3::splat(nan), Vec3::X, Vec3::Y, Vec3::Z])),
            ("mesh", trimesh(vec![], vec![])),
            ("mesh", trimesh(corners(), vec![])),
            ("mesh", trimesh(corners(), vec![[0, 1, 99]])),
            ("mesh", trimesh(corners(), vec![[0, 1, 1]])),
            ("mesh", trimesh(vec![Vec3::splat(nan), Vec3::X, Vec3::Y], vec![[0, 1, 2]])),
            ("height field", heightfield(1, 5, &[0.0; 5], Vec3::ONE)),
            ("height field", heightfield(3, 3, &[0.0; 8], Vec3::ONE)),
            ("height field", heightfield(usize::MAX, 2, &[0.0; 8], Vec3::ONE)),
            ("height field", heightfield(2, 2, &[0.0, nan, 0.0, 0.0], Vec3::ONE)),
            ("height field", heightfield(2, 2, &[0.0; 4], Vec3::new(0.0, 1.0, 1.0))),
            ("compound", compound(vec![])),
            ("compound", compound(vec![(bad_pose, ball_shape.clone())])),
            ("compound", compound(vec![(Pose::IDENTITY, mesh.clone())])),
            ("round cylinder", checked(SharedShape::round_cylinder(0.2, 0.2, -0.1))),
            ("round cuboid", checked(SharedShape::round_cuboid(0.2, nan, 0.2, 0.1))),
            ("made elsewhere", checked(SharedShape::ball(-1.0))),
            ("made elsewhere", checked(SharedShape::halfspace(Vec3::new(0.0, 3.0, 0.0)))),
            ("made elsewhere", checked(SharedShape::halfspace(Vec3::splat(nan)))),
            ("scale", scaled(&ball_shape, Vec3::new(1.0, 0.0, 1.0))),
            ("scale", scaled(&mesh, Vec3::splat(nan))),
        ];
        for (i, (what, result)) in cases.into_iter().enumerate() {
            let reason = result.map(|_| ()).unwrap_err().to_string();
            assert!(reason.len() > 20, "case {i}, {what}: {reason:?}");
        }
    }

    #[test]
    fn bad_triangles_are_dropped_and_the_good_ones_kept() {
        let shape = trimesh(corners(), vec![[0, 1, 2], [0, 1, 99], [3, 3, 4], [4, 5, 6]]).unwrap();
        assert_eq!(shape.as_trimesh().map(TriMesh::num_triangles), Some(2));
    }

    #[test]
    fn a_scaled_shape_has_the_scaled_box() {
        let (a, b) = (Vec3::new(-0.3, 0.0, 0.1), Vec3::new(0.2, 0.5, 0.0));
        let shapes = [
            ("ball", ball(0.5).unwrap()),
            ("capsule", capsule_between(a, b, 0.2).unwrap()),
            ("cuboid", cuboid(Vec3::new(0.1, 0.2, 0.3)).unwrap()),
            ("cylinder", cylinder(0.4, 0.3).unwrap()),
            ("cone", cone(0.4, 0.3).unwrap()),
            ("hull", convex_hull(&corners()).unwrap()),
            ("mesh", trimesh(corners(), vec![[0, 1, 2], [4, 7, 2]]).unwrap()),
            ("height field", heightfield(2, 3, &[0.0, 0.5, 1.0, 0.0, -0.5, 0.2], Vec3::new(1.0, 1.0, 2.0)).unwrap()),
            ("compound", compound(vec![(Pose::translation(0.5, 0.0, 0.0), cone(0.4, 0.3).unwrap())]).unwrap()),
        ];
        for scale in [Vec3::splat(2.0), Vec3::new(2.0, 0.5, 3.0), Vec3::new(1.0, -1.0, 1.0), Vec3::new(-2.0, 1.0, -0.5)] {
            for (name, shape) in &shapes {
                let scaled = scaled(shape, scale).unwrap_or_else(|e| panic!("{name} by {scale}: {e}"));
                let (was, is) = (shape.compute_local_aabb(), scaled.compute_local_aabb());
                let (low, high) = ((was.mins * scale).min(was.maxs * scale), (was.mins * scale).max(was.maxs * scale));
                let error = (is.mins - low).abs().max((is.maxs - high).abs()).max_element();
                assert!(error < 0.02, "{name} by {scale}: box {:?} .. {:?}, wanted {low} .. {high}", is.mins, is.maxs);
            }
        }
        let slope = half_space(Vec3::new(1.0, 1.0, 0.0)).unwrap();
        let normal = scaled(&slope, Vec3::new(2.0, 1.0, 1.0)).unwrap().as_halfspace().unwrap().normal;
        assert!((normal - Vec3::new(1.0, 2.0, 0.0).normalize()).length() < 1.0e-6, "{normal}");
    }
}
