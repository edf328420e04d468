//! Colliders for the bones of a skinned body, from its mesh.
//!
//! ```text
//!   group      each vertex belongs to the joint that moves it most; small groups go to the parent
//!   capsule    along the bone or the longest extent of the group, whichever fits better; then refined
//!   hull       of few corners, where a group is too flat for a capsule
//!   outside    how far vertices stick out of the shape; the margin is lifted to cover nine in ten
//! ```
//!
//! All of it happens in the bind pose, in the space of the mesh, in metres. Shapes are given away in the space of their joint,
//! so that they move with it.

use glam::{Affine3A, Vec3};

use super::capsule::Capsule;
use super::group::{Group, groups, usable};
use super::hull::Hull;
use super::outside::Outside;
use super::shape::{BoneShape, Shape};
use super::spread::Spread;

/// The mesh of a body and its skeleton, in the bind pose.
///
/// Meshes that share a skin may be put one after the other: each vertex counts once.
#[derive(Clone, Copy, Debug)]
pub struct SkinnedBody<'a> {
    /// Positions in the space of the mesh, in its units. Those that are not finite, or beyond 1000 km, are left out.
    pub positions: &'a [Vec3],
    /// Up to four joints of each vertex. Those out of range are left out.
    pub joints: &'a [[u16; 4]],
    /// How much each of them moves the vertex (dimensionless). They need not sum to one; only those above 0 count, and a vertex
    /// without any is left out.
    pub weights: &'a [[f32; 4]],
    /// Inverse bind matrix of each joint, from the mesh to the joint. What a singular one moves goes to the parent.
    pub inverse_binds: &'a [Affine3A],
    /// The joint above each joint. None, missing and out of range make a root; so does a cycle.
    pub parents: &'a [Option<usize>],
    /// Metres per unit of the mesh at bind. 1 in most files, 0.01 where the mesh is in centimetres. Must be above 0, or nothing
    /// is fitted.
    ///
    /// It is the scale of a joint's world transform times its inverse bind matrix.
    pub unit: f32,
}

/// How colliders are fitted. Values out of range are taken as the nearest in range, and NaN as the default.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitSettings {
    /// Distance that cloth keeps from a shape `[m]`. Default 0.015, range 0 to 1.
    ///
    /// Measured on three human bodies: two in five vertices stick out of their capsule, one in twenty by 14 to 19 mm. Lower
    /// lets the body show through, higher makes clothes stand off.
    pub margin: f32,
    /// A group whose box has a diagonal below this share of the body's height goes to the parent (dimensionless). Default 0.12,
    /// range 0 to 1.
    ///
    /// Measured on three human bodies: 41 to 66 joints become 18 to 21 groups. At 0 every finger joint gets a collider, at 1
    /// the body gets a single one. Height is the longest side of the box around all vertices.
    pub least_share: f32,
    /// A group of fewer vertices goes to the parent. Default 12, at least 1. Percentiles of fewer say nothing.
    pub least_vertices: usize,
    /// A group whose shortest over middle standard deviation is below this gets a convex hull (dimensionless). Default 0.4,
    /// range 0 to 2.
    ///
    /// Measured: chests of stylised characters have 0.24, hands 0.33 to 0.36, limbs 0.5 and more. 0 makes capsules only, 2
    /// hulls only.
    pub flatness: f32,
    /// Most corners of a hull. Default 32, range 4 to 255. Measured: hulls of all vertices have 130 faces each, for a few
    /// millimetres of gain.
    pub hull_vertices: usize,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self { margin: 0.015, least_share: 0.12, least_vertices: 12, flatness: 0.4, hull_vertices: 32 }
    }
}

impl FitSettings {
    /// The settings, all in range.
    fn checked(&self) -> Self {
        let usual = Self::default();
        let within = |value: f32, usual: f32, most: f32| if value.is_nan() { usual } else { value.clamp(0.0, most) };
        Self {
            margin: within(self.margin, usual.margin, 1.0),
            least_share: within(self.least_share, usual.least_share, 1.0),
            least_vertices: self.least_vertices.max(1),
            flatness: within(self.flatness, usual.flatness, 2.0),
            hull_vertices: self.hull_vertices.clamp(4, 255),
        }
    }
}

/// A collider that moves with a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct BoneCollider {
    /// Index of the joint.
    pub joint: usize,
    /// Shape in the space of the joint. A child at the joint's origin, without scale of its own, has the size of the body.
    ///
    /// The scale of the inverse bind matrix is in all its lengths. Where joints are in centimetres, as in files from FBX with a
    /// scale of 100, so is the radius. A matrix that scales unevenly gives a capsule its mean scale.
    pub shape: BoneShape,
    /// Metres per unit of the joint's space at bind; a length of the shape times this is in metres.
    pub unit: f32,
    /// Distance that cloth keeps from the shape `[m]`: that of the settings, or what 90 % of the vertices stick out, if that is
    /// more.
    pub margin: f32,
    /// Vertices it was fitted to.
    pub vertices: usize,
    /// How far these stick out of the shape.
    pub outside: Outside,
}

/// Colliders for the bones of a body, by index of their joint; one per group of vertices that is large enough.
///
/// Empty where nothing can be fitted: no vertex with a weight, no joint that can be inverted, no unit. Never panics, whatever
/// it is given.
///
/// ```
/// use bevy_drape::character::{BoneShape, FitSettings, SkinnedBody, fit};
/// use glam::{Affine3A, Vec3};
///
/// // A rod of one joint, 0.9 m long.
/// let at = |i: usize| Vec3::new(0.05 * (i as f32).cos(), 0.05 * (i as f32).sin(), 0.01 * i as f32);
/// let positions: Vec<Vec3> = (0..=90).map(at).collect();
/// let body = SkinnedBody {
///     positions: &positions,
///     joints: &vec![[0; 4]; positions.len()],
///     weights: &vec![[1.0, 0.0, 0.0, 0.0]; positions.len()],
///     inverse_binds: &[Affine3A::IDENTITY],
///     parents: &[None],
///     unit: 1.0,
/// };
/// let colliders = fit(&body, &FitSettings::default());
/// assert!(matches!(colliders[0].shape, BoneShape::Capsule { radius, .. } if radius > 0.04 && radius < 0.06));
/// ```
#[must_use]
pub fn fit(body: &SkinnedBody, settings: &FitSettings) -> Vec<BoneCollider> {
    let settings = settings.checked();
    let collider = |group: Group| {
        let shape = shape(&group, &settings);
        let outside = Outside::of(group.points.iter().map(|&p| shape.outside(p)).collect());
        let (shape, unit) = shape.to_joint(body.inverse_binds.get(group.joint)?, body.unit)?;
        let margin = settings.margin.max(outside.p90);
        Some(BoneCollider { joint: group.joint, shape, unit, margin, vertices: group.points.len(), outside })
    };
    groups(body, &settings).into_iter().filter_map(collider).collect()
}

/// How far the vertices of a body stick out of all its colliders together, in the bind pose.
///
/// Colliders of joints that the body lacks do not count. Without any collider it is 0.
#[must_use]
pub fn measure(body: &SkinnedBody, colliders: &[BoneCollider]) -> Outside {
    let shape =
        |collider: &BoneCollider| Shape::from_joint(&collider.shape, body.inverse_binds.get(collider.joint)?, body.unit);
    let shapes: Vec<Shape> = colliders.iter().filter_map(shape).collect();
    if shapes.is_empty() {
        return Outside::default();
    }
    let outside = |point: Vec3| shapes.iter().map(|shape| shape.outside(point)).fold(f32::MAX, f32::min);
    Outside::of(usable(body).map(|(_, point)| outside(point)).collect())
}

/// The shape of a group `[m]`.
fn shape(group: &Group, settings: &FitSettings) -> Shape {
    let spread = Spread::of(&group.points);
    if spread.is_some_and(|spread| spread.flatness() < settings.flatness)
        && let Some(hull) = Hull::around(&group.points, settings.hull_vertices)
    {
        return Shape::Hull(hull);
    }
    let bone = match group.below[..] {
        [only] => (only - group.origin).try_normalize(),
        _ => None,
    };
    let axes = bone.into_iter().chain(spread.map(|spread| spread.axes[0]));
    Shape::Capsule(Capsule::around(&group.points, axes).refined(&group.points).seen_from(group.origin))
}
