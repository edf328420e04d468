//! Colliders from the primitive shapes of Bevy: `ClothCollider::from(Sphere::new(0.5))`.

use bevy::prelude::*;

use super::{ClothCollider, ClothColliderShape};

macro_rules! colliders_from {
    ($($primitive:ident: $shape:expr;)*) => {$(
        impl From<$primitive> for ClothColliderShape {
            fn from(primitive: $primitive) -> Self {
                let shape: fn($primitive) -> Self = $shape;
                shape(primitive)
            }
        }

        impl From<$primitive> for ClothCollider {
            fn from(primitive: $primitive) -> Self {
                Self::new(primitive.into())
            }
        }
    )*};
}

colliders_from! {
    Sphere: |sphere| Self::Ball { radius: sphere.radius };
    Capsule3d: |capsule| Self::Capsule { radius: capsule.radius, length: 2.0 * capsule.half_length };
    Cuboid: |cuboid| Self::Cuboid { size: 2.0 * cuboid.half_size };
    Cylinder: |cylinder| Self::Cylinder { radius: cylinder.radius, height: 2.0 * cylinder.half_height };
    Cone: |cone| Self::Cone { radius: cone.radius, height: cone.height };
    InfinitePlane3d: |plane| Self::HalfSpace { normal: plane.normal.as_vec3() };
    Triangle3d: |triangle| Self::TriMesh { vertices: triangle.vertices.to_vec(), triangles: vec![[0, 1, 2]], solid: false };
    Tetrahedron: |tetrahedron| Self::ConvexHull { points: tetrahedron.vertices.to_vec() };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn primitives_have_the_size_that_their_meshes_have() {
        assert_eq!(ClothCollider::from(Sphere::new(0.5)), ClothCollider::ball(0.5));
        assert_eq!(ClothCollider::from(Capsule3d::new(0.2, 1.5)), ClothCollider::capsule(0.2, 1.5));
        assert_eq!(ClothCollider::from(Cuboid::new(1.0, 2.0, 3.0)), ClothCollider::cuboid(1.0, 2.0, 3.0));
        assert_eq!(ClothCollider::from(Cylinder::new(0.3, 1.2)), ClothCollider::cylinder(0.3, 1.2));
        assert_eq!(ClothCollider::from(Cone::new(0.3, 1.2)), ClothCollider::cone(0.3, 1.2));
        assert_eq!(ClothCollider::from(InfinitePlane3d::new(Vec3::Y)), ClothCollider::ground());
    }
}
