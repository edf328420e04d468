//! From a collider's data to a shape of the solver.

use bevy::prelude::*;

use super::read;
use crate::components::{ClothColliderPart, ClothColliderShape, ClothMeshFit};
use crate::solver::body::shape::{self, ShapeError};
use crate::solver::body::{Pose, SharedShape};

/// Why a collider has no shape.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ColliderError {
    /// The mesh it is fitted to is not loaded, or missing.
    #[error("it is fitted to a mesh that is not loaded")]
    NoMesh,
    /// The mesh it is fitted to cannot be read.
    #[error("{0}")]
    Unreadable(String),
    /// The shape is not one.
    #[error("{0}")]
    Shape(#[from] ShapeError),
}

/// The shape, unscaled.
pub(crate) fn shape_of(shape: &ClothColliderShape, mesh: Option<&Mesh>) -> Result<SharedShape, ColliderError> {
    Ok(match shape {
        ClothColliderShape::Ball { radius } => shape::ball(*radius)?,
        ClothColliderShape::Capsule { radius, length } => shape::capsule(*radius, 0.5 * length).map_err(whole)?,
        ClothColliderShape::Cuboid { size } => shape::cuboid(0.5 * *size).map_err(whole)?,
        ClothColliderShape::Cylinder { radius, height } => shape::cylinder(*radius, 0.5 * height).map_err(whole)?,
        ClothColliderShape::Cone { radius, height } => shape::cone(*radius, 0.5 * height).map_err(whole)?,
        ClothColliderShape::HalfSpace { normal } => shape::half_space(*normal)?,
        ClothColliderShape::ConvexHull { points } => shape::convex_hull(points)?,
        ClothColliderShape::TriMesh { vertices, triangles, solid: false } => {
            shape::trimesh(vertices.clone(), triangles.clone())?
        }
        ClothColliderShape::TriMesh { vertices, triangles, solid: true } => {
            shape::solid_trimesh(vertices.clone(), triangles.clone())?
        }
        ClothColliderShape::HeightField { rows, columns, heights, size } => {
            shape::heightfield(*rows as usize, *columns as usize, heights, *size)?
        }
        ClothColliderShape::Compound { parts } => {
            let parts: Result<Vec<_>, ColliderError> = parts.iter().map(|part| part_of(part, mesh)).collect();
            shape::compound(parts?)?
        }
        // A plane needs no mesh.
        ClothColliderShape::Mesh(ClothMeshFit::HalfSpace) => shape::half_space(Vec3::Y)?,
        ClothColliderShape::Mesh(fit) => fitted(*fit, mesh.ok_or(ColliderError::NoMesh)?)?,
        ClothColliderShape::Parry(shape) => shape::checked(shape.0.clone().ok_or(ShapeError::Empty)?)?,
    })
}

/// Names the field that was given: the solver takes halves.
fn whole(error: ShapeError) -> ShapeError {
    let ShapeError::Size { what, value } = error else { return error };
    let what = match what {
        "half extent x" => "size x",
        "half extent y" => "size y",
        "half extent z" => "size z",
        "half length" => "length",
        "half height" => "height",
        _ => return error,
    };
    ShapeError::Size { what, value: 2.0 * value }
}

fn part_of(part: &ClothColliderPart, mesh: Option<&Mesh>) -> Result<(Pose, SharedShape), ColliderError> {
    Ok((Pose::from_parts(part.translation, part.rotation), shape_of(&part.shape, mesh)?))
}

fn fitted(fit: ClothMeshFit, mesh: &Mesh) -> Result<SharedShape, ColliderError> {
    let authored = read(mesh).map_err(|error| ColliderError::Unreadable(error.detail))?;
    let fold = |(low, high): (Vec3, Vec3), p: &Vec3| (low.min(*p), high.max(*p));
    let (low, high) = authored.positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), fold);
    let (center, half) = (0.5 * (low + high), 0.5 * (high - low));
    let moved = |shape| shape::compound(vec![(Pose::from_translation(center), shape)]);
    let centred = center.length() <= 1.0e-4 * half.length();
    Ok(match fit {
        ClothMeshFit::Ball => {
            let radius = authored.positions.iter().map(|p| p.distance_squared(center)).fold(0.0, f32::max).sqrt();
            let ball = shape::ball(radius)?;
            if centred { ball } else { moved(ball)? }
        }
        ClothMeshFit::Cuboid => {
            let cuboid = shape::cuboid(half)?;
            if centred { cuboid } else { moved(cuboid)? }
        }
        ClothMeshFit::Capsule => {
            let axis = if half.x > half.y && half.x > half.z {
                Vec3::X
            } else if half.z > half.y {
                Vec3::Z
            } else {
                Vec3::Y
            };
            let radius = (half * (Vec3::ONE - axis)).max_element();
            let reach = (half.max_element() - radius).max(0.0);
            shape::capsule_between(center - axis * reach, center + axis * reach, radius)?
        }
        ClothMeshFit::ConvexHull => shape::convex_hull(&authored.positions)?,
        ClothMeshFit::TriMesh => shape::trimesh(authored.positions, authored.triangles)?,
        ClothMeshFit::HalfSpace => shape::half_space(Vec3::Y)?,
    })
}
